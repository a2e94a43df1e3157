// The camera's view.

import package::bind::sampled::tiles;
import package::bind::uniform::views;
import package::records::view::GpuView;

fn camera() -> GpuView {
    var view = views[0];
    // Not by `views` alone: lavapipe recompiles a kernel for every picture where a uniform buffer decides a
    // branch.
    view.perspective = select(0.0, view.perspective, textureDimensions(tiles).x > 0u);
    return view;
}
