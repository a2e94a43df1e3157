// Summary of the dithered surfaces in a run of texels. CPU reference: src/reference/filter.rs.

struct FilterParams {
    radius: i32, // half the window [texels]
    colored: u32, // 1: opaque depths are per channel
    pad_0: u32,
    pad_1: u32,
}

// blocked share, nearest dithered depth, depth behind the closest hole (-1: none), its distance
const EMPTY_RUN: vec4<f32> = vec4(0.0, 1.0, -1.0, 1e6);

fn add_run(sum: vec4<f32>, other: vec4<f32>, weight: f32, away: i32) -> vec4<f32> {
    let distance = other.w + f32(away);
    let closer = distance < sum.w;
    return vec4(
        sum.x + weight * other.x,
        min(sum.y, other.y),
        select(sum.z, other.z, closer),
        select(sum.w, distance, closer),
    );
}

// Weight in a window of 2 * radius texels, with half weights at its ends.
fn window_weight(i: i32, radius: i32) -> f32 {
    let whole = 0.5 / f32(radius);
    return select(whole, 0.5 * whole, abs(i) == radius);
}
