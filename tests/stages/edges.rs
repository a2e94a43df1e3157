//! Edges that triangles share, on devices whose compilers round a product and a difference at once (`a * b -
//! c * d` as `fma(a, b, -(c * d))` or as `fma(-c, d, a * b)`), each kernel and triangle in its own way: a
//! texel is in one of the two.
use crate::common::scenes::{Chance, flat_view};
use gobo::{
    glam::{UVec2, Vec2, Vec3},
    model::Triangle,
    records::{TriangleRecord, TriangleSetup},
};
use gobo_reference::project::{ProjectParams, project_triangle};

const SIZE: u32 = 64;

/// Products of an edge function, as all compilers round them.
fn products(setup: &TriangleSetup, i: usize, texel: Vec2) -> [f32; 2] {
    let line = setup.edges[i];
    [line.z * (texel.y - line.y), line.w * (texel.x - line.x)]
}

/// The edge function as a compiler may round it.
fn contracted(setup: &TriangleSetup, i: usize, texel: Vec2, form: usize) -> f32 {
    let line = setup.edges[i];
    let [first, second] = products(setup, i, texel);
    match form {
        0 => first - second,
        1 => line.z.mul_add(texel.y - line.y, -second),
        _ => (-line.w).mul_add(texel.x - line.x, first),
    }
}

/// Whether a texel is inside of all edges: the first of each edge's numbers is larger, or equal and the edge
/// its own.
fn is_inside(setup: &TriangleSetup, numbers: impl Fn(usize) -> [f32; 2]) -> bool {
    (0..3).all(|i| {
        let [first, second] = numbers(i);
        first > second || (first == second && setup.ties >> i & 1 == 1)
    })
}

/// Two triangles on the two sides of an edge, in texels.
fn neighbours(chance: &mut Chance) -> [TriangleSetup; 2] {
    let view = flat_view(SIZE, 1.0).to_gpu(0, UVec2::ZERO, 0);
    let mut corner = || Vec3::new(chance.within(-31.0, 31.0), chance.within(-31.0, 31.0), -5.0);
    let (a, b) = (corner(), corner());
    // Their far corners are across the edge from each other.
    let across = (b - a).cross(Vec3::Z).normalize_or(Vec3::X) * 25.0;
    let middle = (a + b) * 0.5;
    let params = ProjectParams { scatter: false, include_non_casters: false, by_distance: false };
    [across, -across].map(|across| {
        let record = TriangleRecord::new(&Triangle::flat([a, middle + across, b], 0));
        project_triangle(&view, 0, &record, 0, 0, params).1
    })
}

/// Texels at most a hundred-thousandth from the shared edge: centres seldom are, so the texel's place is
/// chosen.
fn texel_beside(setup: &TriangleSetup, chance: &mut Chance) -> Vec2 {
    let line = setup.edges[1];
    let along = Vec2::new(line.z, line.w);
    let on_edge = Vec2::new(line.x, line.y) + along * chance.within(-1.0, 1.0);
    on_edge + along.perp().normalize_or(Vec2::X) * chance.within(-1e-5, 1e-5)
}

#[test]
fn texels_beside_a_shared_edge_are_in_one_triangle() {
    let mut chance = Chance::new(3);
    let (mut beside, mut apart) = (0, 0);
    for _ in 0..20_000 {
        let [a, b] = neighbours(&mut chance);
        let texel = texel_beside(&a, &mut chance);
        let [in_a, in_b] = [&a, &b].map(|setup| is_inside(setup, |i| products(setup, i, texel)));
        // Behind an end of the edge it is in neither.
        let is_of_both = [&a, &b]
            .iter()
            .all(|setup| [0, 2].iter().all(|&i| contracted(setup, i, texel, 0) > 1e-2));
        if !is_of_both {
            continue;
        }
        beside += 1;
        assert!(in_a != in_b, "{texel}: in {in_a} and {in_b}");
        for (of_a, of_b) in (0..3).flat_map(|a| (0..3).map(move |b| (a, b))) {
            let inside =
                |setup, form| is_inside(setup, |i| [contracted(setup, i, texel, form), 0.0]);
            let [in_a, in_b] = [inside(&a, of_a), inside(&b, of_b)];
            if of_a == of_b {
                assert!(in_a != in_b, "{texel}: form {of_a}, in {in_a} and {in_b}");
            } else {
                apart += u32::from(in_a == in_b);
            }
        }
    }
    // The signs of the functions, rounded in two ways, would leave gaps and overlaps.
    assert!(beside > 5000 && apart > 100, "{beside} texels, {apart}");
}
