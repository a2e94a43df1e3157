//! Command line arguments of `gobo bench`.
use crate::values::{DeviceArguments, key_value};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct BenchArguments {
    /// Casters: 10k, 2m, 1g; more than 16m are rendered in shares, whose maps are joined
    #[arg(long, value_delimiter = ',', value_parser = count, default_value = "10k,100k,1m")]
    pub(super) casters: Vec<u32>,
    /// Mean diameter of the casters in the map [texels]; 6,16 where not given
    #[arg(long, value_delimiter = ',', value_parser = footprint)]
    pub(super) footprint: Vec<f32>,
    /// Opacity of the casters
    #[arg(long, value_delimiter = ',', value_parser = opacity, default_value = "0.02")]
    pub(super) opacity: Vec<f32>,
    /// Kind of the casters; the diameter of a splat is that of its longest axis, to where it ends
    #[arg(long, default_value = "disc", conflicts_with = "occlude")]
    pub(super) shape: ShapeName,
    /// The splats of a file instead, scaled to fill the map
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = [
            "shape", "occlude", "casters", "footprint", "opacity", "cases", "layout",
        ]
    )]
    pub(super) splats: Option<PathBuf>,
    /// The maps of a scene's first frame instead, with its own settings
    #[arg(
        long,
        value_name = "SCENE",
        conflicts_with_all = [
            "casters", "footprint", "opacity", "shape", "splats", "cases", "layout", "lights",
            "size", "vs", "occlude", "stage", "receiver", "nodes", "html",
        ]
    )]
    pub(super) scene: Option<PathBuf>,
    /// Replace a value of that scene file: light.sun.size=512
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value, requires = "scene")]
    pub(super) set: Vec<(String, String)>,
    /// Single cases instead of every combination of the three above; opacity 0.02 where not given
    #[arg(
        long = "case",
        value_delimiter = ',',
        value_parser = one_case,
        value_name = "CASTERSxTEXELS[@OPACITY]",
        conflicts_with_all = ["casters", "footprint", "opacity", "occlude"]
    )]
    pub(super) cases: Vec<OneCase>,
    /// Where the casters are in the map
    #[arg(long, value_delimiter = ',', default_value = "spread")]
    pub(super) layout: Vec<Layout>,
    /// Directional lights, each with a map of its own
    #[arg(long, value_delimiter = ',', value_parser = lights, default_value = "1")]
    pub(super) lights: Vec<u32>,
    /// Edge of a map [texels]
    #[arg(long, value_delimiter = ',', value_parser = size, default_value = "1024")]
    pub(super) size: Vec<u32>,
    /// Measure the raster pipeline too, and hold the maps against its maps
    #[arg(long)]
    pub(super) vs: Option<Baseline>,
    /// Opaque triangles instead, beside a depth-only raster pass; their bounding squares are 1.5,
    /// 4 and 12 texels wide where --footprint is not given
    #[arg(long, conflicts_with_all = ["opacity", "layout", "lights"])]
    pub(super) occlude: bool,
    /// Shadow masks of pictures at 1280 x 720 and 1920 x 1080 instead, beside PCF of 5 x 5 in shading; of 1,
    /// 4, 16 and 64 lights where --lights is not given
    #[arg(
        long,
        conflicts_with_all = [
            "vs", "occlude", "casters", "footprint", "opacity", "cases", "layout", "size",
            "receiver", "pair_budget", "html", "shape", "splats",
        ]
    )]
    pub(super) stage: Option<StageName>,
    /// Contents of the maps: nearest depth and filter, or curves as well
    #[arg(long, default_value = "nearest", conflicts_with_all = ["vs", "occlude"])]
    pub(super) receiver: ReceiverName,
    /// Nodes of a curve: 4, 8 or 16
    #[arg(long, value_parser = nodes, default_value_t = 8)]
    pub(super) nodes: u32,
    /// Measured frames of each path, after two to warm up; times are their median
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1000), default_value_t = 5)]
    pub(super) runs: u32,
    /// Pairs that a batch may hold at most
    #[arg(long, value_parser = count, value_name = "PAIRS")]
    pub(super) pair_budget: Option<u32>,
    /// Time each kernel too, in a frame whose every dispatch is a pass of its own
    #[arg(long, conflicts_with = "stage")]
    pub(super) kernels: bool,
    /// Measure each choice that the adapter's tuning leaves open beside the present one, and print the best
    #[arg(long, conflicts_with_all = ["vs", "occlude", "stage", "scene", "splats", "kernels", "against", "html"])]
    pub(super) tune: bool,
    /// Compare with the results of an earlier `--json`, case by case, and fail where one is slower than
    /// `--limit` allows
    #[arg(long, value_name = "FILE", conflicts_with = "stage")]
    pub(super) against: Option<PathBuf>,
    /// Most that a case's median time may be of the earlier one
    #[arg(long, value_parser = limit, default_value_t = 1.05, requires = "against")]
    pub(super) limit: f64,
    #[command(flatten)]
    pub(super) device: DeviceArguments,
    /// Write the results as JSON
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Write the results as a page with plots
    #[arg(long, value_name = "FILE")]
    pub(super) html: Option<PathBuf>,
}

