// Walks a tile's soft discs, or splats, like wgsl/traversal/subgroup.wgsl, for subgroups of eight lanes on a
// software adapter, where branches, reductions and writes within loops are expensive and lanes are neighbours
// in a row. In crowded tiles the casters that touch the subgroup's block are collected in a queue; eight at a
// time are multiplied in, with no branch in between. CPU reference: crates/gobo-reference/src/accumulate.rs.

import package::accumulator::plain::{corner, seeks, settled, visit_plain};
import package::records::footprint::{footprint_key, key_depth, load_footprint};
import package::records::view::GpuView;
import package::traversal::lane::{Block, block_high, block_low};
import choice::plain::{Plain, SEEKS_APART, broadcast, only_if, plain_touches, prepare};
import choice::records::pair_record;

// Whether tiles have many casters.
override DENSE: bool = true;

const QUEUE: u32 = 8u; // lanes of the subgroup

struct Collected {
    footprints: vec3<u32>, // per lane: of the next casters, of the casters behind them, and so on
    count: u32,            // of all lanes' casters
}

struct Queue {
    collected: Collected,
    base: u32, // first pair that no lane has fetched
}

// Caster of a lane of the queue.
struct Prepared {
    plain: Plain,
    front: f32, // no later caster is nearer than that of the last lane
}

// Bitwise or of all lanes.
fn join_lanes(bits: u32, lane: u32) -> u32 {
    let two = bits | subgroupShuffle(bits, lane ^ 1u);
    let four = two | subgroupShuffle(two, lane ^ 2u);
    return four | subgroupShuffle(four, lane ^ 4u);
}

// Sum over all lanes.
fn lanes_sum(v: f32, lane: u32) -> f32 {
    let two = v + subgroupShuffle(v, lane ^ 1u);
    let four = two + subgroupShuffle(two, lane ^ 2u);
    return four + subgroupShuffle(four, lane ^ 4u);
}

// Prefix sums of the first bits of 4-bit digits: for each lane, the marked lanes up to it.
fn ranks(marked: u32) -> u32 {
    return marked * 0x11111111u;
}

// Index of the marked lane that comes after `n` others.
fn nth_lane(ranks: u32, n: u32) -> u32 {
    // Marks each lane but the last whose rank is at most `n`: the fourth bit of its digit stays.
    let before = (0x08888888u + n * 0x01111111u - (ranks & 0x07777777u)) & 0x08888888u;
    return (((before >> 3u) * 0x01111111u) >> 24u) & 7u;
}

// Adds footprints of two pairs of each lane, marked by the first two bits of the lane's digit.
fn collect(old: Collected, a: u32, b: u32, marked: u32, lane: u32) -> Collected {
    let ranks_a = ranks(marked & 0x11111111u);
    let ranks_b = ranks((marked >> 1u) & 0x11111111u);
    let count_a = old.count + (ranks_a >> 28u);
    // Lanes before `count` have a footprint; the others take the next ones, and the rest starts again at the
    // first lane.
    let next_a = subgroupShuffle(a, nth_lane(ranks_a, (lane - old.count) & 7u));
    let next_b = subgroupShuffle(b, nth_lane(ranks_b, (lane - count_a) & 7u));
    let first = select(next_b, next_a, lane < count_a);
    let footprints = vec3(
        select(first, old.footprints.x, lane < old.count),
        select(next_b, next_a, lane + QUEUE < count_a),
        next_b,
    );
    return Collected(footprints, count_a + (ranks_b >> 28u));
}

fn without_eight(old: Collected) -> Collected {
    return Collected(old.footprints.yzz, max(old.count, QUEUE) - QUEUE);
}

fn pair_footprint(pair: u32, end: u32) -> u32 {
    return pair_record(min(pair, end - 1u)).y;
}

fn needs_more(queue: Queue, end: u32) -> bool {
    return (queue.collected.count < QUEUE) & (queue.base < end);
}

fn fill(view: GpuView, old: Queue, end: u32, block: Block) -> Queue {
    return fill_within(view, old, end, block.lane, block_low(block), block_high(block));
}

// `low`, `high`: bounds of texel centres that a caster must touch.
fn fill_within(view: GpuView, old: Queue, end: u32, lane: u32, low: vec2<f32>, high: vec2<f32>) -> Queue {
    var queue = old;
    let digit = 1u << (4u * lane);
    loop {
        if needs_more(queue, end) {
            let pair = queue.base + lane;
            let a = pair_footprint(pair, end);
            let b = pair_footprint(pair + QUEUE, end);
            let touches_a = pair < end && plain_touches(view, load_footprint(a), low, high);
            let touches_b = pair + QUEUE < end && plain_touches(view, load_footprint(b), low, high);
            let marked =
                join_lanes(select(0u, digit, touches_a) | select(0u, digit << 1u, touches_b), lane);
            queue.collected = collect(queue.collected, a, b, marked, lane);
            queue.base += 2u * QUEUE;
        }
        if !needs_more(queue, end) {
            break;
        }
    }
    return queue;
}

