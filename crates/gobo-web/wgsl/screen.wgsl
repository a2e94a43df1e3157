// The background, and the picture on the screen.

@group(2) @binding(0) var sky: texture_2d<f32>;

struct Pixel {
    @builtin(position) clip: vec4<f32>,
    @location(0) place: vec2<f32>,
}

@vertex
fn screen_corner(@builtin(vertex_index) index: u32) -> Pixel {
    let place = vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return Pixel(vec4(place, 0.0, 1.0), place);
}

fn texel(at: vec2<i32>) -> vec3<f32> {
    return textureLoad(sky, clamp(at, vec2(0), vec2(i32(frame.sky_edge) + 1)), 0).rgb;
}

@fragment
fn sky_pixel(pixel: Pixel) -> @location(0) vec4<f32> {
    if frame.sky_edge == 0u {
        return vec4(frame.background.rgb, 1.0);
    }
    let ray = frame.forward.xyz + pixel.place.x * frame.right.w * frame.right.xyz
        + pixel.place.y * frame.up.w * frame.up.xyz;
    // Octahedral (Cigolle et al. 2014); the map has a border of a texel.
    let n = ray / (abs(ray.x) + abs(ray.y) + abs(ray.z));
    let sides = select(vec2(-1.0), vec2(1.0), n.xy >= vec2(0.0));
    let flat = select(n.xy, (1.0 - abs(n.yx)) * sides, n.z < 0.0);
    let place = (flat * 0.5 + 0.5) * f32(frame.sky_edge) + 0.5;
    let low = floor(place);
    let part = place - low;
    let at = vec2<i32>(low);
    let upper = mix(texel(at), texel(at + vec2(1, 0)), part.x);
    let lower = mix(texel(at + vec2(0, 1)), texel(at + vec2(1, 1)), part.x);
    return vec4(mix(upper, lower, part.y), 1.0);
}
