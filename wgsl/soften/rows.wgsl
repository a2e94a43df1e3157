// soften, rows: summary of the dithered surfaces in each row's window.

import package::bind::stored::rows;
import package::features::NODES;
import package::records::view::GpuView;
import package::soften::run::{EMPTY_RUN, Run, add_run, is_grey, run_layer, texel_run};

fn start(view: GpuView, at: vec2<i32>) -> Run {
    return EMPTY_RUN;
}

fn add(sum: Run, view: GpuView, at: vec2<i32>, off: i32) -> Run {
    return add_run(sum, texel_run(view, at), off);
}

fn store(view: GpuView, at: vec2<i32>, run: Run) {
    let layer = run_layer(view);
    if is_grey() {
        textureStore(rows, at, layer, vec4(run.blocked.r, run.nearest, run.hole.x, run.distance));
    } else {
        textureStore(rows, at, layer, vec4(run.blocked, run.nearest));
        textureStore(rows, at, layer + 1u, vec4(run.hole.x, run.distance, run.farthest, 0.0));
    }
    if NODES > 0u {
        textureStore(rows, at, layer + 2u, vec4(run.moments, 0.0));
    }
}
