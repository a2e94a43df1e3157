//! Comparison of two renderers' maps of a view.
use gobo::records::ViewMaps;

/// Expected maps of a texel.
#[derive(Clone, Debug)]
pub(crate) struct ExpectedTexel {
    pub(crate) filter: [f64; 3],
    /// Least and largest `D` that rounding allows.
    pub(crate) nearest: [f64; 2],
    pub(crate) opaque: f64,
    /// Whether rounding decides if the ray hits some caster at all.
    pub(crate) undecided: bool,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    pub(crate) filter: f64,
    pub(crate) depth: f64,
    /// Largest share of texels that may be undecided.
    pub(crate) undecided: f64,
}

/// Error of the first difference.
pub(crate) fn compare_maps(
    expected: &[ExpectedTexel],
    maps: &ViewMaps,
    tolerance: Tolerance,
) -> Result<(), String> {
    let lengths = [maps.filter.len(), maps.nearest.len(), maps.opaque.len()];
    if lengths != [expected.len(); 3] {
        return Err(format!("{lengths:?} texels instead of {}", expected.len()));
    }
    let undecided = expected.iter().filter(|texel| texel.undecided).count();
    if undecided as f64 > tolerance.undecided * expected.len() as f64 {
        return Err(format!("{undecided} of {} texels are undecided", expected.len()));
    }
    for (i, want) in expected.iter().enumerate().filter(|(_, texel)| !texel.undecided) {
        let (filter, nearest) = (maps.filter[i].map(f64::from), f64::from(maps.nearest[i]));
        let opaque = f64::from(maps.opaque[i]);
        let [low, high] = want.nearest;
        // Written so that a NaN is wrong.
        let light = (0..3).all(|c| (filter[c] - want.filter[c]).abs() <= tolerance.filter);
        let depth = nearest >= low - tolerance.depth && nearest <= high + tolerance.depth;
        let solid = (opaque - want.opaque).abs() <= tolerance.depth;
        if !(light && depth && solid) {
            let (x, y) = (i as u32 % maps.view.size.x, i as u32 / maps.view.size.x);
            let view = maps.view.name;
            return Err(format!(
                "view {view}, texel ({x}, {y}): F {filter:?}, D {nearest}, Z {opaque} instead of \
                 {want:?}"
            ));
        }
    }
    Ok(())
}

pub(crate) fn assert_maps_agree(expected: &[ExpectedTexel], maps: &ViewMaps, tolerance: Tolerance) {
    if let Err(wrong) = compare_maps(expected, maps, tolerance) {
        panic!("{wrong}");
    }
}
