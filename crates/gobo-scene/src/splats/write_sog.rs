//! Writes SOG version 2.
use super::{
    cloud::HARMONIC,
    clusters::{Palette, book_of_numbers, nearest, palette_of},
    harmonics::{Harmonics, degree_of},
    sog::PALETTE_ROW,
};
use glam::Vec3;
use gobo::model::Gaussian;
use image::{ExtendedColorType, ImageEncoder as _, codecs::webp::WebPEncoder};
use serde_json::json;
use std::io::{self, Cursor, Write as _};
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

/// Alpha of a rotation whose largest part is w; x, y and z follow.
const FIRST_MODE: u8 = 252;

/// Most entries of the palette of higher harmonics, and splats per entry where there are fewer.
const MOST_ENTRIES: usize = 1 << 16;
const SPLATS_PER_ENTRY: usize = 16;

/// A texel of an image.
type Texel = [u8; 4];

/// The splats as a SOG, a zip of lossless images. `colors`: one per splat, of any magnitude. Numbers become 8
/// bits with a codebook, centres 16 bits of their extent. Takes seconds for a million splats with harmonics.
///
/// # Errors
/// If there is no splat, or a number is not finite.
pub fn to_sog(splats: &[Gaussian], colors: &[Vec3], harmonics: &Harmonics) -> io::Result<Vec<u8>> {
    let invalid = |message: &str| io::Error::new(io::ErrorKind::InvalidInput, message);
    let Some(degree) = degree_of(harmonics.count) else {
        return Err(invalid("the harmonics are of no degree"));
    };
    let coefficients: Vec<Vec3> = colors.iter().map(|c| (c - 0.5) / HARMONIC).collect();
    let higher = harmonics.coefficients.as_flattened();
    if splats.is_empty() {
        return Err(invalid("SOG holds at least one splat"));
    }
    if !coefficients.iter().all(|c| c.is_finite()) || !higher.iter().all(|c| c.is_finite()) {
        return Err(invalid("a colour is not finite"));
    }
    let mut file = ZipWriter::new(Cursor::new(Vec::new()));
    let mut put = |name: &str, width: usize, texels: &[Texel]| -> io::Result<()> {
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        file.start_file(name, options).map_err(io::Error::other)?;
        file.write_all(&lossless(width, texels)?)
    };
    let width = splats.len().isqrt().max(1).next_multiple_of(4);
    let (means, [low, high]) = means(splats);
    put("means_l.webp", width, &low)?;
    put("means_u.webp", width, &high)?;
    let scales: Vec<Vec3> = splats.iter().map(|splat| splat.sigma.map(f32::ln)).collect();
    let (scale_book, scales) = coded(&scales, |_| 255);
    put("scales.webp", width, &scales)?;
    let turns: Vec<Texel> = splats.iter().map(rotation).collect();
    put("quats.webp", width, &turns)?;
    let alpha = |i: usize| (splats[i].opacity * 255.0).round().clamp(0.0, 255.0) as u8;
    let (color_book, colors) = coded(&coefficients, alpha);
    put("sh0.webp", width, &colors)?;
    let mut meta = json!({
        "version": 2,
        "asset": { "generator": "gobo" },
        "count": splats.len(),
        "antialias": false,
        "means": means,
        "scales": { "codebook": scale_book.to_vec(), "files": ["scales.webp"] },
        "quats": { "files": ["quats.webp"] },
        "sh0": { "codebook": color_book.to_vec(), "files": ["sh0.webp"] },
    });
    if degree > 0 {
        let Palette { rows, labels } =
            palette_of(higher, 3 * harmonics.count, entries(splats.len()));
        let rows = rows.as_chunks::<3>().0;
        let triples: Vec<Vec3> = rows.iter().map(|&rgb| Vec3::from_array(rgb)).collect();
        let (book, texels) = coded(&triples, |_| 255);
        put("shN_centroids.webp", PALETTE_ROW * harmonics.count, &texels)?;
        let labels: Vec<Texel> =
            labels.iter().map(|label| label.to_le_bytes()).map(|[l, h]| [l, h, 0, 255]).collect();
        put("shN_labels.webp", width, &labels)?;
        meta["shN"] = json!({
            "count": rows.len() / harmonics.count,
            "bands": degree,
            "codebook": book.to_vec(),
            "files": ["shN_centroids.webp", "shN_labels.webp"],
        });
    }
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    file.start_file("meta.json", options).map_err(io::Error::other)?;
    file.write_all(meta.to_string().as_bytes())?;
    file.finish().map(Cursor::into_inner).map_err(io::Error::other)
}