fn prepare_lane(view: GpuView, id: u32, waits: bool) -> Prepared {
    let footprint = load_footprint(id);
    let plain = only_if(waits, prepare(view, footprint));
    return Prepared(plain, key_depth(subgroupShuffle(footprint_key(footprint), QUEUE - 1u)));
}

const CHANGES: u32 = 1u; // some texel can still change
const SEEKS: u32 = 2u;   // some nearest depth may still change

fn wants(front: f32, lane: u32) -> u32 {
    return join_lanes(select(CHANGES, 0u, settled(front)) | select(0u, SEEKS, seeks(front)), lane);
}

fn goes_on(queue: Queue, end: u32, wanted: u32, needed: u32) -> bool {
    let is_left = (queue.base < end) | (queue.collected.count > 0u);
    return is_left & ((wanted & needed) == needed);
}

struct Crowd {
    queue: Queue,
    wanted: u32, // by some texel: CHANGES, SEEKS
}

// Visits casters, eight at a time, while some texel wants all that is `needed`.
fn visit_crowd(view: GpuView, first: Crowd, end: u32, block: Block, needed: u32) -> Crowd {
    let seeks = !SEEKS_APART || (needed & SEEKS) != 0u;
    var crowd = first;
    loop {
        if goes_on(crowd.queue, end, crowd.wanted, needed) {
            let queue = fill(view, crowd.queue, end, block);
            let eight = prepare_lane(view, queue.collected.footprints.x, block.lane < queue.collected.count);
            visit_plain(view, broadcast(eight.plain, 0u), seeks);
            visit_plain(view, broadcast(eight.plain, 1u), seeks);
            visit_plain(view, broadcast(eight.plain, 2u), seeks);
            visit_plain(view, broadcast(eight.plain, 3u), seeks);
            visit_plain(view, broadcast(eight.plain, 4u), seeks);
            visit_plain(view, broadcast(eight.plain, 5u), seeks);
            visit_plain(view, broadcast(eight.plain, 6u), seeks);
            visit_plain(view, broadcast(eight.plain, 7u), seeks);
            crowd = Crowd(Queue(without_eight(queue.collected), queue.base), wants(eight.front, block.lane));
        }
        if !goes_on(crowd.queue, end, crowd.wanted, needed) {
            break;
        }
    }
    return crowd;
}

fn walk_crowded(view: GpuView, first: u32, end: u32, block: Block) {
    let crowd = Crowd(Queue(Collected(vec3(0u), 0u), first), CHANGES | SEEKS);
    if !SEEKS_APART {
        _ = visit_crowd(view, crowd, end, block, CHANGES);
        return;
    }
    let rest = visit_crowd(view, crowd, end, block, CHANGES | SEEKS);
    // Now all texels have their nearest depth.
    _ = visit_crowd(view, rest, end, block, CHANGES);
}

fn walk_sparse(view: GpuView, first: u32, end: u32, block: Block) {
    var base = first;
    let low = block_low(block);
    let high = block_high(block);
    loop {
        let pair = base + block.lane;
        let id = pair_footprint(pair, max(end, 1u));
        let stretch = prepare_lane(view, id, true);
        let touched = pair < end && plain_touches(view, load_footprint(id), low, high);
        var mask = join_lanes(select(0u, 1u << block.lane, touched), block.lane);
        loop {
            if mask != 0u {
                visit_plain(view, broadcast(stretch.plain, firstTrailingBit(mask)), true);
                mask &= mask - 1u;
            }
            if mask == 0u {
                break;
            }
        }
        base = select(end, base + QUEUE, (wants(stretch.front, block.lane) & CHANGES) != 0u);
        if base >= end {
            break;
        }
    }
}

fn walk(view: GpuView, first: u32, end: u32) {
    let lane = u32(corner.x) & 7u;
    let texel = vec2<u32>(corner) - vec2(lane, 0u);
    let block = Block(lane, QUEUE, texel, texel + vec2(QUEUE - 1u, 0u));
    if DENSE {
        walk_crowded(view, first, end, block);
    } else {
        walk_sparse(view, first, end, block);
    }
}
