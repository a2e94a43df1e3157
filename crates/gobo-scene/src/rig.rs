//! Moving shapes and meshes: keys of the scene file move the whole, a model's own animation moves its nodes.
use super::{Scene, deform::Deform, splats, track::Channel, track::Track};
use glam::{EulerRot, Mat3, Mat4, Quat, Vec3};
use gobo::model::{
    Bounds, FARTHEST, Gaussian, GaussianOpacity, LightKind, MAX_GAIN, Motion, Strand, Triangle,
    moved, volume,
};
use rayon::prelude::*;
use std::{ops::Range, sync::Arc};

/// Most samples in time of a motion; one splat in as many is sampled.
const FEW: usize = 64;
/// Most triangles of a draw that are sampled.
const MANY: usize = 4096;

/// Placement of a shape or mesh.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Placement {
    pub(super) translation: Channel,
    /// Euler xyz \[degrees\].
    pub(super) rotation: Channel,
    pub(super) scale: Channel,
}

impl Placement {
    pub(super) fn still(translation: Vec3, rotation: Vec3, scale: Vec3) -> Self {
        let [translation, rotation, scale] = [translation, rotation, scale].map(Channel::Still);
        Self { translation, rotation, scale }
    }

    pub(super) fn moves(&self) -> bool {
        self.tracks().next().is_some()
    }

    fn tracks(&self) -> impl Iterator<Item = &Track> {
        [&self.translation, &self.rotation, &self.scale].into_iter().filter_map(Channel::track)
    }

    pub(super) fn at(&self, seconds: f64) -> Mat4 {
        let [x, y, z] = self.rotation.at(seconds).to_array().map(f32::to_radians);
        let turn = Quat::from_euler(EulerRot::XYZ, x, y, z);
        let (scale, translation) = (self.scale.at(seconds), self.translation.at(seconds));
        Mat4::from_scale_rotation_translation(scale, turn, translation)
    }
}

/// A node of a glTF file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    /// Index of the parent, which precedes it.
    pub(super) parent: Option<usize>,
    /// Local transform, where no track replaces it.
    pub(super) transform: Mat4,
    pub(super) translation: Option<Track>,
    pub(super) rotation: Option<Track>,
    pub(super) scale: Option<Track>,
}

impl Node {
    fn at(&self, seconds: f64) -> Mat4 {
        if self.translation.is_none() && self.rotation.is_none() && self.scale.is_none() {
            return self.transform;
        }
        let (scale, rotation, translation) = self.transform.to_scale_rotation_translation();
        let vector = |track: &Option<Track>, still: Vec3| {
            track.as_ref().map_or(still, |track| track.at(seconds).truncate())
        };
        let rotation = self.rotation.as_ref().map_or(rotation, |track| track.rotation(seconds));
        let (scale, translation) =
            (vector(&self.scale, scale), vector(&self.translation, translation));
        Mat4::from_scale_rotation_translation(scale, rotation, translation)
    }
}

/// Triangles that follow a node.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Draw {
    pub(super) triangles: Range<usize>,
    pub(super) node: usize,
    /// Transform in the node's space.
    pub(super) place: Mat4,
    /// Deformation by skins and morph targets.
    pub(super) deform: Option<Deform>,
}

/// Nodes of a model, and the draws and lights that follow them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Rig {
    /// Nodes, parents before their children.
    pub(super) nodes: Vec<Node>,
    pub(super) draws: Vec<Draw>,
    /// Lights on nodes: index of the light in the model, index of the node.
    pub(super) lights: Vec<(usize, usize)>,
    /// Node of the model's camera.
    pub(super) camera: Option<usize>,
}

impl Rig {
    /// Rig of triangles that follow only their placement.
    pub(super) fn whole(triangles: usize) -> Self {
        let transform = Mat4::IDENTITY;
        let node = Node { parent: None, transform, translation: None, rotation: None, scale: None };
        let draw = Draw { triangles: 0..triangles, node: 0, place: transform, deform: None };
        Self { nodes: vec![node], draws: vec![draw], ..Self::default() }
    }

