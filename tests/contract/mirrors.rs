//! Constants that Rust and WGSL share are equal, and every constant of the WGSL is known: it has a mirror,
//! or belongs to the kernels alone.
use gobo::{
    internals::{
        gpu::Library,
        records::{
            AIR_CELL, ALL_LIGHTS, AREA_FLAT, AREA_SPHERE, AREA_SUN, AREA_TEXELS, BACK_BIT,
            BLOCK_TEXELS, BLUE_SIZE, CASTER_TEXELS, COLORED_BIT, CURVE_SEGMENT, DEPTH_TAG_BITS,
            FARTHEST_PLACE, FILTER_BOX, FILTER_DISC, FILTER_SPLINE, FIXED_ONE, FOOTPRINT_TEXELS,
            FORMAT_RG11B10UFLOAT, FORMAT_RGBA8UNORM, FORMAT_RGBA16FLOAT, INVISIBLE, JOINED_BIT,
            LEVELED_TEXELS, LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_SPOT, LIGHT_TEXELS, MAX_AREAS,
            MAX_MATERIALS, MAX_TAU, MAX_VIEWS, MIN_RADIUS, NO_OWNER, NO_TEXTURE, NORMALS_NONE,
            NORMALS_UNORM, OPACITY_SCALE, PART_FACE, PART_WHOLE, PART_WINDOW, RADIUS_STEPS,
            REACH_TEXELS, ROW, SATURATED, SETUP_TEXELS, SHAFTS_BIT, SKIRT, SLOTS, SPLINE_REACH,
            STEPS_AT_ONCE, TRIANGLE_BIT, TRIANGLE_TEXELS, UNIT, VIEW_TEXELS,
        },
        reference::{
            FAINT, accumulate, air,
            curve::{
                self,
                tile::{ROUNDING, SLAB_PAIRS, TRACE},
            },
            dither::{BLOCK_BITS, FARTHEST},
            mask,
            order::WAITING,
            project::{MIN_COSINE, SLACK},
            resolve::BLACK,
            shading::{self, receive, taps},
        },
        shadows::cull::frustum,
        stage::{
            bin::{Dispatch, RUN_PAIRS, SEGMENT_LENGTH, TILE_LANES},
            project::{self, CHUNK_SIZE},
            shade,
            sort::{FEW_BITS, MAX_BITS, PAIR_ROW, TOTAL_ROW, WIDE_BLOCK},
        },
    },
    model::{
        LEVELS, MAX_GAIN, Pattern, Profile, ROUGH_SIZE, Receives, Shape, TILE_SIZE, Transfer,
        emitter::{EmitterShape, STEP, STEPS_PER_SECOND, TRIES},
    },
};
use std::collections::{BTreeMap, BTreeSet};

