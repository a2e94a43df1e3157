//! Scenes made of arrays.
use super::{Gobo, failure};
use gobo::{
    Light, Material, Particle, Scene, Shape, Transfer, Triangle,
    glam::{Vec3, Vec4},
};
use gobo_scene::LoadOptions;
use std::path::Path;
use wasm_bindgen::prelude::*;

fn check(is_so: bool, what: &str, help: &str) -> Result<(), JsError> {
    if is_so { Ok(()) } else { Err(failure(&what, Some(help))) }
}

fn vectors(values: &[f32]) -> impl Iterator<Item = Vec3> {
    values.as_chunks().0.iter().map(|&[x, y, z]| Vec3::new(x, y, z))
}

#[wasm_bindgen]
impl Gobo {
    /// Begins a scene with a sun alone; `direction`: in which its light travels.
    pub fn empty(&mut self, direction: &[f32]) -> Result<(), JsError> {
        let help = "three numbers, not all 0";
        check(direction.len() == 3, "direction has not three numbers", help)?;
        let light = Light { intensity: 3.0, ..Light::directional(Vec3::from_slice(direction)) };
        light.check(0).map_err(|error| failure(&error, Some(help)))?;
        let mut scene = gobo_scene::empty_scene();
        scene.lights.push(light);
        (self.show, self.scene) = (None, Some(scene));
        Ok(())
    }

    fn unfinished(&mut self) -> Result<&mut Scene, JsError> {
        let help = "call empty first, then add, then maps or a canvas's make";
        let none = || failure(&"there is no scene to add to", Some(help));
        self.scene.as_mut().ok_or_else(none)
    }

    /// Adds puffs of smoke: centres (x, y, z) and radii \[m\], colours (linear r, g, b) and opacities, 0
    /// to 1. Invalid ones are left out; returns their number.
    pub fn add_particles(
        &mut self,
        centers: &[f32],
        radii: &[f32],
        colors: &[f32],
    ) -> Result<u32, JsError> {
        let count = radii.len();
        let help = "for each radius three numbers of a centre and four of a colour";
        let is_so = centers.len() == 3 * count && colors.len() == 4 * count;
        check(is_so, "the arrays do not fit each other", help)?;
        let scene = self.unfinished()?;
        let material = scene.materials.len() as u32;
        scene.materials.push(Material { shape: Shape::Puff, ..Material::default() });
        let first = scene.particles.len() as u32;
        let parts = vectors(centers).zip(radii).zip(colors.as_chunks::<4>().0);
        let particles = (first..).zip(parts).map(|(id, ((center, &radius), &color))| Particle {
            center,
            radius,
            color: Vec4::from_array(color),
            material,
            id,
            ..Particle::default()
        });
        let before = scene.particles.len();
        scene.particles.extend(particles.filter(|particle| particle.problem(1.0).is_none()));
        Ok((count - (scene.particles.len() - before)) as u32)
    }

    /// Adds triangles, three corners (x, y, z) each \[m\], of a colour (linear r, g, b) and opacity, 0 to 1;
    /// `solid` ones hide their background, others filter it. Invalid ones are left out; returns their number.
    pub fn add_triangles(
        &mut self,
        positions: &[f32],
        color: &[f32],
        solid: bool,
    ) -> Result<u32, JsError> {
        check(
            positions.len().is_multiple_of(9),
            "a triangle is not whole",
            "nine numbers for each",
        )?;
        let is_color = color.len() == 4 && color.iter().all(|part| (0.0..=1.0).contains(part));
        check(is_color, "color is none", "four numbers of 0 to 1")?;
        let scene = self.unfinished()?;
        let material = scene.materials.len() as u32;
        scene.materials.push(Material {
            tint: Vec4::from_slice(color),
            transfer: if solid { Transfer::Opaque } else { Transfer::Filter },
            ..Material::default()
        });
        let (mut left_out, corners) = (0, vectors(positions).collect::<Vec<_>>());
        for &corners in corners.as_chunks::<3>().0 {
            if corners.iter().all(|corner| corner.is_finite() && corner.abs().max_element() <= 1e7)
            {
                scene.triangles.push(Triangle::flat(corners, material));
            } else {
                left_out += 1;
            }
        }
        Ok(left_out)
    }

    /// Makes the text of a scene file (TOML) the scene.
    pub fn open_text(&mut self, text: &str) -> Result<(), JsError> {
        let options = LoadOptions::default();
        let scene = gobo_scene::load_text(text, Path::new("scene.toml"), &options);
        let scene = scene.map_err(|error| super::of_scene(&error))?;
        self.set_scene(scene)
    }
}
