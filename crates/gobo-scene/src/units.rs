//! Units and axes of files.
use glam::{DMat3, DVec3};
use serde::Deserialize;

/// The upward axis of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Up {
    Y,
    Z,
}

impl Up {
    /// Rotation from the file's axes to ours.
    pub(super) fn turn(self) -> DMat3 {
        match self {
            Self::Y => DMat3::IDENTITY,
            Self::Z => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
        }
    }
}

/// A unit of length \[m\] by its names in files.
pub(super) fn unit_named(name: &str) -> Option<f64> {
    Some(match name.trim().to_ascii_lowercase().as_str() {
        "m" | "meter" | "meters" | "metre" | "metres" => 1.0,
        "cm" | "centimeter" | "centimeters" => 1e-2,
        "mm" | "millimeter" | "millimeters" => 1e-3,
        "um" | "\u{b5}m" | "\u{3bc}m" | "\\u00b5m" | "micron" | "microns" | "micrometer" => 1e-6,
        "nm" | "nanometer" | "nanometers" => 1e-9,
        _ => return None,
    })
}
