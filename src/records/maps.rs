//! Maps and pictures on the host, read back from the device.
use super::{CurveMap, caustic_light};
use crate::model::View;
use glam::UVec2;

/// The maps of one view, read back. Texel `(x, y)` is at `y * size.x + x`; row 0 is the top.
#[derive(Clone, Debug)]
pub struct ViewMaps {
    /// The view of the maps.
    pub view: View,
    /// `F`: product of the transmittances in front of the opaque surface, linear rgb.
    pub filter: Vec<[f32; 3]>,
    /// `D`: light depth of the nearest translucent hit, 1 where there is none.
    pub nearest: Vec<f32>,
    /// `Z`: light depth of the nearest opaque surface, 1 where there is none.
    pub opaque: Vec<f32>,
    /// `Z` per channel with coloured dithering; else empty. `opaque` is the largest of the three.
    pub colored: Vec<[f32; 3]>,
    /// Transmittance curves, in curve mode.
    pub curve: Option<CurveMap>,
    /// Sums over the casters, from which `filter` and `nearest` are resolved, if requested; else empty.
    /// Optical depth per channel in fixed point, and nearness of the nearest hit: see
    /// [`crate::records::added`].
    pub sums: Vec<[u32; 4]>,
    /// Light that glass throws onto opaque surfaces, in fixed point: see [`Self::thrown_light`]. Empty
    /// without [`Light::caustics`](crate::Light::caustics).
    pub caustics: Vec<[u32; 4]>,
    /// Owner tag of the caster that wrote `nearest`, see [`crate::records::owner_tag`]; empty if no receiver
    /// reads it.
    pub owner: Vec<u16>,
}

impl ViewMaps {
    /// Light that lands in each texel: linear rgb as a share of the light sent to a texel, and 1 where the
    /// texel's own light was thrown elsewhere, else 0. Empty without
    /// [`Light::caustics`](crate::Light::caustics).
    pub fn thrown_light(&self) -> Vec<[f32; 4]> {
        self.caustics.iter().map(|&texel| caustic_light(texel).into()).collect()
    }
}

/// The lit picture.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Width and height \[pixels\].
    pub size: UVec2,
    /// sRGB, rows from the top.
    pub rgb: Vec<[u8; 3]>,
    /// Linear light before exposure and tone curve; empty for a debug picture.
    pub light: Vec<[f32; 3]>,
}
