// Curves of soft discs by two walks, like wgsl/curve/ray.wgsl, for subgroups of eight lanes that collect
// discs as wgsl/llvmpipe/queue.wgsl does. A subgroup's texels end their nodes together, behind a batch of
// eight discs, once the mean of their places is past the node's share. Texels with few hits are walked once
// more, a node for each hit. llvmpipe takes both sides of branches, but it leaves loops.

import package::features::{NODES, PERSPECTIVE, unrolled};
import package::hit::disc::broadcast_disc;
import package::llvmpipe::curve_state::{
    changes, counts_on, few_rows, has_many, lost_light, lost_so_far, sample_changes, sample_lost,
    sample_lost_so_far, seeks, start_few, store_few, visit_few,
};
import package::llvmpipe::curve_texels::{
    add_scattered, corner, end_nodes, high, keep_found, light_all, node_count, open_node, sample, store_pairs,
    visit,
};
import package::llvmpipe::queue::{
    Collected, Prepared, QUEUE, Queue, fill, fill_within, join_lanes, lanes_sum, prepare_lane, without_eight,
};
import package::records::view::GpuView;
import package::traversal::lane::{Block, block_high, block_low};

// A batch of eight discs: their light depths.
struct Batch {
    queue: Queue,
    first: f32,
    last: f32,
    front: f32, // no later disc is nearer
}

const CHANGES: u32 = 1u; // some texel can still change
const SEEKS: u32 = 2u;   // some nearest depth may still change, or some texel has few hits

fn wanted(front: f32, lane: u32) -> u32 {
    return join_lanes(
        select(0u, CHANGES, changes(front)) | select(0u, SEEKS, seeks(front) || counts_on(front)),
        lane,
    );
}

// Light depth of a disc's middle; approximate for discs beside the view.
fn light_depth(view: GpuView, depth: f32) -> f32 {
    if PERSPECTIVE {
        return saturate((depth - view.near) / (view.far - view.near));
    }
    return depth;
}

// The next eight discs, and the queue behind them.
struct Eight {
    prepared: Prepared,
    count: u32,
    rest: Queue,
}

fn next_eight(view: GpuView, old: Queue, end: u32, block: Block) -> Eight {
    return eight_of(view, fill(view, old, end, block), block);
}

fn eight_of(view: GpuView, queue: Queue, block: Block) -> Eight {
    let count = queue.collected.count;
    let prepared = prepare_lane(view, queue.collected.footprints.x, block.lane < count);
    return Eight(prepared, count, Queue(without_eight(queue.collected), queue.base));
}

fn last_of(view: GpuView, eight: Eight) -> f32 {
    let last = subgroupShuffle(eight.prepared.plain.depth, clamp(eight.count, 1u, QUEUE) - 1u);
    return select(0.0, light_depth(view, last), eight.count > 0u);
}

fn visit_eight(view: GpuView, old: Queue, end: u32, block: Block, counts: bool) -> Batch {
    let eight = next_eight(view, old, end, block);
    for (var k = 0u; k < unrolled(QUEUE); k += 1u) {
        visit(view, broadcast_disc(eight.prepared.plain, k), counts);
    }
    let depth = light_depth(view, eight.prepared.plain.depth);
    return Batch(
        eight.rest,
        select(2.0, subgroupShuffle(depth, 0u), eight.count > 0u),
        last_of(view, eight),
        eight.prepared.front,
    );
}

fn is_left(queue: Queue, end: u32) -> bool {
    return (queue.base < end) | (queue.collected.count > 0u);
}

struct Found {
    lost: f32,  // light lost by all texels
    first: f32, // depths of the first and the last disc that change a texel
    last: f32,
    is_sample: bool, // `lost` is measured on a quarter of the rows
}

// In the second walk.
fn all_lost(found: Found, lane: u32) -> f32 {
    return lanes_sum(select(lost_so_far(), sample_lost_so_far(), found.is_sample), lane);
}

