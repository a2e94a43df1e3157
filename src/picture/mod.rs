//! The lit picture: what the camera sees of a scene, with the light that the shadow maps let pass.
mod air;
mod bands;
mod clusters;
pub mod debug;
mod lists;
mod prepared;
mod shading;

pub use prepared::{Kept, PictureRoom, PreparedPicture};
