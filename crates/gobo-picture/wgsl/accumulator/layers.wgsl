// Accumulator: layers of translucent casters over a pixel, blended front to back. CPU reference:
// crates/gobo-reference/src/shade/layers.rs.
//
// Casters come in the order of their nearest corners, among bricks of their nearest points. A pane may reach
// far behind its nearest corner, so it waits until the next caster is behind it; the order is exact while at
// most two panes wait. The light that the two nearest panes scatter and mirror is evaluated after the walk;
// panes behind only filter.

import package::bind::picture_in::{band, lit, seen_pixels};
import package::bind::picture_out::layers;
import package::bind::uniform::materials;
import package::features::{HAS_AIR, HAS_BRICKS, HAS_PARTICLES, HAS_REFRACTION, HAS_TRIANGLES, HAS_VOLUMES};
import package::hit::caster_hit::{faced_hit, faced_of};
import package::hit::coplanar::{COPLANAR, is_coplanar, is_in_front};
import package::hit::hit::Hit;
import package::hit::triangle::{triangle_hit, triangle_weights};
import package::records::footprint::{Footprint, caster_of, setup_of};
import package::records::material::{SHAPE_BRICK, TRANSFER_GAIN, TRANSFER_NONE, shows_color};
import package::records::point_list::PANE_LIST;
import package::records::record::record_texel;
import package::records::tile::depth_of_key;
import package::records::view::GpuView;
import package::shade::air::air_at;
import package::shade::bend::{bend, start_bend};
import package::shade::camera::{camera, count_pair, cross_face, fog_to, start_fog};
import package::shade::details::emission_at;
import package::shade::layer::{
    LAYER_TEXELS, NOWHERE, NO_PANE, Pane, mirrored_share, packed_pane, scattered_share, seen_color,
};
import package::shade::near_surface::share_before_surface;
import package::shade::normals::{normals_at, pane_caster};
import package::shade::points::append_point;
import package::shade::surface::{eye, world_point};

const ROWS: u32 = 1u; // pixels that an invocation holds

const PANES: u32 = 2u; // of a pixel whose light is evaluated
const FAINT: f32 = 0.0009765625; // transmittance below which nothing behind is visible: 1/1024

// A pane that waits.
struct Waiting {
    depth: f32, // NOWHERE for none
    setup: u32,
}

const NONE_WAITS: Waiting = Waiting(NOWHERE, 0u);

var<private> corner: vec2<f32>; // transmittance for the light from behind
var<private> opaque_depth: f32;
var<private> passed: vec3<f32>; // transmittance for what is behind
var<private> color: vec3<f32>;
var<private> near: Waiting;
var<private> far: Waiting;
var<private> third: Waiting;    // only while a pane is sorted in
var<private> pixel_index: u32;  // in the band
var<private> pane_count: u32;   // panes whose light is evaluated: 2 at most

// `index`: of the pixel in the band.
fn start(view: GpuView, pixel: vec2<u32>, index: u32, opaque: f32) {
    corner = vec2<f32>(pixel);
    pixel_index = index;
    opaque_depth = opaque;
    passed = vec3(1.0);
    color = vec3(0.0);
    near = NONE_WAITS;
    far = NONE_WAITS;
    third = NONE_WAITS;
    pane_count = 0u;
    if HAS_VOLUMES {
        start_fog(view, corner + 0.5);
    }
    if HAS_REFRACTION {
        start_bend();
    }
}

// Absorbs in volumes up to light depth `depth`.
fn lay_fog(depth: f32) {
    if HAS_VOLUMES {
        passed *= fog_to(depth);
    }
}

// Blends a layer, attenuated by the air in front of light depth `depth`. The background will be blended with
// all the air, so only the part of the air that the layer covers is added here.
fn lay(view: GpuView, depth: f32, light: vec3<f32>, pass_on: vec3<f32>) {
    if HAS_AIR {
        let before = air_at(view, corner + 0.5, depth);
        color += passed * (light * before.left + before.light * (1.0 - pass_on));
    } else {
        color += passed * light;
    }
    passed *= pass_on;
}

// Stores the next pane whose light is evaluated.
fn store_pane(pane: Pane) {
    let texel = pixel_index * LAYER_TEXELS + 2u + pane_count;
    pane_count += 1u;
    textureStore(layers, record_texel(texel), packed_pane(pane));
    if pane.depth < NOWHERE && all(corner + 0.5 < camera().size) {
        append_point(PANE_LIST, pane_count * band.pixel_count + pixel_index);
    }
}

