// Light that arrives at a point before shadows, and the face of a cube's map that a point is in.

import package::records::light::{END_BIT, GpuLight, INNER_BIT, LIGHT_DIRECTIONAL, LIGHT_SPOT};

// Face of a cube that contains the direction `away` from its centre.
fn cube_face(away: vec3<f32>) -> u32 {
    let size = abs(away);
    if (size.x >= size.y) & (size.x >= size.z) {
        return select(1u, 0u, away.x > 0.0);
    }
    if size.y >= size.z {
        return select(3u, 2u, away.y > 0.0);
    }
    return select(5u, 4u, away.z > 0.0);
}

struct Incoming {
    toward: vec3<f32>, // direction to the light, unit
    color: vec3<f32>,  // irradiance at normal incidence, before shadows
}

fn incoming(light: GpuLight, point: vec3<f32>) -> Incoming {
    if light.kind == LIGHT_DIRECTIONAL {
        return Incoming(-light.direction, light.color);
    }
    let away = point - light.position;
    let square = max(dot(away, away), 1e-4);
    let ray = away * inverseSqrt(square);
    // Falls to 0 at the end of its range: glTF KHR_lights_punctual; squared, Karis 2013.
    let part = square * light.per_range2;
    let window = max(1.0 - part * part, 0.0);
    var color = light.color / square * (window * select(window, 1.0, (light.traits & END_BIT) != 0u));
    if light.kind == LIGHT_SPOT {
        let share = saturate(
            (dot(ray, light.direction) - light.cone_outer) / (light.cone_inner - light.cone_outer)
        );
        color *= share * share * select(3.0 - 2.0 * share, 1.0, (light.traits & INNER_BIT) != 0u);
    }
    return Incoming(-ray, color);
}
