//! `gobo maps`: maps of a share of a scene's filtering casters, as sums that `gobo merge` joins.
//!
//! A part is a line of JSON, the [`Head`], then for each view its arrays, little-endian, row by row: sums (4
//! words a texel), opaque depths (1), opaque depths per channel (3, with coloured dithering), packed curves
//! (2 a node). A digest of everything ends the file.
use super::{
    arguments::{MapsArguments, MomentArguments},
    curves,
    failure::Failure,
    files::{self, Digesting},
    inputs, maps,
    memory::Needs,
    output::{self, Output},
};
use gobo::{
    model::{Class, MAX_MAP_SIZE, Material, Receiver, Transfer},
    records::ViewMaps,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene as scene;
use gobo_scene::{LoadOptions, Scene};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::{
    collections::BTreeSet,
    fs::File,
    io::{self, BufWriter, Read as _, Seek as _, SeekFrom, Write as _},
    path::{Path, PathBuf},
};

/// First line of a part.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Head {
    /// Program version that wrote it.
    pub gobo: String,
    /// Digest of the scene's files, its options and its frame.
    pub scene: String,
    pub frame: u32,
    /// Index of the share, and number of shares.
    pub share: [u32; 2],
    /// Nodes of a curve; 0 without curves.
    pub nodes: usize,
    /// Whether there are opaque depths per channel.
    pub colored: bool,
    /// Start of each view's file names.
    pub names: Vec<String>,
    /// Width and height of each view [texels].
    pub sizes: Vec<[u32; 2]>,
    /// The `views.json` of the maps.
    pub views: String,
}

/// Longest head that is read [bytes]: a thousand views take about a megabyte.
const MAX_HEAD: u64 = 1 << 26;
const MAGIC: &[u8] = b"gobo part 2\n";
const DIGEST: u64 = 32;

/// Longest name of a view's files, made of two numbered names of at most 64 characters [bytes].
const MAX_NAME: usize = 150;

/// Whether a name is that of a file in the same folder: no path, no hidden file, and no control characters.
fn is_plain(name: &str) -> bool {
    let is_safe = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    (1..=MAX_NAME).contains(&name.len()) && !name.starts_with('.') && name.chars().all(is_safe)
}

/// Names in an entry of `views.json`.
#[derive(Deserialize)]
struct Named {
    light: String,
    view: String,
}

/// An array of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Array {
    Sums,
    Opaque,
    Colored,
    Curve,
}

impl Array {
    /// Largest value of its `index`th word.
    fn most(self, index: usize) -> u32 {
        match self {
            // Depths 0..=1 are ordered like their bits.
            Self::Opaque | Self::Colored => 1.0_f32.to_bits(),
            Self::Sums if index % 4 == 3 => 1.0_f32.to_bits(),
            Self::Sums | Self::Curve => u32::MAX,
        }
    }
}

impl Head {
    const ARRAYS: [Array; 4] = [Array::Sums, Array::Opaque, Array::Colored, Array::Curve];

    /// Words of a texel.
    pub(super) fn words(&self, array: Array) -> usize {
        match array {
            Array::Sums => 4,
            Array::Opaque => 1,
            Array::Colored => 3 * usize::from(self.colored),
            Array::Curve => 2 * self.nodes,
        }
    }

    /// Fault in a head that was read: its names become files, and its numbers memory.
    fn fault(&self) -> Option<&'static str> {
        let is_count = self.names.len() == self.sizes.len();
        let is_size = |size: &[u32; 2]| size.iter().all(|side| (1..=MAX_MAP_SIZE).contains(side));
        let unique: BTreeSet<_> = self.names.iter().map(|name| name.to_ascii_lowercase()).collect();
        let views: Option<Vec<Named>> = serde_json::from_str(&self.views).ok();
        let is_named = || {
            let views = views.iter().flatten();
            views.map(|view| format!("{}.{}", view.light, view.view)).eq(self.names.iter().cloned())
        };
        let is_text = |text: &str| text.len() <= MAX_NAME && text.chars().all(|c| !c.is_control());
        if !(is_count && is_text(&self.gobo) && is_text(&self.scene)) {
            Some("its head is damaged")
        } else if self.share[0] >= self.share[1] || !matches!(self.nodes, 0 | 4 | 8 | 16) {
            Some("its head has numbers that no part has")
        } else if !self.sizes.iter().all(is_size) {
            Some("a view of it has a size that no map has")
        } else if !self.names.iter().all(|name| is_plain(name)) || unique.len() < self.names.len() {
            Some("the name of a view of it is no file's")
        } else if !is_named() {
            Some("its views.json is not that of its views")
        } else {
            None
        }
    }

    pub(super) fn texels(&self, view: usize) -> u64 {
        self.sizes[view].map(u64::from).iter().product()
    }

    /// Length of a view's arrays [bytes].
    fn bytes(&self, view: usize) -> u64 {
        let words: usize = Self::ARRAYS.iter().map(|&array| self.words(array)).sum();
        self.texels(view).saturating_mul(4 * words as u64)
    }
}

