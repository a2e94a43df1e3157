//! A writer of `NanoVDB` files, after the layout's description (version 32).
use super::vdb::{VdbGrid, blosc, zipped};
use std::collections::{BTreeMap, BTreeSet};

/// Numbers of the types of grids.
pub(crate) const FLOAT: u32 = 1;
pub(crate) const DOUBLE: u32 = 2;
pub(crate) const INT16: u32 = 3;
pub(crate) const INT32: u32 = 4;
pub(crate) const HALF: u32 = 9;
pub(crate) const FP4: u32 = 13;
pub(crate) const FP8: u32 = 14;
pub(crate) const FP16: u32 = 15;
pub(crate) const FPN: u32 = 16;

/// Compression of grids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Codec {
    Plain,
    Zip,
    Blosc,
}

type Voxel = [i32; 3];

fn floor_to(voxel: Voxel, edge: i32) -> Voxel {
    voxel.map(|at| at.div_euclid(edge) * edge)
}

fn bytes_of(kind: u32, value: f32) -> Vec<u8> {
    match kind {
        DOUBLE => f64::from(value).to_le_bytes().to_vec(),
        INT16 => (value as i16).to_le_bytes().to_vec(),
        INT32 => (value as i32).to_le_bytes().to_vec(),
        HALF => half::f16::from_f32(value).to_le_bytes().to_vec(),
        _ => value.to_le_bytes().to_vec(),
    }
}

fn put(bytes: &mut [u8], at: usize, value: impl AsRef<[u8]>) {
    bytes[at..at + value.as_ref().len()].copy_from_slice(value.as_ref());
}

/// A leaf; with steps of 1, its values are whole numbers from 0 to 15.
fn leaf(kind: u32, i: usize, values: &[(f32, bool); 512]) -> Vec<u8> {
    let table = if kind == DOUBLE { 128 } else { 96 };
    let mut bytes = vec![0; table];
    for (i, _) in values.iter().enumerate().filter(|(_, (_, is_active))| *is_active) {
        bytes[16 + i / 8] |= 1 << (i % 8);
    }
    let logarithm = match kind {
        FP4 => 2,
        FP8 => 3,
        FP16 => 4,
        FPN => 2 + i % 3,
        _ => {
            bytes.extend(values.iter().flat_map(|&(value, _)| bytes_of(kind, value)));
            return bytes;
        }
    };
    bytes[15] = if kind == FPN { (logarithm as u8) << 5 } else { 0 };
    put(&mut bytes, 80, (-1_f32).to_le_bytes());
    put(&mut bytes, 84, 1_f32.to_le_bytes());
    let bits = 1 << logarithm;
    let mut steps = vec![0_u8; 512 * bits / 8];
    for (i, (value, _)) in values.iter().enumerate() {
        let number = (value + 1.0) as u16;
        for bit in (0..bits).filter(|bit| number >> bit & 1 == 1) {
            let place = i * bits + bit;
            steps[place / 8] |= 1 << (place % 8);
        }
    }
    bytes.extend(steps);
    bytes
}

/// The children and tiles of an inner node, by the logarithm of its parts along an edge.
fn inner(kind: u32, log: usize, table: usize, parts: &BTreeMap<usize, Part>) -> Vec<u8> {
    let count = 1 << (3 * log);
    let mut bytes = vec![0; table + count * 8];
    for (&i, part) in parts {
        let mask = |first: usize| first + i / 8;
        match part {
            Part::Child(offset) => {
                bytes[mask(32 + count / 8)] |= 1 << (i % 8);
                put(&mut bytes, table + i * 8, offset.to_le_bytes());
            }
            Part::Tile(value, is_active) => {
                bytes[mask(32)] |= u8::from(*is_active) << (i % 8);
                put(&mut bytes, table + i * 8, bytes_of(kind, *value));
            }
        }
    }
    bytes
}

enum Part {
    Child(i64),
    Tile(f32, bool),
}

/// Index of the part that begins at a voxel, in a node of 2^log parts along an edge.
fn place(voxel: Voxel, log: usize, edge: i32) -> usize {
    let [x, y, z] = voxel.map(|at| (at.div_euclid(edge)).rem_euclid(1 << log) as usize);
    (x << (2 * log)) | (y << log) | z
}

