// Lane operations on discs in a subgroup.

import package::features::{PERSPECTIVE, WIDE};
import package::hit::disc::Disc;

fn broadcast_disc(disc: Disc, j: u32) -> Disc {
    var other: Disc;
    other.center = subgroupShuffle(disc.center, j);
    other.bend = subgroupShuffle(disc.bend, j);
    other.depth = subgroupShuffle(disc.depth, j);
    other.slope = subgroupShuffle(disc.slope, j);
    other.absorbed = subgroupShuffle(disc.absorbed, j);
    if PERSPECTIVE {
        other.tilt = subgroupShuffle(disc.tilt, j);
        other.tilt_bend = subgroupShuffle(disc.tilt_bend, j);
        other.start = subgroupShuffle(disc.start, j);
    }
    return other;
}

// First lane of a ballot.
fn first_lane(mask: vec2<u32>) -> u32 {
    if !WIDE {
        return firstTrailingBit(mask.x);
    }
    return select(32u + firstTrailingBit(mask.y), firstTrailingBit(mask.x), mask.x != 0u);
}

fn without_first(mask: vec2<u32>) -> vec2<u32> {
    if !WIDE {
        return vec2(mask.x & (mask.x - 1u), 0u);
    }
    return select(vec2(0u, mask.y & (mask.y - 1u)), vec2(mask.x & (mask.x - 1u), mask.y), mask.x != 0u);
}

fn has_lanes(mask: vec2<u32>) -> bool {
    return select(mask.x, mask.x | mask.y, WIDE) != 0u;
}
