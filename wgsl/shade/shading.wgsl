// How what the camera sees scatters light to it. CPU twin: src/reference/shading/mod.rs.

import package::bind::uniform::picture_params;
import package::records::light::{LightList, listed_light};
import package::shade::cost::count_lights;
import package::shade::receive::{incoming, shadow};

const PER_PI: f32 = 0.31830989;

// What is seen, and mirrored, where there is nothing: brighter above.
fn sky(direction: vec3<f32>) -> vec3<f32> {
    return picture_params.background * (1.0 + 0.35 * direction.y);
}

fn ambient_light(normal: vec3<f32>) -> vec3<f32> {
    return picture_params.ambient * (0.85 + 0.15 * normal.y);
}

// Schlick 1994, of glass and most that is no metal.
fn fresnel(cosine: f32) -> f32 {
    let rest = clamp(1.0 - cosine, 0.0, 1.0);
    return 0.04 + 0.96 * rest * rest * rest * rest * rest;
}

// How much is mirrored: all of what reflects by itself, of the rest what shines like glass.
struct Gloss {
    reflectivity: f32,
    polish: f32, // 1 of glass, 0 of what is not there
}

fn mirrored(gloss: Gloss, cosine: f32) -> f32 {
    return gloss.reflectivity + (1.0 - gloss.reflectivity) * gloss.polish * fresnel(cosine);
}

// Blinn 1977, normalised; the exponent from the roughness as Walter et al. 2007, section 6.
fn highlight(normal: vec3<f32>, toward: vec3<f32>, to_eye: vec3<f32>, roughness: f32, gloss: Gloss) -> f32 {
    let middle = normalize(toward + to_eye);
    let width = max(roughness * roughness, 0.04);
    let exponent = 2.0 / (width * width) - 1.0;
    let lobe = pow(max(dot(normal, middle), 1e-6), exponent);
    return (exponent + 8.0) * (PER_PI / 8.0) * lobe * mirrored(gloss, dot(to_eye, middle));
}

struct Surface {
    point: vec3<f32>,
    normal: vec3<f32>, // interpolated, on the eye's side
    face: vec3<f32>,   // of the plane, on the eye's side
    to_eye: vec3<f32>,
    albedo: vec3<f32>,
    roughness: f32,
    reach: f32,        // how far what is in the map may lie off the point [m]
    lights: LightList,
}

fn shade_solid(surface: Surface) -> vec3<f32> {
    var sum = surface.albedo * ambient_light(surface.normal);
    count_lights(surface.lights.count);
    for (var i = 0u; i < surface.lights.count; i += 1u) {
        let light = listed_light(surface.lights, i);
        let arriving = incoming(light, surface.point);
        let cosine = dot(surface.normal, arriving.toward);
        if cosine > 0.0 && dot(surface.face, arriving.toward) > 0.0 && any(arriving.color > vec3(0.0)) {
            let bias = picture_params.bias + surface.reach;
            let passed = shadow(light, surface.point, surface.face, arriving.toward, bias);
            let shine = highlight(surface.normal, arriving.toward, surface.to_eye, surface.roughness, Gloss(0.0, 1.0));
            sum += arriving.color * passed * (cosine * (surface.albedo * PER_PI + shine));
        }
    }
    return sum;
}
