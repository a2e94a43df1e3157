//! Penumbrae of a light with a size, from a small map of the triangles that its middle sees, a few layers
//! deep.
//!
//! From places that may be in a penumbra, rays go through the map to points of the light. Occluders in the
//! first opaque layer are in shadow maps, too; occluders and filters behind it are not.
use crate::{
    model::{Light, Material, Projection, Scene, Source, Transfer, View},
    view::{
        detail::{ShownPicture, TEXELS, source_axes},
        raster::{Layer, Layers, Nearest, Raster, SMALL_MAP},
    },
};
use glam::{DVec2, DVec3, IVec2, UVec2, Vec3};

/// Points of the light.
const POINTS: u32 = 16;
/// Share of the light that one of its points represents.
pub(super) const ONE_POINT: f64 = 1.0 / POINTS as f64;
/// Most steps of a ray.
const STEPS: u32 = 48;
/// Approximate number of places of a view that are sampled.
const ASKED: usize = 24_000;
/// Number of penumbrae that suffice to know their widths.
const ENOUGH: usize = 200;

/// A place that a part of a light reaches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Penumbra {
    /// Edge of the light's map that gives the penumbra enough texels, or texels no wider than a pixel
    /// \[texels\].
    pub(super) texels: f64,
    /// Difference between the light of the points behind hidden occluders and that of the points that the
    /// light's middle sees, as a share of the light.
    pub(super) hidden: f64,
}

/// Result over the sampled places.
#[derive(Clone, Debug, Default)]
pub(super) struct SeenPenumbrae {
    /// Number of places.
    pub(super) places: usize,
    /// Number of these places in penumbrae.
    pub(super) count: usize,
    /// Their penumbrae or, where they are few, further ones.
    pub(super) penumbrae: Vec<Penumbra>,
}

impl SeenPenumbrae {
    pub(super) fn add(&mut self, other: Self) {
        self.places += other.places;
        self.count += other.count;
        self.penumbrae.extend(other.penumbrae);
    }
}

/// A receiver of the small map.
struct Place {
    point: DVec3,
    normal: DVec3,
    /// Widest texel there that is narrow enough for the picture, on the light's plane; 0 if unknown.
    texel: f64,
}

/// Small map of the light's view.
struct SmallView<'a> {
    scene: &'a Scene,
    view: &'a View,
    raster: Raster,
    layers: Vec<Layers>,
    /// Points of the light, along x and down in the view \[m\]; for a sun, slopes.
    points: Vec<DVec2>,
    /// Half of the light's narrower side, in the same unit.
    half: f64,
    is_opaque: Vec<bool>,
    /// Transmittance of materials that are not opaque.
    passed: Vec<DVec3>,
}

/// Occluders between two depths of a texel, on the way to a point of the light.
struct Met {
    /// Depths \[m\] of an occluder that the light's middle sees, and of a hidden one.
    depths: [Option<f64>; 2],
    /// Transmittance of the filters.
    passed: DVec3,
    /// Whether a hidden occluder is opaque.
    is_dark: bool,
}

/// Penumbrae in a `view` from the middle of a `light`, at places of the picture or, without a picture, at all
/// places that the light may reach.
pub(super) fn penumbrae(
    scene: &Scene,
    light: &Light,
    view: &View,
    picture: Option<&ShownPicture<'_>>,
) -> SeenPenumbrae {
    let Some(source) = light.area() else { return SeenPenumbrae::default() };
    let map = SmallView::new(scene, view, &source);
    let nearest = map.layers.iter().map(|layers| f64::from(layers[0].depth));
    let first = nearest.fold(f64::INFINITY, f64::min);
    let places = picture.map_or_else(|| map.places(&|_| true), |picture| map.shown(picture));
    let of = |places: &[Place]| {
        places.iter().filter_map(|place| map.penumbra(place, first)).collect::<Vec<_>>()
    };
    let mut penumbrae = of(&places);
    let count = penumbrae.len();
    if count < ENOUGH && picture.is_none() {
        penumbrae = of(&map.places(&|at| map.is_edge(at)));
    }
    SeenPenumbrae { places: places.len(), count, penumbrae }
}

