//! Counts that a glTF file announces, before anything is allocated.
//!
//! Never more than [`super::gltf::load`] makes: a texture that is stored once for bodies and once for
//! surfaces is counted once.
use super::{
    file::GltfFile,
    mesh::{corners, triangle_count},
    nodes,
    texture::{IMAGES, MAX_SIDE, Product, transmission},
};
use crate::{images, limits::Limit};
use ::gltf::{Image, Material};
use std::collections::{HashMap, HashSet};

/// Counts of one use of a file.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Announced {
    pub(crate) triangles: u64,
    pub(crate) textures: u64,
    pub(crate) texels: u64,
}

/// Counts the contents of the nodes in the file's scene.
pub(crate) fn announced(file: &GltfFile) -> Announced {
    let mut triangles = 0_u64;
    let mut materials = Vec::new();
    let mut uses = 0_u64;
    let mut is_whole = HashMap::new();
    let mut seen = vec![false; file.document.nodes().len()];
    let mut waiting = nodes::roots(&file.document);
    while let Some(node) = waiting.pop() {
        // A damaged file, or one past the limit of nodes, is refused when it is read.
        if std::mem::replace(&mut seen[node.index()], true) || uses > Limit::Nodes.most() {
            break;
        }
        let Some(mesh) = node.mesh() else {
            waiting.extend(node.children());
            continue;
        };
        let instances = nodes::instances(file, &node).map_or(0, |places| places.len() as u64);
        uses += instances * mesh.primitives().len().max(1) as u64;
        for primitive in mesh.primitives() {
            let Some(corners) = corners(&primitive) else { continue };
            let is_whole = is_whole
                .entry(corners.index())
                .or_insert_with(|| file.check(&corners, corners.size()).is_ok());
            if *is_whole {
                let count = instances.saturating_mul(triangle_count(&primitive) as u64);
                triangles = triangles.saturating_add(count);
                materials.push(primitive.material());
            }
        }
        waiting.extend(node.children());
    }
    let (textures, texels) = images(file, materials);
    Announced { triangles, textures, texels }
}

/// Number of these materials' textures, and of their texels.
pub(crate) fn images<'a>(
    file: &'a GltfFile,
    materials: impl IntoIterator<Item = Material<'a>>,
) -> (u64, u64) {
    let (mut known, mut used) = (HashSet::new(), HashSet::new());
    let (mut textures, mut texels) = (0, 0);
    for material in materials {
        if !known.insert(material.index()) {
            continue;
        }
        for images in images_of(file, &material) {
            let key = images.each_ref().map(|image| image.as_ref().map(Image::index));
            if key == [None; IMAGES] || !used.insert(key) {
                continue;
            }
            // The product of two images has the larger size.
            let sizes = images
                .iter()
                .flatten()
                .filter_map(|image| images::size(file.image(image).ok()?.as_ref(), MAX_SIDE));
            let [width, height] = sizes.fold([0; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
            textures += 1;
            texels += u64::from(width) * u64::from(height);
        }
    }
    (textures, texels)
}

/// Images of the colour, which become one texture; of the emission; and of diffuse transmission.
fn images_of<'a>(file: &'a GltfFile, material: &Material<'a>) -> [[Option<Image<'a>>; IMAGES]; 3] {
    let transmits = transmission(material) > 0.0;
    let color = Product::of(material, transmits, false);
    let diffuse = file.diffuse(material).filter(|_| !transmits);
    let far = diffuse.map_or_else(Product::default, |d| Product::far(&file.document, &d, material));
    let color = diffuse.map_or(color.clone(), |d| color.near(&file.document, &d));
    let strength = material.emissive_strength().unwrap_or(1.0);
    let emits = material.emissive_factor().iter().any(|factor| factor * strength > 0.0);
    let emission = material.emissive_texture().filter(|_| emits);
    let emission = emission.map(|info| info.texture().source());
    let emission = Product { base: emission, ..Product::default() };
    [color, emission, far].map(|product| product.images().map(Option::<&Image<'a>>::cloned))
}
