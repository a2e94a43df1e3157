//! Tables of lights and their shadows in the library's units.
use super::{SceneError, keys::Keys, tables};
use gobo::model::{
    Cascades, Light, LightKind, LookUp, MAX_BOUNCE, MAX_CASCADES, MAX_CAUSTIC_RAYS, MAX_SHADOWS,
    MAX_SOURCE_SIZE, MAX_SUN_ANGLE, MAX_VIEWPOINTS, Shadow, Source,
};
use serde::Deserialize;
use toml::Spanned;

/// Least near plane of a spot or point light \[m\]: matrices can represent it.
const MIN_DEPTH: f32 = 1e-7;
/// Shortest range of cascades \[m\].
const MIN_RANGE: f32 = 1e-3;

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum KindOfLight {
    Directional,
    Spot,
    Point,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum KindOfSource {
    Sphere,
    Disc,
    Rect,
    Sun,
}

/// `index`: of the light in the file.
pub(super) fn light(keys: &Keys<'_>, index: usize) -> Result<Light, SceneError> {
    let Shadow { kind, near, far, size, cascades } = shadow(keys, "light", None)?;
    let shadows = keys.many("shadow", |keys| shadow(keys, "shadow", Some(kind)))?;
    if shadows.len() >= MAX_SHADOWS {
        let help = format!("a light has at most {}", MAX_SHADOWS - 1);
        return Err(keys.fault("shadow", format!("{} further shadows", shadows.len()), &help));
    }
    let rgb = |key| keys.three(key, 0.0..=f32::MAX, "0 or more");
    let intensity = keys.number("intensity", 0.0..=f32::MAX, "0 or more")?;
    let source = keys.one("source", |of| source(of, keys, kind))?.map(Spanned::into_inner);
    let rays = format!("0 to {MAX_CAUSTIC_RAYS} rays along the edge of a texel");
    let points = format!("0 to {MAX_BOUNCE} points along the edge of a map");
    let light = Light {
        name: keys.given("name")?.unwrap_or_else(|| format!("light{index}")),
        kind,
        color: rgb("color")?.unwrap_or(glam::Vec3::ONE),
        intensity: intensity.unwrap_or(3.0),
        near,
        far,
        size,
        // Only glTF files set these.
        inner_angle: None,
        end: None,
        casts: keys.value("casts", true)?,
        cascades,
        shafts: keys.value("shafts", true)?,
        source: source.map(|(source, _)| source),
        viewpoints: source.map_or(1, |(_, viewpoints)| viewpoints),
        caustics: keys.whole("caustics", 0, 0..=MAX_CAUSTIC_RAYS, &rays)?,
        bounce: keys.whole("bounce", 0, 0..=MAX_BOUNCE, &points)?,
        look_up: LookUp {
            filter: tables::filter(keys)?,
            bias: keys.bias("bias")?,
            slope_bias: keys.bias("slope_bias")?,
            normal_bias: keys.bias("normal_bias")?,
        },
        shadows: shadows.into_iter().map(Spanned::into_inner).collect(),
    };
    match (light.caustics_problem(), light.bounce_problem()) {
        (Some(problem), _) => Err(keys.fault("caustics", problem, without_caustics(&light))),
        (None, Some(problem)) => {
            let help = if light.casts { "lower bounce" } else { "remove bounce, or casts = false" };
            Err(keys.fault("bounce", problem, help))
        }
        (None, None) => Ok(light),
    }
}

/// Remedy where a light's caustics cannot be made.
fn without_caustics(light: &Light) -> &'static str {
    if !light.casts {
        "remove caustics, or casts = false"
    } else if light.source.is_some() {
        "remove the source: the caustics are then those of its middle, and sharper; or remove caustics"
    } else if !light.shadows.is_empty() {
        "give the further shadow to a light of its own, or remove caustics"
    } else {
        "lower size, or remove caustics"
    }
}

/// Area of a light, the surface that its rays leave, and its viewpoints; `light`: keys of the light.
fn source(keys: &Keys<'_>, light: &Keys<'_>, kind: LightKind) -> Result<(Source, u32), SceneError> {
    let source = source_shape(keys, light, kind)?;
    let help = format!("1 to {MAX_VIEWPOINTS} viewpoints");
    // 0: chosen after the scene is loaded.
    let is_stated = keys.has("viewpoints");
    let viewpoints = keys.whole("viewpoints", 1, 1..=MAX_VIEWPOINTS, &help)?;
    let viewpoints = if is_stated { viewpoints } else { 0 };
    match source.parts_problem(&kind, viewpoints) {
        Some(problem) => {
            Err(keys.fault("viewpoints", problem, "give it another number, or leave it out"))
        }
        None => Ok((source, viewpoints)),
    }
}

