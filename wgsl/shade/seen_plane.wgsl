// Plane of the surface under a point without a normal, from the surfaces that the map sees around it.
// Otherwise a floor that rises towards the light would occlude itself.

import package::curve::node::DEPTHS;
import package::records::view::GpuView;
import package::shade::receiver::solid_depths;

// Distance from the point to the first texels read [texels]; where they see something in front of the
// surface, farther texels are read.
const FIRST_RING: f32 = 2.0;
const LAST_RING: f32 = 54.0;
const NEXT_RING: f32 = 3.0; // factor from one ring to the next
const AROUND_COUNT: u32 = 8u;
// Texels of a ring that must lie on the plane: half of them, as at the edge of a shadow.
const LEAST_ON_PLANE: u32 = 4u;
// Slack of a surface on the plane, as a distance over which the plane may change by as much [texels].
const ROUGH: f32 = 0.0625;
const NO_SURFACE: f32 = 1e30;

// Texels around a point: four along the axes, then four diagonal ones.
fn around_offset(i: u32) -> vec2<f32> {
    let low = select(1.0, -1.0, (i & 1u) != 0u);
    let high = select(1.0, -1.0, (i & 2u) != 0u);
    let along = select(vec2(low, 0.0), vec2(0.0, low), (i & 2u) != 0u);
    return select(along, vec2(low, high), i >= 4u);
}

// Offset of a texel from the point [texels]; and the distance of its surface, in a perspective view its
// inverse, less the point's.
fn surface_around(view: GpuView, near: f32, center: vec2<f32>, at_point: f32, off: vec2<f32>) -> vec3<f32> {
    let texel = clamp(floor(center + off), vec2(0.0), view.size - 1.0);
    let depths = solid_depths(view, view.origin + vec2<u32>(texel));
    let depth = max(depths.x, max(depths.y, depths.z));
    let distance = near + depth * DEPTHS;
    let linear = select(distance, 1.0 / max(distance, 1e-6), view.perspective > 0.0);
    return vec3(texel + 0.5 - center, select(linear - at_point, NO_SURFACE, depth >= 1.0));
}

// Change of the plane per texel; zero where the map sees none. Distances are in steps of a curve's depths.
// `near`: of the near plane; `center`: place of the point [texels]; `at_point`: its distance, or in a
// perspective view the inverse; `slack`: largest error of a surface on the plane.
fn seen_plane(view: GpuView, near: f32, center: vec2<f32>, at_point: f32, slack: f32) -> vec2<f32> {
    var ring = FIRST_RING;
    var by_texel = vec2(0.0);
    loop {
        // The two texels in different directions with the least errors: occluders are far off the surface.
        var first = vec3(1.0, 0.0, NO_SURFACE);
        for (var i = 0u; i < AROUND_COUNT; i += 1u) {
            let seen = surface_around(view, near, center, at_point, around_offset(i) * ring);
            first = select(first, seen, abs(seen.z) < abs(first.z));
        }
        var second = vec3(0.0, 1.0, NO_SURFACE);
        for (var i = 0u; i < AROUND_COUNT; i += 1u) {
            let seen = surface_around(view, near, center, at_point, around_offset(i) * ring);
            // For opposite texels the cross product is at most `ring`.
            let is_aside = abs(first.x * seen.y - first.y * seen.x) > ring;
            second = select(second, seen, is_aside & (abs(seen.z) < abs(second.z)));
        }
        let across = first.x * second.y - first.y * second.x;
        let is_whole = (abs(across) > 1.0) & (max(abs(first.z), abs(second.z)) < NO_SURFACE);
        by_texel = vec2(first.z * second.y - second.z * first.y, second.z * first.x - first.z * second.x)
            / select(1.0, across, is_whole);
        let most_off = slack + ROUGH * (abs(by_texel.x) + abs(by_texel.y));
        var count = 0u;
        for (var i = 0u; i < AROUND_COUNT; i += 1u) {
            let seen = surface_around(view, near, center, at_point, around_offset(i) * ring);
            count += select(0u, 1u, abs(seen.z - dot(by_texel, seen.xy)) <= most_off);
        }
        if is_whole & (count >= LEAST_ON_PLANE) {
            break;
        }
        ring *= NEXT_RING;
        if ring > LAST_RING {
            by_texel = vec2(0.0);
            break;
        }
    }
    return by_texel;
}