impl<'a> SmallView<'a> {
    fn new(scene: &'a Scene, view: &'a View, source: &Source) -> Self {
        let raster = Raster::new(view, UVec2::splat(SMALL_MAP));
        let casts = |material: &Material| material.casts && material.transfer != Transfer::None;
        let layers = raster.layers(scene, casts);
        let axes = source_axes(view, source);
        let is_rect = matches!(source, Source::Rect { .. });
        let points = (0..POINTS).map(|i| {
            let u = (f64::from(i) + 0.5) / f64::from(POINTS);
            let v = (f64::from(i) * 0.618_033_988_749_895).fract();
            // Half axes are those of a disc of the same variance.
            let at = if is_rect {
                (DVec2::new(u, v) - 0.5) * 12f64.sqrt()
            } else {
                DVec2::from_angle(v * std::f64::consts::TAU) * u.sqrt()
            };
            let on_light = axes[0] * at.x + axes[1] * at.y;
            DVec2::new(on_light.x, -on_light.y)
        });
        let of = |transfer: &Material| transfer.transfer.is_opaque();
        let passed = |material: &Material| {
            let [color, opacity] = [material.tint.truncate(), Vec3::splat(material.tint.w)];
            (1.0 - opacity * (1.0 - color)).as_dvec3().clamp(DVec3::ZERO, DVec3::ONE)
        };
        Self {
            scene,
            view,
            raster,
            layers,
            points: points.collect(),
            half: axes[0].length().min(axes[1].length()),
            is_opaque: scene.materials.iter().map(of).collect(),
            passed: scene.materials.iter().map(passed).collect(),
        }
    }

    /// Surfaces of the picture.
    fn shown(&self, picture: &ShownPicture<'_>) -> Vec<Place> {
        let count = picture.hits().count();
        let place = |hit: &Nearest| {
            let receiver = picture.receiver(hit, self.view)?;
            self.raster.texel_of(hit.point)?;
            Some(Place { point: hit.point, normal: receiver.normal, texel: receiver.seen.texel })
        };
        picture.hits().step_by(count / ASKED + 1).filter_map(place).collect()
    }

    /// Opaque surfaces that face the light, of some of the texels whose indices are `wanted`.
    fn places(&self, wanted: &dyn Fn(usize) -> bool) -> Vec<Place> {
        let all = (0..).zip(&self.layers).filter(|(at, _)| wanted(*at));
        let all = all.flat_map(|(at, layers)| layers.iter().map(move |layer| (at, layer)));
        let all: Vec<_> = all.filter(|(_, layer)| layer.is_front && self.stops(layer)).collect();
        let place = |(at, layer): (usize, &Layer)| {
            let corners = self.scene.triangles[layer.triangle as usize].positions;
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            Place { point: self.raster.point(at, layer.depth.into()), normal, texel: 0.0 }
        };
        let step = all.len() / ASKED + 1;
        all.into_iter().step_by(step).map(place).collect()
    }

    /// Whether a texel and its neighbours see different bodies.
    fn is_edge(&self, at: usize) -> bool {
        let edge = SMALL_MAP as usize;
        let around = [at.wrapping_sub(1), at + 1, at.wrapping_sub(edge), at + edge];
        let depth = |at: usize| self.layers.get(at).map(|layers| f64::from(layers[0].depth));
        let Some(own) = depth(at) else { return false };
        let [left, right, up, down] = around.map(|at| depth(at).unwrap_or(own));
        // The depths of a plane, or their reciprocals, are nearly linear.
        let bend = |a: f64, b: f64| (a - own - (own - b)).abs();
        let texel = f64::from(self.view.size.x) / f64::from(self.view.scale) / f64::from(SMALL_MAP);
        let spread = if self.view.projection == Projection::Perspective { own } else { 1.0 };
        bend(left, right).max(bend(up, down)) > texel * spread
    }

    fn stops(&self, layer: &Layer) -> bool {
        layer.depth.is_finite()
            && self.is_opaque[self.scene.triangles[layer.triangle as usize].material as usize]
    }

