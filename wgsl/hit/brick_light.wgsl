// Light that a brick of a thin grid sends along a ray to the eye: light scattered at four points of the ray,
// interpolated in the brick's lattice, weighted by the light absorbed near each, with even density in each
// third of the way. CPU reference: crates/gobo-reference/src/brick_light.rs.

import package::bind::sampled::brick_lights;
import package::records::record::record_texel;

// Whether the kernel shades bricks.
override SHADES_BRICKS: bool = false;

const THIRDS: u32 = 3u;
const SERIES: f32 = 0.02; // optical depth below which a series is more precise

fn point_light_at(index: u32) -> vec3<f32> {
    return textureLoad(brick_lights, record_texel(index), 0).rgb;
}

// Trilinear between the points of a lattice, `edge` along each edge; `position` in the box, 0..1.
fn lattice_light(first_point: u32, edge: u32, position: vec3<f32>) -> vec3<f32> {
    let last = f32(edge - 1u);
    let at = clamp(position, vec3(0.0), vec3(1.0)) * last;
    let low = min(floor(at), vec3(last - 1.0));
    let aside = at - low;
    let cell = vec3<u32>(low);
    let row = edge;
    let layer = edge * edge;
    let lattice_point = first_point + cell.x + cell.y * row + cell.z * layer;
    let a = mix(point_light_at(lattice_point), point_light_at(lattice_point + 1u), aside.x);
    let b = mix(point_light_at(lattice_point + row), point_light_at(lattice_point + row + 1u), aside.x);
    let low_layer = mix(a, b, aside.y);
    let c = mix(point_light_at(lattice_point + layer), point_light_at(lattice_point + layer + 1u), aside.x);
    let d = mix(
        point_light_at(lattice_point + layer + row),
        point_light_at(lattice_point + layer + row + 1u),
        aside.x,
    );
    return mix(low_layer, mix(c, d, aside.y), aside.z);
}

// Mean distance from its start at which a homogeneous medium of optical depth `tau` absorbs light, as a share
// of its length: 1 / tau - 1 / (exp(tau) - 1).
fn mean_way(tau: vec3<f32>) -> vec3<f32> {
    let exact = 1.0 / tau - 1.0 / (exp(min(tau, vec3(80.0))) - 1.0);
    return select(exact, 0.5 - tau / 12.0, tau < vec3(SERIES));
}

// Mean of the light that a brick scatters along a ray, weighted by absorption. `depths`: optical depth of
// each third of the ray's way through the box.
fn brick_light(
    first_point: u32,
    edge: u32,
    enters: vec3<f32>,
    leaves: vec3<f32>,
    depths: vec3<f32>,
    extinction: vec3<f32>,
) -> vec3<f32> {
    var left = vec3(1.0); // share of the light from behind
    var all = vec3(0.0);
    var sum = vec3(0.0);
    var far = vec3(0.0);  // absorbed in the third before, in the weight of its end
    // A count unknown to compilers keeps the loop from being unrolled: its code is large.
    let samples = select(0u, THIRDS + 1u, any(depths > vec3(0.0)));
    for (var i = 0u; i < samples; i += 1u) {
        let depth = select(select(depths.z, depths.y, i == 1u), depths.x, i == 0u);
        let tau = select(depth, 0.0, i == THIRDS) * extinction;
        let passed = exp(-tau);
        let absorbed = left * (1.0 - passed);
        let at_end = absorbed * mean_way(tau);
        let position = mix(enters, leaves, f32(i) / f32(THIRDS));
        sum += (far + absorbed - at_end) * lattice_light(first_point, edge, position);
        all += absorbed;
        far = at_end;
        left *= passed;
    }
    return sum / max(all, vec3(1e-20));
}
