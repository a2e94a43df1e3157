//! The scenes of the benchmark: soft discs or splats in a cube, seen along its axes.
use super::{
    arguments::{BenchArguments, Layout, OneCase, ShapeName},
    raster::Inputs,
};
use gobo::{
    glam::{Mat3, Mat4, Quat, UVec2, Vec2, Vec3, Vec4},
    model::{
        Casters, Gaussian, Material, Particle, Projection, Shape, TILE_SIZE, Triangle, View,
        ViewRole, reach_squared,
    },
};
use gobo_scene::generate::Chance;
use std::ops::Range;

/// A case: one row of the results.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(super) struct Case {
    pub(super) shape: ShapeName,
    pub(super) casters: u32,
    /// Mean diameter [texels].
    pub(super) footprint: f32,
    pub(super) opacity: f32,
    pub(super) layout: Layout,
    pub(super) lights: u32,
    /// Edge of a map [texels].
    pub(super) size: u32,
}

/// The discs of a case and its view, for measurements of their maps: of the default material, `footprint`
/// \[texels\] wide in the mean, spread over a map of 1024 x 1024 texels.
#[doc(hidden)]
pub fn bench_discs(casters: u32, footprint: f32) -> (Vec<Particle>, View) {
    let case = Case {
        shape: ShapeName::Disc,
        casters,
        footprint,
        opacity: 0.02,
        layout: Layout::Spread,
        lights: 1,
        size: 1024,
    };
    (case.particles(0..casters), case.views().swap_remove(0))
}

/// Every combination of the arguments.
pub(super) fn cases(arguments: &BenchArguments) -> Vec<Case> {
    let usual: &[f32] = if arguments.occlude { &[1.5, 4.0, 12.0] } else { &[6.0, 16.0] };
    let footprints = if arguments.footprint.is_empty() { usual } else { &arguments.footprint };
    let opacities = if arguments.occlude { &[1.0][..] } else { &arguments.opacity };
    let each: Vec<_> = if arguments.cases.is_empty() {
        let of = |&opacity| {
            footprints.iter().flat_map(move |&footprint| {
                let case = move |&casters| OneCase { casters, footprint, opacity };
                arguments.casters.iter().map(case)
            })
        };
        opacities.iter().flat_map(of).collect()
    } else {
        arguments.cases.clone()
    };
    let shape = arguments.shape;
    let mut cases = Vec::new();
    for &size in &arguments.size {
        for &lights in &arguments.lights {
            for &layout in &arguments.layout {
                for &OneCase { casters, footprint, opacity } in &each {
                    cases.push(Case { shape, casters, footprint, opacity, layout, lights, size });
                }
            }
        }
    }
    cases
}

/// Share of a file's splats whose centres are inside the map, along each axis.
const WITHIN: f64 = 0.98;

/// Cases of a file's splats, moved and scaled until most of them are in the cube.
pub(super) fn cases_of_file(arguments: &BenchArguments, splats: &mut [Gaussian]) -> Vec<Case> {
    let middle_and_size = |axis: usize, splats: &[Gaussian]| {
        let mut places: Vec<f32> = splats.iter().map(|splat| splat.center[axis]).collect();
        places.sort_by(f32::total_cmp);
        let cut = (places.len() as f64 * 0.5 * (1.0 - WITHIN)) as usize;
        let [low, high] = [places[cut], places[places.len() - 1 - cut]];
        (0.5 * (low + high), high - low)
    };
    let [x, y, z] = [0, 1, 2].map(|axis| middle_and_size(axis, splats));
    let middle = Vec3::new(x.0, y.0, z.0);
    let scale = 2.0 / x.1.max(y.1).max(z.1).max(f32::MIN_POSITIVE);
    let (mut diameters, mut opacities) = (0.0, 0.0);
    for splat in splats.iter_mut() {
        splat.center = (splat.center - middle) * scale;
        splat.sigma *= scale;
        splat.material = 0;
        // The map is 2 m wide.
        diameters += f64::from(splat.sigma.max_element() * reach_squared(splat.opacity).sqrt());
        opacities += f64::from(splat.opacity);
    }
    let mean = |sum: f64| (sum / splats.len() as f64 * 1e2).round() as f32 / 1e2;
    let mut cases = Vec::new();
    for &size in &arguments.size {
        for &lights in &arguments.lights {
            cases.push(Case {
                shape: ShapeName::Gaussian,
                casters: splats.len() as u32,
                footprint: mean(diameters * f64::from(size)),
                opacity: mean(opacities),
                layout: Layout::File,
                lights,
                size,
            });
        }
    }
    cases
}

/// The casters of a case, of the first of `materials`.
pub(super) fn casters_of<'a>(inputs: &'a Inputs, materials: &'a [Material]) -> Casters<'a> {
    let none = Casters { materials, ..Casters::default() };
    match inputs {
        Inputs::Discs(discs) => Casters { particles: discs, ..none },
        Inputs::Splats(splats) => Casters { gaussians: splats, ..none },
    }
}

