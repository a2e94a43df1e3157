//! What is blended at a pixel, laid over each other front to back, and the volumes between.
use glam::Vec3;

/// Panes that wait for what may lie before them.
const MAX_WAITING: usize = 2;

/// Panes of a segment whose scattered and mirrored light is seen; those behind only filter.
const MAX_LIT: usize = 2;

/// What a pane does to a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layer {
    pub depth: f32,
    /// Light that it emits.
    pub own: Vec3,
    /// Light that it scatters and mirrors.
    pub shown: Option<Vec3>,
    pub passed: Vec3,
    pub face: Option<Face>,
}

/// A pixel while layers are laid over it: light `L` behind becomes `color + passed * L`.
#[derive(Clone, Debug)]
pub(super) struct Pixel {
    pub color: Vec3,
    pub passed: Vec3,
    pub waiting: Vec<Layer>,
    /// Panes that were shown.
    pub lit: usize,
    pub fog: Fog,
}

/// Volumes along the eye's ray, between the layers of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fog {
    /// Absorption where the ray is [1/m].
    pub inside: Vec3,
    /// Light depth so far.
    pub reached: f32,
    /// Of the ray, per light depth.
    pub metres: f32,
    /// The walk starts at the eye and ends at the surface.
    pub whole: bool,
}

/// A face of a volume.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// [1/m]
    pub absorption: Vec3,
    pub leaves: bool,
}

impl Fog {
    pub(super) const NONE: Self =
        Self { inside: Vec3::ZERO, reached: 0.0, metres: 0.0, whole: false };

    /// What passes from where the ray was to light depth `depth`.
    pub(super) fn to(&mut self, depth: f32) -> Vec3 {
        let length = (depth - self.reached).max(0.0) * self.metres;
        self.reached = self.reached.max(depth);
        (-self.inside * length).map(f32::exp)
    }

    /// Past a face: what it takes from what is behind.
    fn cross(&mut self, face: &Face, depth: f32) -> Vec3 {
        if !face.leaves {
            self.inside += face.absorption;
            return Vec3::ONE;
        }
        if self.inside.cmpge(face.absorption * 0.999).all() {
            self.inside = (self.inside - face.absorption).max(Vec3::ZERO);
            return Vec3::ONE;
        }
        // The eye is inside what was not entered.
        let way = if self.whole { depth * self.metres } else { 0.0 };
        (-face.absorption * way).map(f32::exp)
    }
}

impl Pixel {
    pub(super) const CLEAR: Self =
        Self { color: Vec3::ZERO, passed: Vec3::ONE, waiting: Vec::new(), lit: 0, fog: Fog::NONE };

    pub(super) fn lay(&mut self, own: Vec3, passed: Vec3) {
        self.color += self.passed * own;
        self.passed *= passed;
    }

    fn lay_pane(&mut self, layer: &Layer) {
        self.passed *= self.fog.to(layer.depth);
        let shown = layer.shown.filter(|_| self.lit < MAX_LIT);
        self.lit += usize::from(shown.is_some());
        self.lay(layer.own + shown.unwrap_or(Vec3::ZERO), layer.passed);
        if let Some(face) = &layer.face {
            self.passed *= self.fog.cross(face, layer.depth);
        }
    }

    /// The panes before `depth`, nearest first.
    pub(super) fn lay_waiting(&mut self, depth: f32) {
        while self.waiting.first().is_some_and(|layer| layer.depth < depth) {
            let layer = self.waiting.remove(0);
            self.lay_pane(&layer);
        }
    }

    pub(super) fn wait(&mut self, layer: Layer) {
        let place = self.waiting.partition_point(|other| other.depth < layer.depth);
        self.waiting.insert(place, layer);
        if self.waiting.len() > MAX_WAITING {
            let nearest = self.waiting.remove(0);
            self.lay_pane(&nearest);
        }
    }
}