/// A single grid: world from index is (4 z + 7, 2 x + 8, 3 y + 9).
pub(crate) fn grid(kind: u32, class: u32, grid: &VdbGrid) -> Vec<u8> {
    let is_wide = kind == DOUBLE;
    let (root_size, background_at, value_at) = if is_wide { (96, 32, 24) } else { (64, 28, 20) };
    let leaves: Vec<(Voxel, Vec<u8>)> = grid
        .leaves
        .iter()
        .enumerate()
        .map(|(i, (&origin, values))| (origin, leaf(kind, i, values)))
        .collect();
    let tiles = |edge: i32| grid.tiles.iter().filter(move |((_, own), _)| *own == edge);
    let lowers: BTreeSet<Voxel> = leaves
        .iter()
        .map(|(origin, _)| *origin)
        .chain(tiles(8).map(|((origin, _), _)| *origin))
        .map(|origin| floor_to(origin, 128))
        .collect();
    let uppers: BTreeSet<Voxel> = lowers
        .iter()
        .copied()
        .chain(tiles(128).map(|((origin, _), _)| *origin))
        .map(|origin| floor_to(origin, 4096))
        .collect();
    let entries = uppers.len() + tiles(4096).count();
    let root_at = 672 + 64;
    let upper_at = root_at + root_size + 32 * entries;
    let lower_at = upper_at + uppers.len() * 270_400;
    let mut leaf_at = lower_at + lowers.len() * 33_856;
    let mut bytes = vec![0; leaf_at];
    let leaf_places: BTreeMap<Voxel, usize> = leaves
        .iter()
        .map(|(origin, leaf)| {
            leaf_at += leaf.len();
            (*origin, leaf_at - leaf.len())
        })
        .collect();
    let lower_places: BTreeMap<Voxel, usize> =
        lowers.iter().enumerate().map(|(i, &origin)| (origin, lower_at + i * 33_856)).collect();
    let background =
        |mut node: Vec<u8>, log: usize, table: usize, parts: &BTreeMap<usize, Part>| {
            for i in (0..1 << (3 * log)).filter(|i| !parts.contains_key(i)) {
                put(&mut node, table + i * 8, bytes_of(kind, grid.background));
            }
            node
        };
    for (&origin, &at) in &lower_places {
        let mut parts = BTreeMap::new();
        for (&leaf, &leaf_at) in
            leaf_places.iter().filter(|(leaf, _)| floor_to(**leaf, 128) == origin)
        {
            parts.insert(place(leaf, 4, 8), Part::Child((leaf_at - at) as i64));
        }
        for ((tile, _), &(value, is_active)) in
            tiles(8).filter(|((tile, _), _)| floor_to(*tile, 128) == origin)
        {
            parts.insert(place(*tile, 4, 8), Part::Tile(value, is_active));
        }
        let node = background(inner(kind, 4, 1088, &parts), 4, 1088, &parts);
        put(&mut bytes, at, node);
    }
    let mut table = Vec::new();
    // 21 bits for each number; the lowest 20 are a coordinate's.
    let key = |origin: Voxel| {
        let [x, y, z] = origin.map(|at| u64::from(at.cast_unsigned() >> 12));
        (z | y << 21 | x << 42).to_le_bytes()
    };
    for (i, &origin) in uppers.iter().enumerate() {
        let at = upper_at + i * 270_400;
        let mut parts = BTreeMap::new();
        for (&lower, &lower_at) in
            lower_places.iter().filter(|(lower, _)| floor_to(**lower, 4096) == origin)
        {
            parts.insert(place(lower, 5, 128), Part::Child((lower_at - at) as i64));
        }
        for ((tile, _), &(value, is_active)) in
            tiles(128).filter(|((tile, _), _)| floor_to(*tile, 4096) == origin)
        {
            parts.insert(place(*tile, 5, 128), Part::Tile(value, is_active));
        }
        let node = background(inner(kind, 5, 8256, &parts), 5, 8256, &parts);
        put(&mut bytes, at, node);
        let mut entry = vec![0; 32];
        put(&mut entry, 0, key(origin));
        put(&mut entry, 8, ((at - root_at) as i64).to_le_bytes());
        table.extend(entry);
    }
    for ((origin, _), &(value, is_active)) in tiles(4096) {
        let mut entry = vec![0; 32];
        put(&mut entry, 0, key(*origin));
        put(&mut entry, 16, u32::from(is_active).to_le_bytes());
        put(&mut entry, value_at, bytes_of(kind, value));
        table.extend(entry);
    }
    put(&mut bytes, root_at + 24, (entries as u32).to_le_bytes());
    put(&mut bytes, root_at + background_at, bytes_of(kind, grid.background));
    put(&mut bytes, root_at + root_size, table);
    bytes.extend(leaves.into_iter().flat_map(|(_, leaf)| leaf));
    let length = bytes.len() as u64;
    // The head, and the root's offset after the tree's own 64 bytes.
    put(&mut bytes, 0, b"NanoVDB1");
    put(&mut bytes, 16, (32_u32 << 21).to_le_bytes());
    put(&mut bytes, 28, 1_u32.to_le_bytes());
    put(&mut bytes, 32, length.to_le_bytes());
    put(&mut bytes, 40, grid.name);
    let rows = [0.0, 0.0, 4.0, 2.0, 0.0, 0.0, 0.0, 3.0, 0.0_f64];
    put(&mut bytes, 384, rows.map(f64::to_le_bytes).concat());
    put(&mut bytes, 528, [7.0_f64, 8.0, 9.0].map(f64::to_le_bytes).concat());
    put(&mut bytes, 632, class.to_le_bytes());
    put(&mut bytes, 636, kind.to_le_bytes());
    put(&mut bytes, 672 + 24, 64_u64.to_le_bytes());
    bytes
}

/// A segment of grids by name, type and bytes.
pub(crate) fn segment(codec: Codec, grids: &[(&str, u32, Vec<u8>)]) -> Vec<u8> {
    let number = codec as u16;
    let mut bytes = b"NanoVDB2".to_vec();
    bytes.extend((32_u32 << 21).to_le_bytes());
    bytes.extend((grids.len() as u16).to_le_bytes());
    bytes.extend(number.to_le_bytes());
    let mut data = Vec::new();
    for (name, kind, grid) in grids {
        let packed = match codec {
            Codec::Plain => grid.clone(),
            Codec::Zip => {
                [(zipped(grid).len() as u64).to_le_bytes().to_vec(), zipped(grid)].concat()
            }
            Codec::Blosc => {
                let frame = blosc(grid, 4);
                [(frame.len() as u64).to_le_bytes().to_vec(), frame].concat()
            }
        };
        let mut about = vec![0; 176];
        put(&mut about, 0, (grid.len() as u64).to_le_bytes());
        put(&mut about, 8, (packed.len() as u64).to_le_bytes());
        put(&mut about, 32, kind.to_le_bytes());
        put(&mut about, 136, (name.len() as u32 + 1).to_le_bytes());
        put(&mut about, 168, number.to_le_bytes());
        put(&mut about, 172, (32_u32 << 21).to_le_bytes());
        bytes.extend(about);
        bytes.extend(name.bytes().chain([0]));
        data.extend(packed);
    }
    bytes.extend(data);
    bytes
}
