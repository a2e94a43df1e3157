//! Reads a picture's results back: pixels, light, masks, clusters, costs and counters.
use super::{PictureCapacity, PreparedPicture, Targets};
use crate::picture::{FirstLight, air::Air};
use gobo::{
    Error,
    gpu::Gpu,
    records::{MaskSlots, Picture},
    shadows::{ListCounters, roomy},
};
use gobo_reference::records::{ClusterCounters, ClusterGrid};

impl PreparedPicture {
    /// Mask slot of each light.
    pub fn slots(&self) -> &MaskSlots {
        &self.lighting.slots
    }

    /// The masks, layer by layer and row by row, at the picture's size; empty without masks. Blocks.
    pub fn read_masks(&self, gpu: &Gpu) -> Result<Vec<[u8; 4]>, Error> {
        match &self.lighting.masks {
            Some(memory) => {
                let mut texels = gpu.try_read_texture(memory.masks())?;
                texels.truncate((self.slots().count * self.size.element_product()) as usize);
                Ok(texels)
            }
            None => Ok(Vec::new()),
        }
    }

    /// Reads the counters of the clusters. Blocks.
    pub fn read_cluster_counters(&self, gpu: &Gpu) -> Result<ClusterCounters, Error> {
        self.clusters.read_counters(gpu)
    }

    /// Grid of the camera's clusters.
    pub fn grid(&self) -> &ClusterGrid {
        &self.clusters.grid
    }

    /// Light list of each cluster, ascending; `None` if all lights are evaluated. Blocks.
    pub fn read_clusters(&self, gpu: &Gpu) -> Result<Vec<Option<Vec<u32>>>, Error> {
        self.clusters.read(gpu)
    }

    /// The picture before its tone curve, row by row: linear light, and the light depth of the opaque
    /// surface, 1 for the sky. Blocks.
    pub fn read_radiance(&self, gpu: &Gpu) -> Result<Vec<[f32; 4]>, Error> {
        gpu.try_read_texture(&self.targets.radiance)
    }

    /// Light that pictures through further samples of the pixels take over, by
    /// [`Kept::first_light`](super::Kept::first_light).
    pub fn first_light(&self) -> FirstLight {
        let Targets { lit, brick_lights, first_surfaces, .. } = &self.targets;
        FirstLight {
            around: self.around,
            particles: lit.clone(),
            bricks: brick_lights.clone(),
            surfaces: first_surfaces.clone(),
            offsets: self.offsets.clone(),
        }
    }

    /// Slices of each column of air that were lit, row by row; empty without air. Blocks.
    pub fn read_lit_air(&self, gpu: &Gpu) -> Result<Vec<u16>, Error> {
        let ends = |air: &Air| -> Result<Vec<[u16; 2]>, Error> { gpu.try_read(&air.ends) };
        let ends = self.lighting.air.as_ref().map_or(Ok(Vec::new()), ends)?;
        Ok(ends.into_iter().map(|[end, _]| end).collect())
    }

    /// Light that each visible translucent particle sends to the eye, per unit of its colour. Blocks.
    pub fn read_lit(&self, gpu: &Gpu) -> Result<Vec<[f32; 4]>, Error> {
        let mut texels: Vec<[f32; 4]> = gpu.try_read_texture(&self.targets.lit)?;
        texels.truncate(self.lit_count as usize);
        Ok(texels)
    }

    /// Cost of each pixel, if [`gobo::shadows::Toggles::count_cost`] is set: pairs that were walked, and
    /// lights that were evaluated, both up to 65,535. Blocks.
    pub fn read_costs(&self, gpu: &Gpu) -> Result<Vec<[u16; 2]>, Error> {
        gpu.try_read(&self.targets.pixels)
    }

    /// Reads the picture. Blocks.
    pub fn read(&self, gpu: &Gpu) -> Result<Picture, Error> {
        let pixels: Vec<[u8; 4]> = gpu.try_read(&self.targets.pixels)?;
        let rgb = pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        Ok(Picture { size: self.size, rgb, light: Vec::new() })
    }

    /// Counters of the lists, part by part: of opaque, and of translucent casters. Blocks.
    fn read_parts(&self, gpu: &Gpu) -> Result<Vec<[ListCounters; 2]>, Error> {
        gpu.try_read(&self.targets.counters)
    }

    /// Counters of the solid and of the translucent list, summed over the parts. Blocks.
    pub fn read_counters(&self, gpu: &Gpu) -> Result<[ListCounters; 2], Error> {
        let mut sums = [ListCounters::default(); 2];
        for part in self.read_parts(gpu)? {
            sums[0].add(&part[0]);
            sums[1].add(&part[1]);
        }
        Ok(sums)
    }

    /// Capacities that suffice for the picture, and for one that needs a little more; `None` if the present
    /// ones suffice. `budget`: of pairs. Blocks.
    pub fn needs(&self, gpu: &Gpu, budget: u32) -> Result<Option<PictureCapacity>, Error> {
        let parts = self.read_parts(gpu)?;
        let lists = || parts.iter().flatten();
        let mut wanted = self.capacity;
        // Rounds of the longest tile; every other tile has at least two.
        let rounds = lists().map(|counted| {
            counted.segment_count.saturating_sub(2 * counted.merged_count.saturating_sub(1))
        });
        wanted.rounds = rounds.max().unwrap_or(1).max(self.capacity.rounds);
        let needed = lists().map(|counted| counted.pairs_needed).max().unwrap_or(0);
        let capacity = self.pair_capacity;
        if needed > capacity && capacity < budget {
            wanted.pairs = Some(roomy(needed));
        } else if lists().any(|counted| counted.overflowed > 0) {
            let more = needed.div_ceil(capacity.max(1)).max(2);
            wanted.parts = self.capacity.parts.saturating_mul(more).min(self.tile_count);
        }
        Ok((wanted != self.capacity).then_some(wanted))
    }
}
