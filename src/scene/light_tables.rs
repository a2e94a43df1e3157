//! Validation of light and shadow tables, and conversion to the library's units.
use super::{
    SceneError,
    document_lights::{KindOfLight, LightShadowTable, LightTable, SourceTable},
    look_up,
    source::SceneText,
    tables::Table,
};
use crate::model::{
    Cascades, Light, LightKind, MAX_CASCADES, MAX_SHADOWS, MAX_SOURCE_SIZE, MAX_SUN_ANGLE, Shadow,
    Source,
};
use toml::Spanned;

/// Least near plane of a spot or point light [m]: matrices can represent it.
const MIN_DEPTH: f32 = 1e-7;
/// Shortest range of cascades [m].
const MIN_RANGE: f32 = 1e-3;

pub(super) fn light(
    source: &SceneText<'_>,
    table: &Spanned<LightTable>,
    index: usize,
) -> Result<Light, SceneError> {
    let check = Table { source, table };
    let light = table.get_ref();
    let faces = matches!(light.kind, KindOfLight::Point) && faces(light);
    let own = LightShadowTable {
        kind: Some(light.kind),
        position: light.position,
        direction: light.direction.filter(|_| !faces),
        angle: light.angle,
        cascades: light.cascades,
        lambda: light.lambda,
        fade: light.fade,
        range: light.range,
        near: light.near,
        far: light.far,
        size: light.size,
    };
    let Shadow { kind, near, far, size, cascades } = shadow(&check, &own, "light", None)?;
    let color = light.color.unwrap_or([1.0; 3]);
    for v in color {
        check.number("color", v, |v| v >= 0.0, "0 or more")?;
    }
    let intensity = light.intensity.unwrap_or(3.0);
    let intensity = check.number("intensity", intensity, |v| v >= 0.0, "0 or more")?;
    if light.shadow.len() >= MAX_SHADOWS {
        let message = format!("{} further shadows", light.shadow.len());
        let help = format!("a light has at most {}", MAX_SHADOWS - 1);
        return Err(check.fault("shadow", message, &help));
    }
    let further = |table: &Spanned<LightShadowTable>| {
        shadow(&Table { source, table }, table.get_ref(), "shadow", Some(kind))
    };
    Ok(Light {
        name: light.name.clone().unwrap_or_else(|| format!("light{index}")),
        kind,
        color: color.into(),
        intensity,
        near,
        far,
        size,
        casts: light.casts.unwrap_or(true),
        cascades,
        shafts: light.shafts.unwrap_or(true),
        source: source_of(source, &check, kind)?,
        look_up: look_up::of_light(source, &check)?,
        shadows: light.shadow.iter().map(further).collect::<Result<_, _>>()?,
    })
}

/// Whether a light has an area with a facing direction.
fn faces(light: &LightTable) -> bool {
    let source = light.source.as_ref().map(Spanned::get_ref);
    matches!(source, Some(SourceTable::Disc { .. } | SourceTable::Rect { .. }))
}

/// Area of a light; `kind`: of the light of the table.
fn source_of(
    source: &SceneText<'_>,
    light: &Table<'_, LightTable>,
    kind: LightKind,
) -> Result<Option<Source>, SceneError> {
    let Some(table) = &light.table.get_ref().source else { return Ok(None) };
    let check = Table { source, table };
    let is_sun = matches!(table.get_ref(), SourceTable::Sun { .. });
    if is_sun != matches!(kind, LightKind::Directional { .. }) {
        let (message, help) = if is_sun {
            ("a sun is the source of a directional light", "sphere, disc or rect")
        } else {
            ("the source of a directional light is a sun", "{ kind = \"sun\", angle = 0.53 }")
        };
        return Err(check.fault("kind", message, &format!("use {help}")));
    }
    let size = |key, value| {
        let valid = |v| (0.0..=MAX_SOURCE_SIZE).contains(&v);
        check.number(key, value, valid, "a size of 0 to 1e4 m")
    };
    let direction = || match kind {
        LightKind::Spot { direction, .. } => Ok(direction),
        _ => match light.table.get_ref().direction {
            Some(direction) => light.direction("direction", direction),
            None => {
                let message = "a source that faces nowhere";
                Err(light.fault("source", message, "give the light a direction, or use a sphere"))
            }
        },
    };
    Ok(Some(match *table.get_ref() {
        SourceTable::Sphere { radius } => Source::Sphere { radius: size("radius", radius)? },
        SourceTable::Disc { radius } => {
            Source::Disc { radius: size("radius", radius)?, direction: direction()? }
        }
        SourceTable::Rect { width, height } => Source::Rect {
            width: size("width", width)?,
            height: size("height", height)?,
            direction: direction()?,
        },
        SourceTable::Sun { angle } => {
            let most = MAX_SUN_ANGLE.to_degrees();
            let valid = |v| (0.0..=most).contains(&v);
            let range = format!("0 to {most:.0} degrees");
            Source::Sun { angle: check.number("angle", angle, valid, &range)?.to_radians() }
        }
    }))
}

