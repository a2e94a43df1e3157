//! `camera.lens`: the blur of defocused objects against a thin lens's circle of confusion. `camera.shutter`:
//! motion blur against the time that an object covers a pixel.
use crate::common::{
    TIERS, gpu,
    scenes::{empty, material, triangle},
};
use gobo::{
    Camera, Material, Transfer,
    glam::{UVec2, Vec3},
    model::Lens,
    records::Picture,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::Scene;

/// A strip of pixels whose middle row is measured.
const SIZE: UVec2 = UVec2::new(64, 16);
/// Tangent of half the strip's vertical angle.
const TANGENT: f32 = 0.05;
const FOCUS: f32 = 5.0;

/// A shining half plane, at a distance from a lens focused at [`FOCUS`].
fn half_plane(distance: f32, radius: f32) -> Scene {
    let mut scene = empty(vec![Material { emission: Vec3::ONE, ..material(Transfer::Opaque) }]);
    scene.camera = Camera {
        eye: Vec3::Z * FOCUS,
        target: Vec3::ZERO,
        up: Vec3::Y,
        fov_y: 2.0 * TANGENT.atan(),
        size: SIZE,
    };
    let z = FOCUS - distance;
    let corners = [Vec3::new(0.0, -90.0, z), Vec3::new(0.0, 90.0, z), Vec3::new(-90.0, 0.0, z)];
    scene.triangles = vec![triangle(corners, 0)];
    (scene.samples, scene.lens) = (64, Lens { radius, focus: None });
    scene
}

/// Share of a disc's area to the right of a distance from its middle [radii].
fn covered(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    (x.acos() - x * (1.0 - x * x).sqrt()) / std::f64::consts::PI
}

fn middle_row(picture: &Picture) -> &[[f32; 3]] {
    &picture.light[(SIZE.x * SIZE.y / 2) as usize..][..SIZE.x as usize]
}

#[test]
fn blur_is_the_circle_of_confusion() {
    const RADIUS: f32 = 0.2;
    let options = RenderOptions { light: true, ..RenderOptions::default() };
    let scale = f64::from(SIZE.y) * 0.5 / f64::from(TANGENT);
    for distance in [2.5, FOCUS, 9.0] {
        let scene = half_plane(distance, RADIUS);
        let (near, far) = (f64::from(distance), f64::from(FOCUS));
        // Radius in the picture [pixels].
        let blur = f64::from(RADIUS) * (1.0 / near - 1.0 / far).abs() * scale;
        for mut renderer in [Renderer::on(gpu(TIERS[0])).unwrap(), Renderer::on_cpu()] {
            let picture = renderer.render(&scene, &options).unwrap().picture;
            let row = middle_row(&picture);
            let mut error = 0.0_f64;
            for (x, light) in row.iter().enumerate() {
                let off = x as f64 + 0.5 - f64::from(SIZE.x) * 0.5;
                let expected =
                    if blur > 1.0 { covered(off / blur) } else { (0.5 - off).clamp(0.0, 1.0) };
                error = error.max((f64::from(light[0]) - expected).abs());
            }
            assert!(error < 0.09, "{distance} m, {blur} pixels: {error}");
        }
    }
}

/// A ball crosses the picture evenly while the shutter is open: each pixel has the share of the time in which
/// the ball covers it. Without a shutter the frame is that of its time.
#[test]
fn what_moves_is_blurred_as_far_as_it_moves() {
    let ([width, height], fov_y) = (SIZE.to_array(), 2.0 * TANGENT.atan().to_degrees());
    let toml = format!(
        "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nfov_y = {fov_y}\nsize = [{width}, {height}]\n\
         samples = 32\n\
         shutter = 0.5\nocclusion = false\n[environment]\nambient = [0, 0, 0]\nbackground = [0, 0, 0]\n\
         [[light]]\nkind = 'directional'\ndirection = [0, -1, 0]\nintensity = 0\n\
         [[material]]\nname = 'lamp'\ntransfer = 'opaque'\ntint = [0, 0, 0, 1]\nemission = [1, 1, 1]\n\
         [[shape]]\nname = 'bar'\nkind = 'box'\nmaterial = 'lamp'\nscale = [0.2, 9, 0.001]\n\
         [[animate]]\ntarget = 'shape.bar.translation'\ntimes = [0, 1]\nvalues = [[-4, 0, 0], [4, 0, 0]]\n"
    );
    let options = RenderOptions { light: true, ..RenderOptions::default() };
    let metre = f64::from(SIZE.y) * 0.5 / f64::from(TANGENT) / 5.0;
    for mut renderer in [Renderer::on(gpu(TIERS[0])).unwrap(), Renderer::on_cpu()] {
        let mut scene = crate::common::files::read(&toml).unwrap();
        // In a tenth of a second it moves 0.8 m; the shutter is open for 0.4 m of that.
        let picture = renderer.render_at(&mut scene, 0.5, 0.1, &options).unwrap().picture;
        let row = middle_row(&picture);
        for (x, light) in row.iter().enumerate() {
            let off = ((x as f64 + 0.5 - f64::from(SIZE.x) * 0.5) / metre).abs();
            // A bar of 0.2 m on a path of 0.4 m.
            let share = ((0.3 - off) / 0.4).clamp(0.0, 0.5);
            let found = f64::from(light[0]);
            assert!((found - share).abs() < 0.08, "{x}: {found}, not {share}");
        }
        scene.shutter = 0.0;
        let still = renderer.render_at(&mut scene, 0.5, 0.1, &options).unwrap().picture;
        scene.set_time(0.5);
        assert_eq!(still.light, renderer.render(&scene, &options).unwrap().picture.light);
    }
}
