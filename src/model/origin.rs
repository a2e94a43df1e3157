//! Scenes far from the origin: kept relative to a place of their own, so that positions have their digits
//! where the scene is.
use super::{Bounds, LightKind, Scene};
use glam::Vec3;

/// Share of a particle's radius, or of the scene's, that a shadow may be off by: 1/256 of the radius
/// is 0.6% of a soft disc's opacity.
const SEEN: f32 = 1.0 / 256.0;
/// Sizes of the scene: an axis along which it lies farther off is moved.
const FAR: f32 = 8.0;

impl Scene {
    /// Moves the scene near the origin where its place costs digits that count, and keeps in
    /// [`Self::origin`] how far. Exact: by a multiple of a power of two as large as the scene. What has
    /// its digits stays as it is.
    pub fn recentre(&mut self) {
        let bounds = self.bounds();
        let Some((rounding, size)) = self.rounding(&bounds) else { return };
        // Transforms round several times.
        if rounding <= size * SEEN / 16.0 {
            return;
        }
        let grid = bounds.radius().max(1e-3).log2().ceil().exp2();
        let middle = bounds.center();
        let whole = (middle / grid).round() * grid;
        let by = Vec3::select(middle.abs().cmpgt(Vec3::splat(FAR * grid)), whole, Vec3::ZERO);
        if by == Vec3::ZERO {
            return;
        }
        self.camera.eye -= by;
        self.camera.target -= by;
        for particle in &mut self.particles {
            particle.center -= by;
        }
        for corner in self.triangles.iter_mut().flat_map(|triangle| &mut triangle.positions) {
            *corner -= by;
        }
        for light in &mut self.lights {
            move_light(&mut light.kind, by);
            light.shadows.iter_mut().for_each(|shadow| move_light(&mut shadow.kind, by));
        }
        for motion in &mut self.motions {
            if let Some(moved) = motion.moved(-by) {
                *motion = moved;
            }
        }
        self.origin += by;
    }

    /// Rounding of positions, and the size that it is held against [m]; `None` of an empty scene.
    fn rounding(&self, bounds: &Bounds) -> Option<(f32, f32)> {
        if bounds.is_empty() {
            return None;
        }
        let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
        let mut radii: Vec<f32> = self.particles.iter().map(|particle| particle.radius).collect();
        radii.sort_unstable_by(f32::total_cmp);
        // A scene of triangles is held against a map's texel.
        let size = radii.get(radii.len() / 2).copied();
        let size = size.unwrap_or_else(|| bounds.radius() / self.shadow.size as f32);
        Some((farthest * f32::EPSILON, size))
    }

    /// What a scene loses by its size or its place, in words; `None` where nothing is seen of it.
    /// Positions have 24 bits: 10 km from [`Self::origin`] they are rounded to a millimetre, which moves
    /// the shadows of small particles.
    pub fn rounding_warning(&self) -> Option<String> {
        let bounds = self.bounds();
        let (rounding, size) = self.rounding(&bounds)?;
        (rounding > size * SEEN).then(|| {
            let millimetres = rounding * 1000.0;
            let farthest = rounding / f32::EPSILON;
            format!(
                "the scene reaches {farthest:.0} m from the origin, where positions are rounded to \
                 {millimetres:.2} mm: shadows are off by up to that much; move the scene, its camera \
                 and its lights towards the origin"
            )
        })
    }
}

fn move_light(kind: &mut LightKind, by: Vec3) {
    if let LightKind::Spot { position, .. } | LightKind::Point { position } = kind {
        *position -= by;
    }
}
