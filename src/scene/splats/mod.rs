//! Files of anisotropic Gaussians (splats), recognised by their contents.
//!
//! | file | coordinates | opacity | scale |
//! |---|---|---|---|
//! | `.ply` of 3D Gaussian splatting (Kerbl et al. 2023) | as they are: the format has none | logit | logarithm |
//! | `.compressed.ply` (PlayCanvas) | as they are, like the `.ply` that it was made from | 8 bits | logarithm |
//! | `.splat` | as they are | 8 bits | plain |
//! | `.spz` 1 to 4 (Niantic) | x right, y up, z back, as here | 8 bits | logarithm |
//! | `.sog` 2 (PlayCanvas) | x right, y up, z back, as here | 8 bits | logarithm |
//! | `KHR_gaussian_splatting` in glTF | glTF's, as here | plain | plain; logarithm in drafts |
//! | `.ply` of volumetric primitives (Condor et al. 2024) | as they are | extinction | logarithm |
mod bare;
mod cloud;
mod packed;
mod place;
mod ply;
mod sog;
mod spz;
mod write_ply;
mod write_spz;

use super::{SceneError, gltf_splats, read};
use std::path::Path;

pub use cloud::Cloud;
pub(super) use place::placed;
pub use write_ply::to_ply;
pub use write_spz::to_spz;

/// The problem and the remedy.
pub type Fault = (String, &'static str);

/// Degree-0 spherical harmonic, `1 / (2 sqrt(pi))`: colour = 0.5 + this * coefficient (Kerbl et al. 2023).
pub(super) const HARMONIC: f32 = 0.282_094_8;

/// Head by which a kind is recognised: longer than the header of any PLY [bytes].
const LONGEST_HEAD: u64 = 1 << 16;

/// Kind of a file of splats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// PLY with a row per splat.
    Ply,
    /// PLY of PlayCanvas, in chunks of 256 splats.
    Packed,
    /// Records of 32 bytes without a header.
    Bare,
    /// SPZ.
    Spz,
    /// SOG.
    Sog,
}

/// Kind of splats in the bytes of a file; `None` if they are none, or glTF.
pub fn kind_of(bytes: &[u8]) -> Option<Kind> {
    if bytes.starts_with(b"ply") {
        return ply::kind_of(bytes);
    }
    if spz::is_spz(bytes) {
        return Some(Kind::Spz);
    }
    if bytes.starts_with(b"PK\x03\x04") {
        return Some(Kind::Sog);
    }
    bare::is_bare(bytes).then_some(Kind::Bare)
}

impl Kind {
    /// Whether y points down in most files of the kind: in the scenes of 3D Gaussian splatting, which took over
    /// the axes of photogrammetry.
    pub(super) fn points_down(self) -> bool {
        matches!(self, Self::Ply | Self::Packed | Self::Bare)
    }
}

/// Reads a file of any kind. World space = the file's space.
pub fn load(path: &Path) -> Result<Cloud, SceneError> {
    let bytes = read::bytes(path)?;
    let Some(kind) = kind_of(&bytes) else {
        if is_gltf(&bytes) {
            return gltf_splats::read(path);
        }
        let message = "holds no splats of a known kind";
        let help = "splats are a .ply, .splat, .spz, .sog, .glb or .gltf file";
        return Err(SceneError::invalid(path, message, help));
    };
    read_kind(kind, &bytes).map_err(|(message, help)| SceneError::invalid(path, message, help))
}

/// Kind of splats in a file, by its head; `None` if they are none, or glTF, or the file cannot be read.
pub(super) fn kind_of_file(path: &Path) -> Option<Kind> {
    let (head, length) = read::head(path, LONGEST_HEAD).ok()?;
    // A file without a header is also recognised by its length.
    kind_of(&head).filter(|&kind| kind != Kind::Bare || bare::is_whole(length))
}

/// Whether the bytes are those of a glTF file, of any contents.
fn is_gltf(bytes: &[u8]) -> bool {
    bytes.starts_with(b"glTF") || bytes.trim_ascii_start().starts_with(b"{")
}

/// Reads the bytes of a file of a kind.
pub fn read_kind(kind: Kind, bytes: &[u8]) -> Result<Cloud, Fault> {
    match kind {
        Kind::Ply => ply::read(bytes),
        Kind::Packed => packed::read(bytes),
        Kind::Bare => bare::read(bytes),
        Kind::Spz => spz::read(bytes),
        Kind::Sog => sog::read(bytes),
    }
}

/// Number `i` of little-endian numbers; the caller checked the length.
fn word(bytes: &[u8], i: usize) -> [u8; 4] {
    std::array::from_fn(|byte| bytes[4 * i + byte])
}