/// Value in Rust, by name in WGSL.
fn mirrors() -> BTreeMap<&'static str, f64> {
    let whole = [
        ("AIR_CELL", AIR_CELL),
        ("MAX_LIT_SAMPLES", air::MAX_LIT_SAMPLES),
        ("MAX_AIR_SAMPLES", air::MAX_AIR_SAMPLES),
        ("ALL_LIGHTS", ALL_LIGHTS),
        ("AREA_FLAT", AREA_FLAT),
        ("AREA_SPHERE", AREA_SPHERE),
        ("AREA_SUN", AREA_SUN),
        ("AREA_TEXELS", AREA_TEXELS),
        ("BACK_BIT", BACK_BIT),
        ("BINS", curve::mean::BINS),
        ("BLOCK_BITS", BLOCK_BITS),
        ("BLOCK_TEXELS", BLOCK_TEXELS),
        ("BLUE_SIZE", BLUE_SIZE),
        ("CARRIED", shade::CARRIED),
        ("CASTER_TEXELS", CASTER_TEXELS),
        ("CHUNK_SIZE", CHUNK_SIZE),
        ("CURVE_SEGMENT", CURVE_SEGMENT),
        ("DARK", u32::from(curve::DARK)),
        ("DEPTH_TAG_BITS", DEPTH_TAG_BITS),
        ("DEPTH_TAG_MASK", (1 << DEPTH_TAG_BITS) - 1),
        ("FILTER_BOX", FILTER_BOX),
        ("FILTER_DISC", FILTER_DISC),
        ("FILTER_SPLINE", FILTER_SPLINE),
        ("FOOTPRINT_TEXELS", FOOTPRINT_TEXELS),
        ("FORMAT_RG11B10UFLOAT", FORMAT_RG11B10UFLOAT),
        ("FORMAT_RGBA16FLOAT", FORMAT_RGBA16FLOAT),
        ("FORMAT_RGBA8UNORM", FORMAT_RGBA8UNORM),
        ("INVISIBLE", INVISIBLE),
        ("LAYERED_HEAD", shade::LAYERED_HEAD),
        ("LAYER_TEXELS", shade::LAYER_TEXELS),
        ("LIST_COUNT", shade::LIST_COUNT),
        ("LIST_HEAD", shade::LIST_HEAD),
        ("LIST_ROWS", shade::LIST_ROWS),
        ("LEVELED_TEXELS", LEVELED_TEXELS),
        ("LEVELS_AROUND", LEVELS),
        ("LIGHT_DIRECTIONAL", LIGHT_DIRECTIONAL),
        ("LIGHT_POINT", LIGHT_POINT),
        ("LIGHT_SPOT", LIGHT_SPOT),
        ("LIGHT_TEXELS", LIGHT_TEXELS),
        ("MAX_AREAS", MAX_AREAS as u32),
        ("MAX_MATERIALS", MAX_MATERIALS as u32),
        ("MAX_VIEWS", MAX_VIEWS as u32),
        ("MERGED_DISPATCH", Dispatch::Merged as u32),
        ("NO_LIST", shade::NO_LIST),
        ("NO_OWNER", u32::from(NO_OWNER)),
        ("NO_TEXTURE", NO_TEXTURE),
        ("OVERFLOW_DISPATCH", Dispatch::Overflow as u32),
        ("MAX_X", project::grid(u32::MAX)[0]),
        ("PAIR_ROW", PAIR_ROW),
        ("TILE_LANES", TILE_LANES),
        ("WAITING", WAITING as u32),
        ("PANE_LIST", shade::PANE_LIST),
        ("PART_COUNT_DISPATCH", Dispatch::PartCount as u32),
        ("PARTED_DISPATCH", Dispatch::Parted as u32),
        ("PART_DISPATCH", Dispatch::Part as u32),
        ("PART_FACE", PART_FACE),
        ("PART_WHOLE", PART_WHOLE),
        ("PART_WINDOW", PART_WINDOW),
        ("PATTERN_BAYER16", Pattern::Bayer16 as u32),
        ("PATTERN_BAYER2", Pattern::Bayer2 as u32),
        ("PATTERN_BAYER4", Pattern::Bayer4 as u32),
        ("PATTERN_BAYER8", Pattern::Bayer8 as u32),
        ("PATTERN_BLUE", Pattern::Blue as u32),
        ("PATTERN_CHECKERBOARD", Pattern::Checkerboard as u32),
        ("PATTERN_HASHED", Pattern::Hashed as u32),
        ("PATTERN_IGN", Pattern::Ign as u32),
        ("POINT_LANES", shade::POINT_LANES),
        ("POINT_TEXELS", shade::POINT_TEXELS),
        ("PROFILE_FLAT", Profile::Flat as u32),
        ("PROFILE_SOFT", Profile::Soft as u32),
        ("REACH_TEXELS", REACH_TEXELS),
        ("COLORED_BIT", COLORED_BIT),
        ("JOINED_BIT", JOINED_BIT),
        ("NORMALS_NONE", NORMALS_NONE),
        ("NORMALS_UNORM", NORMALS_UNORM),
        ("SLOTS", SLOTS),
        ("RECEIVES_CURVE", Receives::Curve as u32),
        ("RECEIVES_NEAREST", Receives::Nearest as u32),
        ("RECEIVES_OPAQUE", Receives::Opaque as u32),
        ("RECEIVES_OTHERS", Receives::Others as u32),
        ("ROUGH_SIZE", ROUGH_SIZE),
        ("ROUND_LENGTH", shade::ROUND_LENGTH),
        ("ROW", ROW),
        ("RUN_PAIRS", RUN_PAIRS),
        ("SEGMENT_DISPATCH", Dispatch::Segment as u32),
        ("SEGMENT_LENGTH", SEGMENT_LENGTH),
        ("SATURATED", SATURATED),
        ("SETUP_TEXELS", SETUP_TEXELS),
        ("SHAFTS_BIT", SHAFTS_BIT),
        ("SHAPE_DISC", Shape::Disc as u32),
        ("SHAPE_PUFF", Shape::Puff as u32),
        ("SHAPE_QUAD", Shape::Quad as u32),
        ("SHORTEST", curve::bodies::SHORTEST),
        ("SKIRT", SKIRT),
        ("SLAB_PAIRS", SLAB_PAIRS as u32),
        ("EMITTER_BOX", EmitterShape::Box as u32),
        ("EMITTER_DISC", EmitterShape::Disc as u32),
        ("EMITTER_POINT", EmitterShape::Point as u32),
        ("EMITTER_SPHERE", EmitterShape::Sphere as u32),
        ("STEPS_AT_ONCE", STEPS_AT_ONCE),
        ("SURFACE_LIST", shade::SURFACE_LIST),
        ("TILE_SIZE", TILE_SIZE),
        ("TOTAL_ROW", TOTAL_ROW),
        ("TRANSFER_CUTOUT", Transfer::Cutout as u32),
        ("TRANSFER_DITHER", Transfer::Dither as u32),
        ("TRANSFER_FILTER", Transfer::Filter as u32),
        ("TRANSFER_GAIN", Transfer::Gain as u32),
        ("TRANSFER_NONE", Transfer::None as u32),
        ("TRANSFER_OPAQUE", Transfer::Opaque as u32),
        ("TRANSFER_OVER", Transfer::Over as u32),
        ("TRANSFER_SMOKE", Transfer::Smoke as u32),
        ("TRANSFER_STAIN", Transfer::Stain as u32),
        ("TRIES", TRIES),
        ("TRIANGLE_BIT", TRIANGLE_BIT),
        ("TRIANGLE_TEXELS", TRIANGLE_TEXELS),
        ("VIEW_TEXELS", VIEW_TEXELS),
    ];
    let real = [
        ("BLACK", BLACK),
        ("BOX_ROUNDING", frustum::ROUNDING),
        ("BOX_SKEW", frustum::SKEWED),
        ("DARKEST_LOG", curve::DARKEST_LOG),
        ("DEPTHS", curve::DEPTHS),
        ("EDGE_ON", receive::EDGE_ON),
        ("FAINT", FAINT),
        ("FARTHEST", FARTHEST),
        ("FARTHEST_PLACE", FARTHEST_PLACE),
        ("FIXED_ONE", FIXED_ONE),
        ("GOLDEN_COSINE", taps::GOLDEN.x),
        ("GOLDEN_SINE", taps::GOLDEN.y),
        ("HEAD_ON", shading::HEAD_ON),
        ("MIN_BEND", curve::bodies::MIN_BEND),
        ("MIN_INCIDENCE", receive::MIN_INCIDENCE),
        ("MIN_DISTANCE", f32::MIN_POSITIVE),
        ("MIN_REST", curve::MIN_REST),
        ("MIN_ROOT", curve::bodies::MIN_ROOT),
        ("LEVELS", curve::LEVELS),
        ("MAX_GAIN", MAX_GAIN),
        ("MAX_TAU", MAX_TAU),
        ("MIN_COSINE", MIN_COSINE),
        ("MIN_RADIUS", MIN_RADIUS),
        ("OCTAVES", curve::OCTAVES),
        ("OPACITY_SCALE", OPACITY_SCALE),
        ("RADIUS_STEPS", RADIUS_STEPS),
        ("ROUNDING", ROUNDING),
        ("SLACK", SLACK),
        ("SPLINE_REACH", SPLINE_REACH),
        ("STEPS_PER_SECOND", STEPS_PER_SECOND as f32),
        ("STEP_SECONDS", STEP),
        ("THIN", air::THIN),
        ("NEAREST", air::NEAREST),
        ("SAMPLE_ANGLE", air::SAMPLE_ANGLE),
        ("TINY", air::TINY),
        ("TOUCH", receive::TOUCH),
        ("TRACE", TRACE),
        ("UNIT", UNIT),
        ("MIN_FACING", mask::MIN_FACING),
        ("MIN_WEIGHT", mask::MIN_WEIGHT),
        ("TIED", mask::TIED),
        ("TURNED", mask::TURNED),
        ("WIDTHS", mask::WIDTHS),
        ("VISIBLE_OPACITY", accumulate::VISIBLE_OPACITY),
    ];
    let whole = whole.into_iter().map(|(name, value)| (name, f64::from(value)));
    whole.chain(real.into_iter().map(|(name, value)| (name, f64::from(value)))).collect()
}

