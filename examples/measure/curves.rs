//! Figures of the curves: those in `docs/curves.md`, checked by the tests.
use crate::{
    moments::Moments,
    rivals::{Fourier, Hit, exact, nearest},
};
use gobo::{glam::Vec3, records::curve::light_at};
use gobo_reference::curve::{
    Streaming,
    two_walks::{self, RayHit, RayModes},
};
use gobo_scene::generate::Chance;

/// A seeded kind of texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rays {
    /// 50 to 400 faint hits whose density and colour change along the ray.
    Smoke,
    /// 2 to 14 strong hits.
    Panes,
    /// 3 to 6 separate puffs: 10 to 60 faint hits each, close together.
    Puffs,
}

impl Rays {
    pub(crate) const ALL: [Self; 3] = [Self::Smoke, Self::Panes, Self::Puffs];

    /// Whether the hits may be of soft discs alone; no pairs of these are joined by cost.
    const fn are_discs(self) -> bool {
        matches!(self, Self::Smoke | Self::Puffs)
    }

    fn hits(self, chance: &mut Chance) -> Vec<Hit> {
        let mut hits = match self {
            Self::Smoke => smoke(chance),
            Self::Panes => {
                let count = chance.within(2.0, 15.0) as u32;
                let pane = |_| {
                    let color = color(chance, 1.0);
                    (chance.within(0.05, 0.95), filter(chance.within(0.85, 1.0), color))
                };
                (0..count).map(pane).collect()
            }
            Self::Puffs => {
                let count = chance.within(3.0, 7.0) as u32;
                (0..count).flat_map(|_| puff(chance)).collect()
            }
        };
        hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        hits
    }
}

fn filter(opacity: f32, color: Vec3) -> Vec3 {
    Vec3::ONE - opacity * (Vec3::ONE - color)
}

fn color(chance: &mut Chance, most: f32) -> Vec3 {
    Vec3::from_array([0; 3].map(|_| chance.within(0.0, most)))
}

/// Approximate full turn [radians]; the page's figures belong to these digits.
const WHOLE_TURN: f32 = 628.0 / 100.0;

fn smoke(chance: &mut Chance) -> Vec<Hit> {
    let count = chance.within(50.0, 401.0) as usize;
    let opacity = chance.within(0.01, 0.04);
    let (first, last) = (color(chance, 0.9), color(chance, 0.9));
    let (low, high) = (chance.within(0.05, 0.3), chance.within(0.6, 0.95));
    let (waves, phase) = (chance.within(1.0, 4.0), chance.within(0.0, WHOLE_TURN));
    let mut hits = Vec::new();
    while hits.len() < count {
        let along = chance.within(0.0, 1.0);
        let density = 0.55 + 0.45 * (waves * std::f32::consts::TAU * along + phase).sin();
        if chance.within(0.0, 1.0) < density {
            let profile = chance.within(0.0, 1.0).powi(2) * 2.0;
            let light = filter(opacity * profile, first.lerp(last, along));
            hits.push((low + (high - low) * along, light));
        }
    }
    hits
}

fn puff(chance: &mut Chance) -> Vec<Hit> {
    let (middle, half) = (chance.within(0.1, 0.9), chance.within(0.01, 0.03));
    let color = color(chance, 0.9);
    let (count, opacity) = (chance.within(10.0, 60.0) as u32, chance.within(0.005, 0.04));
    let hit = |_| {
        // Approximately normal, cut at 1.5.
        let sum: f32 = (0..12).map(|_| chance.within(-0.5, 0.5)).sum();
        (middle + half * (0.6 * sum).clamp(-1.5, 1.5), filter(opacity, color))
    };
    (0..count).map(hit).collect()
}

/// Representation of a texel's hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    Nearest,
    /// A curve with K nodes.
    Curve(u32),
    /// A curve with K nodes by two walks.
    TwoWalks(u32),
    /// Fourier opacity map, 15 coefficients a channel.
    Fourier,
    /// Moment map, 4 moments a channel and its total.
    Moments,
}

impl Method {
    pub(crate) const ALL: [Self; 9] = [
        Self::Nearest,
        Self::Curve(4),
        Self::Curve(8),
        Self::Curve(16),
        Self::TwoWalks(4),
        Self::TwoWalks(8),
        Self::TwoWalks(16),
        Self::Fourier,
        Self::Moments,
    ];

