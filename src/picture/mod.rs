//! The lit picture: what the camera sees of a scene, with the light that the shadow maps let pass.
mod air;
mod clusters;
pub mod debug;
mod prepared;

pub use prepared::PreparedPicture;
