// Geometry and optics of one ray's hit. CPU reference: crates/gobo-reference/src/hit.rs,
// crates/gobo-reference/src/fresnel.rs, crates/gobo-reference/src/occlude.rs.

import package::bind::uniform::materials;
import package::features::HAS_FRESNEL;
import package::records::footprint::setup_texel;
import package::records::material::{
    MAX_GAIN, PROFILE_SOFT, SHAPE_DISC, SHAPE_QUAD, TRANSFER_CUTOUT, TRANSFER_DITHER, TRANSFER_FILTER,
    TRANSFER_GAIN, TRANSFER_OVER, TRANSFER_SMOKE, TRANSFER_STAIN,
};
import package::records::pack::from_octahedral;
import package::records::view::{GpuView, MIN_DISTANCE, is_beside};

struct Hit {
    light: vec3<f32>, // transmittance
    color: vec3<f32>,
    opacity: f32,
    depth: f32,       // light depth; -1 for a miss
    start: f32,       // light depths between which it takes light: its ramp in a curve
    end: f32,
    material: u32,
    absorbed: vec3<f32>, // 1 - light, with full precision where light is next to 1
}

const MISS: Hit = Hit(vec3(1.0), vec3(0.0), 0.0, -1.0, -1.0, -1.0, 0u, vec3(0.0));

// Weight of a hit in depths: its opacity, or the light that `stain` and `gain` change without any opacity.
fn presence_of(hit: Hit) -> f32 {
    let transfer = materials[hit.material].transfer;
    let changes = transfer == TRANSFER_STAIN || transfer == TRANSFER_GAIN;
    let changed = abs(hit.absorbed);
    return select(hit.opacity, max(hit.opacity, max(max(changed.r, changed.g), changed.b)), changes);
}

// A particle set up for texels: q = (frame * delta + offset) / (start + tilt . delta), where delta is the
// vector from the reference to the texel's centre [texels]. The reference is the particle's centre, where q
// is 0 and start 1; for a particle beside the view the map's centre.
struct Facing {
    reference: vec2<f32>,
    frame_x: vec2<f32>,
    frame_y: vec2<f32>,
    offset: vec2<f32>,
    tilt: vec2<f32>,
    start: f32,
    distance: f32, // of the plane along the axis at the reference, times start [m]
}

fn to_world(view: GpuView, v: vec3<f32>) -> vec3<f32> {
    return v * mat3x3(view.view_from_world[0].xyz, view.view_from_world[1].xyz, view.view_from_world[2].xyz);
}

// Components to the right, down and along the axis.
fn to_map(view: GpuView, axis: vec3<f32>) -> vec3<f32> {
    return (view.view_from_world * vec4(axis, 0.0)).xyz * vec3(1.0, -1.0, -1.0);
}

// `bounds` as in a footprint; `rotation` about the ray [radians].
fn facing(view: GpuView, bounds: vec4<f32>, rotation: f32) -> Facing {
    let beside = is_beside(bounds);
    let slope = (bounds.xy - view.size * 0.5) / view.scale;
    var ray = vec3(slope, 1.0);
    var k = 1.0 / bounds.z;
    var per_texel = 1.0;
    var tilt = vec2(0.0);
    var distance = view.near + bounds.w * (view.far - view.near);
    if beside {
        distance = max(length(bounds.xyw), MIN_DISTANCE);
        ray = bounds.xyw / distance;
        k = distance / -bounds.z;
        per_texel = 1.0 / view.scale;
        tilt = ray.xy * per_texel;
    } else if view.perspective > 0.0 {
        let len = length(ray);
        ray /= len;
        k = 1.0 / (bounds.z * len * view.scale);
        tilt = ray.xy / (len * view.scale);
    } else {
        ray = vec3(0.0, 0.0, 1.0);
    }
    let n = to_world(view, ray * vec3(1.0, -1.0, -1.0));
    let up = select(vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0), abs(n.y) > 0.99);
    let x = normalize(cross(up, n));
    let y = cross(n, x);
    let s = sin(rotation);
    let c = cos(rotation);
    let frame_x = to_map(view, x * c + y * s) * k;
    let frame_y = to_map(view, y * c - x * s) * k;
    return Facing(
        select(bounds.xy, view.size * 0.5, beside),
        frame_x.xy * per_texel,
        frame_y.xy * per_texel,
        select(vec2(0.0), vec2(frame_x.z, frame_y.z), beside),
        tilt,
        select(1.0, ray.z, beside),
        distance,
    );
}

