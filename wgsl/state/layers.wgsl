// Four pixels while what is not solid is laid over them, front to back. CPU twin:
// src/reference/shade/layers.rs.
//
// Casters come in order of their nearest corner. A pane reaches from there far back, so it waits
// until what comes next is behind it; the order is exact while at most two panes wait. What the two
// nearest panes scatter and mirror is added after the walk: a software driver runs both sides of
// every branch, and particles would pay for panes. Those behind only filter.

import package::bind::sampled::{lit, surfaces};
import package::bind::uniform::{materials, picture_params};
import package::features::{HAS_PARTICLES, HAS_TRIANGLES, HAS_VOLUMES, ROLLED};
import package::hit::caster_hit::{Hit, caster_hit, triangle_hit};
import package::records::material::{
    GpuMaterial, MAX_GAIN, TRANSFER_GAIN, TRANSFER_NONE, TRANSFER_OVER,
};
import package::records::record::{TRIANGLE_BIT, record_texel};
import package::records::setup::setup_texel;
import package::records::view::GpuView;
import package::shade::air::air_at;
import package::shade::cost::{asked, count_pair};
import package::shade::fog::{cross_face, fog_to, start_fog, whole};
import package::shade::receiver::set_receiver;
import package::shade::shading::{Gloss, mirrored, sky};
import package::shade::sheet::light_sheet;
import package::shade::surface::{eye, face_normal, triangle_surface, world_point};

const FAINT: f32 = 0.0009765625; // what is behind less than this is not seen: 1/1024
const NOWHERE: f32 = 4.0;        // depth of a place where no pane waits

struct Layer {
    depth: f32,          // NOWHERE for none
    own: vec3<f32>,      // light that the pane emits
    passed: vec3<f32>,
    look: vec2<u32>,     // caster and setup; caster 0 for what only emits
}

const NO_LAYER: Layer = Layer(NOWHERE, vec3(0.0), vec3(1.0), vec2(0u));

var<private> corner: vec2<f32>; // first of the four pixels
var<private> opaque_depth: vec4<f32>;
var<private> passed: array<vec3<f32>, 4>; // of what is behind
var<private> color: array<vec3<f32>, 4>;
var<private> near: array<Layer, 4>; // panes that wait
var<private> far: array<Layer, 4>;
var<private> first: array<Layer, 4>; // panes to be lit; `passed` is of what is before them
var<private> second: array<Layer, 4>;
var<private> asked_of: vec4<u32>; // lights, for the cost of each pixel

fn start(view: GpuView, pixel: vec2<u32>) {
    corner = vec2<f32>(pixel);
    for (var i = 0u; i < 4u; i += 1u) {
        opaque_depth[i] = textureLoad(surfaces, pixel + vec2(0u, i), 0).a;
        passed[i] = vec3(1.0);
        color[i] = vec3(0.0);
        if HAS_VOLUMES {
            start_fog(view, corner + vec2(0.5, f32(i) + 0.5), i);
        }
        if HAS_TRIANGLES {
            near[i] = NO_LAYER;
            far[i] = NO_LAYER;
            first[i] = NO_LAYER;
            second[i] = NO_LAYER;
        }
    }
}

fn lay(i: u32, own: vec3<f32>, pass_on: vec3<f32>) {
    color[i] += passed[i] * own;
    passed[i] *= pass_on;
}

// What volumes let pass up to light depth `depth`.
fn lay_fog(i: u32, depth: f32) {
    if HAS_VOLUMES {
        passed[i] *= fog_to(i, depth);
    }
}

// As `lay`, seen through the air before light depth `depth`; what is behind is laid over what the
// air scatters before it as well, so that here only what the layer takes of that counts.
fn lay_at(i: u32, depth: f32, own: vec3<f32>, pass_on: vec3<f32>) {
    if picture_params.air_slices > 0u {
        let before = air_at(corner + vec2(0.5, f32(i) + 0.5), depth);
        lay(i, own * before.a + before.rgb * (1.0 - pass_on), pass_on);
    } else {
        lay(i, own, pass_on);
    }
}

fn lay_pane(i: u32, layer: Layer) {
    lay_fog(i, layer.depth);
    let shown = Layer(layer.depth, vec3(0.0), passed[i], layer.look);
    if layer.look.x != 0u && first[i].look.x == 0u {
        first[i] = shown;
    } else if layer.look.x != 0u && second[i].look.x == 0u {
        second[i] = shown;
    }
    lay_at(i, layer.depth, layer.own, layer.passed);
    if HAS_VOLUMES && layer.look.x != 0u {
        passed[i] *= cross_face(i, layer.look.y, layer.depth);
    }
}

// The panes before light depth `depth`, nearest first.
fn lay_waiting(i: u32, depth: f32) {
    while near[i].depth < depth {
        lay_pane(i, near[i]);
        near[i] = far[i];
        far[i].depth = NOWHERE;
    }
}

fn wait(i: u32, layer: Layer) {
    if layer.depth >= NOWHERE {
        return;
    }
    // Of three, the nearest waits no longer.
    if far[i].depth < NOWHERE {
        lay_waiting(i, min(layer.depth, far[i].depth));
    }
    if layer.depth > near[i].depth {
        far[i] = layer;
    } else if far[i].depth < NOWHERE {
        lay_pane(i, layer);
    } else {
        far[i] = near[i];
        near[i] = layer;
    }
}

