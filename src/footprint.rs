//! The records that stages hand on: casters as uploaded, footprints as one view sees them.
//!
//! All live in rgba32uint or rg32uint textures, [`ROW`] texels wide: element `i` of `n` texels
//! starts at linear texel `i * n`. Texture reads are cheap on every adapter, and a texture is not
//! bound by the size of a storage binding. WGSL: `wgsl/common/record.wgsl`.
use crate::caster::{Material, Particle};
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3, Vec4};
use half::f16;

/// Texels in a row of a record texture.
pub const ROW: u32 = 4096;
/// Texels of a [`Caster`] and of a [`Footprint`].
pub const CASTER_TEXELS: u32 = 2;
pub const FOOTPRINT_TEXELS: u32 = 2;
/// Texels of a [`TriangleSetup`].
pub const SETUP_TEXELS: u32 = 8;
/// Texels of a [`TriangleRecord`].
pub const TRIANGLE_TEXELS: u32 = 5;
/// Bit of [`Footprint::caster`] that marks a triangle.
pub const TRIANGLE_BIT: u32 = 1 << 31;
/// Bit of [`TriangleSetup::ties`] of a triangle that is clockwise as the light sees it.
pub const BACK_BIT: u32 = 8;
/// Projected radius below which a particle is enlarged and thinned: half the diagonal of a texel,
/// so that one texel's centre is always hit [texels].
pub const MIN_RADIUS: f32 = std::f32::consts::FRAC_1_SQRT_2;
/// Bits of the depth key. Commutative transfers need order only to stop early.
pub const DEPTH_BITS: u32 = 16;
/// Key of what touches no texel: sorts behind everything.
pub const INVISIBLE: u32 = (1 << DEPTH_BITS) - 1;

/// Two numbers in 0..=1 as `pack2x16unorm` does.
fn unorm2(x: f32, y: f32) -> u32 {
    let unorm = |v: f32| (0.5 + 65535.0 * v.clamp(0.0, 1.0)).floor() as u32;
    unorm(x) | unorm(y) << 16
}

fn from_unorm(bits: u32) -> f32 {
    (bits & 0xffff) as f32 / 65535.0
}

fn half_bits(v: f32) -> u32 {
    u32::from(f16::from_f32(v).to_bits())
}

fn from_half(bits: u32) -> f32 {
    f16::from_bits(bits as u16).to_f32()
}

/// A particle as kernels read it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Caster {
    /// World space [m].
    pub center: Vec3,
    /// [m]
    pub radius: f32,
    /// Red and green, unorm16; of a `gain` material divided by 16.
    pub red_green: u32,
    /// Blue, unorm16, and alpha, f16.
    pub blue_alpha: u32,
    /// Material in the low half, rotation in the high one [turns / 65536].
    pub material_rotation: u32,
    pub id: u32,
}

impl Caster {
    pub fn new(particle: &Particle, material: &Material) -> Self {
        let color = particle.color.truncate() / material.transfer.max_color();
        let turns = (particle.rotation / std::f32::consts::TAU).rem_euclid(1.0);
        Self {
            center: particle.center,
            radius: particle.radius,
            red_green: unorm2(color.x, color.y),
            blue_alpha: unorm2(color.z, 0.0) | half_bits(particle.color.w) << 16,
            material_rotation: (particle.material & 0xffff)
                | ((turns * 65536.0).round() as u32 & 0xffff) << 16,
            id: particle.id,
        }
    }

    pub fn material(&self) -> u32 {
        self.material_rotation & 0xffff
    }

    /// [radians]
    pub fn rotation(&self) -> f32 {
        (self.material_rotation >> 16) as f32 * (std::f32::consts::TAU / 65536.0)
    }

    /// Linear rgba, before the material's tint; rgb of a `gain` material divided by 16.
    pub fn color(&self) -> Vec4 {
        Vec4::new(
            from_unorm(self.red_green),
            from_unorm(self.red_green >> 16),
            from_unorm(self.blue_alpha),
            from_half(self.blue_alpha >> 16),
        )
    }
}

