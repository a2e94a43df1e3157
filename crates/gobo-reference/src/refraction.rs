//! CPU reference of `crates/gobo-picture/wgsl/shade/bend.wgsl` and `wgsl/refraction/*.wgsl`: the background
//! behind glass is displaced, by refraction where the eye's ray enters a body, and blurred, by the roughness
//! of panes.
use super::{bloom::Level, shading::world_point};
use crate::records::refraction_levels;
use glam::{IVec2, Mat4, UVec2, Vec2, Vec3};
use gobo::{
    model::Material,
    records::{GpuView, image_level_size},
};

/// Least light depth by which a surface must be in front of a pane to hide the background of the pane: depths
/// are half floats.
pub const PANE_SLACK: f32 = 0.001;

/// Cosine between a ray and a face's normal at which the ray hardly meets the face.
pub const MIN_LEAVING: f32 = -0.05;

/// Effect of a face on the path of the eye's ray.
#[derive(Clone, Copy, Debug)]
pub struct GlassFace {
    /// Radius of the blur \[pixels\].
    pub blur: f32,
    /// Unit direction behind the face, if it belongs to a body; world space.
    pub bent: Option<Vec3>,
    /// Normal on the eye's side, and its cosine to the straight ray.
    pub normal: Vec3,
    /// Cosine of the angle between `normal` and the straight ray.
    pub cosine: f32,
    /// Whether the ray leaves a body through it.
    pub leaves: bool,
}

impl GlassFace {
    /// A face at light depth `depth` in front of the surface at `behind`; `normal`: on the eye's side.
    pub fn new(
        view: &GpuView,
        material: &Material,
        depth: f32,
        behind: f32,
        leaves: bool,
        [normal, to_eye]: [Vec3; 2],
    ) -> Self {
        let range = view.far - view.near;
        let share = (behind - depth) * range / (view.near + behind * range);
        let refracted =
            (material.ior > 1.0).then(|| refracted(-to_eye, normal, 1.0 / material.ior));
        Self {
            blur: material.frost * share * view.scale,
            bent: refracted,
            normal,
            cosine: -normal.dot(to_eye),
            leaves,
        }
    }
}

/// Direction behind a face by Snell's law.
fn refracted(ray: Vec3, normal: Vec3, ratio: f32) -> Vec3 {
    let cosine = normal.dot(ray);
    let rest = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    ray * ratio - normal * (ratio * cosine + rest.max(0.0).sqrt())
}

/// A body on the eye's ray.
#[derive(Clone, Copy, Debug)]
struct BodyOnRay {
    entered: f32,
    bent: Vec3,
    left: f32,
    /// Path length inside, relative to that of the straight ray.
    share: f32,
}

/// The eye's ray through the panes of a pixel.
#[derive(Clone, Debug, Default)]
pub struct Ray {
    bodies: Vec<BodyOnRay>,
    /// Light depth and direction behind the face by which it entered the present body.
    entered: Option<(f32, Vec3)>,
    blur_square: f32,
}

impl Ray {
    /// Takes the ray through the next face, at light depth `depth`.
    pub fn cross(&mut self, face: &GlassFace, depth: f32) {
        self.blur_square += face.blur * face.blur;
        let Some(bent) = face.bent else { return };
        match self.entered {
            Some((entered, bent)) if face.leaves => {
                // Up to the plane of the face.
                let share = face.cosine / face.normal.dot(bent).min(MIN_LEAVING);
                self.bodies.push(BodyOnRay {
                    entered,
                    bent,
                    left: depth,
                    share: share.clamp(0.5, 1.5),
                });
                self.entered = None;
            }
            None if !face.leaves => self.entered = Some((depth, bent)),
            _ => {}
        }
    }

    /// Displacement and blur of the background at light depth `behind`; `None` for a straight, sharp view.
    pub fn bend(
        mut self,
        view: &GpuView,
        world_from_view: &Mat4,
        pixel: Vec2,
        behind: f32,
    ) -> Option<(Vec2, f32)> {
        if let Some((entered, bent)) = self.entered.filter(|_| behind < 1.0) {
            self.bodies.push(BodyOnRay { entered, bent, left: behind, share: 1.0 });
        }
        let slope = (pixel - view.size * 0.5) / view.scale;
        let metres = (view.far - view.near) * (1.0 + slope.length_squared()).sqrt();
        let aside = |body: &BodyOnRay| {
            let start = world_point(view, world_from_view, pixel, body.entered);
            let position = start + body.bent * (body.share * (body.left - body.entered) * metres);
            let seen = view.view_from_world.transform_point3(position);
            let scale = view.scale / (-seen.z).max(view.near);
            Vec2::new(seen.x, -seen.y) * scale + view.size * 0.5 - pixel
        };
        let aside: Vec2 = self.bodies.iter().map(aside).sum();
        let blur = self.blur_square.sqrt();
        (aside != Vec2::ZERO || blur != 0.0).then_some((aside, blur))
    }
}

/// Displaced and blurred background of a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Bend {
    /// Offset from the pixel \[pixels\].
    pub aside: Vec2,
    /// Radius of the blur \[pixels\].
    pub blur: f32,
    /// Light depth of the nearest pane.
    pub pane: f32,
    /// Share of the background's light that reaches the eye.
    pub passed: Vec3,
}

/// A picture's light with displaced and blurred backgrounds: `light` without them, `behind` the opaque
/// surfaces and their light depths.
pub fn refracted_picture(
    size: UVec2,
    light: &[Vec3],
    behind: &[(Vec3, f32)],
    bends: &[Option<Bend>],
) -> Vec<Vec3> {
    let seen = behind.iter().map(|&(light, _)| light).collect();
    let mut levels = vec![Level::new(size, seen)];
    for level in 1..refraction_levels(size) {
        let next = levels[levels.len() - 1].halved(image_level_size(size, level));
        levels.push(next);
    }
    let shown = |i: usize| {
        let Some(bend) = bends[i] else { return light[i] };
        let pixel = UVec2::new(i as u32 % size.x, i as u32 / size.x).as_vec2() + 0.5;
        let found = (pixel + bend.aside).clamp(Vec2::splat(0.5), size.as_vec2() - 0.5);
        let texel = found.as_uvec2();
        let (_, depth) = behind[(texel.y * size.x + texel.x) as usize];
        let position = if depth < bend.pane - PANE_SLACK { pixel } else { found };
        light[i] + bend.passed * blurred(&levels, position, bend.blur)
    };
    (0..light.len()).map(shown).collect()
}

/// Light around a position \[pixels\], blurred over a radius \[pixels\].
fn blurred(levels: &[Level], position: Vec2, blur: f32) -> Vec3 {
    let level = (blur.max(0.5) * 2.0).log2().clamp(0.0, (levels.len() - 1) as f32);
    let (low, part) = (level as usize, level.fract());
    let smooth = |level: usize| {
        let at = position * (-(level as f32)).exp2();
        let middle = at.floor();
        let off = at - middle - 0.5;
        let weight = |step: i32, off: f32| match step {
            -1 => 0.5 * (0.5 - off) * (0.5 - off),
            0 => 0.75 - off * off,
            _ => 0.5 * (0.5 + off) * (0.5 + off),
        };
        let steps = (0..9).map(|i| IVec2::new(i % 3, i / 3) - 1);
        let tap = |step: IVec2| {
            let share = weight(step.x, off.x) * weight(step.y, off.y);
            levels[level].at(middle.as_ivec2() + step) * share
        };
        steps.map(tap).sum::<Vec3>()
    };
    if part > 0.0 { smooth(low).lerp(smooth(low + 1), part) } else { smooth(low) }
}
