// Where one level hands over to the next, each occluder counts with a share that falls linearly over a range
// of depths. A block's ramp has the mean depth of its texels' ramps, and so the same share. Split at one
// depth, ramps of different lengths would have different shares, and the shadow a bright line.

// A fade: the share falls from 1 at `low` to 0 at `high`.
struct Fade {
    low: f32,
    high: f32,
    slope: f32,
}

fn fade_between(depths: vec2<f32>) -> Fade {
    return Fade(depths.x, depths.y, 1.0 / max(depths.y - depths.x, 1e-3));
}

// Share of a ramp of length 1 / `inverse` that counts as before the fade, seen from the light, of its part
// from `start` to `stop`.
fn share_before(fade: Fade, start: f32, stop: f32, inverse: f32) -> f32 {
    let inside = clamp(vec2(start, stop), vec2(fade.low), vec2(fade.high));
    let weights = (fade.high - inside) * fade.slope;
    let whole = max(min(stop, fade.low) - start, 0.0);
    return saturate((whole + (inside.y - inside.x) * 0.5 * (weights.x + weights.y)) * inverse);
}
