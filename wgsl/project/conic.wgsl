// A Gaussian's projected covariance: its whitening and ellipse in the map. CPU reference:
// crates/gobo-reference/src/gaussian.rs, crates/gobo-reference/src/outline.rs.

import package::project::extent::tangents;
import package::records::caster::GaussianSetup;
import package::records::outline::Outline;
import package::records::tile::SLACK;
import package::records::view::{GpuView, TILE_SIZE};

const MIN_SQUARE: f32 = 0.5;  // squared deviation below which the conic is enlarged [texels^2]
const MEASURED_AT: f32 = 4.0; // squared distance at which a deviation is measured in the map [deviations]
const NEAREST_EYE: f32 = 1e-12; // least squared distance of the eye from a centre beside the view [sigma^2]
const ALONG: f32 = 1e-10;     // squared sine below which a step to the right is along the way to the centre
const FLAT: f32 = 1e-12;      // ratio of squared deviations below which the smaller has no direction in space
const THINNEST: f32 = 1e-5;   // least deviation of a Gaussian beside the view, a share of its longest
const ENDLESS: f32 = 1e6;     // bounds of a Gaussian that reaches the eye's plane [texels]
const MIN_NORMAL: f32 = 1.17549435e-38;

// A Gaussian in a view's map.
struct Placed {
    center: vec2<f32>, // of its footprint, and depth
    depth: f32,
    setup: GaussianSetup,
    thin: f32, // share of its enlarged area
    lo: vec2<f32>,
    hi: vec2<f32>,
    ellipse: Ellipse,
}

// Squared distance from the centre at which a Gaussian of opacity, or medium of optical depth, `opacity`
// ends. Rust: src/model/gaussian.rs.
fn reach_squared(opacity: f32) -> f32 {
    return min(2.0 * log(max(opacity * 8192.0, 256.0)), 64.0);
}

// A Gaussian whose centre projects into the map. `axes`: its deviations to the right, down and along the axis
// [m]; `squared`: squared distance at which it ends.
fn gaussian_within(view: GpuView, center: vec3<f32>, axes: mat3x3<f32>, squared: f32) -> Placed {
    let rows = transpose(axes);
    let range = view.far - view.near;
    var slope = center.xy;
    var p = rows[0] * view.scale;
    var q = rows[1] * view.scale;
    var along = rows[2] / range;
    if view.perspective > 0.0 {
        slope = center.xy / center.z;
        let per_metre = view.scale / center.z;
        p = (rows[0] - rows[2] * slope.x) * per_metre;
        q = (rows[1] - rows[2] * slope.y) * per_metre;
        along = rows[2] / center.z;
    }
    var placed: Placed;
    placed.center = slope * view.scale + view.size * 0.5;
    placed.depth = (center.z - view.near) / range;

    let xx = dot(p, p);
    let xy = dot(p, q);
    let yy = dot(q, q);
    let apart = 0.5 * (xx - yy);
    let radius = sqrt(apart * apart + xy * xy);
    let large = max(0.5 * (xx + yy) + radius, MIN_NORMAL);
    let area = cross(p, q);
    let small = dot(area, area) / large;
    let axis = select(vec2(xy, radius - apart), vec2(apart + radius, xy), apart >= 0.0);
    let length_of_axis = length(axis);
    var major = vec2(1.0, 0.0); // unit, of the larger deviation
    if length_of_axis > 0.0 {
        major = axis / length_of_axis;
    }
    let minor = vec2(-major.y, major.x);
    let w1 = (p * major.x + q * major.y) / sqrt(large);
    var across = q * major.x - p * major.y;
    across -= w1 * dot(w1, across);
    var tilt = vec2(-dot(along, w1), 0.0); // change of the distance along the axis over each deviation
    var spread = max(dot(along, along) - tilt.x * tilt.x, 0.0);
    if small > FLAT * large {
        let w2 = across / length(across);
        let ray = dot(along, cross(w1, w2));
        tilt.y = -dot(along, w2);
        spread = ray * ray;
    }
    // Near the eye, a Gaussian may span many texels though its middle is thinner than one: along the
    // principal axes, the map shows its deviations times the root of rest / wide^2.
    let measured = MEASURED_AT * view.perspective;
    let wide = max(1.0 - measured * (spread + tilt * tilt), vec2(0.0));
    let rest_of = max(measured * tilt * tilt + wide, vec2(MIN_NORMAL));
    let least = max(MIN_SQUARE * wide * wide / rest_of, vec2(FLAT * large));
    let squares = max(vec2(large, small), least);
    placed.thin = sqrt(large / squares.x * (small / squares.y));

    // The whitening in triangular form.
    let row1 = major / sqrt(squares.x);
    let row2 = minor / sqrt(squares.y);
    let a = length(vec2(row1.x, row2.x));
    let turn = vec2(row1.x, row2.x) / a;
    placed.setup.whitening =
        vec3(a, turn.x * row1.y + turn.y * row2.y, turn.x * row2.y - turn.y * row1.y);
    placed.setup.spread = spread;
    placed.setup.tilt = vec2(turn.x * tilt.x + turn.y * tilt.y, turn.x * tilt.y - turn.y * tilt.x);

    // The exact box of the texels with q^2 <= squared, by the dual conic.
    let square = major * major * squares.x + minor * minor * squares.y;
    var open = 1.0;
    var lean = vec2(0.0);
    if view.perspective > 0.0 {
        open = 1.0 - squared * spread - squared * dot(tilt, tilt);
        let over = tilt * sqrt(squares);
        lean = (major * over.x + minor * over.y) * squared;
    }
    let reach = sqrt(lean * lean + square * (squared * open));
    placed.lo = placed.center + (lean - reach) / open;
    placed.hi = placed.center + (lean + reach) / open;
    // Shape matrix [W^2, L H; L H, H^2] of the ellipse's half width, lean and half height.
    let half = reach / open;
    let aslant = lean.x * lean.y + squared * open * major.x * major.y * (squares.x - squares.y);
    let rest = 1.0 - squared * spread * view.perspective;
    let width = squared * sqrt(squares.x * squares.y * rest / (open * open * open)) / half.y;
    placed.ellipse = Ellipse(placed.center + lean / open, half, aslant / (open * open * half.y), width, open);
    // Written so that a NaN is endless.
    if !(open > 0.0) {
        placed.lo = vec2(-ENDLESS);
        placed.hi = vec2(ENDLESS);
    }
    return placed;
}

