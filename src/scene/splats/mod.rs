//! Files of anisotropic Gaussians (splats), recognised by their contents.
//!
//! | file | coordinates | opacity | scale |
//! |---|---|---|---|
//! | `.ply` of 3D Gaussian splatting (Kerbl et al. 2023) | as they are: the format has none | logit | logarithm |
//! | `.compressed.ply` (`PlayCanvas`) | as they are, like the `.ply` that it was made from | 8 bits | logarithm |
//! | `.splat` | as they are | 8 bits | plain |
//! | `.spz` 1 to 4 (Niantic) | x right, y up, z back, as here | 8 bits | logarithm |
//! | `.sog` 2 (`PlayCanvas`) | x right, y up, z back, as here | 8 bits | logarithm |
//! | `KHR_gaussian_splatting` in glTF | glTF's, as here | plain | plain; logarithm in drafts |
//! | `.ply` of volumetric primitives (Condor et al. 2024) | as they are | extinction | logarithm |
mod bare;
mod cloud;
mod kind;
mod packed;
mod place;
mod ply;
mod sog;
mod spz;
mod write_ply;
mod write_spz;

pub(super) use bare::is_whole;
pub(super) use cloud::HARMONIC;
pub use cloud::{Cloud, Fault, valid};
pub use kind::Kind;
pub(super) use place::placed;
pub use write_ply::to_ply;
pub use write_spz::to_spz;

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
