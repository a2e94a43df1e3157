//! Resources of the steps: their sizes as formulas, and their initial contents.
use super::{KEYS, PAIRS, SortOf};
use crate::{
    model::TILE_SIZE,
    records::{
        CASTER_TEXELS, FOOTPRINT_TEXELS, GpuMaterial, GpuView, MAX_MATERIALS, MAX_VIEWS,
        SETUP_TEXELS, TRIANGLE_TEXELS,
    },
    stage::{
        accumulate::COMPOSED_TEXELS,
        bin::{self, BatchCounters, Dispatch, Segment},
        curve::{PARTIAL_BYTES, PARTIAL_COUNT},
        formula::{
            Formula::{self, Is, Of, Product, Quotient},
            Number, Numbers,
        },
        project::{self, Chunk},
        sort::{HISTOGRAM_WIDTH, PAIR_FORMAT, TOTAL_ROW, pass_params},
    },
};
use wgpu::TextureFormat::{self, R32Float, R32Uint, Rgba8UnormSrgb, Rgba16Float, Rgba32Uint};

/// Kind and size of a resource.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A storage buffer of so many elements of so many bytes.
    Storage { element: u64, count: Formula },
    /// A storage buffer of these `u32`.
    Words { words: &'static [Formula] },
    /// A uniform buffer of these `u32`, the fields of the struct in order.
    Uniform { fields: &'static [Formula] },
    /// A uniform buffer for each digit of a sort.
    UniformOfDigits { fields: &'static [Formula], sort: SortOf },
    /// A uniform buffer of the host, of so many bytes.
    HostUniform { size: u64 },
    /// A 2D texture, 4096 texels wide, of at least so many texels.
    Records { format: TextureFormat, texels: Formula },
    /// A 2D texture for a sort.
    Texture { format: TextureFormat, size: [Formula; 2], sort: SortOf },
    /// A 2D array.
    Array { format: TextureFormat, size: [Formula; 3] },
}

/// Contents of a resource before the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Initial {
    /// Anything: it is written before it is read.
    Any,
    Zero,
    /// Zero before the first frame; each frame resets it.
    ZeroOnce,
    /// Anything; or 1.0 in each texel, if the blocking list is left out because it has no casters.
    One,
    /// Written by the host.
    Host,
}

#[derive(Clone, Copy, Debug)]
pub struct ResourceDesc {
    pub name: &'static str,
    pub kind: Kind,
    pub initial: Initial,
    /// Description, unless the name suffices.
    pub note: &'static str,
}

const fn new(name: &'static str, kind: Kind, initial: Initial, note: &'static str) -> ResourceDesc {
    ResourceDesc { name, kind, initial, note }
}

const FOOTPRINTS: Formula = Of(Number::FootprintCount);
const TILES: Formula = Of(Number::TileCount);
const CAPACITY: Formula = Of(Number::PairCapacity);
const SUMMED: Formula = Product(&TILES, &Is((TILE_SIZE * TILE_SIZE) as u64));
const CURVE_LAYERS: Formula = Product(&Of(Number::Layers), &Quotient(&Of(Number::Nodes), &Is(2)));
const ATLAS: [Formula; 3] = [Of(Number::Width), Of(Number::Height), Of(Number::Layers)];

const fn words(count: Formula) -> Kind {
    Kind::Storage { element: 4, count }
}

const fn records(format: TextureFormat, texels: Formula) -> Kind {
    Kind::Records { format, texels }
}

const fn of_host<T>(count: usize) -> Kind {
    Kind::HostUniform { size: (size_of::<T>() * count) as u64 }
}

const fn chunks(count: Number) -> Kind {
    Kind::Storage { element: size_of::<Chunk>() as u64, count: Of(count) }
}

const fn histograms(sort: SortOf) -> Kind {
    const SIZE: [Formula; 2] = [HISTOGRAM_WIDTH, Is(TOTAL_ROW as u64 + 1)];
    Kind::Texture { format: R32Uint, size: SIZE, sort }
}

const DEPTH_COUNT: [Formula; 1] = [FOOTPRINTS];
const PARTICLE_PARAMS: [Formula; 5] = project::params(Number::ParticleChunks);
const TRIANGLE_PARAMS: [Formula; 5] = project::params(Number::TriangleChunks);
const TINY_PARAMS: [Formula; 5] = project::params(Number::TinyChunks);
const DEPTH_PASS: [Formula; 4] = pass_params(0);
const TILE_PASS: [Formula; 4] = pass_params(bin::PAIR_COUNT_INDEX);

/// All resources of the steps. A list may overwrite the intermediate data of the one before.
pub const RESOURCES: &[ResourceDesc] = &{
    use Initial::{Any, Host, One, Zero, ZeroOnce};
    [
        new("views", of_host::<GpuView>(MAX_VIEWS), Host, "GpuView of each view of the batch"),
        new(
            "materials",
            of_host::<GpuMaterial>(MAX_MATERIALS),
            Host,
            "GpuMaterial of each material",
        ),
        new(
            "casters",
            records(Rgba32Uint, Product(&Of(Number::CasterCount), &Is(CASTER_TEXELS as u64))),
            Host,
            "Caster of each particle; then, where some material dithers by blue noise, its ranks",
        ),
        new(
            "triangles",
            records(Rgba32Uint, Product(&Of(Number::TriangleCount), &Is(TRIANGLE_TEXELS as u64))),
            Host,
            "TriangleRecord of each triangle",
        ),
        new(
            "images",
            Kind::Array {
                format: Rgba8UnormSrgb,
                size: [Of(Number::ImageWidth), Of(Number::ImageHeight), Of(Number::ImageCount)],
            },
            Host,
            "textures of materials, a layer each; one texel where there are none",
        ),
        new("particle_chunks", chunks(Number::ParticleChunks), Host, "Chunk of particles, each"),
        new("triangle_chunks", chunks(Number::TriangleChunks), Host, "Chunk of triangles, each"),
        new("tiny_chunks", chunks(Number::TinyChunks), Host, "some of `particle_chunks`"),
        new("particle_params", Kind::Uniform { fields: &PARTICLE_PARAMS }, Host, "ProjectParams"),
        new("triangle_params", Kind::Uniform { fields: &TRIANGLE_PARAMS }, Host, "ProjectParams"),
        new("tiny_params", Kind::Uniform { fields: &TINY_PARAMS }, Host, "ProjectParams"),
        new("bin_params", Kind::Uniform { fields: &bin::PARAMS }, Host, "BinParams"),
        new(
            "depth_pass",
            Kind::UniformOfDigits { fields: &DEPTH_PASS, sort: SortOf::Depth },
            Host,
            "SortPass",
        ),
        new(
            "tile_pass",
            Kind::UniformOfDigits { fields: &TILE_PASS, sort: SortOf::Tile },
            Host,
            "SortPass",
        ),
        new(
            "depth_count",
            Kind::Words { words: &DEPTH_COUNT },
            Host,
            "`footprint_count`, which the sort by depth reads",
        ),
        new(
            "footprints",
            records(Rgba32Uint, Product(&FOOTPRINTS, &Is(FOOTPRINT_TEXELS as u64))),
            Any,
            "Footprint of each (caster, view)",
        ),
        new(KEYS[0], records(PAIR_FORMAT, FOOTPRINTS), Any, "(depth key, footprint)"),
        new(KEYS[1], records(PAIR_FORMAT, FOOTPRINTS), Any, "the same, from digit to digit"),
        new("rects", records(PAIR_FORMAT, FOOTPRINTS), Any, "tiles of each footprint"),
        new(
            "setups",
            records(Rgba32Uint, Product(&Of(Number::SetupCount), &Is(SETUP_TEXELS as u64))),
            Any,
            "TriangleSetup of each (triangle, view)",
        ),
        new("depth_histograms", histograms(SortOf::Depth), Any, ""),
        new("tile_histograms", histograms(SortOf::Tile), Any, ""),
        new(PAIRS[0], records(PAIR_FORMAT, CAPACITY), Any, "(tile, footprint)"),
        new(PAIRS[1], records(PAIR_FORMAT, CAPACITY), Any, "the same, from digit to digit"),
        new("tiles", records(Rgba32Uint, TILES), Any, "pairs of each tile"),
        new("scattered_tiles", words(TILES), Zero, "1 where something was scattered"),
        new("nothing_scattered", words(TILES), ZeroOnce, "for curves, which take that themselves"),
        new("merged_tiles", words(TILES), Any, "tiles that several workgroups added to"),
        new(
            "segments",
            Kind::Storage { element: size_of::<Segment>() as u64, count: bin::SEGMENT_CAPACITY },
            Any,
            "Segment of each part of a long tile",
        ),
        new("run_offsets", words(bin::MAX_RUNS), Any, ""),
        new("overflow", words(FOOTPRINTS), Any, "footprints whose pairs did not fit"),
        new(
            "dispatches",
            Kind::Storage { element: 16, count: Is(Dispatch::COUNT) },
            Zero,
            "workgroup counts, for indirect dispatches: x, y, z and their sum",
        ),
        new(
            "counters",
            Kind::Storage { element: size_of::<BatchCounters>() as u64, count: Is(1) },
            Zero,
            "BatchCounters: what the list made",
        ),
        new(
            "sum_red",
            words(SUMMED),
            ZeroOnce,
            "of each texel; native: a texture of r32uint records",
        ),
        new("sum_green", words(SUMMED), ZeroOnce, "as `sum_red`"),
        new("sum_blue", words(SUMMED), ZeroOnce, "as `sum_red`"),
        new("nearness", words(SUMMED), ZeroOnce, "as `sum_red`"),
        new("small_depths", words(Is(1)), Any, "bound, but not read where HAS_SMALL is false"),
        new(
            "partials",
            Kind::Storage {
                element: 16,
                count: Product(&PARTIAL_COUNT, &Quotient(&PARTIAL_BYTES, &Is(16))),
            },
            Any,
            "curves of segments; without curves 16 bytes will do",
        ),
        new(
            "composed",
            Kind::Storage { element: 32, count: COMPOSED_TEXELS },
            Any,
            "what segments do to texels, where they are composed one by one",
        ),
        new("filters", Kind::Array { format: Rgba16Float, size: ATLAS }, Any, "F"),
        new("nearests", Kind::Array { format: R32Float, size: ATLAS }, Any, "D"),
        new("opaques", Kind::Array { format: R32Float, size: ATLAS }, One, "Z"),
        new(
            "curves",
            Kind::Array {
                format: Rgba32Uint,
                size: [Of(Number::Width), Of(Number::Height), CURVE_LAYERS],
            },
            Any,
            "two nodes a texel, `nodes` / 2 layers after another; one texel where there are none",
        ),
    ]
};

/// Sums of light, and nearness: buffers, or textures of r32uint records on the native tier.
pub const SUMS: [&str; 4] = ["sum_red", "sum_green", "sum_blue", "nearness"];

/// Resource of a name.
pub fn resource(name: &str) -> Option<&'static ResourceDesc> {
    RESOURCES.iter().find(|resource| resource.name == name)
}

impl ResourceDesc {
    /// Number of elements or texels; 0 for resources without any.
    pub fn count(&self, numbers: &Numbers) -> u64 {
        match self.kind {
            Kind::Storage { count, .. } => count.of(numbers),
            Kind::Records { texels, .. } => texels.of(numbers),
            Kind::Texture { size, .. } => size.iter().map(|edge| edge.of(numbers)).product(),
            Kind::Array { size, .. } => size.iter().map(|edge| edge.of(numbers)).product(),
            Kind::Words { .. }
            | Kind::Uniform { .. }
            | Kind::UniformOfDigits { .. }
            | Kind::HostUniform { .. } => 0,
        }
    }
}
