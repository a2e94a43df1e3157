//! Materials in the format of the page's passes.
use bytemuck::{Pod, Zeroable};
use gobo::{Material, Shape, Transfer, model::Profile};

/// WGSL: `Look` of `wgsl/frame.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Look {
    tint: [f32; 4],
    emission: [f32; 3],
    transmission: f32,
    absorption: [f32; 3],
    roughness: f32,
    metallic: f32,
    reflectivity: f32,
    cutoff: f32,
    flags: u32,
    transfer: u32,
    pad: [u32; 3],
}

const UNLIT: u32 = 1;
const PUFF: u32 = 2;
const SOFT: u32 = 4;
const SQUARE: u32 = 8;
const CUTOUT: u32 = 16;
const DITHER: u32 = 32;
const MEDIUM: u32 = 64;

/// Kind of drawing of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Class {
    /// Hides its background.
    Solid,
    /// Filters its background.
    Pane,
    /// Covers its background.
    Cover,
}

impl Class {
    pub(crate) fn of(material: &Material) -> Self {
        match material.transfer {
            transfer if transfer.is_opaque() => Self::Solid,
            Transfer::Over | Transfer::Smoke => Self::Cover,
            _ => Self::Pane,
        }
    }
}

impl Look {
    pub(crate) fn new(material: &Material) -> Self {
        let flags = [
            (material.unlit, UNLIT),
            (material.shape == Shape::Puff, PUFF),
            (material.profile == Profile::Soft, SOFT),
            (material.shape == Shape::Quad, SQUARE),
            (material.transfer == Transfer::Cutout, CUTOUT),
            (material.transfer == Transfer::Dither, DITHER),
            (material.is_medium(), MEDIUM),
        ];
        Self {
            tint: material.tint.to_array(),
            emission: material.emission.to_array(),
            transmission: material.transmission,
            absorption: material.absorption().to_array(),
            roughness: material.roughness,
            metallic: material.metallic,
            reflectivity: material.reflectivity,
            cutoff: material.cutoff,
            flags: flags.iter().filter(|(is_so, _)| *is_so).map(|(_, flag)| flag).sum(),
            transfer: match material.transfer {
                Transfer::Stain => 1,
                Transfer::Smoke => 2,
                Transfer::Over => 3,
                Transfer::Gain => 4,
                Transfer::None => 5,
                _ => 0,
            },
            pad: [0; 3],
        }
    }
}
