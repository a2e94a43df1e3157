//! Depth maps of the host, and their cameras.
use crate::shadows::host_inputs::HostDepth;
use crate::{
    error::{Error, Input},
    gpu::has_texture,
    model::{Projection, View},
    records::ImportParams,
};
use bytemuck::Zeroable as _;
use glam::{DMat4, DVec2, DVec3, DVec4, Mat4, UVec2};
use std::collections::HashMap;
use wgpu::{Texture, TextureAspect, TextureFormat, TextureUsages, TextureView};

/// Depth map of the host for a view.
#[derive(Clone, Debug)]
pub(crate) struct DepthInput {
    pub texture: TextureView,
    /// Parameters, except for the position of our map.
    pub params: ImportParams,
    pub instead: bool,
    pub version: Option<u64>,
}

pub(in crate::shadows) const NO_TEXTURE: &str = "its texture was destroyed, or is another device's";

/// Largest deviation of our rays from the host's window over their length \[our texels\].
const ASTRAY: f64 = 0.25;

/// Views of the host's textures by texture and layer, kept from frame to frame.
#[derive(Debug, Default)]
pub(in crate::shadows) struct DepthViews(HashMap<(Texture, u32), TextureView>);

/// Depth inputs by view. `kept`: of the last frame, then of this one.
pub(in crate::shadows) fn depth_inputs(
    device: &wgpu::Device,
    views: &[View],
    given: &[HostDepth<'_>],
    kept: &mut DepthViews,
) -> Result<Vec<Option<DepthInput>>, Error> {
    let mut before = std::mem::take(kept);
    if given.is_empty() {
        return Ok(Vec::new());
    }
    let mut inputs = vec![None; views.len()];
    for (index, depth) in given.iter().enumerate() {
        let invalid = |problem| Input::HostDepth.invalid(index, problem);
        let view = views.get(depth.view).ok_or(invalid("its view is not among the views"))?;
        let key = (depth.texture.clone(), depth.layer);
        let known = kept.0.get(&key).cloned().or_else(|| before.0.remove(&key));
        let input = DepthInput::new(device, depth, view, known).map_err(invalid)?;
        kept.0.insert(key, input.texture.clone());
        if inputs[depth.view].replace(input).is_some() {
            return Err(invalid("its view has one already"));
        }
    }
    Ok(inputs)
}

impl DepthInput {
    /// `known`: view of the texture's layer.
    fn new(
        device: &wgpu::Device,
        depth: &HostDepth<'_>,
        view: &View,
        known: Option<TextureView>,
    ) -> Result<Self, &'static str> {
        let texture = depth.texture;
        let aspect =
            depth_aspect(texture.format()).ok_or("its format must be one of depth, or r32float")?;
        if texture.dimension() != wgpu::TextureDimension::D2 || texture.sample_count() != 1 {
            return Err("it must have two dimensions and one sample a texel");
        }
        if !texture.usage().contains(TextureUsages::TEXTURE_BINDING) {
            return Err("its usage lacks TEXTURE_BINDING");
        }
        if depth.layer >= texture.depth_or_array_layers() {
            return Err("it has no such layer");
        }
        if !has_texture(device, texture) {
            return Err(NO_TEXTURE);
        }
        let params = params(depth, view)?;
        let texture = known.unwrap_or_else(|| layer_view(texture, aspect, depth.layer));
        Ok(Self { texture, params, instead: depth.instead, version: depth.version })
    }
}

/// The aspect of a texture that a depth is read from; `None` for a format without depths.
pub(in crate::shadows) fn depth_aspect(format: TextureFormat) -> Option<TextureAspect> {
    use TextureFormat::{
        Depth16Unorm, Depth24Plus, Depth24PlusStencil8, Depth32Float, Depth32FloatStencil8,
        R32Float,
    };
    match format {
        R32Float => Some(TextureAspect::All),
        Depth16Unorm | Depth24Plus | Depth24PlusStencil8 | Depth32Float | Depth32FloatStencil8 => {
            Some(TextureAspect::DepthOnly)
        }
        _ => None,
    }
}