    pub(crate) fn name(self) -> String {
        match self {
            Self::Nearest => "nearest depth".to_owned(),
            Self::Curve(nodes) => format!("curve, K = {nodes}"),
            Self::TwoWalks(nodes) => format!("curve, K = {nodes}, by two walks"),
            Self::Fourier => "Fourier, 15 coefficients".to_owned(),
            Self::Moments => "4 moments".to_owned(),
        }
    }

    /// Memory of a map [bytes per texel], with F as rgba16float and D as r32float.
    pub(crate) fn bytes(self) -> u32 {
        match self {
            Self::Nearest => 12,
            Self::Curve(nodes) | Self::TwoWalks(nodes) => 12 + 8 * nodes,
            // Stored as 16-bit floats.
            Self::Fourier => 3 * 15 * 2,
            Self::Moments => 3 * 5 * 4,
        }
    }
}

/// Error against the exact product, over texels, depths and channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CurveError {
    pub(crate) mean: f32,
    /// 99th percentile of the errors.
    pub(crate) high: f32,
    pub(crate) max: f32,
}

const TEXELS: usize = 150;
const DEPTHS: u32 = 400;

/// Seeded texels of one kind, and their exact light at every depth.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    rays: Rays,
    texels: Vec<(Vec<Hit>, Vec<Vec3>)>,
}

fn depths() -> impl Iterator<Item = f32> {
    (0..DEPTHS).map(|i| (i as f32 + 0.5) / DEPTHS as f32)
}

impl Sample {
    pub(crate) fn new(rays: Rays) -> Self {
        let mut chance = Chance::new(5);
        let texel = |_| {
            let hits = rays.hits(&mut chance);
            let light = depths().map(|z| exact(&hits, z)).collect();
            (hits, light)
        };
        Self { rays, texels: (0..TEXELS).map(texel).collect() }
    }

    /// Number of hits of all texels.
    pub(crate) fn hit_count(&self) -> usize {
        self.texels.iter().map(|(hits, _)| hits.len()).sum()
    }

    pub(crate) fn error(&self, method: Method) -> CurveError {
        let mut errors = Vec::new();
        for (hits, expected) in &self.texels {
            let light = light_of(method, self.rays, hits);
            for (z, expected) in depths().zip(expected) {
                errors.extend((light(z) - *expected).abs().to_array());
            }
        }
        errors.sort_by(f32::total_cmp);
        let mean = errors.iter().copied().map(f64::from).sum::<f64>() / errors.len() as f64;
        let high = errors[errors.len() / 100 * 99];
        CurveError { mean: mean as f32, high, max: errors[errors.len() - 1] }
    }

    /// Makes every texel's curve, to measure the time.
    pub(crate) fn build(&self, method: Method) -> f32 {
        self.texels.iter().map(|(hits, _)| light_of(method, self.rays, hits)(0.5).x).sum()
    }
}

fn light_of(method: Method, rays: Rays, hits: &[Hit]) -> Box<dyn Fn(f32) -> Vec3 + '_> {
    match method {
        Method::Nearest => Box::new(|z| nearest(hits, z)),
        Method::Curve(nodes) => {
            let mut curve = Streaming::new(nodes, false);
            for &(depth, light) in hits {
                curve.insert(depth, depth, light);
            }
            packed(&curve)
        }
        Method::TwoWalks(nodes) => {
            let point = |&(depth, light): &Hit| {
                let absorbed = Vec3::ONE - light;
                RayHit { start: depth, end: depth, absorbed, presence: absorbed.max_element() }
            };
            let hits: Vec<_> = hits.iter().map(point).collect();
            let few = !rays.are_discs();
            let modes = RayModes { nodes, few, faint: false, grows: false, bodies: None };
            let (nodes, _) = two_walks::curve(&hits, modes);
            Box::new(move |z| light_at(&nodes, z, false))
        }
        Method::Fourier => {
            let map = Fourier::new(hits);
            Box::new(move |z| map.light_at(z))
        }
        Method::Moments => {
            let map = Moments::new(hits, 4);
            Box::new(move |z| map.light_at(z))
        }
    }
}

fn packed(curve: &Streaming) -> Box<dyn Fn(f32) -> Vec3> {
    let nodes: Vec<_> = curve.pack().collect();
    Box::new(move |z| light_at(&nodes, z, false))
}