impl Case {
    /// The case's generated casters.
    pub(super) fn inputs(&self) -> Inputs {
        match self.shape {
            ShapeName::Disc => Inputs::Discs(self.particles(0..self.casters)),
            ShapeName::Gaussian => Inputs::Splats(self.splats()),
        }
    }

    /// Splats at the positions of the discs.
    fn splats(&self) -> Vec<Gaussian> {
        let mut chance = Chance::new(9);
        let one = |disc: Particle| {
            let long = disc.radius / reach_squared(self.opacity).sqrt();
            let axis = Vec3::from_array(std::array::from_fn(|_| chance.within(-1.0, 1.0)));
            Gaussian {
                center: disc.center,
                rotation: Quat::from_axis_angle(
                    axis.normalize_or(Vec3::X),
                    chance.within(0.0, std::f32::consts::PI),
                ),
                sigma: long * Vec3::new(1.0, chance.within(0.25, 1.0), chance.within(0.25, 1.0)),
                color: disc.color.truncate(),
                opacity: self.opacity,
                material: 0,
                id: disc.id,
            }
        };
        self.particles(0..self.casters).into_iter().map(one).collect()
    }

    /// Particles with these numbers, of the default material: soft discs with the `filter` transfer.
    pub(super) fn particles(&self, numbers: Range<u32>) -> Vec<Particle> {
        /// Random numbers of a particle.
        const DRAWS: u64 = 7;
        let mut chance = Chance::new(7);
        chance.skip(u64::from(numbers.start) * DRAWS);
        let texel = 2.0 / self.size as f32; // [m]
        let tile = TILE_SIZE as f32 * texel;
        let (low, high) = match self.layout {
            Layout::Spread | Layout::File => (Vec3::NEG_ONE, Vec3::ONE),
            Layout::Corner => (Vec3::NEG_ONE, Vec3::splat(-0.5)),
            Layout::Tile => {
                let first = (self.size / TILE_SIZE / 2) as f32 * tile - 1.0;
                (Vec3::new(first, -first - tile, -1.0), Vec3::new(first + tile, -first, 1.0))
            }
        };
        let one = |id| {
            let part = Vec3::new(chance.unit(), chance.unit(), chance.unit());
            let radius = self.footprint * 0.5 * chance.within(0.75, 1.25) * texel;
            let color = Vec4::new(chance.unit(), chance.unit(), chance.unit(), self.opacity);
            let center = low + part * (high - low);
            Particle { center, radius, color, rotation: 0.0, material: 0, id }
        };
        numbers.map(one).collect()
    }

    /// Random nearly equilateral triangles of material 0, spread evenly over the map; `footprint` is the
    /// side of the bounding square.
    pub(super) fn triangles(&self) -> Vec<Triangle> {
        let mut chance = Chance::new(7);
        // The bounding square of an equilateral triangle has 1.5 to 1.93 times its circumradius.
        let radius = self.footprint / 1.7 * 2.0 / self.size as f32; // [m]
        let one = |_| {
            let center = Vec3::from_array(std::array::from_fn(|_| chance.within(-1.0, 1.0)));
            let turn = chance.within(0.0, std::f32::consts::TAU);
            let positions = [0.0, 1.0, 2.0].map(|corner| {
                let angle = turn + corner * std::f32::consts::TAU / 3.0;
                let tilt = chance.within(-0.01, 0.01);
                center * Vec3::new(1.0, 1.0, 0.98) + (Vec2::from_angle(angle) * radius).extend(tilt)
            });
            Triangle { normals: [Vec3::Z; 3], ..Triangle::flat(positions, 0) }
        };
        (0..self.casters).map(one).collect()
    }

    /// The default material of the shape, with the `filter` transfer.
    pub(super) fn material(&self) -> Material {
        let shape = match self.shape {
            ShapeName::Disc => Shape::Disc,
            ShapeName::Gaussian => Shape::Gaussian,
        };
        Material { shape, ..Material::default() }
    }

    /// Views along the axes of the cube in turn; along the first axis only if the casters are in one tile, as
    /// they are spread over several in other views.
    pub(super) fn views(&self) -> Vec<View> {
        const DIRECTIONS: [Vec3; 6] =
            [Vec3::NEG_Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::Z, Vec3::X, Vec3::Y];
        let light = |light: usize| {
            let turn = if self.layout == Layout::Tile { 0 } else { light % DIRECTIONS.len() };
            let forward = DIRECTIONS[turn];
            let up = if forward.y == 0.0 { Vec3::Y } else { Vec3::Z };
            let right = forward.cross(up);
            let axes = Mat3::from_cols(right, right.cross(forward), -forward).transpose();
            View {
                role: ViewRole::Whole,
                light: Some(light),
                name: "0",
                projection: Projection::Orthographic,
                size: UVec2::splat(self.size),
                near: 0.0,
                far: 2.1,
                // The cube begins 0.05 m behind the near plane.
                view_from_world: Mat4::from_translation(Vec3::new(0.0, 0.0, -1.05))
                    * Mat4::from_mat3(axes),
                scale: self.size as f32 * 0.5,
            }
        };
        (0..self.lights as usize).map(light).collect()
    }
}
