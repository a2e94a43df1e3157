// Walks a tile's opaque triangles front to back, a subgroup at a time: every lane fetches one and
// tests its box and its edges against the subgroup's block of texels; those that touch it are
// broadcast. CPU twin: src/reference/occlude.rs.

import package::bind::loaded::{footprints, pairs};
import package::records::record::{FOOTPRINT_TEXELS, record_texel};
import package::records::tile_rect::INVISIBLE;
import package::records::view::GpuView;
import package::state::triangles::{Sheet, corner, load_sheet, settled, visit_sheet};
import choice::rows::ROWS;

const EDGE_SLACK: f32 = 0.001; // [texels], for rounding

// Whether an edge has some of the block lo..hi on its inner side.
fn edge_touches(edge: vec4<f32>, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    let far = select(lo, hi, vec2((edge.w < 0.0), (edge.z > 0.0)));
    let slack = EDGE_SLACK * (abs(edge.z) + abs(edge.w));
    return edge.z * (far.y - edge.y) - edge.w * (far.x - edge.x) >= -slack;
}

fn walk(view: GpuView, first: u32, end: u32) {
    let lane = subgroupExclusiveAdd(1u);
    let all_lanes = subgroupBallot(true);
    let size = countOneBits(all_lanes.x) + countOneBits(all_lanes.y);
    // The block of texels that the subgroup holds, centre to centre: lanes follow each other in
    // rows of blocks, so that the first and the last are its corners. (As integers: LLVM 15 cannot
    // broadcast a float.)
    let texel = vec2<u32>(corner);
    let lo = vec2<f32>(subgroupBroadcastFirst(texel)) + 0.5;
    let hi = vec2<f32>(subgroupShuffle(texel, size - 1u)) + vec2(0.5, f32(ROWS) - 0.5);
    for (var base = first; base < end; base += size) {
        let at = textureLoad(pairs, record_texel(min(base + lane, end - 1u))).g * FOOTPRINT_TEXELS;
        let place = bitcast<vec4<f32>>(textureLoad(footprints, record_texel(at)));
        let look = textureLoad(footprints, record_texel(at + 1u));
        let sheet = load_sheet(look.x);
        let outside = abs(place.xy - clamp(place.xy, lo, hi));
        let touches = base + lane < end && max(outside.x, outside.y) <= place.z
            && edge_touches(sheet.edges[0], lo, hi) && edge_touches(sheet.edges[1], lo, hi)
            && edge_touches(sheet.edges[2], lo, hi);
        let ballot = subgroupBallot(touches);
        var low = ballot.x;
        var high = ballot.y;
        while (low | high) != 0u {
            var j: u32;
            if low != 0u {
                j = firstTrailingBit(low);
                low &= low - 1u;
            } else {
                j = 32u + firstTrailingBit(high);
                high &= high - 1u;
            }
            visit_sheet(broadcast_sheet(sheet, j));
        }
        // What follows is no nearer than this stretch's first pair.
        if subgroupAll(settled(subgroupShuffle(f32(look.z >> 16u) / f32(INVISIBLE - 1u), 0u))) {
            break;
        }
    }
}

fn broadcast_sheet(sheet: Sheet, j: u32) -> Sheet {
    var other: Sheet;
    for (var i = 0u; i < 3u; i += 1u) {
        other.edges[i] = subgroupShuffle(sheet.edges[i], j);
    }
    other.weights = subgroupShuffle(sheet.weights, j);
    other.ties = subgroupShuffle(sheet.ties, j);
    other.depths = subgroupShuffle(sheet.depths, j);
    return other;
}
