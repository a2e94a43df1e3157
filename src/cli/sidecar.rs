//! `frame_0000.json`, beside a frame: the inputs of the frame and its files, so that a stopped job can be
//! continued, and a damaged frame is found.
use super::{
    arguments::RenderArguments,
    failure::Failure,
    files::{self, entries},
};
use gobo::scene::Scene;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::{
    collections::BTreeMap,
    fmt, fs,
    ops::Range,
    path::{Path, PathBuf},
};

/// Contents of the JSON file.
#[derive(Debug, Deserialize, Serialize)]
pub(super) struct Sidecar {
    /// The program's version.
    gobo: String,
    frame: u32,
    /// Frames of the whole job, including other shards: first, and one past the last.
    pub(super) frames: [u32; 2],
    /// SHA-256 of the scene, the options and the version.
    inputs: String,
    /// Contents by path from the folder.
    files: BTreeMap<String, Contents>,
}

#[derive(Debug, Deserialize, PartialEq, Serialize)]
struct Contents {
    bytes: u64,
    sha256: String,
}

/// Problem of a file of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    Missing,
    Damaged,
}

impl Sidecar {
    /// `None` if there is no readable sidecar.
    pub(super) fn read(dir: &Path, frame: u32) -> Option<Self> {
        let text = fs::read(path(dir, frame)).ok()?;
        serde_json::from_slice(&text).ok().filter(|sidecar: &Self| sidecar.frame == frame)
    }

    /// Whether the frame is complete, undamaged, and made from these inputs.
    pub(super) fn holds(&self, dir: &Path, inputs: &str) -> bool {
        self.inputs == inputs && self.faults(dir).next().is_none()
    }

    /// Files that have changed since they were written.
    pub(super) fn faults(&self, dir: &Path) -> impl Iterator<Item = (&str, Fault)> {
        self.files.iter().filter_map(move |(name, expected)| {
            let fault = match Contents::of(&dir.join(name)) {
                Ok(found) if found == *expected => return None,
                Ok(_) => Fault::Damaged,
                Err(_) => Fault::Missing,
            };
            Some((name.as_str(), fault))
        })
    }

    /// Writes the sidecar; call it after all other files of the frame.
    pub(super) fn write(
        dir: &Path,
        frame: u32,
        frames: Range<u32>,
        inputs: &str,
    ) -> Result<(), Failure> {
        let mut files = BTreeMap::new();
        for file in files_of(dir, frame)? {
            let contents = Contents::of(&file).map_err(|source| Failure::file(&file, source))?;
            let name = file.strip_prefix(dir).unwrap_or(&file).components();
            let name: Vec<_> = name.map(|part| part.as_os_str().to_string_lossy()).collect();
            files.insert(name.join("/"), contents);
        }
        let sidecar = Self {
            gobo: env!("CARGO_PKG_VERSION").to_owned(),
            frame,
            frames: [frames.start, frames.end],
            inputs: inputs.to_owned(),
            files,
        };
        let text = serde_json::to_string_pretty(&sidecar).expect("plain data is JSON");
        files::write(&path(dir, frame), (text + "\n").as_bytes())
    }
}

pub(super) fn path(dir: &Path, frame: u32) -> PathBuf {
    dir.join(format!("frame_{frame:04}.json"))
}

/// The frame whose sidecar has this name.
pub(super) fn frame_of(name: &str) -> Option<u32> {
    let number = name.strip_prefix("frame_")?.strip_suffix(".json")?;
    let frame = number.parse().ok()?;
    (format!("{frame:04}") == number).then_some(frame)
}

/// All files of a frame except its sidecar.
fn files_of(dir: &Path, frame: u32) -> Result<Vec<PathBuf>, Failure> {
    let stem = format!("frame_{frame:04}");
    let own = path(dir, frame);
    let mut files: Vec<_> = entries(dir)?
        .into_iter()
        .filter(|file| {
            let name = file.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            *file != own && name.strip_prefix(&stem).is_some_and(|rest| rest.starts_with('.'))
        })
        .collect();
    let maps = dir.join("maps").join(stem);
    if maps.is_dir() {
        files.extend(entries(&maps)?);
    }
    Ok(files)
}

impl Contents {
    fn of(file: &Path) -> std::io::Result<Self> {
        let bytes = fs::read(file)?;
        Ok(Self { bytes: bytes.len() as u64, sha256: hex(Sha256::digest(&bytes)) })
    }
}

/// Hash of everything that decides what frames look like, except the device, whose rounding may move a last
/// bit.
pub(super) fn inputs(scene: &Scene, arguments: &RenderArguments) -> String {
    let mut hash = Hash(Sha256::new());
    let RenderArguments { maps, exr, fps, .. } = arguments;
    let debug = arguments.debug();
    // Hashes every field of the scene, each number to its last bit.
    let written = fmt::write(
        &mut hash,
        format_args!("{} {maps} {exr} {fps} {debug:?} {scene:?}", env!("CARGO_PKG_VERSION")),
    );
    written.expect("a hash takes all text");
    hex(hash.0.finalize())
}

struct Hash(Sha256);

impl fmt::Write for Hash {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

fn hex(bytes: impl AsRef<[u8]>) -> String {
    bytes.as_ref().iter().map(|byte| format!("{byte:02x}")).collect()
}
