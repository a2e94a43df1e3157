//! glTF 2.0: the nodes of a scene, flattened to world space.
//!
//! Exporters write photometric and radiometric intensities. Those above 100 are taken as photometric
//! (candela, lux) and are divided by 683 lm/W.
pub(crate) mod animation;
pub(crate) mod announced;
mod coat;
mod coat_images;
mod details;
mod diffuse;
mod draco;
pub(crate) mod file;
pub(crate) mod film;
mod ignored;
pub(crate) mod items;
pub(crate) mod json;
mod material;
pub(crate) mod mesh;
mod meshopt;
pub(crate) mod nodes;
pub(crate) mod splat_json;
pub(crate) mod splats;
mod texture;
mod uses;
pub(crate) mod variants;

use crate::{
    SceneError,
    deform::Deform,
    limits::Limit,
    rig::{Draw, Node, Rig},
    track::Track,
};
use ::gltf::khr_lights_punctual::Kind;
use animation::NodeTracks;
use file::GltfFile;
use glam::{Mat4, UVec2, Vec3};
use gobo::model::{Camera, Light, LightKind, Material, Skipped, Texture, Transfer, Triangle};
use material::GltfMaterials;
use mesh::Meshes;
use nodes::{PlacedNode, instances, placed_nodes};
use std::{collections::HashMap, path::Path, sync::Arc};

/// Contents of one file, in world space.
#[derive(Clone, Debug)]
pub struct Model {
    /// Materials, indexed by the triangles.
    pub materials: Vec<Material>,
    /// Textures, indexed by the materials.
    pub textures: Vec<Texture>,
    /// Triangles, world space.
    pub triangles: Vec<Triangle>,
    /// Lights of `KHR_lights_punctual`.
    pub lights: Vec<Light>,
    /// The first perspective camera.
    pub camera: Option<Camera>,
    /// Triangles left out and features ignored, by reason.
    pub skipped: Skipped,
    /// Features of the file that are ignored, a sentence each.
    pub notes: Vec<String>,
    /// Whether the file holds splats too.
    pub(crate) has_splats: bool,
    /// Rig that moves the triangles; they are then in the spaces of their draws.
    pub(crate) rig: Option<Rig>,
}

/// Counts of the scene's contents before this file.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Earlier {
    pub(crate) materials: usize,
    pub(crate) textures: usize,
    pub(crate) texels: u64,
    pub(crate) triangles: usize,
    pub(crate) lights: usize,
}

/// Options of reading a model.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wanted<'a> {
    /// Transfer of partly transparent materials (alphaMode BLEND), if not the usual one.
    pub(crate) blend: Option<Transfer>,
    /// Whether the model will be moved as a whole.
    pub(crate) is_keyed: bool,
    /// Name of the materials' variant, in a file with variants.
    pub(crate) variant: Option<&'a str>,
}

/// Intensity above which a light is photometric.
const BRIGHTEST_RADIOMETRIC: f32 = 100.0;

/// Luminous efficacy of green light, by definition of the candela \[lm/W\].
const EFFICACY: f32 = 683.0;

/// Widest cone \[radians\]. A flat map cannot hold the half space that glTF allows; past this its texels are
/// worthless.
const WIDEST_CONE: f32 = 170.0 * std::f32::consts::PI / 180.0;

/// Distance of an origin along an axis \[m\] past which triangles are kept in their own space, to be placed
/// again when the scene is re-centred: beyond it neighbouring `f32` are 15 um apart, a hundredth of a texel
/// for a metre in a large map.
const FAR: f32 = 128.0;

/// Rows of a picture if the camera gives only its aspect \[pixels\].
const PICTURE_HEIGHT: f32 = 540.0;

