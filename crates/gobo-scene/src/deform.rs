//! Skins and morph targets of glTF meshes: deformation of triangles.
use super::{
    SceneError,
    gltf::{file::GltfFile, items::Items},
    limits::{self, Limit},
    track::Track,
};
use ::gltf::{
    Accessor, Semantic,
    accessor::{DataType, Dimensions},
};
use glam::{Mat3, Mat4, Vec3};
use gobo::model::Triangle;

/// Skin and morph targets of one draw's triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Deform {
    targets: Vec<MorphTarget>,
    skin: Option<Skin>,
}

/// A morph target: offsets of each corner.
#[derive(Clone, Debug, PartialEq)]
struct MorphTarget {
    /// Weight without a track.
    weight: f32,
    track: Option<Track>,
    positions: Vec<[Vec3; 3]>,
    /// Offsets of normals: none, or as many as of positions.
    normals: Vec<[Vec3; 3]>,
}

#[derive(Clone, Debug, PartialEq)]
struct Skin {
    /// Node and inverse bind matrix of each joint. The node is numbered as in the file until [`Deform::find`]
    /// numbers it as in the rig.
    joints: Vec<(usize, Mat4)>,
    /// Sets of four joints per corner.
    sets: usize,
    /// All sets of the first triangle's corners, then of the next.
    bounds: Vec<Bound>,
}

/// A set of joints and weights of a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bound {
    joints: [u16; 4],
    /// Weights: their sum over all sets of a corner is 1, or 0 for a corner without joints.
    weights: [f32; 4],
}

impl Deform {
    /// `kept`: vertices of the triangles that the primitive became. `tracks`: of the node's weights.
    /// `morphed`: triangles and keys of all targets of the file so far.
    pub(super) fn new(
        file: &GltfFile,
        node: &gltf::Node<'_>,
        primitive: &gltf::Primitive<'_>,
        kept: &[[usize; 3]],
        tracks: &[Track],
        morphed: &mut u64,
    ) -> Result<Option<Self>, SceneError> {
        let skin = match node.skin() {
            Some(skin) => Skin::new(file, &skin, primitive, kept)?,
            None => None,
        };
        let targets = targets(file, node, primitive, kept, tracks, morphed)?;
        Ok((skin.is_some() || !targets.is_empty()).then_some(Self { targets, skin }))
    }

    /// Replaces the file's node numbers by the rig's; `number`: the rig's number of a node of the file.
    pub(super) fn find(
        &mut self,
        file: &GltfFile,
        number: impl Fn(usize) -> Option<usize>,
    ) -> Result<(), SceneError> {
        for (joint, _) in self.skin.iter_mut().flat_map(|skin| &mut skin.joints) {
            *joint = number(*joint).ok_or_else(|| {
                let message = format!("joint {joint} of a skin is not in the scene");
                file.invalid(message, "export the file again")
            })?;
        }
        Ok(())
    }

    pub(super) fn tracks(&self) -> impl Iterator<Item = &Track> {
        self.targets.iter().filter_map(|target| target.track.as_ref())
    }

    /// Writes `local`, deformed at a time \[s\], to `target` in world space; `worlds`: transforms of the
    /// rig's nodes.
    pub(super) fn put(
        &self,
        target: &mut [Triangle],
        local: &[Triangle],
        world: Mat4,
        worlds: &[Mat4],
        seconds: f64,
    ) {
        let pose = self.pose(worlds, seconds);
        for (i, (target, local)) in target.iter_mut().zip(local).enumerate() {
            for c in 0..3 {
                let (position, world) = self.corner(&pose, local, [i, c], world);
                let mut normal = local.normals[c];
                for (moved, weight) in self.targets.iter().zip(&pose.weights) {
                    normal += moved.normals.get(i).map_or(Vec3::ZERO, |n| n[c]) * *weight;
                }
                target.positions[c] = position;
                let normal_from_local = Mat3::from_mat4(world).inverse().transpose();
                target.normals[c] = (normal_from_local * normal).normalize_or(Vec3::Y);
            }
            target.uvs = local.uvs;
        }
    }

