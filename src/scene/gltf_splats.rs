//! Splats in glTF: `KHR_gaussian_splatting`.
use super::{
    SceneError,
    gltf_file::File,
    gltf_items::Items,
    gltf_nodes::{PlacedNode, instances, placed_nodes},
    gltf_splat_json::SplatPrimitive,
    limits::Limit,
    splats::{Cloud, HARMONIC},
};
use crate::model::Gaussian;
use ::gltf::accessor::Dimensions;
use glam::{Mat4, Quat, Vec3};
use std::path::Path;

/// Reads the splats of a file, placed by its nodes as they rest.
pub(super) fn read(path: &Path) -> Result<Cloud, SceneError> {
    let file = File::open(path)?;
    let fault = |(message, help): (String, &'static str)| file.invalid(message, help);
    if file.splats.is_empty() {
        return Err(file.invalid("holds no splats", "name it in a [[mesh]], or export splats"));
    }
    let mut primitives = Vec::new();
    let mut uses = 0;
    for (mesh, world) in meshes(&file)? {
        for primitive in file.splats.iter().filter(|primitive| primitive.mesh == mesh) {
            let columns = Columns::new(&file, primitive)?;
            uses = Limit::Splats.grown_in(path, uses, columns.position.count as u64)?;
            primitives.push((columns, primitive.harmonics, world));
        }
    }
    let mut cloud = Cloud::with_room(uses).map_err(fault)?;
    for (columns, _, world) in &primitives {
        let is_logarithm = columns.has_logarithms();
        for i in 0..columns.position.count {
            cloud.push_placed(columns.splat(i, is_logarithm), world);
        }
    }
    if file.document.animations().len() > 0 {
        cloud.notes.push("animations do not move the splats of a glTF file".to_owned());
    }
    cloud.leave_out_harmonics(primitives.iter().map(|instance| instance.1).max().unwrap_or(0));
    Ok(cloud.finish())
}

/// Meshes of all nodes, with their transforms. World space = transform * the mesh's space.
fn meshes(file: &File) -> Result<Vec<(usize, Mat4)>, SceneError> {
    let mut found = Vec::new();
    for PlacedNode { node, world, .. } in placed_nodes(file, Mat4::IDENTITY)? {
        if let Some(mesh) = node.mesh() {
            for instance in instances(file, &node)? {
                found.push((mesh.index(), world * instance));
            }
        }
    }
    Ok(found)
}

/// Attributes of a primitive.
struct Columns<'a> {
    position: Items<'a>,
    rotation: Items<'a>,
    scale: Items<'a>,
    opacity: Items<'a>,
    color: Items<'a>,
}

impl<'a> Columns<'a> {
    fn new(file: &'a File, primitive: &SplatPrimitive) -> Result<Self, SceneError> {
        let help = "export the file again";
        let items = |index: usize, dimensions: Dimensions| {
            let none = || file.invalid(format!("there is no accessor {index}"), help);
            let accessor = file.document.accessors().nth(index).ok_or_else(none)?;
            if accessor.dimensions() != dimensions {
                let message = format!("accessor {index} has the wrong type for splats");
                return Err(file.invalid(message, help));
            }
            file.check(&accessor, accessor.size())?;
            file.items(&accessor)
        };
        let columns = Self {
            position: items(primitive.position, Dimensions::Vec3)?,
            rotation: items(primitive.rotation, Dimensions::Vec4)?,
            scale: items(primitive.scale, Dimensions::Vec3)?,
            opacity: items(primitive.opacity, Dimensions::Scalar)?,
            color: items(primitive.color, Dimensions::Vec3)?,
        };
        let count = columns.position.count;
        let others = [&columns.rotation, &columns.scale, &columns.opacity, &columns.color];
        if others.iter().any(|other| other.count != count) {
            let message = format!("mesh {}: attributes of splats differ in count", primitive.mesh);
            return Err(file.invalid(message, help));
        }
        Ok(columns)
    }

    /// Whether scales are logarithms, as drafts of the extension had them until 2025: plain ones are never
    /// negative.
    fn has_logarithms(&self) -> bool {
        (0..self.scale.count).any(|i| self.scale.floats::<3>(i).iter().any(|scale| *scale < 0.0))
    }

    fn splat(&self, i: usize, is_logarithm: bool) -> Gaussian {
        let scale = Vec3::from_array(self.scale.floats(i));
        let [opacity] = self.opacity.floats(i);
        Gaussian {
            center: Vec3::from_array(self.position.floats(i)),
            rotation: Quat::from_array(self.rotation.floats(i)),
            sigma: if is_logarithm { scale.exp() } else { scale },
            opacity,
            color: Vec3::splat(0.5) + HARMONIC * Vec3::from_array(self.color.floats(i)),
            ..Gaussian::default()
        }
    }
}
