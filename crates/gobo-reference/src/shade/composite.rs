//! Blending of particles and panes over opaque surfaces.
use super::{
    Behind, Eye, FAINT, Lit,
    layers::{Face, Layer, Pixel},
    near_surface::share_before_surface,
    seen::Seen,
};
use crate::{
    caster_hit::{Hit, Target, metres_per_depth},
    coplanar::is_in_front,
    fresnel::passed_share,
    hit::HitTriangle,
    refraction::{Bend, GlassFace},
    shading::{Gloss, Point, PointKind},
    tile::{Tile, TileTexels},
};
use glam::{Vec2, Vec3};
use gobo::{
    model::{MAX_GAIN, Material, Shape, Transfer},
    records::{BACK_BIT, Footprint, TRIANGLE_BIT},
};

/// Pairs between two tests of whether anything behind is visible.
const ENDS: usize = 256;

/// A pane's footprint, material and hit.
type PaneHit<'s> = (&'s Footprint, &'s Material, Hit);

impl Eye<'_> {
    /// Blends translucent casters over the opaque surfaces of a tile.
    pub(super) fn composite(
        &self,
        blended: &Seen<'_>,
        lit: &Lit,
        index: usize,
        tile: &Tile,
        surfaces: &TileTexels<Behind>,
    ) -> TileTexels<Blended> {
        let mut pixels = TileTexels::filled(Pixel::empty(0.0));
        for (in_tile, at) in tile.texels() {
            pixels[in_tile] = Pixel::empty(metres_per_depth(&self.view, at));
        }
        let is_faint = |pixel: &Pixel<_>| pixel.passed.max_element() < FAINT;
        for (i, pair) in blended.bins.tile(index).iter().enumerate() {
            if i % ENDS == ENDS - 1 && tile.texels().all(|(in_tile, _)| is_faint(&pixels[in_tile]))
            {
                break;
            }
            let footprint = &blended.casters.footprints[pair.footprint as usize];
            let target = Target::new(blended.records(), footprint);
            let material = target.material;
            let object = (footprint.caster & TRIANGLE_BIT != 0).then_some(target.id);
            for (in_tile, at) in target.texels(tile) {
                let Behind { around, object: behind, .. } = surfaces[in_tile];
                let opaque = around.depth;
                let pixel = &mut pixels[in_tile];
                if is_faint(pixel) {
                    continue;
                }
                let is_first = |hit: &Hit| is_in_front((hit.depth, object), (opaque, behind));
                let Some(hit) = target.hit(at, opaque).filter(is_first) else {
                    continue;
                };
                if object.is_some() {
                    pixel.wait(self.layer(blended, footprint, material, &hit, at, opaque));
                    continue;
                }
                pixel.lay_waiting(hit.depth);
                pixel.passed *= pixel.fog.to(hit.depth);
                let adds = material.transfer == Transfer::None;
                let light = if adds { Vec3::ONE } else { lit.casters[pair.footprint as usize] };
                let mut sent = seen_color(&hit, material) * light + material.emission;
                let depths = [hit.depth, opaque];
                let share = share_before_surface(&self.view, footprint, material, at, depths);
                let mut covered = Vec3::splat(hit.opacity * share);
                if material.shape == Shape::Brick {
                    // Opacity per channel.
                    covered = hit.absorbed;
                    if !adds {
                        sent = target.brick_light(at, opaque, &lit.lattices);
                    }
                }
                let passed = if adds { Vec3::ONE } else { 1.0 - covered };
                // A hit also covers its share of the air in front of it.
                let before = self.air_before(at, hit.depth);
                let veil = before.light * (1.0 - passed);
                pixel.lay(covered * sent * before.left + veil, passed);
            }
        }
        let none = Blended { light: Vec3::ZERO, ambient: Vec3::ZERO, bend: None };
        let mut colors = TileTexels::filled(none);
        for (in_tile, at) in tile.texels() {
            colors[in_tile] = self.over(blended, &mut pixels[in_tile], surfaces[in_tile], at);
        }
        colors
    }

    /// Blends the layers of a pixel over its background.
    fn over<'s>(
        &self,
        blended: &'s Seen<'_>,
        pixel: &mut Pixel<PaneHit<'s>>,
        Behind { light: behind, around, .. }: Behind,
        at: Vec2,
    ) -> Blended {
        let opaque = around.depth;
        pixel.lay_waiting(f32::INFINITY);
        pixel.passed *= pixel.fog.to(opaque);
        let mut color = pixel.color;
        for ((footprint, material, hit), passed) in &pixel.lit {
            let point = self.pane(blended, footprint, material, hit, at);
            let before = self.air_before(at, hit.depth);
            color += passed * self.lighting.light(&point, None) * before.left;
        }
        let ray = std::mem::take(&mut pixel.ray);
        let bend = ray.bend(&self.view, &self.world_from_view, at, opaque);
        let (passed, pane) = (pixel.passed, pixel.nearest.unwrap_or(f32::INFINITY));
        let bend = bend.map(|(aside, blur)| Bend { aside, blur, pane, passed });
        // A displaced background is added where it is sampled.
        let straight = if bend.is_some() { Vec3::ZERO } else { passed };
        let light = color + straight * behind;
        Blended { light, ambient: straight * around.light, bend }
    }

    /// Layer of a pane: its effect on a pixel, except for its scattered and mirrored light.
    fn layer<'s>(
        &self,
        blended: &'s Seen<'_>,
        footprint: &'s Footprint,
        material: &'s Material,
        hit: &Hit,
        pixel: Vec2,
        behind: f32,
    ) -> Layer<PaneHit<'s>> {
        let (depth, opacity) = (hit.depth, hit.opacity);
        let before = self.air_before(pixel, depth);
        let setup = blended.setup(footprint);
        let object = setup.id;
        let met = setup.hit(pixel);
        let mut emission = blended.emission(material, setup, pixel);
        if material.unlit {
            emission += seen_color(hit, material);
        }
        let emitted = opacity * emission * before.left;
        if material.transfer == Transfer::None {
            let sent = emitted + opacity * seen_color(hit, material) * before.left;
            let (passed, face, glass, pane) = (Vec3::ONE, None, None, None);
            return Layer { depth, object, sent, passed, face, glass, pane };
        }
        let to_eye = (self.position() - self.point(pixel, depth)).normalize();
        let [_, normal] = blended.normals(footprint, met, to_eye);
        let mirrored = mirrored_share(material, hit, normal, to_eye);
        // Its transfer already attenuates by its coverage.
        let scattered = if covers(material) { 0.0 } else { scattered_share(material, opacity) };
        // `gain` amplifies light sources, not the background.
        let gathers = material.transfer == Transfer::Gain;
        let light = if gathers { Vec3::ONE } else { hit.light };
        let passed = light * ((1.0 - mirrored) * (1.0 - scattered));
        let face = Face {
            absorption: blended.records.absorptions[setup.material as usize],
            leaves: setup.ties & BACK_BIT != 0,
        };
        let sent = emitted + before.light * (1.0 - passed);
        let glass = material.refracts().then(|| {
            GlassFace::new(&self.view, material, depth, behind, face.leaves, [normal, to_eye])
        });
        let pane = Some((footprint, material, *hit));
        Layer { depth, object, sent, passed, face: Some(face), glass, pane }
    }

    /// Point at which a pane's scattered and mirrored light is evaluated.
    fn pane(
        &self,
        blended: &Seen<'_>,
        footprint: &Footprint,
        material: &Material,
        hit: &Hit,
        pixel: Vec2,
    ) -> Point {
        let surface = self.triangle(blended, footprint, material, hit, pixel);
        let mirrored = mirrored_share(material, hit, surface.normal, surface.to_eye);
        let reflected = (-surface.to_eye).reflect(surface.normal);
        let share = scattered_share(material, hit.opacity) * (1.0 - mirrored);
        let far = blended.far_side(material, footprint, pixel);
        let near = far.map_or(1.0, |far| far.near);
        let mut point = Point {
            kind: match material.transfer {
                _ if far.is_some() => PointKind::Leaf,
                Transfer::Smoke => PointKind::Cover,
                _ => PointKind::Pane,
            },
            albedo: share * near * seen_color(hit, material),
            far: far.map_or(Vec3::ZERO, |far| share * far.color),
            gloss: pane_gloss(material, hit),
            emission: mirrored * self.lighting.radiance_around(reflected, material.roughness),
            ..surface
        };
        point.emission += self.lighting.ambient_behind(&point);
        point
    }
}

