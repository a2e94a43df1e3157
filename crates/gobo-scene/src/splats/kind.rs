//! Kinds of splat files.
/// Kind of a splat file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SplatKind {
    /// PLY with a row per splat.
    Ply,
    /// PLY of `PlayCanvas`, in chunks of 256 splats.
    Packed,
    /// Records of 32 bytes without a header.
    Bare,
    /// SPZ.
    Spz,
    /// SOG in a zip.
    Sog,
    /// The `meta.json` of a SOG in a folder.
    SogFolder,
    /// The `lod-meta.json` of a streamed SOG.
    SogLevels,
    /// `.ksplat` of mkkellogg.
    Ksplat,
}

impl SplatKind {
    /// Whether y points down in most files of the kind: in the scenes of 3D Gaussian splatting, which
    /// inherited the axes of photogrammetry. `PlayCanvas` writes SOG with the axes of the PLY that it is made
    /// from.
    pub(crate) fn points_down(self) -> bool {
        self != Self::Spz
    }
}
