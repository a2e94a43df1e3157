// Extents of casters in a map. CPU reference: crates/gobo-reference/src/project.rs,
// crates/gobo-reference/src/brick.rs.

import package::bind::stored::{keys, rects};
import package::records::brick::{Brick, voxel_edges};
import package::records::record::record_texel;
import package::records::view::GpuView;

// The key and the tile rectangle of a footprint.
fn put(index: u32, key: u32, rect: vec2<u32>) {
    let texel = record_texel(index);
    textureStore(keys, texel, vec4(key, index, 0u, 0u));
    textureStore(rects, texel, vec4(rect, 0u, 0u));
}

// Slopes of a sphere.

// Slopes between which a sphere of radius `sphere` at `(x, distance)` is seen; unbounded if the eye is
// inside.
fn tangents(x: f32, distance: f32, sphere: f32) -> vec2<f32> {
    const ENDLESS: f32 = 1e6;
    let t2 = x * x + distance * distance - sphere * sphere;
    if t2 <= 0.0 {
        return vec2(-ENDLESS, ENDLESS);
    }
    let t = sqrt(t2);
    let low = vec2(x * t - distance * sphere, distance * t + x * sphere);
    let high = vec2(x * t + distance * sphere, distance * t - x * sphere);
    return vec2(
        select(-ENDLESS, low.x / low.y, low.y > 0.0),
        select(ENDLESS, high.x / high.y, high.y > 0.0),
    );
}

// Extent of a brick's box in a view.

// Largest error of a right angle between edges, as a cosine.
const SQUARE: f32 = 1e-4;
// Rounding of the least distance of a right-angled box, as a share of the distances that it is computed from.
// Small, so that neighbours stay in order where the eye is hardly beside the plane of their shared face.
const DISTANCE_ROUNDING: f32 = 4e-6;

struct BrickExtent {
    lo: vec2<f32>,    // box in the map [texels], where `nearest` is in front of the eye
    hi: vec2<f32>,
    nearest: f32,     // along the axis [m]
    farthest: f32,
    least: f32,       // lower bound of the distance of its nearest point from the origin of view space [m]
}

// `center`: of the box, in view space [m].
fn brick_extent(view: GpuView, brick: Brick, center: vec3<f32>) -> BrickExtent {
    let edges = voxel_edges(brick);
    let half_size = (brick.high - brick.low) * 0.5;
    let rotation = mat3x3(
        view.view_from_world[0].xyz,
        view.view_from_world[1].xyz,
        view.view_from_world[2].xyz,
    );
    let x = rotation * edges[0] * half_size.x;
    let y = rotation * edges[1] * half_size.y;
    let z = rotation * edges[2] * half_size.z;
    let reach = abs(x.z) + abs(y.z) + abs(z.z);
    var all = BrickExtent(vec2(1e30), vec2(-1e30), -center.z - reach, -center.z + reach, 0.0);
    for (var i = 0u; i < 8u; i += 1u) {
        let sign = select(vec3(-1.0), vec3(1.0), (vec3(i) & vec3(1u, 2u, 4u)) != vec3(0u));
        let corner = center + x * sign.x + y * sign.y + z * sign.z;
        let per_metre = select(1.0, 1.0 / -corner.z, view.perspective > 0.0);
        let texel = vec2(corner.x, -corner.y) * view.scale * per_metre + view.size * 0.5;
        all.lo = min(all.lo, texel);
        all.hi = max(all.hi, texel);
    }
    let lengths = vec3(length(x), length(y), length(z));
    let skews = abs(vec3(dot(x, y), dot(y, z), dot(z, x))) / (lengths * lengths.yzx);
    let skew = max(max(skews.x, skews.y), skews.z);
    let away = length(center);
    if skew < SQUARE {
        let beside = abs(vec3(dot(center, x), dot(center, y), dot(center, z))) / lengths;
        all.least = length(max(beside - lengths, vec3(0.0)));
    } else {
        all.least = away - length(abs(x) + abs(y) + abs(z));
    }
    let rounding = (min(skew, SQUARE) + DISTANCE_ROUNDING) * (away + lengths.x + lengths.y + lengths.z);
    all.least = max(all.least - rounding, 0.0);
    return all;
}
