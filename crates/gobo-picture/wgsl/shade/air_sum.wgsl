// air, sum: sums from the eye through the slices of a column of pixels. One invocation per column. CPU
// reference: crates/gobo-reference/src/air.rs. Rust: crates/gobo-picture/src/stage/air.rs.

import package::bind::sampled::sources;
import package::bind::stored::air;
import package::bind::uniform::{air_params, views};
import package::records::air_params::AIR_CELL;
import package::shade::sample_offset::air_shift;

const THIN: f32 = 1e-3; // optical depth; the next term of the series is a sixth of its square

@compute @workgroup_size(8, 8)
fn air_sum(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(air)) {
        return;
    }
    let view = views[0];
    let pixel = (vec2<f32>(id.xy) + 0.5) * f32(AIR_CELL) + air_shift(view);
    let slope = (pixel - view.size * 0.5) / view.scale;
    let length = (view.far - view.near) / f32(air_params.slices) * sqrt(1.0 + dot(slope, slope));
    let tau = air_params.extinction * length;
    let passed = exp(-tau);
    // Mean transmittance within a slice; for a thin one by its series, which has no 0/0.
    let thin = tau < vec3(THIN);
    let thick = (1.0 - passed) / select(tau, vec3(1.0), thin);
    let share = air_params.scattering * length * select(thick, 1.0 - 0.5 * tau, thin);
    var light = vec3(0.0);
    var left = vec3(1.0);
    // Layers of the sampled texture: naga's query of a storage texture's layers is invalid SPIR-V.
    let slices = min(air_params.slices, textureNumLayers(sources));
    for (var k = 0u; k < slices; k += 1u) {
        light += textureLoad(sources, id.xy, k, 0).rgb * (left * share);
        left *= passed;
        textureStore(air, id.xy, k, vec4(light, 1.0));
    }
}