/// Constants without a mirror in Rust.
const KERNELS_OWN: &[&str] = &[
    "ALL_LANES",
    "FULL",
    "BRIGHTEST",
    "OVERLAP",
    "PIXELS_OF_TILE",
    "SMALL",
    "BANDS",
    "CHANGES",
    "CHANGE_WORDS",
    "CULL_LANES",
    "DITHERED_BIT",
    "EDGE_ON_PLANE",
    "EDGE_SLACK",
    "EMPTY_RUN",
    "LANES",
    "LAST_DEPTH",
    "MIN_TAU",
    "LIST_LENGTH",
    "MANY",
    "MAX_WORKGROUPS",
    "METAL_STEPS",
    "NO_CASTER",
    "MISS",
    "NEVER",
    "NONE_WAITS",
    "NOWHERE",
    "NO_PANE",
    "NO_SURFACE",
    "OFFSET_SHIFT",
    "ONE_BITS",
    "OVERFLOW_LANES",
    "OVERFLOW_SLICES",
    "PARTIAL_TEXELS",
    "PER_FOUR_PI",
    "PER_PI",
    "PER_TWO_PI",
    "POINT_NONE",
    "POINT_PARTICLE",
    "POINT_PANE",
    "POINT_SOLID",
    "POLISH_STEPS",
    "QUEUE",
    "ROUNDS",
    "ROUND_BIT",
    "ROWS",
    "ROW_COUNT",
    "HIT_WORDS",
    "NODE_LANES",
    "SHARES",
    "SHARE_LANES",
    "node_count",
    "RUN",
    "SCATTERED",
    "SEEKS",
    "SPAN_SLACK",
    "SQRT_2",
    "STEP",
    "STRETCH",
    "TURN",
    "WARP_COUNT",
    "WARP_SIZE",
    "WORDS",
    "WORKGROUP_SIZE",
    "AROUND",
    "EVIDENCE",
    "FADE",
    "MIN",
    "MIN_OPEN",
    "MIN_LIT",
    "LIT",
    "DIM",
    "EARLY",
    "LONGEST",
    "BLOCK_REACH",
    "NOTHING",
    "SHARP",
    "WIDEST",
];

