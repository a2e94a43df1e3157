//! Orbit camera, with y up.
use gobo::{
    Camera,
    glam::{UVec2, Vec3},
};
use std::f32::consts::{FRAC_PI_2, PI};

/// Largest elevation: at the poles the direction is undefined [radians].
const MAX_PITCH: f32 = FRAC_PI_2 - 0.01;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Orbit {
    /// Point that the camera orbits, world space [m].
    target: Vec3,
    /// Distance of the eye from the target [m].
    distance: f32,
    /// Rotation about y, 0 where the eye is at +z of the target [radians].
    yaw: f32,
    /// Elevation of the eye above the target [radians].
    pitch: f32,
    /// Vertical field of view [radians].
    fov_y: f32,
}

impl Orbit {
    /// Orbit with the eye, target and field of view of a camera; upright.
    pub(super) fn of(camera: &Camera) -> Self {
        let arm = camera.eye - camera.target;
        let distance = arm.length().max(1e-3);
        Self {
            target: camera.target,
            distance,
            yaw: arm.x.atan2(arm.z),
            pitch: (arm.y / distance).clamp(-1.0, 1.0).asin().clamp(-MAX_PITCH, MAX_PITCH),
            fov_y: camera.fov_y,
        }
    }

    /// Unit direction from the target to the eye.
    fn arm(&self) -> Vec3 {
        let (sine, cosine) = self.yaw.sin_cos();
        let (up, level) = self.pitch.sin_cos();
        Vec3::new(sine * level, up, cosine * level)
    }

    pub(super) fn camera(&self, size: UVec2) -> Camera {
        let eye = self.target + self.arm() * self.distance;
        Camera { eye, target: self.target, up: Vec3::Y, fov_y: self.fov_y, size }
    }

    /// Orbits by a drag: half a turn for the height of the picture. `drag` in picture heights, x right and
    /// y down.
    pub(super) fn turn(&mut self, drag: [f32; 2]) {
        self.yaw = (self.yaw - drag[0] * PI).rem_euclid(2.0 * PI);
        self.pitch = (self.pitch + drag[1] * PI).clamp(-MAX_PITCH, MAX_PITCH);
    }

    /// Pans with the pointer, exactly at the target's distance. `drag` as in [`Self::turn`].
    pub(super) fn pan(&mut self, drag: [f32; 2]) {
        let height = 2.0 * self.distance * (self.fov_y / 2.0).tan();
        let right = Vec3::Y.cross(self.arm()).normalize();
        let up = self.arm().cross(right);
        self.target += (up * drag[1] - right * drag[0]) * height;
    }

    /// Divides the distance by `factor`.
    pub(super) fn zoom(&mut self, factor: f32) {
        self.distance = (self.distance / factor).clamp(1e-3, 1e6);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gobo::View;

    fn camera() -> Camera {
        Camera {
            eye: Vec3::new(3.0, 2.0, -4.0),
            target: Vec3::new(0.5, 1.0, 0.25),
            fov_y: 0.7,
            size: UVec2::new(640, 400),
            ..Camera::default()
        }
    }

    /// Position of a point in the picture: right and down from the centre, in picture heights.
    fn seen(camera: &Camera, point: Vec3) -> [f32; 2] {
        let view = View::from_camera(camera, &gobo::Bounds { min: -Vec3::ONE, max: Vec3::ONE });
        let at = view.view_from_world.transform_point3(point);
        let height = 2.0 * (camera.fov_y / 2.0).tan() * -at.z;
        [at.x / height, -at.y / height]
    }

    fn assert_near(a: [f32; 2], b: [f32; 2]) {
        let far = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(far < 1e-5, "{a:?} is not {b:?}");
    }

    #[test]
    fn the_camera_it_starts_from_is_its_own() {
        let camera = camera();
        let own = Orbit::of(&camera).camera(camera.size);
        assert!(own.eye.distance(camera.eye) < 1e-5, "{own:?}");
        assert_eq!((own.target, own.fov_y), (camera.target, camera.fov_y));
    }

    #[test]
    fn a_point_at_the_targets_distance_follows_the_pointer() {
        let mut orbit = Orbit::of(&camera());
        let point = camera().target;
        orbit.pan([0.2, -0.1]);
        assert_near(seen(&orbit.camera(UVec2::ONE), point), [0.2, -0.1]);
    }

    #[test]
    fn what_faces_the_eye_turns_with_the_pointer() {
        let mut orbit = Orbit::of(&camera());
        let facing = camera().target.lerp(camera().eye, 0.2);
        orbit.turn([0.05, 0.0]);
        assert!(seen(&orbit.camera(UVec2::ONE), facing)[0] > 0.01);
        let mut orbit = Orbit::of(&camera());
        orbit.turn([0.0, 0.05]);
        assert!(seen(&orbit.camera(UVec2::ONE), facing)[1] > 0.01);
    }

    #[test]
    fn two_pictures_to_the_side_are_a_full_turn() {
        let mut orbit = Orbit::of(&camera());
        (0..8).for_each(|_| orbit.turn([0.25, 0.0]));
        let eye = orbit.camera(UVec2::ONE).eye;
        assert!(eye.distance(camera().eye) < 1e-4, "{eye}");
    }

    #[test]
    fn it_never_goes_over_the_pole() {
        let mut orbit = Orbit::of(&camera());
        orbit.turn([0.0, 9.0]);
        orbit.zoom(2.0);
        let camera = orbit.camera(UVec2::ONE);
        let arm = camera.eye - camera.target;
        assert!(arm.x.hypot(arm.z) > 0.001 && arm.y > 0.0, "{arm}");
        assert!((arm.length() * 2.0 - orbit_length()).abs() < 1e-4);
    }

    fn orbit_length() -> f32 {
        camera().eye.distance(camera().target)
    }
}
