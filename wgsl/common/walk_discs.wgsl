// Walks a tile's soft discs front to back, a subgroup at a time: what most smoke is made of, with
// all else compiled away. Every lane prepares one disc and tests it against the subgroup's block
// of texels; the discs that touch it are broadcast and multiplied into every lane's texels.
// CPU twin: src/cpu/accumulate.rs. Needs common/gather_discs.wgsl; the kernel binds `pairs` and
// `footprints`.
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
        let look = textureLoad(footprints, record_texel(at + 1u));
        let disc = prepare_disc(view, textureLoad(footprints, record_texel(at)), look);
        let outside = disc.center - clamp(disc.center, lo, hi);
        let touches = base + lane < end && dot(outside, outside) <= disc.reach * disc.reach;
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
            visit_disc(view, broadcast_disc(disc, j));
        }
        // What follows is no nearer than this stretch's first pair.
        if subgroupAll(settled(subgroupShuffle(f32(look.z >> 16u) / f32(INVISIBLE - 1u), 0u))) {
            break;
        }
    }
}
