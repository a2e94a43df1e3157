// The curves of four texels in a column while their hits come in: one node more than a curve has,
// each texel's in a component. CPU twin: src/cpu/curve/mod.rs, `Streaming`, which says what merges
// and why. Needs common/curve.wgsl, light4.wgsl, sums.wgsl; the kernel says in `ordered` whether hits come front
// to back.
//
// Indices are literals, so that the arrays become registers: software drivers read arrays with an
// unknown index one lane at a time.
const DARK: u32 = 64u; // 1/1024 of 65535

var<private> spans: array<vec4<u32>, 17>;  // start << 16 | end, in fixed point; 0 for none
var<private> lights: array<vec4<u32>, 17>; // behind: green << 16 | red
var<private> means: array<vec4<u32>, 17>;  // mean of the channels << 16 | blue
var<private> disordered: u32;              // hits whose place in a merged ramp is lost
var<private> latest: vec4<u32>;            // the largest start of a hit so far
var<private> adding: Light4;               // what the hit that goes in adds, of `over`

// The cheapest pair of neighbours so far.
var<private> best_cost: vec4<f32>;
var<private> best: vec4<u32>;
var<private> best_before: vec4<f32>;
var<private> best_first: vec4<u32>;  // spans
var<private> best_second: vec4<u32>;
var<private> best_means: array<vec4<f32>, 2>;
var<private> before: vec4<f32>;

fn encode(v: vec4<f32>) -> vec4<u32> {
    if HAS_GAIN {
        return vec4(
            pack2x16float(vec2(v.x, 0.0)),
            pack2x16float(vec2(v.y, 0.0)),
            pack2x16float(vec2(v.z, 0.0)),
            pack2x16float(vec2(v.w, 0.0)),
        );
    }
    // Only what comes late may brighten what lies behind it past white.
    let most = select(3.4e38, 1.0, HAS_OVER || HAS_VOLUMES);
    return vec4<u32>(round(min(v, vec4(most)) * 65535.0));
}

// As `decode`, in steps.
fn level(bits: vec4<u32>) -> vec4<f32> {
    if HAS_GAIN {
        return vec4(
            unpack2x16float(bits.x).x,
            unpack2x16float(bits.y).x,
            unpack2x16float(bits.z).x,
            unpack2x16float(bits.w).x,
        );
    }
    return vec4<f32>(bits);
}

fn decode(bits: vec4<u32>) -> vec4<f32> {
    return level(bits) * select(1.0 / 65535.0, 1.0, HAS_GAIN);
}

fn mean_level(i: u32) -> vec4<f32> {
    return level(means[i] >> vec4(16u));
}

fn decode_light(light: vec4<u32>, mean: vec4<u32>) -> Light4 {
    return Light4(
        decode(light & vec4(0xffffu)),
        decode(light >> vec4(16u)),
        decode(mean & vec4(0xffffu)),
    );
}

fn encode_lights(v: Light4) -> vec4<u32> {
    return encode(v.red) | (encode(v.green) << vec4(16u));
}

fn encode_means(v: Light4) -> vec4<u32> {
    return encode(v.blue) | (encode((v.red + v.green + v.blue) * (1.0 / 3.0)) << vec4(16u));
}

fn fixed(depth: vec4<f32>) -> vec4<u32> {
    return clamp(vec4<u32>(round(depth * DEPTHS)), vec4(1u), vec4(65535u));
}

fn clear_node(i: u32) {
    let white = white4();
    spans[i] = vec4(0u);
    lights[i] = encode_lights(white);
    means[i] = encode_means(white);
}

fn quotient(a: Light4, b: Light4, least: f32) -> Light4 {
    return Light4(
        a.red / max(b.red, vec4(least)),
        a.green / max(b.green, vec4(least)),
        a.blue / max(b.blue, vec4(least)),
    );
}

fn clear_list() {
    disordered = 0u;
    latest = vec4(0u);
    adding = black4();
    clear_node(0u);
    clear_node(1u);
    clear_node(2u);
    clear_node(3u);
    if NODES > 4u {
        clear_node(4u);
        clear_node(5u);
        clear_node(6u);
        clear_node(7u);
    }
    if NODES > 8u {
        clear_node(8u);
        clear_node(9u);
        clear_node(10u);
        clear_node(11u);
        clear_node(12u);
        clear_node(13u);
        clear_node(14u);
        clear_node(15u);
    }
}

