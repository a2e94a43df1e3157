//! CPU reference of `wgsl/caustics/bounce_light.wgsl`: points of a light's maps that send its light on, one
//! diffuse bounce off opaque triangles (Dachsbacher and Stamminger 2005).
//!
//! A point stands for its part of the map: it sends the light that arrives there times the albedo of the
//! triangle, as a disc of that area does at its middle: at distance d, `1 / (d^2 + r^2)` in place of
//! `1 / d^2`, exact on the disc's axis. Nothing between the point and the receiver blocks the light.
use crate::{
    caustics::NEAR_SURFACE,
    glass_face::{RayFace, nearest_faces},
    light_views::LightViews,
    shading::incoming::incoming,
};
use glam::{UVec2, Vec2, Vec3};
use gobo::{
    model::{Light, Scene, View},
    records::{BOUNCE_SAMPLES, GlassFace, GpuLight, NO_FACE, ViewMaps, albedo_of, solid_faces},
};
use std::f32::consts::FRAC_1_PI;

/// Least cosine of the light's angle by which a point's disc is larger than its part of the map.
pub const LEAST_FACING: f32 = 0.05;
/// Samples of a point are on one surface if the cosine of their normals is more than this.
pub const SAME_NORMAL: f32 = 0.8;
/// And if the distance to the other's plane is less than this \[edges of its part of the map\].
pub const SAME_PLANE: f32 = 0.5;

/// A point that sends light on, world space.
#[derive(Clone, Copy, Debug)]
pub struct Bounce {
    /// Its position \[m\].
    pub position: Vec3,
    /// Squared radius of its disc \[m^2\].
    pub square: f32,
    /// Its unit normal, on the light's side.
    pub normal: Vec3,
    /// Its light over pi.
    pub sent: Vec3,
}

/// The points of all lights; `maps` of `views`.
pub(crate) fn bounces(
    scene: &Scene,
    lights: &[Light],
    views: &[View],
    maps: &[&ViewMaps],
) -> Vec<Bounce> {
    let of = |view: &View| {
        let light = lights.get(view.light?)?;
        (light.bounce > 0 && view.sends_light_on(light)).then_some(light)
    };
    if !views.iter().any(|view| of(view).is_some()) {
        return Vec::new();
    }
    let faces = solid_faces(&scene.casters());
    let sending = views.iter().zip(maps).filter_map(|(view, maps)| Some((of(view)?, view, maps)));
    sending
        .flat_map(|(light, view, maps)| {
            let record = GpuLight::new(light, 0..0, &scene.shadow);
            of_view(&record, light.bounce, view, maps, &faces)
        })
        .collect()
}

/// A sample of a map on an opaque triangle; in the space of the rays.
struct Sent {
    point: Vec3,
    /// Depth \[m\].
    along: f32,
    normal: Vec3,
    /// Area across the light's ray \[m^2\].
    area: f32,
    /// Cosine of the light's angle.
    facing: f32,
    /// Light that it sends, over pi.
    light: Vec3,
}

/// The points of a view, `edge` along each edge of its map.
fn of_view(
    light: &GpuLight,
    edge: u32,
    view: &View,
    maps: &ViewMaps,
    faces: &[GlassFace],
) -> Vec<Bounce> {
    let whole = view.to_gpu(0, UVec2::ZERO, 0);
    let both = [whole.with_edge(BOUNCE_SAMPLES * edge), whole];
    let views = LightViews { views: &both };
    let found: Vec<_> = faces.iter().map(|face| RayFace::new(&views, face)).collect();
    let [nearest, _] = nearest_faces(&views, 0, &found, None);
    let sample = |texel: UVec2| {
        let index = nearest.faces[(texel.y * edge * BOUNCE_SAMPLES + texel.x) as usize];
        let face = found.get(index as usize).filter(|_| index != NO_FACE)?;
        let (start, step) = views.ray(0, texel.as_vec2() + 0.5);
        let (along, weights) = face.meets(start, step)?;
        let point = start + step * along;
        let seen = views.seen_in(1, point);
        let texel = seen.place.clamp(Vec2::ZERO, whole.size - 1.0).as_uvec2();
        let at = (texel.y * view.size.x + texel.x) as usize;
        let depth = whole.near + maps.opaque[at] * (whole.far - whole.near);
        let distance = if whole.perspective > 0.0 { -seen.point.z } else { 1.0 };
        // A face that something else hides in the map sends no light on.
        if (-seen.point.z - depth).abs() > NEAR_SURFACE * distance / whole.scale {
            return None;
        }
        let way = step.normalize();
        let normal = face.normal_at(weights, way);
        let area = (distance / both[0].scale).powi(2) / step.length();
        let (_, color) = incoming(light, views.in_world(point));
        let arriving = color * Vec3::from_array(maps.filter[at]);
        Some(Sent {
            point,
            along: -seen.point.z,
            normal,
            area,
            facing: (-normal.dot(way)).max(LEAST_FACING),
            light: arriving * albedo_of(&faces[index as usize]) * (area * FRAC_1_PI),
        })
    };
    let point = |i: u32| {
        let first = UVec2::new(i % edge, i / edge) * BOUNCE_SAMPLES;
        let samples = (0..BOUNCE_SAMPLES * BOUNCE_SAMPLES)
            .map(|k| first + UVec2::new(k % BOUNCE_SAMPLES, k / BOUNCE_SAMPLES));
        let all: Vec<Sent> = samples.filter_map(&sample).collect();
        // All samples send light, from the middle of those on the surface nearest to the light.
        let nearest = all.iter().reduce(|a, b| if b.along < a.along { b } else { a });
        let is_near = |sent: &&Sent| {
            nearest.is_some_and(|nearest| {
                let apart = SAME_PLANE * BOUNCE_SAMPLES as f32 * nearest.area.sqrt();
                let off = nearest.normal.dot(sent.point - nearest.point).abs();
                off <= apart && sent.normal.dot(nearest.normal) >= SAME_NORMAL
            })
        };
        let near: Vec<&Sent> = all.iter().filter(is_near).collect();
        let middle = near.iter().map(|sent| sent.point).sum::<Vec3>() / near.len().max(1) as f32;
        let normal = near.iter().map(|sent| sent.normal).sum::<Vec3>();
        let square = all.iter().map(|sent| sent.area * FRAC_1_PI / sent.facing).sum::<f32>();
        Bounce {
            position: views.in_world(middle),
            square: square.max(1e-12),
            normal: views.turned_back(normal).normalize_or_zero(),
            sent: all.iter().map(|sent| sent.light).sum(),
        }
    };
    (0..edge * edge).map(point).collect()
}

/// Light that a point scatters to the eye, per albedo. `scatters`: its share of the light from a direction
/// whose cosine with the normal is given.
pub(crate) fn bounced(
    bounces: &[Bounce],
    position: Vec3,
    normal: Vec3,
    scatters: impl Fn(f32) -> f32,
) -> Vec3 {
    let of = |from: &Bounce| {
        let away = from.position - position;
        let square = away.length_squared();
        let toward = away / square.max(1e-12).sqrt();
        let passed = (-from.normal.dot(toward)).max(0.0) / (square + from.square);
        from.sent * (passed * scatters(normal.dot(toward)))
    };
    bounces.iter().map(of).sum()
}