    /// Weights and joint transforms at a time \[s\]; see [`Self::put`].
    pub(super) fn pose(&self, worlds: &[Mat4], seconds: f64) -> Pose {
        let joints = self.skin.iter().flat_map(|skin| &skin.joints);
        Pose {
            weights: self.targets.iter().map(|target| target.at(seconds)).collect(),
            joints: joints.map(|&(node, inverse)| worlds[node] * inverse).collect(),
        }
    }

    /// World position of corner `c` of triangle `i`, and its transform to world space. `world`: transform of
    /// corners without joints. A skinned mesh follows its joints, not its node.
    pub(super) fn corner(
        &self,
        pose: &Pose,
        local: &Triangle,
        [i, c]: [usize; 2],
        world: Mat4,
    ) -> (Vec3, Mat4) {
        let mut position = local.positions[c];
        for (moved, weight) in self.targets.iter().zip(&pose.weights) {
            position += moved.positions[i][c] * *weight;
        }
        let world =
            self.skin.as_ref().map_or(world, |skin| skin.at(3 * i + c, &pose.joints, world));
        (world.transform_point3(position), world)
    }
}

/// Weights of morph targets, and transforms of joints.
pub(super) struct Pose {
    weights: Vec<f32>,
    joints: Vec<Mat4>,
}

impl MorphTarget {
    fn at(&self, seconds: f64) -> f32 {
        self.track.as_ref().map_or(self.weight, |track| track.at(seconds).x)
    }
}

impl Skin {
    fn new(
        file: &GltfFile,
        skin: &gltf::Skin<'_>,
        primitive: &gltf::Primitive<'_>,
        kept: &[[usize; 3]],
    ) -> Result<Option<Self>, SceneError> {
        let damaged = |problem: &str| {
            let message = format!("skin {}: {problem}", skin.index());
            file.invalid(message, "export the file again")
        };
        let mut sets = Vec::new();
        for set in 0.. {
            let both = [Semantic::Joints(set), Semantic::Weights(set)].map(|s| primitive.get(&s));
            let [Some(joints), Some(weights)] = both else { break };
            let is_whole = matches!(joints.data_type(), DataType::U8 | DataType::U16);
            let is_weight =
                matches!(weights.data_type(), DataType::F32 | DataType::U8 | DataType::U16);
            let four = |accessor: &Accessor<'_>| accessor.dimensions() == Dimensions::Vec4;
            if !(is_whole && is_weight && four(&joints) && four(&weights)) {
                return Err(damaged("joints or weights are of another type"));
            }
            sets.push((items(file, &joints)?, items(file, &weights)?));
        }
        if sets.is_empty() {
            return Ok(None);
        }
        let nodes: Vec<usize> = skin.joints().map(|joint| joint.index()).collect();
        let inverses = match skin.inverse_bind_matrices() {
            None => vec![Mat4::IDENTITY; nodes.len()],
            Some(accessor) => {
                let is_matrix = accessor.dimensions() == Dimensions::Mat4
                    && accessor.data_type() == DataType::F32
                    && accessor.count() >= nodes.len();
                if !is_matrix {
                    return Err(damaged("its matrices are too few or of another type"));
                }
                let matrices = items(file, &accessor)?;
                let matrix = |i: usize| {
                    let matrix = Mat4::from_cols_array(&matrices.floats(i));
                    let wrong = || damaged(&format!("the matrix of joint {i} is not finite"));
                    matrix.is_finite().then_some(matrix).ok_or_else(wrong)
                };
                (0..nodes.len()).map(matrix).collect::<Result<_, _>>()?
            }
        };
        let mut bounds = Vec::new();
        limits::reserve(&mut bounds, 3 * kept.len() * sets.len(), "joints of corners", &file.path)?;
        for &vertex in kept.as_flattened() {
            let first = bounds.len();
            let mut sum = 0.0;
            for (joints, weights) in &sets {
                if vertex >= joints.count.min(weights.count) {
                    return Err(damaged("a vertex has no joints"));
                }
                let (joints, weights): ([usize; 4], [f32; 4]) =
                    (joints.wholes(vertex), weights.floats(vertex));
                let known = |(&joint, weight): (&usize, f32)| weight == 0.0 || joint < nodes.len();
                if !joints.iter().zip(weights).all(known) {
                    return Err(damaged("a vertex follows a joint that is not there"));
                }
                sum += weights.iter().sum::<f32>();
                // A joint without weight may have any index.
                let joints = joints.map(|joint| if joint < nodes.len() { joint as u16 } else { 0 });
                bounds.push(Bound { joints, weights });
            }
            if !sum.is_finite() {
                return Err(damaged("the weights of a vertex are not finite"));
            }
            let share = if sum > 0.0 { 1.0 / sum } else { 0.0 };
            for bound in &mut bounds[first..] {
                bound.weights = bound.weights.map(|weight| weight * share);
            }
        }
        let joints = nodes.into_iter().zip(inverses).collect();
        Ok(Some(Self { joints, sets: sets.len(), bounds }))
    }