    pub(super) fn moves(&self) -> bool {
        self.tracks().next().is_some()
    }

    fn tracks(&self) -> impl Iterator<Item = &Track> {
        let of_nodes =
            self.nodes.iter().flat_map(|node| [&node.translation, &node.rotation, &node.scale]);
        let deforms = self.draws.iter().filter_map(|draw| draw.deform.as_ref());
        of_nodes.flatten().chain(deforms.flat_map(Deform::tracks))
    }

    /// Moves `target` to the pose at a time \[s\], and returns the transforms of the nodes. World space =
    /// `whole` * the file's space.
    pub(super) fn pose(
        &self,
        local: &[Triangle],
        target: &mut [Triangle],
        whole: Mat4,
        seconds: f64,
        is_volume: impl Fn(u32) -> bool,
    ) -> Vec<Mat4> {
        let worlds = self.worlds(seconds, whole);
        for Draw { triangles, node, place, deform } in &self.draws {
            let world = worlds[*node] * *place;
            let target = &mut target[triangles.clone()];
            let local = &local[triangles.clone()];
            if let Some(deform) = deform {
                deform.put(target, local, world, &worlds, seconds);
                continue;
            }
            put(target, local, world);
            // Mirroring turns a mesh inside out.
            let has_volume = target.first().is_some_and(|triangle| is_volume(triangle.material));
            if has_volume && Mat3::from_mat4(world).determinant() < 0.0 {
                volume::turn_outwards(target);
            }
        }
        worlds
    }

    /// Box around the triangles' motion, by samples of each draw. `whole`: as in [`Self::pose`], at a time
    /// \[s\].
    fn reach(
        &self,
        local: &[Triangle],
        times: &[f64],
        whole: impl Fn(f64) -> Mat4 + Sync,
        wanted: &dyn Fn(u32) -> bool,
    ) -> Bounds {
        let few = |draw: &Draw| {
            let wanted = |&i: &usize| wanted(local[i].material);
            let all: Vec<usize> = draw.triangles.clone().filter(wanted).collect();
            all.iter().copied().step_by(all.len() / MANY + 1).collect::<Vec<_>>()
        };
        let draws: Vec<_> = self.draws.iter().map(|draw| (draw, few(draw))).collect();
        let at = |&seconds: &f64| {
            let worlds = self.worlds(seconds, whole(seconds));
            let mut reach = Bounds::EMPTY;
            for (Draw { triangles, node, place, deform }, few) in &draws {
                let world = worlds[*node] * *place;
                let posed = deform.as_ref().map(|deform| (deform, deform.pose(&worlds, seconds)));
                let places = |i: &usize| match &posed {
                    Some((deform, pose)) => [0, 1, 2].map(|c| {
                        deform.corner(pose, &local[*i], [*i - triangles.start, c], world).0
                    }),
                    None => local[*i].positions.map(|p| world.transform_point3(p)),
                };
                let places = few.iter().flat_map(places).filter(|place| place.is_finite());
                reach = places.fold(reach, |reach, place| reach.with_sphere(place, 0.0));
            }
            reach
        };
        times.par_iter().map(at).reduce(|| Bounds::EMPTY, |a, b| a.with(&b))
    }

    fn worlds(&self, seconds: f64, whole: Mat4) -> Vec<Mat4> {
        let mut worlds: Vec<Mat4> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let parent = node.parent.map_or(whole, |parent| worlds[parent]);
            worlds.push(parent * node.at(seconds));
        }
        worlds
    }
}

