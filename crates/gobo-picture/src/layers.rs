//! Layers that a compositor needs beside a picture's light.
use super::{Renderer, check, without_emissions};
use glam::Vec3;
use gobo::{
    Error,
    model::{MAX_SAMPLES, ReceiverPoint, Scene},
};
use gobo_reference as reference;

pub use gobo_reference::Surface;

/// Data of the opaque surfaces that a picture shows, row by row.
#[derive(Clone, Debug, Default)]
pub struct SurfaceLayers {
    /// Mean of the samples' albedos, with 0 where there is no surface: linear rgb.
    pub albedo: Vec<[f32; 3]>,
    /// For each light, the mean of its shares that reach the surfaces of the samples: linear rgb, 1 where
    /// nothing is in between, or without a surface.
    pub shadows: Vec<Vec<[f32; 3]>>,
    /// Surfaces of the first sample.
    pub first: Vec<Option<Surface>>,
}

impl Renderer {
    /// Data of the opaque surfaces that the picture of a scene shows, by the CPU reference, and the light
    /// that reaches them through the picture's maps. `next`: the scene at the next frame, for
    /// [`Surface::motion`].
    ///
    /// # Errors
    /// Those of [`Self::render`], and for emitters that are left to a device.
    pub fn surface_layers(
        &mut self,
        scene: &Scene,
        next: Option<&Scene>,
    ) -> Result<SurfaceLayers, Error> {
        check(scene)?;
        without_emissions(scene)?;
        let pixels = scene.camera.size.element_product() as usize;
        let mut albedo = vec![Vec3::ZERO; pixels];
        let mut shadows = vec![vec![Vec3::ZERO; pixels]; scene.lights.len()];
        let mut counts = vec![0.0; pixels];
        let mut first = Vec::new();
        let samples = scene.samples.clamp(1, MAX_SAMPLES);
        let mut look_up = self.picture_look_up(scene)?;
        for sample in 0..samples {
            let seen = reference::surfaces(scene, sample, next.filter(|_| sample == 0));
            let found: Vec<_> = (0..).zip(&seen).filter_map(|(at, s)| Some((at, (*s)?))).collect();
            let points = found.iter().map(|&(_, surface)| ReceiverPoint {
                position: surface.position,
                normal: surface.normal,
            });
            let shares = look_up.own_shares(&points.collect::<Vec<_>>())?;
            for (i, &(at, surface)) in found.iter().enumerate() {
                let at: usize = at;
                counts[at] += 1.0;
                albedo[at] += surface.albedo / samples as f32;
                for (light, shadow) in shadows.iter_mut().enumerate() {
                    shadow[at] += Vec3::from_array(shares[i * scene.lights.len() + light]);
                }
            }
            if sample == 0 {
                first = seen;
            }
        }
        let mean = |(sum, &count): (Vec3, &f32)| {
            if count > 0.0 { (sum / count).to_array() } else { [1.0; 3] }
        };
        Ok(SurfaceLayers {
            albedo: albedo.into_iter().map(Into::into).collect(),
            shadows: shadows
                .into_iter()
                .map(|sums| sums.into_iter().zip(&counts).map(mean).collect())
                .collect(),
            first,
        })
    }
}
