// What a subgroup's lanes share of a disc: all but its reach. Needs common/disc.wgsl.
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
    }
    return other;
}