// The next hit fits without a merge.
fn young() -> vec4<bool> {
    return spans[0] == vec4(0u);
}

fn last_end() -> vec4<u32> {
    return spans[NODES - 1u] & vec4(0xffffu);
}

// Nothing that is seen passes the last node.
fn dark() -> vec4<bool> {
    let last = lights[NODES - 1u];
    let most = max(max(last & vec4(0xffffu), last >> vec4(16u)), means[NODES - 1u] & vec4(0xffffu));
    return select(most < vec4(DARK), vec4(false), vec4(HAS_GAIN || HAS_OVER));
}

// One hit, or several from `start` to `end`, in each texel where `is` holds. `light`: that passes
// them; `passed`: all so far.
fn insert(start: vec4<u32>, end: vec4<u32>, light: Light4, passed: Light4, is: vec4<bool>) {
    let counts = add_node(start, end, light, passed, is);
    best_cost = vec4(1e38);
    before = vec4(select(65535.0, 1.0, HAS_GAIN));
    weigh(0u);
    weigh(1u);
    weigh(2u);
    weigh(3u);
    if NODES > 4u {
        weigh(4u);
        weigh(5u);
        weigh(6u);
        weigh(7u);
    }
    if NODES > 8u {
        weigh(8u);
        weigh(9u);
        weigh(10u);
        weigh(11u);
        weigh(12u);
        weigh(13u);
        weigh(14u);
        weigh(15u);
    }
    let merged = merged_span();
    // Without a hit the new node is the one that goes.
    let at = select(vec4(NODES), best, counts);
    close_up(0u, at, merged);
    close_up(1u, at, merged);
    close_up(2u, at, merged);
    close_up(3u, at, merged);
    if NODES > 4u {
        close_up(4u, at, merged);
        close_up(5u, at, merged);
        close_up(6u, at, merged);
        close_up(7u, at, merged);
    }
    if NODES > 8u {
        close_up(8u, at, merged);
        close_up(9u, at, merged);
        close_up(10u, at, merged);
        close_up(11u, at, merged);
        close_up(12u, at, merged);
        close_up(13u, at, merged);
        close_up(14u, at, merged);
        close_up(15u, at, merged);
    }
}

// One node more, behind or between the others; returns where there is one.
fn add_node(start: vec4<u32>, end: vec4<u32>, light: Light4, passed: Light4, is: vec4<bool>) -> vec4<bool> {
    let span = (start << vec4(16u)) | end;
    let last = spans[NODES - 1u] <= span;
    // What is behind black does nothing, so that a walk may stop there.
    let counts = is & !(last & dark());
    if ordered() {
        spans[NODES] = span;
        lights[NODES] = encode_lights(passed);
        means[NODES] = encode_means(passed);
    } else {
        make_room(span, light, passed, last, counts);
    }
    return counts;
}

// As `insert`, for texels whose first node is none.
fn append(start: vec4<u32>, end: vec4<u32>, light: Light4, passed: Light4, is: vec4<bool>) {
    let counts = add_node(start, end, light, passed, is);
    drop_first(0u, counts);
    drop_first(1u, counts);
    drop_first(2u, counts);
    drop_first(3u, counts);
    if NODES > 4u {
        drop_first(4u, counts);
        drop_first(5u, counts);
        drop_first(6u, counts);
        drop_first(7u, counts);
    }
    if NODES > 8u {
        drop_first(8u, counts);
        drop_first(9u, counts);
        drop_first(10u, counts);
        drop_first(11u, counts);
        drop_first(12u, counts);
        drop_first(13u, counts);
        drop_first(14u, counts);
        drop_first(15u, counts);
    }
}

fn drop_first(i: u32, counts: vec4<bool>) {
    spans[i] = select(spans[i], spans[i + 1u], counts);
    lights[i] = select(lights[i], lights[i + 1u], counts);
    means[i] = select(means[i], means[i + 1u], counts);
}