/// Validates a shadow; `noun` names the owner of the keys; `of_light` fills in missing keys.
fn shadow<T>(
    check: &Table<'_, T>,
    given: &LightShadowTable,
    noun: &str,
    of_light: Option<LightKind>,
) -> Result<Shadow, SceneError> {
    let kind = light_kind(check, given, noun, of_light)?;
    let is_directional = matches!(kind, LightKind::Directional { .. });
    let depth = |key: &str, value: Option<f32>| {
        let valid = |v: f32| v.abs() <= 1e7 && (v >= MIN_DEPTH || is_directional);
        let range = if is_directional { "within 1e7 m" } else { "a distance of 1e-7 to 1e7 m" };
        value.map(|v| check.number(key, v, valid, range)).transpose()
    };
    let (near, far) = (depth("near", given.near)?, depth("far", given.far)?);
    let first = near.or(is_directional.then_some(0.0));
    if let (Some(near), Some(far)) = (first, far)
        && near >= far
    {
        let key = if given.near.is_some() { "near" } else { "far" };
        let message = format!("near {near} is not before far {far}");
        return Err(check.fault(key, message, "near < far"));
    }
    Ok(Shadow {
        kind,
        near,
        far,
        size: given.size.map(|size| check.map_size(size)).transpose()?,
        cascades: cascades(check, given, noun, is_directional)?,
    })
}

fn light_kind<T>(
    check: &Table<'_, T>,
    given: &LightShadowTable,
    noun: &str,
    of_light: Option<LightKind>,
) -> Result<LightKind, SceneError> {
    let (of_kind, position, direction, angle) = match of_light {
        None => (None, None, None, None),
        Some(LightKind::Directional { direction }) => {
            (Some(KindOfLight::Directional), None, Some(direction), None)
        }
        Some(LightKind::Spot { position, direction, angle }) => {
            (Some(KindOfLight::Spot), Some(position), Some(direction), Some(angle))
        }
        Some(LightKind::Point { position }) => {
            (Some(KindOfLight::Point), Some(position), None, None)
        }
    };
    let kind = given.kind.or(of_kind).unwrap_or(KindOfLight::Directional);
    let name = match kind {
        KindOfLight::Directional => "directional",
        KindOfLight::Spot => "spot",
        KindOfLight::Point => "point",
    };
    let has = [
        ("position", given.position.is_some(), "directional"),
        ("direction", given.direction.is_some(), "point"),
        ("angle", given.angle.is_some(), "directional"),
        ("angle", given.angle.is_some(), "point"),
    ];
    if let Some((key, ..)) = has.iter().find(|(_, has, kind)| *has && *kind == name) {
        let message = format!("a {name} {noun} has no {key}");
        return Err(check.fault(key, message, &format!("remove {key}")));
    }
    let missing = |key: &str| {
        check.fault(key, format!("a {name} {noun} without {key}"), &format!("give it a {key}"))
    };
    let position = || match given.position {
        Some(value) => check.vector("position", value),
        None => position.ok_or_else(|| missing("position")),
    };
    let direction = || match given.direction {
        Some(value) => check.direction("direction", value),
        None => direction.ok_or_else(|| missing("direction")),
    };
    Ok(match kind {
        KindOfLight::Directional => LightKind::Directional { direction: direction()? },
        KindOfLight::Spot => LightKind::Spot {
            position: position()?,
            direction: direction()?,
            angle: match (given.angle, angle) {
                (None, Some(angle)) => angle,
                (degrees, _) => check.angle("angle", degrees.unwrap_or(45.0))?,
            },
        },
        KindOfLight::Point => LightKind::Point { position: position()? },
    })
}

fn cascades<T>(
    check: &Table<'_, T>,
    given: &LightShadowTable,
    noun: &str,
    is_directional: bool,
) -> Result<Option<Cascades>, SceneError> {
    let LightShadowTable { cascades: count, lambda, fade, range, .. } = *given;
    let usual = Cascades::default();
    let Some(count) = count else {
        let keys = [("lambda", lambda), ("fade", fade), ("range", range)];
        return match keys.iter().find(|(_, value)| value.is_some()) {
            None => Ok(None),
            Some((key, _)) => {
                Err(check.fault(key, format!("{key} without cascades"), "add cascades = 4"))
            }
        };
    };
    if !(1..=MAX_CASCADES).contains(&count) {
        let help = format!("1 to {MAX_CASCADES} cascades");
        return Err(check.fault("cascades", format!("cascades is {count}"), &help));
    }
    if !is_directional {
        let message = format!("only a directional {noun} has cascades");
        return Err(check.fault("cascades", message, "remove cascades"));
    }
    let most = |v: f32| (MIN_RANGE..=1e7).contains(&v);
    let is_half = |v: f32| (0.0..=0.5).contains(&v);
    Ok(Some(Cascades {
        count,
        lambda: check.share("lambda", lambda.unwrap_or(usual.lambda))?,
        fade: check.number("fade", fade.unwrap_or(usual.fade), is_half, "from 0 to 0.5")?,
        range: range
            .map(|v| check.number("range", v, most, "a distance of 1e-3 to 1e7 m"))
            .transpose()?,
    }))
}
