// Summary of the dithered surfaces in a run of texels, for curves. CPU reference: src/reference/curve/soften.rs.

struct CurveRun {
    blocked: vec3<f32>, // share of the window, per channel
    nearest: f32,       // nearest dithered depth, 1 for none
    moments: vec3<f32>, // share, times the depth, times its square; mean of the channels
    farthest: f32,      // farthest dithered depth, -1 for none
    hole: vec2<f32>,    // texel of the closest hole, negative for none
    distance: f32,      // of that hole [texels]
}

const EMPTY_CURVE_RUN: CurveRun = CurveRun(vec3(0.0), 1.0, vec3(0.0), -1.0, vec2(-1.0), 1e6);

const CURVE_RUN_LAYERS: u32 = 3u; // of `rows`, per layer of the maps

fn add_curve_run(sum: CurveRun, other: CurveRun, weight: f32, away: i32) -> CurveRun {
    let distance = other.distance + f32(away);
    let closer = distance < sum.distance;
    return CurveRun(
        sum.blocked + weight * other.blocked,
        min(sum.nearest, other.nearest),
        sum.moments + weight * other.moments,
        max(sum.farthest, other.farthest),
        select(sum.hole, other.hole, closer),
        select(sum.distance, distance, closer),
    );
}