pub(crate) fn run(arguments: &MapsArguments) -> Result<(), Failure> {
    let share = arguments.casters;
    let mut load = LoadOptions::default();
    load.set.clone_from(&arguments.moment.set);
    load.start = false;
    load.share = Some(share);
    let mut scene = scene::load_as(&arguments.scene, &load)?;
    Output::check(&arguments.out)?;
    scene.set_time(f64::from(arguments.moment.frame) / arguments.moment.fps);
    share.keep(&mut scene);
    scene.shadow.detail = false;
    check(&scene, &arguments.scene)?;
    files::warn(&scene.notes);
    Needs { maps: true, ..Needs::of(arguments.moment.device.backend()) }.check(&scene)?;
    let mut renderer = arguments.moment.device.renderer()?;
    tracing::info!("rendering with {}", renderer.device());
    curves::warn_before(&scene);
    let maps = rendered(&mut renderer, &scene)?;
    let nodes = maps.iter().find_map(|maps| maps.curve.as_ref()).map_or(0, |curve| curve.nodes);
    let maps: Vec<_> =
        maps::of_lights(&maps, &scene.lights).map(|(_, maps)| maps.clone()).collect();
    let names = maps::light_names(&scene.lights);
    let (names, views) = maps::described(&maps, &scene.lights, &names, scene.origin);
    let head = Head {
        gobo: env!("CARGO_PKG_VERSION").to_owned(),
        scene: digest(arguments)?,
        frame: arguments.moment.frame,
        share: [share.index(), share.count()],
        nodes,
        colored: maps.iter().any(|maps| !maps.colored.is_empty()),
        names,
        sizes: maps.iter().map(|maps| maps.view.size.to_array()).collect(),
        views,
    };
    write(&arguments.out, &head, &maps)?;
    output::print_name(&arguments.out)
}

/// Refuses scenes that sums cannot express.
fn check(scene: &Scene, path: &Path) -> Result<(), Failure> {
    let refuse = |message: &str, help| Err(Failure::refused(path, message, help));
    if scene.shadow.soften || scene.shadow.blur > 0 {
        let help = "--set shadow.soften=false --set shadow.blur=0";
        return refuse("maps that are softened or blurred cannot be joined", help);
    }
    let filters = |transfer| {
        let is = |material: &Material| {
            material.transfer == transfer && Class::FILTERING.contains(&Class::of(material))
        };
        scene.materials.iter().any(is)
    };
    if filters(Transfer::Over) {
        let help = "use transfer = \"filter\"";
        return refuse(
            "light of `over` depends on the order of all casters: shares of them cannot be joined",
            help,
        );
    }
    if filters(Transfer::Gain) {
        let help = "leave the casters with transfer = \"gain\" out: casts = false";
        return refuse(
            "`gain` amplifies what casters of other shares take: they cannot be joined",
            help,
        );
    }
    Ok(())
}

/// Maps with sums, and curves if receivers read them.
pub(super) fn rendered(renderer: &mut Renderer, scene: &Scene) -> Result<Vec<ViewMaps>, Failure> {
    let options = RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
    let with_curves = scene.shadow.curve_nodes() > 0;
    let mut plain = scene.clone();
    plain.shadow.receiver = Receiver::Nearest;
    let mut maps = renderer.render(&plain, &RenderOptions { sums: true, ..options })?.maps;
    if with_curves {
        let curves = renderer.render(scene, &options)?.maps;
        for (maps, with_curve) in maps.iter_mut().zip(curves) {
            maps.curve = with_curve.curve;
        }
    }
    Ok(maps)
}

/// Digest of everything that decides a part besides its share: options, and the contents of all files that
/// were read.
fn digest(arguments: &MapsArguments) -> Result<String, Failure> {
    let MomentArguments { frame, fps, set, .. } = &arguments.moment;
    // Independent of the files' folders and names.
    let mut contents = BTreeSet::new();
    for path in inputs::all() {
        let failed = |source| Failure::file(&path, source);
        let mut file = Digesting::new(io::sink());
        io::copy(&mut File::open(&path).map_err(failed)?, &mut file).map_err(failed)?;
        contents.insert(files::hex(file.digest.finalize()));
    }
    let all = format!("{frame} {fps} {set:?} {contents:?}");
    Ok(files::hex(Sha256::digest(all)))
}