/// A moving part of a scene.
#[derive(Clone, Debug)]
pub(super) struct Moving {
    pub(super) rig: Arc<Rig>,
    pub(super) placement: Placement,
    /// Triangles in the spaces of their draws.
    pub(super) local: Arc<Vec<Triangle>>,
    /// Index of its first triangle in the scene.
    pub(super) first_triangle: usize,
    /// Splats in the space of the placement; empty if they do not move.
    pub(super) gaussians: Arc<Vec<Gaussian>>,
    /// Index of its first splat in the scene.
    pub(super) first_gaussian: usize,
    /// Strands, like the splats.
    pub(super) strands: Arc<Vec<Strand>>,
    pub(super) first_strand: usize,
    /// Lights on nodes: index in the scene, index of the node.
    pub(super) lights: Vec<(usize, usize)>,
    /// Node that the scene's camera follows, if it is the model's.
    pub(super) camera: Option<usize>,
    /// World position of the scene's origin \[m\].
    pub(super) origin: Vec3,
    /// Number of triangles that were left out at the start.
    pub(super) far: u64,
}

impl Motion for Moving {
    fn apply(&self, scene: &mut Scene, seconds: f64) {
        let whole = self.whole(seconds);
        let Scene { triangles, materials, .. } = scene;
        let target = &mut triangles[self.first_triangle..][..self.local.len()];
        let is_volume = |material: u32| materials[material as usize].is_volume();
        let worlds = self.rig.pose(&self.local, target, whole, seconds, is_volume);
        self.place_gaussians(scene, &whole);
        self.place_strands(scene, &whole);
        self.place_lights(scene, &worlds);
    }

    fn span(&self) -> Option<[f64; 2]> {
        let times: Vec<f32> = self.tracks().flat_map(Track::times).copied().collect();
        let first = times.iter().copied().reduce(f32::min)?;
        Some([first, times.iter().copied().fold(first, f32::max)].map(f64::from))
    }

    fn steer(&self, scene: &mut Scene, seconds: f64) {
        self.place_lights(scene, &self.rig.worlds(seconds, self.whole(seconds)));
    }

    fn reach(&self, wanted: &dyn Fn(u32) -> bool) -> Bounds {
        let whole = |seconds| self.whole(seconds);
        let times = self.times();
        let mut reach = self.rig.reach(&self.local, &times, whole, wanted);
        for seconds in times {
            let whole = whole(seconds);
            for gaussian in self.gaussians.iter().filter(|g| wanted(g.material)).step_by(FEW) {
                reach = reach.with_sphere(whole.transform_point3(gaussian.center), 0.0);
            }
            for strand in self.strands.iter().filter(|strand| wanted(strand.material)) {
                let ends = [strand.vertices.first(), strand.vertices.last()].into_iter().flatten();
                reach = ends.fold(reach, |reach, end| {
                    reach.with_sphere(whole.transform_point3(end.position), 0.0)
                });
            }
        }
        reach
    }

    fn moves_particles(&self) -> bool {
        !(self.gaussians.is_empty() && self.strands.is_empty())
    }

    fn moved(&self, by: Vec3) -> Option<Arc<dyn Motion>> {
        Some(Arc::new(Self { origin: self.origin - by, ..self.clone() }))
    }
}

impl Moving {
    /// World space from the model's space \[s from the start\].
    fn whole(&self, seconds: f64) -> Mat4 {
        Mat4::from_translation(-self.origin) * self.placement.at(seconds)
    }

    fn tracks(&self) -> impl Iterator<Item = &Track> {
        self.placement.tracks().chain(self.rig.tracks())
    }

    /// Times of its keys, and between them where the motion turns around; only some of them if there are many
    /// \[s\].
    fn times(&self) -> Vec<f64> {
        let mut keys: Vec<f64> = self.tracks().flat_map(Track::times).map(|&t| t.into()).collect();
        keys.sort_unstable_by(f64::total_cmp);
        keys.dedup();
        let between = keys.windows(2).map(|pair| (pair[0] + pair[1]) * 0.5);
        let mut times: Vec<f64> = keys.iter().copied().chain(between).collect();
        times.sort_unstable_by(f64::total_cmp);
        let last = times.last().copied();
        times.into_iter().step_by(2 * keys.len() / FEW + 1).chain(last).collect()
    }

