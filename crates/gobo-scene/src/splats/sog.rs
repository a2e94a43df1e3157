//! SOG version 2 (`PlayCanvas`): lossless images with a texel per splat, and `meta.json`, in a zip or in a
//! folder.
use super::{
    cloud::{HARMONIC, SplatCloud},
    harmonics::Harmonics,
    packed::smallest_three,
    sog_store::Store,
};
use crate::{
    error::{Fault, quoted},
    images, limits,
    limits::Limit,
};
use glam::Vec3;
use gobo::model::Gaussian;
use image::RgbaImage;
use serde::Deserialize;
use std::path::Path;

pub(super) const DAMAGED: &str = "the file is damaged: write it again";

/// Name of the file that describes the images.
pub(super) const META: &str = "meta.json";

/// Longest side of an image \[texels\].
const MAX_SIDE: u32 = 8192;

/// Longest `meta.json` \[bytes\].
const MAX_META: u64 = 1 << 20;

/// Longest compressed image \[bytes\]: more than the largest number of splats needs.
const MAX_IMAGE: u64 = 1 << 28;

/// Alpha of a rotation whose largest part is w; x, y and z follow.
const FIRST_MODE: u8 = 252;

#[derive(Deserialize)]
struct SogMeta {
    count: u64,
    means: Means,
    scales: Coded,
    quats: Files<1>,
    sh0: Coded,
    #[serde(rename = "shN")]
    higher: Option<Higher>,
}

#[derive(Deserialize)]
struct Means {
    mins: [f32; 3],
    maxs: [f32; 3],
    files: [String; 2],
}

#[derive(Deserialize)]
struct Coded {
    codebook: Vec<f32>,
    files: [String; 1],
}

#[derive(Deserialize)]
struct Files<const N: usize> {
    #[serde(deserialize_with = "crate::numbers::array")]
    files: [String; N],
}

#[derive(Deserialize)]
struct Higher {
    bands: usize,
    #[serde(default)]
    count: u64,
    #[serde(default)]
    codebook: Vec<f32>,
    #[serde(default)]
    files: Vec<String>,
}

/// Entries of the palette of higher harmonics side by side in its image.
pub(super) const PALETTE_ROW: usize = 64;

/// The splats of a SOG, decoded on demand.
pub(super) struct Sog {
    pub(super) count: u64,
    least: Vec3,
    most: Vec3,
    scale_of: [f32; 256],
    color_of: [f32; 256],
    /// Images of positions' low and high bytes, scales, rotations and colours.
    images: [RgbaImage; 5],
    /// Coefficients of higher harmonics per channel.
    pub(super) harmonics: usize,
}

impl Sog {
    /// Reads the images that the `meta.json` called `name` in the store lists.
    pub(super) fn open(store: &mut Store<'_>, name: &str) -> Result<Self, Fault> {
        let meta = meta(store, name)?;
        Limit::Splats.grown(0, meta.count)?;
        let mut texels = 0;
        let mut image = |name: &str| image(store, name, meta.count, &mut texels);
        let [low, high] = [&meta.means.files[0], &meta.means.files[1]];
        let images = [
            image(low)?,
            image(high)?,
            image(&meta.scales.files[0])?,
            image(&meta.quats.files[0])?,
            image(&meta.sh0.files[0])?,
        ];
        let coded = |coded: &Coded, name: &str| {
            <[f32; 256]>::try_from(&coded.codebook[..]).map_err(|_| {
                let message = format!("meta.json: the codebook of {name} has not 256 numbers");
                (message, DAMAGED)
            })
        };
        let bands = meta.higher.map_or(0, |higher| higher.bands.min(4));
        Ok(Self {
            count: meta.count,
            least: Vec3::from(meta.means.mins),
            most: Vec3::from(meta.means.maxs),
            scale_of: coded(&meta.scales, "scales")?,
            color_of: coded(&meta.sh0, "sh0")?,
            images,
            harmonics: (bands + 1).pow(2) - 1,
        })
    }

    /// Splat `i` of the file.
    pub(super) fn splat(&self, i: usize) -> Result<Gaussian, Fault> {
        let [low, high, scales, turns, colors] =
            self.images.each_ref().map(|image| texel(image, i));
        let share =
            Vec3::from_array([0, 1, 2].map(|k| f32::from(u16::from_le_bytes([low[k], high[k]]))));
        let [r, g, b, mode] = turns;
        let parts =
            [r, g, b].map(|byte| (f32::from(byte) / 255.0 - 0.5) * std::f32::consts::SQRT_2);
        let Some(largest) = mode.checked_sub(FIRST_MODE) else {
            let message = format!("splat {}: the rotation has mode {mode}, not 252 to 255", i + 1);
            return Err((message, "write quats as a lossless image with alpha"));
        };
        Ok(Gaussian {
            center: expanded(self.least + (self.most - self.least) * share / 65535.0),
            rotation: smallest_three(parts, largest.into()),
            sigma: looked_up(&self.scale_of, scales).exp(),
            opacity: f32::from(colors[3]) / 255.0,
            color: Vec3::splat(0.5) + HARMONIC * looked_up(&self.color_of, colors),
            ..Gaussian::default()
        })
    }
}

