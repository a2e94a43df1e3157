//! Re-centring of scenes far from the origin, so that positions keep their precision.
use glam::{Vec3, Vec3A};
use gobo::{Bounds, LightKind, Scene, model::GaussianOpacity};

/// Largest unnoticed error of a shadow, as a share of a particle's or the scene's radius: 1/256 of the radius
/// is 0.6% of a soft disc's opacity.
const SEEN: f32 = 1.0 / 256.0;
/// Distance from the origin, in sizes of the scene, from which an axis is re-centred.
const FAR: f32 = 8.0;

/// Moves the scene near the origin if its distance costs visible precision, and stores the offset in
/// [`Scene::origin`]. Exact: the offset is a multiple of a power of two as large as the scene. Axes with
/// enough precision stay.
pub fn recentre(scene: &mut Scene) {
    let bounds = scene.bounds();
    let Some((error, size)) = rounding(scene, &bounds) else { return };
    // Transforms round several times.
    if error <= size * SEEN / 16.0 {
        return;
    }
    let grid = bounds.radius().max(1e-3).log2().ceil().exp2();
    let middle = bounds.center();
    let whole = (middle / grid).round() * grid;
    let by = Vec3::select(middle.abs().cmpgt(Vec3::splat(FAR * grid)), whole, Vec3::ZERO);
    if by == Vec3::ZERO {
        return;
    }
    scene.camera.eye -= by;
    scene.camera.target -= by;
    if !scene.around.is_empty() {
        scene.around = Bounds { min: scene.around.min - by, max: scene.around.max - by };
    }
    for particle in &mut scene.particles {
        particle.center -= by;
    }
    for gaussian in &mut scene.gaussians {
        gaussian.center -= by;
    }
    for grid in &mut scene.grids {
        grid.world_from_index.translation -= Vec3A::from(by);
    }
    for vertex in scene.strands.iter_mut().flat_map(|strand| &mut strand.vertices) {
        vertex.position -= by;
    }
    for corner in scene.triangles.iter_mut().flat_map(|triangle| &mut triangle.positions) {
        *corner -= by;
    }
    for light in &mut scene.lights {
        move_light(&mut light.kind, by);
        light.shadows.iter_mut().for_each(|shadow| move_light(&mut shadow.kind, by));
    }
    for motion in &mut scene.motions {
        if let Some(moved) = motion.moved(-by) {
            *motion = moved;
        }
    }
    scene.origin += by;
}

/// Rounding of positions, and the size to compare it with \[m\]; `None` for an empty scene.
fn rounding(scene: &Scene, bounds: &Bounds) -> Option<(f32, f32)> {
    if bounds.is_empty() {
        return None;
    }
    let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
    let radii = scene.particles.iter().map(|particle| particle.radius);
    let reaches = scene.gaussians.iter().map(|gaussian| gaussian.radius(GaussianOpacity::Splat));
    let vertices = scene.strands.iter().flat_map(|strand| &strand.vertices);
    let strands = vertices.map(|vertex| vertex.radius);
    let mut radii: Vec<f32> = radii.chain(reaches).chain(strands).collect();
    radii.sort_unstable_by(f32::total_cmp);
    // Without particles, the edge of a map's texel is the size.
    // Nor where shares of them must have the same origin.
    let size = radii.get(radii.len() / 2).copied().filter(|_| scene.around.is_empty());
    let size = size.unwrap_or_else(|| bounds.radius() / scene.shadow.size as f32);
    Some((farthest * f32::EPSILON, size))
}

/// Warning about precision lost by the scene's size or position; `None` if the error is invisible.
/// Positions have 24 bits: 10 km from [`Scene::origin`] they are rounded to a millimetre, which moves
/// the shadows of small particles.
pub fn rounding_warning(scene: &Scene) -> Option<String> {
    let bounds = scene.bounds();
    let (error, size) = rounding(scene, &bounds)?;
    (error > size * SEEN).then(|| {
        let millimetres = error * 1000.0;
        let farthest = error / f32::EPSILON;
        format!(
            "the scene reaches {farthest:.0} m from the origin, where positions are rounded to \
             {millimetres:.2} mm: shadows are off by up to that much; move the scene, its camera \
             and its lights towards the origin"
        )
    })
}

fn move_light(kind: &mut LightKind, by: Vec3) {
    if let LightKind::Spot { position, .. } | LightKind::Point { position } = kind {
        *position -= by;
    }
}
