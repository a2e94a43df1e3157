//! Small scenes, and seeded random numbers.
use gobo::{
    glam::{Mat4, UVec2, Vec2, Vec3, Vec4},
    model::{
        Camera, Light, LightKind, Material, Particle, Projection, Receiver, ShadowSettings,
        Transfer, Triangle, View, ViewRole,
    },
    records::GpuView,
};
use gobo_scene::Scene;

/// Seeded random numbers (Steele et al. 2014, `SplitMix64`).
pub(crate) struct Chance(u64);

impl Chance {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// A random number in 0..1.
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    pub(crate) fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }

    pub(crate) fn vec3(&mut self, low: f32, high: f32) -> Vec3 {
        Vec3::new(self.within(low, high), self.within(low, high), self.within(low, high))
    }

    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

/// A view of `size` squared texels from the origin along -z, whose view space is world space: orthographic,
/// of `scale` texels per metre, or a perspective one of 90 degrees.
pub(crate) fn view_from_origin(
    projection: Projection,
    size: u32,
    [near, far]: [f32; 2],
    scale: f32,
) -> GpuView {
    let view = View {
        role: ViewRole::Whole,
        light: Some(0),
        name: "0",
        projection,
        size: UVec2::splat(size),
        near,
        far,
        view_from_world: Mat4::IDENTITY,
        scale: if projection == Projection::Orthographic { scale } else { 0.5 * size as f32 },
    };
    view.to_gpu(0, UVec2::ZERO, 0)
}

/// Settings with which receivers read nearest depths.
pub(crate) fn nearest_depth() -> ShadowSettings {
    ShadowSettings { receiver: Receiver::Nearest, ..ShadowSettings::default() }
}

/// Nothing but materials, read by nearest depths.
pub(crate) fn empty(materials: Vec<Material>) -> Scene {
    Scene {
        camera: Camera {
            eye: Vec3::new(4.0, 3.0, 6.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            fov_y: 0.8,
            size: UVec2::new(64, 64),
        },
        shadow: ShadowSettings { size: 64, ..nearest_depth() },
        materials,
        textures: Vec::new(),
        motions: Vec::new(),
        particles: Vec::new(),
        triangles: Vec::new(),
        ambient: Vec3::ZERO,
        background: Vec3::ZERO,
        ..gobo_scene::empty_scene()
    }
}

pub(crate) fn light(kind: LightKind) -> Light {
    Light { kind, ..Light::default() }
}

pub(crate) fn material(transfer: Transfer) -> Material {
    Material { transfer, ..Material::default() }
}

pub(crate) fn particle(center: Vec3, radius: f32, color: Vec4) -> Particle {
    Particle { center, radius, color, rotation: 0.0, material: 0, id: 0 }
}

/// A view whose view space is world space: it looks along -z, with `far` at z = -10, and is `size / scale`
/// metres wide.
pub(crate) fn flat_view(size: u32, scale: f32) -> View {
    View {
        role: ViewRole::Whole,
        light: Some(0),
        name: "0",
        projection: Projection::Orthographic,
        size: UVec2::splat(size),
        near: 0.0,
        far: 10.0,
        view_from_world: Mat4::IDENTITY,
        scale,
    }
}

/// A square pane across the axis of a [`flat_view`], at light depth `depth`.
pub(crate) fn pane(depth: f32, half: f32, material: u32) -> [Triangle; 2] {
    let corner = |x: f32, y: f32| Vec3::new(x * half, y * half, -10.0 * depth);
    let (a, b, c, d) = (corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0));
    [[a, b, c], [a, c, d]].map(|positions| triangle(positions, material))
}

pub(crate) fn triangle(positions: [Vec3; 3], material: u32) -> Triangle {
    let uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE];
    Triangle { normals: [Vec3::Z; 3], uvs, ..Triangle::flat(positions, material) }
}

/// Fixes a directional light's view at 20 x 20 x 20 m around the origin, whatever else casts, by an opaque
/// triangle between two corners; it has no area, so it covers no texel.
pub(crate) fn hold_view(scene: &mut Scene, opaque: u32) {
    // With its margin and one more texel, a window is rounded up to 20 m.
    let far = Vec3::splat(9.2);
    scene.triangles.push(triangle([-far, far, far], opaque));
}

/// Discs of one material in a ball of radius 2 [m] around the origin, with radii from far below a texel to a
/// large part of a map.
pub(crate) fn random_discs(count: usize, seed: u64) -> Vec<Particle> {
    let mut chance = Chance::new(seed);
    let discs = (0..count as u32).map(|id| {
        let center = loop {
            let p = chance.vec3(-2.0, 2.0);
            if p.length() <= 2.0 {
                break p;
            }
        };
        let radius = 0.002 * (300.0_f32).powf(chance.unit());
        let color = chance.vec3(0.0, 1.0).extend(chance.unit().powi(3));
        Particle { rotation: chance.within(-7.0, 7.0), id, ..particle(center, radius, color) }
    });
    discs.collect()
}
