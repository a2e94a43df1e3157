//! Tables of lights and their shadows in the scene file's own names, units and spellings, not validated yet.
use super::numbers::exactly;
use serde::Deserialize;
use toml::Spanned;

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum KindOfLight {
    Directional,
    Spot,
    Point,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LightTable {
    pub name: Option<String>,
    pub kind: KindOfLight,
    #[serde(default, deserialize_with = "exactly")]
    pub position: Option<[f32; 3]>,
    #[serde(default, deserialize_with = "exactly")]
    pub direction: Option<[f32; 3]>,
    /// Opening angle of the whole cone [degrees].
    pub angle: Option<f32>,
    #[serde(default, deserialize_with = "exactly")]
    pub color: Option<[f32; 3]>,
    pub intensity: Option<f32>,
    pub cascades: Option<u32>,
    pub shafts: Option<bool>,
    pub lambda: Option<f32>,
    pub fade: Option<f32>,
    pub range: Option<f32>,
    pub near: Option<f32>,
    pub far: Option<f32>,
    pub size: Option<u32>,
    pub casts: Option<bool>,
    pub source: Option<Spanned<SourceTable>>,
    pub filter: Option<Spanned<FilterTable>>,
    /// Depth bias [m].
    pub bias: Option<f32>,
    /// Slope-scaled bias [texels].
    pub slope_bias: Option<f32>,
    /// Normal offset [texels].
    pub normal_bias: Option<f32>,
    /// Further shadows.
    #[serde(default)]
    pub shadow: Vec<Spanned<LightShadowTable>>,
}

/// Shadow filter: the texels around a receiver that are compared.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum FilterTable {
    None,
    Bilinear,
    Spline,
    /// Bilinear taps per side.
    Pcf {
        #[serde(default = "usual_edge")]
        taps: u32,
    },
    Vogel {
        #[serde(default = "usual_taps")]
        taps: u32,
        /// Radius of the disc [texels].
        #[serde(default = "usual_radius")]
        radius: f32,
    },
}

fn usual_edge() -> u32 {
    5
}

fn usual_taps() -> u32 {
    16
}

fn usual_radius() -> f32 {
    2.5
}

/// Area of a light: the surface that its rays leave.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum SourceTable {
    /// A sphere; radius [m].
    Sphere { radius: f32 },
    /// A disc; radius [m].
    Disc { radius: f32 },
    /// A rectangle; edges [m].
    Rect { width: f32, height: f32 },
    /// Angular diameter of the sun [degrees].
    Sun {
        #[serde(default = "angle_of_the_sun")]
        angle: f32,
    },
}

fn angle_of_the_sun() -> f32 {
    0.53
}

/// A further shadow of a light; position and direction default to the light's.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LightShadowTable {
    pub kind: Option<KindOfLight>,
    #[serde(default, deserialize_with = "exactly")]
    pub position: Option<[f32; 3]>,
    #[serde(default, deserialize_with = "exactly")]
    pub direction: Option<[f32; 3]>,
    /// Opening angle of the whole cone [degrees].
    pub angle: Option<f32>,
    pub cascades: Option<u32>,
    pub lambda: Option<f32>,
    pub fade: Option<f32>,
    pub range: Option<f32>,
    pub near: Option<f32>,
    pub far: Option<f32>,
    pub size: Option<u32>,
}
