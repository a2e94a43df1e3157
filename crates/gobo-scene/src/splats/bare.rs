//! `.splat`: records of 32 bytes without a header (antimatter15/splat): three floats each of centre and
//! deviations, four bytes rgba, four bytes of the rotation w x y z around 128.
use super::cloud::{SplatCloud, word};
use crate::error::Fault;
use glam::{Quat, Vec3};
use gobo::model::Gaussian;

/// Size of a record \[bytes\].
const RECORD: usize = 32;

/// Records that are checked before a file without a header is taken for splats.
const PROBED: usize = 64;

/// Whether bytes look like such records: whether the first ones have plausible numbers.
pub(super) fn is_bare(bytes: &[u8]) -> bool {
    let is_sensible = |record: &[u8]| {
        let Gaussian { center, sigma, rotation, .. } = splat(record);
        center.is_finite()
            && center.abs().max_element() < 1e7
            && sigma.cmpge(Vec3::ZERO).all()
            && sigma.max_element() > 0.0
            && sigma.max_element() < 1e7
            && (0.9..1.1).contains(&rotation.length())
    };
    let probed = bytes.as_chunks::<RECORD>().0.iter().take(PROBED);
    !bytes.is_empty()
        && probed.clone().filter(|record| is_sensible(&record[..])).count() * 2 > probed.len()
}

/// Whether a file of this length has whole records.
pub(super) fn is_whole(length: u64) -> bool {
    length.is_multiple_of(RECORD as u64)
}

/// Number of splats in a file of this length.
pub(super) fn count(length: u64) -> u64 {
    length / RECORD as u64
}

pub(super) fn read(bytes: &[u8]) -> Result<SplatCloud, Fault> {
    let (records, rest) = bytes.as_chunks::<RECORD>();
    if !rest.is_empty() {
        let message = format!("the file ends in splat {}: it has 32 bytes each", records.len() + 1);
        return Err((message, "the file is cut off: write it again"));
    }
    let mut cloud = SplatCloud::with_room(records.len() as u64)?;
    for record in records {
        cloud.push(splat(record));
    }
    Ok(cloud.finish())
}

fn splat(record: &[u8]) -> Gaussian {
    let vector = |first: usize| {
        Vec3::from_array(std::array::from_fn(|i| f32::from_le_bytes(word(record, first + i))))
    };
    let [r, g, b, a] = word(record, 6).map(|byte| f32::from(byte) / 255.0);
    let [w, x, y, z] = word(record, 7).map(|byte| (f32::from(byte) - 128.0) / 128.0);
    Gaussian {
        center: vector(0),
        rotation: Quat::from_xyzw(x, y, z, w),
        sigma: vector(3),
        opacity: a,
        color: Vec3::new(r, g, b),
        ..Gaussian::default()
    }
}
