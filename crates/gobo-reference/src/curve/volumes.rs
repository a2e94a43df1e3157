//! CPU reference of `wgsl/curve/volumes.wgsl`: volumes on a ray, face by face, as ramps.
use crate::caster_hit::SurfaceCrossing;
use glam::{IVec3, Vec3};
use gobo::records::MAX_TAU;

/// Optical depth below which a segment of a ray makes no ramp.
const TRACE: f32 = 1.0 / 65536.0;

/// A ramp: light falls from `start` to `end` by the factor `light`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// Light depth at which it begins.
    pub start: f32,
    /// Light depth at which it ends.
    pub end: f32,
    /// Factor of the light behind it, per channel.
    pub light: Vec3,
}

/// State of a ray with respect to volumes, updated face by face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inside {
    /// Optical depth per light depth, behind `last`, of the volumes that were entered and not left.
    pub density: Vec3,
    /// Light depth of the last face.
    pub last: f32,
    /// Volumes that were left and not entered.
    pub unentered: Unentered,
    /// Sums over all faces, as in nearest-depth mode: optical depth modulo 2^32, and number of volumes left
    /// minus entered.
    pub tau: IVec3,
    /// Volumes left minus entered, over all faces.
    pub leaves: i32,
}

/// Volumes that were left and not entered: the light is inside, or the entry comes late.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Unentered {
    /// Optical depth per light depth.
    pub density: Vec3,
    /// Optical depth from light depth 0 to the faces at which they were left.
    pub tau: Vec3,
    /// Light depths of the first and the last face at which one was left.
    pub first: f32,
    /// Light depth of the last such place.
    pub last: f32,
}

impl Unentered {
    /// Mean light depth of the faces at which they were left.
    fn ends(&self) -> Vec3 {
        self.tau / self.density.max(Vec3::splat(f32::MIN_POSITIVE))
    }

    fn add(&mut self, density: Vec3, ends: Vec3, [first, last]: [f32; 2]) {
        if density != Vec3::ZERO {
            self.first = if self.density == Vec3::ZERO { first } else { self.first.min(first) };
            self.last = self.last.max(last);
            self.density += density;
            self.tau += density * ends;
        }
    }

    /// Removes an entry at light depth `depth`; returns its share of `density`, and the optical depth from
    /// there to the face at which its volume was left.
    fn enter(&mut self, depth: f32, density: Vec3) -> (Vec3, Vec3) {
        if depth >= self.last {
            return (Vec3::ZERO, Vec3::ZERO);
        }
        let (entered, ends) = (density.min(self.density), self.ends());
        self.density -= entered;
        self.tau -= entered * ends;
        (entered, entered * (ends - depth))
    }
}

impl Inside {
    /// Counts a face in the sums; returns the change of density behind it.
    pub fn count(&mut self, face: &SurfaceCrossing) -> Vec3 {
        let crossing = face.crossing();
        self.tau = self.tau.wrapping_add(crossing.tau);
        self.leaves += crossing.leaves;
        face.metres * face.absorption * -(face.leaves as f32)
    }

    /// Continues the volumes to light depth `depth`, and changes their density there; returns the ramp up to
    /// it or, for a late face, the change's effect up to the last face.
    pub fn change(&mut self, depth: f32, change: Vec3) -> Option<Ramp> {
        let is_late = depth < self.last;
        let (start, end) = (self.last.min(depth), self.last.max(depth));
        let (entered, late_tau) = self.unentered.enter(depth, change.max(Vec3::ZERO));
        let balance = self.density + change - entered;
        self.unentered.add((-balance).max(Vec3::ZERO), Vec3::splat(depth), [depth; 2]);
        let behind = balance.max(Vec3::ZERO);
        let acting = if is_late { behind - self.density } else { self.density };
        let tau = (end - start) * acting + late_tau;
        self.density = behind;
        // Absorption too thin for a ramp is left to the next.
        if is_ramp(tau) || change != Vec3::ZERO {
            self.last = end;
        }
        ramp(start, end, tau)
    }

    /// Continues through the next segment, `next`; call it before appending that segment's curve.
    pub fn follow(&mut self, next: &Self) -> Option<Ramp> {
        self.tau = self.tau.wrapping_add(next.tau);
        self.leaves += next.leaves;
        let (start, end) = (self.last, self.last.max(next.last));
        let left = next.unentered.density.min(self.density);
        let ends = next.unentered.ends();
        let tau = (end - start) * self.density - left * (end - ends);
        let span = [next.unentered.first, next.unentered.last];
        self.unentered.add(next.unentered.density - left, ends, span);
        self.density += next.density - left;
        self.last = end;
        ramp(start, end, tau)
    }

    /// The volumes that were left but never entered: they contain the light, and begin at light depth 0. One
    /// ramp ends where the first was left, the next at the last: exact for two volumes.
    pub fn begin(&self) -> [Option<Ramp>; 2] {
        let Unentered { density, tau, first, last } = self.unentered;
        [ramp(0.0, first, density * first), ramp(first, last, tau - density * first)]
    }
}

fn is_ramp(tau: Vec3) -> bool {
    tau.abs().max_element() >= TRACE
}

fn ramp(start: f32, end: f32, tau: Vec3) -> Option<Ramp> {
    is_ramp(tau).then(|| Ramp {
        start,
        end,
        light: (-tau.max(Vec3::splat(-MAX_TAU))).map(f32::exp),
    })
}
