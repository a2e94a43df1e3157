//! Vertices of the casters' quads. Values that depend only on a caster and a view are computed once, at the
//! upload.
use super::{
    Geometry,
    agree::layers as layers_of_discs,
    ellipse::{Ellipse, layers as layers_of_splats},
};
use bytemuck::{Pod, Zeroable};
use gobo::{
    glam::{Vec2, Vec3},
    gpu::Gpu,
    model::{Gaussian, Particle, View},
    records::MIN_RADIUS,
    wgpu,
};
use half::f16;

/// Casters of a case: soft discs or splats, with the `filter` transfer.
#[derive(Clone, Debug)]
pub(crate) enum Inputs {
    Discs(Vec<Particle>),
    Splats(Vec<Gaussian>),
}

/// Quads per draw: bounds the size of a vertex buffer.
const DRAW_QUADS: usize = 1 << 20;

/// Buffers of vertices, and the number of quads in each.
pub(super) type Draws = Vec<(wgpu::Buffer, u32)>;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct DiscVertex {
    center: Vec3,
    radius: f32,
    /// `a(1 - c)` and `a`.
    shade: [f16; 4],
}

/// A rectangle along an ellipse's axes, up to the splat's end.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct SplatVertex {
    /// Centre in clip space.
    center: Vec3,
    /// Distance at which it ends [deviations].
    reach: f32,
    /// Half axes, in clip space.
    axes: [Vec2; 2],
    /// Change of the depth along each axis.
    tilt: Vec2,
    shade: [f16; 4],
}

const DISC: wgpu::VertexBufferLayout<'_> = wgpu::VertexBufferLayout {
    array_stride: size_of::<DiscVertex>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x4, 1 => Float16x4],
};

const SPLAT: wgpu::VertexBufferLayout<'_> = wgpu::VertexBufferLayout {
    array_stride: size_of::<SplatVertex>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![
        0 => Float32x4, 1 => Float32x4, 2 => Float32x2, 3 => Float16x4,
    ],
};

impl Inputs {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Discs(discs) => discs.len(),
            Self::Splats(splats) => splats.len(),
        }
    }

    /// Number of quads over each texel of a view's map.
    pub(crate) fn layers(&self, view: &View) -> Vec<u32> {
        match self {
            Self::Discs(discs) => layers_of_discs(discs, view),
            Self::Splats(splats) => layers_of_splats(splats, view),
        }
    }

    /// Entry point and layout of the vertices.
    pub(super) fn vertices(&self) -> (&'static str, wgpu::VertexBufferLayout<'static>) {
        match self {
            Self::Discs(_) => ("disc", DISC),
            Self::Splats(_) => ("splat", SPLAT),
        }
    }

    /// Vertices for each of the views, which have the same scale.
    pub(super) fn draws(&self, gpu: &Gpu, geometry: Geometry, views: &[View]) -> Vec<Draws> {
        match self {
            Self::Discs(discs) => {
                let scale = views.first().map_or(1.0, |view| view.scale);
                let draws = upload(gpu, geometry, discs, |disc| disc_vertex(disc, scale));
                vec![draws; views.len()]
            }
            Self::Splats(splats) => {
                let of = |view| upload(gpu, geometry, splats, |splat| splat_vertex(splat, view));
                views.iter().map(of).collect()
            }
        }
    }

    /// Corners of the quads of a draw.
    pub(super) fn indices(&self, gpu: &Gpu) -> wgpu::Buffer {
        let quads = self.len().min(DRAW_QUADS) as u32;
        let indices: Vec<_> =
            (0..quads).flat_map(|q| [0, 1, 2, 2, 1, 3].map(|corner| q * 4 + corner)).collect();
        gpu.upload("raster_indices", &indices, wgpu::BufferUsages::INDEX)
    }
}

fn upload<C, V: Pod>(gpu: &Gpu, geometry: Geometry, casters: &[C], of: impl Fn(&C) -> V) -> Draws {
    let copies = if geometry == Geometry::Indexed { 4 } else { 1 };
    let draws = casters.chunks(DRAW_QUADS).map(|casters| {
        let vertices: Vec<_> =
            casters.iter().flat_map(|caster| std::iter::repeat_n(of(caster), copies)).collect();
        let usage = wgpu::BufferUsages::VERTEX;
        (gpu.upload("raster_casters", &vertices, usage), casters.len() as u32)
    });
    draws.collect()
}

fn shade(a: f32, color: Vec3) -> [f16; 4] {
    (a * (Vec3::ONE - color)).extend(a).to_array().map(f16::from_f32)
}

fn disc_vertex(particle: &Particle, scale: f32) -> DiscVertex {
    let grow = (MIN_RADIUS / (particle.radius * scale)).max(1.0);
    let a = particle.color.w / (grow * grow);
    DiscVertex {
        center: particle.center,
        radius: particle.radius * grow,
        shade: shade(a, particle.color.truncate()),
    }
}

fn splat_vertex(gaussian: &Gaussian, view: &View) -> SplatVertex {
    let ellipse = Ellipse::new(gaussian, view);
    let per_texel = Vec2::new(2.0, -2.0) / view.size.as_vec2();
    let center = ellipse.center.as_vec2() * per_texel + Vec2::new(-1.0, 1.0);
    let reach = ellipse.reach as f32;
    SplatVertex {
        center: center.extend(ellipse.depth as f32),
        reach,
        axes: ellipse.axes.map(|axis| axis.as_vec2() * reach * per_texel),
        tilt: ellipse.tilt.as_vec2() * reach,
        shade: shade(ellipse.opacity as f32, gaussian.color),
    }
}
