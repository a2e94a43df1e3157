//! Geometry and optics of one ray's hit. CPU reference of `wgsl/hit/hit.wgsl`.
use glam::{Vec2, Vec3, Vec4};
use gobo::{
    model::{MAX_GAIN, Profile, Shape, Transfer},
    records::{Footprint, GpuView, TriangleSetup},
};

/// Hit of a ray with a particle's plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneHit {
    /// Position in the particle's frame \[radii\].
    pub q: Vec2,
    /// Light depth.
    pub depth: f32,
}

/// A particle set up for texels: `q = (frame * delta + offset) / (start + tilt . delta)`, where `delta` is
/// the vector from the reference to the texel's centre \[texels\]. The reference is the particle's centre,
/// where `q` is 0 and `start` 1; for a particle beside the view, whose centre has no position in the map, it
/// is the map's centre.
#[derive(Clone, Copy, Debug)]
pub struct Facing {
    /// Reference in the map \[texels\].
    pub reference: Vec2,
    /// First row of `frame`, which gives `q.x` \[radii per texel\].
    pub frame_x: Vec2,
    /// Second row of `frame` \[radii per texel\].
    pub frame_y: Vec2,
    /// Numerator of `q` at the reference \[radii\].
    pub offset: Vec2,
    /// Change of the denominator per texel.
    pub tilt: Vec2,
    /// Denominator at the reference.
    pub start: f32,
    /// Distance of the plane along the axis at the reference, times `start` \[m\].
    pub distance: f32,
}

impl Facing {
    /// Sets up a particle; `rotation` about the ray \[radians\].
    pub fn new(view: &GpuView, footprint: &Footprint, rotation: f32) -> Self {
        let (sin, cos) = rotation.sin_cos();
        if let Some(beside) = footprint.beside() {
            return Self::beside(view, beside, -footprint.radius, sin, cos);
        }
        let Footprint { center, radius, depth, .. } = *footprint;
        let distance = view.near + depth * (view.far - view.near);
        let at_center = |frame_x, frame_y, tilt| Self {
            reference: center,
            frame_x,
            frame_y,
            offset: Vec2::ZERO,
            tilt,
            start: 1.0,
            distance,
        };
        if view.perspective == 0.0 {
            let forward = -view.view_from_world.row(2).truncate();
            let (x0, y0) = quad_axes(forward);
            let (x, y) = turned(x0, y0, sin, cos);
            let to_texels = |axis: Vec3| {
                let axis = view.view_from_world.transform_vector3(axis);
                Vec2::new(axis.x, -axis.y) / radius
            };
            let (frame_x, frame_y) = (to_texels(x), to_texels(y));
            return at_center(frame_x, frame_y, Vec2::ZERO);
        }
        let slope = (center - view.size * 0.5) / view.scale;
        let ray = Vec3::new(slope.x, -slope.y, -1.0);
        let len = ray.length();
        let n = ray / len;
        let world_from_view = view.view_from_world.transpose();
        let (x0, y0) = quad_axes(world_from_view.transform_vector3(n));
        let (x, y) = turned(x0, y0, sin, cos);
        let k = 1.0 / (radius * len * view.scale);
        let to_texels = |axis: Vec3| {
            let axis = view.view_from_world.transform_vector3(axis);
            Vec2::new(axis.x, -axis.y) * k
        };
        let tilt = Vec2::new(n.x, -n.y) / (len * view.scale);
        at_center(to_texels(x), to_texels(y), tilt)
    }

