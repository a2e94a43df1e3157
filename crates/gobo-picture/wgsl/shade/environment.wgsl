// Radiance of the background or environment from a direction, prefiltered for reflections. CPU reference:
// `from_around` in crates/gobo-reference/src/shading/mod.rs; the maps are made in src/model/environment.rs.

import package::bind::picture_in::environment;
import package::bind::uniform::picture_params;
import package::features::HAS_ENVIRONMENT;
import package::records::record::record_texel;

const LEVELS_AROUND: u32 = 6u; // of roughness
const ROUGH_SIZE: u32 = 64u;   // edge of all levels but the first, without their borders [texels]

// `direction`: unit; `roughness`: 0 for the visible background and sharp reflections.
fn from_around(direction: vec3<f32>, roughness: f32) -> vec3<f32> {
    if !HAS_ENVIRONMENT {
        return picture_params.background;
    }
    let n = direction / (abs(direction.x) + abs(direction.y) + abs(direction.z));
    let sides = select(vec2(-1.0), vec2(1.0), n.xy >= vec2(0.0));
    let point = select(n.xy, (1.0 - abs(n.yx)) * sides, n.z < 0.0) * 0.5 + 0.5;
    let level = saturate(roughness) * f32(LEVELS_AROUND - 1u);
    let low = u32(level);
    let sharp = level_around(low, point);
    // A roughness of exactly one level needs no other.
    if level == f32(low) {
        return sharp;
    }
    return mix(sharp, level_around(low + 1u, point), level - f32(low));
}

// `point`: point of the octahedral square, 0..1.
fn level_around(level: u32, point: vec2<f32>) -> vec3<f32> {
    let fine = picture_params.environment_size;
    let size = select(ROUGH_SIZE, fine, level == 0u);
    let row = size + 2u;
    let rough_texels = (ROUGH_SIZE + 2u) * (ROUGH_SIZE + 2u);
    let first = select((fine + 2u) * (fine + 2u) + (max(level, 1u) - 1u) * rough_texels, 0u, level == 0u);
    // The centre of the border's texel is half a texel outside the square.
    let at = point * f32(size) + 0.5;
    let low = vec2<u32>(at);
    let part = at - vec2<f32>(low);
    let corner = first + low.y * row + low.x;
    let top = mix(texel_around(corner), texel_around(corner + 1u), part.x);
    let bottom = mix(texel_around(corner + row), texel_around(corner + row + 1u), part.x);
    return mix(top, bottom, part.y);
}

fn texel_around(index: u32) -> vec3<f32> {
    return textureLoad(environment, record_texel(index), 0).rgb;
}
