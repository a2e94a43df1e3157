//! `frame_0000.json`, beside a frame: the frame's inputs and files, so that a stopped job can be continued,
//! and a damaged frame is found.
use super::{
    arguments::RenderArguments,
    failure::Failure,
    files::{self, Digesting, hex},
    output::{self, Fill},
};
use gobo_scene::Scene;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::{
    collections::BTreeMap,
    fmt, fs,
    io::{self, Read as _},
    mem::take,
    ops::Range,
    path::{Path, PathBuf},
};

/// Most bytes of a sidecar: some 100,000 maps of a frame.
const MAX_BYTES: u64 = 1 << 25;

/// Contents of the JSON file.
#[derive(Debug, Deserialize, Serialize)]
pub(super) struct Sidecar {
    /// The program's version.
    pub(super) gobo: String,
    frame: u32,
    /// Frames of the whole job, including other shards: first, and one past the last.
    pub(super) frames: [u32; 2],
    /// SHA-256 of the scene, the options and the version.
    pub(super) inputs: String,
    /// Contents by path from the folder.
    files: BTreeMap<String, SidecarContents>,
}

#[derive(Debug, Deserialize, PartialEq, Serialize)]
struct SidecarContents {
    bytes: u64,
    sha256: String,
}

/// Problem of a file of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SidecarFault {
    Missing,
    Damaged,
}

impl Sidecar {
    /// `None` if there is no readable sidecar of this frame and its files.
    pub(super) fn read(dir: &Path, frame: u32) -> Option<Self> {
        let file = plain(&path(dir, frame)).ok()?;
        let mut text = Vec::new();
        file.take(MAX_BYTES).read_to_end(&mut text).ok()?;
        let sidecar: Self = serde_json::from_slice(&text).ok()?;
        let [first, end] = sidecar.frames;
        let is_whole = sidecar.frame == frame
            && (first..end).contains(&frame)
            && sidecar.names(&picture(frame))
            && sidecar.files.keys().all(|name| is_of(name, frame));
        is_whole.then_some(sidecar)
    }

    /// Whether the frame is complete, undamaged, and made from these inputs.
    pub(super) fn holds(&self, dir: &Path, inputs: &str) -> bool {
        self.gobo == env!("CARGO_PKG_VERSION")
            && self.inputs == inputs
            && self.faults(dir).next().is_none()
    }

    /// Whether the file belongs to the frame.
    pub(super) fn names(&self, name: &str) -> bool {
        self.files.contains_key(name)
    }

    /// Files that have changed since they were written.
    pub(super) fn faults(&self, dir: &Path) -> impl Iterator<Item = (&str, SidecarFault)> {
        self.files.iter().filter_map(move |(name, expected)| {
            let fault = match expected.agrees(&dir.join(name)) {
                Ok(true) => return None,
                Ok(false) => SidecarFault::Damaged,
                Err(_) => SidecarFault::Missing,
            };
            Some((name.as_str(), fault))
        })
    }
}

/// Records the files of a frame while they are written, for its sidecar.
#[derive(Debug)]
pub(super) struct FrameFiles<'a> {
    dir: &'a Path,
    /// `None` if the frame gets no sidecar.
    written: Option<BTreeMap<String, SidecarContents>>,
}

impl<'a> FrameFiles<'a> {
    pub(super) fn new(dir: &'a Path, has_sidecar: bool) -> Self {
        Self { dir, written: has_sidecar.then(BTreeMap::new) }
    }

    /// Writes a file. `name`: its path from the folder, with `/`.
    pub(super) fn write(&mut self, name: String, bytes: &[u8]) -> Result<(), Failure> {
        self.fill(name, &mut |out| out.write_all(bytes))
    }

    /// Like [`Self::write`], for contents that are not in memory at once.
    pub(super) fn fill(&mut self, name: String, contents: Fill<'_>) -> Result<(), Failure> {
        let path = self.dir.join(&name);
        let Some(written) = &mut self.written else { return output::fill(&path, contents) };
        check_plain(&path)?;
        let mut digest = Sha256::new();
        output::fill_synced(&path, &mut |out| {
            let mut digesting = Digesting::new(out);
            contents(&mut digesting)?;
            digest = digesting.digest;
            Ok(())
        })?;
        let bytes = fs::metadata(&path).map_err(|source| Failure::file(&path, source))?.len();
        written.insert(name, SidecarContents { bytes, sha256: hex(digest.finalize()) });
        Ok(())
    }

