// soften, columns: the maps, with a grey or coloured filter in place of holes.

import package::bind::sampled::{filters, nearests, opaques};
import package::bind::stored::{soft_filters, soft_nearests, soft_opaques};
import package::records::texel::is_dithered;
import package::records::view::GpuView;
import package::soften::run::{EMPTY_RUN, Run, add_run, load_run, opaque_depths};

fn start(view: GpuView, at: vec2<i32>) -> Run {
    return EMPTY_RUN;
}

fn add(sum: Run, view: GpuView, at: vec2<i32>, off: i32) -> Run {
    return add_run(sum, load_run(view, at), off);
}

fn store(view: GpuView, at: vec2<i32>, run: Run) {
    let filtered = textureLoad(filters, at, view.layer, 0);
    let nearest = textureLoad(nearests, at, view.layer, 0).r;
    let opaque_depth = textureLoad(opaques, at, view.layer, 0).r;
    let light = max(filtered.rgb * (1.0 - run.blocked), vec3(0.0));
    let depths = opaque_depths(view, select(at, vec2<i32>(run.hole), run.hole.x >= 0.0));
    let behind = select(1.0, max(max(depths.r, depths.g), depths.b), run.hole.x >= 0.0);
    let soft = select(filtered.rgb, light, run.blocked > vec3(0.0));
    textureStore(soft_filters, at, view.layer, vec4(soft, filtered.a));
    textureStore(soft_nearests, at, view.layer, vec4(min(nearest, run.nearest)));
    textureStore(soft_opaques, at, view.layer, vec4(select(opaque_depth, behind, is_dithered(opaque_depth))));
}
