// Texels of a look-up, and their weights. CPU reference: crates/gobo-reference/src/shading/taps.rs.

import package::features::HAS_FILTERS;
import package::records::light::GpuLight;
import package::records::view::GpuView;

const FILTER_BOX: u32 = 1u;    // of bilinear taps
const FILTER_SPLINE: u32 = 2u;
const FILTER_DISC: u32 = 3u;
const RADIUS_STEPS: f32 = 256.0; // fixed-point steps of a disc's radius, per texel
const SPLINE_REACH: f32 = 1.5;   // [texels]

// Rotation from each texel of a disc to the next (Vogel 1979): cosine and sine of the golden angle.
const GOLDEN_COSINE: f32 = -0.73736888;
const GOLDEN_SINE: f32 = 0.6754903;

// Direction to the first texel of a disc, unit.
var<private> pixel_rotation: vec2<f32> = vec2(1.0, 0.0);

// Rotates discs evenly by the pixel (Roberts 2018, the R2 sequence), the same in every frame. `pixel`: x and,
// from bit 16 on, y.
fn set_turn(pixel: u32) {
    let part = ((pixel & 0xffffu) * 12664745u + (pixel >> 16u) * 9560333u) & 0xffffffu;
    let angle = f32(part) * (6.2831853 / 16777216.0);
    pixel_rotation = vec2(cos(angle), sin(angle));
}

// Weights of a quadratic B-spline around t in -0.5..0.5.
fn spline(t: f32) -> vec3<f32> {
    return vec3(0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t));
}

// Nine texels of a view's map around a point, weighted by the spline.
struct Taps {
    position: vec2<f32>,  // of the point [texels]
    middle: vec2<f32>, // [texels]
    z: f32,            // light depth of the point
    reaches: bool,     // the point is inside the map
    x: vec3<f32>,
    y: vec3<f32>,
}

fn map_taps(view: GpuView, point: vec3<f32>) -> Taps {
    let p = (view.view_from_world * vec4(point, 1.0)).xyz;
    let distance = -p.z;
    let perspective = view.perspective > 0.0;
    let position = vec2(p.x, -p.y) * (view.scale / select(1.0, max(distance, 1e-6), perspective))
        + view.size * 0.5;
    let z = (distance - view.near) / (view.far - view.near);
    let inside = all(position >= vec2(0.0)) & all(position <= view.size);
    // A cone or a cube's face ends where its map does.
    let reaches = (z >= 0.0) & (inside | perspective);
    let middle = clamp(floor(position), vec2(-1e6), vec2(1e6));
    let t = clamp(position - middle - 0.5, vec2(-0.5), vec2(0.5));
    return Taps(position, middle, z, reaches, spline(t.x), spline(t.y));
}

fn tap_weight(taps: Taps, i: u32) -> f32 {
    return taps.x[i % 3u] * taps.y[i / 3u];
}

// The filter of a light.
struct Filter {
    kind: u32,   // FILTER_*
    count: u32,  // texels
    edge: f32,   // texels a side
    radius: f32, // of a disc; half the edge of a square [texels]
}

fn filter_of(light: GpuLight) -> Filter {
    if !HAS_FILTERS {
        return Filter(FILTER_SPLINE, 9u, 3.0, SPLINE_REACH);
    }
    let kind = light.taps & 0xffu;
    let taps = (light.taps >> 8u) & 0xffu;
    let box_edge = select(1u, taps + 1u, kind == FILTER_BOX);
    let edge = select(box_edge, 3u, kind == FILTER_SPLINE);
    let is_disc = kind == FILTER_DISC;
    let radius = select(f32(edge) * 0.5, f32(light.taps >> 16u) / RADIUS_STEPS, is_disc);
    return Filter(kind, select(edge * edge, taps, is_disc), f32(edge), radius);
}

// Reach of the filter's texels beyond the spline's [texels].
fn beyond_spline(light: GpuLight) -> f32 {
    return max(filter_of(light).radius - SPLINE_REACH, 0.0);
}

struct Tap {
    texel: vec2<f32>,
    weight: f32,
}

// `rotation`: direction to a disc's texel, unit.
fn filter_tap(kernel: Filter, taps: Taps, i: u32, rotation: vec2<f32>) -> Tap {
    let nine = Tap(taps.middle + vec2(f32(i % 3u), f32(i / 3u)) - 1.0, tap_weight(taps, i % 9u));
    if !HAS_FILTERS {
        return nine;
    }
    let position = clamp(taps.position, vec2(-1e6), vec2(1e6));
    let row = floor((f32(i) + 0.5) / kernel.edge);
    let cell = vec2(f32(i) - row * kernel.edge, row);
    // A box of whole texels over bilinear taps.
    let square = floor(position - 0.5 - kernel.radius) + 1.0 + cell;
    let over = clamp(kernel.radius - abs(square + 0.5 - position), vec2(0.0), vec2(1.0))
        / max(kernel.edge - 1.0, 1.0);
    let reach = kernel.radius * sqrt((f32(i) + 0.5) / f32(kernel.count));
    let even = select(taps.middle, floor(position + rotation * reach), kernel.kind == FILTER_DISC);
    let is_box = kernel.kind == FILTER_BOX;
    let is_spline = kernel.kind == FILTER_SPLINE;
    let texel = select(select(even, square, is_box), nine.texel, is_spline);
    let weight = select(select(1.0 / f32(kernel.count), over.x * over.y, is_box), nine.weight, is_spline);
    return Tap(texel, weight);
}

fn next_rotation(rotation: vec2<f32>) -> vec2<f32> {
    let golden = vec2(GOLDEN_COSINE, GOLDEN_SINE);
    return vec2(rotation.x * golden.x - rotation.y * golden.y, rotation.x * golden.y + rotation.y * golden.x);
}
