// occlusion, apply: takes the occluded part of the ambient light off the picture. A pixel averages the shares
// of the texels on its surface in a box of 4x4, in which all directions and places of the search count
// equally. One invocation per pixel. CPU reference: crates/gobo-reference/src/occlusion.rs. Rust:
// crates/gobo-picture/src/stage/occlusion.rs.

import package::bind::picture_in::{ambients, composited, occlusions};
import package::bind::picture_out::{pixels, radiance};
import package::bind::uniform::views;
import package::occlusion::occlusion::{radius_at, screen, seen_normal, seen_point, unpack_surroundings};
import package::shade::tone::on_screen;

// Distance from a pixel's plane at which another surface does not count [radii].
const OFF_PLANE: f32 = 0.1;
// Weight of surfaces that do not count, for pixels without any other around.
const OFF_PLANE_WEIGHT: f32 = 1e-4;

@compute @workgroup_size(8, 8)
fn occlusion_apply(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<u32>(views[0].size);
    if any(id.xy >= size) {
        return;
    }
    let around_pixel = unpack_surroundings(textureLoad(ambients, id.xy, 0));
    let on = screen();
    let point = seen_point(on, vec2<f32>(id.xy), around_pixel.depth);
    let normal = seen_normal(around_pixel.normal, point);
    // Distance from the plane of a surface at distance d in pixel q: (at_zero + dot(slope, q)) d -
    // dot(normal, point).
    let per_off = 1.0 / (OFF_PLANE * radius_at(point));
    let slope = normal.xy * on.step * per_off;
    let at_zero = (dot(normal.xy, on.first) - normal.z) * per_off;
    let pixel_plane = dot(normal, point) * per_off;
    let last = vec2<i32>(textureDimensions(occlusions)) - 1;
    let first = vec2<i32>(id.xy / 2u) - 2;
    let odd = vec2<f32>(id.xy & vec2(1u)) * 0.5 + 2.0;
    var sum = 0.0;
    var weights = 0.0;
    for (var i = 0u; i < 25u; i += 1u) {
        let step = vec2<i32>(vec2(i % 5u, i / 5u));
        let inside = clamp(first + step, vec2(0), last);
        let found = bitcast<vec2<f32>>(textureLoad(occlusions, inside, 0).xy);
        let near = saturate(2.5 - abs(odd - vec2<f32>(step)));
        let off = abs((at_zero + dot(slope, vec2<f32>(inside * 2))) * found.y - pixel_plane);
        let weight = near.x * near.y * max(1.0 - off, OFF_PLANE_WEIGHT);
        sum += found.x * weight;
        weights += weight;
    }
    let share = select(1.0, sum / weights, around_pixel.depth < 1.0);
    let before = textureLoad(composited, id.xy, 0);
    let light = max(before.rgb - around_pixel.light * (1.0 - share), vec3(0.0));
    textureStore(radiance, id.xy, vec4(light, before.w));
    pixels[id.y * size.x + id.x] = on_screen(light);
}