    /// Sets up a particle beside the view; `center`: to the right, down and along the axis \[m\]; `radius`
    /// \[m\].
    fn beside(view: &GpuView, center: Vec3, radius: f32, sin: f32, cos: f32) -> Self {
        let distance = center.length().max(f32::MIN_POSITIVE);
        let n = center / distance;
        let ray = Vec3::new(n.x, -n.y, -n.z);
        let (x0, y0) = quad_axes(view.view_from_world.transpose().transform_vector3(ray));
        let (x, y) = turned(x0, y0, sin, cos);
        let k = distance / radius;
        let [x, y] = [x, y].map(|axis| {
            let axis = view.view_from_world.transform_vector3(axis);
            Vec3::new(axis.x, -axis.y, -axis.z) * k
        });
        Self {
            reference: view.size * 0.5,
            frame_x: x.truncate() / view.scale,
            frame_y: y.truncate() / view.scale,
            offset: Vec2::new(x.z, y.z),
            tilt: n.truncate() / view.scale,
            start: n.z,
            distance,
        }
    }

    /// `None` if the ray does not meet the plane in front of the light.
    pub fn hit(&self, view: &GpuView, texel: Vec2) -> Option<PlaneHit> {
        let delta = texel - self.reference;
        let denominator = self.start + self.tilt.dot(delta);
        let q = Vec2::new(self.frame_x.dot(delta), self.frame_y.dot(delta)) + self.offset;
        (denominator > 0.0).then(|| PlaneHit {
            q: q / denominator,
            depth: (self.distance / denominator - view.near) / (view.far - view.near),
        })
    }
}

/// Axes of a plane with the normal `n`: unit, world space.
fn quad_axes(n: Vec3) -> (Vec3, Vec3) {
    let up = if n.y.abs() > 0.99 { Vec3::Z } else { Vec3::Y };
    let x = up.cross(n).normalize();
    (x, n.cross(x))
}

fn turned(x: Vec3, y: Vec3, sin: f32, cos: f32) -> (Vec3, Vec3) {
    (x * cos + y * sin, y * cos - x * sin)
}

/// Share of a particle's alpha at `q`, 0 outside its shape.
pub fn coverage(shape: Shape, profile: Profile, q: Vec2) -> f32 {
    let inside = match shape {
        Shape::Quad => q.x.abs().max(q.y.abs()) <= 1.0,
        // A Gaussian, a brick and a capsule have no plane.
        Shape::Gaussian | Shape::Brick | Shape::Capsule => false,
        Shape::Disc | Shape::Puff => q.length_squared() <= 1.0,
    };
    match (inside, shape, profile) {
        (false, ..) => 0.0,
        (true, Shape::Disc, Profile::Soft) => {
            let rest = 1.0 - q.length_squared();
            rest * rest
        }
        (true, ..) => 1.0,
    }
}

/// Opacity of a particle smaller than a texel, before it was reduced.
fn whole_opacity(thin: f32, a: f32) -> f32 {
    // Below the smallest stored half float, both are 0.
    (a / thin.max(1e-12)).min(1.0)
}

/// Transmittance of a hit of opacity `a` and colour `c` (divided by 16 for `gain`), per channel: `1 - thin
/// (1 - T)` for a particle smaller than a texel, whose `a` is reduced.
pub fn transmittance(transfer: Transfer, thin: f32, a: f32, c: Vec3) -> Vec3 {
    let clear = 1.0 - thin;
    let passed = (thin - a).max(0.0);
    match transfer {
        // For the picture only: shadows are dithered.
        Transfer::Filter | Transfer::Dither => Vec3::ONE - a * (Vec3::ONE - c),
        Transfer::Stain => clear + c * passed,
        Transfer::Smoke => clear + passed * (Vec3::ONE - whole_opacity(thin, a) * (Vec3::ONE - c)),
        Transfer::Gain => clear + thin * c * MAX_GAIN,
        Transfer::Over => Vec3::splat(1.0 - a),
        Transfer::None | Transfer::Opaque | Transfer::Cutout => Vec3::ONE,
    }
}

