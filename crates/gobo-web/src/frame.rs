//! Camera and surroundings of a frame.
use bytemuck::{Pod, Zeroable};
use gobo::{
    Bounds, Camera, Scene, View,
    glam::{Mat4, Vec3, Vec4},
    model::Tone,
};

/// WGSL: `Frame` of `wgsl/frame.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Frame {
    clip_from_world: [[f32; 4]; 4],
    eye: [f32; 4],
    right: [f32; 4],
    up: [f32; 4],
    forward: [f32; 4],
    size: [f32; 2],
    light_count: u32,
    sky_edge: u32,
    exposure: f32,
    tone: u32,
    middle: f32,
    far: f32,
    ambient: [f32; 4],
    background: [f32; 4],
    irradiance: [[f32; 4]; 9],
}

impl Frame {
    pub(crate) fn new(scene: &Scene, camera: &Camera, bounds: &Bounds, light_count: u32) -> Self {
        let view = View::from_camera(camera, bounds);
        let world_from_view = view.view_from_world.inverse();
        let [right, up, back] = [0, 1, 2].map(|axis| world_from_view.col(axis).truncate());
        let tall = (camera.fov_y * 0.5).tan();
        let wide = tall * camera.size.x as f32 / camera.size.y as f32;
        let (near, far) = (view.near, view.far);
        let depth = far - near;
        // Reversed z: 1 at the near plane.
        let clip_from_view = Mat4::from_cols(
            Vec4::new(1.0 / wide, 0.0, 0.0, 0.0),
            Vec4::new(0.0, 1.0 / tall, 0.0, 0.0),
            Vec4::new(0.0, 0.0, near / depth, -1.0),
            Vec4::new(0.0, 0.0, near * far / depth, 0.0),
        );
        let clip_from_world = clip_from_view * view.view_from_world;
        let environment = scene.environment.as_ref();
        Self {
            clip_from_world: clip_from_world.to_cols_array_2d(),
            eye: camera.eye.extend(0.0).into(),
            right: right.extend(wide).into(),
            up: up.extend(tall).into(),
            forward: (-back).extend(near).into(),
            size: camera.size.as_vec2().into(),
            light_count,
            sky_edge: environment.map_or(0, |environment| environment.size()),
            exposure: scene.exposure.exp2(),
            tone: match scene.tone {
                Tone::Linear => 1,
                Tone::Filmic => 2,
                _ => 0,
            },
            middle: camera.eye.distance(bounds.or_unit().center()),
            far,
            ambient: scene.mean_ambient().extend(0.0).into(),
            background: scene.background.extend(0.0).into(),
            irradiance: scene.irradiance().map(|of| of.extend(0.0).into()),
        }
    }

    /// Exposure and tone curve. WGSL: `Tone` of `wgsl/tone.wgsl`.
    pub(crate) fn tone(&self) -> [u32; 4] {
        [self.exposure.to_bits(), self.tone, 0, 0]
    }

    /// Position of the eye and direction of its axis.
    pub(crate) fn eye(&self) -> (Vec3, Vec3) {
        let truncated = |v: [f32; 4]| Vec4::from(v).truncate();
        (truncated(self.eye), truncated(self.forward))
    }
}
