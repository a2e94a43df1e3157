//! Reading of `OpenVDB` files (Museth 2013, "VDB: High-Resolution Sparse Volumes with Dynamic Topology"),
//! versions 218 to 225: grids of numbers, and of colours. Memory is at most about twenty times the file's
//! size.
mod bricks;
mod cut;
mod input;
mod nano;
mod nano_tree;
mod product;
mod tree;
mod values;

pub(crate) use bricks::Bricks;
pub(crate) use input::VolumeFault;
pub(crate) use tree::{LEAF_EDGE, LEAF_VOXELS, MOST_NODES, Tile, Tree};

use glam::{DAffine3, DMat3, DMat4, DVec3};
use input::Input;
use tree::Topology;
use values::{Encoding, NODE_MASKS, Scratch, VdbNumber};

/// A file in memory.
#[derive(Debug)]
pub(crate) struct Vdb {
    bytes: Vec<u8>,
    version: u32,
    /// Whether values are compressed by zlib, in versions where the file states it.
    zip: bool,
    /// Grids of numbers.
    heads: Vec<Head>,
    /// Grids of colours.
    colors: Vec<Head>,
    /// Grids of a `NanoVDB` file.
    nano: Vec<nano::NanoHead>,
    /// Grids that cannot be read, a sentence each.
    pub(crate) unread: Vec<String>,
}

/// Head of a grid.
#[derive(Debug)]
struct Head {
    name: String,
    number: VdbNumber,
    /// Numbers per value.
    width: usize,
    /// Whether numbers in nodes are half floats.
    is_half: bool,
    /// Offset of the grid \[bytes\].
    start: usize,
}

/// A grid of numbers.
#[derive(Debug)]
pub(crate) struct VdbGrid {
    /// World space from index space, where voxel centres are whole numbers.
    pub(crate) world_from_index: DAffine3,
    /// Meaning of its numbers, such as `fog volume` or `level set`.
    pub(crate) class: String,
    /// Value of all voxels outside its tree.
    pub(crate) background: f32,
    pub(crate) tree: Tree,
}

const MAGIC: i64 = 0x5644_4220;
const OLDEST: u32 = 218;
const NEWEST: u32 = 225;
/// First version with a map as transform.
const MAPS: u32 = 219;
/// First version in which the grid's head states the compression.
const PACKED: u32 = 220;

impl Vdb {
    /// Whether the first bytes are those of a VDB file.
    pub(crate) fn is(head: &[u8]) -> bool {
        Self::is_nano(head) || head.starts_with(&MAGIC.to_le_bytes())
    }

    /// Whether a head is that of `NanoVDB`.
    pub(crate) fn is_nano(head: &[u8]) -> bool {
        nano::is(head)
    }

    /// Reads the heads of all grids.
    pub(crate) fn new(bytes: Vec<u8>) -> Result<Self, VolumeFault> {
        if nano::is(&bytes) {
            let (nano, unread) = nano::heads(&bytes)?;
            let (heads, colors) = Default::default();
            return Ok(Self { bytes, version: 0, zip: false, heads, colors, nano, unread });
        }
        let mut input = Input::new(&bytes, 0)?;
        if input.i64("the head of the file")? != MAGIC {
            return Err(VolumeFault::new("not an OpenVDB file", "name a .vdb file"));
        }
        let version = input.u32("the version")?;
        if !(OLDEST..=NEWEST).contains(&version) {
            let message = format!("version {version} of OpenVDB's files");
            let help = "versions 218 to 225 are read: write the file with OpenVDB 1.0 to 12";
            return Err(VolumeFault::new(message, help));
        }
        input.take(8, "the version of the library")?;
        let has_offsets = input.u8("the head of the file")? != 0;
        let zip = match version {
            PACKED..NODE_MASKS => input.u8("the head of the file")? != 0,
            _ => true,
        };
        input.take(36, "the id of the file")?;
        metadata(&mut input)?;
        let count = input.u32("the number of grids")?;
        let mut at = input.at();
        let (heads, colors, nano, unread) = Default::default();
        let mut vdb = Self { bytes, version, zip, heads, colors, nano, unread };
        for i in 0..count {
            let Some(next) = vdb.head(at, has_offsets)? else {
                vdb.unread.push(format!("{} grids behind it", count - i - 1));
                break;
            };
            at = next;
        }
        Ok(vdb)
    }

