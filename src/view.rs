//! Shadow cameras, and the picture's camera, which is one more.
use crate::{
    light::{Light, LightKind},
    scene::{Bounds, Camera, Scene},
};
use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Mat4, UVec2, Vec2, Vec3, Vec4};

/// Edge of a tile [texels]. WGSL: `wgsl/common/view.wgsl`.
pub const TILE_SIZE: u32 = 16;
/// Views of a batch: the length of the uniform array.
pub const MAX_VIEWS: usize = 64;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Parallel rays along the view axis.
    Orthographic,
    /// Rays from the view's position.
    Perspective,
}

/// One shadow camera: a directional view, a spot, one face of a point light's cube.
/// View space has x right, y up and looks along -z.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Index into [`Scene::lights`]; `None` for the picture's camera.
    pub light: Option<usize>,
    /// Unique among the views of a light.
    pub name: &'static str,
    pub projection: Projection,
    /// Of the map [texels].
    pub size: UVec2,
    /// First and last depth along the view axis [m].
    pub near: f32,
    pub far: f32,
    pub view_from_world: Mat4,
    /// Texels per metre (orthographic), or per metre at 1 m along the axis (perspective).
    pub scale: f32,
}

/// What kernels read of a [`View`]. WGSL: `wgsl/common/view.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GpuView {
    pub view_from_world: Mat4,
    /// [texels]
    pub size: Vec2,
    /// Texels per metre (orthographic), or per metre at 1 m along the axis (perspective).
    pub scale: f32,
    /// 1 for a perspective view, 0 for an orthographic one.
    pub perspective: f32,
    /// [m]
    pub near: f32,
    /// [m]
    pub far: f32,
    /// First of the view's tiles in its batch.
    pub first_tile: u32,
    /// Tiles in a row.
    pub tiles_x: u32,
    /// Place of the map in the atlas [texels].
    pub origin: UVec2,
    pub layer: u32,
    /// Index of the light; `u32::MAX` for the picture's camera.
    pub light: u32,
}
crate::gpu_layout!(GpuView {
    view_from_world,
    size,
    scale,
    perspective,
    near,
    far,
    first_tile,
    tiles_x,
    origin,
    layer,
    light
});

impl View {
    /// Tiles per row and column.
    pub fn tiles(&self) -> UVec2 {
        (self.size + TILE_SIZE - 1) / TILE_SIZE
    }

    /// Where the light is; for an orthographic view the middle of its near plane.
    pub fn position(&self) -> Vec3 {
        let world_from_view = self.view_from_world.inverse();
        match self.projection {
            Projection::Perspective => world_from_view.w_axis.truncate(),
            Projection::Orthographic => {
                world_from_view.transform_point3(Vec3::new(0.0, 0.0, -self.near))
            }
        }
    }

    /// The view axis: unit, world space.
    pub fn direction(&self) -> Vec3 {
        -self.view_from_world.row(2).truncate()
    }

    /// World space to clip space; NDC z in 0..1, nonlinear in depth for a perspective view.
    pub fn clip_from_world(&self) -> Mat4 {
        let half = self.size.as_vec2() * 0.5;
        let (near, far) = (self.near, self.far);
        let clip_from_view = match self.projection {
            Projection::Orthographic => Mat4::from_cols(
                Vec4::new(self.scale / half.x, 0.0, 0.0, 0.0),
                Vec4::new(0.0, self.scale / half.y, 0.0, 0.0),
                Vec4::new(0.0, 0.0, -1.0 / (far - near), 0.0),
                Vec4::new(0.0, 0.0, -near / (far - near), 1.0),
            ),
            Projection::Perspective => Mat4::from_cols(
                Vec4::new(self.scale / half.x, 0.0, 0.0, 0.0),
                Vec4::new(0.0, self.scale / half.y, 0.0, 0.0),
                Vec4::new(0.0, 0.0, far / (near - far), -1.0),
                Vec4::new(0.0, 0.0, near * far / (near - far), 0.0),
            ),
        };
        clip_from_view * self.view_from_world
    }

    /// The picture's camera; near and far enclose `bounds`.
    pub fn from_camera(camera: &Camera, bounds: &Bounds) -> Self {
        let view_from_world =
            looking(camera.eye, (camera.target - camera.eye).normalize(), camera.up);
        let (_, farthest) = depth_range(&view_from_world, &bounds.or_unit());
        // A floor that is seen from straight above must not lie on the plane, where the sky is.
        let far = farthest * 1.001;
        let near = (far * 1e-4).max(1e-4);
        Self {
            light: None,
            name: "camera",
            projection: Projection::Perspective,
            size: camera.size,
            near,
            far: far.max(near * 2.0),
            view_from_world,
            scale: camera.size.y as f32 * 0.5 / (camera.fov_y * 0.5).tan(),
        }
    }

    pub fn to_gpu(&self, first_tile: u32, origin: UVec2, layer: u32) -> GpuView {
        GpuView {
            view_from_world: self.view_from_world,
            size: self.size.as_vec2(),
            scale: self.scale,
            perspective: f32::from(u8::from(self.projection == Projection::Perspective)),
            near: self.near,
            far: self.far,
            first_tile,
            tiles_x: self.tiles().x,
            origin,
            layer,
            light: self.light.map_or(u32::MAX, |light| light as u32),
        }
    }
}

