//! The lit picture: a scene as the camera sees it, with the light that the shadow maps transmit.
mod air;
mod band_memory;
mod bands;
mod clusters;
pub mod debug;
mod environment;
mod finish;
mod first_light;
mod lighting;
mod lists;
mod prepared;
mod shading;

pub use first_light::{FirstLight, WHOLE_PICTURES};
pub use prepared::{Kept, PictureCapacity, PictureRequest, PreparedPicture};
