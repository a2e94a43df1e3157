// Panes: thin sheets that filter what is behind them, scatter some light and mirror some. CPU twin:
// src/reference/shading/mod.rs.

import package::bind::uniform::picture_params;
import package::records::light::listed_light;
import package::shade::cost::count_lights;
import package::shade::receive::{incoming, shadow};
import package::shade::shading::{Gloss, PER_PI, Surface, ambient_light, highlight};

struct Lit {
    diffuse: vec3<f32>, // from both sides
    shine: vec3<f32>,
}

fn light_sheet(surface: Surface, gloss: Gloss) -> Lit {
    var lit = Lit(ambient_light(surface.normal), vec3(0.0));
    count_lights(surface.lights.count);
    for (var i = 0u; i < surface.lights.count; i += 1u) {
        let light = listed_light(surface.lights, i);
        let arriving = incoming(light, surface.point);
        if any(arriving.color > vec3(0.0)) {
            let cosine = dot(surface.normal, arriving.toward);
            // Off itself, on the light's side: a pane is not behind itself.
            let side = surface.face * select(-1.0, 1.0, dot(surface.face, arriving.toward) > 0.0);
            let passed = arriving.color * shadow(light, surface.point, side, arriving.toward, picture_params.bias);
            lit.diffuse += passed * (abs(cosine) * PER_PI);
            let shine = highlight(surface.normal, arriving.toward, surface.to_eye, surface.roughness, gloss);
            lit.shine += select(vec3(0.0), passed * (cosine * shine), cosine > 0.0);
        }
    }
    return lit;
}
