// Points of a band that are lit: its surfaces, and its panes. `point_lists` holds for each list the
// workgroups of its dispatch in x, y and z and its length, and then the points of all lists. Rust:
// crates/gobo-picture/src/stage/shade.rs.

const SURFACE_LIST: u32 = 0u;
const PANE_LIST: u32 = 1u;
const LIST_COUNT: u32 = 2u;
const NO_LIST: u32 = 0xffffffffu;

const LIST_ROWS: u32 = 2u;   // workgroups of a dispatch in y
const POINT_LANES: u32 = 64u; // workgroup size of kernels over points

// Words of a list's head.
const LIST_HEAD: u32 = 4u;
const LIST_LENGTH: u32 = 3u;

// First point of a list; `pixel_count`: capacity of a band, so of the list before.
fn list_first(list: u32, pixel_count: u32) -> u32 {
    return LIST_COUNT * LIST_HEAD + list * pixel_count;
}
