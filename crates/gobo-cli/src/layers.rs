//! Layers for compositors: a picture's light by its source, and its surfaces.
use super::{
    exr::{Channel, full_channel, rgb_channels},
    failure::Failure,
};
use gobo_picture::{RenderOptions, Renderer, Surface};
use gobo_scene::Scene;

/// Depth without a surface [m], as Blender writes it.
const NO_SURFACE: f32 = 1e10;

/// Names of the lights, which name their layers: other layers avoid them.
struct Names<'a>(&'a [String]);

impl Names<'_> {
    /// The name of a layer that belongs to no light.
    fn of(&self, layer: &str) -> String {
        let mut name = layer.to_owned();
        while self.0.contains(&name) {
            name.push('_');
        }
        name
    }
}

/// Layers of the scene as it is. `whole`: the picture's light; `names`: of its lights; `next`: the scene at
/// the next frame, if anything in it moves.
pub(super) fn of_scene(
    renderer: &mut Renderer,
    scene: &Scene,
    whole: &[[f32; 3]],
    names: &[String],
    next: Option<&Scene>,
) -> Result<Vec<Channel>, Failure> {
    let mut channels = of_surfaces(renderer, scene, names, next)?;
    channels.extend(of_lights(renderer, scene, whole, names)?);
    Ok(channels)
}

/// Contribution of each light, and the rest: their sum is the picture's light.
fn of_lights(
    renderer: &mut Renderer,
    scene: &Scene,
    whole: &[[f32; 3]],
    names: &[String],
) -> Result<Vec<Channel>, Failure> {
    let options = RenderOptions { light: true, keep: true, ..RenderOptions::default() };
    let mut alone = scene.clone();
    alone.lights.iter_mut().for_each(|light| light.intensity = 0.0);
    let none = renderer.render(&alone, &options)?.picture.light;
    let mut rest = whole.to_vec();
    let mut channels = Vec::new();
    for (index, name) in names.iter().enumerate() {
        alone.lights[index].intensity = scene.lights[index].intensity;
        let mut light = renderer.render(&alone, &options)?.picture.light;
        alone.lights[index].intensity = 0.0;
        for ((pixel, none), rest) in light.iter_mut().zip(&none).zip(&mut rest) {
            for channel in 0..3 {
                pixel[channel] -= none[channel];
                rest[channel] -= pixel[channel];
            }
        }
        channels.extend(rgb_channels(&format!("{name}."), &light));
    }
    channels.extend(rgb_channels(&format!("{}.", Names(names).of("rest")), &rest));
    Ok(channels)
}

/// Data of the picture's opaque surfaces.
fn of_surfaces(
    renderer: &mut Renderer,
    scene: &Scene,
    names: &[String],
    next: Option<&Scene>,
) -> Result<Vec<Channel>, Failure> {
    let layers = renderer.surface_layers(scene, next)?;
    let layer_names = Names(names);
    let data = |layer: &str, channel: &str, none: f32, value: fn(&Surface) -> f32| {
        let values = layers.first.iter().map(|first| first.as_ref().map_or(none, value));
        full_channel(&format!("{}.{channel}", layer_names.of(layer)), values)
    };
    let mut channels = vec![
        data("normal", "X", 0.0, |surface| surface.normal.x),
        data("normal", "Y", 0.0, |surface| surface.normal.y),
        data("normal", "Z", 0.0, |surface| surface.normal.z),
        data("depth", "Z", NO_SURFACE, |surface| surface.distance),
        data("object", "X", 0.0, |surface| surface.object as f32 + 1.0),
        data("material", "X", 0.0, |surface| surface.material as f32 + 1.0),
    ];
    if next.is_some() {
        // Compositors count rows from below.
        channels.push(data("motion", "X", 0.0, |surface| surface.motion.x));
        channels.push(data("motion", "Y", 0.0, |surface| -surface.motion.y));
    }
    channels.extend(rgb_channels(&format!("{}.", layer_names.of("albedo")), &layers.albedo));
    for (name, shadow) in names.iter().zip(&layers.shadows) {
        channels.extend(rgb_channels(&format!("{}.{name}.", layer_names.of("shadow")), shadow));
    }
    Ok(channels)
}
