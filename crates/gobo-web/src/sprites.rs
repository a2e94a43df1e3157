//! Particles, Gaussians and strands as sprites, sorted by distance.
use crate::{
    device::{Buffers, TooLarge},
    looks::Class,
};
use bytemuck::{Pod, Zeroable};
use gobo::{
    Scene,
    glam::{Mat3, Quat, Vec3, Vec4},
    wgpu,
};

/// WGSL: `Sprite` of `wgsl/sprites.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Sprite {
    center: [f32; 3],
    look: u32,
    first: [f32; 4],
    second: [f32; 4],
    color: [f32; 4],
}

impl Sprite {
    fn round(center: Vec3, radius: f32, color: Vec4, look: u32) -> Self {
        Self {
            center: center.into(),
            look,
            first: [radius, 0.0, 0.0, 0.0],
            second: [0.0; 4],
            color: color.into(),
        }
    }

    fn gaussian(center: Vec3, axes: Mat3, color: Vec4, look: u32) -> Self {
        let of = axes * axes.transpose();
        Self {
            center: center.into(),
            look,
            first: [of.x_axis.x, of.x_axis.y, of.x_axis.z, 1.0],
            second: [of.y_axis.y, of.y_axis.z, of.z_axis.z, 0.0],
            color: color.into(),
        }
    }
}

/// Middles of sprites or bricks, and buffers for sorting them.
#[derive(Debug, Default)]
pub(crate) struct Order {
    centers: Vec<Vec3>,
    sorted: Vec<u32>,
    keys: Vec<u16>,
    from: Option<(Vec3, Vec3)>,
}

impl Order {
    pub(crate) fn of(centers: Vec<Vec3>) -> Self {
        let sorted = (0..centers.len() as u32).collect();
        Self { keys: vec![0; centers.len()], centers, sorted, from: None }
    }

    /// Indices from the farthest to the nearest, if they changed.
    pub(crate) fn sort(&mut self, eye: Vec3, forward: Vec3) -> Option<&[u32]> {
        if self.centers.is_empty() || self.from == Some((eye, forward)) {
            return None;
        }
        self.from = Some((eye, forward));
        let depth = |center: &Vec3| (*center - eye).dot(forward);
        let (low, high) = self
            .centers
            .iter()
            .map(depth)
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), depth| {
                (low.min(depth), high.max(depth))
            });
        // A counting sort: two bytes of depth are finer than the eye can tell.
        let scale = f32::from(u16::MAX) / (high - low).max(f32::MIN_POSITIVE);
        let mut starts = vec![0_u32; 1 << 16];
        for (key, center) in self.keys.iter_mut().zip(&self.centers) {
            *key = ((high - depth(center)) * scale) as u16;
            starts[usize::from(*key)] += 1;
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += std::mem::replace(start, sum);
        }
        for (index, key) in (0..).zip(&self.keys) {
            let place = &mut starts[usize::from(*key)];
            self.sorted[*place as usize] = index;
            *place += 1;
        }
        Some(&self.sorted)
    }

    pub(crate) fn count(&self) -> u32 {
        self.centers.len() as u32
    }
}

/// Sprites of one class on the device.
#[derive(Debug)]
pub(crate) struct Sprites {
    pub(crate) order: Order,
    pub(crate) buffers: Vec<wgpu::Buffer>,
}

impl Sprites {
    /// The scene's solid sprites, and its others.
    pub(crate) fn of(scene: &Scene, buffers: &Buffers<'_>) -> Result<[Self; 2], TooLarge> {
        let mut solid = Vec::new();
        let mut blended = Vec::new();
        let mut add = |sprite: Sprite| {
            let material = &scene.materials[sprite.look as usize];
            if !material.visible {
                return;
            }
            let is_solid = Class::of(material) == Class::Solid;
            (if is_solid { &mut solid } else { &mut blended }).push(sprite);
        };
        for particle in &scene.particles {
            let color = particle.color;
            add(Sprite::round(particle.center, particle.radius, color, particle.material));
        }
        for gaussian in &scene.gaussians {
            let material = &scene.materials[gaussian.material as usize];
            let opacity = if material.is_medium() {
                1.0 - (-gaussian.opacity * gaussian.sigma.max_element()).exp()
            } else {
                gaussian.opacity
            };
            let color = gaussian.color.extend(opacity);
            add(Sprite::gaussian(gaussian.center, gaussian.axes(), color, gaussian.material));
        }
        for strand in &scene.strands {
            for pair in strand.vertices.windows(2) {
                let [a, b] = [pair[0].position, pair[1].position];
                let along = b - a;
                let turn = Quat::from_rotation_arc(Vec3::X, along.normalize_or(Vec3::X));
                // A Gaussian with a segment's length and width.
                let radius = 0.25 * (pair[0].radius + pair[1].radius);
                let sigma = Vec3::new(along.length() * 0.35, radius, radius);
                let axes = Mat3::from_quat(turn) * Mat3::from_diagonal(sigma);
                let color = 0.5 * (pair[0].color + pair[1].color);
                add(Sprite::gaussian(0.5 * (a + b), axes, color, strand.material));
            }
        }
        let make = |sprites: Vec<Sprite>| {
            let order = Order::of(sprites.iter().map(|sprite| sprite.center.into()).collect());
            let of_order = buffers.storage("order", &order.sorted)?;
            let buffers = vec![buffers.storage("sprites", &sprites)?, of_order];
            Ok(Self { order, buffers })
        };
        Ok([make(solid)?, make(blended)?])
    }
}