fn source_shape(keys: &Keys<'_>, light: &Keys<'_>, kind: LightKind) -> Result<Source, SceneError> {
    let shape = keys.required("kind")?;
    let is_sun = shape == KindOfSource::Sun;
    if is_sun != matches!(kind, LightKind::Directional { .. }) {
        let (message, help) = if is_sun {
            ("a sun is the source of a directional light", "sphere, disc or rect")
        } else {
            ("the source of a directional light is a sun", "{ kind = \"sun\", angle = 0.53 }")
        };
        return Err(keys.fault("kind", message, &format!("use {help}")));
    }
    let size =
        |key| keys.need(key, keys.number(key, 0.0..=MAX_SOURCE_SIZE, "a size of 0 to 1e4 m")?);
    let direction = || match kind {
        LightKind::Spot { direction, .. } => Ok(direction),
        _ => light.direction("direction")?.ok_or_else(|| {
            let message = "a source that faces nowhere";
            light.fault("source", message, "give the light a direction, or use a sphere")
        }),
    };
    Ok(match shape {
        KindOfSource::Sphere
            if light.has("direction") && matches!(kind, LightKind::Point { .. }) =>
        {
            return Err(light.fault(
                "direction",
                "a point light has no direction",
                "remove direction",
            ));
        }
        KindOfSource::Sphere => Source::Sphere { radius: size("radius")? },
        KindOfSource::Disc => Source::Disc { radius: size("radius")?, direction: direction()? },
        KindOfSource::Rect => {
            Source::Rect { width: size("width")?, height: size("height")?, direction: direction()? }
        }
        KindOfSource::Sun => {
            let most = MAX_SUN_ANGLE.to_degrees();
            let angle = keys.number("angle", 0.0..=most, &format!("0 to {most:.0} degrees"))?;
            Source::Sun { angle: angle.unwrap_or(0.53).to_radians() }
        }
    })
}

/// `noun` names the owner of the keys; missing values default to those of `of_light`.
fn shadow(keys: &Keys<'_>, noun: &str, of_light: Option<LightKind>) -> Result<Shadow, SceneError> {
    let kind = light_kind(keys, noun, of_light)?;
    let is_directional = matches!(kind, LightKind::Directional { .. });
    let (depths, words) = match kind {
        LightKind::Directional { .. } => (-1e7..=1e7, "within 1e7 m"),
        _ => (MIN_DEPTH..=1e7, "a distance of 1e-7 to 1e7 m"),
    };
    let near = keys.number("near", depths.clone(), words)?;
    let far = keys.number("far", depths, words)?;
    let first = near.or(is_directional.then_some(0.0));
    if let (Some(first), Some(last)) = (first, far)
        && first >= last
    {
        let key = if near.is_some() { "near" } else { "far" };
        let message = format!("near {first} is not before far {last}");
        return Err(keys.fault(key, message, "near < far"));
    }
    let cascades = cascades(keys, noun, is_directional)?;
    Ok(Shadow { kind, near, far, size: keys.map_size()?, cascades })
}

fn light_kind(
    keys: &Keys<'_>,
    noun: &str,
    of_light: Option<LightKind>,
) -> Result<LightKind, SceneError> {
    let (usual, position, direction, angle) = match of_light {
        None => (keys.required("kind")?, None, None, None),
        Some(LightKind::Directional { direction }) => {
            (KindOfLight::Directional, None, Some(direction), None)
        }
        Some(LightKind::Spot { position, direction, angle }) => {
            (KindOfLight::Spot, Some(position), Some(direction), Some(angle))
        }
        Some(LightKind::Point { position }) => (KindOfLight::Point, Some(position), None, None),
    };
    let kind = keys.value("kind", usual)?;
    // The source of a point light may have a direction.
    let (name, foreign) = match kind {
        KindOfLight::Directional => ("directional", &["position", "angle"][..]),
        KindOfLight::Spot => ("spot", &[][..]),
        KindOfLight::Point if keys.has("source") => ("point", &["angle"][..]),
        KindOfLight::Point => ("point", &["direction", "angle"][..]),
    };
    if let Some(key) = foreign.iter().find(|key| keys.has(key)) {
        let message = format!("a {name} {noun} has no {key}");
        return Err(keys.fault(key, message, &format!("remove {key}")));
    }
    let missing = |key: &str| {
        keys.fault(key, format!("a {name} {noun} without {key}"), &format!("give it a {key}"))
    };
    let position = || keys.vector("position")?.or(position).ok_or_else(|| missing("position"));
    let direction =
        || keys.direction("direction")?.or(direction).ok_or_else(|| missing("direction"));
    Ok(match kind {
        KindOfLight::Directional => LightKind::Directional { direction: direction()? },
        KindOfLight::Spot => LightKind::Spot {
            position: position()?,
            direction: direction()?,
            angle: keys.angle("angle")?.or(angle).unwrap_or(45_f32.to_radians()),
        },
        KindOfLight::Point => LightKind::Point { position: position()? },
    })
}

fn cascades(
    keys: &Keys<'_>,
    noun: &str,
    is_directional: bool,
) -> Result<Option<Cascades>, SceneError> {
    let usual = Cascades::default();
    if !keys.has("cascades") {
        return match ["lambda", "fade", "range"].into_iter().find(|key| keys.has(key)) {
            None => Ok(None),
            Some(key) => {
                Err(keys.fault(key, format!("{key} without cascades"), "add cascades = 4"))
            }
        };
    }
    let help = format!("1 to {MAX_CASCADES} cascades");
    let count = keys.whole("cascades", 1, 1..=MAX_CASCADES, &help)?;
    if !is_directional {
        let message = format!("only a directional {noun} has cascades");
        return Err(keys.fault("cascades", message, "remove cascades"));
    }
    let fade = keys.number("fade", 0.0..=0.5, "from 0 to 0.5")?;
    Ok(Some(Cascades {
        count,
        lambda: keys.share("lambda", usual.lambda)?,
        fade: fade.unwrap_or(usual.fade),
        range: keys.number("range", MIN_RANGE..=1e7, "a distance of 1e-3 to 1e7 m")?,
    }))
}
