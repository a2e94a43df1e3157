// Outline of an area light seen from a receiver, in the plane of a map.

import package::records::area::{AREA_FLAT, AREA_SUN, GpuArea};
import package::records::view::GpuView;

// Sheared rectangle with the second moments of the light's outline.
struct Outline {
    half: vec2<f32>, // half-widths along its axes
    turned: bool,    // whether these are y and x, so that the second is the longer one
    shear: f32,      // along the first axis, per step along the second
}

// Half axes of the light seen from the point, along x and y of the view's map: in metres in a perspective
// view, as slopes in a parallel one.
fn half_axes(view: GpuView, area: GpuArea, p: vec3<f32>, distance: f32) -> mat2x2<f32> {
    let perspective = view.perspective > 0.0;
    let aside = select(vec2(0.0), p.xy / max(-p.z, 1e-6), perspective);
    let down = vec2(1.0, -1.0); // rows of the map go down
    let right = (view.view_from_world * vec4(area.right, 0.0)).xyz;
    let up = (view.view_from_world * vec4(area.up, 0.0)).xyz;
    // Projected along the ray to the point into the plane of the view.
    let flat_axes = mat2x2((right.xy + aside * right.z) * down, (up.xy + aside * up.z) * down);
    // Spheres face the point: they appear as ellipses, longer away from the axis.
    let off_axis = dot(aside, aside);
    let out = select(vec2(1.0, 0.0), aside * inverseSqrt(max(off_axis, 1e-30)), off_axis > 1e-30) * down;
    let facing = mat2x2(out * sqrt(1.0 + off_axis), vec2(-out.y, out.x)) * area.right.x;
    let is_flat = area.kind == AREA_FLAT;
    let axes = mat2x2(select(facing[0], flat_axes[0], is_flat), select(facing[1], flat_axes[1], is_flat));
    let as_slope = select(1.0 / max(distance, 1e-6), 1.0, perspective);
    let of_sun = select(1.0, -p.z, perspective);
    return axes * select(as_slope, of_sun, area.kind == AREA_SUN);
}

// The outline seen from a point, in `view` at `p`, at a distance from the light [m].
fn outline_of(view: GpuView, area: GpuArea, p: vec3<f32>, distance: f32) -> Outline {
    let axes = half_axes(view, area, p, distance);
    let along = axes[0] * axes[0] + axes[1] * axes[1];
    let both = axes[0].x * axes[0].y + axes[1].x * axes[1].y;
    let is_turned = along.x > along.y;
    let squares = select(along, along.yx, is_turned);
    let shear = both / max(squares.y, 1e-30);
    let half = sqrt(vec2(max(squares.x - shear * both, 0.0), squares.y));
    return Outline(half, is_turned, shear);
}
