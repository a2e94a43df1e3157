//! SOG version 2 (`PlayCanvas`): a zip of lossless images with a texel per splat, and `meta.json`. x is right, y
//! up, z back.
use super::{
    cloud::{Cloud, Fault, HARMONIC},
    packed::smallest_three,
};
use crate::model::Gaussian;
use crate::scene::{error::quoted, images, limits};
use glam::Vec3;
use image::RgbaImage;
use serde::Deserialize;
use std::io::{Cursor, Read as _};
use zip::ZipArchive;

const DAMAGED: &str = "the file is damaged: write it again";

/// Longest side of an image [texels].
const MAX_SIDE: u32 = 8192;

/// Longest `meta.json` [bytes].
const MAX_META: u64 = 1 << 20;

/// Longest compressed image: more than the texels of the most splats need [bytes].
const MAX_IMAGE: u64 = 1 << 28;

/// Alpha of a rotation whose largest part is w; x, y and z follow.
const FIRST_MODE: u8 = 252;

#[derive(Deserialize)]
struct Meta {
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
    #[serde(deserialize_with = "crate::scene::numbers::array")]
    files: [String; N],
}

#[derive(Deserialize)]
struct Higher {
    bands: usize,
}

type Archive<'a> = ZipArchive<Cursor<&'a [u8]>>;

pub(super) fn read(bytes: &[u8]) -> Result<Cloud, Fault> {
    let mut archive = ZipArchive::new(Cursor::new(bytes))
        .map_err(|error| (format!("not a valid zip file: {error}"), DAMAGED))?;
    let meta = member(&mut archive, "meta.json", MAX_META)?;
    let version: serde_json::Value = serde_json::from_slice(&meta)
        .map_err(|error| (format!("meta.json: not valid JSON: {error}"), DAMAGED))?;
    if version.get("version").and_then(serde_json::Value::as_u64) != Some(2) {
        let help = "write version 2, for example by splat-transform";
        return Err(("meta.json: not version 2 of SOG".to_owned(), help));
    }
    let meta: Meta =
        serde_json::from_slice(&meta).map_err(|error| (format!("meta.json: {error}"), DAMAGED))?;
    let mut cloud = Cloud::with_room(meta.count)?;
    let mut texels = 0;
    let mut image = |name: &str| image(&mut archive, name, meta.count, &mut texels);
    let [low, high] = [&meta.means.files[0], &meta.means.files[1]];
    let (low, high) = (image(low)?, image(high)?);
    let (scales, turns) = (image(&meta.scales.files[0])?, image(&meta.quats.files[0])?);
    let colors = image(&meta.sh0.files[0])?;
    let (least, most) = (Vec3::from(meta.means.mins), Vec3::from(meta.means.maxs));
    let coded = |coded: &Coded, name: &str| {
        <[f32; 256]>::try_from(&coded.codebook[..]).map_err(|_| {
            let message = format!("meta.json: the codebook of {name} has not 256 numbers");
            (message, DAMAGED)
        })
    };
    let (scale_of, color_of) = (coded(&meta.scales, "scales")?, coded(&meta.sh0, "sh0")?);
    let looked_up = |book: &[f32; 256], [r, g, b, _]: [u8; 4]| {
        Vec3::new(book[usize::from(r)], book[usize::from(g)], book[usize::from(b)])
    };
    for i in 0..meta.count as usize {
        let (low, high) = (texel(&low, i), texel(&high, i));
        let share =
            Vec3::from_array([0, 1, 2].map(|k| f32::from(u16::from_le_bytes([low[k], high[k]]))));
        let [r, g, b, mode] = texel(&turns, i);
        let parts =
            [r, g, b].map(|byte| (f32::from(byte) / 255.0 - 0.5) * std::f32::consts::SQRT_2);
        let Some(largest) = mode.checked_sub(FIRST_MODE) else {
            let message = format!("splat {}: the rotation has mode {mode}, not 252 to 255", i + 1);
            return Err((message, "write quats as a lossless image with alpha"));
        };
        let color = texel(&colors, i);
        cloud.push(Gaussian {
            center: expanded(least + (most - least) * share / 65535.0),
            rotation: smallest_three(parts, largest.into()),
            sigma: looked_up(&scale_of, texel(&scales, i)).exp(),
            opacity: f32::from(color[3]) / 255.0,
            color: Vec3::splat(0.5) + HARMONIC * looked_up(&color_of, color),
            ..Gaussian::default()
        });
    }
    let bands = meta.higher.map_or(0, |higher| higher.bands.min(4));
    cloud.leave_out_harmonics((bands + 1).pow(2) - 1);
    Ok(cloud.finish())
}

/// Positions are stored as sign(x) ln(|x| + 1).
fn expanded(stored: Vec3) -> Vec3 {
    stored.map(|x| x.abs().exp_m1().copysign(x))
}

fn texel(image: &RgbaImage, i: usize) -> [u8; 4] {
    image.as_raw().as_chunks().0[i]
}

fn member(archive: &mut Archive<'_>, name: &str, most: u64) -> Result<Vec<u8>, Fault> {
    let named = quoted(name);
    let mut file = archive.by_name(name).map_err(|error| {
        let help = "a .sog is a zip with meta.json and the images that it names at its root";
        (format!("{named} in the zip: {error}"), help)
    })?;
    let long = || (format!("{named} in the zip has more than {most} bytes"), DAMAGED);
    if file.size() > most {
        return Err(long());
    }
    let mut bytes = Vec::new();
    let read = file.by_ref().take(most + 1).read_to_end(&mut bytes);
    read.map_err(|error| (format!("{named} in the zip: {error}"), DAMAGED))?;
    if bytes.len() as u64 > most { Err(long()) } else { Ok(bytes) }
}

/// Decodes an image of at least `count` texels.
fn image(
    archive: &mut Archive<'_>,
    name: &str,
    count: u64,
    texels: &mut u64,
) -> Result<RgbaImage, Fault> {
    let bytes = member(archive, name, MAX_IMAGE)?;
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