/// A pixel after all its layers were blended.
#[derive(Clone, Copy)]
pub(super) struct Blended {
    pub light: Vec3,
    /// Ambient light of the opaque surface that is left.
    pub ambient: Vec3,
    /// Displacement of the opaque surface, unless it is seen straight.
    pub bend: Option<Bend>,
}

/// Gloss of a pane, premultiplied: glass keeps its highlights where it is clear.
fn pane_gloss(material: &Material, hit: &Hit) -> Gloss {
    if material.unlit {
        return Gloss { reflectivity: 0.0, polish: 0.0 };
    }
    let polish = hit.opacity.max(material.transmission);
    Gloss { reflectivity: material.reflectivity, polish }
}

/// Mirrored share of the sky; `normal` is on the eye's side.
fn mirrored_share(material: &Material, hit: &Hit, normal: Vec3, to_eye: Vec3) -> f32 {
    let (gloss, cosine) = (pane_gloss(material, hit), normal.dot(to_eye));
    let index = material.fresnel.index();
    if index != 0.0 {
        let share = 1.0 - passed_share(index, cosine);
        return gloss.reflectivity + (1.0 - gloss.reflectivity) * gloss.polish * share;
    }
    gloss.mirrored_sky(cosine, material.roughness)
}

/// Whether its transfer attenuates the background by its coverage.
fn covers(material: &Material) -> bool {
    matches!(material.transfer, Transfer::Over | Transfer::Smoke)
}

/// Scattered share of a pane's light: all that it covers, if its transfer attenuates by coverage; else half
/// of it unless the pane is clear, and the rest is filtered.
fn scattered_share(material: &Material, opacity: f32) -> f32 {
    if material.unlit {
        return 0.0;
    }
    opacity * if covers(material) { 1.0 } else { 0.5 * (1.0 - material.transmission) }
}

/// Albedo of a pane; `gain` scatters everything.
pub(super) fn seen_color(hit: &Hit, material: &Material) -> Vec3 {
    if material.transfer == Transfer::Gain {
        (hit.color * MAX_GAIN).min(Vec3::ONE)
    } else {
        hit.color
    }
}
