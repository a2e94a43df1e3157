//! CPU reference of `crates/gobo-picture/wgsl/hit/coplanar.wgsl`: coplanar faces, whose depths differ only by
//! rounding.

/// Largest relative difference of such depths.
pub const COPLANAR: f32 = 1.0 / 65536.0;

/// Whether a face is in front of another; the higher id wins among coplanar ones. Each face is a light depth
/// and the id of its object; `None` if it is no triangle.
pub fn is_in_front(
    (depth, object): (f32, Option<u32>),
    (other, behind): (f32, Option<u32>),
) -> bool {
    match (object, behind) {
        (Some(object), Some(behind))
            if object != behind && (depth - other).abs() <= COPLANAR * other =>
        {
            object > behind
        }
        _ => depth < other,
    }
}