// q.xy and light depth; depth -1 if the ray does not meet the plane in front of the light.
fn facing_hit(f: Facing, view: GpuView, texel: vec2<f32>) -> vec3<f32> {
    let delta = texel - f.reference;
    let denominator = f.start + dot(f.tilt, delta);
    let q = (vec2(dot(f.frame_x, delta), dot(f.frame_y, delta)) + f.offset) / denominator;
    let depth = (f.distance / denominator - view.near) / (view.far - view.near);
    return select(vec3(2.0, 2.0, -1.0), vec3(q, depth), denominator > 0.0);
}

// Share of a particle's alpha at q, 0 outside its shape.
fn coverage(shape: u32, profile: u32, q: vec2<f32>) -> f32 {
    let square = dot(q, q);
    if shape == SHAPE_QUAD {
        return select(0.0, 1.0, max(abs(q.x), abs(q.y)) <= 1.0);
    }
    let rest = 1.0 - square;
    let soft = shape == SHAPE_DISC && profile == PROFILE_SOFT;
    return select(0.0, select(1.0, rest * rest, soft), square <= 1.0);
}

// Opacity of a particle smaller than a texel, before thinning.
fn whole_opacity(thin: f32, a: f32) -> f32 {
    // Below the smallest f16, both are 0.
    return min(a / max(thin, 1e-12), 1.0);
}

// Transmittance of a hit of opacity a and colour c (divided by 16 for `gain`). Where a particle smaller than
// a texel has its opacity a thinned, 1 - thin (1 - T) of the whole T.
fn transmittance(transfer: u32, thin: f32, a: f32, c: vec3<f32>) -> vec3<f32> {
    let clear = 1.0 - thin;
    let passed = max(thin - a, 0.0);
    switch transfer {
        // For the picture only: shadows are dithered.
        case TRANSFER_FILTER, TRANSFER_DITHER: { return 1.0 - a * (1.0 - c); }
        case TRANSFER_STAIN: { return clear + c * passed; }
        case TRANSFER_SMOKE: { return clear + passed * (1.0 - whole_opacity(thin, a) * (1.0 - c)); }
        case TRANSFER_GAIN: { return clear + thin * c * MAX_GAIN; }
        case TRANSFER_OVER: { return vec3(1.0 - a); }
        default: { return vec3(1.0); }
    }
}

// 1 - `transmittance`, with full precision where that is next to 1.
fn absorption(transfer: u32, thin: f32, a: f32, c: vec3<f32>) -> vec3<f32> {
    let filtered = a * (1.0 - c);
    switch transfer {
        case TRANSFER_FILTER, TRANSFER_DITHER: { return filtered; }
        case TRANSFER_STAIN: { return thin * (1.0 - c) + c * min(a, thin); }
        case TRANSFER_SMOKE: { return a + filtered * (1.0 - whole_opacity(thin, a)); }
        case TRANSFER_GAIN: { return thin * (1.0 - c * MAX_GAIN); }
        case TRANSFER_OVER: { return vec3(a); }
        default: { return vec3(0.0); }
    }
}

// Light that faces and panes of glass transmit, by Fresnel's formulas for unpolarised light.

// Transmitted share at a cosine to the outside normal. `index`: refractive index; negative for a pane, whose
// inner reflections go on until all light has left (Born and Wolf 1999, sections 1.5.2 and 7.6.1, without
// interference).
fn passed_share(index: f32, cosine: f32) -> f32 {
    let outside = min(abs(cosine), 1.0);
    let square = index * index;
    let inside = sqrt(max(square - 1.0 + outside * outside, 0.0));
    let across = (outside - inside) / (outside + inside);
    let along = (square * outside - inside) / (square * outside + inside);
    let reflected = vec2(across * across, along * along);
    let passed = (1.0 - reflected) / select(vec2(1.0), 1.0 + reflected, index < 0.0);
    return 0.5 * (passed.x + passed.y);
}

// Share of the ray through `texel` of a map that a triangle transmits.
fn face_passes(view: GpuView, setup: u32, texel: vec2<f32>) -> f32 {
    if !HAS_FRESNEL {
        return 1.0;
    }
    let index = materials[setup_texel(setup, 4u).w].fresnel;
    if index == 0.0 {
        return 1.0;
    }
    let slope = (texel - view.size * 0.5) / view.scale * view.perspective;
    let ray = to_world(view, vec3(slope.x, -slope.y, -1.0));
    let normal = from_octahedral(setup_texel(setup, 6u).z);
    return passed_share(index, dot(normal, ray) / length(ray));
}

// Whether a hit of an `opaque` or `cutout` material is solid; the picture blends dithered ones.
fn is_solid(hit: Hit) -> bool {
    let material = materials[hit.material];
    let cut = material.transfer == TRANSFER_CUTOUT && hit.opacity < material.cutoff;
    return hit.depth >= 0.0 && !cut;
}
