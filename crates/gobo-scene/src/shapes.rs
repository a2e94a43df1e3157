//! Unit shapes: plane, box, sphere and pane.
use glam::{Mat3, Mat4, Vec2, Vec3};
use gobo::model::{Triangle, VertexColor};
use serde::Deserialize;

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum KindOfShape {
    Plane,
    Box,
    Sphere,
    Pane,
}

/// Default subdivisions of the icosahedron: 1,280 triangles.
pub(super) const SPHERE_LEVEL: u32 = 3;
/// Most subdivisions: 327,680 triangles.
pub(super) const MAX_LEVEL: u32 = 7;

/// A shape in world space. The plane is 1x1 in xz and faces +y; the pane is 1x1 in xy and faces +z; box and
/// sphere have width 1; all are centred.
pub(super) fn shape(
    kind: KindOfShape,
    level: u32,
    transform: Mat4,
    material: u32,
    id: u32,
) -> Vec<Triangle> {
    let mut triangles = local(kind, level, material, id);
    let normals = Mat3::from_mat4(transform).inverse().transpose();
    for triangle in &mut triangles {
        triangle.positions = triangle.positions.map(|p| transform.transform_point3(p));
        triangle.normals = triangle.normals.map(|n| (normals * n).normalize_or(Vec3::Y));
    }
    triangles
}

/// Like [`shape`], in its own space.
pub(super) fn local(kind: KindOfShape, level: u32, material: u32, id: u32) -> Vec<Triangle> {
    let mut triangles = match kind {
        KindOfShape::Plane => square(Vec3::ZERO, Vec3::X, Vec3::NEG_Z),
        KindOfShape::Pane => square(Vec3::ZERO, Vec3::X, Vec3::Y),
        KindOfShape::Box => [Vec3::X, Vec3::Y, Vec3::Z]
            .iter()
            .flat_map(|&n| [n, -n])
            .flat_map(|n| {
                let up = if n.y.abs() > 0.5 { Vec3::Z } else { Vec3::Y };
                square(n * 0.5, up.cross(n), up)
            })
            .collect(),
        KindOfShape::Sphere => sphere(level),
    };
    for triangle in &mut triangles {
        triangle.material = material;
        triangle.id = id;
    }
    triangles
}

fn square(center: Vec3, right: Vec3, up: Vec3) -> Vec<Triangle> {
    let corner = |u: f32, v: f32| (center + right * (u - 0.5) + up * (0.5 - v), Vec2::new(u, v));
    let (a, b, c, d) = (corner(0.0, 1.0), corner(1.0, 1.0), corner(1.0, 0.0), corner(0.0, 0.0));
    let normal = right.cross(up);
    [[a, b, c], [a, c, d]]
        .map(|corners| Triangle {
            positions: corners.map(|(position, _)| position),
            normals: [normal; 3],
            uvs: corners.map(|(_, uv)| uv),
            colors: [VertexColor::WHITE; 3],
            material: 0,
            id: 0,
        })
        .to_vec()
}

/// Number of triangles of [`shape`].
pub(super) fn triangles_of(kind: KindOfShape, level: u32) -> usize {
    match kind {
        KindOfShape::Plane | KindOfShape::Pane => 2,
        KindOfShape::Box => 12,
        KindOfShape::Sphere => sphere_triangles(level),
    }
}

/// Number of triangles of a sphere.
pub(super) fn sphere_triangles(level: u32) -> usize {
    20 << (2 * level)
}

pub(super) fn sphere(level: u32) -> Vec<Triangle> {
    let mut faces = icosahedron();
    for _ in 0..level {
        faces = faces
            .into_iter()
            .flat_map(|[a, b, c]| {
                let middle = |p: Vec3, q: Vec3| (p + q).normalize();
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let uv = |n: Vec3| {
        Vec2::new(0.5 + n.x.atan2(n.z) / std::f32::consts::TAU, n.y.acos() / std::f32::consts::PI)
    };
    faces
        .into_iter()
        .map(|corners| Triangle {
            positions: corners.map(|n| n * 0.5),
            normals: corners,
            uvs: corners.map(uv),
            colors: [VertexColor::WHITE; 3],
            material: 0,
            id: 0,
        })
        .collect()
}

fn icosahedron() -> Vec<[Vec3; 3]> {
    let golden = f32::midpoint(1.0, 5f32.sqrt());
    let corner = |x: f32, y: f32, z: f32| Vec3::new(x, y, z).normalize();
    let p = [
        corner(-1.0, golden, 0.0),
        corner(1.0, golden, 0.0),
        corner(-1.0, -golden, 0.0),
        corner(1.0, -golden, 0.0),
        corner(0.0, -1.0, golden),
        corner(0.0, 1.0, golden),
        corner(0.0, -1.0, -golden),
        corner(0.0, 1.0, -golden),
        corner(golden, 0.0, -1.0),
        corner(golden, 0.0, 1.0),
        corner(-golden, 0.0, -1.0),
        corner(-golden, 0.0, 1.0),
    ];
    const FACES: [[usize; 3]; 20] = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    FACES.iter().map(|face| face.map(|i| p[i])).collect()
}