/// 1 - [`transmittance`], in full precision where the transmittance is close to 1.
pub fn absorption(transfer: Transfer, thin: f32, a: f32, c: Vec3) -> Vec3 {
    let filtered = a * (Vec3::ONE - c);
    match transfer {
        Transfer::Filter | Transfer::Dither => filtered,
        Transfer::Stain => thin * (Vec3::ONE - c) + c * a.min(thin),
        Transfer::Smoke => Vec3::splat(a) + filtered * (1.0 - whole_opacity(thin, a)),
        Transfer::Gain => thin * (Vec3::ONE - c * MAX_GAIN),
        Transfer::Over => Vec3::splat(a),
        Transfer::None | Transfer::Opaque | Transfer::Cutout => Vec3::ZERO,
    }
}

/// Hit of a ray with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Texture coordinates.
    pub uv: Vec2,
    /// Weights of the three corners; they add up to 1.
    pub barycentric: Vec3,
    /// Light depth.
    pub depth: f32,
}

/// Rays and the triangle of a setup.
pub trait HitTriangle {
    /// Barycentric weights of two corners, and their change per texel.
    fn on_triangle(&self, texel: Vec2) -> (Vec2, Vec2);
    /// Interpolated colour and alpha of the corners, which store square roots of linear light.
    fn color(&self, barycentric: Vec3) -> Vec4;
    /// Change of the uv at a hit per texel, to the right and down.
    fn uv_steps(&self, texel: Vec2, uv: Vec2) -> [Vec2; 2];
    /// Hit of the ray through a texel; an edge belongs to one of its two triangles.
    fn hit(&self, texel: Vec2) -> Option<TriangleHit>;
}

fn edge(setup: &TriangleSetup, i: usize, texel: Vec2) -> f32 {
    let line = setup.edges[i];
    line.z * (texel.y - line.y) - line.w * (texel.x - line.x)
}

impl HitTriangle for TriangleSetup {
    fn on_triangle(&self, texel: Vec2) -> (Vec2, Vec2) {
        let weighted = |i: usize| edge(self, i, texel) * self.weights[i];
        let step = |i: usize| Vec2::new(-self.edges[i].w, self.edges[i].z) * self.weights[i];
        let sum = weighted(0) + weighted(1) + weighted(2);
        let step_of_sum = step(0) + step(1) + step(2);
        let weighted = Vec2::new(weighted(0), weighted(1)) / sum;
        let along = |i: usize| ((step(i) - weighted[i] * step_of_sum).abs() / sum).max_element();
        (weighted, Vec2::new(along(0), along(1)))
    }

    fn color(&self, barycentric: Vec3) -> Vec4 {
        if self.colors == [u32::MAX; 3] {
            return Vec4::ONE;
        }
        let corner = |i: usize| {
            let [r, g, b, a] = self.colors[i].to_le_bytes().map(|byte| f32::from(byte) / 255.0);
            Vec4::new(r * r, g * g, b * b, a) * barycentric[i]
        };
        corner(0) + corner(1) + corner(2)
    }

    fn uv_steps(&self, texel: Vec2, uv: Vec2) -> [Vec2; 2] {
        let sum: f32 = (0..3).map(|i| edge(self, i, texel) * self.weights[i]).sum();
        let change = |step: &dyn Fn(Vec4) -> f32| {
            let of_corner = |i| (self.uvs[i] - uv) * (step(self.edges[i]) * self.weights[i]);
            (0..3).map(of_corner).sum::<Vec2>() / sum
        };
        [change(&|edge| -edge.w), change(&|edge| edge.z)]
    }

    fn hit(&self, texel: Vec2) -> Option<TriangleHit> {
        let e = Vec3::new(edge(self, 0, texel), edge(self, 1, texel), edge(self, 2, texel));
        let inside = (0..3).all(|i| e[i] > 0.0 || (e[i] == 0.0 && self.ties >> i & 1 == 1));
        let weighted = e * self.weights;
        let sum = weighted.x + weighted.y + weighted.z;
        (inside && sum > 0.0).then(|| {
            let barycentric = weighted / sum;
            TriangleHit {
                uv: self.uvs[0] * barycentric.x
                    + self.uvs[1] * barycentric.y
                    + self.uvs[2] * barycentric.z,
                barycentric,
                depth: self.depths.dot(barycentric),
            }
        })
    }
}
