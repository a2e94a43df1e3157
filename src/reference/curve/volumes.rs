//! CPU reference of `wgsl/curve/volumes.wgsl`: volumes on a ray, face by face, as ramps.
use crate::{records::MAX_TAU, reference::caster_hit::Face};
use glam::{IVec3, Vec3};

/// Optical depth below which a segment of a ray makes no ramp.
const TRACE: f32 = 1.0 / 65536.0;

/// A ramp: light falls from `start` to `end` by the factor `light`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    pub start: f32,
    pub end: f32,
    pub light: Vec3,
}

/// State of a ray with respect to volumes while its faces come in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inside {
    /// Optical depth per light depth, behind `last`. Negative if a body was left that was not entered: the
    /// light is inside, or the entry comes late.
    pub density: Vec3,
    /// Light depth of the last face.
    pub last: f32,
    /// Sums over all faces, as in nearest-depth mode: optical depth modulo 2^32, and volumes left minus
    /// entered.
    pub tau: IVec3,
    pub leaves: i32,
}

impl Inside {
    /// Counts a face in the sums; returns the change of density behind it.
    pub fn count(&mut self, face: &Face) -> Vec3 {
        let crossing = face.crossing();
        self.tau = self.tau.wrapping_add(crossing.tau);
        self.leaves += crossing.leaves;
        face.metres * face.absorption * -(face.leaves as f32)
    }

    /// Continues the volumes to light depth `depth`, and changes their density there; returns the ramp up to
    /// it, or for what comes late the change's effect up to the last one.
    pub fn change(&mut self, depth: f32, change: Vec3) -> Option<Ramp> {
        let is_late = depth < self.last;
        let (start, end) = (self.last.min(depth), self.last.max(depth));
        let tau = (end - start) * if is_late { change } else { self.density };
        self.density += change;
        let counts = tau.abs().max_element() >= TRACE;
        // What is too thin for a ramp goes into the next.
        if counts || change != Vec3::ZERO {
            self.last = end;
        }
        counts.then(|| Ramp { start, end, light: (-tau.max(Vec3::splat(-MAX_TAU))).map(f32::exp) })
    }

    /// Continues through the next segment, `next`; call it before appending that segment's curve.
    pub fn follow(&mut self, next: &Self) -> Option<Ramp> {
        self.tau = self.tau.wrapping_add(next.tau);
        self.leaves += next.leaves;
        self.change(self.last.max(next.last), next.density)
    }

    /// Adds the volumes that were left but never entered: they contain the light, and begin at light depth
    /// 0.
    pub fn begin(&mut self) -> Option<Ramp> {
        self.change(0.0, (-self.density).max(Vec3::ZERO))
    }
}