fn lay_pane(view: GpuView, pane: Waiting) {
    lay_fog(pane.depth);
    let hit = triangle_hit(pane.setup, corner + 0.5, 1.0);
    let material = materials[hit.material];
    let adds = material.transfer == TRANSFER_NONE;
    let to_eye = normalize(eye() - world_point(view, corner + 0.5, pane.depth));
    let weights = triangle_weights(pane.setup, corner + 0.5).xyz;
    let normals = normals_at(pane_caster(pane.setup), pane.setup, weights, to_eye);
    let mirror = mirrored_share(hit, material, normals.normal, to_eye);
    let behind = (1.0 - mirror) * (1.0 - scattered_share(hit, material, false));
    // `gain` amplifies light sources, not the background.
    let light = select(hit.light, vec3(1.0), material.transfer == TRANSFER_GAIN);
    if !adds && pane_count < PANES {
        store_pane(Pane(pane.depth, pane.setup, passed));
    }
    if HAS_REFRACTION && !adds {
        bend(view, corner + 0.5, pane.setup, pane.depth, opaque_depth, normals.normal, to_eye);
    }
    // The sign is 0: this way, the compiler reads the setup again instead of keeping it while an image is
    // sampled.
    let again = pane.setup + (bitcast<u32>(hit.opacity) >> 31u);
    let at = triangle_weights(again, corner + 0.5).xyz;
    let emission = emission_at(materials[hit.material], again, corner + 0.5, at);
    let shown = select(seen_color(hit, material.transfer), hit.color, adds);
    let sent = hit.opacity * (emission + select(vec3(0.0), shown, adds || shows_color(material)));
    lay(view, pane.depth, sent, select(light * behind, vec3(1.0), adds));
    if HAS_VOLUMES {
        passed *= select(cross_face(pane.setup, pane.depth), vec3(1.0), adds);
    }
}

// Blends the panes in front of light depth `depth`, nearest first; of three panes, the nearest waits no
// longer.
fn lay_waiting(view: GpuView, depth: f32) {
    while near.depth < depth || third.depth < NOWHERE {
        lay_pane(view, near);
        near = far;
        far = third;
        third = NONE_WAITS;
    }
}

// Whether a pane, of the caster `caster`, is in front of a waiting one.
fn is_before(pane: Waiting, caster: u32, waits: Waiting) -> bool {
    if is_coplanar(pane.depth, waits.depth) {
        return !is_in_front(waits.depth, pane_caster(waits.setup), pane.depth, caster);
    }
    return pane.depth < waits.depth;
}

// Inserts a pane in front of the panes at its depth.
fn wait(pane: Waiting, caster: u32) {
    let before_near = is_before(pane, caster, near);
    let before_far = before_near || is_before(pane, caster, far);
    third = Waiting(select(pane.depth, far.depth, before_far), select(pane.setup, far.setup, before_far));
    if before_near {
        far = near;
        near = pane;
    } else if before_far {
        far = pane;
    }
}

fn lay_particle(view: GpuView, bounds: vec4<f32>, hit: Hit, arriving: vec3<f32>) {
    lay_fog(hit.depth);
    let material = materials[hit.material];
    let share = share_before_surface(view, bounds, material, corner + 0.5, hit.depth, opaque_depth);
    let adds = material.transfer == TRANSFER_NONE;
    let light = select(arriving, vec3(1.0), adds);
    var sent = seen_color(hit, material.transfer) * light + material.emission;
    var covered = vec3(hit.opacity * share);
    if HAS_BRICKS {
        let is_brick = material.shape == SHAPE_BRICK;
        sent = select(sent, hit.color, is_brick && !adds);
        // By channel.
        covered = select(covered, hit.absorbed, is_brick);
    }
    lay(view, hit.depth, covered * sent, select(1.0 - covered, vec3(1.0), adds));
}

fn visit(view: GpuView, id: u32, footprint: Footprint) {
    count_pair();
    let is_pane = HAS_TRIANGLES && footprint.is_triangle;
    var hit: Hit;
    if is_pane {
        hit.depth = triangle_weights(setup_of(footprint), corner + 0.5).w;
    } else if HAS_PARTICLES {
        hit = faced_hit(view, footprint, faced_of(view, footprint), corner + 0.5, opaque_depth);
    }
    var is_first = hit.depth < opaque_depth;
    if is_pane && is_coplanar(hit.depth, opaque_depth) {
        // The sky is no caster.
        let behind = textureLoad(seen_pixels, record_texel(pixel_index), 0).y;
        is_first = is_in_front(hit.depth, caster_of(footprint), opaque_depth, behind);
    }
    if !(hit.depth >= 0.0 && hit.depth <= 1.0 && is_first) {
        return;
    }
    if is_pane {
        wait(Waiting(hit.depth, setup_of(footprint)), caster_of(footprint));
    }
    if HAS_TRIANGLES {
        lay_waiting(view, select(hit.depth, -1.0, is_pane));
    }
    if HAS_PARTICLES && !is_pane {
        lay_particle(view, footprint.bounds, hit, textureLoad(lit, record_texel(id), 0).rgb);
    }
}

// Blends all waiting layers, up to the surface behind.
fn finish(view: GpuView) {
    if HAS_TRIANGLES {
        lay_waiting(view, 2.0);
        lay_fog(opaque_depth);
        while pane_count < PANES {
            store_pane(NO_PANE);
        }
    }
}

// Among bricks keys are by distance.
fn settled(front: f32) -> bool {
    var depth = front;
    if HAS_BRICKS {
        depth = depth_of_key(camera(), corner + 0.5, front);
    }
    return !(any(passed >= vec3(FAINT)) && opaque_depth + COPLANAR * opaque_depth > depth);
}
