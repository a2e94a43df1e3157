//! Inputs of a picture.
use crate::{
    model::{Scene, View},
    picture::band_memory::BandMemory,
    records::FormerSlots,
    shadows::{CasterSet, Maps, masks::MaskTextures},
};
use std::sync::Arc;

/// Inputs of a picture.
#[derive(Clone, Copy, Debug)]
pub struct PictureRequest<'a> {
    pub device: &'a wgpu::Device,
    pub queue: &'a wgpu::Queue,
    pub casters: &'a CasterSet,
    pub scene: &'a Scene,
    /// The scene's camera, through a sample position of its pixels.
    pub camera: &'a View,
    /// Shadow views of the scene's lights.
    pub views: &'a [View],
    /// Maps of `views`.
    pub maps: &'a Maps,
    pub capacity: PictureCapacity,
}

/// State that a picture takes over from the previous one.
#[derive(Debug, Default)]
pub struct Kept {
    /// Mask slots of the lights.
    pub slots: FormerSlots,
    pub(super) masks: Option<Arc<MaskTextures>>,
    pub(super) band: Option<Arc<BandMemory>>,
}

/// Capacities that a picture is prepared with. The default suffices for most; [`PreparedPicture::needs`]
/// returns what a recorded picture needed.
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
