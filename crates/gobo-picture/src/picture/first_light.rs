//! Light that the pictures through the samples of a pixel share.
use glam::{UVec2, Vec2};
use gobo::{model::View, records::GpuView};
use wgpu::Texture;

/// How far samples of a pixel are apart at most \[pixels\].
const APART: f32 = 2.0;

/// Pictures through the first samples of the pixels, which are lit whole and whose surfaces are kept.
pub const WHOLE_PICTURES: u32 = 2;

/// Light of a picture through the first sample of its pixels, and of its surfaces through the second, which
/// pictures of the same casters and maps through further samples take over.
#[derive(Clone, Debug)]
pub struct FirstLight {
    /// The view in which casters are listed: around those of all samples.
    pub(super) around: GpuView,
    /// Light of the particles.
    pub(super) particles: Texture,
    /// Light of the lattices of all bricks.
    pub(super) bricks: Texture,
    /// Visible surfaces and their light, if pictures take it over: a layer for each of [`WHOLE_PICTURES`].
    pub(super) surfaces: Option<Texture>,
    /// Offsets in their pixel of the samples whose surfaces are kept \[pixels\].
    pub(super) offsets: Vec<Vec2>,
}

/// The view in which casters are listed: the camera's, or one around it, for pictures with several samples.
pub(super) fn around(camera: &View, samples: u32) -> GpuView {
    let wider = 1.0 + APART / camera.size.min_element() as f32;
    let scale = if samples > 1 { camera.scale / wider } else { camera.scale };
    View { scale, ..camera.clone() }.to_gpu(0, UVec2::ZERO, 0)
}
