//! Mean of a picture's samples.
use crate::shading::{shown, to_srgb};
use glam::{UVec2, Vec3};
use gobo::{
    model::{Scene, Tone},
    records::Picture,
};

/// Mean of pictures at several samples per pixel: of linear light, and of the screen's values after the tone
/// curve. A mean of light alone would be as bright as its brightest sample wherever the curve saturates, and
/// edges would be jagged.
#[derive(Clone, Debug)]
pub struct MeanPicture {
    size: UVec2,
    /// Factor of light on the screen.
    exposure: f32,
    tone: Tone,
    count: u32,
    /// Sums over the samples, row by row.
    light: Vec<Vec3>,
    shown: Vec<Vec3>,
}

impl MeanPicture {
    /// A picture of `scene` without samples.
    pub fn new(scene: &Scene) -> Self {
        let size = scene.camera.size;
        let none = vec![Vec3::ZERO; size.element_product() as usize];
        Self {
            size,
            exposure: scene.exposure.exp2(),
            tone: scene.tone,
            count: 0,
            light: none.clone(),
            shown: none,
        }
    }

    /// Adds a sample of each pixel: linear light, row by row.
    pub fn add(&mut self, sample: impl IntoIterator<Item = Vec3>) {
        self.count += 1;
        for ((sum, on_screen), light) in self.light.iter_mut().zip(&mut self.shown).zip(sample) {
            *sum += light;
            *on_screen += shown(light * self.exposure, self.tone);
        }
    }

    /// The mean of the samples.
    pub fn picture(self) -> Picture {
        let share = 1.0 / self.count.max(1) as f32;
        Picture {
            size: self.size,
            rgb: self.shown.into_iter().map(|sum| to_srgb(sum * share)).collect(),
            light: self.light.into_iter().map(|sum| (sum * share).to_array()).collect(),
        }
    }
}
