//! A writer of `OpenVDB` files, after the format's description: a test states a grid's voxels.
use glam::{DVec3, IVec3};
use std::{
    collections::{BTreeMap, BTreeSet},
    io::Write as _,
};

/// Compression of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Packing {
    Plain,
    Zip,
    Blosc,
}

/// Options of a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Format {
    pub(crate) version: u32,
    pub(crate) packing: Packing,
    /// Whether inactive values are left out.
    pub(crate) masked: bool,
    /// Whether the heads of grids state their ends.
    pub(crate) has_offsets: bool,
}

impl Default for Format {
    fn default() -> Self {
        Self { version: 224, packing: Packing::Plain, masked: true, has_offsets: true }
    }
}

/// Values of a leaf, z first, each with its activity.
pub(crate) type Leaf = [(f32, bool); 512];

/// A grid to write.
#[derive(Clone, Debug)]
pub(crate) struct VdbGrid {
    pub(crate) name: &'static str,
    /// `Tree_float_5_4_3`, with `_HalfFloat` for halves.
    pub(crate) kind: &'static str,
    /// The numbers of a value, relative to it: three for a colour.
    pub(crate) channels: &'static [f32],
    pub(crate) class: &'static str,
    pub(crate) instance_of: &'static str,
    /// Name and bytes of the map.
    pub(crate) transform: (&'static str, Vec<u8>),
    pub(crate) background: f32,
    /// Leaves by their lowest voxel.
    pub(crate) leaves: BTreeMap<[i32; 3], Leaf>,
    /// Value and activity by lowest voxel and edge.
    pub(crate) tiles: BTreeMap<([i32; 3], i32), (f32, bool)>,
}

impl Default for VdbGrid {
    fn default() -> Self {
        Self {
            name: "density",
            kind: "Tree_float_5_4_3",
            channels: &[1.0],
            class: "fog volume",
            instance_of: "",
            transform: scaled(0.5),
            background: 0.0,
            leaves: BTreeMap::new(),
            tiles: BTreeMap::new(),
        }
    }
}

/// A map with cubic voxels [m].
pub(crate) fn scaled(edge: f64) -> (&'static str, Vec<u8>) {
    ("UniformScaleMap", doubles([edge; 15]))
}

pub(crate) fn doubles(numbers: impl IntoIterator<Item = f64>) -> Vec<u8> {
    numbers.into_iter().flat_map(f64::to_le_bytes).collect()
}

/// A map with a scale and a translation [m].
pub(crate) fn placed(scale: DVec3, translation: DVec3) -> (&'static str, Vec<u8>) {
    let rest = std::iter::repeat_n(scale.to_array(), 5).flatten();
    ("ScaleTranslateMap", doubles(translation.to_array().into_iter().chain(rest)))
}

fn floor_to(voxel: [i32; 3], edge: i32) -> [i32; 3] {
    voxel.map(|v| v.div_euclid(edge) * edge)
}

impl VdbGrid {
    /// Sets an active voxel.
    pub(crate) fn set(&mut self, voxel: IVec3, value: f32) {
        let leaf = self.leaves.entry(floor_to(voxel.to_array(), 8));
        let [x, y, z] = voxel.to_array().map(|v| v.rem_euclid(8) as usize);
        let background = self.background;
        leaf.or_insert([(background, false); 512])[(x * 8 + y) * 8 + z] = (value, true);
    }

    /// Value of a voxel; the background counts as 0.
    pub(crate) fn at(&self, voxel: IVec3) -> f64 {
        let [x, y, z] = voxel.to_array().map(|v| v.rem_euclid(8) as usize);
        let voxel = voxel.to_array();
        let leaf = self.leaves.get(&floor_to(voxel, 8)).map(|leaf| leaf[(x * 8 + y) * 8 + z]);
        let tile = || [8, 128, 4096].iter().find_map(|&e| self.tiles.get(&(floor_to(voxel, e), e)));
        match leaf.or_else(|| tile().copied()) {
            Some((value, is_active)) if is_active || value != self.background => value.into(),
            _ => 0.0,
        }
    }
}

/// Bytes of a file with these grids.
pub(crate) fn file(format: Format, grids: &[VdbGrid]) -> Vec<u8> {
    let mut out = Out { format, stored: 4, channels: &[1.0], bytes: Vec::new() };
    out.put(0x5644_4220u64.to_le_bytes());
    out.number(format.version);
    out.put([11, 0, 0, 0, 0, 0, 0, 0, u8::from(format.has_offsets)]);
    if (220..222).contains(&format.version) {
        out.put([u8::from(format.packing == Packing::Zip)]);
    }
    out.put(b"00000000-0000-0000-0000-000000000000");
    out.number(0);
    out.number(grids.len() as u32);
    for grid in grids {
        out.grid(grid);
    }
    out.bytes
}

struct Out {
    format: Format,
    /// Bytes of a stored number.
    stored: usize,
    channels: &'static [f32],
    bytes: Vec<u8>,
}

impl Out {
    fn put(&mut self, bytes: impl AsRef<[u8]>) {
        self.bytes.extend_from_slice(bytes.as_ref());
    }