/// A case given by `--case`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OneCase {
    pub(super) casters: u32,
    pub(super) footprint: f32,
    pub(super) opacity: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Baseline {
    Raster,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Layout {
    /// Evenly over the map
    Spread,
    /// In one corner: a sixteenth of the map
    Corner,
    /// All centred in one tile
    Tile,
    /// As in a file
    #[value(skip)]
    File,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ShapeName {
    /// Soft discs
    Disc,
    /// Splats, up to four times as long as thick
    Gaussian,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum StageName {
    Mask,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum ReceiverName {
    Nearest,
    Curve,
}

impl Layout {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Spread => "spread",
            Self::Corner => "corner",
            Self::Tile => "tile",
            Self::File => "file",
        }
    }
}

impl ShapeName {
    /// Name of its casters in the plural.
    pub(super) fn plural(self) -> &'static str {
        match self {
            Self::Disc => "discs",
            Self::Gaussian => "splats",
        }
    }
}

/// Most casters in a list.
pub(super) const MAX_LIST: u32 = 1 << 24;

/// Parses `500`, `10k`, `1.5m`, `1g`.
fn count(text: &str) -> Result<u32, String> {
    let expected = || format!("{text:?} is not a count such as 500, 10k or 1.5m");
    let lower = text.trim().to_ascii_lowercase();
    let (digits, factor) = match lower.strip_suffix('k') {
        Some(digits) => (digits, 1e3),
        None => match lower.strip_suffix('g') {
            Some(digits) => (digits, 1e9),
            None => lower.strip_suffix('m').map_or((&lower[..], 1.0), |digits| (digits, 1e6)),
        },
    };
    let value = digits.parse::<f64>().map_err(|_| expected())? * factor;
    if !(1.0..=4e9).contains(&value) {
        return Err(format!("{text} is not in 1..=4g"));
    }
    if (value - value.round()).abs() > 1e-6 {
        return Err(expected());
    }
    Ok(value.round() as u32)
}

fn within(text: &str, low: f32, high: f32) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(value) if (low..=high).contains(&value) => Ok(value),
        _ => Err(format!("{text:?} is not a number in {low}..={high}")),
    }
}

fn footprint(text: &str) -> Result<f32, String> {
    within(text, 0.05, 1024.0)
}

fn opacity(text: &str) -> Result<f32, String> {
    within(text, 1e-9, 1.0)
}

/// Parses `1mx16`, `1mx16@0.5`.
fn one_case(text: &str) -> Result<OneCase, String> {
    let (size, of) = text.split_once('@').map_or((text, None), |(size, of)| (size, Some(of)));
    let (casters, footprint_of) = size
        .split_once(['x', 'X'])
        .ok_or_else(|| format!("{text:?} is not a case such as 100kx16 or 1mx6@0.5"))?;
    Ok(OneCase {
        casters: count(casters)?,
        footprint: footprint(footprint_of)?,
        opacity: of.map_or(Ok(0.02), opacity)?,
    })
}

fn limit(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if (0.1..=100.0).contains(&value) => Ok(value),
        _ => Err(format!("{text:?} is not a number in 0.1..=100")),
    }
}

fn whole(text: &str, range: std::ops::RangeInclusive<u32>) -> Result<u32, String> {
    match text.trim().parse() {
        Ok(value) if range.contains(&value) => Ok(value),
        _ => Err(format!("{text:?} is not in {}..={}", range.start(), range.end())),
    }
}

fn nodes(text: &str) -> Result<u32, String> {
    match text.trim().parse() {
        Ok(value @ (4 | 8 | 16)) => Ok(value),
        _ => Err(format!("{text:?} is not 4, 8 or 16")),
    }
}

fn lights(text: &str) -> Result<u32, String> {
    whole(text, 1..=64)
}

fn size(text: &str) -> Result<u32, String> {
    whole(text, gobo::model::MIN_MAP_SIZE..=gobo::model::MAX_MAP_SIZE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_suffixes() {
        for (text, value) in [
            ("500", 500),
            ("10k", 10_000),
            ("1.5M", 1_500_000),
            ("16m", 16_000_000),
            ("1g", 1_000_000_000),
        ] {
            assert_eq!(count(text), Ok(value));
        }
        for bad in ["", "k", "0", "-1", "1.5", "5g", "1t", "nan", "infk"] {
            assert!(count(bad).is_err(), "{bad}");
        }
    }
    #[test]
    fn cases_have_an_opacity_or_the_usual_one() {
        let of = |casters, footprint, opacity| Ok(OneCase { casters, footprint, opacity });
        assert_eq!(one_case("10kx6"), of(10_000, 6.0, 0.02));
        assert_eq!(one_case("1mX0.5@1"), of(1_000_000, 0.5, 1.0));
        for bad in ["", "1m", "x", "1mx", "x16", "1mx16@", "1mx16@2", "1mx0", "1mx16@0.5@1"] {
            assert!(one_case(bad).is_err(), "{bad}");
        }
    }
}