/// The up of a light that looks along `forward` (unit).
fn light_up(forward: Vec3) -> Vec3 {
    if forward.y.abs() > 0.99 { Vec3::Z } else { Vec3::Y }
}

/// `view_from_world` of a view that looks along `forward` (unit).
fn looking(position: Vec3, forward: Vec3, up: Vec3) -> Mat4 {
    let right = forward.cross(up).normalize();
    let axes = Mat3::from_cols(right, right.cross(forward), -forward).transpose();
    Mat4::from_cols(
        axes.x_axis.extend(0.0),
        axes.y_axis.extend(0.0),
        axes.z_axis.extend(0.0),
        (-(axes * position)).extend(1.0),
    )
}

/// Depths along the axis that enclose the box [m].
fn depth_range(view_from_world: &Mat4, bounds: &Bounds) -> (f32, f32) {
    bounds
        .corners()
        .iter()
        .map(|&c| -view_from_world.transform_point3(c).z)
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(near, far), depth| {
            (near.min(depth), far.max(depth))
        })
}

/// The faces of a point light's cube.
const CUBE: [(&str, Vec3); 6] = [
    ("px", Vec3::X),
    ("nx", Vec3::NEG_X),
    ("py", Vec3::Y),
    ("ny", Vec3::NEG_Y),
    ("pz", Vec3::Z),
    ("nz", Vec3::NEG_Z),
];

/// The shadow views of all lights, in order of lights.
pub fn shadow_views(scene: &Scene) -> Vec<View> {
    let bounds = scene.bounds().or_unit();
    let lights = scene.lights.iter().enumerate().filter(|(_, light)| light.casts);
    lights
        .flat_map(|(index, light)| light_views(index, light, scene.shadow.size, &bounds))
        .collect()
}

/// The shadow views of one light. `index` is the light's, `size` its maps' edge [texels] where it
/// has none of its own, `bounds` holds all casters and receivers (world space [m]).
pub fn light_views(index: usize, light: &Light, size: u32, bounds: &Bounds) -> Vec<View> {
    let size = UVec2::splat(light.size.unwrap_or(size));
    match light.kind {
        LightKind::Directional { direction } => {
            vec![directional(index, light, size, direction, bounds)]
        }
        LightKind::Spot { position, direction, angle } => {
            vec![perspective(
                index,
                light,
                size,
                "0",
                looking(position, direction, light_up(direction)),
                angle,
                bounds,
            )]
        }
        LightKind::Point { position } => CUBE
            .iter()
            .map(|&(name, forward)| {
                let view_from_world = looking(position, forward, light_up(forward));
                let right_angle = std::f32::consts::FRAC_PI_2;
                perspective(index, light, size, name, view_from_world, right_angle, bounds)
            })
            .collect(),
    }
}

/// Fits the box: the window is square, its planes enclose every caster and receiver.
fn directional(index: usize, light: &Light, size: UVec2, direction: Vec3, box_: &Bounds) -> View {
    let axes = looking(Vec3::ZERO, direction, light_up(direction));
    let corners = box_.corners().map(|corner| axes.transform_point3(corner));
    let min = corners.iter().fold(Vec3::INFINITY, |a, &b| a.min(b));
    let max = corners.iter().fold(Vec3::NEG_INFINITY, |a, &b| a.max(b));
    // A margin keeps what lies on the box off the window's border and off depths 0 and 1.
    let margin = (box_.radius() * 0.01).max(1e-4);
    let window = (max - min).truncate().max_element() + 2.0 * margin;
    let middle = (min + max) * 0.5;
    let near = light.near.unwrap_or(0.0);
    let far = light.far.unwrap_or_else(|| {
        (max.z - min.z + 2.0 * margin).max(near + margin.max(near.abs() * 1e-3))
    });
    let shift = Mat4::from_translation(-Vec3::new(middle.x, middle.y, max.z + margin));
    View {
        light: Some(index),
        name: "0",
        projection: Projection::Orthographic,
        size,
        near,
        far,
        view_from_world: shift * axes,
        scale: size.x as f32 / window,
    }
}

fn perspective(
    index: usize,
    light: &Light,
    size: UVec2,
    name: &'static str,
    view_from_world: Mat4,
    angle: f32,
    bounds: &Bounds,
) -> View {
    let (_, deepest) = depth_range(&view_from_world, bounds);
    let margin = (bounds.radius() * 0.01).max(1e-4);
    let beyond = light.near.map_or(margin, |near| near * 2.0);
    let far = light.far.unwrap_or_else(|| (deepest + margin).max(beyond));
    let near = light.near.unwrap_or(far * 1e-4);
    View {
        light: Some(index),
        name,
        projection: Projection::Perspective,
        size,
        near,
        far,
        view_from_world,
        scale: size.x as f32 * 0.5 / (angle * 0.5).tan(),
    }
}
