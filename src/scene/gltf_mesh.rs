//! glTF primitives as triangles in world space.
use super::{
    SceneError,
    gltf_file::File,
    gltf_material::{Materials, Uses},
    particles::FARTHEST,
};
use crate::model::{Skipped, Triangle, volume};
use ::gltf::{
    Semantic,
    accessor::{DataType, Dimensions},
    mesh::Mode,
};
use glam::{Mat3, Mat4, Vec2, Vec3};

/// A small file can name one mesh many times.
const MAX_TRIANGLES: usize = 1 << 24;

#[derive(Debug, Default)]
pub(super) struct Meshes {
    pub(super) triangles: Vec<Triangle>,
    /// Primitives so far: ids of their triangles.
    objects: u32,
    pub(super) skipped: Skipped,
}

/// What a corner of a triangle needs.
#[derive(Debug)]
struct Vertices {
    positions: Vec<Vec3>,
    normals: Option<Vec<Vec3>>,
    uvs: Option<Vec<Vec2>>,
}

impl Meshes {
    pub(super) fn add(
        &mut self,
        file: &File,
        materials: &mut Materials<'_>,
        primitive: &gltf::Primitive<'_>,
        world: Mat4,
    ) -> Result<(), SceneError> {
        if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip)
        {
            self.skip("points and lines ignored");
            return Ok(());
        }
        if primitive.get(&Semantic::Colors(0)).is_some() {
            self.skip("vertex colours ignored");
        }
        if primitive.morph_targets().len() > 0 {
            self.skip("morph targets ignored");
        }
        let uses = materials.add(&primitive.material(), world)?;
        let vertices = read_vertices(file, primitive, &uses, world)?;
        let indices = read_indices(file, primitive, vertices.positions.len())?;
        let corners: Vec<[usize; 3]> = match primitive.mode() {
            Mode::TriangleStrip => (2..indices.len())
                .map(|i| {
                    let odd = i % 2;
                    [indices[i - 2], indices[i - 1 + odd], indices[i - odd]]
                })
                .collect(),
            Mode::TriangleFan => {
                indices.windows(2).skip(1).map(|pair| [pair[0], pair[1], indices[0]]).collect()
            }
            _ => indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
        };
        if self.triangles.len() + corners.len() > MAX_TRIANGLES {
            let message = format!("has more than {MAX_TRIANGLES} triangles");
            return Err(file.invalid(message, "simplify the meshes, or name them less often"));
        }
        let first = self.triangles.len();
        self.triangles.reserve(corners.len());
        for corner in corners {
            match triangle(&vertices, corner, uses.material, self.objects) {
                Ok(triangle) => self.triangles.push(triangle),
                Err(reason) => self.skip(reason),
            }
        }
        if materials.is_volume(uses.material) {
            let body = &mut self.triangles[first..];
            if volume::is_closed(body) {
                volume::turn_outwards(body);
            } else {
                let open = materials.open(uses.material);
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
}

fn triangle(
    vertices: &Vertices,
    corner: [usize; 3],
    material: u32,
    id: u32,
) -> Result<Triangle, &'static str> {
    let positions = corner.map(|i| vertices.positions[i]);
    let uvs = vertices.uvs.as_ref().map_or([Vec2::ZERO; 3], |uvs| corner.map(|i| uvs[i]));
    let near = |p: &Vec3| p.is_finite() && p.abs().max_element() <= FARTHEST;
    if !positions.iter().all(near) || !uvs.iter().all(|uv| uv.is_finite()) {
        return Err("triangle not finite");
    }
    let [a, b, c] = positions.map(Vec3::as_dvec3);
    let face = (b - a).cross(c - a).try_normalize().ok_or("triangle without area")?.as_vec3();
    let normals = match &vertices.normals {
        Some(normals) => corner.map(|i| normals[i].try_normalize().unwrap_or(face)),
        None => [face; 3],
    };
    Ok(Triangle { positions, normals, uvs, material, id })
}

fn read_vertices(
    file: &File,
    primitive: &gltf::Primitive<'_>,
    uses: &Uses,
    world: Mat4,
) -> Result<Vertices, SceneError> {
    let get = |semantic: Semantic, dimensions: Dimensions| match primitive.get(&semantic) {
        None => Ok(None),
        Some(accessor) if accessor.dimensions() != dimensions => {
            let message = format!("accessor {} has the wrong type", accessor.index());
            Err(file.invalid(message, "export the file again"))
        }
        some => Ok(some),
    };
    let vector = |semantic: Semantic| {
        let Some(accessor) = get(semantic, Dimensions::Vec3)? else { return Ok(None) };
        if accessor.data_type() != DataType::F32 {
            let message = format!("accessor {} is quantized", accessor.index());
            return Err(file.invalid(message, "export without mesh quantization"));
        }
        file.check(&accessor, 12)?;
        Ok(Some(accessor))
    };
    let reader = primitive.reader(|buffer| file.buffer(&buffer));
    let no_positions =
        || file.invalid("a mesh primitive has no positions", "export the file again");
    vector(Semantic::Positions)?.ok_or_else(no_positions)?;
    let positions: Vec<Vec3> = reader
        .read_positions()
        .ok_or_else(no_positions)?
        .map(|p| world.transform_point3(p.into()))
        .collect();
    let normals = match vector(Semantic::Normals)? {
        None => None,
        Some(_) => {
            let normal_from_local = cofactors(Mat3::from_mat4(world));
            let normals = reader.read_normals().into_iter().flatten();
            Some(normals.map(|n| normal_from_local * Vec3::from(n)).collect::<Vec<_>>())
        }
    };
    let uvs = match get(Semantic::TexCoords(uses.uv_set), Dimensions::Vec2)? {
        None => None,
        Some(accessor) => {
            let size = match accessor.data_type() {
                DataType::F32 => 8,
                DataType::U16 => 4,
                DataType::U8 => 2,
                _ => {
                    let message = format!("accessor {} holds no uvs", accessor.index());
                    return Err(file.invalid(message, "export the file again"));
                }
            };
            file.check(&accessor, size)?;
            let uvs = reader.read_tex_coords(uses.uv_set).into_iter();
            let uvs = uvs.flat_map(gltf::mesh::util::ReadTexCoords::into_f32);
            Some(uvs.map(|uv| uses.transform_uv(uv.into())).collect::<Vec<_>>())
        }
    };
    let count = positions.len();
    let others = [normals.as_ref().map(Vec::len), uvs.as_ref().map(Vec::len)];
    if others.into_iter().flatten().any(|other| other != count) {
        let message = "the attributes of a mesh primitive differ in count";
        return Err(file.invalid(message, "export the file again"));
    }
    Ok(Vertices { positions, normals, uvs })
}

/// Inverse transpose times |determinant|: normals of a flattened mesh stay right where the inverse
/// does not exist.
fn cofactors(m: Mat3) -> Mat3 {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign
}

fn read_indices(
    file: &File,
    primitive: &gltf::Primitive<'_>,
    vertex_count: usize,
) -> Result<Vec<usize>, SceneError> {
    let Some(accessor) = primitive.indices() else { return Ok((0..vertex_count).collect()) };
    let size = match (accessor.data_type(), accessor.dimensions()) {
        (DataType::U8, Dimensions::Scalar) => 1,
        (DataType::U16, Dimensions::Scalar) => 2,
        (DataType::U32, Dimensions::Scalar) => 4,
        _ => {
            let message = format!("accessor {} holds no indices", accessor.index());
            return Err(file.invalid(message, "export the file again"));
        }
    };
    file.check(&accessor, size)?;
    let reader = primitive.reader(|buffer| file.buffer(&buffer));
    let indices = reader.read_indices().into_iter();
    let indices: Vec<usize> =
        indices.flat_map(gltf::mesh::util::ReadIndices::into_u32).map(|i| i as usize).collect();
    if let Some(index) = indices.iter().find(|index| **index >= vertex_count) {
        let message = format!("index {index} is beyond the {vertex_count} vertices");
        return Err(file.invalid(message, "the file is damaged: export it again"));
    }
    Ok(indices)
}
