//! What one scene may hold, over all its tables and files together. Each limit is asked before the
//! memory is taken: a few bytes of input can promise gigabytes.
use super::SceneError;
use std::path::Path;

/// Something that a scene may hold so many of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limit {
    /// Lights of files and tables together, as all of these.
    Lights,
    /// A uniform array on every device.
    Materials,
    /// Layers that a texture array of WebGPU has.
    Textures,
    /// Texels of all textures: 1 GiB.
    Texels,
    /// Read or generated.
    Particles,
    /// Triangles of shapes and meshes, flat ones too.
    Triangles,
    /// Nodes of a glTF file, instances and primitives of each counted.
    Nodes,
}

impl Limit {
    /// Each once.
    pub const ALL: [Self; 7] = [
        Self::Lights,
        Self::Materials,
        Self::Textures,
        Self::Texels,
        Self::Particles,
        Self::Triangles,
        Self::Nodes,
    ];

    /// So many fit.
    pub const fn most(self) -> u64 {
        match self {
            Self::Lights => crate::records::MAX_LIGHTS as u64,
            Self::Materials => crate::records::MAX_MATERIALS as u64,
            Self::Textures => 256,
            Self::Texels => 1 << 28,
            Self::Particles => 16_000_000,
            Self::Triangles => 8_000_000,
            Self::Nodes => 1_000_000,
        }
    }

    /// What is counted, as messages and `docs/scene.md` call it.
    pub const fn noun(self) -> &'static str {
        match self {
            Self::Lights => "lights",
            Self::Materials => "materials",
            Self::Textures => "textures",
            Self::Texels => "texels of textures",
            Self::Particles => "particles",
            Self::Triangles => "triangles",
            Self::Nodes => "nodes of a glTF file",
        }
    }

    const fn remedy(self) -> &'static str {
        match self {
            Self::Lights => "remove lights, or put those that are close together into one",
            Self::Materials => "share materials that are alike",
            Self::Textures => "share textures, or paint several into one",
            Self::Texels => "make the textures smaller",
            Self::Particles => "use fewer and larger particles",
            Self::Triangles => {
                "simplify the meshes, use them less often, or lower a sphere's level"
            }
            Self::Nodes => "join meshes, or use them less often",
        }
    }

    /// `have` of them so far and `more` to come: `have` then, or what is wrong and the remedy.
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
}

/// Room for `more` items, or an error that says how much is missing.
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