    /// Places the lights and the camera that follow nodes, by the nodes' transforms.
    fn place_lights(&self, scene: &mut Scene, worlds: &[Mat4]) {
        let lights = &mut scene.lights;
        let mut left_out = 0;
        let mut place = |node: usize| {
            let at = worlds[node].w_axis.truncate();
            left_out += u64::from(!(at.is_finite() && at.abs().max_element() <= FARTHEST));
            // Beyond this distance nothing is lit or visible.
            let limit = Vec3::splat(FARTHEST);
            Vec3::select(at.is_nan_mask(), limit, at).clamp(-limit, limit)
        };
        for &(light, node) in &self.lights {
            let toward = worlds[node].transform_vector3(Vec3::NEG_Z).try_normalize();
            let at = place(node);
            match &mut lights[light].kind {
                LightKind::Directional { direction } => *direction = toward.unwrap_or(*direction),
                LightKind::Spot { position, direction, .. } => {
                    (*position, *direction) = (at, toward.unwrap_or(*direction));
                }
                LightKind::Point { position } => *position = at,
            }
        }
        if let Some(node) = self.camera {
            let toward = |axis: Vec3| worlds[node].transform_vector3(axis).try_normalize();
            if let (Some(forward), Some(up)) = (toward(Vec3::NEG_Z), toward(Vec3::Y)) {
                scene.camera.eye = place(node);
                scene.camera.target = scene.camera.eye + forward;
                scene.camera.up = up;
            }
        }
        if left_out > 0 {
            *scene.skipped.entry(moved::NODE).or_default() += left_out;
        }
    }

    /// A part that nothing follows yet.
    pub(super) fn none(placement: Placement) -> Self {
        Self {
            rig: Arc::new(Rig::whole(0)),
            placement,
            local: Arc::default(),
            first_triangle: 0,
            gaussians: Arc::default(),
            first_gaussian: 0,
            strands: Arc::default(),
            first_strand: 0,
            lights: Vec::new(),
            camera: None,
            origin: Vec3::ZERO,
            far: 0,
        }
    }

    /// Places its strands. A strand that cannot be placed stays where it was, with opacity 0.
    fn place_strands(&self, scene: &mut Scene, whole: &Mat4) {
        let target = &mut scene.strands[self.first_strand..][..self.strands.len()];
        let mut left_out = 0;
        for (target, local) in target.iter_mut().zip(self.strands.iter()) {
            let placed = local.placed(whole);
            if placed.problem(MAX_GAIN).is_none() {
                *target = placed;
            } else {
                target.vertices.iter_mut().for_each(|vertex| vertex.color.w = 0.0);
                left_out += 1;
            }
        }
        if left_out > 0 {
            *scene.skipped.entry(moved::STRAND).or_default() += left_out;
        }
    }

    /// Places its splats. A splat that cannot be placed stays where it was, with opacity 0.
    fn place_gaussians(&self, scene: &mut Scene, whole: &Mat4) {
        let target = &mut scene.gaussians[self.first_gaussian..][..self.gaussians.len()];
        let mut left_out = 0;
        for (target, local) in target.iter_mut().zip(self.gaussians.iter()) {
            let placed = splats::placed(local, whole);
            if placed.problem(MAX_GAIN, GaussianOpacity::Splat).is_none() {
                *target = placed;
            } else {
                target.opacity = 0.0;
                left_out += 1;
            }
        }
        if left_out > 0 {
            *scene.skipped.entry(moved::GAUSSIAN).or_default() += left_out;
        }
    }
}

/// Writes `local`, transformed to world space, to `target`.
fn put(target: &mut [Triangle], local: &[Triangle], world: Mat4) {
    let normal_from_local = Mat3::from_mat4(world).inverse().transpose();
    for (target, local) in target.iter_mut().zip(local) {
        target.positions = local.positions.map(|p| world.transform_point3(p));
        target.normals = local.normals.map(|n| (normal_from_local * n).normalize_or(Vec3::Y));
        target.uvs = local.uvs;
    }
}