// Weighs the merge of nodes i and i + 1: how far the light between falls from the straight line
// over both, as an area; nothing where one of them takes nothing.
fn weigh(i: u32) {
    let a = spans[i];
    let b = spans[i + 1u];
    let first_mean = mean_level(i);
    let second_mean = mean_level(i + 1u);
    let first = before - first_mean;
    let second = first_mean - second_mean;
    let start = vec4<f32>(a >> vec4(16u));
    let own = first * (vec4<f32>(b & vec4(0xffffu)) - start);
    let both = first + second;
    let cost = select(
        abs(own - both * (vec4<f32>(a & vec4(0xffffu)) - start))
            + abs(own - both * (vec4<f32>(b >> vec4(16u)) - start)),
        vec4(0.0),
        first * second == vec4(0.0),
    );
    let better = cost < best_cost;
    best_cost = select(best_cost, cost, better);
    best = select(best, vec4(i), better);
    best_before = select(best_before, before, better);
    best_first = select(best_first, a, better);
    best_second = select(best_second, b, better);
    best_means[0] = select(best_means[0], first_mean, better);
    best_means[1] = select(best_means[1], second_mean, better);
    before = first_mean;
}

// The ramp with the mean and the variance of both, inside what they span.
fn merged_span() -> vec4<u32> {
    let start_a = vec4<f32>(best_first >> vec4(16u));
    let end_a = vec4<f32>(best_first & vec4(0xffffu));
    let start_b = vec4<f32>(best_second >> vec4(16u));
    let end_b = vec4<f32>(best_second & vec4(0xffffu));
    let drop_a = abs(best_before - best_means[0]);
    let drop_b = abs(best_means[0] - best_means[1]);
    let nothing = drop_a + drop_b == vec4(0.0);
    let per_both = 1.0 / select(drop_a + drop_b, vec4(1.0), nothing);
    let first = drop_a * per_both;
    let second = drop_b * per_both;
    // Twice the middle, and twelve times the variance.
    let middle_a = start_a + end_a;
    let middle_b = start_b + end_b;
    let length_a = end_a - start_a;
    let length_b = end_b - start_b;
    let middle = first * middle_a + second * middle_b;
    let off_a = middle - middle_a;
    let off_b = middle - middle_b;
    let spread = first * (length_a * length_a + 3.0 * off_a * off_a)
        + second * (length_b * length_b + 3.0 * off_b * off_b);
    let half_middle = 0.5 * middle;
    let length = max(min(min(0.5 * sqrt(spread), half_middle - start_a), end_b - half_middle), vec4(0.0));
    let start = vec4<u32>(round(half_middle - length));
    let end = vec4<u32>(round(half_middle + length));
    return select((start << vec4(16u)) | end, best_second, nothing);
}

// Puts what follows a merge in its place.
fn close_up(i: u32, at: vec4<u32>, merged: vec4<u32>) {
    let stays = vec4(i) < at;
    spans[i] = select(select(spans[i + 1u], spans[i], stays), merged, vec4(i) == at);
    lights[i] = select(lights[i + 1u], lights[i], stays);
    means[i] = select(means[i + 1u], means[i], stays);
}

var<private> new_span: vec4<u32>;
var<private> new_lights: vec4<u32>;
var<private> new_means: vec4<u32>;
var<private> old_span: vec4<u32>; // of the node in front of the new one

fn seek(i: u32) {
    let in_front = spans[i] <= new_span;
    old_span = select(old_span, spans[i], in_front);
    new_lights = select(new_lights, lights[i], in_front);
    new_means = select(new_means, means[i], in_front);
}

