//! Tables of a scene file that say what moves, as they are written: nothing checked yet.
use super::{
    document::{array, exactly},
    track::Mode,
};
use crate::model::emitter::Source;
use serde::{
    Deserialize, Deserializer,
    de::{SeqAccess, value::SeqAccessDeserializer},
};
use toml::Spanned;

/// One number for all channels, or one for each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shades(pub [f32; 3]);

impl<'de> Deserialize<'de> for Shades {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = Shades;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("f32")
            }

            fn visit_f64<E>(self, value: f64) -> Result<Shades, E> {
                Ok(Shades([value as f32; 3]))
            }

            fn visit_i64<E>(self, value: i64) -> Result<Shades, E> {
                Ok(Shades([value as f32; 3]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Shades, A::Error> {
                array(SeqAccessDeserializer::new(list)).map(Shades)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// Keys of one value.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AnimateTable {
    /// What they move: `camera.eye`.
    pub target: String,
    /// [s]
    pub times: Vec<f32>,
    pub values: Vec<Key>,
    pub mode: Option<Mode>,
}

/// A number, or several.
#[derive(Clone, Debug)]
pub(super) struct Key(pub Vec<f32>);

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = Key;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("f32")
            }

            fn visit_f64<E>(self, value: f64) -> Result<Key, E> {
                Ok(Key(vec![value as f32]))
            }

            fn visit_i64<E>(self, value: i64) -> Result<Key, E> {
                Ok(Key(vec![value as f32]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Key, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(list)).map(Key)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// What sends particles out.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EmitterTable {
    pub material: String,
    /// [1/s]
    pub rate: f32,
    /// One, or the shortest and the longest [s].
    pub lifetime: Key,
    pub seed: Option<u32>,
    /// [s]
    pub start: Option<f32>,
    /// [s]
    pub stop: Option<f32>,
    pub shape: Option<Source>,
    #[serde(default, deserialize_with = "exactly")]
    pub position: Option<[f32; 3]>,
    #[serde(default, deserialize_with = "exactly")]
    pub extent: Option<[f32; 3]>,
    /// Rows of seconds and x, y, z.
    #[serde(default)]
    pub path: Vec<Key>,
    #[serde(default, deserialize_with = "exactly")]
    pub velocity: Option<[f32; 3]>,
    pub spread: Option<f32>,
    pub gravity: Option<f32>,
    pub buoyancy: Option<f32>,
    pub drag: Option<f32>,
    #[serde(default, deserialize_with = "exactly")]
    pub wind: Option<[f32; 3]>,
    pub turbulence: Option<f32>,
    pub frequency: Option<f32>,
    pub evolve: Option<f32>,
    pub ground: Option<f32>,
    #[serde(default)]
    pub boxes: Vec<Spanned<BoxTable>>,
    pub bounce: Option<f32>,
    pub slide: Option<f32>,
    /// Over a particle's life, as those that follow.
    pub radius: Option<Vec<f32>>,
    pub color: Option<Vec<Shades>>,
    pub alpha: Option<Vec<f32>>,
}

/// Corners [m].
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BoxTable {
    #[serde(deserialize_with = "array")]
    pub min: [f32; 3],
    #[serde(deserialize_with = "array")]
    pub max: [f32; 3],
}
