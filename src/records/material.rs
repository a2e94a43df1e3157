//! Materials as kernels read them.
use crate::model::{Material, Texture};
use glam::{Vec2, Vec3, Vec4};

crate::records::gpu_struct! {
    /// A material as kernels read it. WGSL: `wgsl/records/material.wgsl`.
    pub struct GpuMaterial {
        /// Linear rgba.
        pub tint: Vec4,
        pub emission: Vec3,
        pub transmission: f32,
        pub transfer: u32,
        pub shape: u32,
        pub profile: u32,
        /// Layer of the texture array, [`NO_TEXTURE`] without a texture.
        pub texture: u32,
        /// Size of the texture within its layer \[texels\].
        pub texture_size: Vec2,
        pub reflectivity: f32,
        pub cutoff: f32,
        pub roughness: f32,
        pub pattern: u32,
        /// Edge of a cell of the pattern \[texels\].
        pub pattern_scale: u32,
        /// First texel of the blue-noise ranks in the particles' records.
        pub blue_first: u32,
        /// Absorption coefficient inside a closed mesh [1/m]; zero if it is no volume.
        pub absorption: Vec3,
        pub receives: u32,
        /// Size of the emissive texture within its layer \[texels\].
        pub emissive_size: Vec2,
        /// Layer of the texture array, [`NO_TEXTURE`] without a texture.
        pub emissive_texture: u32,
        pub metallic: f32,
        pub ior: f32,
        pub frost: f32,
        /// Refractive index of its faces, or minus that of its panes; 0 for no reflection.
        pub fresnel: f32,
        /// [`SHOWS_SURROUNDINGS`] and [`SHOWS_COLOR`]; from bit [`FAR_SIDE_SHIFT`] on the index of its far
        /// side's material plus 1, or 0.
        pub shows: u32,
    }
}

/// Number in place of a texture's index.
pub const NO_TEXTURE: u32 = u32::MAX;

/// Flag of [`GpuMaterial::shows`]: the surroundings behind it.
pub const SHOWS_SURROUNDINGS: u32 = 1;
/// Flag of [`GpuMaterial::shows`]: its own colour, whatever the light.
pub const SHOWS_COLOR: u32 = 2;
/// Number of flag bits in [`GpuMaterial::shows`].
pub const FAR_SIDE_SHIFT: u32 = 8;

/// Bits of flags and of a far side in [`GpuMaterial::shows`].
pub const DETAILS_SHIFT: u32 = 18;
const _: () = assert!((MAX_MATERIALS as u32) < 1 << (DETAILS_SHIFT - FAR_SIDE_SHIFT));

/// Most materials of a scene: the uniform array's length.
pub const MAX_MATERIALS: usize = 512;

impl GpuMaterial {
    /// The record of a material.
    pub fn new(material: &Material, textures: &[Texture]) -> Self {
        let select = |is: bool, flag: u32| if is { flag } else { 0 };
        let image = |index: Option<u32>| {
            let texture = index.map(|index| &textures[index as usize]);
            let size = texture.map_or(Vec2::ONE, |t| Vec2::new(t.width as f32, t.height as f32));
            (index.unwrap_or(NO_TEXTURE), size)
        };
        let (texture, texture_size) = image(material.texture);
        let (emissive_texture, emissive_size) = image(material.emissive_texture);
        Self {
            tint: material.tint,
            emission: material.emission,
            transmission: material.transmission,
            transfer: material.transfer as u32,
            shape: material.shape as u32,
            profile: material.profile as u32,
            texture,
            texture_size,
            reflectivity: material.reflectivity,
            cutoff: material.cutoff,
            roughness: material.roughness,
            pattern: material.pattern as u32,
            pattern_scale: material.pattern_scale,
            blue_first: 0,
            absorption: Vec3::ZERO,
            receives: material.receives as u32,
            emissive_size,
            emissive_texture,
            metallic: material.metallic,
            ior: material.ior,
            frost: material.frost,
            fresnel: material.fresnel.index(),
            shows: select(material.catcher, SHOWS_SURROUNDINGS)
                | select(material.unlit, SHOWS_COLOR)
                | material.far_side.map_or(0, |far| (far + 1) << FAR_SIDE_SHIFT)
                | material.details.map_or(0, |details| (details + 1) << DETAILS_SHIFT),
        }
    }
}
