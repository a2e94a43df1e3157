// Summary of the dithered surfaces in a run of texels, per channel.

import package::records::opaque_depth::is_dithered;

struct ColoredRun {
    blocked: vec3<f32>, // share of the window
    nearest: f32,       // dithered depth of any channel, 1 for none
    hole: f32,          // depth behind the closest hole of any channel, negative for none
    distance: f32,      // of that hole [texels]
}

const EMPTY_COLORED: ColoredRun = ColoredRun(vec3(0.0), 1.0, -1.0, 1e6);

fn add_colored(sum: ColoredRun, other: ColoredRun, weight: f32, away: i32) -> ColoredRun {
    let distance = other.distance + f32(away);
    let closer = distance < sum.distance;
    return ColoredRun(
        sum.blocked + weight * other.blocked,
        min(sum.nearest, other.nearest),
        select(sum.hole, other.hole, closer),
        select(sum.distance, distance, closer),
    );
}

// Run of one texel. An opaque surface that is not dithered has the same depth in every channel, behind the
// dithered ones.
fn colored_run(depths: vec3<f32>) -> ColoredRun {
    let dithered = vec3(is_dithered(depths.r), is_dithered(depths.g), is_dithered(depths.b));
    let near = select(vec3(1.0), depths, dithered);
    let last = max(max(depths.r, depths.g), depths.b);
    return ColoredRun(
        select(vec3(0.0), vec3(1.0), dithered),
        min(min(near.r, near.g), near.b),
        select(last, -1.0, all(dithered)),
        select(0.0, 1e6, all(dithered)),
    );
}
