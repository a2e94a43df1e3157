//! Strands on a ray, by definition in 64 bits.
use crate::{
    rays::Ray,
    strand_truth::{Way, meet},
};
use gobo::{
    glam::{DVec3, DVec4},
    model::Strand,
};
use gobo_scene::Scene;
use std::f64::consts::FRAC_1_SQRT_2;

/// A scene of fur on a ball of 1 m.
pub(crate) fn fur(count: u32, length: f32) -> String {
    format!(
        r#"
        material = [
          {{ name = "skin", tint = [1, 1, 1, 0], casts = false, visible = false }},
          {{ name = "hair", tint = [0.1, 0.1, 0.1, 0.9] }},
        ]
        shape = [{{ kind = "sphere", name = "ball", material = "skin" }}]
        [[strands]]
        material = "hair"
        generate = {{ kind = "fur", on = "ball", count = {count}, length = {length}, radius = 0.002, comb = [0.3, 0, 0], curl = 1, clump = 0.3 }}
        "#
    )
}

/// Optical depth of an opaque capsule.
const MOST: f64 = 20.0;

/// A capsule on a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Capsule {
    way: Way,
    tau: DVec3,
}

impl Capsule {
    /// Its optical depth in front of light depth `z`.
    pub(crate) fn tau(&self, z: f64) -> DVec3 {
        self.tau * self.way.share(z)
    }
}

/// Capsules on a sun's ray. `texel`: its width [m].
pub(crate) fn met(scene: &Scene, ray: &Ray, texel: f64) -> Vec<Capsule> {
    let least = FRAC_1_SQRT_2 * texel;
    let is_near = |strand: &&Strand| {
        let bounds = strand.bounds();
        let apart = (bounds.center().as_dvec3() - ray.start).cross(ray.way).length();
        apart <= (f64::from(bounds.radius()) + 2.0 * least) * ray.way.length()
    };
    let met = scene.strands.iter().filter(is_near).flat_map(|strand| {
        let tint = scene.materials[strand.material as usize].tint;
        let met = meet(strand, ray.start, ray.way, [0.0, 1.0], |_| least);
        met.into_iter().filter_map(move |met| Some((met.way?, (met.color * tint).as_dvec4())))
    });
    let capsule = |(way, color): (Way, DVec4)| {
        let of_diameter = DVec3::ONE - color.w * (DVec3::ONE - color.truncate());
        let tau = |passed: f64| -way.passed(passed).max((-MOST).exp()).ln();
        Capsule { way, tau: of_diameter.map(tau) }
    };
    met.map(capsule).collect()
}

/// Disjoint stretches, front to back, and the optical depths of the capsules in them.
pub(crate) fn stretches(capsules: &[Capsule]) -> Vec<([f64; 2], DVec3)> {
    let mut ends: Vec<_> = capsules.iter().flat_map(|c| [c.way.enters, c.way.leaves]).collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    let taken = |ends: &[f64]| {
        let tau = capsules.iter().map(|c| c.tau(ends[1]) - c.tau(ends[0])).sum::<DVec3>();
        ([ends[0], ends[1]], tau)
    };
    ends.windows(2).map(taken).filter(|(_, tau)| *tau != DVec3::ZERO).collect()
}
