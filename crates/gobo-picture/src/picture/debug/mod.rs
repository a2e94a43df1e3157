//! Debug pictures for tuning a scene.
mod atlas;
mod cascades;
mod heat;
mod letters;
mod masks;

use crate::picture::PreparedPicture;
use glam::{UVec2, Vec2};
use gobo::{Error, gpu::Gpu, model::Scene, records::Picture};
use heat::Heat;

pub(crate) use {atlas::atlas, cascades::cascades, masks::masks};

/// Debug picture beside the rendered one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DebugMode {
    /// Number of lights in each pixel's cluster.
    Clusters,
    /// Pairs that each pixel walked, and below them the lights that it evaluated.
    Cost,
    /// The cascade that each pixel's surface is in.
    Cascades,
    /// The maps of all views in the atlas.
    Atlas,
    /// The shadow masks of the picture, beside each other.
    Masks,
}

impl DebugMode {
    /// Unique name, part of a file's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clusters => "clusters",
            Self::Cost => "cost",
            Self::Cascades => "cascades",
            Self::Atlas => "atlas",
            Self::Masks => "masks",
        }
    }
}

/// Heat map of the lights in each pixel's cluster; the sky is in none. Blocks.
pub(crate) fn clusters(
    gpu: &Gpu,
    prepared: &PreparedPicture,
    scene: &Scene,
    picture: &Picture,
) -> Result<Picture, Error> {
    let lists = prepared.read_clusters(gpu)?;
    let surfaces = prepared.read_radiance(gpu)?;
    let width = picture.size.x as usize;
    let values = surfaces.iter().enumerate().map(|(i, &[.., depth])| {
        let pixel = Vec2::new((i % width) as f32, (i / width) as f32) + 0.5;
        let cluster = prepared.grid().cluster(pixel, depth).filter(|_| depth < 1.0);
        cluster.map_or(Heat::None, |cluster| match &lists[cluster as usize] {
            Some(list) => Heat::Value(list.len() as u32),
            None => Heat::Overflow(scene.lights.len() as u32),
        })
    });
    Ok(heat::draw(picture, &values.collect::<Vec<_>>(), "LIGHTS PER CLUSTER"))
}

/// Heat maps of `costs`: pairs and lights per pixel.
pub(crate) fn cost(picture: &Picture, costs: &[[u16; 2]]) -> Picture {
    let titles = ["PAIRS PER PIXEL", "LIGHTS PER PIXEL"];
    let panels = [0, 1].map(|i| {
        let values: Vec<_> = costs.iter().map(|cost| Heat::Value(cost[i].into())).collect();
        heat::draw(picture, &values, titles[i]).rgb
    });
    Picture { size: picture.size * UVec2::new(1, 2), rgb: panels.concat(), light: Vec::new() }
}
