//! Light that lit surfaces scatter, as points that send it on.
use super::{GlassFace, GpuLight, linear_from_srgb};
use crate::model::{Casters, Class, Material, Texture, Transfer, Triangle};
use glam::{Vec2, Vec3, Vec4};

/// Vectors of a point that sends light on: its position, world space \[m\], and the squared radius of its
/// disc \[m^2\]; its normal; the light that it sends, over pi. WGSL: `wgsl/records/bounce.wgsl`.
pub const BOUNCE_VECTORS: u32 = 3;
/// Samples of a point's part of the map, along its edge. WGSL: `wgsl/caustics/bounce_light.wgsl`.
pub const BOUNCE_SAMPLES: u32 = 4;
/// Vectors of all such points, after the head: the bits of their number, and zeros.
pub const BOUNCE_LENGTH: u32 = BOUNCE_VECTORS * crate::model::MAX_BOUNCES + 1;

crate::records::gpu_struct! {
    /// WGSL: `wgsl/records/bounce.wgsl`.
    pub struct BounceParams {
        pub light: GpuLight,
        /// Number of the view's first point.
        pub first: u32,
        /// Points along an edge of the map.
        pub edge: u32,
        pub pad_0: u32,
        pub pad_1: u32,
    }
}

/// Opaque triangles that send light on, in the order of the triangles. The last numbers of their normals are
/// their albedos.
pub fn solid_faces(casters: &Casters<'_>) -> Vec<GlassFace> {
    let sends: Vec<bool> = casters.materials.iter().map(is_solid).collect();
    let face = |triangle: &Triangle| {
        let material = &casters.materials[triangle.material as usize];
        let albedo = mean_albedo(triangle, material, casters.textures);
        let normals = [0, 1, 2].map(|i| triangle.normals[i].extend(albedo[i]));
        GlassFace { corners: triangle.positions.map(|corner| corner.extend(0.0)), normals }
    };
    casters.triangles.iter().filter(|it| sends[it.material as usize]).map(face).collect()
}

fn is_solid(material: &Material) -> bool {
    material.transfer == Transfer::Opaque && Class::BLOCKING.contains(&Class::of(material))
}

/// Share of the light that a triangle scatters, without what metal mirrors: its mean over points of the
/// triangle.
fn mean_albedo(triangle: &Triangle, material: &Material, textures: &[Texture]) -> Vec3 {
    /// Points along an edge.
    const EDGE: usize = 7;
    let own = material.tint.truncate() * (1.0 - material.metallic);
    let texture = material.texture.and_then(|index| textures.get(index as usize));
    if texture.is_none() && !triangle.is_colored() {
        return own;
    }
    let colors = triangle.colors.map(|color| {
        let [r, g, b, _] = color.0.map(|value| f32::from(value) / 255.0);
        Vec3::new(r * r, g * g, b * b)
    });
    let mut sum = Vec3::ZERO;
    let mut count = 0;
    for i in 0..EDGE {
        for k in 0..EDGE - i {
            // Middles of small triangles along the edges.
            let [second, third] = [i, k].map(|it| (it as f32 + 1.0 / 3.0) / EDGE as f32);
            let weights = [1.0 - second - third, second, third];
            let mixed = |values: [Vec3; 3]| {
                values.into_iter().zip(weights).map(|(value, weight)| value * weight).sum::<Vec3>()
            };
            let uv = mixed(triangle.uvs.map(|uv| uv.extend(0.0))).truncate();
            sum += mixed(colors) * texture.map_or(Vec3::ONE, |texture| color_at(texture, uv));
            count += 1;
        }
    }
    own * sum / count as f32
}

/// Colour of the texel at a point of a repeating image.
fn color_at(texture: &Texture, uv: Vec2) -> Vec3 {
    let size = glam::UVec2::new(texture.width, texture.height);
    let at = ((uv - uv.floor()) * size.as_vec2()).as_uvec2().min(size - 1);
    let first = 4 * (at.y as usize * size.x as usize + at.x as usize);
    let byte = |i: usize| texture.rgba.get(first + i).copied().unwrap_or_default();
    Vec3::from_array([0, 1, 2].map(|i| linear_from_srgb(byte(i))))
}

/// Albedo of a face of [`solid_faces`].
pub fn albedo_of(face: &GlassFace) -> Vec3 {
    Vec3::from_array(face.normals.map(|normal: Vec4| normal.w))
}
