// Insertion of a hit between a texel's nodes. CPU reference: src/reference/curve/mod.rs.

import package::curve::bodies::new_place;
import package::curve::light4::{
    Light4, decode_light, encode_lights, encode_means, plus, quotient, scaled, white4,
};
import package::curve::list::{adding, disordered, latest, node_lights, node_means, spans};
import package::features::{HAS_OVER, NODES};
import package::sums::sums::BLACK;

var<private> new_span: vec4<u32>;
var<private> new_lights: vec4<u32>;
var<private> new_means: vec4<u32>;
var<private> old_span: vec4<u32>; // of the node in front of the new one

fn seek(i: u32) {
    let in_front = spans[i] <= new_span;
    old_span = select(old_span, spans[i], in_front);
    new_lights = select(new_lights, node_lights[i], in_front);
    new_means = select(new_means, node_means[i], in_front);
    new_place += select(vec4(0u), vec4(1u), in_front);
}

// Moves nodes behind the new one back, and dims them. Without a hit the new node goes last.
fn insert_between(span: vec4<u32>, light: Light4, passed: Light4, last: vec4<bool>, counts: vec4<bool>) {
    new_span = select(vec4(0xffffffffu), span, counts);
    old_span = vec4(0u);
    new_place = vec4(0u);
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
    node_lights[0] = select(node_lights[0], new_lights, here);
    node_means[0] = select(node_means[0], new_means, here);
}

fn move_back(i: u32, light: Light4) {
    let front = i - 1u;
    let moves = spans[front] > new_span;
    let here = !moves & ((spans[i] > new_span) | vec4(i == NODES));
    let own = scaled(decode_light(node_lights[front], node_means[front]), light);
    spans[i] = select(select(spans[i], new_span, here), spans[front], moves);
    node_lights[i] = select(select(node_lights[i], new_lights, here), encode_lights(own), moves);
    node_means[i] = select(select(node_means[i], new_means, here), encode_means(own), moves);
}
