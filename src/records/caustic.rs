//! Glass that refracts light, and the light that it throws, as kernels read and write them.
use crate::model::{Casters, Class, Fresnel};
use glam::{Vec3, Vec4};

/// A triangle of glass or water that refracts light, [`GLASS_VECTORS`] vectors. WGSL:
/// `wgsl/caustics/glass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct GlassFace {
    /// Corners, world space \[m\]; w of the first is the refractive index.
    pub corners: [Vec4; 3],
    /// Unit normals of the corners, world space.
    pub normals: [Vec4; 3],
}

/// Vectors of a [`GlassFace`].
pub const GLASS_VECTORS: u32 = 6;

/// All such faces, in the order of the triangles.
pub fn glass_faces(casters: &Casters<'_>) -> Vec<GlassFace> {
    let bends = |material: u32| {
        let material = &casters.materials[material as usize];
        let casts = Class::FILTERING.contains(&Class::of(material));
        match material.fresnel {
            Fresnel::Face { ior } if ior > 1.0 && casts => Some(ior),
            _ => None,
        }
    };
    let face = |triangle: &crate::model::Triangle| {
        let mut corners = triangle.positions.map(|corner| corner.extend(0.0));
        corners[0].w = bends(triangle.material)?;
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

/// Adds light to a texel; `light`: in units of a texel's.
pub fn add_caustic(texel: &mut CausticTexel, light: Vec3) {
    for (channel, light) in light.to_array().into_iter().enumerate() {
        let added = (light * CAUSTIC_ONE + 0.5) as u32;
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
