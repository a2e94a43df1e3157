// Extent of a footprint in the map.

import package::features::{
    HAS_BRICKS, HAS_CAPSULES, HAS_GAUSSIANS, HAS_PUFFS, HAS_QUADS, HAS_TRIANGLES, only_capsules,
    only_gaussians,
};
import package::hit::capsule::{capsule_half, capsule_touches};
import package::hit::gaussian::gaussian_touches;
import package::records::capsule::is_capsule;
import package::records::footprint::Footprint;
import package::records::gaussian::{gaussian_setup, is_gaussian};
import package::records::tile_rect::SLACK;
import package::records::view::{GpuView, is_beside};

// Whether a footprint may touch texel centres in the box lo..hi.
fn touches_box(view: GpuView, footprint: Footprint, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    let center = footprint.bounds.xy;
    let radius = footprint.bounds.z;
    if is_beside(footprint.bounds) {
        return true;
    }
    let outside = center - clamp(center, lo, hi);
    if HAS_TRIANGLES && footprint.is_triangle {
        return max(abs(outside.x), abs(outside.y)) <= radius;
    }
    if HAS_CAPSULES && (only_capsules() || is_capsule(footprint)) {
        return capsule_touches(footprint.bounds, capsule_half(footprint.look), lo, hi);
    }
    if HAS_GAUSSIANS && (only_gaussians() || is_gaussian(footprint)) {
        return gaussian_touches(view, gaussian_setup(footprint), footprint.bounds, lo, hi);
    }
    var reach = radius * select(1.0, 1.41421356, HAS_QUADS);
    if view.perspective > 0.0 {
        if HAS_PUFFS || HAS_BRICKS {
            // A sphere's cone has its radius over distance as sine, not as tangent.
            reach = select(1e30, reach / sqrt(1.0 - reach * reach), reach < 1.0);
        }
        // tan(axis + cone) - tan(axis), outwards from the view's centre.
        let slope = length(center - view.size * 0.5) / view.scale;
        let rest = 1.0 - slope * reach;
        reach = select(1e30, view.scale * reach * (1.0 + slope * slope) / rest, rest > 0.0);
    }
    reach += SLACK;
    return dot(outside, outside) <= reach * reach;
}
