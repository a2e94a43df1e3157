// Visits the rest of a block's slabs, from where no hit is inserted by itself, as wgsl/llvmpipe/queue.wgsl visits
// tiles: a slab's soft discs that touch the block are collected, and eight at a time are visited with no branch in
// between. The order is that of wgsl/traversal/slabs_subgroup.wgsl, and so are the bits.

import package::curve::gather::{flush, merge, settled, single};
import package::curve::list::must_merge;
import package::curve::slab::{is_within, next_slab};
import package::curve::visit_discs::{touches, visit_disc};
import package::hit::disc::{broadcast_disc, prepare_disc};
import package::llvmpipe::queue::{QUEUE, join_lanes, nth_lane, ranks};
import package::records::footprint::{Footprint, footprint_key, key_depth};
import package::records::footprint_loaded::load_footprint;
import package::records::view::GpuView;
import package::traversal::slabs_subgroup::{base, slab};
import package::traversal::subgroup_block::{Block, block_high, block_low};
import choice::pairs::pair_footprint;
import choice::rows::any_row;

// Discs of a slab, as in queue.wgsl.
struct SlabQueue {
    footprints: vec3<u32>, // per lane: of the next discs, of those behind them, and so on
    count: u32,            // of all lanes' discs
    whole: bool,           // no pair of the slab is left
}

fn leaves_rest() -> bool {
    return !subgroupAny(any_row(single));
}

fn needs_discs(queue: SlabQueue) -> bool {
    return (queue.count < QUEUE) & !queue.whole;
}

// Bits of a pair: the slab has it, and its disc touches the block.
fn pair_bits(view: GpuView, footprint: Footprint, is_there: bool, block: Block) -> vec2<u32> {
    let within = is_there & is_within(slab, footprint_key(footprint));
    let touched = within & touches(view, footprint, block_low(block), block_high(block));
    return vec2(u32(within), u32(touched));
}

fn fill_slab(view: GpuView, old: SlabQueue, end: u32, block: Block) -> SlabQueue {
    var queue = old;
    loop {
        if needs_discs(queue) {
            let pair = base + block.lane;
            let a = pair_footprint(min(pair, end - 1u));
            let b = pair_footprint(min(pair + QUEUE, end - 1u));
            let bits_a = pair_bits(view, load_footprint(a), pair < end, block);
            let bits_b = pair_bits(view, load_footprint(b), pair + QUEUE < end, block);
            let digit = bits_a.y | (bits_b.y << 1u) | (bits_a.x << 2u) | (bits_b.x << 3u);
            let marked = join_lanes(digit << (4u * block.lane), block.lane);
            let ranks_a = ranks(marked & 0x11111111u);
            let ranks_b = ranks((marked >> 1u) & 0x11111111u);
            let count_a = queue.count + (ranks_a >> 28u);
            let next_a = subgroupShuffle(a, nth_lane(ranks_a, (block.lane - queue.count) & 7u));
            let next_b = subgroupShuffle(b, nth_lane(ranks_b, (block.lane - count_a) & 7u));
            let first = select(next_b, next_a, block.lane < count_a);
            queue.footprints = vec3(
                select(first, queue.footprints.x, block.lane < queue.count),
                select(next_b, next_a, block.lane + QUEUE < count_a),
                next_b,
            );
            queue.count = count_a + (ranks_b >> 28u);
            let pair_count = countOneBits(marked & 0xccccccccu);
            base += pair_count;
            queue.whole = pair_count < 2u * QUEUE;
        }
        if !needs_discs(queue) {
            break;
        }
    }
    return queue;
}

fn visit_eight(view: GpuView, queue: SlabQueue, lane: u32) {
    var disc = prepare_disc(view, load_footprint(queue.footprints.x));
    let share = select(0.0, 1.0, lane < queue.count);
    disc.slope *= share;
    disc.absorbed *= share;
    _ = visit_disc(view, broadcast_disc(disc, 0u));
    _ = visit_disc(view, broadcast_disc(disc, 1u));
    _ = visit_disc(view, broadcast_disc(disc, 2u));
    _ = visit_disc(view, broadcast_disc(disc, 3u));
    _ = visit_disc(view, broadcast_disc(disc, 4u));
    _ = visit_disc(view, broadcast_disc(disc, 5u));
    _ = visit_disc(view, broadcast_disc(disc, 6u));
    _ = visit_disc(view, broadcast_disc(disc, 7u));
}

fn visit_rest_slab(view: GpuView, end: u32, block: Block) {
    var queue = SlabQueue(vec3(0u), 0u, false);
    loop {
        queue = fill_slab(view, queue, end, block);
        visit_eight(view, queue, block.lane);
        queue.footprints = queue.footprints.yzz;
        queue.count = max(queue.count, QUEUE) - QUEUE;
        if queue.whole & (queue.count == 0u) {
            break;
        }
    }
}

fn visit_rest(view: GpuView, end: u32, block: Block) {
    var is_end = false;
    loop {
        var merges = false;
        loop {
            visit_rest_slab(view, end, block);
            flush(true);
            merges = subgroupAny(must_merge());
            slab = next_slab(slab, base, end);
            is_end = base >= end || subgroupAll(settled(key_depth(slab.key)));
            if is_end | merges {
                break;
            }
        }
        if merges {
            merge();
        }
        if is_end {
            break;
        }
    }
}