    /// Reads the head of a grid; returns the offset of the next one, if known.
    fn head(&mut self, at: usize, has_offsets: bool) -> Result<Option<usize>, VolumeFault> {
        /// Suffix of types whose nodes have half floats.
        const HALVES: &str = "_HalfFloat";
        const WHAT: &str = "the head of a grid";
        let mut input = Input::new(&self.bytes, at)?;
        let unique = input.text(WHAT)?;
        let kind = input.text(WHAT)?;
        let instance_of = input.text(WHAT)?;
        input.take(16, WHAT)?;
        let end = input.i64(WHAT)?;
        let start = input.at();
        let (tree, is_half) = match kind.strip_suffix(HALVES) {
            Some(tree) => (tree, true),
            None => (&*kind, false),
        };
        // A separator and a suffix distinguish grids of the same name.
        let name = unique.split('\x1e').next().unwrap_or_default().to_owned();
        let number = match tree {
            "Tree_half_5_4_3" => Some((VdbNumber::Half, 1)),
            "Tree_float_5_4_3" => Some((VdbNumber::Float, 1)),
            "Tree_double_5_4_3" => Some((VdbNumber::Double, 1)),
            "Tree_vec3s_5_4_3" => Some((VdbNumber::Float, 3)),
            "Tree_vec3d_5_4_3" => Some((VdbNumber::Double, 3)),
            _ => None,
        };
        let unread = match number {
            _ if !instance_of.is_empty() => format!("it is an instance of {}", shown(&instance_of)),
            Some((number, width)) => {
                let heads = if width == 1 { &mut self.heads } else { &mut self.colors };
                heads.push(Head { name, number, width, is_half, start });
                return self.end_of(start, end, has_offsets, width, &unique);
            }
            None if tree.starts_with("Tree_ptdataidx") => "it has points".to_owned(),
            None => format!("its type is {}", shown(tree)),
        };
        self.unread.push(format!("grid {} is not read: {unread}", shown(&unique)));
        self.end_of(start, end, has_offsets, 0, &unique)
    }

    /// Offset of the end of a grid that begins at byte `start` and whose head ends at `end`; `width`: of the
    /// last head, 0 for a grid that is not read.
    fn end_of(
        &self,
        start: usize,
        end: i64,
        has_offsets: bool,
        width: usize,
        name: &str,
    ) -> Result<Option<usize>, VolumeFault> {
        if has_offsets {
            let next =
                usize::try_from(end).ok().filter(|&end| start <= end && end <= self.bytes.len());
            let message =
                || format!("the grid {} ends at byte {end}, outside of the file", shown(name));
            return next.map(Some).ok_or_else(|| VolumeFault::damaged(message()));
        }
        let head = match width {
            0 => None,
            1 => self.heads.last(),
            _ => self.colors.last(),
        };
        head.map(|head| self.read_head(head, true, 0).map(|(_, end)| end)).transpose()
    }

    /// Names of the grids of numbers.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        let nano = self.nano.iter().map(|head| &*head.name);
        self.heads.iter().map(|head| &*head.name).chain(nano)
    }

    /// Reads a grid by its index in [`Self::names`]; without its leaves' values unless `has_values`.
    pub(crate) fn read(&self, i: usize, has_values: bool) -> Result<VdbGrid, VolumeFault> {
        if let Some(head) = self.nano.get(i) {
            return self.read_nano(head, has_values).map_err(|fault| of_grid(&head.name, &fault));
        }
        let head = &self.heads[i];
        self.read_head(head, has_values, 0).map(|(grid, _)| grid)
    }

    /// Names of the grids of colours.
    pub(crate) fn color_names(&self) -> impl Iterator<Item = &str> {
        self.colors.iter().map(|head| &*head.name)
    }

    /// Reads a channel of a grid by its index in [`Self::color_names`].
    pub(crate) fn read_color(&self, i: usize, channel: usize) -> Result<VdbGrid, VolumeFault> {
        self.read_head(&self.colors[i], true, channel).map(|(grid, _)| grid)
    }

    /// The grid, and the offset of its end.
    fn read_head(
        &self,
        head: &Head,
        has_values: bool,
        channel: usize,
    ) -> Result<(VdbGrid, usize), VolumeFault> {
        let grid = self.read_grid(head, has_values, channel);
        grid.map_err(|fault| of_grid(&head.name, &fault))
    }

    fn read_grid(
        &self,
        head: &Head,
        has_values: bool,
        channel: usize,
    ) -> Result<(VdbGrid, usize), VolumeFault> {
        const ZIP: u32 = 1;
        const MASKED: u32 = 2;
        const BLOSC: u32 = 4;
        let mut input = Input::new(&self.bytes, head.start)?;
        let usual = if self.zip { ZIP } else { 0 };
        let is_own = self.version >= NODE_MASKS;
        let packed = if is_own { input.u32("the compression")? } else { usual };
        if packed > ZIP | MASKED | BLOSC {
            let help = "write the file with zip or Blosc LZ4, as OpenVDB does";
            return Err(VolumeFault::new(format!("compression {packed}"), help));
        }
        let class = metadata(&mut input)?;
        let world_from_index = transform(&mut input, self.version)?;
        let mut encoding = Encoding {
            version: self.version,
            number: head.number,
            stored: if head.is_half { VdbNumber::Half } else { head.number },
            width: head.width,
            channel,
            is_filled: head.width > 1,
            zip: packed & ZIP != 0,
            blosc: packed & BLOSC != 0,
            masked: packed & MASKED != 0,
            background: 0.0,
        };
        let topology = Topology {
            input: &mut input,
            encoding: &mut encoding,
            scratch: Scratch::default(),
            tree: Tree::default(),
        };
        let mut tree = topology.read()?;
        if has_values {
            tree.read_leaves(&mut input, &encoding)?;
        }
        let background = encoding.background;
        Ok((VdbGrid { world_from_index, class, background, tree }, input.at()))
    }
}