/// A layer of a host's texture.
pub(in crate::shadows) fn layer_view(
    texture: &Texture,
    aspect: TextureAspect,
    layer: u32,
) -> TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        label: Some("host_depths"),
        dimension: Some(wgpu::TextureViewDimension::D2),
        aspect,
        mip_level_count: Some(1),
        base_array_layer: layer,
        array_layer_count: Some(1),
        ..Default::default()
    })
}

/// A host's camera whose rays coincide with a view's. In `f64`, because matrices cancel far from the origin.
pub(in crate::shadows) struct HostCamera<'a> {
    view: &'a View,
    pub clip_from_view: DMat4,
}

impl<'a> HostCamera<'a> {
    pub(in crate::shadows) fn new(
        clip_from_world: &Mat4,
        view: &'a View,
    ) -> Result<Self, &'static str> {
        let world_from_view = view.view_from_world.as_dmat4().inverse();
        let clip_from_view = clip_from_world.as_dmat4() * world_from_view;
        if !clip_from_view.is_finite() {
            return Err("its matrix must be finite");
        }
        let camera = Self { view, clip_from_view };
        for corner in CORNERS {
            let [first, last] = [camera.middle(), view.far.into()].map(|d| camera.clip(corner, d));
            if !(first.w > 0.0 && last.w > 0.0) {
                return Err("its camera does not see all of the view");
            }
            let astray = camera.ndc(corner, camera.middle()) - camera.ndc(corner, view.far.into());
            let astray = astray.truncate().abs().max_element();
            if astray.is_nan() || astray > 2.0 * ASTRAY / f64::from(view.size.max_element()) {
                return Err("its camera must see along the view's own rays");
            }
        }
        Ok(camera)
    }

    /// Clip coordinates of a point in -1..1 of the window, at a distance along the view's axis \[m\].
    fn clip(&self, corner: DVec2, distance: f64) -> DVec4 {
        let half = (self.view.size.as_dvec2() - 1.0) * 0.5 / f64::from(self.view.scale);
        let spread = if self.is_perspective() { distance } else { 1.0 };
        self.clip_from_view * (corner * half * spread).extend(-distance).extend(1.0)
    }

    fn ndc(&self, corner: DVec2, distance: f64) -> DVec3 {
        let clip = self.clip(corner, distance);
        clip.truncate() / clip.w
    }

    /// A distance between the near and far planes, off the eye \[m\].
    fn middle(&self) -> f64 {
        let (near, far) = (f64::from(self.view.near), f64::from(self.view.far));
        near + 0.25 * (far - near)
    }

    /// Whether its window contains the view's.
    fn covers(&self) -> bool {
        let far = self.view.far.into();
        let reach = |corner| self.ndc(corner, far).truncate().abs().max_element();
        CORNERS.into_iter().all(|corner| reach(corner) <= 1.0 + 1e-5)
    }

    fn is_perspective(&self) -> bool {
        self.view.projection == Projection::Perspective
    }

    /// 1 for a perspective camera, 0 for an orthographic one.
    pub(in crate::shadows) fn perspective(&self) -> f32 {
        f32::from(u8::from(self.is_perspective()))
    }

    /// Its clear depth: 0 for reversed z, else 1.
    pub(in crate::shadows) fn empty(&self) -> f32 {
        let [first, last] =
            [self.middle(), self.view.far.into()].map(|d| self.ndc(DVec2::ZERO, d).z);
        if last < first { 0.0 } else { 1.0 }
    }
}

const CORNERS: [DVec2; 4] =
    [DVec2::NEG_ONE, DVec2::new(1.0, -1.0), DVec2::new(-1.0, 1.0), DVec2::ONE];

/// Parameters, except for the position of our map.
fn params(depth: &HostDepth<'_>, view: &View) -> Result<ImportParams, &'static str> {
    let clip_from_world = depth.clip_from_world.unwrap_or_else(|| view.clip_from_world());
    let camera = HostCamera::new(&clip_from_world, view)?;
    if !camera.covers() {
        return Err("it does not cover the view");
    }
    Ok(ImportParams {
        clip_from_view: camera.clip_from_view.as_mat4(),
        size: view.size.as_vec2(),
        host_size: UVec2::new(depth.texture.width(), depth.texture.height()).as_vec2(),
        scale: view.scale,
        perspective: camera.perspective(),
        near: view.near,
        far: view.far,
        empty: camera.empty(),
        ..ImportParams::zeroed()
    })
}
