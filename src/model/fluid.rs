//! Smoothed particle hydrodynamics after Müller, Charypar and Gross 2003, sections 3.2 to 3.5. Sums,
//! products, divisions and square roots in a fixed order: the same on every machine.
use super::emitter::EmittedParticle;
use glam::{IVec3, Vec3};
use std::f32::consts::PI;

/// Interaction of particles. A lattice of `spacing` has a density of about 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fluid {
    /// Distance between particles at rest; its cube is a particle's mass \[m\].
    pub spacing: f32,
    /// Support radius of the kernels, `h` \[m\].
    pub reach: f32,
    /// Pressure per excess density: the square of the speed of sound [m^2/s^2].
    pub stiffness: f32,
    /// Kinematic viscosity [m^2/s].
    pub viscosity: f32,
}

impl Fluid {
    /// Most particles of one emitter.
    pub const MAX: u32 = 10_000;

    /// Mass of a particle; water at rest has a mass of 1 per m^3.
    fn mass(&self) -> f32 {
        self.spacing * self.spacing * self.spacing
    }

    /// Kernel `poly6` at a squared distance [1/m^3]: equation 20.
    fn weight(&self, square: f32) -> f32 {
        let whole = self.reach * self.reach;
        // In units of `reach`, whose ninth power may leave the range of an `f32`.
        let left = (1.0 - square / whole).max(0.0);
        315.0 / (64.0 * PI) * (left * left * left) / (whole * self.reach)
    }

    /// Density at each particle, its own included: equation 3.
    pub fn densities(&self, points: &[Vec3]) -> Vec<f32> {
        self.densities_by(points, &Cells::new(points, self.reach))
    }

    fn densities_by(&self, points: &[Vec3], cells: &Cells) -> Vec<f32> {
        let density = |&point: &Vec3| {
            let mut sum = 0.0;
            cells.near(point, |other| {
                sum += self.mass() * self.weight(point.distance_squared(points[other]));
            });
            sum
        };
        points.iter().map(density).collect()
    }

    /// Acceleration of each particle by the others [m/s^2].
    ///
    /// Equations 10, 12 and 14 with the gradient of the spiky kernel and the Laplacian of the viscous one
    /// (21, 22), divided by both densities, so that forces between two particles are equal and opposite.
    /// Unlike the paper: below the density at rest there is no tension, so that smoke may thin out.
    pub fn accelerations(&self, emitted: &[EmittedParticle]) -> Vec<Vec3> {
        let points: Vec<Vec3> = emitted.iter().map(|emitted| emitted.position).collect();
        let cells = Cells::new(&points, self.reach);
        let densities = self.densities_by(&points, &cells);
        let pressure = |density: f32| self.stiffness * (density - 1.0).max(0.0);
        let whole = self.reach * self.reach * self.reach;
        let scale = self.mass() / whole * 45.0 / (PI * whole);
        let of = |(i, particle): (usize, &EmittedParticle)| {
            let mut sum = Vec3::ZERO;
            cells.near(particle.position, |j| {
                let aside = particle.position - points[j];
                let distance = aside.length();
                // Particles at the same position have no direction apart.
                if j == i || distance >= self.reach || distance == 0.0 {
                    return;
                }
                let left = self.reach - distance;
                let weight = scale * left / (densities[i] * densities[j]);
                let push = (pressure(densities[i]) + pressure(densities[j])) * 0.5;
                let drag = (emitted[j].velocity - particle.velocity) * self.viscosity;
                sum += (aside * (push * left / distance) + drag) * weight;
            });
            sum
        };
        emitted.iter().enumerate().map(of).collect()
    }
}

/// Particles by grid cell, with `reach` as the edge.
struct Cells {
    edge: f32,
    /// Cell and particle, ascending.
    members: Vec<([i32; 3], usize)>,
}

impl Cells {
    fn new(points: &[Vec3], edge: f32) -> Self {
        let key = |point: &Vec3| Self::cell(*point, edge).to_array();
        let mut members: Vec<_> = points.iter().map(key).zip(0..).collect();
        members.sort_unstable();
        Self { edge, members }
    }

    fn cell(point: Vec3, edge: f32) -> IVec3 {
        (point / edge).floor().as_ivec3()
    }

    /// Visits the particles in the position's cell and its 26 neighbours, in a fixed order.
    fn near(&self, point: Vec3, mut visit: impl FnMut(usize)) {
        let [x, y, z] = Self::cell(point, self.edge).to_array();
        let around = |v: i32| v.saturating_sub(1)..=v.saturating_add(1);
        for x in around(x) {
            for y in around(y) {
                let row = [x, y, z.saturating_sub(1)];
                let last = [x, y, z.saturating_add(1)];
                let first = self.members.partition_point(|(cell, _)| *cell < row);
                let members = self.members[first..].iter();
                members.take_while(|(cell, _)| *cell <= last).for_each(|&(_, i)| visit(i));
            }
        }
    }
}
