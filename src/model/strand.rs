//! Strands: hair, fur, ribbons and trails, as polylines of capsules.
use super::bounds::{Bounds, FARTHEST};
use glam::{Mat3, Mat4, Vec3, Vec4};

/// A vertex of a [`Strand`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrandVertex {
    /// World space \[m\].
    pub position: Vec3,
    /// At least 0; 0 for a tip \[m\].
    pub radius: f32,
    /// Linear rgba, 0..=1 (rgb 16 with `gain`); multiplies the material's tint. A capsule has the mean of its
    /// ends.
    pub color: Vec4,
}

impl StrandVertex {
    /// A white opaque vertex; position in world space \[m\], radius \[m\].
    pub fn new(position: impl Into<[f32; 3]>, radius: f32) -> Self {
        Self { position: position.into().into(), radius, color: Vec4::ONE }
    }
}

/// A polyline with a radius and a colour at each vertex. Between two neighbours it is a *capsule*: a cone
/// between two planes. Inner planes bisect the angle between the neighbours, so that no point is in two
/// capsules.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strand {
    /// At least two, in order.
    pub vertices: Vec<StrandVertex>,
    /// Index into [`crate::model::Scene::materials`], of a material whose shape is [`super::Shape::Capsule`].
    pub material: u32,
    /// Seed of dither patterns; unique where the file gives one.
    pub id: u32,
}

/// One segment of a strand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// Ends, world space \[m\].
    pub ends: [Vec3; 2],
    /// Radii at the ends \[m\].
    pub radii: [f32; 2],
    /// Unit normals of the planes through the ends, both from the first end to the second.
    pub planes: [Vec3; 2],
    /// Mean of the ends' colours: linear rgba.
    pub color: Vec4,
}

/// Least cosine of a turn at which neighbours share a plane: 90 degrees.
const SHARP: f32 = 1e-3;
/// Largest change of the radius over the length at which neighbours share a plane.
const STEEP: f32 = 0.25;

impl Strand {
    /// The strand transformed by `world`; radii scale by the mean of its scales.
    #[must_use]
    pub fn placed(&self, world: &Mat4) -> Self {
        let scale = Mat3::from_mat4(*world).determinant().abs().cbrt();
        let vertex = |vertex: &StrandVertex| StrandVertex {
            position: world.transform_point3(vertex.position),
            radius: vertex.radius * scale,
            ..*vertex
        };
        Self { vertices: self.vertices.iter().map(vertex).collect(), ..*self }
    }

    /// Short reason why it cannot be used; `None` if it can. `max_color`: its [`super::Transfer::max_color`].
    pub fn problem(&self, max_color: f32) -> Option<&'static str> {
        let all = || self.vertices.iter();
        let finite = |v: &StrandVertex| {
            v.position.is_finite() && v.radius.is_finite() && v.color.is_finite()
        };
        let far = |v: &StrandVertex| v.position.abs().max_element().max(v.radius) > FARTHEST;
        let colors = |v: &StrandVertex| {
            let color = v.color.truncate();
            color.min_element() >= 0.0 && color.max_element() <= max_color
        };
        if !all().all(finite) {
            Some("strand not finite")
        } else if all().any(far) {
            Some("strand too far")
        } else if all().any(|v| v.radius < 0.0) || all().all(|v| v.radius == 0.0) {
            Some("strand radius not positive")
        } else if !all().all(colors) {
            Some("strand colour out of range")
        } else if !all().all(|v| (0.0..=1.0).contains(&v.color.w)) {
            Some("strand opacity out of range")
        } else if self.distinct().nth(1).is_none() {
            Some("strand shorter than two vertices")
        } else {
            None
        }
    }

    /// Vertices that differ in position from the one before.
    fn distinct(&self) -> impl Iterator<Item = &StrandVertex> {
        let mut before = None;
        self.vertices.iter().filter(move |vertex| {
            let position = before.replace(vertex.position);
            position.is_none_or(|position| position.distance_squared(vertex.position) > 0.0)
        })
    }

    /// Its capsules, in order.
    pub fn capsules(&self) -> Vec<Capsule> {
        let vertices: Vec<_> = self.distinct().collect();
        let ways: Vec<Vec3> =
            vertices.windows(2).map(|v| (v[1].position - v[0].position).normalize()).collect();
        let is_steep = |i: usize| {
            let [a, b] = [vertices[i], vertices[i + 1]];
            (b.radius - a.radius).abs() > STEEP * a.position.distance(b.position)
        };
        // The plane between segments i - 1 and i; `None` where each ends in a plane of its own.
        let between = |i: usize| {
            let [before, after] = [ways.get(i.checked_sub(1)?)?, ways.get(i)?];
            let shares = before.dot(*after) > SHARP && !is_steep(i - 1) && !is_steep(i);
            shares.then(|| (*before + *after).normalize())
        };
        let capsule = |(i, way): (usize, &Vec3)| {
            let [a, b] = [vertices[i], vertices[i + 1]];
            Capsule {
                ends: [a.position, b.position],
                radii: [a.radius, b.radius],
                planes: [i, i + 1].map(|plane| between(plane).unwrap_or(*way)),
                color: (a.color + b.color) * 0.5,
            }
        };
        ways.iter().enumerate().map(capsule).collect()
    }

    /// Box around it, world space \[m\].
    pub fn bounds(&self) -> Bounds {
        let capsules = self.capsules();
        capsules.iter().fold(Bounds::EMPTY, |all, capsule| {
            let reaches = capsule.reaches();
            all.with_sphere(capsule.ends[0], reaches[0]).with_sphere(capsule.ends[1], reaches[1])
        })
    }
}

impl Capsule {
    /// Radii of the spheres around its ends whose convex hull contains it \[m\].
    pub fn reaches(&self) -> [f32; 2] {
        let along = self.ends[1] - self.ends[0];
        let length = along.length();
        let slope = (self.radii[1] - self.radii[0]).abs() / length;
        [0, 1].map(|end| self.radii[end] * mitre(self.planes[end].dot(along / length), slope))
    }
}

/// Factor of a capsule's radius up to which it reaches at an end. `cosine`: of the end's plane with the axis;
/// `slope` of the radius. WGSL: `wgsl/project/extent.wgsl`.
pub fn mitre(cosine: f32, slope: f32) -> f32 {
    let cosine = cosine.clamp(0.5, 1.0);
    let tangent = (1.0 - cosine * cosine).sqrt() / cosine;
    1.0 / (cosine * (1.0 - slope * tangent).max(0.5))
}
