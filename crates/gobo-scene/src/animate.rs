//! `[[animate]]`: keys of the camera, lights, shapes, meshes, materials and air.
use super::{
    Scene, SceneError,
    document::{AnimateTable, Document},
    error::quoted,
    particles::FARTHEST,
    plain::nearest,
    rig::{Moving, Placement},
    source::SceneText,
    track::{Channel, Track},
};
use glam::{Vec3, Vec4};
use gobo::model::{LightKind, Motion, Source};
use std::{
    collections::HashMap,
    ops::{Range, RangeInclusive},
    sync::Arc,
};
use toml::Spanned;

mod find;

use find::{find, no_value};

/// A shape, mesh, splats or strands of the scene file that keys may name.
pub(super) struct Placed {
    /// One of [`PLACED`].
    pub kind: &'static str,
    pub name: Option<String>,
    /// Its triangles in the scene.
    pub triangles: Range<usize>,
    /// Its movable part; `None` for a displaced sphere, which cannot be moved.
    pub moving: Option<Moving>,
}

/// A value that keys animate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Target {
    Eye,
    LookAt,
    Up,
    Lens,
    Exposure,
    Position(usize),
    Direction(usize),
    Color(usize),
    Intensity(usize),
    Angle(usize),
    Tint(usize),
    Emission(usize),
    Reflectivity(usize),
    Cutoff(usize),
    Transmission(usize),
    Roughness(usize),
    Metallic(usize),
    Scattering,
    Extinction,
}

/// Time after which a light that swings is no longer upright \[s\].
const SOON: f64 = 1e-3;
/// Kinds of tables that have a place in the scene.
const PLACED: [&str; 4] = ["shape", "mesh", "splats", "strands"];
const CAMERA: &[&str] = &["eye", "target", "up", "fov_y", "exposure"];
const LIGHT: &[&str] = &["position", "direction", "color", "intensity", "angle"];
const MATERIAL: &[&str] =
    &["tint", "emission", "reflectivity", "cutoff", "transmission", "roughness", "metallic"];
const PLACE: &[&str] = &["translation", "rotation", "scale"];
const AIR: &[&str] = &["scattering", "extinction"];

/// Keys of one table.
#[derive(Clone, Debug)]
struct Keyed {
    target: Target,
    track: Track,
    /// Valid range of each number of a key.
    range: RangeInclusive<f32>,
    /// World position of the scene's origin \[m\].
    origin: Vec3,
}

/// Format of a target's keys.
struct KeyFormat {
    /// Numbers per key.
    count: usize,
    range: RangeInclusive<f32>,
}

impl Target {
    fn kind(self, scene: &Scene) -> KeyFormat {
        let (count, range) = match self {
            Self::Eye | Self::LookAt | Self::Up | Self::Position(_) | Self::Direction(_) => {
                (3, -FARTHEST..=FARTHEST)
            }
            Self::Lens | Self::Angle(_) => (1, 0.01..=179.9),
            Self::Exposure => (1, -32.0..=32.0),
            Self::Color(_) | Self::Emission(_) => (3, 0.0..=f32::MAX),
            Self::Intensity(_) => (1, 0.0..=f32::MAX),
            Self::Tint(material) => (4, 0.0..=scene.materials[material].transfer.max_color()),
            Self::Reflectivity(_)
            | Self::Cutoff(_)
            | Self::Transmission(_)
            | Self::Roughness(_)
            | Self::Metallic(_) => (1, 0.0..=1.0),
            Self::Scattering | Self::Extinction => (3, 0.0..=1e3),
        };
        KeyFormat { count, range }
    }
}

