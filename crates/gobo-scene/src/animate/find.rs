//! Animated values by the path in `target`.
use super::{AIR, CAMERA, Check, LIGHT, MATERIAL, Target};
use crate::{Scene, SceneError, error::quoted, plain::nearest};
use gobo::model::LightKind;

pub(super) fn no_value(check: &Check<'_>, field: &str, known: &[&str]) -> SceneError {
    let message = format!("{} is no value that keys can move", quoted(field));
    let help = nearest(field, known.iter().copied()).unwrap_or_default();
    check.fault("target", message, &help)
}

pub(super) fn find(check: &Check<'_>, parts: &[&str], scene: &Scene) -> Result<Target, SceneError> {
    let index = |kind: &str, name: &str, names: Vec<&str>| {
        let named = names.iter().position(|known| *known == name);
        let found =
            named.or_else(|| name.parse().ok().filter(|&index: &usize| index < names.len()));
        found.ok_or_else(|| {
            let message = format!("there is no {kind} {}", quoted(name));
            check.fault("target", message, &nearest(name, names).unwrap_or_default())
        })
    };
    match *parts {
        ["camera", field] => match field {
            "eye" => Ok(Target::Eye),
            "target" => Ok(Target::LookAt),
            "up" => Ok(Target::Up),
            "fov_y" => Ok(Target::Lens),
            "exposure" => Ok(Target::Exposure),
            _ => Err(no_value(check, field, CAMERA)),
        },
        ["air", field] => {
            if scene.air.is_none() {
                return Err(check.fault("target", "the scene has no air", "add an [air] table"));
            }
            match field {
                "scattering" => Ok(Target::Scattering),
                "extinction" => Ok(Target::Extinction),
                _ => Err(no_value(check, field, AIR)),
            }
        }
        ["light", name, field] => {
            let names = scene.lights.iter().map(|light| light.name.as_str()).collect();
            let light = index("light", name, names)?;
            light_target(check, light, field, scene.lights[light].kind)
        }
        ["material", name, field] => {
            let names = scene.materials.iter().map(|material| material.name.as_str()).collect();
            let material = index("material", name, names)?;
            match field {
                "tint" => Ok(Target::Tint(material)),
                "emission" => Ok(Target::Emission(material)),
                "reflectivity" => Ok(Target::Reflectivity(material)),
                "cutoff" => Ok(Target::Cutoff(material)),
                "transmission" => Ok(Target::Transmission(material)),
                "roughness" => Ok(Target::Roughness(material)),
                "metallic" => Ok(Target::Metallic(material)),
                _ => Err(no_value(check, field, MATERIAL)),
            }
        }
        _ => {
            let message = format!("{} is nothing that keys can move", quoted(&parts.join(".")));
            let help = "write camera.eye, light.NAME.direction, shape.NAME.translation, \
                        mesh.NAME.rotation, splats.NAME.rotation, strands.NAME.scale, material.NAME.tint \
                        or air.scattering";
            Err(check.fault("target", message, help))
        }
    }
}

fn light_target(
    check: &Check<'_>,
    light: usize,
    field: &str,
    kind: LightKind,
) -> Result<Target, SceneError> {
    let (is_directional, is_point) =
        (matches!(kind, LightKind::Directional { .. }), matches!(kind, LightKind::Point { .. }));
    match field {
        "position" if !is_directional => Ok(Target::Position(light)),
        "direction" if !is_point => Ok(Target::Direction(light)),
        "angle" if !is_directional && !is_point => Ok(Target::Angle(light)),
        "color" => Ok(Target::Color(light)),
        "intensity" => Ok(Target::Intensity(light)),
        "position" | "direction" | "angle" => {
            let message = format!("the light has no {field}");
            Err(check.fault("target", message, "name a value that its kind has"))
        }
        _ => Err(no_value(check, field, LIGHT)),
    }
}