/// Entries of the palette for a number of splats: a power of 4.
fn entries(splats: usize) -> usize {
    let wanted = (splats / SPLATS_PER_ENTRY).clamp(1, MOST_ENTRIES);
    4_usize.pow(wanted.ilog(4)).max(PALETTE_ROW)
}

/// Centres as sign(x) ln(1 + |x|), 16 bits of their extent: the extent, and images of the low and high bytes.
fn means(splats: &[Gaussian]) -> (serde_json::Value, [Vec<Texel>; 2]) {
    let packed = |splat: &Gaussian| splat.center.map(|x| x.abs().ln_1p().copysign(x));
    let all: Vec<Vec3> = splats.iter().map(packed).collect();
    let least = all.iter().fold(Vec3::INFINITY, |least, x| least.min(*x));
    let most = all.iter().fold(Vec3::NEG_INFINITY, |most, x| most.max(*x));
    let extent = (most - least).max(Vec3::splat(f32::MIN_POSITIVE));
    let steps = all.iter().map(|x| {
        let share =
            ((x - least) / extent * 65535.0).round().clamp(Vec3::ZERO, Vec3::splat(65535.0));
        share.to_array().map(|step| (step as u16).to_le_bytes())
    });
    let (low, high) =
        steps.map(|[x, y, z]| ([x[0], y[0], z[0], 255], [x[1], y[1], z[1], 255])).unzip();
    let files = ["means_l.webp", "means_u.webp"];
    (json!({ "mins": least.to_array(), "maxs": most.to_array(), "files": files }), [low, high])
}

/// A codebook of the numbers of vectors, and a texel for each vector.
fn coded(vectors: &[Vec3], alpha: impl Fn(usize) -> u8) -> ([f32; 256], Vec<Texel>) {
    let numbers: Vec<f32> = vectors.iter().flat_map(Vec3::to_array).collect();
    let book = book_of_numbers(&numbers);
    let texel = |(i, v): (usize, &Vec3)| {
        let [r, g, b] = v.to_array().map(|number| nearest(&book, number));
        [r, g, b, alpha(i)]
    };
    (book, vectors.iter().enumerate().map(texel).collect())
}

/// Three parts of a rotation beside its largest, which is made positive, in the order w x y z; alpha names
/// the largest.
fn rotation(splat: &Gaussian) -> Texel {
    let [x, y, z, w] = splat.rotation.to_array();
    let parts = [w, x, y, z];
    let larger = |a: usize, b: usize| if parts[b].abs() > parts[a].abs() { b } else { a };
    let largest = (1..4).fold(0, larger);
    let byte = |part: f32| {
        let share = part * parts[largest].signum() / std::f32::consts::SQRT_2 + 0.5;
        (share * 255.0).round().clamp(0.0, 255.0) as u8
    };
    let mut rest = (0..4).filter(|&i| i != largest).map(|i| byte(parts[i]));
    let mut next = || rest.next().unwrap_or_default();
    [next(), next(), next(), FIRST_MODE + largest as u8]
}

/// A lossless WebP of a width \[texels\]; texels that are missing in its last row are 0.
fn lossless(width: usize, texels: &[Texel]) -> io::Result<Vec<u8>> {
    let height = texels.len().div_ceil(width);
    let mut bytes = texels.as_flattened().to_vec();
    bytes.resize(4 * width * height, 0);
    let mut image = Vec::new();
    WebPEncoder::new_lossless(&mut image)
        .write_image(&bytes, width as u32, height as u32, ExtendedColorType::Rgba8)
        .map_err(io::Error::other)?;
    Ok(image)
}
