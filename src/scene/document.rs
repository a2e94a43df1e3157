//! Tables of the scene file in its own names, units and spellings, not validated yet.
use crate::{
    model::{Pattern, Profile, Receiver, Receives, Shape, Transfer},
    scene::{
        displace::Displace,
        document_lights::{FilterTable, LightTable},
        document_motion::{AnimateTable, EmitterTable, Shades},
        generate::Generate,
        noise::Noise,
        numbers::{array, exactly},
        shapes::KindOfShape,
    },
};
use serde::{
    Deserialize, Deserializer,
    de::{MapAccess, value::MapAccessDeserializer},
};
use std::path::PathBuf;
use toml::Spanned;

/// The whole file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Document {
    pub camera: Option<Spanned<CameraTable>>,
    #[serde(default)]
    pub shadow: Option<Spanned<ShadowTable>>,
    pub clusters: Option<Spanned<ClustersTable>>,
    pub mask: Option<Spanned<MaskTable>>,
    pub environment: Option<Spanned<EnvironmentTable>>,
    pub air: Option<Spanned<AirTable>>,
    #[serde(default)]
    pub light: Vec<Spanned<LightTable>>,
    #[serde(default)]
    pub material: Vec<Spanned<MaterialTable>>,
    #[serde(default)]
    pub particles: Vec<Spanned<ParticlesTable>>,
    #[serde(default)]
    pub shape: Vec<Spanned<ShapeTable>>,
    #[serde(default)]
    pub mesh: Vec<Spanned<MeshTable>>,
    #[serde(default)]
    pub animate: Vec<Spanned<AnimateTable>>,
    #[serde(default)]
    pub emitter: Vec<Spanned<EmitterTable>>,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraTable {
    #[serde(default, deserialize_with = "exactly")]
    pub eye: Option<[f32; 3]>,
    #[serde(default, deserialize_with = "exactly")]
    pub target: Option<[f32; 3]>,
    #[serde(default, deserialize_with = "exactly")]
    pub up: Option<[f32; 3]>,
    /// Vertical field of view [degrees].
    pub fov_y: Option<f32>,
    /// Size of the picture [pixels].
    #[serde(default, deserialize_with = "exactly")]
    pub size: Option<[u32; 2]>,
    /// Exposure [stops].
    pub exposure: Option<f32>,
    /// Samples per pixel.
    pub samples: Option<u32>,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ShadowTable {
    pub size: Option<u32>,
    pub receiver: Option<Receiver>,
    pub nodes: Option<u32>,
    pub filter: Option<Spanned<FilterTable>>,
    /// Depth bias [m].
    pub bias: Option<f32>,
    /// Slope-scaled bias [texels].
    pub slope_bias: Option<f32>,
    /// Normal offset [texels].
    pub normal_bias: Option<f32>,
    pub pair_budget: Option<u32>,
    pub texel_budget: Option<u64>,
    pub soften: Option<bool>,
    pub colored: Option<bool>,
    /// [texels]
    pub blur: Option<u32>,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ClustersTable {
    /// Edge of a cluster [pixels].
    pub tile: Option<u32>,
    pub slices: Option<u32>,
    /// End of the first slice [m].
    pub near: Option<f32>,
    pub budget: Option<u32>,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaskTable {
    pub half: Option<bool>,
    pub taps: Option<u32>,
    /// Distance of the full blur width [m].
    pub depth_scale: Option<f32>,
    pub anisotropic: Option<bool>,
    pub sensitivity: Option<f32>,
    pub limit: Option<u32>,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EnvironmentTable {
    #[serde(default, deserialize_with = "exactly")]
    pub ambient: Option<[f32; 3]>,
    #[serde(default, deserialize_with = "exactly")]
    pub background: Option<[f32; 3]>,
    #[serde(default, deserialize_with = "exactly")]
    pub zenith: Option<[f32; 3]>,
    #[serde(default, deserialize_with = "exactly")]
    pub horizon: Option<[f32; 3]>,
    #[serde(default, deserialize_with = "exactly")]
    pub ground: Option<[f32; 3]>,
    pub sun: Option<Spanned<SunTable>>,
    pub file: Option<PathBuf>,
    /// Rotation about +y [degrees].
    pub rotation: Option<f32>,
    pub intensity: Option<f32>,
}

/// A sun disc in the sky.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SunTable {
    #[serde(deserialize_with = "array")]
    pub direction: [f32; 3],
    #[serde(default, deserialize_with = "exactly")]
    pub color: Option<[f32; 3]>,
    /// Angular diameter [degrees].
    pub angle: Option<f32>,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AirTable {
    /// Extinction coefficient of the density [1/m].
    pub density: Option<f32>,
    #[serde(default, deserialize_with = "exactly")]
    pub albedo: Option<[f32; 3]>,
    /// Scattering coefficient [1/m].
    pub scattering: Option<Shades>,
    /// Extinction coefficient [1/m].
    pub extinction: Option<Shades>,
    pub ambient: Option<f32>,
    pub anisotropy: Option<f32>,
    pub steps: Option<u32>,
}

/// Source of a texture: a file, or generated.
#[derive(Clone, Debug)]
pub(super) enum TextureSource {
    File(PathBuf),
    Noise(Noise),
}

impl<'de> Deserialize<'de> for TextureSource {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = TextureSource;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("the path of an image, or a table such as { generate = \"noise\" }")
            }

            fn visit_str<E>(self, path: &str) -> Result<TextureSource, E> {
                Ok(TextureSource::File(path.into()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<TextureSource, A::Error> {
                Noise::deserialize(MapAccessDeserializer::new(map)).map(TextureSource::Noise)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialTable {
    pub name: String,
    pub transfer: Option<Transfer>,
    pub shape: Option<Shape>,
    pub profile: Option<Profile>,
    #[serde(default, deserialize_with = "exactly")]
    pub tint: Option<[f32; 4]>,
    /// Radius of particles whose file has none [m].
    pub radius: Option<f32>,
    pub reflectivity: Option<f32>,
    pub texture: Option<TextureSource>,
    pub cutoff: Option<f32>,
    pub pattern: Option<Pattern>,
    /// Edge of a pattern's cells [texels].
    pub scale: Option<u32>,
    #[serde(default, deserialize_with = "exactly")]
    pub emission: Option<[f32; 3]>,
    pub transmission: Option<f32>,
    pub roughness: Option<f32>,
    pub metallic: Option<f32>,
    #[serde(default, deserialize_with = "exactly")]
    pub attenuation_color: Option<[f32; 3]>,
    /// Distance of `attenuation_color` [m].
    pub attenuation_distance: Option<f32>,
    pub receives: Option<Receives>,
    pub visible: Option<bool>,
    pub casts: Option<bool>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ParticlesTable {
    pub file: Option<PathBuf>,
    pub generate: Option<Generate>,
    pub material: String,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ShapeTable {
    /// Name for keys.
    pub name: Option<String>,
    pub kind: KindOfShape,
    pub material: String,
    /// Subdivisions of a sphere.
    pub level: Option<u32>,
    /// Displacement, for spheres only.
    pub displace: Option<Displace>,
    #[serde(default, deserialize_with = "exactly")]
    pub translation: Option<[f32; 3]>,
    /// Euler xyz [degrees].
    #[serde(default, deserialize_with = "exactly")]
    pub rotation: Option<[f32; 3]>,
    #[serde(default, deserialize_with = "exactly")]
    pub scale: Option<[f32; 3]>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshTable {
    /// Name for keys.
    pub name: Option<String>,
    pub file: PathBuf,
    pub casts: Option<bool>,
    #[serde(default, deserialize_with = "exactly")]
    pub translation: Option<[f32; 3]>,
    /// Euler xyz [degrees].
    #[serde(default, deserialize_with = "exactly")]
    pub rotation: Option<[f32; 3]>,
    #[serde(default, deserialize_with = "exactly")]
    pub scale: Option<[f32; 3]>,
}
