//! Nodes of a glTF file's scene, and the instances of their meshes.
use super::{file::GltfFile, json::Instancing};
use crate::{SceneError, limits::Limit};
use ::gltf::accessor::{DataType, Dimensions};
use glam::{Mat4, Quat, Vec3};

/// A node of the scene.
pub(crate) struct PlacedNode<'a> {
    pub(crate) node: gltf::Node<'a>,
    /// Transform in the parent's space.
    pub(crate) local: Mat4,
    pub(crate) world: Mat4,
    /// Index of the parent, which comes before it.
    pub(crate) parent: Option<usize>,
}

/// All nodes of the scene, parents before their children. World space = `transform` * glTF space.
pub(crate) fn placed_nodes(
    file: &GltfFile,
    transform: Mat4,
) -> Result<Vec<PlacedNode<'_>>, SceneError> {
    let mut seen = vec![false; file.document.nodes().len()];
    let mut placed = Vec::new();
    let mut waiting: Vec<_> =
        roots(&file.document).into_iter().rev().map(|node| (node, transform, None)).collect();
    while let Some((node, parent_world, parent)) = waiting.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            let message = format!("node {} has two parents, or is its own ancestor", node.index());
            return Err(file.invalid(message, "export the file again"));
        }
        let local = Mat4::from_cols_array_2d(&node.transform().matrix());
        if !local.is_finite() {
            let message = format!("the transform of node {} is not finite", node.index());
            return Err(file.invalid(message, "export the file again"));
        }
        let (world, number) = (parent_world * local, placed.len());
        let children: Vec<_> = node.children().map(|child| (child, world, Some(number))).collect();
        waiting.extend(children.into_iter().rev());
        placed.push(PlacedNode { node, local, world, parent });
    }
    Ok(placed)
}

/// Transforms of the instances of a node's mesh, in the node's space (`EXT_mesh_gpu_instancing`).
pub(crate) fn instances(file: &GltfFile, node: &gltf::Node<'_>) -> Result<Vec<Mat4>, SceneError> {
    let Some(instancing) = file.instancing(node.index()) else { return Ok(vec![Mat4::IDENTITY]) };
    let Instancing { translation, rotation, scale } = instancing;
    let damaged = |problem: &str| {
        let message = format!("instances of node {}: {problem}", node.index());
        file.invalid(message, "export the file again")
    };
    let items = |index: Option<usize>, dimensions: Dimensions, whole: bool| {
        let Some(index) = index else { return Ok(None) };
        let accessor = file.document.accessors().nth(index);
        let accessor = accessor.ok_or_else(|| damaged("there is no such accessor"))?;
        let is_float = accessor.data_type() == DataType::F32;
        let is_short = matches!(accessor.data_type(), DataType::I8 | DataType::I16);
        if accessor.dimensions() != dimensions || !(is_float || whole && is_short) {
            return Err(damaged("an accessor has the wrong type"));
        }
        file.check(&accessor, accessor.size())?;
        file.items(&accessor).map(Some)
    };
    let translation = items(translation, Dimensions::Vec3, false)?;
    let rotation = items(rotation, Dimensions::Vec4, true)?;
    let scale = items(scale, Dimensions::Vec3, false)?;
    let mut counts = [&translation, &rotation, &scale].into_iter().flatten().map(|i| i.count);
    let Some(count) = counts.next() else { return Ok(vec![Mat4::IDENTITY]) };
    if counts.any(|other| other != count) {
        return Err(damaged("their attributes differ in count"));
    }
    Limit::Nodes.grown_in(&file.path, 0, count as u64)?;
    let place = |i: usize| {
        let translation = translation.map_or(Vec3::ZERO, |t| Vec3::from_array(t.floats(i)));
        let turn = rotation.map_or(Quat::IDENTITY, |r| Quat::from_array(r.floats(i)));
        let scale = scale.map_or(Vec3::ONE, |s| Vec3::from_array(s.floats(i)));
        let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { Quat::IDENTITY };
        let place = Mat4::from_scale_rotation_translation(scale, turn, translation);
        let wrong = || damaged(&format!("number {i} is not finite"));
        place.is_finite().then_some(place).ok_or_else(wrong)
    };
    (0..count).map(place).collect()
}

/// Root nodes of the default scene, else of the first, else of the whole document.
pub(crate) fn roots(document: &gltf::Document) -> Vec<gltf::Node<'_>> {
    if let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) {
        return scene.nodes().collect();
    }
    let mut is_child = vec![false; document.nodes().len()];
    for child in document.nodes().flat_map(|node| node.children()) {
        is_child[child.index()] = true;
    }
    document.nodes().filter(|node| !is_child[node.index()]).collect()
}
