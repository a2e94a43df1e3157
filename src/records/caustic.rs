//! Glass that refracts light, and the light that it throws, as kernels read and write them.
use crate::model::{Casters, Class, Fresnel};
use glam::{Vec3, Vec4};

/// A triangle of glass or water that refracts light, [`GLASS_VECTORS`] vectors. WGSL:
/// `wgsl/records/glass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct GlassFace {
    /// Corners, world space \[m\]; w of the first is the refractive index for green light, w of the second
    /// what is added to it for blue and taken away for red.
    pub corners: [Vec4; 3],
    /// Unit normals of the corners, world space; w is 0, or the albedo of a
    /// [solid face](super::solid_faces): red, green and blue.
    pub normals: [Vec4; 3],
}

/// Vectors of a [`GlassFace`].
pub const GLASS_VECTORS: u32 = 6;

/// Half the difference of the refractive indices at blue (486 nm) and red (656 nm), per index less 1 and per
/// unit of dispersion: the Abbe number is 20 over the dispersion (glTF `KHR_materials_dispersion`).
const SPREAD: f32 = 0.025;

/// All such faces, in the order of the triangles.
pub fn glass_faces(casters: &Casters<'_>) -> Vec<GlassFace> {
    let bends = |material: u32| {
        let material = &casters.materials[material as usize];
        let casts = Class::FILTERING.contains(&Class::of(material));
        match material.fresnel {
            Fresnel::Face { ior } if ior > 1.0 && casts => Some((ior, material.dispersion)),
            _ => None,
        }
    };
    let face = |triangle: &crate::model::Triangle| {
        let mut corners = triangle.positions.map(|corner| corner.extend(0.0));
        let (ior, dispersion) = bends(triangle.material)?;
        corners[0].w = ior;
        corners[1].w = (ior - 1.0) * (SPREAD * dispersion);
        Some(GlassFace { corners, normals: triangle.normals.map(|normal| normal.extend(0.0)) })
    };
    casters.triangles.iter().filter_map(face).collect()
}

/// Light that lands in a texel, as a share of a texel's own light: red, green and blue in fixed point, with
/// their carries in ten bits each of the last word; its highest bit is set where the texel's straight light
/// was thrown elsewhere.
pub type CausticTexel = [u32; 4];

/// Light of one texel.
pub const CAUSTIC_ONE: f32 = 65536.0;
/// Bits of a channel's carry.
pub const CARRY_BITS: u32 = 10;
/// Flag where a texel's light was thrown elsewhere.
pub const THROWN_BIT: u32 = 1 << 31;
/// No face.
pub const NO_FACE: u32 = u32::MAX;

/// Light in fixed point; `light`: in units of a texel's; `rest`: what rounding left of the light before, and
/// then of this.
pub fn caustic_words(light: Vec3, rest: &mut Vec3) -> [u32; 3] {
    let whole = light * CAUSTIC_ONE + *rest;
    let words = whole.to_array().map(|channel| channel as u32);
    *rest = whole - Vec3::from_array(words.map(|word| word as f32));
    words
}

/// Adds light in fixed point to a texel.
pub fn add_caustic(texel: &mut CausticTexel, light: [u32; 3]) {
    for (channel, added) in light.into_iter().enumerate() {
        let (sum, carries) = texel[channel].overflowing_add(added);
        texel[channel] = sum;
        texel[3] += u32::from(carries) << (CARRY_BITS * channel as u32);
    }
}

/// Light that lands in a texel, and 1 where the texel's own was thrown elsewhere, else 0.
pub fn caustic_light(texel: CausticTexel) -> Vec4 {
    let mask = (1 << CARRY_BITS) - 1;
    let channel = |i: usize| {
        let carries = texel[3] >> (CARRY_BITS * i as u32) & mask;
        texel[i] as f32 / CAUSTIC_ONE + carries as f32 * CAUSTIC_ONE
    };
    Vec4::new(channel(0), channel(1), channel(2), (texel[3] >> 31) as f32)
}
