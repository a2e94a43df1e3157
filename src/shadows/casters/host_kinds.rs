//! Kinds, list and number of records of the host's casters.
use super::group::GAUSSIAN_ENLARGED;
use crate::shadows::{
    cull::Frustum,
    host_inputs::{HostCasters, HostInputs},
};
use crate::{
    error::{Error, Input},
    model::{Class, Material, Shape},
    records::GpuView,
    stage::{load::group_count, project::CHUNK_SIZE},
};

/// Kinds of casters in the groups of a list.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct HostKinds {
    pub gaussians: bool,
    /// Discs, quads, puffs and bricks of grids.
    pub particles: bool,
}

impl HostKinds {
    pub(super) fn or(self, other: Self) -> Self {
        Self {
            gaussians: self.gaussians | other.gaussians,
            particles: self.particles | other.particles,
        }
    }

    /// Frustum that allows for the reach of casters beyond their groups' boxes.
    pub(super) fn frustum(self, view: &GpuView) -> Frustum {
        if self.gaussians {
            Frustum::around(view, GAUSSIAN_ENLARGED.into())
        } else {
            Frustum::new(view)
        }
    }
}

/// Index of the list in [`Class::LISTS`] that the set belongs to.
pub(super) fn list_of(
    index: usize,
    set: &HostCasters<'_>,
    materials: &[Material],
) -> Result<usize, Error> {
    let invalid = |problem| Input::HostCasters.invalid(index, problem);
    let mut list = None;
    for &material in set.materials {
        let material = materials.get(material as usize);
        let material = material.ok_or(invalid("a material of it is not among the materials"))?;
        match (set.loader.gaussians, material.shape) {
            (_, Shape::Brick) => return Err(invalid("a material of it is for grids")),
            (_, Shape::Capsule) => {
                return Err(invalid("a material of it is of strands, which are uploaded"));
            }
            (false, Shape::Gaussian) => {
                return Err(invalid(
                    "a material of it is of Gaussians: make its loader with `gaussian_loader`",
                ));
            }
            (true, Shape::Disc | Shape::Quad | Shape::Puff) => {
                return Err(invalid(
                    "its loader is of Gaussians, and the shape of a material of it is not",
                ));
            }
            _ => {}
        }
        let class = Class::of(material);
        let of = (0..Class::LISTS.len()).find(|&i| Class::LISTS[i].contains(&class));
        let of = of.ok_or(invalid("a material of it casts nothing"))?;
        if *list.get_or_insert(of) != of {
            return Err(invalid(
                "some of its materials block light and some filter it: make two sets",
            ));
        }
    }
    list.ok_or(invalid("it has no material"))
}

/// Number of records that sets and grids need: whole groups, and as many again for the axes of Gaussians.
pub(in crate::shadows) fn record_count(inputs: &HostInputs<'_>) -> u32 {
    let records = |capacity| group_count(capacity).saturating_mul(CHUNK_SIZE);
    let of_sets = inputs.casters.iter().map(|set| {
        records(set.count.capacity()).saturating_mul(1 + u32::from(set.loader.gaussians))
    });
    let of_grids = inputs.grids.iter().map(|grid| records(grid.bricks().element_product()));
    of_sets.chain(of_grids).fold(0, u32::saturating_add)
}