fn normalize_or(v: vec3<f32>, other: vec3<f32>) -> vec3<f32> {
    let size = length(v);
    return select(other, v / size, size > 0.0);
}

// A Gaussian whose centre does not project into the map. Relative to the map's centre, u has an offset, the
// footprint's centre, and e = depth + tilt . delta [1/m].
fn gaussian_beside(
    view: GpuView,
    center: vec3<f32>,
    axes: mat3x3<f32>,
    sigma: vec3<f32>,
    squared: f32,
) -> Placed {
    let longest = max(max(sigma.x, sigma.y), sigma.z);
    let thick = max(sigma, vec3(longest * THINNEST));
    let units = mat3x3(
        normalize_or(axes[0], vec3(0.0)),
        normalize_or(axes[1], vec3(0.0)),
        normalize_or(axes[2], vec3(0.0)),
    );
    // Rays in the Gaussian's own space, for a step along the axis and for a texel to the right and down.
    let rows = transpose(units);
    let eye = (center * units) / thick;
    let right = rows[0] / thick / view.scale;
    let down = rows[1] / thick / view.scale;
    let along = rows[2] / thick;
    let away = max(dot(eye, eye), NEAREST_EYE);
    let toward = normalize_or(eye, vec3(1.0, 0.0, 0.0));
    // Two directions across the one from the eye to the centre; the second is also across a step to the
    // right.
    let step = right - toward * dot(toward, right);
    let aside = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), abs(toward.x) > 0.5);
    var first = normalize(cross(toward, aside));
    if dot(step, step) > ALONG * dot(right, right) {
        // Removes the direction to the centre that rounding left.
        first = normalize(step);
        first = normalize(first - toward * dot(toward, first));
    }
    let second = cross(toward, first);
    let ahead = toward / sqrt(away);
    var placed: Placed;
    placed.center = vec2(dot(first, along), dot(second, along));
    placed.depth = dot(ahead, along);
    placed.setup.whitening = vec3(dot(first, right), dot(first, down), dot(second, down));
    placed.setup.spread = 1.0 / away;
    placed.setup.tilt = vec2(dot(ahead, right), dot(ahead, down));
    placed.thin = 1.0;
    let sphere = longest * sqrt(squared);
    let x = tangents(center.x, center.z, sphere);
    let y = tangents(center.y, center.z, sphere);
    placed.lo = vec2(x.x, y.x) * view.scale + view.size * 0.5;
    placed.hi = vec2(x.y, y.y) * view.scale + view.size * 0.5;
    return placed;
}

// An ellipse's outline in a view's tiles.

const OUTLINE_GROWTH: f32 = 1.0002;  // for the rounding of the ellipse
const WIDEST_OUTLINE: f32 = 32000.0; // half width [units]
const FINEST_UNIT: i32 = -8;         // edge of a unit, its logarithm to base 2 [texels]
const COARSEST_UNIT: i32 = 4;
const LEAST_OPEN: f32 = 1e-3;        // below, the ellipse is known too roughly

// Texels with (x, y) - middle = (lean v -+ width sqrt(1 - v^2), half.y v).
struct Ellipse {
    middle: vec2<f32>, // [texels]
    half: vec2<f32>,
    lean: f32,
    width: f32,
    open: f32, // 1 for a Gaussian far from the eye's plane, less near it
}

// Logarithm to base 2 of the edge of the least unit in which half the width is within WIDEST_OUTLINE
// [texels].
fn unit_log(ellipse: Ellipse) -> i32 {
    let edge = bitcast<u32>(ellipse.half.x * (OUTLINE_GROWTH / WIDEST_OUTLINE));
    return max(i32(edge >> 23u) - 126, FINEST_UNIT);
}

// Whether the ellipse has an outline; else it counts as touching all tiles of its rectangle.
fn has_outline(ellipse: Ellipse) -> bool {
    return ellipse.open >= LEAST_OPEN && unit_log(ellipse) <= COARSEST_UNIT;
}

// `row`: the first row of tiles.
fn outline_of(ellipse: Ellipse, row: u32) -> Outline {
    let log = unit_log(ellipse);
    let per_texel = bitcast<f32>(u32(127 - log) << 23u);
    let high = ellipse.half.y * OUTLINE_GROWTH;
    let top = f32(row * TILE_SIZE) + 0.5 - SLACK;
    let first = i32(floor((top - ellipse.middle.y) / high * 16777216.0)) - 256;
    let step = u32(ceil(f32(TILE_SIZE) / high * 16777216.0));
    let lean = i32(round(ellipse.lean * OUTLINE_GROWTH * per_texel));
    let width = u32(ceil(ellipse.width * OUTLINE_GROWTH * per_texel));
    let middle = i32(round(ellipse.middle.x * per_texel));
    return Outline(
        first,
        step | (u32(COARSEST_UNIT - log) << 27u),
        (bitcast<u32>(lean) & 0xffffu) | (width << 16u),
        row | (bitcast<u32>(middle) << 8u),
    );
}