impl Motion for Keyed {
    fn apply(&self, scene: &mut Scene, seconds: f64) {
        let (low, high) = (Vec4::splat(*self.range.start()), Vec4::splat(*self.range.end()));
        let value = self.track.at(seconds).clamp(low, high);
        let (vector, number) = (value.truncate(), value.x);
        let Scene { camera, lights, materials, .. } = scene;
        match self.target {
            Target::Eye => camera.eye = vector - self.origin,
            Target::LookAt => camera.target = vector - self.origin,
            Target::Up => camera.up = vector.try_normalize().unwrap_or(camera.up),
            Target::Lens => camera.fov_y = number.to_radians(),
            Target::Exposure => scene.exposure = number,
            Target::Position(light) => match &mut lights[light].kind {
                LightKind::Spot { position, .. } | LightKind::Point { position } => {
                    *position = vector - self.origin;
                }
                LightKind::Directional { .. } => {}
            },
            Target::Direction(light) => {
                match &mut lights[light].kind {
                    LightKind::Directional { direction } | LightKind::Spot { direction, .. } => {
                        *direction = vector.try_normalize().unwrap_or(*direction);
                    }
                    LightKind::Point { .. } => {}
                }
                // A light whose direction passes the vertical keeps the orientation that it has just after.
                let soon = self.track.at(seconds + SOON).truncate();
                let toward = if Source::is_upright(vector) { soon } else { vector };
                if let Some(Source::Disc { direction, .. } | Source::Rect { direction, .. }) =
                    &mut lights[light].source
                {
                    *direction = toward.try_normalize().unwrap_or(*direction);
                }
            }
            Target::Color(light) => lights[light].color = vector,
            Target::Intensity(light) => lights[light].intensity = number,
            Target::Angle(light) => {
                if let LightKind::Spot { angle, .. } = &mut lights[light].kind {
                    *angle = number.to_radians();
                }
            }
            Target::Tint(material) => {
                materials[material].tint = vector.extend(value.w.min(1.0));
            }
            Target::Emission(material) => materials[material].emission = vector,
            Target::Reflectivity(material) => materials[material].reflectivity = number,
            Target::Cutoff(material) => materials[material].cutoff = number,
            Target::Transmission(material) => materials[material].transmission = number,
            Target::Roughness(material) => materials[material].roughness = number,
            Target::Metallic(material) => materials[material].metallic = number,
            Target::Scattering | Target::Extinction => {
                if let Some(air) = &mut scene.air {
                    let is_scattering = self.target == Target::Scattering;
                    *(if is_scattering { &mut air.scattering } else { &mut air.extinction }) =
                        vector;
                }
            }
        }
    }

    fn span(&self) -> Option<[f64; 2]> {
        let times = self.track.times();
        Some([times[0], times[times.len() - 1]].map(f64::from))
    }

    fn steer(&self, scene: &mut Scene, seconds: f64) {
        self.apply(scene, seconds);
    }

    fn moved(&self, by: Vec3) -> Option<Arc<dyn Motion>> {
        Some(Arc::new(Self { origin: self.origin - by, ..self.clone() }))
    }
}

/// A table being checked.
struct Check<'a> {
    source: &'a SceneText<'a>,
    table: &'a Spanned<AnimateTable>,
}

impl Check<'_> {
    fn fault(&self, key: &str, message: impl Into<String>, help: &str) -> SceneError {
        self.source.error_at(&self.table.span(), key, message, help)
    }
}

/// Motions of the scene from the keys of a scene file's tables; those of one shape or mesh become one
/// motion. Returns the parts that do not move.
pub(super) fn animate(
    source: &SceneText<'_>,
    document: &Document,
    placed: Vec<Placed>,
    scene: &mut Scene,
) -> Result<Vec<Moving>, SceneError> {
    let names = Names::new(&placed);
    let mut placed = placed;
    let mut seen = HashMap::new();
    for table in &document.animate {
        let check = Check { source, table };
        let target = &table.get_ref().target;
        if seen.insert(target.clone(), ()).is_some() {
            let message = format!("a second table moves {}", quoted(target));
            return Err(check.fault("target", message, "put all keys into one table"));
        }
        let parts: Vec<&str> = target.split('.').collect();
        let kind = PLACED.into_iter().find(|kind| parts.first() == Some(kind));
        match (kind, &parts[..]) {
            (Some(kind), [_, name, field]) => {
                place(&check, kind, name, field, &names, &mut placed)?;
            }
            _ => {
                let target = find(&check, &parts, scene)?;
                let KeyFormat { count, range } = target.kind(scene);
                let track = track(&check, count, &range)?;
                scene.motions.push(Arc::new(Keyed { target, track, range, origin: Vec3::ZERO }));
            }
        }
    }
    let mut still = Vec::new();
    for moving in placed.into_iter().filter_map(|placed| placed.moving) {
        if moving.placement.moves() || moving.rig.moves() {
            scene.motions.push(Arc::new(moving));
        } else if moving.far > 0 {
            *scene.skipped.entry("triangle not finite").or_default() += moving.far;
        } else {
            still.push(moving);
        }
    }
    scene.set_time(0.0);
    Ok(still)
}

