//! Writes SPZ version 3.
use super::{
    Harmonics,
    cloud::HARMONIC,
    harmonics::degree_of,
    spz::{COLOR_SCALE, SH_STEPS, SH_ZERO},
};
use flate2::{Compression, write::GzEncoder};
use glam::Vec3;
use gobo::model::Gaussian;
use std::io::{self, Write as _};

const VERSION: u32 = 3;

/// Most fractional bits of a coordinate.
const MAX_FRACTION: u32 = 20;

/// Largest number of 23 bits and a sign.
const MOST: f32 = 8_388_607.0;

/// The splats as SPZ. `colors`: one per splat; SPZ can hold -0.44 to 1.44. `harmonics`: of each splat, or
/// none; SPZ can hold -1 to 0.99.
pub fn to_spz(splats: &[Gaussian], colors: &[Vec3], harmonics: &Harmonics) -> io::Result<Vec<u8>> {
    let farthest = splats.iter().fold(0.0, |most: f32, s| most.max(s.center.abs().max_element()));
    // As fine as the farthest centre allows.
    let fraction = (0..=MAX_FRACTION).rev().find(|&bits| farthest * (1 << bits) as f32 <= MOST);
    let Some(fraction) = fraction else {
        let message = format!("SPZ holds coordinates up to {MOST}, and a centre is at {farthest}");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    };
    let Some(degree) = degree_of(harmonics.count) else {
        let message = "the harmonics are of no degree";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    };
    let mut file = GzEncoder::new(Vec::new(), Compression::default());
    file.write_all(b"NGSP")?;
    file.write_all(&VERSION.to_le_bytes())?;
    file.write_all(&(splats.len() as u32).to_le_bytes())?;
    file.write_all(&[degree, fraction as u8, 0, 0])?;
    for splat in splats {
        for part in splat.center.to_array() {
            let fixed = (part * (1 << fraction) as f32).round() as i32;
            file.write_all(&fixed.to_le_bytes()[..3])?;
        }
    }
    let byte = |share: f32| share.round().clamp(0.0, 255.0) as u8;
    for splat in splats {
        file.write_all(&[byte(splat.opacity * 255.0)])?;
    }
    for color in colors {
        let coded = color.map(|c| ((c - 0.5) / HARMONIC * COLOR_SCALE + 0.5) * 255.0);
        file.write_all(&coded.to_array().map(byte))?;
    }
    for splat in splats {
        let coded = splat.sigma.map(|sigma| (sigma.ln() + 10.0) * 16.0);
        file.write_all(&coded.to_array().map(byte))?;
    }
    for splat in splats {
        file.write_all(&rotation(splat).to_le_bytes())?;
    }
    for coefficients in &harmonics.coefficients {
        file.write_all(&coefficients.map(|c| byte(c * SH_STEPS + SH_ZERO)))?;
    }
    file.finish()
}

/// Index of the largest part of x y z w, then the others, a sign and nine bits each, the last one lowest.
fn rotation(splat: &Gaussian) -> u32 {
    let parts = splat.rotation.to_array();
    let larger = |a: usize, b: usize| if parts[b].abs() > parts[a].abs() { b } else { a };
    let largest = (1..4).fold(0, larger);
    let mut word = largest as u32;
    for (_, part) in parts.into_iter().enumerate().filter(|&(i, _)| i != largest) {
        let sign = (part < 0.0) != (parts[largest] < 0.0);
        let size = (part.abs() * std::f32::consts::SQRT_2 * 511.0).round().min(511.0) as u32;
        word = word << 10 | u32::from(sign) << 9 | size;
    }
    word
}
