// resolve, curve: curves, filter and nearest depth of the tiles that have several segments: their
// curves after each other. One workgroup per tile, four texels per invocation.
// CPU twin: src/cpu/curve/tile.rs. Host: src/stage/curve.rs. Needs common/curve_list.wgsl,
// overflow_curve.wgsl and what they need.
@group(0) @binding(4) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(5) var<storage, read> dispatches: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read> merged_tiles: array<u32>;
@group(0) @binding(7) var<storage, read> tiles: array<Tile>;
@group(0) @binding(8) var<storage, read> partials: array<vec4<u32>>;
@group(0) @binding(9) var filters: texture_storage_2d_array<rgba16float, write>;
@group(0) @binding(10) var nearests: texture_storage_2d_array<r32float, write>;
@group(0) @binding(11) var curves: texture_storage_2d_array<rgba32uint, write>;

fn ordered() -> bool {
    return false;
}

fn channel(bits: vec4<u32>) -> vec4<f32> {
    let share = vec4<f32>(bits & vec4(0xfffu)) / LEVELS;
    if HAS_GAIN {
        return select(exp2(share * OCTAVES + DARKEST_LOG), vec4(0.0), (bits & vec4(0xfffu)) == vec4(0u));
    }
    return share;
}

fn quotient(a: Light4, b: Light4) -> Light4 {
    let least = vec4(1e-9);
    return Light4(a.red / max(b.red, least), a.green / max(b.green, least), a.blue / max(b.blue, least));
}

@compute @workgroup_size(LANES)
fn resolve_curve(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let slot = workgroup.y * workgroups.x + workgroup.x;
    if slot >= dispatches[MERGED_DISPATCH].w {
        return;
    }
    let tile_id = merged_tiles[slot];
    let tile = tiles[tile_id];
    let view = views[tile.view];
    let place = lane_texel(lane);
    let at = view.origin + tile_texel(view, tile_id) + place;
    let count = (tile.end - tile.first + CURVE_SEGMENT - 1u) / CURVE_SEGMENT;
    let white = Light4(vec4(1.0), vec4(1.0), vec4(1.0));
    let row = TILE_SIZE * partial_size();
    clear_list();
    var passed = white; // of the curve, whose nodes are rounded
    var before = white;
    var whole = white;  // the filter
    var nearest = vec4(1.0);
    // Nodes of the segments, one after another, and what overflowed behind them.
    for (var i = 0u; i <= count * NODES; i += 1u) {
        let n = i % NODES;
        var start: vec4<u32>;
        var end: vec4<u32>;
        var own: Light4;
        var is: vec4<bool>;
        if i < count * NODES {
            let first = sum_index(tile.merged - 1u + i / NODES, place) * partial_size();
            if n == 0u {
                before = white;
                let a = bitcast<vec4<f32>>(partials[first]);
                let b = bitcast<vec4<f32>>(partials[first + row]);
                let c = bitcast<vec4<f32>>(partials[first + 2u * row]);
                let d = bitcast<vec4<f32>>(partials[first + 3u * row]);
                whole.red *= vec4(a.r, b.r, c.r, d.r);
                whole.green *= vec4(a.g, b.g, c.g, d.g);
                whole.blue *= vec4(a.b, b.b, c.b, d.b);
                nearest = min(nearest, vec4(a.a, b.a, c.a, d.a));
            }
            let a = partials[first + n / 2u + 1u];
            let b = partials[first + row + n / 2u + 1u];
            let c = partials[first + 2u * row + n / 2u + 1u];
            let d = partials[first + 3u * row + n / 2u + 1u];
            let odd = n % 2u == 1u;
            let firsts = select(vec4(a.x, b.x, c.x, d.x), vec4(a.z, b.z, c.z, d.z), odd);
            let seconds = select(vec4(a.y, b.y, c.y, d.y), vec4(a.w, b.w, c.w, d.w), odd);
            let root = vec4<f32>((firsts >> vec4(4u)) & vec4(0xfffu)) / LEVELS;
            start = firsts >> vec4(16u);
            end = vec4<u32>(min(round(vec4<f32>(start) + root * root * DEPTHS), vec4(DEPTHS)));
            let light = Light4(
                channel(((firsts & vec4(15u)) << vec4(8u)) | (seconds >> vec4(24u))),
                channel(seconds >> vec4(12u)),
                channel(seconds),
            );
            own = quotient(light, before);
            before = light;
            is = start > vec4(0u);
        }
        // Drivers skip no branch, but they leave loops.
        for (var is_rest = i == count * NODES; is_rest; is_rest = false) {
            let rest = overflowed(sum_index(tile_id, place));
            own = rest.light;
            is = is_light(own);
            start = max(fixed(select(nearest, rest.depth, rest.depth < vec4(1.0))), last_end());
            end = start;
            whole = scaled(whole, own);
            nearest = min(nearest, rest.depth);
        }
        let all = scaled(passed, own);
        passed.red = select(passed.red, all.red, is);
        passed.green = select(passed.green, all.green, is);
        passed.blue = select(passed.blue, all.blue, is);
        insert(start, end, own, passed, is);
    }
    for (var i = 0u; i < ROWS; i += 1u) {
        let texel = at + vec2(0u, i);
        let filtered = min(vec3(whole.red[i], whole.green[i], whole.blue[i]), vec3(65504.0));
        textureStore(filters, texel, view.layer, vec4(blackened(filtered), 1.0));
        textureStore(nearests, texel, view.layer, vec4(nearest[i]));
    }
    store_pair(view, at, 0u);
    store_pair(view, at, 1u);
    if NODES > 4u {
        store_pair(view, at, 2u);
        store_pair(view, at, 3u);
    }
    if NODES > 8u {
        store_pair(view, at, 4u);
        store_pair(view, at, 5u);
        store_pair(view, at, 6u);
        store_pair(view, at, 7u);
    }
}

fn store_pair(view: GpuView, at: vec2<u32>, pair: u32) {
    let nodes = packed_pair(pair);
    let layer = curve_layer(view.layer, pair);
    textureStore(curves, at, layer, packed_row(nodes, 0u));
    textureStore(curves, at + vec2(0u, 1u), layer, packed_row(nodes, 1u));
    textureStore(curves, at + vec2(0u, 2u), layer, packed_row(nodes, 2u));
    textureStore(curves, at + vec2(0u, 3u), layer, packed_row(nodes, 3u));
}