/// A grid's fault, with the grid's name.
fn of_grid(name: &str, fault: &VolumeFault) -> VolumeFault {
    VolumeFault::new(format!("grid {}: {}", shown(name), fault.message), fault.help)
}

/// A name for messages.
fn shown(name: &str) -> String {
    crate::error::quoted(name)
}

/// Reads named values; returns that of `class`.
fn metadata(input: &mut Input<'_>) -> Result<String, VolumeFault> {
    const WHAT: &str = "metadata";
    let mut class = String::new();
    for _ in 0..input.u32(WHAT)? {
        let name = input.text(WHAT)?;
        input.text(WHAT)?;
        let value = input.text(WHAT)?;
        if name == "class" {
            class = value;
        }
    }
    Ok(class)
}

/// Reads a transform. `OpenVDB` multiplies row vectors: its rows are our columns.
fn transform(input: &mut Input<'_>, version: u32) -> Result<DAffine3, VolumeFault> {
    const WHAT: &str = "the transform";
    let matrix = |input: &mut Input<'_>| -> Result<DMat4, VolumeFault> {
        let mut numbers = [0.0; 16];
        for number in &mut numbers {
            *number = input.f64(WHAT)?;
        }
        Ok(DMat4::from_cols_array(&numbers))
    };
    let scaled = |input: &mut Input<'_>, translation: DVec3| -> Result<DAffine3, VolumeFault> {
        let scale = input.dvec3(WHAT)?;
        // Voxel sizes and inverses, which follow from the scale.
        input.take(4 * 24, WHAT)?;
        Ok(DAffine3 { matrix3: DMat3::from_diagonal(scale), translation })
    };
    let kind = input.text(WHAT)?;
    let affine = match &*kind {
        "LinearTransform" if version < MAPS => {
            // Bounds, then world from local, local from world, local from voxel, voxel from local.
            input.take(24, WHAT)?;
            let world_from_local = matrix(input)?;
            matrix(input)?;
            let local_from_voxel = matrix(input)?;
            matrix(input)?;
            DAffine3::from_mat4(world_from_local * local_from_voxel)
        }
        "AffineMap" | "UnitaryMap" => DAffine3::from_mat4(matrix(input)?),
        "ScaleMap" | "UniformScaleMap" => scaled(input, DVec3::ZERO)?,
        "TranslationMap" => DAffine3::from_translation(input.dvec3(WHAT)?),
        "ScaleTranslateMap" | "UniformScaleTranslateMap" => {
            let translation = input.dvec3(WHAT)?;
            scaled(input, translation)?
        }
        _ => {
            let help = "resample it to a grid with a linear transform";
            return Err(VolumeFault::new(format!("its transform is {}", shown(&kind)), help));
        }
    };
    check(&affine)?;
    Ok(affine)
}

/// Refuses a transform without an inverse.
fn check(affine: &DAffine3) -> Result<(), VolumeFault> {
    let (matrix, determinant) = (affine.matrix3, affine.matrix3.determinant());
    if !affine.is_finite() || !determinant.is_normal() || !matrix.inverse().is_finite() {
        return Err(VolumeFault::damaged("its transform is not finite or cannot be inverted"));
    }
    Ok(())
}
