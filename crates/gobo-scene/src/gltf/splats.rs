//! Splats in glTF: `KHR_gaussian_splatting`, in accessors or in an SPZ file in a view, whose coordinates are
//! used unchanged, as in `CesiumJS`.
use super::{
    file::GltfFile,
    items::Items,
    nodes::{PlacedNode, instances, placed_nodes},
    splat_json::{SplatPrimitive, Stored},
};
use crate::{
    SceneError,
    limits::Limit,
    splats::{HARMONIC, SplatCloud, Spz},
};
use ::gltf::accessor::Dimensions;
use glam::{Mat4, Quat, Vec3};
use gobo::model::Gaussian;
use std::{
    collections::{HashMap, hash_map::Entry},
    path::Path,
};

/// Reads the splats of a file, placed by its nodes at rest.
pub(crate) fn read(path: &Path) -> Result<SplatCloud, SceneError> {
    let file = GltfFile::open(path)?;
    let fault = |(message, help): (String, &'static str)| file.invalid(message, help);
    if file.splats.is_empty() {
        return Err(file.invalid("holds no splats", "name it in a [[mesh]], or export splats"));
    }
    let mut opened = HashMap::new();
    let mut places = Vec::new();
    let mut uses = 0;
    for (mesh, world) in meshes(&file)? {
        for (i, primitive) in file.splats.iter().enumerate().filter(|(_, p)| p.mesh == mesh) {
            let source = match opened.entry(i) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => new.insert(PrimitiveSplats::open(&file, primitive)?),
            };
            uses = Limit::Splats.grown_in(path, uses, source.count() as u64)?;
            places.push((i, world));
        }
    }
    let mut cloud = SplatCloud::with_room(uses).map_err(fault)?;
    for (i, world) in &places {
        let source = &opened[i];
        for i in 0..source.count() {
            cloud.push_placed(source.splat(i), world);
        }
    }
    if file.document.animations().len() > 0 {
        cloud.notes.push("animations do not move the splats of a glTF file".to_owned());
    }
    cloud.leave_out_harmonics(opened.values().map(PrimitiveSplats::harmonics).max().unwrap_or(0));
    Ok(cloud.finish())
}

/// Meshes of all nodes, with their transforms. World space = transform * the mesh's space.
fn meshes(file: &GltfFile) -> Result<Vec<(usize, Mat4)>, SceneError> {
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

/// Splats of a primitive, in its mesh's space.
enum PrimitiveSplats<'a> {
    Attributes(Box<SplatAttributes<'a>>),
    Spz(Spz),
}

impl<'a> PrimitiveSplats<'a> {
    fn open(file: &'a GltfFile, primitive: &SplatPrimitive) -> Result<Self, SceneError> {
        let Stored::Spz { view } = primitive.stored else {
            return SplatAttributes::new(file, primitive)
                .map(|columns| Self::Attributes(Box::new(columns)));
        };
        let none =
            || file.invalid(format!("there is no bufferView {view}"), "export the file again");
        let view = file.document.views().nth(view).ok_or_else(none)?;
        let fault = |(message, help): (String, &'static str)| {
            file.invalid(format!("mesh {}: SPZ: {message}", primitive.mesh), help)
        };
        Spz::open(file.view(&view)?).map(Self::Spz).map_err(fault)
    }

    fn count(&self) -> usize {
        match self {
            Self::Attributes(columns) => columns.position.count,
            Self::Spz(spz) => spz.count(),
        }
    }

    fn splat(&self, i: usize) -> Gaussian {
        match self {
            Self::Attributes(columns) => columns.splat(i),
            Self::Spz(spz) => spz.splat(i),
        }
    }

    /// Coefficients of higher harmonics per channel.
    fn harmonics(&self) -> usize {
        match self {
            Self::Attributes(columns) => columns.harmonics,
            Self::Spz(spz) => spz.harmonics(),
        }
    }
}

/// Attributes of a primitive.
struct SplatAttributes<'a> {
    position: Items<'a>,
    rotation: Items<'a>,
    scale: Items<'a>,
    opacity: Items<'a>,
    color: Items<'a>,
    harmonics: usize,
    is_logarithm: bool,
}

impl<'a> SplatAttributes<'a> {
    fn new(file: &'a GltfFile, primitive: &SplatPrimitive) -> Result<Self, SceneError> {
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
        let Stored::Attributes { position, rotation, scale, opacity, color, harmonics } =
            primitive.stored
        else {
            return Err(file.invalid("splats without attributes", help));
        };
        let mut columns = Self {
            position: items(position, Dimensions::Vec3)?,
            rotation: items(rotation, Dimensions::Vec4)?,
            scale: items(scale, Dimensions::Vec3)?,
            opacity: items(opacity, Dimensions::Scalar)?,
            color: items(color, Dimensions::Vec3)?,
            harmonics,
            is_logarithm: false,
        };
        let count = columns.position.count;
        let others = [&columns.rotation, &columns.scale, &columns.opacity, &columns.color];
        if others.iter().any(|other| other.count != count) {
            let message = format!("mesh {}: attributes of splats differ in count", primitive.mesh);
            return Err(file.invalid(message, help));
        }
        columns.is_logarithm = columns.has_logarithms();
        Ok(columns)
    }

    /// Whether scales are logarithms, as in drafts of the extension until 2025: plain scales are never
    /// negative.
    fn has_logarithms(&self) -> bool {
        (0..self.scale.count).any(|i| self.scale.floats::<3>(i).iter().any(|scale| *scale < 0.0))
    }

    fn splat(&self, i: usize) -> Gaussian {
        let scale = Vec3::from_array(self.scale.floats(i));
        let [opacity] = self.opacity.floats(i);
        Gaussian {
            center: Vec3::from_array(self.position.floats(i)),
            rotation: Quat::from_array(self.rotation.floats(i)),
            sigma: if self.is_logarithm { scale.exp() } else { scale },
            opacity,
            color: Vec3::splat(0.5) + HARMONIC * Vec3::from_array(self.color.floats(i)),
            ..Gaussian::default()
        }
    }
}
