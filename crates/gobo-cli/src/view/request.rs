//! Requests of the window to the renderer, and its answers.
use super::{inset::Inset, pick::Pick};
use eframe::egui::ColorImage;
use gobo::{Bounds, Camera, Counters, Light, Receiver, Scene, ShadowSettings, glam::Vec3};
use gobo_scene::LoadOptions;
use std::{collections::BTreeMap, path::PathBuf};

/// Time after which an animation without an end restarts [s].
const ENDLESS: f64 = 10.0;

/// Overrides of a scene file's values.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Look {
    pub(super) camera: Camera,
    /// Exposure [stops].
    pub(super) exposure: f32,
    pub(super) shadow: ShadowSettings,
    /// Lights that were changed, by index.
    pub(super) lights: BTreeMap<usize, Light>,
    /// Time of the animation [s].
    pub(super) time: f64,
    /// Light whose maps are read back.
    pub(super) maps_of: Option<usize>,
    /// Whether both receivers are shown.
    pub(super) beside: bool,
    pub(super) pick: Option<Pick>,
}

impl Look {
    /// Receivers whose pictures are shown, from the left.
    pub(super) fn receivers(&self) -> Vec<Receiver> {
        match self.beside {
            true => vec![Receiver::Nearest, Receiver::Curve],
            false => vec![self.shadow.receiver],
        }
    }
}

/// Name for users.
pub(super) fn receiver_name(receiver: Receiver) -> &'static str {
    match receiver {
        Receiver::Nearest => "nearest depth",
        Receiver::Curve => "curve",
    }
}

/// Request for pictures; it replaces an earlier one that has not been started.
#[derive(Clone, Debug)]
pub(super) struct Wish {
    pub(super) file: PathBuf,
    pub(super) load: LoadOptions,
    /// Number of the reading: a new number makes the file be read again.
    pub(super) reading: u64,
    /// Overrides; none for the values of the file.
    pub(super) look: Option<Look>,
    /// Number that returns with the pictures.
    pub(super) number: u64,
}

/// Properties of a scene that the window needs.
#[derive(Clone, Debug)]
pub(super) struct Facts {
    pub(super) camera: Camera,
    pub(super) exposure: f32,
    pub(super) shadow: ShadowSettings,
    pub(super) lights: Vec<Light>,
    pub(super) bounds: Bounds,
    /// Last time of its animation [s], if part of it moves.
    pub(super) end: Option<f64>,
    pub(super) particles: usize,
    pub(super) triangles: usize,
    /// Remarks about the scene, a sentence each.
    pub(super) notes: Vec<String>,
}

impl Facts {
    pub(super) fn of(scene: &Scene) -> Self {
        let skipped = scene.skipped.iter().map(|(why, count)| format!("{count} left out: {why}"));
        let ends = scene.motions.iter().filter_map(|motion| motion.span());
        let end = ends.map(|[_, last]| last).filter(|&last| last > 0.0).reduce(f64::max);
        Self {
            camera: scene.camera,
            exposure: scene.exposure,
            shadow: scene.shadow,
            lights: scene.lights.clone(),
            bounds: scene.bounds(),
            end: (!scene.motions.is_empty()).then(|| end.unwrap_or(ENDLESS).min(1e6)),
            particles: scene.particles.len(),
            triangles: scene.triangles.len(),
            notes: scene.notes.iter().cloned().chain(skipped).collect(),
        }
    }
}

/// Pictures of a moment, and their costs.
#[derive(Clone)]
pub(super) struct Shown {
    pub(super) number: u64,
    pub(super) camera: Camera,
    /// One of each receiver, from the left.
    pub(super) pictures: Vec<(Receiver, ColorImage)>,
    pub(super) insets: Vec<Inset>,
    pub(super) counters: Counters,
    /// Time of each stage [ms].
    pub(super) stages: Vec<(&'static str, f64)>,
    /// Memory on the devices [bytes].
    pub(super) memory: u64,
    /// Time from the request to the pictures [ms].
    pub(super) ms: f64,
    /// Surface and light at the picked pixel, if one is picked.
    pub(super) picked: Option<Picked>,
}

/// Surface and light at a picked pixel; without a surface, nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Picked {
    /// Position of its opaque surface, less the scene's origin and in the world [m].
    pub(super) surface: Option<[Vec3; 2]>,
    /// Share of each light that reaches it, for each receiver from the left.
    pub(super) shares: Vec<Vec<[f32; 3]>>,
}

pub(super) enum News {
    Device(String),
    Read {
        reading: u64,
        facts: Box<Facts>,
    },
    /// The file cannot be read; the last scene stays.
    Unread {
        reading: u64,
        text: String,
    },
    /// Kernels left to compile, their total number, and the one being compiled.
    Kernels {
        left: usize,
        of: usize,
        name: &'static str,
    },
    Shown(Box<Shown>),
    Problem {
        number: u64,
        text: String,
    },
}