/// Loads a file. World space = `transform` * glTF space; material and texture indices start at 0.
pub(crate) fn load(
    path: &Path,
    transform: Mat4,
    earlier: &Earlier,
    wanted: Wanted<'_>,
) -> Result<Model, SceneError> {
    let Wanted { blend, is_keyed, variant } = wanted;
    let mut file = GltfFile::open_variant(path, variant)?;
    let mut tracks = animation::tracks(&mut file)?;
    let has_targets = |mesh: gltf::Mesh<'_>| mesh.primitives().any(|p| p.morph_targets().len() > 0);
    let is_soft = file.document.skins().len() > 0 || file.document.meshes().any(has_targets);
    let moves = is_keyed || is_soft || !tracks.is_empty();
    let mut nodes = Nodes {
        file: &file,
        earlier,
        rig: Rig::default(),
        numbers: HashMap::new(),
        meshes: Meshes::new(earlier.triangles as u64),
        draws: Vec::new(),
        uses: 0,
        lights: Vec::new(),
        camera: None,
        skipped: Skipped::new(),
    };
    nodes.visit(transform, &mut tracks)?;
    let moves = moves || nodes.draws.iter().any(|draw| is_far(&draw.world));
    nodes.announce_images()?;
    let mut materials = GltfMaterials::new(&file, earlier, blend);
    nodes.draw(&mut materials, moves)?;
    let Nodes { meshes, lights, camera, mut skipped, rig, .. } = nodes;
    let (materials, textures, ignored) = materials.finish();
    for (reason, count) in meshes.skipped.into_iter().chain(ignored) {
        *skipped.entry(reason).or_default() += count;
    }
    let (notes, has_splats) = (file.notes, !file.splats.is_empty());
    Ok(Model {
        materials,
        textures,
        triangles: meshes.triangles,
        lights,
        camera,
        skipped,
        notes,
        has_splats,
        rig: moves.then_some(rig),
    })
}

/// Whether a transform moves the origin past [`FAR`].
fn is_far(world: &Mat4) -> bool {
    world.w_axis.truncate().abs().max_element() > FAR
}

/// Contents of a file's nodes, in the order of visits.
struct Nodes<'a> {
    file: &'a GltfFile,
    earlier: &'a Earlier,
    rig: Rig,
    /// Number of each node in the rig.
    numbers: HashMap<usize, usize>,
    meshes: Meshes,
    /// All draws are counted before the first is made.
    draws: Vec<PrimitiveDraw<'a>>,
    /// Number of instances, primitives and joints of the draws.
    uses: u64,
    lights: Vec<Light>,
    camera: Option<Camera>,
    skipped: Skipped,
}

/// A primitive of an instance of a node's mesh.
struct PrimitiveDraw<'a> {
    primitive: gltf::Primitive<'a>,
    node: gltf::Node<'a>,
    world: Mat4,
    /// Transform in the node's space.
    place: Mat4,
    /// Weights of the mesh's morph targets.
    weights: Arc<Vec<Track>>,
}

impl<'a> Nodes<'a> {
    fn visit(
        &mut self,
        transform: Mat4,
        tracks: &mut HashMap<usize, NodeTracks>,
    ) -> Result<(), SceneError> {
        for (number, placed) in placed_nodes(self.file, transform)?.into_iter().enumerate() {
            let PlacedNode { node, local, world, parent } = placed;
            let NodeTracks { transform, weights } =
                tracks.remove(&node.index()).unwrap_or_default();
            let [translation, rotation, scale] = transform;
            self.numbers.insert(node.index(), number);
            self.rig.nodes.push(Node { parent, transform: local, translation, rotation, scale });
            self.mesh(&node, world, weights)?;
            self.light(&node, world, number)?;
            self.camera(&node, world, number);
        }
        Ok(())
    }

    fn mesh(
        &mut self,
        node: &gltf::Node<'a>,
        world: Mat4,
        weights: Vec<Track>,
    ) -> Result<(), SceneError> {
        let Some(mesh) = node.mesh() else { return Ok(()) };
        let weights = Arc::new(weights);
        let joints = node.skin().map_or(0, |skin| skin.joints().count());
        // An instance of an empty mesh counts as well.
        let least = if mesh.primitives().len() == 0 { 1 } else { 0 };
        for place in instances(self.file, node)? {
            let path = &self.file.path;
            self.uses = Limit::Nodes.grown_in(path, self.uses, joints as u64 + least)?;
            for primitive in mesh.primitives() {
                self.uses = Limit::Nodes.grown_in(path, self.uses, 1)?;
                self.meshes.promise(self.file, &primitive)?;
                let (world, node, weights) = (world * place, node.clone(), weights.clone());
                self.draws.push(PrimitiveDraw { primitive, node, world, place, weights });
            }
        }
        Ok(())
    }

    fn light(
        &mut self,
        node: &gltf::Node<'_>,
        world: Mat4,
        number: usize,
    ) -> Result<(), SceneError> {
        let Some(source) = node.light() else { return Ok(()) };
        let Some(light) = light(&source, world, self.lights.len()) else {
            self.skip("light not valid");
            return Ok(());
        };
        let count = (self.earlier.lights + self.lights.len()) as u64;
        Limit::Lights.grown_in(&self.file.path, count, 1)?;
        self.rig.lights.push((self.lights.len(), number));
        self.lights.push(light);
        Ok(())
    }

