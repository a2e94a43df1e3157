//! A scene, and its state beside the library's.
use crate::{
    fault::Fault,
    tables::{only, scene_of},
};
use gobo::{Material, Shape, glam::DVec3, model::Skipped};
use gobo_scene::{Limit, Scene};
use std::collections::HashMap;
use toml::{Table, Value};

/// A material: one of the scene's, by name, or a table with an image of the scene.
#[derive(Clone, Debug)]
pub(crate) enum Wanted {
    Named(String),
    Made { table: Table, texture: Option<u32> },
}

/// Contents of a scene.
#[derive(Debug)]
pub(crate) struct State {
    pub(crate) scene: Scene,
    /// World position of the origin of the library's scene [m]. The library's own origin is 0: its points
    /// have 32 bits.
    pub(crate) origin: DVec3,
    /// Whether the camera was placed.
    pub(crate) has_camera: bool,
    /// Time of the scene, if it was set [s].
    pub(crate) seconds: f64,
    /// Id of the next caster.
    next_id: u32,
    /// Materials by the tables that they were made from.
    made: HashMap<String, u32>,
}

impl State {
    pub(crate) fn new(scene: Scene, origin: DVec3) -> Self {
        Self { scene, origin, has_camera: false, seconds: 0.0, next_id: 0, made: HashMap::new() }
    }

    pub(crate) fn loaded(mut scene: Scene) -> Self {
        let origin = std::mem::take(&mut scene.origin).as_dvec3();
        // Ids of casters from files are unknown; only dither patterns depend on them.
        let next_id = 1 << 31;
        Self { has_camera: true, next_id, ..Self::new(scene, origin) }
    }

    /// First of the ids of `count` casters.
    pub(crate) fn ids(&mut self, count: usize) -> u32 {
        let first = self.next_id;
        self.next_id = first.wrapping_add(count as u32);
        first
    }

    /// Counts inputs that were left out.
    pub(crate) fn skip(&mut self, skipped: Skipped) {
        for (reason, count) in skipped {
            *self.scene.skipped.entry(reason).or_default() += count;
        }
    }

    /// Index of a material. `change` adapts it to its casters, and has a name.
    pub(crate) fn material(
        &mut self,
        wanted: &Wanted,
        (kind, change): (&str, &dyn Fn(Material) -> Material),
    ) -> Result<u32, Fault> {
        let (key, material) = match wanted {
            Wanted::Named(name) => {
                let all = &self.scene.materials;
                let Some(index) = all.iter().rposition(|material| material.name == *name) else {
                    let message = format!("no material is named {name:?}");
                    return Err(Fault::input(message, "give a dictionary with its keys"));
                };
                let material = all[index].clone();
                if change(material.clone()) == material {
                    return Ok(index as u32);
                }
                (format!("{kind} {index}"), Ok(material))
            }
            Wanted::Made { table, texture } => {
                (format!("{kind} {texture:?} {table}"), Err((table, *texture)))
            }
        };
        if let Some(&index) = self.made.get(&key) {
            return Ok(index);
        }
        let material = material.or_else(|(table, texture)| self.parsed(table, texture))?;
        check_limit(Limit::Materials, self.scene.materials.len(), 1)?;
        let index = self.scene.materials.len() as u32;
        self.scene.materials.push(change(material));
        self.made.insert(key, index);
        Ok(index)
    }

    /// The material of a table; its images are the scene's.
    fn parsed(&mut self, table: &Table, texture: Option<u32>) -> Result<Material, Fault> {
        let mut table = table.clone();
        table.entry("name").or_insert_with(|| Value::from("material"));
        let parsed = scene_of("material", &only("material", table))?;
        if !parsed.motions.is_empty() {
            let remedy = "leave its motion out, or load a scene file";
            return Err(Fault::input("material: its texture moves", remedy));
        }
        let Some(material) = parsed.materials.into_iter().next() else {
            return Err(Fault::input(
                "material: nothing was read",
                "use the keys of docs/scene.md",
            ));
        };
        let have = self.scene.textures.len();
        check_limit(Limit::Textures, have, parsed.textures.len())?;
        self.scene.textures.extend(parsed.textures);
        let moved = |index: Option<u32>| index.map(|index| index + have as u32);
        Ok(Material {
            texture: texture.or(moved(material.texture)),
            emissive_texture: moved(material.emissive_texture),
            ..material
        })
    }

    /// Refuses further particles after emitters: emitted particles must come after all others.
    pub(crate) fn check_no_emitters(&self) -> Result<(), Fault> {
        if self.scene.motions.iter().any(|motion| motion.moves_particles()) {
            let message = "the scene has emitters, whose particles come last";
            let remedy = "name the particles in the scene file, or load one without [[emitter]]";
            return Err(Fault::input(message, remedy));
        }
        Ok(())
    }

    /// Index of a light, by its name or number.
    pub(crate) fn light(&self, name: &LightName) -> Result<usize, Fault> {
        let lights = &self.scene.lights;
        let found = match name {
            LightName::Index(index) => {
                let count = lights.len() as i64;
                let index = if *index < 0 { index + count } else { *index };
                (0..count).contains(&index).then_some(index as usize)
            }
            LightName::Name(name) => lights.iter().position(|light| light.name == *name),
        };
        found.ok_or_else(|| {
            let names: Vec<_> = lights.iter().map(|light| light.name.as_str()).collect();
            let remedy = if names.is_empty() {
                "add one with add_light".to_owned()
            } else {
                format!("use an index, or one of {}", names.join(", "))
            };
            Fault::input(format!("there is no light {name}"), remedy)
        })
    }
}

/// Name of a light by the caller.
#[derive(Clone, Debug)]
pub(crate) enum LightName {
    Index(i64),
    Name(String),
}

impl std::fmt::Display for LightName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Index(index) => write!(f, "{index}"),
            Self::Name(name) => write!(f, "{name:?}"),
        }
    }
}

/// Whether a material is for particles.
pub(crate) fn check_shape(material: &Material) -> Result<(), Fault> {
    if matches!(material.shape, Shape::Disc | Shape::Quad | Shape::Puff) {
        return Ok(());
    }
    let message = format!("material {:?} is not for particles", material.name);
    Err(Fault::input(message, "give particles a material of their own"))
}

/// Checks that `have` + `more` items are within a limit.
pub(crate) fn check_limit(limit: Limit, have: usize, more: usize) -> Result<(), Fault> {
    let (all, most) = (have as u64 + more as u64, limit.most());
    if all <= most {
        return Ok(());
    }
    let message = format!("{all} {}, but a scene has at most {most}", limit.noun());
    Err(Fault::input(message, "use several scenes, or fewer and larger ones"))
}

/// Reserves memory for `more` items.
pub(crate) fn reserve<T>(items: &mut Vec<T>, more: usize) -> Result<(), Fault> {
    let bytes = (more as u64).saturating_mul(size_of::<T>() as u64);
    items.try_reserve(more).map_err(|_| Fault::Memory(bytes))
}