// The first walk.
fn count_all(view: GpuView, first: u32, end: u32, block: Block) -> Found {
    var queue = Queue(Collected(vec3(0u), 0u), first);
    var found = Found(0.0, 2.0, 0.0, false);
    var wants = CHANGES | SEEKS;
    loop {
        if is_left(queue, end) & (wants >= SEEKS) {
            let changed = (wants & CHANGES) != 0u;
            let batch = visit_eight(view, queue, end, block, true);
            queue = batch.queue;
            found.first = min(found.first, batch.first);
            found.last = select(found.last, max(found.last, batch.last), changed);
            wants = wanted(batch.front, block.lane);
        }
        if !(is_left(queue, end) & (wants >= SEEKS)) {
            break;
        }
    }
    // The rest of the light is measured on a quarter of the rows: the second walk computes all of it.
    loop {
        if is_left(queue, end) & ((wants & CHANGES) != 0u) {
            let eight = next_eight(view, queue, end, block);
            for (var k = 0u; k < unrolled(QUEUE); k += 1u) {
                sample(view, broadcast_disc(eight.prepared.plain, k));
            }
            queue = eight.rest;
            found.is_sample = true;
            found.last = max(found.last, last_of(view, eight));
            wants = join_lanes(select(0u, CHANGES, sample_changes()), block.lane);
        }
        if !(is_left(queue, end) & ((wants & CHANGES) != 0u)) {
            break;
        }
    }
    return found;
}

// The second walk: all nodes of all texels.
fn take_all(view: GpuView, first: u32, end: u32, block: Block, found: Found) {
    let by_light = 0.5 / max(found.lost, 1e-9);
    let by_depth = 0.5 / max(found.last - found.first, 1e-9);
    var queue = Queue(Collected(vec3(0u), 0u), first);
    var goes_on = is_left(queue, end);
    open_node(found.first);
    let count = node_count();
    var k = 0u;
    loop {
        var half = 0u;
        loop {
            k += 1u;
            let cut = f32(k) / f32(count);
            var is_full = false;
            loop {
                if goes_on {
                    let batch = visit_eight(view, queue, end, block, false);
                    queue = batch.queue;
                    high = max(high, batch.last);
                    let place = by_light * all_lost(found, block.lane) + by_depth * (high - found.first);
                    is_full = (place > cut) & (k < count);
                    let changes = join_lanes(select(0u, 1u, changes(batch.front)), block.lane);
                    goes_on = is_left(queue, end) & (changes != 0u);
                }
                if is_full | !goes_on {
                    break;
                }
            }
            end_nodes();
            open_node(high);
            half += 1u;
            if half == 2u {
                break;
            }
        }
        store_pairs(view, k / 2u - 1u, k == NODES);
        if (k == NODES) | !goes_on {
            break;
        }
    }
    // Free nodes.
    end_nodes();
    end_nodes();
    loop {
        if k < NODES {
            k += 2u;
            store_pairs(view, k / 2u - 1u, k == NODES);
        }
        if k == NODES {
            break;
        }
    }
}

const TURN: u32 = 4u; // half of a queue: each loop runs once, with a row or without

// Texels of few hits, row by row, by the discs that touch the row.
fn walk_few(view: GpuView, first: u32, end: u32, block: Block, all_rows: u32) {
    var rows = all_rows;
    loop {
        var queue = Queue(Collected(vec3(0u), 0u), select(end, first, rows != 0u));
        let row = firstTrailingBit(rows | 128u);
        start_few(row);
        let low = block_low(block) + vec2(0.0, f32(row));
        let high = vec2(block_high(block).x, low.y);
        loop {
            if is_left(queue, end) {
                let within = fill_within(view, queue, end, block.lane, low, high);
                let eight = eight_of(view, within, block);
                var turn = 0u;
                loop {
                    for (var k = 0u; k < unrolled(TURN); k += 1u) {
                        visit_few(view, broadcast_disc(eight.prepared.plain, turn + k));
                    }
                    turn += TURN;
                    if turn >= min(eight.count, QUEUE) {
                        break;
                    }
                }
                queue = eight.rest;
            }
            if !is_left(queue, end) {
                break;
            }
        }
        store_few(view);
        rows &= rows - min(rows, 1u);
        if rows == 0u {
            break;
        }
    }
}

fn walk(view: GpuView, first: u32, end: u32) {
    let lane = u32(corner.x) & 7u;
    let texel = vec2<u32>(corner) - vec2(lane, 0u);
    let block = Block(lane, QUEUE, texel, texel + vec2(QUEUE - 1u, 0u));
    var found = count_all(view, first, end, block);
    add_scattered(found.last);
    found.lost = lanes_sum(select(lost_light(), sample_lost(), found.is_sample), lane);
    let rows = join_lanes(few_rows() | select(0u, 256u, has_many()), lane);
    if !found.is_sample {
        keep_found();
    }
    light_all();
    take_all(view, first, select(first, end, rows >= 256u), block, found);
    if found.is_sample {
        keep_found();
    }
    walk_few(view, first, end, block, rows & 255u);
}