/// A caster as one view sees it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Footprint {
    /// Centre in the view's map [texels]; of a triangle, of its bounding square; of a particle
    /// beside the view how far it is to the right and down [m].
    pub center: Vec2,
    /// Orthographic: [texels]. Perspective: radius over distance from the light. Triangle: half
    /// the side of the bounding square [texels]. Negative for a particle beside the view, whose
    /// centre has no place in the map: minus its radius [m].
    pub radius: f32,
    /// Light depth of the centre; of a triangle the smallest; of a particle beside the view how far
    /// it is along the axis [m].
    pub depth: f32,
    /// Colour times tint, red and green, unorm16; of a `gain` material divided by 16.
    pub red_green: u32,
    /// Blue, unorm16, and the slope of the opacity, f16.
    pub blue_slope: u32,
    /// Opacity where texture and profile are 0 (reflectivity), f16 in the low half.
    pub base: u32,
    /// Index of the particle, or of the triangle with [`TRIANGLE_BIT`].
    pub caster: u32,
}

impl Footprint {
    pub fn set_opacity(&mut self, color: Vec3, base: f32, slope: f32) {
        self.red_green = unorm2(color.x, color.y);
        self.blue_slope = unorm2(color.z, 0.0) | half_bits(slope) << 16;
        self.base = half_bits(base);
    }

    /// Centre of a particle beside the view: to the right, down and along the axis [m]. `None` for
    /// all others. WGSL: `is_beside` in `wgsl/common/view.wgsl`.
    pub fn beside(&self) -> Option<Vec3> {
        (self.radius < 0.0).then(|| self.center.extend(self.depth))
    }

    /// `c`, rgb; of a `gain` material divided by 16.
    pub fn color(&self) -> Vec3 {
        Vec3::new(
            from_unorm(self.red_green),
            from_unorm(self.red_green >> 16),
            from_unorm(self.blue_slope),
        )
    }

    /// `(base, slope)` of the opacity `a = base + slope * texture.a * profile`.
    pub fn opacity(&self) -> (f32, f32) {
        (from_half(self.base), from_half(self.blue_slope >> 16))
    }
}

/// The tiles of a footprint: decided once, by `project`; `bin` reads it twice.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct TileRect {
    /// First and last column and row, inclusive, 8 bits each: x0, y0, x1, y1.
    pub corners: u32,
    /// Low half: which tiles of a rectangle of at most 4x4 are touched, row by row, 4 bits a row;
    /// all ones for a larger rectangle, 0 for none. High half: the view's index in its batch.
    pub mask_view: u32,
}

impl TileRect {
    pub const EMPTY: Self = Self { corners: 0, mask_view: 0 };

    /// Of a caster that goes straight to its few texels: no tiles, and corners that no rectangle
    /// without tiles has.
    pub fn scattered(view: u32) -> Self {
        Self { corners: u32::MAX, mask_view: view << 16 }
    }

    pub fn is_scattered(&self) -> bool {
        self.corners == u32::MAX && self.mask_view & 0xffff == 0
    }

    pub fn x(&self) -> std::ops::RangeInclusive<u32> {
        (self.corners & 255)..=(self.corners >> 16 & 255)
    }

    pub fn y(&self) -> std::ops::RangeInclusive<u32> {
        (self.corners >> 8 & 255)..=(self.corners >> 24)
    }

    pub fn view(&self) -> u32 {
        self.mask_view >> 16
    }

    /// Tiles `(x, y)` in row order.
    pub fn tiles(&self) -> impl Iterator<Item = (u32, u32)> {
        let (xs, ys, mask) = (self.x(), self.y(), self.mask_view & 0xffff);
        let small = xs.end() - xs.start() < 4 && ys.end() - ys.start() < 4;
        let (x0, y0) = (*xs.start(), *ys.start());
        ys.flat_map(move |y| xs.clone().map(move |x| (x, y))).filter(move |&(x, y)| {
            mask != 0 && (!small || mask >> ((y - y0) * 4 + x - x0) & 1 == 1)
        })
    }
}

/// A triangle of the scene as kernels read it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TriangleRecord {
    /// Three world-space positions [m], each followed by the vertex's u.
    pub positions_u: [Vec4; 3],
    pub v: Vec3,
    pub material: u32,
    /// Octahedral normals, snorm16 pairs.
    pub normals: [u32; 3],
    pub id: u32,
}

impl TriangleRecord {
    pub fn new(triangle: &crate::caster::Triangle) -> Self {
        let [a, b, c] = triangle.uvs;
        Self {
            positions_u: std::array::from_fn(|i| triangle.positions[i].extend(triangle.uvs[i].x)),
            v: Vec3::new(a.y, b.y, c.y),
            material: triangle.material,
            normals: triangle.normals.map(octahedral),
            id: triangle.id,
        }
    }
}