    fn number(&mut self, number: u32) {
        self.put(number.to_le_bytes());
    }

    fn value(&mut self, value: f32) {
        self.channels.iter().for_each(|channel| self.bytes.extend((value * channel).to_le_bytes()));
    }

    fn text(&mut self, text: &str) {
        self.number(text.len() as u32);
        self.put(text);
    }

    fn place(&mut self, voxel: [i32; 3]) {
        voxel.into_iter().for_each(|v| self.put(v.to_le_bytes()));
    }

    fn grid(&mut self, grid: &VdbGrid) {
        self.text(grid.name);
        self.text(grid.kind);
        self.text(grid.instance_of);
        let offsets = self.bytes.len();
        self.put([0; 24]);
        if self.format.version >= 222 {
            let packing = match self.format.packing {
                Packing::Plain => 0,
                Packing::Zip => 1,
                Packing::Blosc => 4,
            };
            self.number(packing | u32::from(self.format.masked) << 1);
        }
        self.number(1);
        ["class", "string", grid.class].into_iter().for_each(|text| self.text(text));
        self.text(grid.transform.0);
        self.put(&grid.transform.1);
        if grid.instance_of.is_empty() {
            self.channels = grid.channels;
            self.stored = if grid.kind.ends_with("_HalfFloat") { 2 } else { 4 };
            self.tree(grid);
        }
        if self.format.has_offsets {
            let end = self.bytes.len() as u64;
            self.bytes[offsets + 16..offsets + 24].copy_from_slice(&end.to_le_bytes());
        }
    }

    fn tree(&mut self, grid: &VdbGrid) {
        let tiles_of = |edge: i32| grid.tiles.iter().filter(move |((_, e), _)| *e == edge);
        let within = |edge: i32| {
            let leaves = grid.leaves.keys().map(move |&leaf| floor_to(leaf, edge));
            let tiles = grid.tiles.keys().filter(move |(_, e)| *e < edge);
            leaves.chain(tiles.map(move |&(tile, _)| floor_to(tile, edge))).collect::<BTreeSet<_>>()
        };
        self.number(1);
        self.value(grid.background);
        let (uppers, lowers) = (within(4096), within(128));
        self.number(tiles_of(4096).count() as u32);
        self.number(uppers.len() as u32);
        for (&(tile, _), &(value, is_active)) in tiles_of(4096) {
            self.place(tile);
            self.value(value);
            self.put([u8::from(is_active)]);
        }
        let mut leaves = Vec::new();
        for upper in uppers {
            self.place(upper);
            let below: Vec<_> = self.inner(grid, upper, 32, 128, &lowers);
            for lower in below {
                let of_leaves = grid.leaves.keys().copied().collect();
                for leaf in self.inner(grid, lower, 16, 8, &of_leaves) {
                    self.mask(grid.leaves[&leaf].iter().map(|&(_, is_active)| is_active));
                    leaves.push(leaf);
                }
            }
        }
        for leaf in leaves {
            let voxels = &grid.leaves[&leaf];
            self.mask(voxels.iter().map(|&(_, is_active)| is_active));
            if self.format.version < 222 {
                self.place(leaf);
                self.put([1]);
            }
            self.values(grid.background, &voxels.map(Some));
        }
    }

    /// An inner node; returns its children in order.
    fn inner(
        &mut self,
        grid: &VdbGrid,
        origin: [i32; 3],
        parts: i32,
        edge: i32,
        children: &BTreeSet<[i32; 3]>,
    ) -> Vec<[i32; 3]> {
        let place = |i: i32| {
            let part = [i / (parts * parts), i / parts % parts, i % parts];
            std::array::from_fn(|axis| origin[axis] + part[axis] * edge)
        };
        let places: Vec<[i32; 3]> = (0..parts * parts * parts).map(place).collect();
        let tile = |place: &[i32; 3]| {
            grid.tiles.get(&(*place, edge)).copied().unwrap_or((grid.background, false))
        };
        self.mask(places.iter().map(|place| children.contains(place)));
        self.mask(places.iter().map(|place| tile(place).1));
        let value = |place: &[i32; 3]| (!children.contains(place)).then(|| tile(place));
        let values: Vec<_> = places.iter().map(value).collect();
        self.values(grid.background, &values);
        places.into_iter().filter(|place| children.contains(place)).collect()
    }

