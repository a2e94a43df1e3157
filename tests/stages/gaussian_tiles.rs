//! Tiles of Gaussians: none that a texel of theirs is in is missed, and few others are listed.
use crate::common::{gaussian_truth::meet, scenes::Chance};
use gobo::{
    glam::{DVec3, Mat4, Quat, UVec2, Vec2, Vec3},
    internals::{
        records::{Caster, GaussianAxes, GpuMaterial, GpuView},
        reference::{gaussian::project_gaussian, project::ProjectParams},
    },
    model::{Gaussian, Material, Part, Projection, Shape, TILE_SIZE, View},
};
use std::collections::BTreeSet;

const SIZE: u32 = 192;
/// Rounding of `q^2`, a share of it: what ends within it may go either way.
const ROUNDING: f64 = 2e-3;

/// A view whose view space is world space.
fn view(projection: Projection) -> GpuView {
    let (near, far) = (0.1, 20.0);
    let view = View {
        part: Part::Whole,
        light: Some(0),
        name: "0",
        projection,
        size: UVec2::splat(SIZE),
        near,
        far,
        view_from_world: Mat4::IDENTITY,
        scale: if projection == Projection::Orthographic { 20.0 } else { 120.0 },
    };
    view.to_gpu(0, UVec2::ZERO, 0)
}

fn random(chance: &mut Chance, parallel: bool) -> Gaussian {
    let long = 0.03 * 40.0_f32.powf(chance.unit());
    let [a, b] = [0; 2].map(|_| 100.0_f32.powf(-chance.unit()));
    let axis = chance.vec3(-1.0, 1.0).normalize_or(Vec3::X);
    let depth = chance.within(2.0, 12.0);
    let aside = if parallel { 6.0 } else { depth };
    let across = Vec2::new(chance.within(-aside, aside), chance.within(-aside, aside));
    Gaussian {
        center: across.extend(-depth),
        rotation: Quat::from_axis_angle(axis, chance.within(0.0, 3.0)),
        sigma: Vec3::new(long, long * a, long * b),
        opacity: chance.within(0.01, 1.0),
        ..Gaussian::default()
    }
}

/// Whether the ray through a texel certainly meets it.
fn is_met(view: &GpuView, gaussian: &Gaussian, material: &Material, texel: [u32; 2]) -> bool {
    let half = view.size.as_dvec2() * 0.5;
    let scale = f64::from(view.scale);
    let x = (f64::from(texel[0]) + 0.5 - half.x) / scale;
    let y = (half.y - f64::from(texel[1]) - 0.5) / scale;
    let (start, way) = if view.perspective > 0.0 {
        (DVec3::ZERO, DVec3::new(x, y, -1.0))
    } else {
        (DVec3::new(x, y, 0.0), DVec3::NEG_Z)
    };
    let met = meet(gaussian, material, start, way, [0.0, 1e9]);
    let share = met.alpha / f64::from(gaussian.opacity);
    let reach = f64::from(gaussian.reach(material.gaussian)).powi(2);
    met.t > 0.0 && -2.0 * share.ln() <= reach * (1.0 - ROUNDING)
}

/// Tiles that texels certainly are in, and tiles that are listed. `None` if it is smaller than a texel.
fn tiles(view: &GpuView, gaussian: &Gaussian) -> Option<[BTreeSet<(u32, u32)>; 2]> {
    let material = Material { shape: Shape::Gaussian, ..Material::default() };
    let params = ProjectParams { scatter: false, include_non_casters: false, by_distance: false };
    let caster = Caster::of_gaussian(gaussian, &material, 0);
    let record = GpuMaterial::new(&material, &[]);
    let axes = GaussianAxes::new(gaussian);
    let (projected, setup) = project_gaussian(view, 0, &caster, &axes, 0, 0, &record, params);
    if setup.thin() < 1.0 {
        return None;
    }
    let mut met = BTreeSet::new();
    for y in 0..SIZE {
        for x in 0..SIZE {
            let tile = (x / TILE_SIZE, y / TILE_SIZE);
            if !met.contains(&tile) && is_met(view, gaussian, &material, [x, y]) {
                met.insert(tile);
            }
        }
    }
    Some([met, projected.rect.tiles().collect()])
}

#[test]
fn no_tile_of_a_gaussian_is_missed() {
    let mut chance = Chance::new(5);
    for projection in [Projection::Orthographic, Projection::Perspective] {
        let view = view(projection);
        let (mut exact, mut listed, mut seen) = (0, 0, 0);
        for _ in 0..1000 {
            let gaussian = random(&mut chance, view.perspective == 0.0);
            let Some([met, found]) = tiles(&view, &gaussian) else { continue };
            let missed: Vec<_> = met.difference(&found).collect();
            assert!(missed.is_empty(), "{gaussian:?}: {missed:?}");
            let side = |of: fn(&(u32, u32)) -> u32| {
                let all = || found.iter().map(of);
                all().max().unwrap_or(0) - all().min().unwrap_or(0)
            };
            // Larger rectangles are taken whole.
            if side(|tile| tile.0) < 4 && side(|tile| tile.1) < 4 {
                (exact, listed) = (exact + met.len(), listed + found.len());
                seen += usize::from(!met.is_empty());
            }
        }
        assert!(seen > 100, "{seen}");
        // Conics that touch a tile between its texels.
        assert!(listed as f64 <= 1.05 * exact as f64, "{projection:?}: {listed} of {exact}");
    }
}
