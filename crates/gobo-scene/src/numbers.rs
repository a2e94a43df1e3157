//! Arrays of numbers in scene files.
use serde::{Deserialize, Deserializer, de::Error};

/// Deserializes an array of N numbers: serde's own takes the first N of a longer one.
pub(super) fn array<'de, D, T, const N: usize>(deserializer: D) -> Result<[T; N], D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    exactly(Vec::deserialize(deserializer)?)
}

pub(super) fn exactly<E: Error, T, const N: usize>(values: Vec<T>) -> Result<[T; N], E> {
    let count = values.len();
    let message = || format!("expected an array of {N} numbers, found one of {count}");
    values.try_into().map_err(|_| E::custom(message()))
}