    /// Writes the sidecar, after all other files of the frame. `frames`: of the whole job.
    pub(super) fn finish(
        self,
        frame: u32,
        frames: Range<u32>,
        inputs: &str,
    ) -> Result<(), Failure> {
        let files = self.written.unwrap_or_default();
        let has_maps = files.keys().any(|name| name.starts_with("maps/"));
        let sidecar = Sidecar {
            gobo: env!("CARGO_PKG_VERSION").to_owned(),
            frame,
            frames: [frames.start, frames.end],
            inputs: inputs.to_owned(),
            files,
        };
        // The files that it promises are made durable first.
        if has_maps {
            files::sync_dir(&self.dir.join(maps(frame)));
            files::sync_dir(&self.dir.join("maps"));
        }
        files::sync_dir(self.dir);
        let text = serde_json::to_string_pretty(&sidecar).expect("plain data is JSON");
        let path = path(self.dir, frame);
        check_plain(&path)?;
        output::write_synced(&path, (text + "\n").as_bytes())?;
        files::sync_dir(self.dir);
        Ok(())
    }
}

/// Start of the names of a frame's files.
pub(super) fn stem(frame: u32) -> String {
    format!("frame_{frame:04}")
}

/// Name of a frame's picture.
pub(super) fn picture(frame: u32) -> String {
    stem(frame) + ".png"
}

/// The frame of a file or folder with this name: `frame_0001`, with or without an ending.
pub(super) fn frame_of_any(name: &str) -> Option<u32> {
    let frame = name.strip_prefix("frame_")?.split('.').next()?.parse().ok()?;
    let rest = name.strip_prefix(&stem(frame))?;
    (rest.is_empty() || rest.starts_with('.')).then_some(frame)
}

/// Folder of a frame's maps, relative to that of its picture.
pub(super) fn maps(frame: u32) -> String {
    format!("maps/{}", stem(frame))
}

fn path(dir: &Path, frame: u32) -> PathBuf {
    dir.join(stem(frame) + ".json")
}

/// The frame whose sidecar has this name.
pub(super) fn frame_of(name: &str) -> Option<u32> {
    let number = name.strip_prefix("frame_")?.strip_suffix(".json")?;
    let frame = number.parse().ok()?;
    (format!("{frame:04}") == number).then_some(frame)
}

/// Whether a path in the folder is that of a file of one of these frames; for a path that ends with `/`, of a
/// folder with such files.
pub(super) fn is_of_frames(name: &str, frames: &Range<u32>) -> bool {
    let own = name.strip_prefix("maps/").unwrap_or(name).split('/').next();
    let frame = own.and_then(frame_of_any);
    name == "maps/" || frame.is_some_and(|frame| frames.contains(&frame))
}

/// Whether a path in the folder is that of a frame's file: beside its picture, or a map.
fn is_of(name: &str, frame: u32) -> bool {
    let map = name.strip_prefix(&maps(frame)).and_then(|rest| rest.strip_prefix('/'));
    let beside = name.strip_prefix(&stem(frame)).and_then(|rest| rest.strip_prefix('.'));
    let is_plain = |name: &str| {
        !name.is_empty() && !name.starts_with('.') && !name.contains(['/', '\\', ':', '\0'])
    };
    map.or(beside).is_some_and(is_plain)
}

/// Refuses outputs that cannot be checked later, such as pipes.
fn check_plain(path: &Path) -> Result<(), Failure> {
    match fs::symlink_metadata(path) {
        Ok(metadata) if !metadata.is_file() => {
            let message = "is no plain file, which --skip-existing could check";
            Err(Failure::refused(path, message, "remove it, or leave --skip-existing out"))
        }
        _ => Ok(()),
    }
}

/// Opens a plain file: a pipe or a device might never end.
fn plain(path: &Path) -> io::Result<fs::File> {
    if fs::symlink_metadata(path)?.is_file() {
        return fs::File::open(path);
    }
    Err(io::ErrorKind::NotFound.into())
}

impl SidecarContents {
    fn agrees(&self, path: &Path) -> io::Result<bool> {
        let mut file = plain(path)?;
        if file.metadata()?.len() != self.bytes {
            return Ok(false);
        }
        let mut all = Digesting::new(io::sink());
        io::copy(&mut file, &mut all)?;
        Ok(hex(all.digest.finalize()) == self.sha256)
    }
}

/// Hash of everything that decides the look of frames, except the device, whose rounding may move a last bit,
/// and the scene's folder. The simulation of emitters counts: frames of CPU and device do not fit together.
/// The scene is unchanged afterwards.
pub(super) fn inputs(scene: &mut Scene, arguments: &RenderArguments) -> String {
    let mut hash = Hash(Sha256::new());
    let RenderArguments { maps, exr, layers, fps, .. } = arguments;
    let debug = arguments.debug();
    // Notes name files.
    let notes = take(&mut scene.notes);
    let names: Vec<String> = scene.textures.iter_mut().map(|it| take(&mut it.name)).collect();
    // Hashes every field of the scene, each number to its last bit.
    let written = fmt::write(
        &mut hash,
        format_args!(
            "{} {maps} {exr} {layers} {fps} {debug:?} {scene:?}",
            env!("CARGO_PKG_VERSION")
        ),
    );
    scene.notes = notes;
    for (texture, name) in scene.textures.iter_mut().zip(names) {
        texture.name = name;
    }
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
