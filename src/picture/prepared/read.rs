//! Reads back what a picture holds: pixels, light, masks, clusters and costs.
use super::PreparedPicture;
use crate::{
    error::Error,
    gpu::Gpu,
    records::{ClusterCounters, Grid, MaskSlots, Picture},
};

impl PreparedPicture {
    /// Mask slot of each light.
    pub fn slots(&self) -> &MaskSlots {
        &self.slots
    }

    /// The masks, layer by layer and row by row, at the picture's size; empty without masks. Blocks.
    pub fn read_masks(&self, gpu: &Gpu) -> Result<Vec<[u8; 4]>, Error> {
        match &self.masks {
            Some((memory, _)) => {
                let mut texels = gpu.try_read_texture(memory.masks())?;
                texels.truncate((self.slots.count * self.size.element_product()) as usize);
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
    pub fn grid(&self) -> &Grid {
        &self.clusters.grid
    }

    /// Light list of each cluster, ascending; `None` if all lights are evaluated. Blocks.
    pub fn read_clusters(&self, gpu: &Gpu) -> Result<Vec<Option<Vec<u32>>>, Error> {
        self.clusters.read(gpu)
    }

    /// The picture before its tone curve, row by row: linear light, and the light depth of the opaque
    /// surface, 1 for the sky. Blocks.
    pub fn read_radiance(&self, gpu: &Gpu) -> Result<Vec<[f32; 4]>, Error> {
        gpu.try_read_texture(&self.radiance)
    }

    /// Light that each visible translucent particle sends to the eye, per unit of its colour. Blocks.
    pub fn read_lit(&self, gpu: &Gpu) -> Result<Vec<[f32; 4]>, Error> {
        let mut texels: Vec<[f32; 4]> = gpu.try_read_texture(&self.lit_texture)?;
        texels.truncate(self.clear.first_setup as usize);
        Ok(texels)
    }

    /// Cost of each pixel, if [`crate::shadows::Config::count_cost`] is set: pairs that were walked, and
    /// lights that were evaluated, both up to 65,535. Blocks.
    pub fn read_costs(&self, gpu: &Gpu) -> Result<Vec<[u16; 2]>, Error> {
        gpu.try_read(&self.pixels)
    }

    /// Reads the picture. Blocks.
    pub fn read(&self, gpu: &Gpu) -> Result<Picture, Error> {
        let pixels: Vec<[u8; 4]> = gpu.try_read(&self.pixels)?;
        let rgb = pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        Ok(Picture { size: self.size, rgb, light: Vec::new() })
    }
}
