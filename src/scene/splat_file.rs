//! Files of splats of any kind.
use super::{
    SceneError, gltf_splats, read,
    splats::{Cloud, Kind, is_whole, kind_of, read_kind},
};
use std::path::Path;

/// Head by which a kind is recognised: longer than the header of any PLY [bytes].
const LONGEST_HEAD: u64 = 1 << 16;

/// Reads a file of splats, whatever its name. World space = the file's space.
pub fn load_splats(path: &Path) -> Result<Cloud, SceneError> {
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
    kind_of(&head).filter(|&kind| kind != Kind::Bare || is_whole(length))
}

/// Whether the bytes are those of a glTF file, of any contents.
fn is_gltf(bytes: &[u8]) -> bool {
    bytes.starts_with(b"glTF") || bytes.trim_ascii_start().starts_with(b"{")
}
