// Properties of the receiver that choose the casters that tint it, set before light is evaluated.

import package::records::material::{RECEIVES_OPAQUE, RECEIVES_OTHERS};
import package::records::owner::stored_tag;

var<private> receives: u32;     // RECEIVES_*
var<private> receiver_tag: u32; // owner tag of its object
var<private> is_solid: bool;    // it is opaque: in no filter map, so it is none of the translucent casters
var<private> is_leaf: bool;     // it is in the filter map itself

fn set_receiver(accepts: u32, tag: u32, solid: bool) {
    receives = accepts;
    receiver_tag = tag;
    is_solid = solid;
}

fn set_leaf(leaf: bool) {
    is_leaf = leaf;
}

// Whether a texel's translucent casters tint the receiver at all. `filtered` and `nearest`: in the format of
// the maps.
fn is_tinted(filtered: vec4<f32>, nearest: f32) -> bool {
    let is_shown = receives == RECEIVES_OTHERS && stored_tag(filtered.a, nearest) == receiver_tag;
    return receives != RECEIVES_OPAQUE && !is_shown;
}
