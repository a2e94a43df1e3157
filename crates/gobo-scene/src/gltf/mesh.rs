//! glTF primitives as triangles in world space.
use super::{file::GltfFile, items::Items, material::GltfMaterials, uses::Uses};
use crate::{
    SceneError,
    limits::{self, Limit},
    particles::FARTHEST,
};
use ::gltf::{
    Semantic,
    accessor::{DataType, Dimensions},
    mesh::Mode,
};
use glam::{DVec3, Mat3, Mat4, Vec2, Vec3, Vec4};
use gobo::model::{Skipped, Triangle, VertexColor, volume};
use std::collections::HashSet;

#[derive(Debug, Default)]
pub(crate) struct Meshes {
    pub(crate) triangles: Vec<Triangle>,
    /// Vertices of the triangles of the last primitive.
    pub(crate) kept: Vec<[usize; 3]>,
    /// Number of primitives so far: object ids of their triangles.
    objects: u32,
    pub(crate) skipped: Skipped,
    /// Triangles of the scene and those announced by this file, including degenerate ones: a small file can
    /// name one mesh many times.
    promised: u64,
    /// Accessors that were checked.
    checked: HashSet<usize>,
}

/// Vertex attributes of triangles, in the mesh's own space.
struct MeshVertices<'a> {
    positions: Items<'a>,
    normals: Option<Items<'a>>,
    uvs: Option<Items<'a>>,
    colors: Option<(Items<'a>, Dimensions)>,
}

impl Meshes {
    /// `earlier`: triangles that the scene already has.
    pub(crate) fn new(earlier: u64) -> Self {
        Self { promised: earlier, ..Self::default() }
    }

    /// Counts the triangles that [`Self::add`] will make of a primitive, before any is made.
    pub(crate) fn promise(
        &mut self,
        file: &GltfFile,
        primitive: &gltf::Primitive<'_>,
    ) -> Result<(), SceneError> {
        if let Some(corners) = corners(primitive) {
            self.items(file, &corners)?;
        }
        let count = triangle_count(primitive) as u64;
        self.promised = Limit::Triangles.grown_in(&file.path, self.promised, count)?;
        Ok(())
    }

    /// Adds the triangles of a primitive: in world space or, if it moves, in the mesh's own space.
    pub(crate) fn add(
        &mut self,
        file: &GltfFile,
        materials: &mut GltfMaterials<'_>,
        primitive: &gltf::Primitive<'_>,
        world: Mat4,
        stays: bool,
    ) -> Result<(), SceneError> {
        self.kept.clear();
        if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip)
        {
            self.skip("points and lines ignored");
            return Ok(());
        }
        let uses = materials.add(&primitive.material(), world)?;
        let vertices = self.vertices(file, primitive, &uses)?;
        let indices = self.indices(file, primitive)?;
        let count = triangle_count(primitive);
        let first = self.triangles.len();
        limits::reserve(&mut self.triangles, count, "triangles", &file.path)?;
        // Moving triangles stay in their own space.
        let world = if stays { world } else { Mat4::IDENTITY };
        let normal_from_local = cofactors(Mat3::from_mat4(world));
        for i in 0..count {
            let corner = match primitive.mode() {
                Mode::TriangleStrip => [i, i + 1 + i % 2, i + 2 - i % 2],
                Mode::TriangleFan => [i + 1, i + 2, 0],
                _ => [3 * i, 3 * i + 1, 3 * i + 2],
            };
            let corner = corner.map(|c| indices.map_or(c, |indices| indices.whole(c)));
            if let Some(index) = corner.iter().find(|index| **index >= vertices.positions.count) {
                let vertices = vertices.positions.count;
                let message = format!("index {index} is beyond the {vertices} vertices");
                return Err(file.invalid(message, "the file is damaged: export it again"));
            }
            match triangle(&vertices, corner, world, normal_from_local, &uses, self.objects) {
                Ok(triangle) => {
                    self.triangles.push(triangle);
                    self.kept.push(corner);
                }
                Err(reason) => self.skip(reason),
            }
        }
        if materials.is_volume(uses.material) {
            let body = &mut self.triangles[first..];
            if volume::is_closed(body) {
                let first = body.first().map(|triangle| triangle.positions);
                volume::turn_outwards(body);
                if first != body.first().map(|triangle| triangle.positions) {
                    self.kept.iter_mut().for_each(|corners| corners.swap(1, 2));
                }
            } else {
                let is_sheet = is_sheet(body);
                let open = materials.open(uses.material, &primitive.material(), is_sheet)?;
                body.iter_mut().for_each(|triangle| triangle.material = open);
                self.skip("volumes of meshes that are not closed: by their thickness factor");
            }
        }
        self.objects += 1;
        Ok(())
    }

    fn skip(&mut self, reason: &'static str) {
        *self.skipped.entry(reason).or_default() += 1;
    }

    fn items<'f>(
        &mut self,
        file: &'f GltfFile,
        accessor: &gltf::Accessor<'_>,
    ) -> Result<Items<'f>, SceneError> {
        if self.checked.insert(accessor.index()) {
            file.check(accessor, accessor.size())?;
        }
        file.items(accessor)
    }

    fn vertices<'f>(
        &mut self,
        file: &'f GltfFile,
        primitive: &gltf::Primitive<'_>,
        uses: &Uses,
    ) -> Result<MeshVertices<'f>, SceneError> {
        let get = |semantic: Semantic, dimensions: Dimensions| match primitive.get(&semantic) {
            None => Ok(None),
            Some(accessor) if accessor.dimensions() != dimensions => {
                let message = format!("accessor {} has the wrong type", accessor.index());
                Err(file.invalid(message, "export the file again"))
            }
            some => Ok(some),
        };
        let mut vector = |semantic: Semantic| {
            let Some(accessor) = get(semantic, Dimensions::Vec3)? else { return Ok(None) };
            if accessor.data_type() == DataType::U32 {
                let message = format!("accessor {} holds no vectors", accessor.index());
                return Err(file.invalid(message, "export the file again"));
            }
            self.items(file, &accessor).map(Some)
        };
        let positions = vector(Semantic::Positions)?.ok_or_else(|| {
            file.invalid("a mesh primitive has no positions", "export the file again")
        })?;
        let normals = vector(Semantic::Normals)?;
        let uvs = match get(Semantic::TexCoords(uses.uv_set), Dimensions::Vec2)? {
            None => None,
            Some(accessor) => {
                if accessor.data_type() == DataType::U32 {
                    let message = format!("accessor {} holds no uvs", accessor.index());
                    return Err(file.invalid(message, "export the file again"));
                }
                Some(self.items(file, &accessor)?)
            }
        };
        let colors = match primitive.get(&Semantic::Colors(0)) {
            None => None,
            Some(accessor) => {
                let dimensions = accessor.dimensions();
                let is_color = matches!(dimensions, Dimensions::Vec3 | Dimensions::Vec4);
                let is_share = accessor.data_type() == DataType::F32 || accessor.normalized();
                if !is_color || !is_share {
                    let message = format!("accessor {} holds no colours", accessor.index());
                    return Err(file.invalid(message, "export the file again"));
                }
                Some((self.items(file, &accessor)?, dimensions))
            }
        };
        let of_color = colors.as_ref().map(|(items, _)| items);
        let others = [&normals, &uvs].into_iter().flatten().chain(of_color);
        if others.into_iter().any(|other| other.count != positions.count) {
            let message = "the attributes of a mesh primitive differ in count";
            return Err(file.invalid(message, "export the file again"));
        }
        Ok(MeshVertices { positions, normals, uvs, colors })
    }

    fn indices<'f>(
        &mut self,
        file: &'f GltfFile,
        primitive: &gltf::Primitive<'_>,
    ) -> Result<Option<Items<'f>>, SceneError> {
        let Some(accessor) = primitive.indices() else { return Ok(None) };
        let is_whole = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        if !is_whole || accessor.dimensions() != Dimensions::Scalar {
            let message = format!("accessor {} holds no indices", accessor.index());
            return Err(file.invalid(message, "export the file again"));
        }
        self.items(file, &accessor).map(Some)
    }
}