fn write(path: &Path, head: &Head, maps: &[ViewMaps]) -> Result<(), Failure> {
    let failed = |source| Failure::file(path, source);
    let output = Output::new(path)?;
    let mut out = Digesting::new(BufWriter::new(output.writer().map_err(failed)?));
    let json = serde_json::to_vec(head).expect("plain data is JSON");
    let mut write = |bytes: &[u8]| out.write_all(bytes).map_err(failed);
    write(MAGIC)?;
    write(&(json.len() as u64).to_le_bytes())?;
    write(&json)?;
    for maps in maps {
        for sum in &maps.sums {
            write(&sum.map(u32::to_le_bytes).concat())?;
        }
        for depth in &maps.opaque {
            write(&depth.to_le_bytes())?;
        }
        for depths in &maps.colored {
            write(&depths.map(f32::to_le_bytes).concat())?;
        }
        for node in maps.curve.iter().flat_map(|curve| &curve.packed) {
            write(&node.map(u32::to_le_bytes).concat())?;
        }
    }
    let Digesting { mut file, digest } = out;
    file.write_all(&digest.finalize()).and_then(|()| file.flush()).map_err(failed)?;
    output.finish()
}

/// A part file.
#[derive(Debug)]
pub(super) struct Part {
    pub path: PathBuf,
    pub head: Head,
    /// Offset of the arrays [bytes].
    first: u64,
}

const AGAIN: &str = "write it again with `gobo maps`";

impl Part {
    /// Opens a part and checks that it is complete.
    pub(super) fn open(path: &Path) -> Result<Self, Failure> {
        let unreadable = |error: io::Error| {
            Failure::refused(
                path,
                error.to_string(),
                "check the name, and that the file may be read",
            )
        };
        let refused = |message: &str| Failure::refused(path, message, AGAIN);
        if !path.metadata().map_err(unreadable)?.is_file() {
            return Err(refused("is no plain file"));
        }
        let mut file = File::open(path).map_err(unreadable)?;
        let length = file.metadata().map_err(unreadable)?.len();
        let mut start = [0; 20];
        let is_part = file.read_exact(&mut start).is_ok() && start.starts_with(MAGIC);
        if !is_part {
            return Err(refused("is no part of maps"));
        }
        let [.., a, b, c, d, e, f, g, h] = start;
        let head_length = u64::from_le_bytes([a, b, c, d, e, f, g, h]);
        if head_length > MAX_HEAD.min(length) {
            return Err(refused("its head is damaged"));
        }
        let mut json = vec![0; head_length as usize];
        file.read_exact(&mut json).map_err(unreadable)?;
        let head: Head =
            serde_json::from_slice(&json).map_err(|_| refused("its head is damaged"))?;
        if let Some(fault) = head.fault() {
            return Err(refused(fault));
        }
        let first = start.len() as u64 + head_length;
        let arrays = (0..head.sizes.len()).map(|view| head.bytes(view));
        let expected = arrays.fold(first.saturating_add(DIGEST), u64::saturating_add);
        if expected != length {
            return Err(refused("it is damaged, or was not written to its end"));
        }
        let mut all = Digesting::new(io::sink());
        file.seek(SeekFrom::Start(0)).map_err(unreadable)?;
        io::copy(&mut (&file).take(length - DIGEST), &mut all).map_err(unreadable)?;
        let mut written = [0; DIGEST as usize];
        file.read_exact(&mut written).map_err(unreadable)?;
        if all.digest.finalize()[..] != written {
            return Err(refused("it is damaged: its digest is another"));
        }
        Ok(Self { path: path.to_owned(), head, first })
    }

    /// Some texels of an array.
    pub(super) fn read(
        &self,
        view: usize,
        array: Array,
        texels: std::ops::Range<u64>,
    ) -> Result<Vec<u32>, Failure> {
        let failed = |source| Failure::file(&self.path, source);
        let views: u64 = (0..view).map(|view| self.head.bytes(view)).sum();
        let before = Head::ARRAYS.iter().take_while(|&&other| other != array);
        let before: usize = before.map(|&array| self.head.words(array)).sum();
        let texel = 4 * self.head.words(array) as u64;
        let skip = 4 * before as u64 * self.head.texels(view) + texels.start * texel;
        let mut file = File::open(&self.path).map_err(failed)?;
        file.seek(SeekFrom::Start(self.first + views + skip)).map_err(failed)?;
        let mut bytes = vec![0; ((texels.end - texels.start) * texel) as usize];
        file.read_exact(&mut bytes).map_err(failed)?;
        let words: Vec<u32> = bytes
            .chunks_exact(4)
            .map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
            .collect();
        if words.iter().enumerate().any(|(i, &word)| word > array.most(i)) {
            return Err(Failure::refused(&self.path, "its maps are damaged", AGAIN));
        }
        Ok(words)
    }
}