/// Reads a store: a zip, or the folder of a `meta.json` called `name`.
pub(super) fn read(store: &mut Store<'_>, name: &str) -> Result<SplatCloud, Fault> {
    let sog = Sog::open(store, name)?;
    let mut cloud = SplatCloud::with_room(sog.count)?;
    for i in 0..sog.count as usize {
        cloud.push(sog.splat(i)?);
    }
    cloud.leave_out_harmonics(sog.harmonics);
    Ok(cloud.finish())
}

/// Coefficients of higher harmonics: a label per splat, and a palette whose bytes look a codebook up.
/// Also gives the number of splats.
pub(super) fn harmonics(store: &mut Store<'_>, name: &str) -> Result<(Harmonics, u64), Fault> {
    let SogMeta { count, higher, .. } = meta(store, name)?;
    let Some(Higher { bands, count: entries, codebook, files }) = higher else {
        return Ok((Harmonics::default(), count));
    };
    let [palette, labels] = &files[..] else {
        return Err((format!("meta.json: shN names {} images, not 2", files.len()), DAMAGED));
    };
    let book = <[f32; 256]>::try_from(codebook)
        .map_err(|_| ("meta.json: the codebook of shN has not 256 numbers".to_owned(), DAMAGED))?;
    if !(1..=4).contains(&bands) || entries > 1 << 16 {
        let message = format!("meta.json: shN has {bands} bands and {entries} entries");
        return Err((message, DAMAGED));
    }
    let mut all = Harmonics::with_room((bands + 1).pow(2) - 1, count)?;
    let (per_splat, mut texels) = (all.count, 0);
    let palette = image(store, palette, entries * per_splat as u64, &mut texels)?;
    let (width, rows) = (palette.width() as usize, (entries as usize).div_ceil(PALETTE_ROW));
    if width < PALETTE_ROW * per_splat || (palette.height() as usize) < rows {
        let message = format!("the palette of shN has {width} x {} texels", palette.height());
        return Err((message, DAMAGED));
    }
    let labels = image(store, labels, count, &mut texels)?;
    for i in 0..count as usize {
        let [low, high, ..] = texel(&labels, i);
        let label = usize::from(u16::from_le_bytes([low, high]));
        if label as u64 >= entries {
            let message = format!("splat {}: entry {label} of {entries} of shN", i + 1);
            return Err((message, DAMAGED));
        }
        let first = label / PALETTE_ROW * width + label % PALETTE_ROW * per_splat;
        let of = |k: usize| looked_up(&book, texel(&palette, first + k)).to_array();
        all.coefficients.extend((0..per_splat).map(of));
    }
    Ok((all, count))
}

/// Names of the images beside a `meta.json`.
pub(super) fn images(folder: &Path, name: &str) -> Result<Vec<String>, Fault> {
    let SogMeta { means, scales, quats, sh0, higher, .. } = meta(&mut Store::folder(folder), name)?;
    let higher = higher.map(|higher| higher.files).unwrap_or_default();
    let plain = [scales.files, quats.files, sh0.files].concat();
    Ok(means.files.into_iter().chain(plain).chain(higher).collect())
}

fn meta(store: &mut Store<'_>, name: &str) -> Result<SogMeta, Fault> {
    let meta = store.member(name, MAX_META)?;
    let version: serde_json::Value = serde_json::from_slice(&meta)
        .map_err(|error| (format!("meta.json: not valid JSON: {error}"), DAMAGED))?;
    if version.get("version").and_then(serde_json::Value::as_u64) != Some(2) {
        let help = "write version 2, for example by splat-transform";
        return Err(("meta.json: not version 2 of SOG".to_owned(), help));
    }
    serde_json::from_slice(&meta).map_err(|error| (format!("meta.json: {error}"), DAMAGED))
}

fn looked_up(book: &[f32; 256], [r, g, b, _]: [u8; 4]) -> Vec3 {
    Vec3::new(book[usize::from(r)], book[usize::from(g)], book[usize::from(b)])
}

/// Positions are stored as sign(x) ln(|x| + 1).
fn expanded(stored: Vec3) -> Vec3 {
    stored.map(|x| x.abs().exp_m1().copysign(x))
}

fn texel(image: &RgbaImage, i: usize) -> [u8; 4] {
    image.as_raw().as_chunks().0[i]
}

/// Decodes an image of at least `count` texels.
fn image(
    store: &mut Store<'_>,
    name: &str,
    count: u64,
    texels: &mut u64,
) -> Result<RgbaImage, Fault> {
    let bytes = store.member(name, MAX_IMAGE)?;
    if !limits::has_memory(bytes.len() as u64) {
        return Err((format!("no memory for {}", quoted(name)), "use a smaller file"));
    }
    if bytes.get(12..16) == Some(b"VP8 ") {
        let message =
            format!("{} is a lossy image: its numbers are not what was stored", quoted(name));
        return Err((message, "write lossless WebP"));
    }
    let image = images::decode(&bytes, MAX_SIDE, texels)
        .map_err(|(message, _)| (format!("{}: {message}", quoted(name)), DAMAGED))?;
    let have = u64::from(image.width()) * u64::from(image.height());
    if have < count {
        let message = format!("{} has {have} texels for {count} splats", quoted(name));
        return Err((message, DAMAGED));
    }
    Ok(image)
}
