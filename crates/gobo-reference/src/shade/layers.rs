//! Layers of a pixel, blended front to back, and the volumes between them.
use crate::{
    coplanar::is_in_front,
    refraction::{GlassFace, Ray},
};
use glam::Vec3;

/// Panes that wait for nearer ones.
const MAX_WAITING: usize = 2;

/// Panes whose scattered and mirrored light is evaluated; those behind only filter.
const MAX_LIT: usize = 2;

/// A pane's effect on a pixel. `P`: the point at which its light is evaluated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layer<P> {
    pub depth: f32,
    /// Id of its object.
    pub object: u32,
    /// Emitted light.
    pub sent: Vec3,
    pub passed: Vec3,
    pub face: Option<Face>,
    /// Refraction of a pane that displaces or blurs its background.
    pub glass: Option<GlassFace>,
    /// `None` for a layer that only emits.
    pub pane: Option<P>,
}

/// A pixel during blending: light `L` from behind becomes `color + passed * L`.
#[derive(Clone, Debug)]
pub(super) struct Pixel<P> {
    pub color: Vec3,
    pub passed: Vec3,
    pub waiting: Vec<Layer<P>>,
    /// The nearest panes, each with the transmittance in front of it.
    pub lit: Vec<(P, Vec3)>,
    pub fog: Fog,
    pub ray: Ray,
    /// Light depth of the nearest pane, if any.
    pub nearest: Option<f32>,
}

/// Volumes along the eye's ray, between the layers of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fog {
    /// Absorption coefficient at the ray's present depth [1/m].
    inside: Vec3,
    /// Light depth reached so far.
    reached: f32,
    /// Length of the ray per unit of light depth \[m\].
    metres: f32,
}

/// A face of a volume.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// Absorption coefficient of the volume [1/m].
    pub absorption: Vec3,
    pub leaves: bool,
}

impl Fog {
    pub(super) fn new(metres: f32) -> Self {
        Self { inside: Vec3::ZERO, reached: 0.0, metres }
    }

    /// Advances to light depth `depth`; returns the transmittance of the path.
    pub(super) fn to(&mut self, depth: f32) -> Vec3 {
        let length = (depth - self.reached).max(0.0) * self.metres;
        self.reached = self.reached.max(depth);
        (-self.inside * length).map(f32::exp)
    }

    /// Crosses a face; returns its transmittance for the light behind.
    fn cross(&mut self, face: &Face, depth: f32) -> Vec3 {
        if !face.leaves {
            self.inside += face.absorption;
            return Vec3::ONE;
        }
        if self.inside.cmpge(face.absorption * 0.999).all() {
            self.inside = (self.inside - face.absorption).max(Vec3::ZERO);
            return Vec3::ONE;
        }
        // The eye is inside a volume that was not entered.
        (-face.absorption * depth * self.metres).map(f32::exp)
    }
}

impl<P: Copy> Pixel<P> {
    /// An empty pixel; `metres`: length of the ray per unit of light depth \[m\].
    pub(super) fn empty(metres: f32) -> Self {
        let (color, passed) = (Vec3::ZERO, Vec3::ONE);
        Self {
            color,
            passed,
            waiting: Vec::new(),
            lit: Vec::new(),
            fog: Fog::new(metres),
            ray: Ray::default(),
            nearest: None,
        }
    }

    pub(super) fn lay(&mut self, sent: Vec3, passed: Vec3) {
        self.color += self.passed * sent;
        self.passed *= passed;
    }

    fn lay_pane(&mut self, layer: &Layer<P>) {
        self.passed *= self.fog.to(layer.depth);
        if let Some(pane) = layer.pane.filter(|_| self.lit.len() < MAX_LIT) {
            self.lit.push((pane, self.passed));
            self.nearest = self.nearest.or(Some(layer.depth));
        }
        if let Some(glass) = &layer.glass {
            self.ray.cross(glass, layer.depth);
        }
        self.lay(layer.sent, layer.passed);
        if let Some(face) = &layer.face {
            self.passed *= self.fog.cross(face, layer.depth);
        }
    }

    /// Blends the panes in front of `depth`, nearest first.
    pub(super) fn lay_waiting(&mut self, depth: f32) {
        while self.waiting.first().is_some_and(|layer| layer.depth < depth) {
            let layer = self.waiting.remove(0);
            self.lay_pane(&layer);
        }
    }

    pub(super) fn wait(&mut self, layer: Layer<P>) {
        let is_behind = |other: &Layer<P>| {
            !is_in_front((other.depth, Some(other.object)), (layer.depth, Some(layer.object)))
        };
        let index = self.waiting.iter().position(is_behind).unwrap_or(self.waiting.len());
        self.waiting.insert(index, layer);
        if self.waiting.len() > MAX_WAITING {
            let nearest = self.waiting.remove(0);
            self.lay_pane(&nearest);
        }
    }
}
