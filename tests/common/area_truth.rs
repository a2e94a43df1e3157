//! Reference light of area lights, in 64 bits, straight from the scene: a ray from each of many points of
//! the visible emitting surface is tested against every triangle. No map, no filter.
use gobo::{
    glam::{DVec3, Vec3},
    model::{Light, LightKind, Source, Transfer, Triangle},
};
use gobo_scene::Scene;
use std::f64::consts::{PI, TAU};

/// Sample points on a light.
const PLACES: usize = 1024;
/// Distance below which a caster is the receiver's own surface [m].
const TOUCHING: f64 = 1e-3;
/// Distance of a directional light's sample points [m].
const FAR: f64 = 100.0;

/// Mean over the light; `normal`: of the receiver's surface.
pub(crate) fn share(scene: &Scene, light: &Light, point: Vec3, normal: Vec3) -> DVec3 {
    share_of_places(scene, light, point, normal, PLACES)
}

/// [`share`] by `count` places.
pub(crate) fn share_of_places(
    scene: &Scene,
    light: &Light,
    point: Vec3,
    normal: Vec3,
    count: usize,
) -> DVec3 {
    let start = point.as_dvec3() + normal.as_dvec3() * TOUCHING;
    let places = (0..count).map(|i| {
        // Rank-1 lattice of the golden ratio.
        let (u, v) = ((i as f64 + 0.5) / count as f64, (i as f64 * 0.618_033_988_749_895).fract());
        place(light, start, u, v)
    });
    let facets = facets(scene, start);
    places.map(|end| passed(&facets, end - start)).sum::<DVec3>() / count as f64
}

/// A sample point on the light as seen from `start`; `u` and `v` are in 0..1.
fn place(light: &Light, start: DVec3, u: f64, v: f64) -> DVec3 {
    let disc = |radius: f64| {
        let (radius, angle) = (radius * u.sqrt(), TAU * v);
        (radius * angle.cos(), radius * angle.sin())
    };
    let center = match light.kind {
        LightKind::Directional { direction } => {
            let away = -direction.as_dvec3().normalize();
            let Some(Source::Sun { angle }) = light.source else { return start + away * FAR };
            let (x, y) = disc((f64::from(angle) * 0.5).tan());
            let (right, up) = across(away);
            return start + (away + right * x + up * y) * FAR;
        }
        LightKind::Spot { position, .. } | LightKind::Point { position } => position.as_dvec3(),
    };
    match light.source {
        // Evenly over its solid angle, on the visible side.
        Some(Source::Sphere { radius }) => {
            let radius = f64::from(radius);
            let away = center - start;
            let sine2 = (radius / away.length()).powi(2);
            let cosine = 1.0 - u * (1.0 - (1.0 - sine2).sqrt());
            let sine = (1.0 - cosine * cosine).sqrt();
            let (right, up) = across(away.normalize());
            let (x, y) = ((TAU * v).cos(), (TAU * v).sin());
            let way = away.normalize() * cosine + (right * x + up * y) * sine;
            let along = away.dot(way);
            let root = (radius * radius - (away.length_squared() - along * along)).max(0.0).sqrt();
            start + way * (along - root)
        }
        Some(Source::Disc { radius, direction }) => {
            let (right, up) = across(direction.as_dvec3().normalize());
            let (x, y) = disc(f64::from(radius));
            center + right * x + up * y
        }
        Some(Source::Rect { width, height, direction }) => {
            let (right, up) = across(direction.as_dvec3().normalize());
            center + right * ((u - 0.5) * f64::from(width)) + up * ((v - 0.5) * f64::from(height))
        }
        _ => center,
    }
}

/// The axis `cross(along, up)`, and the axis perpendicular to both.
fn across(along: DVec3) -> (DVec3, DVec3) {
    let up = if along.x.hypot(along.z) < 1e-5 { DVec3::Z } else { DVec3::Y };
    let right = along.cross(up).normalize();
    (right, right.cross(along))
}

/// A triangle for rays from one point (Möller and Trumbore 1997): along `way`, `way.dot(normal)` times its
/// barycentric coordinates and the ray's parameter are `way.dot(u)`, `way.dot(v)` and `t`.
struct Facet {
    normal: DVec3,
    u: DVec3,
    v: DVec3,
    t: f64,
    light: DVec3,
}

fn facets(scene: &Scene, start: DVec3) -> Vec<Facet> {
    let facet = |triangle: &Triangle| {
        let [a, b, c] = triangle.positions.map(Vec3::as_dvec3);
        let (ab, ac, s) = (b - a, c - a, start - a);
        let v = s.cross(ab);
        let material = &scene.materials[triangle.material as usize];
        let tint = material.tint.as_dvec4();
        let light = match material.transfer {
            Transfer::Opaque => DVec3::ZERO,
            Transfer::Filter => DVec3::ONE - tint.w * (DVec3::ONE - tint.truncate()),
            other => panic!("{other:?} has no truth here"),
        };
        Facet { normal: ac.cross(ab), u: ac.cross(s), v, t: ac.dot(v), light }
    };
    scene.triangles.iter().map(facet).collect()
}

fn passed(facets: &[Facet], way: DVec3) -> DVec3 {
    let mut light = DVec3::ONE;
    for facet in facets {
        let scale = way.dot(facet.normal);
        let (t, end) = (facet.t * scale, scale * scale);
        if !(t > 0.0 && t < end) || scale.abs() < 1e-15 {
            continue;
        }
        let (u, v) = (way.dot(facet.u) * scale, way.dot(facet.v) * scale);
        if !(u >= 0.0 && v >= 0.0 && u + v < end) {
            continue;
        }
        light *= facet.light;
        if light == DVec3::ZERO {
            break;
        }
    }
    light
}

/// Angle of a cone in radians.
pub(crate) fn degrees(angle: f64) -> f32 {
    (angle * PI / 180.0) as f32
}
