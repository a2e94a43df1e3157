// Ray of a texel of our map in the clip space of a host's camera with the same rays: clip coordinates are
// `slope * distance + start`, `distance` along our axis [m]. Rust: crates/gobo-reference/src/import.rs.

struct ClipRay {
    slope: vec4<f32>,
    start: vec4<f32>,
}

// `across`: offset from the axis, in a perspective view at 1 m along it [m].
fn clip_ray(clip: mat4x4<f32>, across: vec2<f32>, perspective: f32) -> ClipRay {
    let spreads = perspective > 0.0;
    let slope = select(-clip[2], clip * vec4(across, -1.0, 0.0), spreads);
    return ClipRay(slope, select(clip * vec4(across, 0.0, 1.0), clip[3], spreads));
}

// `texel`: a point of our map [texels].
fn across_axis(texel: vec2<f32>, size: vec2<f32>, scale: f32) -> vec2<f32> {
    return (texel - size * 0.5) / scale * vec2(1.0, -1.0);
}
