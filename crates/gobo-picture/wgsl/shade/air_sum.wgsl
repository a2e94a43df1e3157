// air, sum: sums from the eye through the slices of a column of pixels. One invocation per column of the
// blocks that a band sees. CPU reference: crates/gobo-reference/src/air.rs. Rust:
// crates/gobo-picture/src/stage/air.rs.

import package::bind::picture_in::{air_ends, air_params, sources};
import package::bind::picture_out::{air, air_items};
import package::bind::uniform::views;
import package::records::picture::AIR_CELL;
import package::shade::air::air_shift;
import package::shade::air_items::{AIR_BLOCK, ITEM_COUNT, air_size, band_blocks, block_column};

const THIN: f32 = 1e-3; // optical depth; the next term of the series is a sixth of its square

@compute @workgroup_size(8, 8)
fn air_sum(@builtin(global_invocation_id) id: vec3<u32>) {
    if all(id.xy == vec2(0u)) {
        // Emptied for the next band.
        atomicStore(&air_items[0], 0u);
        atomicStore(&air_items[ITEM_COUNT], 0u);
    }
    let column = block_column(0u) + id.xy;
    let size = air_size();
    if any(id.xy >= band_blocks() * AIR_BLOCK) || any(column >= size) {
        return;
    }
    let ends = air_ends[column.y * size.x + column.x];
    if (ends >> 16u) == (ends & 0xffffu) {
        return;
    }
    let view = views[0];
    let pixel = (vec2<f32>(column) + 0.5) * f32(AIR_CELL) + air_shift(view);
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
    let slices = min(ends & 0xffffu, textureNumLayers(sources));
    for (var k = 0u; k < slices; k += 1u) {
        light += textureLoad(sources, column, k, 0).rgb * (left * share);
        left *= passed;
        textureStore(air, column, k, vec4(light, 1.0));
    }
}
