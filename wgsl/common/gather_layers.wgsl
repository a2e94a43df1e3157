// Four pixels while what is not solid is laid over them, front to back. CPU twin: src/cpu/shade.rs.
// Needs common/caster_hit.wgsl, sheet.wgsl, surface.wgsl; the kernel binds `surfaces` and `lit`.
//
// Casters come in order of their nearest corner. A pane reaches from there far back, so it waits
// until what comes next is behind it; the order is exact while at most three panes wait.
const FAINT: f32 = 0.0009765625; // what is behind less than this is not seen: 1/1024
const NOWHERE: f32 = 4.0;        // depth of a place where no pane waits

var<private> corner: vec2<f32>; // first of the four pixels
var<private> opaque_depth: vec4<f32>;
var<private> passed: array<vec3<f32>, 4>; // of what is behind
var<private> color: array<vec3<f32>, 4>;
var<private> waiting_depth: array<vec3<f32>, 4>;
var<private> waiting_color: array<vec3<f32>, 12>;
var<private> waiting_passed: array<vec3<f32>, 12>;

fn start(view: GpuView, pixel: vec2<u32>) {
    corner = vec2<f32>(pixel);
    for (var i = 0u; i < 4u; i += 1u) {
        opaque_depth[i] = textureLoad(surfaces, pixel + vec2(0u, i), 0).a;
        passed[i] = vec3(1.0);
        color[i] = vec3(0.0);
        if HAS_TRIANGLES {
            waiting_depth[i] = vec3(NOWHERE);
        }
    }
}

fn lay(i: u32, own: vec3<f32>, pass_on: vec3<f32>) {
    color[i] += passed[i] * own;
    passed[i] *= pass_on;
}

fn first_waiting(i: u32) -> u32 {
    let d = waiting_depth[i];
    return select(select(2u, 1u, d.y <= d.z), 0u, d.x <= min(d.y, d.z));
}

fn waits_before(i: u32, depth: f32) -> bool {
    let d = waiting_depth[i];
    return min(d.x, min(d.y, d.z)) < depth;
}

// The panes before light depth `depth`, nearest first.
fn lay_waiting(i: u32, depth: f32) {
    while waits_before(i, depth) {
        let k = first_waiting(i);
        lay(i, waiting_color[3u * i + k], waiting_passed[3u * i + k]);
        waiting_depth[i][k] = NOWHERE;
    }
}

fn finish() {
    if HAS_TRIANGLES {
        for (var i = 0u; i < 4u; i += 1u) {
            lay_waiting(i, 2.0);
        }
    }
}

fn seen_color(hit: Hit, transfer: u32) -> vec3<f32> {
    return select(hit.color, min(hit.color * MAX_GAIN, vec3(1.0)), transfer == TRANSFER_GAIN);
}

fn visit_pane(view: GpuView, place: vec4<u32>, look: vec4<u32>, i: u32) {
    let pixel = corner + vec2(0.5, f32(i) + 0.5);
    let hit = caster_hit(view, place, look, pixel, opaque_depth[i]);
    if !(hit.depth >= 0.0 && hit.depth < opaque_depth[i] && any(passed[i] >= vec3(FAINT))) {
        return;
    }
    let material = materials[hit.material];
    let albedo = seen_color(hit, material.transfer);
    var own = hit.opacity * material.emission;
    var pass_on = vec3(1.0);
    if material.transfer == TRANSFER_NONE {
        own += hit.opacity * albedo;
    } else {
        let id = look.w & ~TRIANGLE_BIT;
        let surface = triangle_surface(view, pixel, hit.depth, id, look.x, albedo, material.roughness);
        let lit = light_sheet(surface);
        // A sheet that is not clear scatters half of what it covers and filters the rest.
        let covers = material.transfer == TRANSFER_OVER;
        let share = hit.opacity * select(0.5 * (1.0 - material.transmission), 1.0, covers);
        let mirrored = hit.opacity * fresnel(dot(surface.normal, surface.to_eye));
        own += share * albedo * lit.diffuse + hit.opacity * lit.shine
            + mirrored * sky(reflect(-surface.to_eye, surface.normal));
        pass_on = hit.light * (1.0 - mirrored) * select(1.0 - share, 1.0, covers);
    }
    var k = first_waiting(i);
    let d = waiting_depth[i];
    if max(d.x, max(d.y, d.z)) < NOWHERE {
        if hit.depth <= d[k] {
            lay(i, own, pass_on);
            return;
        }
        lay(i, waiting_color[3u * i + k], waiting_passed[3u * i + k]);
    } else {
        k = select(select(2u, 1u, d.y == NOWHERE), 0u, d.x == NOWHERE);
    }
    waiting_depth[i][k] = hit.depth;
    waiting_color[3u * i + k] = own;
    waiting_passed[3u * i + k] = pass_on;
}

fn visit_particle(view: GpuView, place: vec4<u32>, look: vec4<u32>, arriving: vec3<f32>, i: u32) {
    let hit = caster_hit(view, place, look, corner + vec2(0.5, f32(i) + 0.5), opaque_depth[i]);
    if hit.depth >= 0.0 && hit.depth < opaque_depth[i] {
        if HAS_TRIANGLES {
            lay_waiting(i, hit.depth);
        }
        let material = materials[hit.material];
        let adds = material.transfer == TRANSFER_NONE;
        let light = select(arriving, vec3(1.0), adds);
        let own = seen_color(hit, material.transfer) * light + material.emission;
        lay(i, hit.opacity * own, vec3(select(1.0 - hit.opacity, 1.0, adds)));
    }
}

fn visit(view: GpuView, footprint: u32, place: vec4<u32>, look: vec4<u32>) {
    if HAS_TRIANGLES && (look.w & TRIANGLE_BIT) != 0u {
        for (var i = 0u; i < 4u; i += 1u) {
            visit_pane(view, place, look, i);
        }
    } else if HAS_PARTICLES {
        let arriving = textureLoad(lit, record_texel(footprint), 0).rgb;
        visit_particle(view, place, look, arriving, 0u);
        visit_particle(view, place, look, arriving, 1u);
        visit_particle(view, place, look, arriving, 2u);
        visit_particle(view, place, look, arriving, 3u);
    }
}

fn is_open(i: u32, front: f32) -> bool {
    return any(passed[i] >= vec3(FAINT)) && opaque_depth[i] > front;
}

fn settled(front: f32) -> bool {
    return !(is_open(0u, front) || is_open(1u, front) || is_open(2u, front) || is_open(3u, front));
}