// Nodes behind the new one move back, and get less light. Without a hit the new node goes last.
fn make_room(span: vec4<u32>, light: Light4, passed: Light4, last: vec4<bool>, counts: vec4<bool>) {
    new_span = select(vec4(0xffffffffu), span, counts);
    old_span = vec4(0u);
    let white = white4();
    new_lights = encode_lights(white);
    new_means = encode_means(white);
    seek(0u);
    seek(1u);
    seek(2u);
    seek(3u);
    if NODES > 4u {
        seek(4u);
        seek(5u);
        seek(6u);
        seek(7u);
    }
    if NODES > 8u {
        seek(8u);
        seek(9u);
        seek(10u);
        seek(11u);
        seek(12u);
        seek(13u);
        seek(14u);
        seek(15u);
    }
    let start = span >> vec4(16u);
    let late = counts & (start < latest);
    latest = select(latest, max(latest, start), counts);
    let inside = ((old_span >> vec4(16u)) < start) & ((old_span & vec4(0xffffu)) > start);
    let reached = decode_light(new_lights, new_means);
    var behind = scaled(reached, light);
    var own = light;
    var lost = late & inside;
    if HAS_OVER {
        behind = plus(behind, adding);
        own = plus(own, quotient(adding, reached, BLACK));
        lost = lost | (counts & !last & (adding.red + adding.green + adding.blue > vec4(0.0)));
    }
    disordered += dot(vec4<u32>(lost), vec4(1u));
    new_lights = select(encode_lights(behind), encode_lights(passed), last);
    new_means = select(encode_means(behind), encode_means(passed), last);
    if NODES > 8u {
        move_back(16u, own);
        move_back(15u, own);
        move_back(14u, own);
        move_back(13u, own);
        move_back(12u, own);
        move_back(11u, own);
        move_back(10u, own);
        move_back(9u, own);
    }
    if NODES > 4u {
        move_back(8u, own);
        move_back(7u, own);
        move_back(6u, own);
        move_back(5u, own);
    }
    move_back(4u, own);
    move_back(3u, own);
    move_back(2u, own);
    move_back(1u, own);
    let here = spans[0] > new_span;
    spans[0] = select(spans[0], new_span, here);
    lights[0] = select(lights[0], new_lights, here);
    means[0] = select(means[0], new_means, here);
}

fn move_back(i: u32, light: Light4) {
    let front = i - 1u;
    let moves = spans[front] > new_span;
    let here = !moves & ((spans[i] > new_span) | vec4(i == NODES));
    let own = scaled(decode_light(lights[front], means[front]), light);
    spans[i] = select(select(spans[i], new_span, here), spans[front], moves);
    lights[i] = select(select(lights[i], new_lights, here), encode_lights(own), moves);
    means[i] = select(select(means[i], new_means, here), encode_means(own), moves);
}

fn stored_channel(v: vec4<f32>) -> vec4<u32> {
    if HAS_GAIN {
        let octave = (log2(max(v, vec4(1e-9))) - DARKEST_LOG) / OCTAVES;
        return vec4<u32>(round(clamp(octave * LEVELS, vec4(0.0), vec4(LEVELS))));
    }
    return vec4<u32>(round(select(v, vec4(0.0), v < vec4(BLACK)) * LEVELS));
}

// Node i of the four texels as a map stores it: the first words, then the second.
fn packed_first(i: u32) -> vec4<u32> {
    let start = spans[i] >> vec4(16u);
    let end = max(spans[i] & vec4(0xffffu), start);
    let length = vec4<u32>(round(sqrt(vec4<f32>(end - start) / DEPTHS) * LEVELS));
    let red = stored_channel(decode(lights[i] & vec4(0xffffu)));
    return (start << vec4(16u)) | (length << vec4(4u)) | (red >> vec4(8u));
}

fn packed_second(i: u32) -> vec4<u32> {
    let red = stored_channel(decode(lights[i] & vec4(0xffffu)));
    let green = stored_channel(decode(lights[i] >> vec4(16u)));
    let blue = stored_channel(decode(means[i] & vec4(0xffffu)));
    return ((red & vec4(255u)) << vec4(24u)) | (green << vec4(12u)) | blue;
}

// Two nodes of the four texels.
struct Packed {
    firsts: array<vec4<u32>, 2>,
    seconds: array<vec4<u32>, 2>,
}

fn packed_pair(pair: u32) -> Packed {
    let i = 2u * pair;
    return Packed(
        array(packed_first(i), packed_first(i + 1u)),
        array(packed_second(i), packed_second(i + 1u)),
    );
}

fn packed_row(nodes: Packed, row: u32) -> vec4<u32> {
    return vec4(nodes.firsts[0][row], nodes.seconds[0][row], nodes.firsts[1][row], nodes.seconds[1][row]);
}
