//! Cascades: windows of a directional light that follow the camera without shimmering.
//!
//! Each window holds the sphere around the camera's frustum up to its split, so that its size does not depend
//! on the viewing direction, and moves by whole texels (Valient 2007, "Stable Rendering of Cascaded Shadow
//! Maps"). The frusta are nested: where a window fades, the next one holds the point too. Depths enclose the
//! whole scene, so that every caster is in front of its receivers, and don't change while the scene's bounds
//! do not.
use super::{
    Projection, View, ViewRole,
    fit::{light_up, looking},
    window::{BORDER, LightBox, rounded_up, snapped, stepped},
};
use crate::model::{Bounds, Camera, Cascades};
use glam::{Mat4, UVec2, Vec3};

/// Share of the range below which distances to the eye do not influence a split.
const NEAREST: f64 = 1e-3;
/// Steps per octave by which windows along the camera's axis grow.
const STEPS: f64 = 16.0;

/// End of each cascade [m from the eye, along its axis]; the last is `range` (Zhang et al. 2006,
/// "Parallel-Split Shadow Maps", section 3: the practical split).
pub fn splits(cascades: &Cascades, range: f32) -> Vec<f32> {
    let (far, lambda) = (f64::from(range), f64::from(cascades.lambda));
    let near = far * NEAREST;
    let count = cascades.count();
    let split = |i: u32| {
        let share = f64::from(i) / f64::from(count);
        let ratio = near * (far / near).powf(share);
        let even = near + (far - near) * share;
        (lambda * ratio + (1.0 - lambda) * even) as f32
    };
    (1..count).map(split).chain([range]).collect()
}

/// Default shadow range: the width of the scene, doubled until it holds the scene's farthest corner \[m\]. It
/// changes in steps, so that the windows keep their size while the camera moves.
pub(super) fn usual_range(camera: &Camera, bounds: &Bounds) -> f32 {
    let farthest = bounds.corners().iter().fold(0f32, |far, c| far.max(c.distance(camera.eye)));
    let mut range = stepped(2.0 * bounds.radius()).clamp(1e-3, 1e8);
    while range < farthest && range < 1e8 {
        range *= 2.0;
    }
    range
}

/// Bounding sphere of the camera's frustum up to `split` \[m from the eye\]: distance of its centre from the
/// eye, and its radius, both per metre of `split`.
fn frustum_sphere(camera: &Camera) -> (f64, f64) {
    let aspect = f64::from(camera.size.x) / f64::from(camera.size.y);
    let slope = (f64::from(camera.fov_y) * 0.5).tan() * (1.0 + aspect * aspect).sqrt();
    if slope >= 1.0 {
        (1.0, slope)
    } else {
        ((1.0 + slope * slope) * 0.5, (1.0 + slope * slope) * 0.5)
    }
}

/// Properties that all cascades of a light share.
pub(super) struct Fit<'a> {
    pub light: usize,
    /// Name of each cascade.
    pub names: &'a [&'static str],
    /// Direction in which light travels (unit, world space).
    pub direction: Vec3,
    pub near: Option<f32>,
    pub far: Option<f32>,
    pub camera: &'a Camera,
    /// Box around all casters and receivers.
    pub bounds: &'a Bounds,
}

impl Fit<'_> {
    /// `size_of`: edge of each cascade's map \[texels\].
    pub(super) fn views(&self, cascades: &Cascades, size_of: &dyn Fn(usize) -> u32) -> Vec<View> {
        // From the split at which a window would be as large as the scene, the last one holds the whole
        // scene.
        let (_, radius) = frustum_sphere(self.camera);
        let covering = self.extent().stepped_edge() / (2.0 * radius);
        let range = cascades.range.unwrap_or_else(|| usual_range(self.camera, self.bounds));
        let range = range.min(covering as f32);
        let splits = splits(cascades, range);
        let count = splits.len();
        let cascade = |(index, split): (usize, &f32)| {
            let last = index + 1 == count;
            self.view(cascades, index, f64::from(*split), last, size_of(index))
        };
        splits.iter().enumerate().map(cascade).collect()
    }

    /// World space to a space that looks along the light's direction.
    fn axes(&self) -> Mat4 {
        looking(Vec3::ZERO, self.direction, light_up(self.direction))
    }

    fn extent(&self) -> LightBox {
        LightBox::new(&self.axes(), self.bounds)
    }

    fn view(&self, cascades: &Cascades, index: usize, split: f64, last: bool, size: u32) -> View {
        let axes = self.axes();
        let extent = self.extent();
        let (ahead, radius) = frustum_sphere(self.camera);
        let (forward, eye) = (self.camera.target - self.camera.eye, self.camera.eye);
        let center = eye.as_dvec3() + forward.as_dvec3().normalize() * (ahead * split);
        // The border of the last window lies outside the camera's frustum.
        let inner = if last { 1.0 - f64::from(cascades.fade) } else { 1.0 };
        let whole = f64::from(size);
        let texel = 2.0 * radius * split / (whole * inner - 2.0 * BORDER).max(1.0);
        let (of_scene, middle_of_scene) = extent.window(size);
        let (texel, middle, fade) = if texel < of_scene {
            let texel = rounded_up(texel, STEPS);
            let in_light = axes.as_dmat4().transform_point3(center);
            (texel, snapped(in_light.truncate(), texel), cascades.fade)
        } else {
            // No window need be larger than the scene.
            (of_scene, middle_of_scene, 0.0)
        };
        let near = self.near.unwrap_or(0.0);
        let front = extent.front(self.near.or(self.far).is_some());
        let shift = -middle.as_vec2().extend(front);
        View {
            light: Some(self.light),
            name: self.names[index],
            role: ViewRole::Window { index: index as u32, count: cascades.count(), fade },
            projection: Projection::Orthographic,
            size: UVec2::splat(size),
            near,
            far: self.far.unwrap_or_else(|| extent.far(front, extent.min.z, near)),
            view_from_world: Mat4::from_translation(shift) * axes,
            scale: (1.0 / texel) as f32,
        }
    }
}
