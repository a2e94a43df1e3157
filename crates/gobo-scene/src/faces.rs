//! Faces of files without nodes, as triangles.
use super::particles::FARTHEST;
use glam::{Vec2, Vec3};
use gobo::model::{Material, Skipped, Texture, Triangle, VertexColor};

/// Vertex normals are smooth on faces that are turned by less than this from the mean of the faces around the
/// vertex: the edges of a cube stay sharp [cosine of 45 degrees].
const SMOOTH: f32 = std::f32::consts::FRAC_1_SQRT_2;

/// Faces of a file and their vertex attributes.
#[derive(Debug, Default)]
pub(super) struct Surface {
    pub(super) vertices: Vertices,
    pub(super) faces: Vec<Face>,
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Texture>,
    pub(super) skipped: Skipped,
    pub(super) notes: Vec<String>,
}

/// Indexed vertices.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    pub(super) positions: Vec<Vec3>,
    /// Empty if the file has none.
    pub(super) normals: Vec<Vec3>,
    pub(super) uvs: Vec<Vec2>,
    /// Colour of each position, or empty.
    pub(super) colors: Vec<VertexColor>,
}

/// Three corners by their vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    pub(super) positions: [usize; 3],
    pub(super) normals: Option<[usize; 3]>,
    pub(super) uvs: Option<[usize; 3]>,
    pub(super) material: u32,
    pub(super) id: u32,
}

impl Vertices {
    /// The faces as triangles, in the file's space; degenerate ones are counted.
    pub(super) fn triangles(&self, faces: &[Face], skipped: &mut Skipped) -> Vec<Triangle> {
        let smooth = if self.normals.is_empty() { self.smooth_normals(faces) } else { Vec::new() };
        let mut triangles = Vec::with_capacity(faces.len());
        for face in faces {
            match self.triangle(face, &smooth) {
                Ok(triangle) => triangles.push(triangle),
                Err(reason) => *skipped.entry(reason).or_default() += 1,
            }
        }
        triangles
    }

    /// Mean normals of the faces around each vertex, weighted by their angles there (Thuermer and Wuethrich
    /// 1998).
    fn smooth_normals(&self, faces: &[Face]) -> Vec<Vec3> {
        let mut sums = vec![Vec3::ZERO; self.positions.len()];
        for face in faces {
            let Some(corners) = all(&self.positions, face.positions) else { continue };
            let Some(normal) = normal(corners) else { continue };
            for (k, vertex) in face.positions.into_iter().enumerate() {
                let [at, a, b] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
                let angle = (a - at).angle_between(b - at);
                if angle.is_finite() {
                    sums[vertex] += normal * angle;
                }
            }
        }
        sums
    }

    fn triangle(&self, face: &Face, smooth: &[Vec3]) -> Result<Triangle, &'static str> {
        let positions = all(&self.positions, face.positions).ok_or("face without its vertices")?;
        let near = |p: &Vec3| p.is_finite() && p.abs().max_element() <= FARTHEST;
        let uvs = face.uvs.and_then(|corners| all(&self.uvs, corners)).unwrap_or_default();
        if !positions.iter().all(near) || !uvs.iter().all(|uv| uv.is_finite()) {
            return Err("triangle not finite");
        }
        let flat = normal(positions).ok_or("triangle without area")?;
        let of_file = face.normals.and_then(|corners| all(&self.normals, corners));
        let normals = match (of_file, all(smooth, face.positions)) {
            (Some(normals), _) => normals.map(|n| n.try_normalize().unwrap_or(flat)),
            (None, Some(means)) => means.map(|mean| {
                let mean = mean.try_normalize().unwrap_or(flat);
                if mean.dot(flat) > SMOOTH { mean } else { flat }
            }),
            (None, None) => [flat; 3],
        };
        let colors = all(&self.colors, face.positions).unwrap_or_default();
        Ok(Triangle { positions, normals, uvs, colors, material: face.material, id: face.id })
    }
}

fn all<T: Copy>(items: &[T], corners: [usize; 3]) -> Option<[T; 3]> {
    let [a, b, c] = corners.map(|corner| items.get(corner).copied());
    Some([a?, b?, c?])
}

fn normal(corners: [Vec3; 3]) -> Option<Vec3> {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    Some((b - a).cross(c - a).try_normalize()?.as_vec3())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box has sharp edges, a finely divided cylinder none.
    #[test]
    fn only_flat_edges_are_smooth() {
        let square = |corners: [usize; 4]| {
            let [a, b, c, d] = corners;
            [[a, b, c], [a, c, d]]
        };
        let face = |positions| Face { positions, normals: None, uvs: None, material: 0, id: 0 };
        let corner = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        let cube = Vertices { positions: (0..8).map(corner).collect(), ..Vertices::default() };
        let sides =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces: Vec<Face> = sides.into_iter().flat_map(square).map(face).collect();
        for triangle in cube.triangles(&faces, &mut Skipped::new()) {
            let axis = triangle.normals[0].abs();
            assert!(
                triangle.normals.iter().all(|n| *n == triangle.normals[0])
                    && axis.max_element() > 0.999
            );
            // Normals point outwards.
            assert!(triangle.normals[0].dot(triangle.positions[0] - Vec3::splat(0.5)) > 0.0);
        }
        let ring = |i: usize| {
            let angle = (i / 2) as f32 * std::f32::consts::TAU / 32.0;
            Vec3::new(angle.cos(), (i % 2) as f32, angle.sin())
        };
        let tube = Vertices { positions: (0..64).map(ring).collect(), ..Vertices::default() };
        let side = |i: usize| square([2 * i, 2 * i + 1, (2 * i + 3) % 64, (2 * i + 2) % 64]);
        let faces: Vec<Face> = (0..32).flat_map(side).map(face).collect();
        for triangle in tube.triangles(&faces, &mut Skipped::new()) {
            for (n, p) in triangle.normals.iter().zip(triangle.positions) {
                assert!(n.dot(Vec3::new(p.x, 0.0, p.z)) > 0.999, "{n} at {p}");
            }
        }
    }
}