/// Value of `const NAME: u32 = 0xffu;` or `f32`, rounded as in kernels.
fn value(declaration: &str) -> Option<f64> {
    let (_, value) = declaration.split_once('=')?;
    let value = value.split(';').next()?.trim();
    let digits = value.trim_end_matches('u');
    match digits.strip_prefix("0x") {
        Some(hex) => u32::from_str_radix(hex, 16).ok().map(f64::from),
        None if value.ends_with('u') => digits.parse::<u32>().ok().map(f64::from),
        None => digits.parse::<f32>().ok().map(f64::from),
    }
}

#[test]
fn numbers_of_both_sides_are_the_same() {
    let mirrors = mirrors();
    let mut seen = BTreeSet::new();
    let items = Library::embedded().unwrap().items();
    for item in items.filter(|item| item.keyword == "const") {
        let place = format!("wgsl/{}:{} {}", item.file, item.line, item.name);
        // Blocks of the sort are as long as the product of two of the kernels' own.
        if item.name == "BLOCK" {
            assert_eq!(WIDE_BLOCK, 256 * 16);
        } else if item.name == "DIGITS" {
            let bits = if item.file.ends_with("_64.wgsl") { FEW_BITS } else { MAX_BITS };
            assert_eq!(value(item.text), Some(f64::from(1 << bits)), "{place}");
        } else if let Some(&mirror) = mirrors.get(item.name) {
            assert_eq!(value(item.text), Some(mirror), "{place}");
        } else {
            assert!(KERNELS_OWN.contains(&item.name), "{place}: what is it in Rust?");
        }
        seen.insert(item.name);
    }
    let known = mirrors.keys().copied().chain(KERNELS_OWN.iter().copied());
    let stale: Vec<_> = known.filter(|name| !seen.contains(name)).collect();
    assert_eq!(stale, [""; 0], "in no file");
}

/// The check can fail, even on the slightest difference.
#[test]
fn values_are_read_as_kernels_round_them() {
    assert_eq!(value("// Not 3.\nconst A: u32 = 0xffu; // = 2"), Some(255.0));
    assert_eq!(value("const A: u32 = 12u;"), Some(12.0));
    assert_eq!(value("const A: f32 = 0.1;"), Some(f64::from(0.1_f32)));
    assert_ne!(value("const A: f32 = 0.1000001;"), value("const A: f32 = 0.1;"));
    assert_eq!(value("const A: u32 = B * C;"), None);
}
