//! Values with several spellings.
use crate::{noise::Noise, numbers::exactly};
use serde::{
    Deserialize, Deserializer,
    de::{
        MapAccess, SeqAccess,
        value::{MapAccessDeserializer, SeqAccessDeserializer},
    },
};
use std::path::PathBuf;

/// Source of a texture: a file, or generated.
#[derive(Clone, Debug)]
pub(crate) enum TextureSource {
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

/// One number, or a list of them.
#[derive(Clone, Debug)]
pub(crate) struct Numbers {
    pub values: Vec<f32>,
    pub(super) is_list: bool,
}

impl<'de> Deserialize<'de> for Numbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = Numbers;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("f32")
            }

            fn visit_f64<E>(self, value: f64) -> Result<Numbers, E> {
                Ok(Numbers { values: vec![value as f32], is_list: false })
            }

            fn visit_i64<E>(self, value: i64) -> Result<Numbers, E> {
                Ok(Numbers { values: vec![value as f32], is_list: false })
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Numbers, A::Error> {
                let values = Vec::deserialize(SeqAccessDeserializer::new(list))?;
                Ok(Numbers { values, is_list: true })
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// A colour, or one number for all channels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shades(pub [f32; 3]);

impl<'de> Deserialize<'de> for Shades {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Numbers { values, is_list } = Numbers::deserialize(deserializer)?;
        let values = if is_list { values } else { values.repeat(3) };
        exactly(values).map(Self)
    }
}
