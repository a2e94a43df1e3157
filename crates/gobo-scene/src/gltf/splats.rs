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
    splats::{HARMONIC, Harmonics, SplatCloud, Spz},
};
use ::gltf::accessor::Dimensions;
use glam::{Mat3, Mat4, Quat, Vec3};
use gobo::model::Gaussian;
use std::{
    collections::{HashMap, hash_map::Entry},
    path::Path,
};

/// Reads the splats of a file, placed by its nodes at rest.
pub(crate) fn read(path: &Path) -> Result<SplatCloud, SceneError> {
    let file = GltfFile::open(path)?;
    let fault = |(message, help): (String, &'static str)| file.invalid(message, help);
    let UsedSplats { opened, places, count } = UsedSplats::open(&file, false)?;
    let mut cloud = SplatCloud::with_room(count).map_err(fault)?;
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

/// Reads the coefficients of higher harmonics, in the order of [`read`]; `None` if nodes rotate or mirror
/// splats, whose coefficients would be others.
pub(crate) fn harmonics(path: &Path) -> Result<Option<Harmonics>, SceneError> {
    let file = GltfFile::open(path)?;
    let fault = |(message, help): (String, &'static str)| file.invalid(message, help);
    let UsedSplats { opened, places, .. } = UsedSplats::open(&file, true)?;
    if places.iter().any(|(_, world)| is_turned(world)) {
        return Ok(None);
    }
    let mut own = HashMap::new();
    for (i, source) in &opened {
        own.insert(*i, source.all_harmonics(&file)?);
    }
    let parts: Vec<_> = places.iter().map(|(i, _)| (&own[i], opened[i].count() as u64)).collect();
    Harmonics::joined(&parts).map(Some).map_err(fault)
}

/// Whether a transform does more than move and stretch along the axes.
fn is_turned(world: &Mat4) -> bool {
    let matrix = Mat3::from_mat4(*world);
    let along = Vec3::new(matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z);
    let turned = matrix - Mat3::from_diagonal(along);
    let rest = turned.to_cols_array().into_iter().fold(0.0, |most: f32, part| most.max(part.abs()));
    !(along.min_element() > 0.0 && rest <= 1e-5 * along.max_element())
}

/// The primitives of splats that nodes use.
struct UsedSplats<'a> {
    /// By their index among all primitives of splats.
    opened: HashMap<usize, PrimitiveSplats<'a>>,
    /// Each use: the index, and the transform. World space = transform * the mesh's space.
    places: Vec<(usize, Mat4)>,
    /// Splats of all uses.
    count: u64,
}

impl<'a> UsedSplats<'a> {
    /// `is_whole`: with harmonics.
    fn open(file: &'a GltfFile, is_whole: bool) -> Result<Self, SceneError> {
        if file.splats.is_empty() {
            return Err(file.invalid("holds no splats", "name it in a [[mesh]], or export splats"));
        }
        let mut used = Self { opened: HashMap::new(), places: Vec::new(), count: 0 };
        for (mesh, world) in meshes(file)? {
            for (i, primitive) in file.splats.iter().enumerate().filter(|(_, p)| p.mesh == mesh) {
                let source = match used.opened.entry(i) {
                    Entry::Occupied(known) => known.into_mut(),
                    Entry::Vacant(new) => {
                        new.insert(PrimitiveSplats::open(file, primitive, is_whole)?)
                    }
                };
                used.count =
                    Limit::Splats.grown_in(&file.path, used.count, source.count() as u64)?;
                used.places.push((i, world));
            }
        }
        Ok(used)
    }
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
    fn open(
        file: &'a GltfFile,
        primitive: &SplatPrimitive,
        is_whole: bool,
    ) -> Result<Self, SceneError> {
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
        let open = if is_whole { Spz::open_whole } else { Spz::open };
        open(file.view(&view)?).map(Self::Spz).map_err(fault)
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
            Self::Attributes(columns) => columns.named,
            Self::Spz(spz) => spz.harmonics(),
        }
    }

    /// Coefficients of higher harmonics of all its splats; an SPZ file must have been opened whole.
    fn all_harmonics(&self, file: &GltfFile) -> Result<Harmonics, SceneError> {
        let fault = |(message, help): (String, &'static str)| file.invalid(message, help);
        let columns = match self {
            Self::Spz(spz) => return spz.all_harmonics().map_err(fault),
            Self::Attributes(columns) => columns,
        };
        let count = columns.harmonics.len();
        let mut all = Harmonics::with_room(count, self.count() as u64).map_err(fault)?;
        for i in 0..self.count() {
            all.coefficients.extend(columns.harmonics.iter().map(|items| items.floats::<3>(i)));
        }
        Ok(all)
    }
}

/// Attributes of a primitive.
struct SplatAttributes<'a> {
    position: Items<'a>,
    rotation: Items<'a>,
    scale: Items<'a>,
    opacity: Items<'a>,
    color: Items<'a>,
    harmonics: Vec<Items<'a>>,
    /// Number of attributes of harmonics, also of incomplete degrees.
    named: usize,
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
        let Stored::Attributes { position, rotation, scale, opacity, color, ref harmonics, named } =
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
            harmonics: harmonics
                .iter()
                .map(|&index| items(index, Dimensions::Vec3))
                .collect::<Result<_, _>>()?,
            named,
            is_logarithm: false,
        };
        let count = columns.position.count;
        let others = [&columns.rotation, &columns.scale, &columns.opacity, &columns.color];
        if others.into_iter().chain(&columns.harmonics).any(|other| other.count != count) {
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
