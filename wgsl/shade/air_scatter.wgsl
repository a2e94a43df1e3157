// air, scatter: light that the air of one slice of a column of pixels sends to the eye, per unit of
// scattering optical depth. One invocation per column and slice. CPU twin: src/reference/air.rs. Host:
// src/stage/air.rs.

import package::bind::sampled::lights;
import package::bind::stored::sources;
import package::bind::uniform::{air_params, picture_params, views};
import package::records::air_params::AIR_CELL;
import package::records::light::{SHAFTS_BIT, light_record};
import package::shade::receive::{incoming, shadow};

const PER_FOUR_PI: f32 = 0.07957747;

// Phase function of Henyey and Greenstein 1941; `cosine` between the incoming and outgoing directions.
fn phase(cosine: f32, g: f32) -> f32 {
    let spread = max(1.0 + g * g - 2.0 * g * cosine, 1e-6);
    return PER_FOUR_PI * (1.0 - g * g) / (spread * sqrt(spread));
}

// Radiance that a point of the air scatters back along `ray`, per unit of scattering optical depth.
fn scattered(point: vec3<f32>, ray: vec3<f32>) -> vec3<f32> {
    var sum = air_params.ambient;
    // The loop's end depends on more than the uniform: llvmpipe would recompile the kernel for its value.
    let count = min(picture_params.light_count, textureDimensions(lights).x);
    for (var i = 0u; i < count; i += 1u) {
        let light = light_record(i);
        let arriving = incoming(light, point);
        if (light.traits & SHAFTS_BIT) != 0u && any(arriving.color > vec3(0.0)) {
            let passed = shadow(light, point, vec3(0.0), arriving.toward, 0.0);
            sum += arriving.color * passed * phase(dot(arriving.toward, ray), air_params.anisotropy);
        }
    }
    return sum;
}

@compute @workgroup_size(8, 8)
fn air_scatter(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(sources);
    if any(id.xy >= size) {
        return;
    }
    let view = views[0];
    let pixel = (vec2<f32>(id.xy) + 0.5) * f32(AIR_CELL);
    let slope = (pixel - view.size * 0.5) / view.scale;
    let way = vec3(slope.x, -slope.y, -1.0);
    let ray = normalize((picture_params.world_from_view * vec4(way, 0.0)).xyz);
    var sum = vec3(0.0);
    // Not by the uniform alone: llvmpipe would recompile the kernel for its value.
    let samples = select(0u, air_params.samples, size.x > 0u);
    for (var i = 0u; i < samples; i += 1u) {
        let along = f32(id.z) + (f32(i) + 0.5) / f32(air_params.samples);
        let distance = view.near + along / f32(air_params.slices) * (view.far - view.near);
        let point = (picture_params.world_from_view * vec4(way * distance, 1.0)).xyz;
        sum += scattered(point, ray);
    }
    textureStore(sources, id.xy, id.z, vec4(sum / f32(air_params.samples), 1.0));
}
