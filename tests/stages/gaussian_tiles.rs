//! Tiles of Gaussians: no tile with a covered texel is missed, and few others are listed.
use crate::common::{
    gaussian_truth::{Seen, meet},
    scenes::{Chance, view_from_origin},
};
use gobo::{
    glam::{DMat3, DVec2, DVec3, Quat, Vec2, Vec3},
    model::{Gaussian, Material, Projection, Shape, TILE_SIZE},
    records::{CasterRecord, GaussianAxes, GpuMaterial, GpuView},
};
use gobo_reference::{gaussian::project_gaussian, project::ProjectParams};

const SIZE: u32 = 1024;
const TILES: usize = (SIZE / TILE_SIZE) as usize;
/// Relative rounding of `q^2`: a border within it may be on either side.
const ROUNDING: f64 = 2e-3;
/// Gaussians per projection.
const COUNT: u32 = 50_000;

fn view(projection: Projection) -> GpuView {
    view_from_origin(projection, SIZE, [0.1, 20.0], 85.0)
}

/// Their longest deviations are from less than a texel to a third of the map, up to 100 times the shortest.
fn random(chance: &mut Chance, parallel: bool) -> Gaussian {
    let long = 0.008 * 500.0_f32.powf(chance.unit());
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

/// A Gaussian's shadow in 64 bits: `form(x, y) <= 0` where `q^2 <= squared`.
struct Shadow {
    /// Quadratic form of `(x, y, 1)`, texels.
    form: DMat3,
    /// `toward . (x, y, 1)` is positive where the light is in front of it.
    toward: DVec3,
}

impl Shadow {
    fn new(view: &GpuView, gaussian: &Gaussian, squared: f64) -> Self {
        let half = view.size.as_dvec2() * 0.5;
        let scale = f64::from(view.scale);
        let axes = DMat3::from_quat(gaussian.rotation.as_dquat().normalize())
            * DMat3::from_diagonal(gaussian.sigma.as_dvec3());
        let center = gaussian.center.as_dvec3();
        if view.perspective == 0.0 {
            let to_map = |v: DVec3| DVec2::new(v.x, -v.y) * scale;
            let at = to_map(center) + half;
            let [a, b, c] = [axes.x_axis, axes.y_axis, axes.z_axis].map(to_map);
            let (xx, xy, yy) = (
                a.x * a.x + b.x * b.x + c.x * c.x,
                a.x * a.y + b.x * b.y + c.x * c.y,
                a.y * a.y + b.y * b.y + c.y * c.y,
            );
            // No principal deviation is below half the diagonal of a texel.
            let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
            let (major, minor) = (DVec2::from_angle(angle), DVec2::from_angle(angle).perp());
            let square = |v: DVec2| xx * v.x * v.x + 2.0 * xy * v.x * v.y + yy * v.y * v.y;
            let row = |v: DVec2| v.extend(-v.dot(at)) / square(v).max(0.5).sqrt();
            let outer = |v: DVec3| DMat3::from_cols(v * v.x, v * v.y, v * v.z);
            let constant = outer(DVec3::Z * squared.sqrt());
            return Self {
                form: outer(row(major)) + outer(row(minor)) - constant,
                toward: DVec3::Z,
            };
        }
        // Rays in the Gaussian's own space.
        let own = axes.inverse();
        let rays = own
            * DMat3::from_cols(
                DVec3::X / scale,
                DVec3::NEG_Y / scale,
                DVec3::new(-half.x / scale, half.y / scale, -1.0),
            );
        let m = own * center;
        let toward = rays.transpose() * m;
        let along = DMat3::from_cols(toward * toward.x, toward * toward.y, toward * toward.z);
        Self { form: rays.transpose() * rays * (m.length_squared() - squared) - along, toward }
    }

    fn is_met(&self, x: f64, y: f64) -> bool {
        let at = DVec3::new(x, y, 1.0);
        at.dot(self.form * at) <= 0.0 && self.toward.dot(at) > 0.0
    }

    /// Columns of tiles in each row with a texel that meets it, as bits.
    fn tiles(&self) -> Vec<u64> {
        let mut rows = vec![0; TILES];
        for texel in 0..SIZE {
            let y = f64::from(texel) + 0.5;
            let row = &mut rows[(texel / TILE_SIZE) as usize];
            let rest = self.form * DVec3::new(0.0, y, 1.0);
            let (a, b, c) = (self.form.x_axis.x, rest.x, rest.dot(DVec3::new(0.0, y, 1.0)));
            let inner = b * b - a * c;
            if a <= 0.0 {
                // Two intervals or all: it reaches the plane of the light.
                let met = (0..SIZE).filter(|&x| self.is_met(f64::from(x) + 0.5, y));
                met.for_each(|x| *row |= 1 << (x / TILE_SIZE));
                continue;
            }
            if inner < 0.0 || self.toward.dot(DVec3::new(-b / a, y, 1.0)) <= 0.0 {
                continue;
            }
            let texel = |x: f64| (x / a - 0.5).clamp(-1.0, f64::from(SIZE));
            let (first, last) = (texel(-b - inner.sqrt()).ceil(), texel(-b + inner.sqrt()).floor());
            let (first, last) = (first.max(0.0), last.min(f64::from(SIZE - 1)));
            if first <= last {
                let tile = |x: f64| x as u32 / TILE_SIZE;
                (tile(first)..=tile(last)).for_each(|x| *row |= 1 << x);
            }
        }
        rows
    }
}

/// Its tiles by the CPU reference, as bits of each row; `None` where perspective enlarges it.
fn listed(view: &GpuView, gaussian: &Gaussian) -> Option<Vec<u64>> {
    let material = Material { shape: Shape::Gaussian, ..Material::default() };
    let params = ProjectParams { scatter: false, include_non_casters: false, by_distance: false };
    let caster = CasterRecord::of_gaussian(gaussian, &material, 0);
    let record = GpuMaterial::new(&material, &[]);
    let axes = GaussianAxes::new(gaussian);
    let (projected, setup) = project_gaussian(view, 0, &caster, &axes, 0, 0, &record, params);
    if view.perspective > 0.0 && setup.thin() < 1.0 {
        return None;
    }
    let mut rows = vec![0; TILES];
    for (x, y) in projected.rect.tiles(Some(&setup.outline)) {
        rows[y as usize] |= 1 << x;
    }
    Some(rows)
}

/// Whether it nearly reaches the plane through the light: its shadow is then no ellipse.
fn reaches_the_light(view: &GpuView, gaussian: &Gaussian, squared: f64) -> bool {
    let axes = DMat3::from_quat(gaussian.rotation.as_dquat().normalize())
        * DMat3::from_diagonal(gaussian.sigma.as_dvec3());
    let along = axes.row(2).length_squared() / f64::from(gaussian.center.z).powi(2);
    view.perspective > 0.0 && 1.0 - squared * along < 2e-3
}

fn count(rows: &[u64]) -> u32 {
    rows.iter().map(|row| row.count_ones()).sum()
}

#[test]
fn no_tile_of_a_gaussian_is_missed() {
    let mut chance = Chance::new(5);
    for projection in [Projection::Orthographic, Projection::Perspective] {
        let view = view(projection);
        // Pairs of rectangles of at most 4 x 4 tiles, and of larger ones.
        let (mut exact, mut found, mut seen) = ([0; 2], [0; 2], 0);
        for _ in 0..COUNT {
            let gaussian = random(&mut chance, view.perspective == 0.0);
            let Some(listed) = listed(&view, &gaussian) else { continue };
            let squared = f64::from(gaussian.reach(Material::default().gaussian)).powi(2);
            let certain = Shadow::new(&view, &gaussian, squared * (1.0 - ROUNDING)).tiles();
            let missed = certain.iter().zip(&listed).position(|(met, listed)| met & !listed != 0);
            assert_eq!(missed, None, "{gaussian:?}\n{certain:x?}\n{listed:x?}");
            if reaches_the_light(&view, &gaussian, squared) {
                continue;
            }
            let touched = count(&Shadow::new(&view, &gaussian, squared).tiles());
            let high = listed.iter().filter(|&&row| row != 0).count();
            let all = listed.iter().fold(0, |all, row| all | row);
            let is_large =
                high > 4 || u64::BITS - all.leading_zeros() - all.trailing_zeros().min(63) > 4;
            exact[usize::from(is_large)] += touched;
            found[usize::from(is_large)] += count(&listed);
            seen += u32::from(touched > 0);
        }
        let ratio = |i: usize| f64::from(found[i]) / f64::from(exact[i]);
        println!(
            "{projection:?}: {seen}, {:.4} within 4 x 4 tiles, {:.4} beyond",
            ratio(0),
            ratio(1)
        );
        assert!(seen > COUNT / 4, "{seen}");
        let all = f64::from(found[0] + found[1]) / f64::from(exact[0] + exact[1]);
        assert!(all <= 1.02, "{projection:?}: {found:?} of {exact:?}");
    }
}

/// The closed form agrees with the definition, ray by ray.
#[test]
fn shadows_in_64_bits_are_those_of_the_definition() {
    let mut chance = Chance::new(6);
    let material = Material { shape: Shape::Gaussian, ..Material::default() };
    for projection in [Projection::Orthographic, Projection::Perspective] {
        let view = view(projection);
        let half = f64::from(SIZE) * 0.5;
        let mut met = 0;
        for _ in 0..2000 {
            let gaussian = random(&mut chance, view.perspective == 0.0);
            if listed(&view, &gaussian).is_none() || gaussian.sigma.min_element() < 0.02 {
                continue;
            }
            let squared = f64::from(gaussian.reach(material.gaussian)).powi(2);
            let shadow = Shadow::new(&view, &gaussian, squared);
            for _ in 0..100 {
                let [x, y] = [0; 2].map(|_| f64::from(chance.within(0.0, SIZE as f32)));
                let (right, up) =
                    ((x - half) / f64::from(view.scale), (half - y) / f64::from(view.scale));
                let (start, way) = if view.perspective > 0.0 {
                    (DVec3::ZERO, DVec3::new(right, up, -1.0))
                } else {
                    (DVec3::new(right, up, 0.0), DVec3::NEG_Z)
                };
                let meeting =
                    meet(&Seen::whole(&gaussian), &gaussian, &material, start, way, [0.0, 1e9]);
                let share = -2.0 * (meeting.alpha / f64::from(gaussian.opacity)).ln() / squared;
                if meeting.t > 0.0 && (share - 1.0).abs() > 1e-6 {
                    assert_eq!(shadow.is_met(x, y), share < 1.0, "{gaussian:?} at {x}, {y}");
                    met += u32::from(share < 1.0);
                }
            }
        }
        assert!(met > 100, "{met}");
    }
}

/// Needles across a map touch the tiles along them, not all of their rectangles.
#[test]
fn a_needle_touches_the_tiles_along_it() {
    let view = view(Projection::Orthographic);
    for (long, most) in [(2.2, 1.03), (30.0, 1.12)] {
        let gaussian = Gaussian {
            center: Vec3::new(0.0, 0.0, -5.0),
            rotation: Quat::from_rotation_z(0.8),
            sigma: Vec3::new(long, 0.003, 0.003),
            opacity: 1.0,
            ..Gaussian::default()
        };
        let squared = f64::from(gaussian.reach(Material::default().gaussian)).powi(2);
        let found = count(&listed(&view, &gaussian).unwrap());
        let exact = count(&Shadow::new(&view, &gaussian, squared).tiles());
        assert!((64..200).contains(&exact), "{exact}");
        assert!(f64::from(found) <= most * f64::from(exact), "{found} of {exact}");
    }
}
