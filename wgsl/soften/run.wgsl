// Summary of the dithered surfaces in a run of texels. CPU reference: crates/gobo-reference/src/soften.rs,
// crates/gobo-reference/src/curve/soften.rs. Rust: src/stage/soften.rs.

import package::bind::sampled::{colored, rows};
import package::bind::uniform::soften_params;
import package::features::NODES;
import package::records::texel::is_dithered;
import package::records::view::GpuView;

override COLORED: bool = false; // whether opaque depths are per channel

struct SoftenParams {
    radius: i32, // half the window [texels]
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
}

struct Run {
    blocked: vec3<f32>, // share of the window, per channel
    nearest: f32,       // nearest dithered depth of any channel, 1 for none
    hole: vec2<f32>,    // texel of the atlas with the closest hole of any channel, negative for none
    distance: f32,      // distance to that hole [texels]
    farthest: f32,      // farthest dithered depth, -1 for none
    moments: vec3<f32>, // share, times the depth, times its square; mean of the channels
}

const EMPTY_RUN: Run = Run(vec3(0.0), 1.0, vec2(-1.0), 1e6, -1.0, vec3(0.0));

// First and last offset of a window, including texels beyond the map's edge.
fn window(before: i32, behind: i32) -> vec2<i32> {
    // Not by the uniform alone: lavapipe recompiles such a loop for every buffer.
    let radius = select(soften_params.radius, 0, before < 0);
    return vec2(-radius, radius);
}

// `off`: offset of the other run in a window of 2 radius texels, with half weights at its ends.
fn add_run(sum: Run, other: Run, off: i32) -> Run {
    let whole = 0.5 / f32(soften_params.radius);
    let weight = select(whole, 0.5 * whole, abs(off) == soften_params.radius);
    let distance = other.distance + f32(abs(off));
    let closer = distance < sum.distance;
    return Run(
        sum.blocked + weight * other.blocked,
        min(sum.nearest, other.nearest),
        select(sum.hole, other.hole, closer),
        select(sum.distance, distance, closer),
        max(sum.farthest, other.farthest),
        sum.moments + weight * other.moments,
    );
}

// Opaque depths per channel. A surface that is not dithered has the same depth in all, behind the dithered
// ones.
fn opaque_depths(view: GpuView, at: vec2<i32>) -> vec3<f32> {
    let depths = textureLoad(colored, at, view.layer, 0).rgb;
    return select(depths.rrr, depths, COLORED);
}

// Run of one texel.
fn texel_run(view: GpuView, at: vec2<i32>) -> Run {
    let depths = opaque_depths(view, at);
    let dithered = vec3(is_dithered(depths.r), is_dithered(depths.g), is_dithered(depths.b));
    let blocked = select(vec3(0.0), vec3(1.0), dithered);
    let near = select(vec3(1.0), depths, dithered);
    let far = select(vec3(-1.0), depths, dithered);
    let moments = vec3(dot(blocked, vec3(1.0)), dot(blocked, depths), dot(blocked, depths * depths));
    return Run(
        blocked,
        min(min(near.r, near.g), near.b),
        select(vec2<f32>(at), vec2(-1.0), all(dithered)),
        select(0.0, 1e6, all(dithered)),
        max(max(far.r, far.g), far.b),
        moments / 3.0,
    );
}

// Whether a run of a row takes one texel of `rows`; else it takes two, and with curves three. Rust:
// `run_layers`.
fn is_grey() -> bool {
    return !COLORED && NODES == 0u;
}

fn run_layer(view: GpuView) -> u32 {
    if is_grey() {
        return view.layer;
    }
    return select(2u, 3u, NODES > 0u) * view.layer;
}

fn load_run(view: GpuView, at: vec2<i32>) -> Run {
    let layer = run_layer(view);
    let y = f32(at.y);
    let first = textureLoad(rows, at, layer, 0);
    if is_grey() {
        return Run(first.rrr, first.g, vec2(first.b, y), first.a, -1.0, vec3(0.0));
    }
    let second = textureLoad(rows, at, layer + 1u, 0);
    var run = Run(first.rgb, first.a, vec2(second.r, y), second.g, second.b, vec3(0.0));
    if NODES > 0u {
        run.moments = textureLoad(rows, at, layer + 2u, 0).rgb;
    }
    return run;
}