/// Accessor with one item per corner of triangles, strips and fans.
pub(crate) fn corners<'a>(primitive: &gltf::Primitive<'a>) -> Option<gltf::Accessor<'a>> {
    primitive.indices().or_else(|| primitive.get(&Semantic::Positions))
}

/// Number of triangles that the primitive announces, including degenerate ones.
pub(crate) fn triangle_count(primitive: &gltf::Primitive<'_>) -> usize {
    let corners = corners(primitive).map_or(0, |accessor| accessor.count());
    match primitive.mode() {
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => 0,
        Mode::TriangleStrip | Mode::TriangleFan => corners.saturating_sub(2),
        Mode::Triangles => corners / 3,
    }
}

/// Whether a ray crosses one face of an open mesh and not two: whether most of its area faces one way or its
/// opposite.
fn is_sheet(triangles: &[Triangle]) -> bool {
    let (mut whole, mut sum) = (0.0, DVec3::ZERO);
    for triangle in triangles {
        let [a, b, c] = triangle.positions.map(Vec3::as_dvec3);
        let area = (b - a).cross(c - a);
        whole += area.length();
        sum += area;
    }
    2.0 * sum.length() > whole
}

fn triangle(
    vertices: &MeshVertices<'_>,
    corner: [usize; 3],
    world: Mat4,
    normal_from_local: Mat3,
    uses: &Uses,
    id: u32,
) -> Result<Triangle, &'static str> {
    let positions =
        corner.map(|i| world.transform_point3(Vec3::from_array(vertices.positions.floats(i))));
    let uvs = vertices.uvs.map_or([Vec2::ZERO; 3], |uvs| {
        corner.map(|i| uses.transform_uv(Vec2::from_array(uvs.floats(i))))
    });
    let near = |p: &Vec3| p.is_finite() && p.abs().max_element() <= FARTHEST;
    if !positions.iter().all(near) || !uvs.iter().all(|uv| uv.is_finite()) {
        return Err("triangle not finite");
    }
    let [a, b, c] = positions.map(Vec3::as_dvec3);
    let face = (b - a).cross(c - a).try_normalize().ok_or("triangle without area")?.as_vec3();
    let normals = vertices.normals.map_or([face; 3], |normals| {
        corner.map(|i| {
            let normal = normal_from_local * Vec3::from_array(normals.floats(i));
            normal.try_normalize().unwrap_or(face)
        })
    });
    let colors = vertices.colors.map_or([VertexColor::WHITE; 3], |(colors, dimensions)| {
        corner.map(|i| {
            let rgba = match dimensions {
                Dimensions::Vec4 => Vec4::from_array(colors.floats(i)),
                _ => Vec3::from_array(colors.floats(i)).extend(1.0),
            };
            VertexColor::new(rgba)
        })
    });
    Ok(Triangle { positions, normals, uvs, colors, material: uses.material, id })
}

/// Inverse transpose times |determinant|: normals of a flattened mesh stay correct where the inverse does
/// not exist.
pub(crate) fn cofactors(m: Mat3) -> Mat3 {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign
}
