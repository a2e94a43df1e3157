// Hit of a ray with a puff. CPU reference: crates/gobo-reference/src/puff.rs.

import package::bind::uniform::materials;
import package::hit::hit::{Hit, MISS, absorption, transmittance};
import package::records::view::{GpuView, is_beside};
import package::sums::sums::{tau_absorbed, whole_tau};

// A puff absorbs along the ray's chord through the sphere in front of the opaque surface: its transfer along
// a diameter, to the power of the chord's share of the diameter.
fn puff_hit(
    view: GpuView,
    bounds: vec4<f32>,
    color: vec3<f32>,
    thin: f32,
    alpha: f32,
    texel: vec2<f32>,
    opaque_depth: f32,
    material_id: u32,
) -> Hit {
    let range = view.far - view.near;
    let center = view.near + bounds.w * range; // along the axis [m]
    let w = vec3((texel - view.size * 0.5) / view.scale, 1.0);
    let middle = (bounds.xy - view.size * 0.5) / view.scale;
    // Squared distance of the ray from the centre [radii²], and metres along the axis per radius.
    var miss2: f32;
    var radius_axis: f32;
    var closest: f32;
    if is_beside(bounds) {
        let apart = cross(bounds.xyw, w);
        miss2 = dot(apart, apart) / dot(w, w) / (bounds.z * bounds.z);
        radius_axis = -bounds.z / length(w);
        closest = dot(bounds.xyw, w) / dot(w, w);
    } else if view.perspective > 0.0 {
        let c = vec3(middle, 1.0);
        let distance = center * length(c);
        let radius = bounds.z * distance;
        let apart = cross(c, w - c);
        miss2 = dot(apart, apart) / dot(w, w) * (center * center) / (radius * radius);
        radius_axis = radius / length(w);
        closest = center * dot(c, w) / dot(w, w);
    } else {
        let delta = (texel - bounds.xy) / bounds.z;
        miss2 = dot(delta, delta);
        radius_axis = bounds.z / view.scale;
        closest = center;
    }
    if miss2 >= 1.0 {
        return MISS;
    }
    let half_chord = sqrt(1.0 - miss2); // [radii]
    let first = max(closest - half_chord * radius_axis, view.near);
    let last = min(closest + half_chord * radius_axis, view.near + opaque_depth * range);
    let share = clamp((last - first) / (2.0 * radius_axis), 0.0, 1.0);
    let per_diameter = max(transmittance(materials[material_id].transfer, thin, alpha, color), vec3(1e-9));
    let opacity = 1.0 - pow(max(1.0 - alpha, 1e-9), share);
    let entered = (first - view.near) / range;
    let left = (last - view.near) / range;
    let light = pow(per_diameter, vec3(share));
    let absorbed = tau_absorbed(
        whole_tau(absorption(materials[material_id].transfer, thin, alpha, color)) * share
    );
    let depth = select(-1.0, entered, share > 0.0);
    return Hit(light, color, opacity, depth, depth, left, material_id, absorbed);
}