    /// Transform of a corner. `joints`: transforms of the joints; `node`: of the mesh, for a corner without
    /// joints.
    fn at(&self, corner: usize, joints: &[Mat4], node: Mat4) -> Mat4 {
        let bounds = &self.bounds[corner * self.sets..][..self.sets];
        if bounds.iter().all(|bound| bound.weights == [0.0; 4]) {
            return node;
        }
        let parts = bounds.iter().flat_map(|bound| bound.joints.iter().zip(bound.weights));
        parts
            .map(|(&joint, weight)| joints[usize::from(joint)] * weight)
            .fold(Mat4::ZERO, |a, b| a + b)
    }
}

fn targets(
    file: &GltfFile,
    node: &gltf::Node<'_>,
    primitive: &gltf::Primitive<'_>,
    kept: &[[usize; 3]],
    tracks: &[Track],
    morphed: &mut u64,
) -> Result<Vec<MorphTarget>, SceneError> {
    let of_mesh = node.mesh().and_then(|mesh| mesh.weights());
    let weights = node.weights().or(of_mesh).unwrap_or_default();
    // Triangles without a weight count as well.
    let count = primitive.morph_targets().len() as u64;
    *morphed = Limit::Keys.grown_in(&file.path, *morphed, count)?;
    let mut targets = Vec::new();
    for (i, target) in primitive.morph_targets().enumerate() {
        let (weight, track) = (weights.get(i).copied().unwrap_or(0.0), tracks.get(i).cloned());
        if !weight.is_finite() {
            let message = format!("a weight of node {} is not finite", node.index());
            return Err(file.invalid(message, "export the file again"));
        }
        let Some(positions) = target.positions().filter(|_| weight != 0.0 || track.is_some())
        else {
            continue;
        };
        // Each draw has its own copy of keys and offsets.
        let keys = track.as_ref().map_or(1, Track::key_count);
        *morphed = Limit::Keys.grown_in(&file.path, *morphed, (kept.len() + keys) as u64)?;
        let positions = deltas(file, &positions, kept)?;
        let normals = match target.normals() {
            Some(normals) => deltas(file, &normals, kept)?,
            None => Vec::new(),
        };
        targets.push(MorphTarget { weight, track, positions, normals });
    }
    Ok(targets)
}

fn deltas(
    file: &GltfFile,
    accessor: &Accessor<'_>,
    kept: &[[usize; 3]],
) -> Result<Vec<[Vec3; 3]>, SceneError> {
    let damaged = || {
        let message = format!("accessor {} is not that of a morph target", accessor.index());
        file.invalid(message, "export the file again")
    };
    if accessor.dimensions() != Dimensions::Vec3 || accessor.data_type() == DataType::U32 {
        return Err(damaged());
    }
    let items = items(file, accessor)?;
    let delta = |vertex: usize| {
        if vertex >= items.count {
            return Err(damaged());
        }
        let delta = Vec3::from_array(items.floats(vertex));
        if delta.is_finite() { Ok(delta) } else { Err(damaged()) }
    };
    kept.iter().map(|&[a, b, c]| Ok([delta(a)?, delta(b)?, delta(c)?])).collect()
}

fn items<'f>(file: &'f GltfFile, accessor: &Accessor<'_>) -> Result<Items<'f>, SceneError> {
    file.check(accessor, accessor.size())?;
    file.items(accessor)
}
