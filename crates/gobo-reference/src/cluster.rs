//! CPU reference of `wgsl/cluster/cluster_*.wgsl`: the lights that may reach each cluster.
use crate::records::{ClusterCounters, ClusterGrid};
use glam::{IVec3, Vec3};
use gobo::records::{Reach, UNIT};

/// Light lists of a grid's clusters.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Clusters {
    /// Indices of lights, ascending; `None` if the list did not fit: all lights.
    pub lists: Vec<Option<Vec<u32>>>,
    /// Lights and lists that were counted.
    pub counters: ClusterCounters,
}

/// Assigns lights to clusters; `capacity`: of all lists together \[lights\].
pub fn assign(grid: &ClusterGrid, reaches: &[Reach], capacity: u32) -> Clusters {
    let mut clusters = Clusters::default();
    let ClusterCounters { needed, overflowed, longest, .. } = &mut clusters.counters;
    for cluster in 0..grid.cluster_count() {
        let (low, high) = grid.cluster_box(cluster);
        let lights = (0..).zip(reaches).filter(|(_, reach)| reaches_box(reach, low, high));
        let list: Vec<u32> = lights.map(|(index, _)| index).collect();
        let count = list.len() as u32;
        let fits = *needed + count <= capacity;
        *needed += count;
        *overflowed += u32::from(!fits);
        *longest = (*longest).max(count);
        clusters.lists.push(fits.then_some(list));
    }
    clusters
}

/// Conservative test of whether the light may reach the box.
pub fn reaches_box(reach: &Reach, low: Vec3, high: Vec3) -> bool {
    if reach.per_radius == 0.0 {
        return true;
    }
    // The box relative to the light \[radii\].
    let in_radii = |corner: Vec3| {
        ((corner - reach.center) * reach.per_radius).clamp(Vec3::splat(-2.0), Vec3::splat(2.0))
    };
    let (low, high) = (in_radii(low), in_radii(high));
    let apart = (low.max(-high).max(Vec3::ZERO) * UNIT).as_ivec3();
    if apart.length_squared() > (UNIT * UNIT) as i32 {
        return false;
    }
    // The part of the box in the cube around the sphere.
    let low = (low.max(Vec3::NEG_ONE) * UNIT).floor().as_ivec3();
    let high = (high.min(Vec3::ONE) * UNIT).ceil().as_ivec3();
    reach.planes.iter().all(|&plane| {
        let [x, y, z, begin] = plane.map(i32::from);
        let normal = IVec3::new(x, y, z);
        let nearest = IVec3::select(normal.cmpge(IVec3::ZERO), low, high);
        normal.dot(nearest) <= begin * UNIT as i32
    })
}
