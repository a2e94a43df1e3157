//! Order of points by their place, so that invocations of a subgroup read the same texels, and their loops
//! end together.
use glam::Vec3;
use gobo::shadows::cull::order::morton_code;

/// Index of the last cell along the longest edge of the points' bounds: ten bits per axis of a key.
const LAST_CELL: f32 = 1023.0;

/// Indices of points along a Z-order curve (Morton 1966) through their bounds.
pub(super) fn place_order(points: impl Iterator<Item = Vec3> + Clone) -> Vec<u32> {
    let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) =
        points.clone().fold(none, |(low, high), point| (low.min(point), high.max(point)));
    let per_metre = LAST_CELL / (high - low).max_element().max(f32::MIN_POSITIVE);
    let key = |point: Vec3| {
        // A NaN becomes 0.
        morton_code(((point - low) * per_metre).as_uvec3())
    };
    let mut keys: Vec<_> = points.map(key).zip(0..).collect();
    keys.sort_unstable();
    keys.into_iter().map(|(_, index)| index).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_there_once_and_near_its_neighbours() {
        let point = |i: usize| Vec3::new((i * 37 % 64) as f32, 5.0, (i * 101 % 61) as f32) * 0.1;
        let points: Vec<_> = (0..64 * 61).map(point).collect();
        let order = place_order(points.iter().copied());
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().copied().eq(0..64 * 61));
        let length = |order: &mut dyn Iterator<Item = usize>| {
            let along: Vec<_> = order.map(|i| points[i]).collect();
            along.windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f32>()
        };
        let (before, after) =
            (length(&mut (0..points.len())), length(&mut order.iter().map(|&i| i as usize)));
        assert!(after < 0.1 * before, "{after} {before}");
    }

    #[test]
    fn points_without_extent_or_at_no_place_are_kept() {
        assert_eq!(place_order([Vec3::ONE; 3].into_iter()), [0, 1, 2]);
        assert_eq!(place_order([].into_iter()), [0_u32; 0]);
        let none = [Vec3::NAN, Vec3::ZERO, Vec3::INFINITY, Vec3::ONE];
        let mut order = place_order(none.into_iter());
        order.sort_unstable();
        assert_eq!(order, [0, 1, 2, 3]);
    }
}