    fn mask(&mut self, bits: impl Iterator<Item = bool>) {
        let bits: Vec<bool> = bits.collect();
        for byte in bits.chunks(8) {
            self.put([byte.iter().rev().fold(0, |sum, &bit| sum << 1 | u8::from(bit))]);
        }
    }

    /// Values of a node, without those of its children.
    fn values(&mut self, background: f32, values: &[Option<(f32, bool)>]) {
        if self.format.version < 222 {
            let own: Vec<f32> = values.iter().flatten().map(|&(value, _)| value).collect();
            return self.packed(&own);
        }
        let mut inactive: Vec<f32> = Vec::new();
        for &(value, is_active) in values.iter().flatten() {
            if !is_active && !inactive.contains(&value) {
                inactive.push(value);
            }
        }
        // The background comes last.
        inactive.sort_by_key(|&value| value == background);
        let kind = match *inactive {
            _ if !self.format.masked => 6,
            [] => 0,
            [value] if value == background => 0,
            [value] if value == -background => 1,
            [_] => 2,
            [first, second] if second == background && first == -background => 3,
            [_, second] if second == background => 4,
            [_, _] => 5,
            _ => 6,
        };
        self.put([kind]);
        let given = match kind {
            2 | 4 => 1,
            5 => 2,
            _ => 0,
        };
        inactive.iter().take(given).for_each(|&value| self.value(value));
        if (3..=5).contains(&kind) {
            let second = inactive[1];
            let is_second = |value: &Option<(f32, bool)>| value.is_some_and(|(v, _)| v == second);
            self.mask(values.iter().map(is_second));
        }
        let is_written = |value: &Option<(f32, bool)>| kind == 6 || value.is_some_and(|(_, on)| on);
        let written = values.iter().filter(|value| is_written(value));
        let written: Vec<f32> = written.map(|value| value.map_or(0.0, |(v, _)| v)).collect();
        self.packed(&written);
    }

    fn packed(&mut self, values: &[f32]) {
        let number = |value: f32| match self.stored {
            2 => half::f16::from_f32(value).to_le_bytes().to_vec(),
            _ => value.to_le_bytes().to_vec(),
        };
        let numbers = values.iter().flat_map(|value| self.channels.iter().map(move |c| value * c));
        let plain: Vec<u8> = numbers.flat_map(number).collect();
        let packed = match self.format.packing {
            _ if self.stored == 2 && values.is_empty() => return,
            Packing::Plain => return self.put(plain),
            _ if values.is_empty() => Vec::new(),
            Packing::Zip => zipped(&plain),
            Packing::Blosc => blosc(&plain, self.stored * self.channels.len()),
        };
        if packed.len() >= plain.len() {
            self.put((-(plain.len() as i64)).to_le_bytes());
            return self.put(plain);
        }
        self.put((packed.len() as i64).to_le_bytes());
        self.put(packed);
    }
}

pub(crate) fn zipped(plain: &[u8]) -> Vec<u8> {
    let mut zip = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    zip.write_all(plain).unwrap();
    zip.finish().unwrap()
}

/// A Blosc frame of one block: bytes sorted by their position in a number, in a stream each if there are
/// enough.
pub(crate) fn blosc(plain: &[u8], number: usize) -> Vec<u8> {
    let count = plain.len() / number;
    let sorted: Vec<u8> = (0..plain.len()).map(|i| plain[i % count * number + i / count]).collect();
    let mut streams = Vec::new();
    for stream in sorted.chunks(if count >= 128 { count } else { plain.len() }) {
        let mut packed = vec![0; lz4_flex::block::get_maximum_output_size(stream.len())];
        let length = lz4_flex::block::compress_into(stream, &mut packed).unwrap();
        let packed = if length < stream.len() { &packed[..length] } else { stream };
        streams.extend((packed.len() as u32).to_le_bytes());
        streams.extend(packed);
    }
    let mut frame = vec![2, 1, 1 | 1 << 5, number as u8];
    for length in [plain.len(), plain.len(), 20 + streams.len(), 20] {
        frame.extend((length as u32).to_le_bytes());
    }
    frame.extend(streams);
    frame
}
