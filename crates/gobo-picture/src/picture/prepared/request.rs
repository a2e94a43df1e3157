//! Inputs of a picture.
use crate::picture::{FirstLight, band_memory::BandMemory};
use glam::{Vec2, Vec3};
use gobo::{
    model::{Environment, Scene, View},
    records::{FormerSlots, ImageDetail, LightRecords},
    shadows::{Prepared, masks::MaskTextures},
    stage::light_points::PictureParams,
};
use gobo_reference::records::{ClusterGrid, OcclusionRadius};
use std::sync::Arc;
use wgpu::Texture;

/// Inputs of a picture.
#[derive(Clone, Copy, Debug)]
pub struct PictureRequest<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The scene's camera, through a sample position of its pixels.
    pub camera: &'a View,
    /// Maps of the scene's casters and lights, of the last frame.
    pub prepared: &'a Prepared,
    /// Capacities of the picture.
    pub capacity: PictureCapacity,
}

impl PictureRequest<'_> {
    pub(super) fn light_records(&self) -> LightRecords {
        let Self { scene, prepared, .. } = self;
        let lights = scene.lights.iter().enumerate();
        LightRecords::new(lights, prepared.views(), prepared.gpu_views(), &scene.shadow)
    }

    /// `first_setup`: footprint with the translucent setup 0, modulo 2^32; `from_first`: offsets of the
    /// sample and of the last one that is lit whole from the first \[pixels\].
    pub(super) fn params(
        &self,
        records: &LightRecords,
        grid: &ClusterGrid,
        first_setup: u32,
        [from_first, second_from_first]: [Vec2; 2],
    ) -> PictureParams {
        let Self { scene, camera, prepared, .. } = self;
        let detail = ImageDetail::new(scene.samples, camera.sample_offset());
        let radius = OcclusionRadius::new(scene.occlusion, scene.camera.fov_y);
        PictureParams {
            world_from_view: camera.view_from_world.inverse(),
            ambient: scene.mean_ambient(),
            light_count: scene.lights.len() as u32,
            background: scene.background,
            first_setup,
            near: grid.near,
            depth_range: grid.depth_range,
            cells: grid.cells,
            tile: grid.tile,
            first_slice: grid.first_slice,
            slices_per_doubling: grid.slices_per_doubling,
            colored: u32::from(prepared.maps().colored.is_some()),
            air_slices: scene.air.map_or(0, |air| air.steps),
            exposure: scene.exposure.exp2(),
            tone: scene.tone as u32,
            bloom: scene.bloom,
            occlusion_radius: radius.map_or(0.0, |radius| radius.metres),
            occlusion_radius_per_distance: radius.map_or(0.0, |radius| radius.per_distance),
            first_area: records.first_area(),
            extinction: scene.air.map_or(Vec3::ZERO, |air| air.extinction),
            environment_size: scene.environment.as_ref().map_or(0, |sky| sky.size()),
            image_reach: detail.reach,
            cutout_threshold: detail.threshold,
            from_first,
            second_from_first,
            pad_0: 0,
            pad_1: 0,
            irradiance: scene.irradiance().map(|c| c.extend(0.0)),
        }
    }
}

/// State that a picture takes over from the previous one.
#[derive(Debug, Default)]
pub struct Kept {
    /// Mask slots of the lights.
    pub slots: FormerSlots,
    pub(in crate::picture) masks: Option<Arc<MaskTextures>>,
    pub(super) band: Option<Arc<BandMemory>>,
    /// Whether pictures through further samples of the pixels will take over the light of its surfaces.
    pub is_first: bool,
    /// Light of a picture through the first sample of the pixels, for pictures through further ones.
    pub first_light: Option<FirstLight>,
    /// Environment of the last picture that had one, and its texels on the device.
    pub(in crate::picture) environment: Option<(Arc<Environment>, Texture)>,
}

/// Capacities that a picture is prepared with. The default suffices for most;
/// [`PreparedPicture::needs`](super::PreparedPicture::needs) returns what a recorded picture needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureCapacity {
    /// Pair capacity, within the budget.
    pub(super) pairs: Option<u32>,
    /// Parts of the picture that are binned one after another, if not all pairs fit.
    pub(super) parts: u32,
    /// Rounds in which the pairs of the longest tile are walked.
    pub(super) rounds: u32,
}

impl Default for PictureCapacity {
    fn default() -> Self {
        Self { pairs: None, parts: 1, rounds: 1 }
    }
}

impl PictureCapacity {
    /// Whether the pairs do not fit at once.
    pub fn is_in_parts(&self) -> bool {
        self.parts > 1
    }
}
