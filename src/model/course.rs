//! Course of a moving scene: the values that all its frames share, so that no part at rest changes with one
//! that moves. They are the extent of all motion, and lights and camera at a few moments.
//!
//! It follows from the scene alone, not from the frames that are rendered: a single frame is the same as in a
//! sequence.
use super::{Bounds, Camera, Light, Motion, Scene, ShadowSettings, View};
use glam::Vec3;
use std::sync::{Arc, Mutex, PoisonError};

/// Moments between a scene's first key and its last.
const MOMENTS: u32 = 8;
/// Ratio of the scene's largest extent to that at its start, past which views follow it from frame to frame.
const WIDEST: f32 = 4.0;
/// Margin around a moving part's box, as a share of the box that was sampled.
const MARGIN: f32 = 1.0 / 16.0;

/// Extent of a moving scene over all frames, and its lights and camera at a few moments: the views of all
/// frames follow from it.
#[derive(Clone, Debug)]
pub struct Course {
    /// Box around all moving parts, in all frames \[m\].
    all: Bounds,
    /// Box around those parts that cast shadows \[m\].
    casters: Bounds,
    moments: Vec<Moment>,
    /// Triangles, lights, splats and strands of the scene that it was made for.
    counts: [usize; 4],
    /// Windows that were chosen last.
    windows: Arc<Mutex<Option<Windows>>>,
}

/// Lights and camera at a time.
#[derive(Clone, Debug)]
pub(crate) struct Moment {
    /// From the start \[s\].
    pub seconds: f64,
    pub camera: Camera,
    pub lights: Vec<Light>,
}

/// Windows of finer texels, and the key that they were chosen for.
#[derive(Clone, Debug)]
struct Windows {
    key: WindowsKey,
    of_lights: Vec<Vec<View>>,
}

/// Inputs that [`Scene::kept_windows`] are chosen by, besides the course.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WindowsKey {
    /// Views that they refine.
    pub bases: Vec<View>,
    /// The camera, if it stands still.
    pub camera: Option<Camera>,
    pub shadow: ShadowSettings,
}

impl Default for Course {
    /// The course of a scene at rest.
    fn default() -> Self {
        Self {
            all: Bounds::EMPTY,
            casters: Bounds::EMPTY,
            moments: Vec::new(),
            counts: [0; 4],
            windows: Arc::default(),
        }
    }
}

impl Course {
    /// Whether the camera moves.
    pub(crate) fn moves_camera(&self) -> bool {
        self.differs(|moment| moment.camera)
    }

    /// Whether a light moves or turns.
    pub(crate) fn moves_light(&self, index: usize) -> bool {
        self.differs(|moment| moment.lights.get(index).map(|light| light.kind))
    }

    /// Whether a light moves, or changes in another way.
    pub(crate) fn changes_light(&self, index: usize) -> bool {
        self.differs(|moment| moment.lights.get(index))
    }

    fn differs<'a, T: PartialEq>(&'a self, of: impl Fn(&'a Moment) -> T) -> bool {
        self.moments.windows(2).any(|pair| of(&pair[0]) != of(&pair[1]))
    }
}

impl Scene {
    /// Box that views are fitted to besides the scene's present contents \[m\].
    pub(crate) fn held(&self) -> Bounds {
        self.around.with(&self.course.all)
    }

    /// The same for casters \[m\].
    pub(crate) fn held_casters(&self) -> Bounds {
        self.around.with(&self.course.casters)
    }

    /// Moments of a scene that still has the parts it was loaded with; none otherwise, or if no light,
    /// triangle or camera moves.
    pub(crate) fn moments(&self) -> &[Moment] {
        let is_same = self.course.counts == self.counts() && !self.motions.is_empty();
        if is_same { &self.course.moments } else { &[] }
    }

    fn counts(&self) -> [usize; 4] {
        let moving = |motion: &Arc<dyn Motion>| motion.first_particle().is_some();
        // Trails come and go.
        let strands = if self.motions.iter().any(moving) { 0 } else { self.strands.len() };
        [self.triangles.len(), self.lights.len(), self.gaussians.len(), strands]
    }

    /// Makes [`Self::course`] for the scene's motions. The scene must be at its start.
    pub fn follow_motions(&mut self) {
        self.course = Course::default();
        let motions = self.motions.clone();
        if motions.is_empty() {
            return;
        }
        let reach = |wanted: &dyn Fn(u32) -> bool| {
            let reaches = motions.iter().map(|motion| motion.reach(wanted));
            let all = reaches.fold(Bounds::EMPTY, |all, reach| all.with(&reach));
            let margin = (all.max - all.min).max(Vec3::ZERO) * MARGIN;
            Bounds { min: all.min - margin, max: all.max + margin }
        };
        let casts = |material: u32| self.materials[material as usize].casts;
        let casters = reach(&casts);
        let all = casters.with(&reach(&|material| !casts(material)));
        let start = self.bounds();
        let is_held = all.is_finite()
            && !start.is_empty()
            && start.with(&all).radius() <= WIDEST * start.radius();
        if is_held {
            (self.course.all, self.course.casters) = (all, casters);
        }
        self.course.counts = self.counts();
        let spans = motions.iter().filter_map(|motion| motion.span());
        let Some([first, last]) =
            spans.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).map(|s| s.map(|t| t.max(0.0)))
        else {
            return;
        };
        let skipped = self.skipped.clone();
        let mut steered_to = |seconds: f64| {
            motions.iter().for_each(|motion| motion.steer(self, seconds));
            Moment { seconds, camera: self.camera, lights: self.lights.clone() }
        };
        let time = |i: u32| first + (last - first) * f64::from(i) / f64::from(MOMENTS - 1);
        let count = if last > first { MOMENTS } else { 1 };
        let moments = (0..count).map(|i| steered_to(time(i))).collect();
        steered_to(0.0);
        (self.course.moments, self.skipped) = (moments, skipped);
    }

    /// The scene reduced to triangles, lights, camera and the motions that move them, to be set to
    /// [`Self::moments`].
    pub(crate) fn solids(&self) -> Self {
        let motions = self.motions.iter().filter(|motion| motion.span().is_some());
        let moves_particles = motions.clone().any(|motion| motion.moves_particles());
        let (mut gaussians, mut strands) = (Vec::new(), Vec::new());
        if moves_particles {
            (gaussians, strands) = (self.gaussians.clone(), self.strands.clone());
        }
        Self {
            camera: self.camera,
            shadow: self.shadow,
            lights: self.lights.clone(),
            materials: self.materials.clone(),
            triangles: self.triangles.clone(),
            gaussians,
            strands,
            around: self.bounds(),
            air: self.air,
            motions: motions.cloned().collect(),
            ..Self::default()
        }
    }

    /// The windows of lights that `choose` chose for the same key before, or chooses now.
    pub(crate) fn kept_windows(
        &self,
        key: WindowsKey,
        choose: impl FnOnce() -> Vec<Vec<View>>,
    ) -> Vec<Vec<View>> {
        let mut kept = self.course.windows.lock().unwrap_or_else(PoisonError::into_inner);
        let windows = kept.take().filter(|kept| kept.key == key);
        let windows = windows.unwrap_or_else(|| Windows { key, of_lights: choose() });
        kept.insert(windows).of_lights.clone()
    }
}
