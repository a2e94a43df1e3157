// All pairs are visited in one way.

import package::records::view::GpuView;
import package::traversal::subgroup_block::Block;

fn leaves_rest() -> bool {
    return false;
}

fn visit_rest(view: GpuView, end: u32, block: Block) {}
