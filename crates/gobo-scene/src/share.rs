//! Shares of a scene's filtering casters: the maps of all shares can be merged to the whole scene's.
use super::Scene;
use gobo::model::Class;

/// Every N-th share of a scene's filtering casters. Particles of `[[particles]]` tables and Gaussians are
/// dealt in blocks; triangles, grids, strands and emitted particles belong to the first share. Casters that
/// block light belong to every share, since they end rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    index: u32,
    count: u32,
}

/// Particles per block.
const BLOCK: u64 = 1024;

impl Share {
    /// `None` if `index` is not below `count`.
    pub fn new(index: u32, count: u32) -> Option<Self> {
        (index < count).then_some(Self { index, count })
    }

    /// Index of the share.
    pub fn index(&self) -> u32 {
        self.index
    }

    /// Number of shares.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Whether a table's particle of this number belongs to the share.
    pub(super) fn has(&self, number: u64) -> bool {
        number / BLOCK % u64::from(self.count) == u64::from(self.index)
    }

    /// How many of the numbers below `end` it has.
    pub(super) fn count_of(&self, end: u64) -> u64 {
        self.ranges(end).map(|range| range.end - range.start).sum()
    }

    /// Its ranges of the numbers below `end`.
    pub(super) fn ranges(&self, end: u64) -> impl Iterator<Item = std::ops::Range<u64>> + use<> {
        let first = u64::from(self.index) * BLOCK;
        let starts = (first..end).step_by((u64::from(self.count) * BLOCK) as usize);
        starts.map(move |start| start..(start + BLOCK).min(end))
    }

    /// Removes the casters of other shares from a scene that was loaded with this one, at its present time.
    /// The scene keeps the bounds of the removed casters, so that all shares have the same views.
    pub fn keep(&self, scene: &mut Scene) {
        let classes: Vec<Class> = scene.materials.iter().map(Class::of).collect();
        let stays = |material: u32| !Class::FILTERING.contains(&classes[material as usize]);
        let Scene { gaussians, materials, around, .. } = scene;
        let mut numbers = 0..;
        gaussians.retain(|gaussian| {
            let is_own = numbers.next().is_some_and(|number| self.has(number));
            if !is_own && !stays(gaussian.material) {
                let bounds = gaussian.bounds(materials[gaussian.material as usize].gaussian);
                *around = around.with(&bounds);
            }
            is_own || stays(gaussian.material)
        });
        if self.index == 0 {
            return;
        }
        let emitted = scene.motions.iter().filter_map(|motion| motion.first_particle()).min();
        let first = emitted.unwrap_or(scene.particles.len());
        let Scene { particles, triangles, grids, strands, around, .. } = scene;
        let mut numbers = 0..;
        particles.retain(|particle| {
            let is_tables = numbers.next().is_some_and(|number| number < first);
            let kept = is_tables || stays(particle.material);
            if !kept {
                *around = around.with_sphere(particle.center, particle.radius);
            }
            kept
        });
        triangles.retain(|triangle| {
            let kept = stays(triangle.material);
            if !kept {
                let corners = triangle.positions.into_iter();
                *around = corners.fold(*around, |bounds, corner| bounds.with_sphere(corner, 0.0));
            }
            kept
        });
        grids.retain(|grid| {
            let kept = stays(grid.material);
            if !kept {
                *around = around.with(&grid.bounds());
            }
            kept
        });
        strands.retain(|strand| {
            let kept = stays(strand.material);
            if !kept {
                *around = around.with(&strand.bounds());
            }
            kept
        });
    }
}
