//! A pixel of a picture, and the point visible in it.
use gobo::{
    Camera, Scene,
    glam::{UVec2, Vec2, Vec3},
    model::Lens,
};
use gobo_reference::{Surface, surfaces};

/// A position in a camera's picture, right and down, 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pick {
    pub(super) camera: Camera,
    pub(super) at: Vec2,
}

/// Right, up and forward of a camera.
fn axes(camera: &Camera) -> [Vec3; 3] {
    let forward = (camera.target - camera.eye).normalize();
    let right = forward.cross(camera.up).normalize();
    [right, right.cross(forward), forward]
}

/// Half of the width and height of the picture at a distance of 1.
fn half(camera: &Camera) -> Vec2 {
    let size = camera.size.as_vec2();
    Vec2::new(size.x / size.y, 1.0) * (camera.fov_y / 2.0).tan()
}

impl Pick {
    /// A camera of one pixel, aimed at the position.
    fn camera_of_one_pixel(&self) -> Camera {
        let camera = self.camera;
        let [right, up, forward] = axes(&camera);
        let [x, y] = ((self.at * 2.0 - 1.0) * half(&camera)).to_array();
        let pixel = 2.0 * half(&camera).y / camera.size.y as f32;
        let target = camera.eye + (forward + right * x - up * y).normalize();
        Camera { target, fov_y: 2.0 * (pixel / 2.0).atan(), size: UVec2::ONE, ..camera }
    }

    /// The nearest opaque surface at the position. The scene is unchanged afterwards.
    pub(super) fn surface(&self, scene: &mut Scene) -> Option<Surface> {
        let own = (scene.camera, scene.samples, scene.lens);
        (scene.camera, scene.samples) = (self.camera_of_one_pixel(), 1);
        scene.lens = Lens::default();
        let found = surfaces(scene, 0, None);
        (scene.camera, scene.samples, scene.lens) = own;
        found.first().copied().flatten()
    }
}

/// Position of a point in the camera's picture, right and down, 0..1; `None` if it is behind the eye or
/// outside the picture.
pub(super) fn place(camera: &Camera, point: Vec3) -> Option<Vec2> {
    let [right, up, forward] = axes(camera);
    let arm = point - camera.eye;
    let ahead = arm.dot(forward);
    let at = Vec2::new(arm.dot(right), -arm.dot(up)) / ahead / half(camera) * 0.5 + 0.5;
    (ahead > 0.0 && at.min_element() >= 0.0 && at.max_element() <= 1.0).then_some(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gobo::{Bounds, Material, Transfer, Triangle, View};

    fn camera() -> Camera {
        Camera {
            eye: Vec3::new(3.0, 2.0, -4.0),
            target: Vec3::new(0.5, 1.0, 0.25),
            fov_y: 0.7,
            size: UVec2::new(640, 400),
            ..Camera::default()
        }
    }

    #[test]
    fn a_place_is_where_the_pictures_view_has_it() {
        let (camera, point) = (camera(), Vec3::new(0.1, 0.4, 0.6));
        let view = View::from_camera(&camera, &Bounds { min: -Vec3::ONE, max: Vec3::ONE });
        let seen = view.view_from_world.transform_point3(point);
        let tangent = 0.35_f32.tan();
        let expected = Vec2::new(seen.x / 1.6, -seen.y) / -seen.z / tangent * 0.5 + 0.5;
        let found = place(&camera, point).unwrap();
        assert!(found.distance(expected) < 1e-5, "{found} is not {expected}");
        assert_eq!(place(&camera, camera.eye * 2.0 - camera.target), None);
    }

    #[test]
    fn the_pixel_sees_what_is_at_its_place() {
        let corners = [[-9.0, 0.5, -9.0], [9.0, 0.5, -9.0], [0.0, 0.5, 15.0]];
        let mut scene = Scene {
            materials: vec![Material { transfer: Transfer::Opaque, ..Material::default() }],
            triangles: vec![Triangle::flat(corners, 0)],
            ..Scene::default()
        };
        let own = scene.camera;
        let point = Vec3::new(0.4, 0.5, -0.3);
        let at = place(&camera(), point).unwrap();
        let surface = Pick { camera: camera(), at }.surface(&mut scene).unwrap();
        assert!(surface.position.distance(point) < 1e-3, "{}", surface.position);
        assert!(surface.normal.y.abs() > 0.999);
        let above = Pick { camera: camera(), at: Vec2::new(0.5, 0.0) };
        let up = Camera { target: camera().eye + Vec3::new(-1.0, 2.0, 1.0), ..camera() };
        assert!(Pick { camera: up, ..above }.surface(&mut scene).is_none());
        assert_eq!(scene.camera, own);
    }
}
