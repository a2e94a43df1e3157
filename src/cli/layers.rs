//! A picture's light by where it comes from: what each light adds, and the rest.
use super::failure::Failure;
use gobo::{
    render::{RenderOptions, Renderer},
    scene::Scene,
};

/// A layer's name, and linear light by pixel.
pub(super) type Layer = (String, Vec<[f32; 3]>);

/// Name of what no light adds: ambient light, surroundings, and what glows.
const REST: &str = "rest";

/// Layers of the scene as it is; their sum is the picture's light. `names`: of its lights.
pub(super) fn of_lights(
    renderer: &mut Renderer,
    scene: &Scene,
    names: &[String],
) -> Result<Vec<Layer>, Failure> {
    let options = RenderOptions { light: true, keep: true, ..RenderOptions::default() };
    let mut alone = scene.clone();
    alone.lights.iter_mut().for_each(|light| light.intensity = 0.0);
    let rest = renderer.render(&alone, &options)?.picture.light;
    let mut layers = Vec::with_capacity(names.len() + 1);
    for (index, name) in names.iter().enumerate() {
        alone.lights[index].intensity = scene.lights[index].intensity;
        let mut light = renderer.render(&alone, &options)?.picture.light;
        alone.lights[index].intensity = 0.0;
        for (pixel, rest) in light.iter_mut().zip(&rest) {
            (0..3).for_each(|channel| pixel[channel] -= rest[channel]);
        }
        layers.push((name.clone(), light));
    }
    let mut name = REST.to_owned();
    while names.contains(&name) {
        name.push('_');
    }
    layers.push((name, rest));
    Ok(layers)
}
