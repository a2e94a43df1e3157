//! Animation tables of a scene file, not validated yet.
use super::{
    numbers::{array, exactly},
    track::Mode,
};
use crate::model::emitter::EmitterShape;
use serde::{
    Deserialize, Deserializer,
    de::{SeqAccess, value::SeqAccessDeserializer},
};
use toml::Spanned;

/// A colour, or one number for all channels.
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

/// Keys of one animated value.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AnimateTable {
    /// Animated value, such as `camera.eye`.
    pub target: String,
    /// Times of the keys [s].
    pub times: Vec<f32>,
    pub values: Vec<Key>,
    pub mode: Option<Mode>,
}

/// One number, or several.
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

/// A particle emitter.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EmitterTable {
    pub material: String,
    /// Particles emitted per second [1/s].
    pub rate: f32,
    /// Lifetime, or the shortest and the longest [s].
    pub lifetime: Key,
    pub seed: Option<u32>,
    /// Time of the first particle [s].
    pub start: Option<f32>,
    /// Time after which no particle starts [s].
    pub stop: Option<f32>,
    pub shape: Option<EmitterShape>,
    #[serde(default, deserialize_with = "exactly")]
    pub position: Option<[f32; 3]>,
    #[serde(default, deserialize_with = "exactly")]
    pub extent: Option<[f32; 3]>,
    /// Rows of seconds and an offset x, y, z.
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
    pub fluid: Option<Spanned<FluidTable>>,
    pub bounce: Option<f32>,
    pub slide: Option<f32>,
    /// Values over a particle's life; so are the following.
    pub radius: Option<Vec<f32>>,
    pub color: Option<Vec<Shades>>,
    pub alpha: Option<Vec<f32>>,
}

/// Fluid of an emitter's particles.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FluidTable {
    /// [m]
    pub spacing: f32,
    /// [m]
    pub reach: Option<f32>,
    /// [m^2/s^2]
    pub stiffness: Option<f32>,
    /// [m^2/s]
    pub viscosity: Option<f32>,
}

/// Corners of a collision box [m].
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BoxTable {
    #[serde(deserialize_with = "array")]
    pub min: [f32; 3],
    #[serde(deserialize_with = "array")]
    pub max: [f32; 3],
}
