//! Compressed PLY of `PlayCanvas`: chunks of 256 splats with the bounds of their numbers, four words a splat.
use super::{
    cloud::SplatCloud,
    harmonics::Harmonics,
    ply::{rest, table},
};
use crate::{error::Fault, ply_body::PlyBody, ply_header};
use glam::{Quat, Vec3};
use gobo::model::Gaussian;

/// Range of a coefficient of higher harmonics, -4 to 4.
const SH_RANGE: f32 = 8.0;

/// Splats per chunk.
const CHUNK: usize = 256;

/// Columns of a chunk's bounds: of centres, logarithms of deviations, colours.
const BOUNDS: [[&str; 6]; 3] = [
    ["min_x", "min_y", "min_z", "max_x", "max_y", "max_z"],
    ["min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z"],
    ["min_r", "min_g", "min_b", "max_r", "max_g", "max_b"],
];

const WORDS: [&str; 4] = ["packed_position", "packed_rotation", "packed_scale", "packed_color"];

/// Bounds of a chunk: minima and maxima of centres, logarithms of deviations, and colours.
type Chunk = [[Vec3; 2]; 3];

pub(super) fn read(bytes: &[u8]) -> Result<SplatCloud, Fault> {
    let header = ply_header::parse(bytes)?;
    let mut body = PlyBody::new(&header, bytes);
    let mut chunks: Vec<Chunk> = Vec::new();
    let mut cloud = None;
    let mut harmonics = 0;
    let mut notes = Vec::new();
    for element in &header.elements {
        body.check_count(element)?;
        match element.name.as_str() {
            "chunk" => {
                let bounds = BOUNDS.as_flattened();
                let plain = table(element, &bounds[..12])?;
                let colors = table(element, bounds).ok();
                let help = "use a smaller file, or a machine with more memory";
                let memory = || (format!("no memory for {} chunks", element.count), help);
                chunks.try_reserve_exact(element.count).map_err(|_| memory())?;
                let read = |_: usize, row: &[f64]| {
                    let vector =
                        |i: usize| Vec3::new(row[i] as f32, row[i + 1] as f32, row[i + 2] as f32);
                    let color = if row.len() > 12 {
                        [vector(12), vector(15)]
                    } else {
                        [Vec3::ZERO, Vec3::ONE]
                    };
                    [[vector(0), vector(3)], [vector(6), vector(9)], color]
                };
                body.rows(element, colors.as_ref().unwrap_or(&plain), read, |chunk| {
                    chunks.push(chunk);
                    Ok(())
                })?;
            }
            "vertex" => {
                let words = table(element, &WORDS)?;
                let mut splats = SplatCloud::with_room(element.count as u64)?;
                let read = |index: usize, row: &[f64]| {
                    let chunk = chunks.get(index / CHUNK).ok_or_else(|| {
                        let message = format!(
                            "splat {} has no chunk: there are {} chunks of {CHUNK} before it",
                            index + 1,
                            chunks.len()
                        );
                        (message, "write the element `chunk` before `vertex`, whole")
                    })?;
                    let words = [row[0], row[1], row[2], row[3]].map(|word| word as u32);
                    Ok::<_, Fault>(splat(chunk, words))
                };
                body.rows(element, &words, read, |splat| {
                    splats.push(splat?);
                    Ok(())
                })?;
                cloud = Some(splats);
            }
            "sh" => {
                harmonics = element.properties.len() / 3;
                body.skip(element)?;
            }
            other => {
                body.skip(element)?;
                notes.push(format!("{} rows of `{other}` are not read", element.count));
            }
        }
    }
    let none = || ("there is no element `vertex` in the PLY header".to_owned(), "write the splats");
    let mut cloud = cloud.ok_or_else(none)?;
    cloud.notes = notes;
    cloud.leave_out_harmonics(harmonics);
    Ok(cloud.finish())
}

/// Coefficients of higher harmonics, the element `sh`: bytes of -4 to 4.
pub(super) fn harmonics(bytes: &[u8]) -> Result<Harmonics, Fault> {
    let header = ply_header::parse(bytes)?;
    let mut body = PlyBody::new(&header, bytes);
    for element in &header.elements {
        body.check_count(element)?;
        if element.name == "sh" {
            return rest(&mut body, element, |byte| {
                let share = if byte <= 0.0 { 0.0 } else { ((byte as f32 + 0.5) / 256.0).min(1.0) };
                (if byte >= 255.0 { 1.0 } else { share } - 0.5) * SH_RANGE
            });
        }
        body.skip(element)?;
    }
    Ok(Harmonics::default())
}

/// The `bits` of `word` from `shift` on as a share of their largest.
fn share(word: u32, shift: u32, bits: u32) -> f32 {
    let most = (1 << bits) - 1;
    (word >> shift & most) as f32 / most as f32
}

/// Decodes the words of the centre (11, 10, 11 bits from the top), rotation (index of the largest part of w x
/// y z, and the others), deviations (as the centre), colour and opacity (8 bits each from the top).
fn splat(chunk: &Chunk, [position, rotation, scale, color]: [u32; 4]) -> Gaussian {
    let vector = |word| Vec3::new(share(word, 21, 11), share(word, 11, 10), share(word, 0, 11));
    let within = |[least, most]: [Vec3; 2], share: Vec3| least + (most - least) * share;
    let [centers, scales, colors] = *chunk;
    let parts =
        [20, 10, 0].map(|shift| (share(rotation, shift, 10) - 0.5) * std::f32::consts::SQRT_2);
    let rgb = Vec3::new(share(color, 24, 8), share(color, 16, 8), share(color, 8, 8));
    Gaussian {
        center: within(centers, vector(position)),
        rotation: smallest_three(parts, (rotation >> 30) as usize),
        sigma: within(scales, vector(scale)).exp(),
        opacity: share(color, 0, 8),
        color: within(colors, rgb),
        ..Gaussian::default()
    }
}

/// A unit quaternion from the parts without its largest, number `largest` of w x y z.
pub(super) fn smallest_three(parts: [f32; 3], largest: usize) -> Quat {
    let sum: f32 = parts.iter().map(|part| part * part).sum();
    let mut rest = parts.into_iter();
    let missing = (1.0 - sum).max(0.0).sqrt();
    let [w, x, y, z] =
        std::array::from_fn(
            |i| {
                if i == largest { missing } else { rest.next().unwrap_or_default() }
            },
        );
    Quat::from_xyzw(x, y, z, w)
}
