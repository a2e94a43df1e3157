// Visits the rest of a block's slabs, from where no hit is inserted by itself, as wgsl/llvmpipe/queue.wgsl visits
// tiles: a slab's soft discs that touch the block are collected, and eight at a time are visited with no branch in
// between. The order is that of wgsl/traversal/slabs_subgroup.wgsl, and so are the bits.

import package::curve::gather::{flush, merge, settled, single};
import package::curve::list::must_merge;
import package::curve::slab::{is_within, next_slab};
import package::curve::visit_discs::{touches, visit_disc};
import package::hit::disc::{broadcast_disc, prepare_disc};
import package::llvmpipe::queue::{Collected, QUEUE, collect, join_lanes, without_eight};
import package::records::footprint::{Footprint, footprint_key, key_depth};
import package::records::footprint_loaded::load_footprint;
import package::records::view::GpuView;
import package::traversal::slabs_subgroup::{base, slab};
import package::traversal::subgroup_block::{Block, block_high, block_low};
import choice::pairs::pair_footprint;
import choice::rows::any_row;

// Discs of a slab, as in queue.wgsl.
struct SlabQueue {
    collected: Collected,
    whole: bool, // no pair of the slab is left
}

fn leaves_rest() -> bool {
    return !subgroupAny(any_row(single));
}

fn needs_discs(queue: SlabQueue) -> bool {
    return (queue.collected.count < QUEUE) & !queue.whole;
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
            queue.collected = collect(queue.collected, a, b, marked, block.lane);
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
    var disc = prepare_disc(view, load_footprint(queue.collected.footprints.x));
    let share = select(0.0, 1.0, lane < queue.collected.count);
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
    var queue = SlabQueue(Collected(vec3(0u), 0u), false);
    loop {
        queue = fill_slab(view, queue, end, block);
        visit_eight(view, queue, block.lane);
        queue.collected = without_eight(queue.collected);
        if queue.whole & (queue.collected.count == 0u) {
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
