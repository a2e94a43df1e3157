//! Twin of `wgsl/shade/outline.wgsl`: an area light as a receiver sees it, in the plane of a map.
use crate::records::{AREA_FLAT, AREA_SUN, GpuArea, GpuLight, GpuView};
use glam::{Vec2, Vec2Swizzles as _, Vec3};

/// A light's outline as a sheared rectangle, of equal moments.
pub(super) struct Outline {
    /// Whether the rectangle's axes are y and x, so that the second is the longer one.
    pub(super) turned: bool,
    /// Half-widths along its axes.
    pub(super) half: Vec2,
    /// How far it is sheared along its first axis, per step along its second.
    pub(super) shear: f32,
}

impl Outline {
    /// The outline seen from `point`, in `view` at `p`.
    pub(super) fn new(
        view: &GpuView,
        light: &GpuLight,
        area: &GpuArea,
        p: Vec3,
        point: Vec3,
    ) -> Self {
        let [right, up] = half_axes(view, light, area, p, point);
        // Twice the moments along x and y, and their product.
        let squares = right * right + up * up;
        let both = right.x * right.y + up.x * up.y;
        let turned = squares.x > squares.y;
        let squares = if turned { squares.yx() } else { squares };
        let shear = both / squares.y.max(1e-30);
        let first = (squares.x - shear * both).max(0.0);
        Self { turned, half: Vec2::new(first, squares.y).map(f32::sqrt), shear }
    }
}

/// Half axes of the light seen from the point, along x and y of a view's map: in metres in a perspective
/// view, as slopes in a parallel one.
fn half_axes(view: &GpuView, light: &GpuLight, area: &GpuArea, p: Vec3, point: Vec3) -> [Vec2; 2] {
    let perspective = view.perspective > 0.0;
    let aside = if perspective { Vec2::new(p.x, p.y) / (-p.z).max(1e-6) } else { Vec2::ZERO };
    // Rows of the map go down.
    let down = Vec2::new(1.0, -1.0);
    let axes = if area.kind == AREA_FLAT {
        [area.right, area.up].map(|axis| {
            let axis = view.view_from_world.transform_vector3(axis);
            // Projected along the ray to the point into the plane of the view.
            (Vec2::new(axis.x, axis.y) + aside * axis.z) * down
        })
    } else {
        // Spheres face the point: an ellipse, longer away from the axis.
        let out = aside.normalize_or(Vec2::X) * down;
        [out * (1.0 + aside.length_squared()).sqrt(), out.perp()].map(|axis| axis * area.right.x)
    };
    let scale = match (area.kind == AREA_SUN, perspective) {
        (true, true) => -p.z,
        (false, false) => 1.0 / (point - light.position).length().max(1e-6),
        _ => 1.0,
    };
    axes.map(|axis| axis * scale)
}
