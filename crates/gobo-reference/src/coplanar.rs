//! CPU reference of `crates/gobo-picture/wgsl/hit/coplanar.wgsl`: faces in one plane, whose depths differ by
//! their rounding alone.

/// Largest difference of such depths, as a share of one.
pub const COPLANAR: f32 = 1.0 / 65536.0;

/// Whether a face is in front of another: of those in one plane, the one with the higher id. Each is a light
/// depth and the id of the object that it is of; `None` for what is no triangle.
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