/// Indices in a list of [`Placed`].
#[derive(Default)]
struct Names {
    named: HashMap<(&'static str, String), usize>,
    /// Indices of each kind, in order.
    numbered: HashMap<&'static str, Vec<usize>>,
}

impl Names {
    fn new(placed: &[Placed]) -> Self {
        let mut names = Self::default();
        for (i, Placed { kind, name, .. }) in placed.iter().enumerate() {
            names.numbered.entry(kind).or_default().push(i);
            if let Some(name) = name {
                names.named.insert((kind, name.clone()), i);
            }
        }
        names
    }

    /// Index of the entry with this name, or else with this number.
    fn find(&self, kind: &'static str, name: &str) -> Option<usize> {
        let by_number = || self.numbered.get(kind)?.get(name.parse::<usize>().ok()?);
        self.named.get(&(kind, name.to_owned())).or_else(by_number).copied()
    }
}

/// Adds the keys of a shape or mesh.
fn place(
    check: &Check<'_>,
    kind: &'static str,
    name: &str,
    field: &str,
    names: &Names,
    placed: &mut [Placed],
) -> Result<(), SceneError> {
    let Some(index) = names.find(kind, name) else {
        let of_kind = placed.iter().filter(|placed| placed.kind == kind);
        let known = of_kind.filter_map(|placed| placed.name.as_deref());
        let help = nearest(name, known).filter(|help| help.contains('`'));
        let help = help.unwrap_or_else(|| format!("give a [[{kind}]] a name, or use its number"));
        return Err(check.fault("target", format!("there is no {kind} {}", quoted(name)), &help));
    };
    let Some(moving) = &mut placed[index].moving else {
        let message = "a displaced sphere cannot be moved";
        return Err(check.fault("target", message, "remove `displace`, or use its `drift`"));
    };
    let Placement { translation, rotation, scale } = &mut moving.placement;
    let channel = match field {
        "translation" => translation,
        "rotation" => rotation,
        "scale" => scale,
        _ => return Err(no_value(check, field, PLACE)),
    };
    let track = track(check, 3, &(-FARTHEST..=FARTHEST))?;
    let has_zero = |key: &Vec<f32>| key.contains(&0.0);
    if field == "scale" && check.table.get_ref().values.iter().any(|key| has_zero(&key.values)) {
        let help = "use a small number to flatten a shape";
        return Err(check.fault("values", "scale has a 0", help));
    }
    *channel = Channel::Moving(track);
    Ok(())
}

/// Track of keys with `count` numbers each, in `range`.
fn track(
    check: &Check<'_>,
    count: usize,
    range: &RangeInclusive<f32>,
) -> Result<Track, SceneError> {
    let AnimateTable { times, values, mode, .. } = check.table.get_ref();
    if times.is_empty() || times.len() != values.len() {
        let message = format!("{} times and {} values", times.len(), values.len());
        return Err(check.fault("values", message, "give a value for each time, one at least"));
    }
    if !times.iter().all(|time| time.is_finite()) || !times.is_sorted_by(|a, b| a < b) {
        let message = "times that do not ascend";
        return Err(check.fault("times", message, "write them in order, each once [s]"));
    }
    let mut keys = Vec::with_capacity(values.len());
    for key in values {
        let key = match key.values[..] {
            // A single number is that of all channels.
            [all] if count == 3 && *range.end() == 1e3 => vec![all; 3],
            _ => key.values.clone(),
        };
        if key.len() != count {
            let message = format!("a value of {} numbers", key.len());
            return Err(check.fault("values", message, &format!("each value has {count} here")));
        }
        if let Some(v) = key.iter().find(|v| !v.is_finite() || !range.contains(v)) {
            let help = format!("values must be from {:?} to {:?}", range.start(), range.end());
            return Err(check.fault("values", format!("values is {v}"), &help));
        }
        let part = |i: usize| key.get(i).copied().unwrap_or(0.0);
        keys.push(Vec4::new(part(0), part(1), part(2), part(3)));
    }
    if count == 4 && keys.iter().any(|key| key.w > 1.0) {
        let message = "alpha is above 1";
        return Err(check.fault("values", message, "alpha is from 0 to 1"));
    }
    let track = Track::new(times.clone(), keys, *mode);
    track.ok_or_else(|| check.fault("values", "keys that are not finite", "use finite numbers"))
}
