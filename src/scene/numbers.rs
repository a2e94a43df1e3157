//! Arrays of numbers in scene files.
use serde::{Deserialize, Deserializer, de::Error as _};

/// Deserializes an array of N numbers: serde's own takes the first N of a longer one.
pub(super) fn array<'de, D, T, const N: usize>(deserializer: D) -> Result<[T; N], D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    let values = Vec::<T>::deserialize(deserializer)?;
    let count = values.len();
    values.try_into().map_err(|_| {
        D::Error::custom(format!("expected an array of {N} numbers, found one of {count}"))
    })
}

pub(super) fn exactly<'de, D, T, const N: usize>(
    deserializer: D,
) -> Result<Option<[T; N]>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    array(deserializer).map(Some)
}
