// Lists of a band's points to light: its surfaces, and its panes. For each list, `point_lists` holds the
// workgroups of its dispatch in x, y and z and its length; then come the points of all lists. Rust:
// crates/gobo-picture/src/stage/shade.rs.

import package::bind::picture_in::point_lists;
import package::bind::uniform::point_batch;

const SURFACE_LIST: u32 = 0u;
const PANE_LIST: u32 = 1u;
const LIST_COUNT: u32 = 2u;
const NO_LIST: u32 = 0xffffffffu;

const LIST_ROWS: u32 = 2u;   // workgroups of a dispatch in y
const POINT_LANES: u32 = 64u; // workgroup size of kernels over points

// Words of a list's head.
const LIST_HEAD: u32 = 4u;
const LIST_LENGTH: u32 = 3u;

// Place of a list's first point; `pixel_count`: capacity of a band, and so of each list.
fn list_first(list: u32, pixel_count: u32) -> u32 {
    return LIST_COUNT * LIST_HEAD + list * pixel_count;
}

// Points that a dispatch evaluates: a list of the band, or all points of a batch.
fn is_listed() -> bool {
    return point_batch.list != NO_LIST;
}

fn point_count() -> u32 {
    let head = select(0u, point_batch.list * LIST_HEAD, is_listed());
    return select(point_batch.count, point_lists[head + LIST_LENGTH], is_listed());
}

fn point_at(index: u32) -> u32 {
    let entry = select(0u, point_batch.first + index, is_listed());
    return select(index, point_lists[entry], is_listed());
}