    fn camera(&mut self, node: &gltf::Node<'_>, world: Mat4, number: usize) {
        let Some(source) = node.camera().filter(|_| self.camera.is_none()) else { return };
        match source.projection() {
            gltf::camera::Projection::Perspective(lens) => {
                self.camera = picture(&lens, world);
                self.rig.camera = self.camera.map(|_| number);
            }
            gltf::camera::Projection::Orthographic(_) => {
                self.skip("orthographic cameras ignored");
            }
        }
    }

    fn skip(&mut self, reason: &'static str) {
        *self.skipped.entry(reason).or_default() += 1;
    }

    /// Checks the images of all draws against the limits, before any is decoded.
    fn announce_images(&self) -> Result<(), SceneError> {
        let materials = self.draws.iter().map(|draw| draw.primitive.material());
        let (textures, texels) = announced::images(self.file, materials);
        let path = &self.file.path;
        Limit::Textures.grown_in(path, self.earlier.textures as u64, textures)?;
        Limit::Texels.grown_in(path, self.earlier.texels, texels)?;
        Ok(())
    }

    /// Makes the triangles of all draws: in world space or, if the model `moves`, in the meshes' spaces.
    fn draw(&mut self, materials: &mut GltfMaterials<'_>, moves: bool) -> Result<(), SceneError> {
        let (file, numbers) = (self.file, &self.numbers);
        let mut morphed = 0;
        for PrimitiveDraw { primitive, node, world, place, weights } in self.draws.drain(..) {
            let first = self.meshes.triangles.len();
            self.meshes.add(file, materials, &primitive, world, !moves)?;
            let kept = &self.meshes.kept;
            let mut deform = Deform::new(file, &node, &primitive, kept, &weights, &mut morphed)?;
            if let Some(deform) = &mut deform {
                deform.find(file, |node| numbers.get(&node).copied())?;
            }
            let (triangles, node) = (first..self.meshes.triangles.len(), numbers[&node.index()]);
            self.rig.draws.push(Draw { triangles, node, place, deform });
        }
        Ok(())
    }
}

fn light(
    source: &gltf::khr_lights_punctual::Light<'_>,
    world: Mat4,
    number: usize,
) -> Option<Light> {
    let position = world.w_axis.truncate();
    let direction = world.transform_vector3(Vec3::NEG_Z).try_normalize();
    let mut inner_angle = None;
    let kind = match source.kind() {
        Kind::Directional => LightKind::Directional { direction: direction? },
        Kind::Point => LightKind::Point { position },
        Kind::Spot { inner_cone_angle, outer_cone_angle } => {
            let angle = (2.0 * outer_cone_angle).min(WIDEST_CONE);
            inner_angle = Some((2.0 * inner_cone_angle).clamp(0.0, angle.max(0.0)));
            LightKind::Spot { position, direction: direction?, angle }
        }
    };
    let watts = match source.intensity() {
        bright if bright > BRIGHTEST_RADIOMETRIC => bright / EFFICACY,
        intensity => intensity,
    };
    let color = Vec3::from(source.color());
    let is_valid = position.is_finite()
        && (color.is_finite() && color.min_element() >= 0.0)
        && (watts.is_finite() && watts >= 0.0)
        && match kind {
            LightKind::Spot { angle, .. } => angle > 0.0,
            _ => true,
        };
    is_valid.then(|| Light {
        name: source.name().map_or_else(|| format!("light {number}"), str::to_owned),
        kind,
        color,
        intensity: watts,
        inner_angle,
        end: source.range().filter(|&range| range > 0.0 && range.is_finite()),
        ..Light::default()
    })
}

fn picture(lens: &gltf::camera::Perspective<'_>, world: Mat4) -> Option<Camera> {
    let eye = world.w_axis.truncate();
    let forward = world.transform_vector3(Vec3::NEG_Z).try_normalize()?;
    let up = world.transform_vector3(Vec3::Y).try_normalize()?;
    let aspect = lens.aspect_ratio().filter(|a| (0.1..=10.0).contains(a)).unwrap_or(16.0 / 9.0);
    let fov_y = lens.yfov();
    let is_valid = eye.is_finite() && fov_y > 0.0 && fov_y < std::f32::consts::PI;
    is_valid.then(|| Camera {
        eye,
        target: eye + forward,
        up,
        fov_y,
        size: UVec2::new((PICTURE_HEIGHT * aspect).round() as u32, PICTURE_HEIGHT as u32),
    })
}