/// A unit vector in two snorm16 (Cigolle et al. 2014, section 3).
pub(crate) fn octahedral(n: Vec3) -> u32 {
    let n = n / (n.x.abs() + n.y.abs() + n.z.abs()).max(1e-20);
    let folded = if n.z < 0.0 {
        (Vec2::ONE - Vec2::new(n.y, n.x).abs()) * Vec2::new(1f32.copysign(n.x), 1f32.copysign(n.y))
    } else {
        Vec2::new(n.x, n.y)
    };
    let snorm = |v: f32| u32::from(((v.clamp(-1.0, 1.0) * 32767.0).round() as i16) as u16);
    snorm(folded.x) | snorm(folded.y) << 16
}

/// The inverse of [`octahedral`].
pub(crate) fn from_octahedral(bits: u32) -> Vec3 {
    let snorm = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).max(-1.0);
    let e = Vec2::new(snorm(bits), snorm(bits >> 16));
    let z = 1.0 - e.x.abs() - e.y.abs();
    let folded =
        (Vec2::ONE - Vec2::new(e.y, e.x).abs()) * Vec2::new(1f32.copysign(e.x), 1f32.copysign(e.y));
    let xy = if z < 0.0 { folded } else { e };
    xy.extend(z).normalize_or_zero()
}

/// A triangle prepared for a view: what its hit test needs. Texel space.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct TriangleSetup {
    /// A point of the edge's line and the edge's direction: `x, y, dx, dy` [texels]. The edge
    /// function is `dx (py - y) - dy (px - x)`; the inside is where all three are >= 0.
    pub edges: [Vec4; 3],
    /// Factors that turn edge values into perspective-correct weights.
    pub weights: Vec3,
    /// Bit i: a texel centre exactly on edge i belongs to this triangle. [`BACK_BIT`]: it looks away
    /// from the light.
    pub ties: u32,
    /// Light depths of the corners.
    pub depths: Vec3,
    pub material: u32,
    pub uvs: [Vec2; 3],
    /// World-space face normal, octahedral.
    pub normal: u32,
    pub id: u32,
    pub pad: [u32; 4],
}

/// A material as kernels read it. WGSL: `wgsl/common/material.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GpuMaterial {
    /// Linear rgba.
    pub tint: Vec4,
    pub emission: Vec3,
    pub transmission: f32,
    pub transfer: u32,
    pub shape: u32,
    pub profile: u32,
    /// Layer of the texture array, [`NO_TEXTURE`] for none.
    pub texture: u32,
    /// Of the texture within its layer [texels].
    pub texture_size: Vec2,
    pub reflectivity: f32,
    pub cutoff: f32,
    pub roughness: f32,
    pub pattern: u32,
    /// Edge of a cell of the pattern [texels].
    pub pattern_scale: u32,
    /// Texel of the particles' records where the ranks of the blue noise start.
    pub blue_first: u32,
    /// Of the way through a closed mesh of it [1/m]; zero where it is no volume.
    pub absorption: Vec3,
    pub receives: u32,
}
crate::gpu_layout!(GpuMaterial {
    tint,
    emission,
    transmission,
    transfer,
    shape,
    profile,
    texture,
    texture_size,
    reflectivity,
    cutoff,
    roughness,
    pattern,
    pattern_scale,
    blue_first,
    absorption,
    receives
});

pub const NO_TEXTURE: u32 = u32::MAX;

/// Materials that a scene may have: the uniform array's length.
pub const MAX_MATERIALS: usize = 512;

impl GpuMaterial {
    pub fn new(material: &Material, textures: &[crate::caster::Texture]) -> Self {
        let texture = material.texture.map(|index| (index, &textures[index as usize]));
        Self {
            tint: material.tint,
            emission: material.emission,
            transmission: material.transmission,
            transfer: material.transfer as u32,
            shape: material.shape as u32,
            profile: material.profile as u32,
            texture: texture.map_or(NO_TEXTURE, |(index, _)| index),
            texture_size: texture
                .map_or(Vec2::ONE, |(_, t)| Vec2::new(t.width as f32, t.height as f32)),
            reflectivity: material.reflectivity,
            cutoff: material.cutoff,
            roughness: material.roughness,
            pattern: material.pattern as u32,
            pattern_scale: material.pattern_scale,
            blue_first: 0,
            absorption: Vec3::ZERO,
            receives: material.receives as u32,
        }
    }
}