// What a pane scatters and mirrors.
fn pane_light(view: GpuView, pixel: vec2<f32>, layer: Layer) -> vec3<f32> {
    let hit = triangle_hit(layer.look.y, pixel);
    let material = materials[hit.material];
    let albedo = seen_color(hit, material.transfer);
    let id = layer.look.x & ~TRIANGLE_BIT;
    let surface =
        triangle_surface(view, pixel, layer.depth, id, layer.look.y, albedo, material.roughness);
    set_receiver(material, setup_texel(layer.look.y, 6u).w);
    let gloss = sheet_gloss(hit, material);
    let lit = light_sheet(surface, gloss);
    let mirror = mirrored_share(gloss, layer.look.y, surface.to_eye);
    return scattered_share(hit, material) * (1.0 - mirror) * albedo * lit.diffuse + lit.shine
        + mirror * sky(reflect(-surface.to_eye, surface.normal));
}

// Premultiplied: glass keeps its highlights where it is clear.
fn sheet_gloss(hit: Hit, material: GpuMaterial) -> Gloss {
    return Gloss(material.reflectivity, max(hit.opacity, material.transmission));
}

// A sheet that is not clear scatters half of what it covers and filters the rest.
fn scattered_share(hit: Hit, material: GpuMaterial) -> f32 {
    let covers = material.transfer == TRANSFER_OVER;
    return hit.opacity * select(0.5 * (1.0 - material.transmission), 1.0, covers);
}

fn mirrored_share(gloss: Gloss, setup: u32, to_eye: vec3<f32>) -> f32 {
    return mirrored(gloss, abs(dot(face_normal(setup), to_eye)));
}

fn finish(view: GpuView) {
    if HAS_TRIANGLES {
        for (var i = 0u; i < 4u; i += 1u) {
            lay_waiting(i, 2.0);
            if whole {
                lay_fog(i, opaque_depth[i]);
            }
        }
        for (var k = 0u; k < 8u; k += 1u) {
            let i = k % 4u;
            var layer = first[i];
            if k >= 4u {
                layer = second[i];
            }
            if layer.look.x != 0u {
                let pixel = corner + vec2(0.5, f32(i) + 0.5);
                asked = 0u;
                var shown = layer.passed * pane_light(view, pixel, layer);
                if picture_params.air_slices > 0u {
                    shown *= air_at(pixel, layer.depth).a;
                }
                color[i] += shown;
                asked_of[i] += asked;
            }
        }
    }
}

fn seen_color(hit: Hit, transfer: u32) -> vec3<f32> {
    return select(hit.color, min(hit.color * MAX_GAIN, vec3(1.0)), transfer == TRANSFER_GAIN);
}

fn visit_pane(view: GpuView, look: vec4<u32>, i: u32) {
    let pixel = corner + vec2(0.5, f32(i) + 0.5);
    let hit = triangle_hit(look.x, pixel);
    let counts = hit.depth >= 0.0 && hit.depth <= 1.0 && hit.depth < opaque_depth[i];
    let material = materials[hit.material];
    let to_eye = normalize(eye() - world_point(view, pixel, hit.depth));
    let covers = material.transfer == TRANSFER_OVER;
    let scattered = select(scattered_share(hit, material), 0.0, covers);
    let behind = (1.0 - mirrored_share(sheet_gloss(hit, material), look.x, to_eye)) * (1.0 - scattered);
    // What gathers light gathers that of lamps, not what the eye sees behind it.
    let light = select(hit.light, vec3(1.0), material.transfer == TRANSFER_GAIN);
    var layer = Layer(hit.depth, hit.opacity * material.emission, light * behind, vec2(look.w, look.x));
    if material.transfer == TRANSFER_NONE {
        layer.own += hit.opacity * hit.color;
        layer.passed = vec3(1.0);
        layer.look.x = 0u;
    }
    if counts {
        wait(i, layer);
    }
}

fn visit_particle(view: GpuView, place: vec4<u32>, look: vec4<u32>, arriving: vec3<f32>, i: u32) {
    let hit = caster_hit(view, place, look, corner + vec2(0.5, f32(i) + 0.5), opaque_depth[i]);
    if hit.depth >= 0.0 && hit.depth < opaque_depth[i] {
        if HAS_TRIANGLES {
            lay_waiting(i, hit.depth);
            lay_fog(i, hit.depth);
        }
        let material = materials[hit.material];
        let adds = material.transfer == TRANSFER_NONE;
        let light = select(arriving, vec3(1.0), adds);
        let own = seen_color(hit, material.transfer) * light + material.emission;
        lay_at(i, hit.depth, hit.opacity * own, vec3(select(1.0 - hit.opacity, 1.0, adds)));
    }
}

fn visit(view: GpuView, footprint: u32, place: vec4<u32>, look: vec4<u32>) {
    count_pair();
    if HAS_TRIANGLES && (look.w & TRIANGLE_BIT) != 0u {
        // A loop: what is written out four times takes a software driver seconds to compile.
        for (var i = 0u; i < 4u; i += 1u) {
            visit_pane(view, look, i);
        }
    } else if HAS_PARTICLES {
        let arriving = textureLoad(lit, record_texel(footprint), 0).rgb;
        for (var i = 0u; ROLLED && i < 4u; i += 1u) {
            visit_particle(view, place, look, arriving, i);
        }
        if !ROLLED {
            visit_particle(view, place, look, arriving, 0u);
            visit_particle(view, place, look, arriving, 1u);
            visit_particle(view, place, look, arriving, 2u);
            visit_particle(view, place, look, arriving, 3u);
        }
    }
}

fn is_open(i: u32, front: f32) -> bool {
    return any(passed[i] >= vec3(FAINT)) && opaque_depth[i] > front;
}

fn settled(front: f32) -> bool {
    return !(is_open(0u, front) || is_open(1u, front) || is_open(2u, front) || is_open(3u, front));
}