    /// `first`: nearest depth of the map \[m\].
    fn penumbra(&self, place: &Place, first: f64) -> Option<Penumbra> {
        let is_wide = self.view.projection == Projection::Perspective;
        let in_view = self.view.view_from_world.as_dmat4().transform_point3(place.point);
        let depth = -in_view.z;
        if depth <= first {
            return None;
        }
        let spread = if is_wide { depth } else { 1.0 };
        let scale = f64::from(SMALL_MAP) / f64::from(self.view.size.x) * f64::from(self.view.scale);
        let middle =
            DVec2::new(in_view.x, -in_view.y) / spread * scale + f64::from(SMALL_MAP) * 0.5;
        // Offset of the ray to a point of the light at a depth, per metre of the point's offset.
        let farthest = if is_wide { first.recip() - depth.recip() } else { depth - first };
        let through =
            |aside: f64| if is_wide { (depth.recip() + aside).recip() } else { depth - aside };
        let slack = 0.5 * spread / scale;
        let (mut stopped, mut narrowest) = (0u32, f64::INFINITY);
        // Light of points that the middle sees, and of points behind hidden occluders.
        let (mut seen, mut hidden) = (Vec::new(), Vec::new());
        // First a few points, spread over the light.
        let spread_out = (0..4).flat_map(|start| self.points.iter().skip(start).step_by(4));
        for (number, point) in spread_out.enumerate() {
            if number == 4 && stopped == 0 && hidden.is_empty() {
                return None;
            }
            let way = *point * scale;
            let steps = ((way.length() * farthest).ceil() as u32 + 1).min(STEPS);
            let mut found = [None; 2];
            let (mut light, mut is_dark) = (DVec3::ONE, false);
            for i in 0..steps {
                let [near, far] = [i, i + 1].map(|i| farthest * f64::from(i) / f64::from(steps));
                let at = (middle + way * (near + far) * 0.5).floor().as_ivec2();
                if !self.raster.contains(at) {
                    break;
                }
                let now = self.met(at, [through(far), through(near)], place, slack);
                (0..2).for_each(|kind| found[kind] = found[kind].or(now.depths[kind]));
                light *= now.passed;
                is_dark |= now.is_dark;
                if found[0].is_some() {
                    break;
                }
            }
            match found {
                [Some(_), _] => stopped += 1,
                [None, Some(_)] => hidden.push(if is_dark { DVec3::ZERO } else { light }),
                [None, None] => seen.push(light),
            }
            if let Some(depth_there) = found[0].or(found[1]) {
                let aside =
                    if is_wide { depth_there.recip() - depth.recip() } else { depth - depth_there };
                narrowest = narrowest.min(2.0 * self.half * aside);
            }
        }
        if stopped == POINTS || stopped == 0 && hidden.is_empty() {
            return None;
        }
        // A look-up takes hidden light to be like the visible light around it.
        let usual = seen.iter().sum::<DVec3>() / (seen.len() as f64).max(1.0);
        let usual = if seen.is_empty() { DVec3::ONE } else { usual };
        let hidden: f64 = hidden.iter().map(|light| (*light - usual).abs().max_element()).sum();
        let wanted = (narrowest / TEXELS).max(place.texel);
        let edge = f64::from(self.view.size.x) / f64::from(self.view.scale);
        let texels = if wanted > 0.0 { edge / wanted } else { 0.0 };
        Some(Penumbra { texels, hidden: hidden / f64::from(POINTS) })
    }

    fn met(&self, at: IVec2, [low, high]: [f64; 2], place: &Place, slack: f64) -> Met {
        let index = (at.y * SMALL_MAP as i32 + at.x) as usize;
        let layers = &self.layers[index];
        let in_front =
            |depth: f64| (self.raster.point(index, depth) - place.point).dot(place.normal) > slack;
        let mut met = Met { depths: [None; 2], passed: DVec3::ONE, is_dark: false };
        let found = &mut met.depths;
        let mut is_behind = false;
        for (number, layer) in layers.iter().enumerate() {
            let depth = f64::from(layer.depth);
            if depth > high {
                break;
            }
            let stops = self.stops(layer);
            let is_met = depth >= low && in_front(depth);
            let kind = usize::from(is_behind);
            if is_met && (stops || is_behind) {
                found[kind] = found[kind].or(Some(depth));
                met.is_dark |= stops && is_behind;
            }
            if is_met && !stops {
                let material = self.scene.triangles[layer.triangle as usize].material;
                met.passed *= self.passed[material as usize];
            }
            // Inside a body.
            let back =
                layers.get(number + 1).filter(|back| stops && layer.is_front && !back.is_front);
            if let Some(back) = back.map(|back| f64::from(back.depth)).filter(|&back| back >= low)
                && depth < low
                && in_front(low)
                && back.is_finite()
            {
                found[1] = found[1].or(Some(low));
                met.is_dark = true;
            }
            is_behind |= stops;
        }
        met
    }
}
