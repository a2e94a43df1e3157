//! Levels of bloom.
use glam::UVec2;

/// Most levels.
const MAX_LEVELS: usize = 8;
/// Least length of the coarsest level's shorter side \[texels\].
const COARSEST: u32 = 4;

/// Number of levels of the light behind glass, the picture's own size first.
pub fn refraction_levels(picture: UVec2) -> u32 {
    (picture.min_element() / COARSEST).max(1).ilog2().min(MAX_LEVELS as u32) + 1
}

/// Sizes of the levels of a picture's bloom, each half of the one before, rounded up; the first is half the
/// picture.
pub fn bloom_sizes(picture: UVec2) -> Vec<UVec2> {
    let halved = |size: &UVec2| Some((*size + 1) / 2);
    let sizes = std::iter::successors(halved(&picture), halved);
    let coarse = |size: &UVec2| size.min_element() >= COARSEST;
    let first = (picture + 1) / 2;
    let mut levels: Vec<UVec2> = sizes.take(MAX_LEVELS).take_while(coarse).collect();
    if levels.is_empty() {
        levels.push(first);
    }
    levels
}
