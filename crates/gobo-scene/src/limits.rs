//! Limits of one scene, over all its tables and files together. Each limit is checked before memory is
//! allocated: a few bytes of input can announce gigabytes.
use super::SceneError;
use std::path::Path;

/// A kind of contents with a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limit {
    /// Lights of files and tables together.
    Lights,
    /// Viewpoints of area lights that cast shadows.
    Sources,
    /// Points of lights that surfaces send on: a uniform array on every device.
    Bounces,
    /// Materials: a uniform array on every device.
    Materials,
    /// Textures: layers of a texture array in WebGPU.
    Textures,
    /// Texels of all textures: 1 GiB.
    Texels,
    /// Particles, read or generated.
    Particles,
    /// Gaussians, read or generated.
    Splats,
    /// Triangles of shapes and meshes, including degenerate ones.
    Triangles,
    /// Bricks of 8^3 voxels of all volumes: 0.7 GiB.
    Bricks,
    /// Vertices of strands, read or generated.
    Capsules,
    /// Nodes of a glTF file; instances and primitives of each count too, and joints of its skin.
    Nodes,
    /// Bytes of a glTF file's decompressed meshes: 1 GiB.
    Unpacked,
    /// Keys of glTF animations; each channel counts its sampler's. Offsets of morph targets count too, as
    /// keys per triangle.
    Keys,
    /// Bytes of the scene file itself.
    Text,
}

impl Limit {
    /// All limits.
    pub const ALL: [Self; 15] = [
        Self::Lights,
        Self::Sources,
        Self::Bounces,
        Self::Materials,
        Self::Textures,
        Self::Texels,
        Self::Particles,
        Self::Splats,
        Self::Triangles,
        Self::Bricks,
        Self::Capsules,
        Self::Nodes,
        Self::Unpacked,
        Self::Keys,
        Self::Text,
    ];

    /// The limit.
    pub const fn most(self) -> u64 {
        match self {
            Self::Lights => gobo::records::MAX_LIGHTS as u64,
            Self::Sources => gobo::records::MAX_AREAS as u64,
            Self::Bounces => gobo::model::MAX_BOUNCES as u64,
            Self::Materials => gobo::records::MAX_MATERIALS as u64,
            Self::Textures => 256,
            Self::Texels => 1 << 28,
            Self::Particles | Self::Splats => 16_000_000,
            Self::Triangles | Self::Capsules => 8_000_000,
            Self::Bricks => super::vdb::MOST_NODES as u64,
            Self::Nodes => 1_000_000,
            Self::Unpacked => 1 << 30,
            Self::Keys => 10_000_000,
            Self::Text => 1 << 24,
        }
    }

    /// Name of the contents in messages and `docs/scene.md`.
    pub const fn noun(self) -> &'static str {
        match self {
            Self::Lights => "lights",
            Self::Sources => "viewpoints of sources",
            Self::Bounces => "points that send light on",
            Self::Materials => "materials",
            Self::Textures => "textures",
            Self::Texels => "texels of textures",
            Self::Particles => "particles",
            Self::Splats => "splats",
            Self::Triangles => "triangles",
            Self::Bricks => "bricks of volumes",
            Self::Capsules => "vertices of strands",
            Self::Nodes => "nodes of a glTF file",
            Self::Unpacked => "bytes of compressed meshes",
            Self::Keys => "keys and morphed triangles of a glTF file",
            Self::Text => "bytes of a scene file",
        }
    }

    const fn remedy(self) -> &'static str {
        match self {
            Self::Lights => "remove lights, or put those that are close together into one",
            Self::Sources => "remove the source of some lights, or give them fewer viewpoints",
            Self::Bounces => "lower the bounce of some lights",
            Self::Materials => "share materials that are alike",
            Self::Textures => "share textures, or paint several into one",
            Self::Texels => "make the textures smaller",
            Self::Particles => "use fewer and larger particles",
            Self::Splats => "use fewer and larger splats",
            Self::Triangles => {
                "simplify the meshes, use them less often, or lower a sphere's level"
            }
            Self::Bricks => "use fewer or larger voxels",
            Self::Capsules => "use fewer strands, or fewer segments in each",
            Self::Nodes => "join meshes, or use them less often",
            Self::Unpacked => "simplify the meshes",
            Self::Keys => "use fewer keys or morph targets",
            Self::Text => "put particles and meshes into files of their own",
        }
    }

    /// The sum of `have` and `more`, or the problem and the remedy.
    pub(super) fn grown(self, have: u64, more: u64) -> Result<u64, (String, &'static str)> {
        match have.checked_add(more) {
            Some(all) if all <= self.most() => Ok(all),
            all => {
                let all = all.unwrap_or(u64::MAX);
                let (noun, most) = (self.noun(), self.most());
                Err((format!("{all} {noun}, but a scene has at most {most}"), self.remedy()))
            }
        }
    }

    /// Like [`Self::grown`], of a file's contents.
    pub(super) fn grown_in(self, path: &Path, have: u64, more: u64) -> Result<u64, SceneError> {
        self.grown(have, more).map_err(|(message, help)| SceneError::invalid(path, message, help))
    }
}

/// Whether the host can allocate `bytes` more. An allocation that fails later aborts the program.
pub(super) fn has_memory(bytes: u64) -> bool {
    let mut probe = Vec::<u8>::new();
    let is_there = usize::try_from(bytes).is_ok_and(|bytes| probe.try_reserve_exact(bytes).is_ok());
    // Without this the compiler may remove the allocation.
    std::hint::black_box(&mut probe);
    is_there
}

/// Reserves memory for `more` items, or returns an error with the missing amount.
pub(super) fn reserve<T>(
    items: &mut Vec<T>,
    more: usize,
    what: &str,
    path: &Path,
) -> Result<(), SceneError> {
    items.try_reserve(more).map_err(|_| {
        let bytes = more.saturating_mul(size_of::<T>());
        SceneError::memory(path, format!("no memory for {more} {what} ({} MiB)", bytes >> 20))
    })
}
