//! Debug picture of the cascades.
use crate::picture::PreparedPicture;
use glam::{Vec2, Vec3};
use gobo::{
    Error,
    gpu::Gpu,
    model::Scene,
    model::{View, ViewRole},
    records::Picture,
};

/// Colours of the cascades, near to far.
const COLORS: [[f32; 3]; 6] = [
    [1.0, 0.35, 0.3],
    [0.4, 0.9, 0.35],
    [0.35, 0.55, 1.0],
    [1.0, 0.85, 0.3],
    [0.85, 0.4, 1.0],
    [0.35, 0.95, 0.95],
];

/// Surfaces tinted by the colour of their cascade, for the first light with cascades; grey beyond the last. A
/// surface between two cascades has the colour of the nearer one. Blocks.
pub(crate) fn cascades(
    gpu: &Gpu,
    prepared: &PreparedPicture,
    scene: &Scene,
    views: &[View],
    picture: &Picture,
) -> Result<Picture, Error> {
    let is_cascade =
        |view: &View| matches!(view.role, ViewRole::Window { .. }) && !view.is_detail();
    let first = views.iter().position(is_cascade);
    let windows = first.map_or(&[][..], |first| {
        let count = match views[first].role {
            ViewRole::Window { count, .. } => count as usize,
            _ => 0,
        };
        &views[first..(first + count).min(views.len())]
    });
    let surfaces = prepared.read_radiance(gpu)?;
    let camera = View::from_camera(&scene.camera, &scene.held_bounds());
    let world_from_view = camera.view_from_world.inverse();
    let width = picture.size.x as usize;
    let rgb = picture.rgb.iter().zip(&surfaces).enumerate().map(|(i, (&rgb, &[.., depth]))| {
        let pixel = Vec2::new((i % width) as f32, (i / width) as f32) + 0.5;
        let distance = camera.near + depth * (camera.far - camera.near);
        let slope = (pixel - camera.size.as_vec2() * 0.5) / camera.scale;
        let point = Vec3::new(slope.x, -slope.y, -1.0) * distance;
        let point = world_from_view.transform_point3(point);
        let cascade = windows.iter().position(|view| depth < 1.0 && holds(view, point));
        let color = cascade.map_or([0.6; 3], |cascade| COLORS[cascade % COLORS.len()]);
        let [r, g, b] = rgb.map(f32::from);
        let luminance = 40.0 + 0.84 * (0.2126 * r + 0.7152 * g + 0.0722 * b);
        color.map(|c| (c * luminance) as u8)
    });
    Ok(Picture { size: picture.size, rgb: rgb.collect(), light: Vec::new() })
}

/// Whether the view's map contains a point together with its filter.
fn holds(view: &View, point: Vec3) -> bool {
    let p = view.view_from_world.transform_point3(point);
    let position = Vec2::new(p.x, -p.y) * view.scale + view.size.as_vec2() * 0.5;
    let border = position.min(view.size.as_vec2() - position).min_element();
    border > 1.5 && (view.near..=view.far).contains(&-p.z)
}
