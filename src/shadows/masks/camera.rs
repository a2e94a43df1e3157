//! Camera of a host: its depths and normals, checked and in the form that kernels read.
use super::host::ShadowFunction;
use crate::shadows::views::host_depths::{depth_aspect, layer_view};
use crate::{
    error::{Error, Input},
    gpu::{Shelf, has_texture},
    model::{Bounds, Camera, View},
    records::{HostView, NORMALS_NONE, NORMALS_SIGNED, NORMALS_UNORM},
};
use glam::{DMat4, DVec4, Mat4, UVec2, Vec3};
use wgpu::{BindGroup, Texture, TextureAspect, TextureFormat, TextureUsages, TextureView};

/// Far plane of masks for an infinite camera \[m\]; farther surfaces are moved to it.
const FARTHEST: f64 = 1e5;

/// A host's depths and normals, for [`LightMasks::prepare`](crate::host::LightMasks::prepare). The textures
/// are read when the masks are recorded.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct MaskView<'a> {
    pub(super) depth: &'a Texture,
    layer: u32,
    of: Of<'a>,
    normals: Option<&'a Texture>,
    is_view_space: bool,
    pub(super) joined: Option<Joined<'a>>,
}

#[derive(Clone, Copy, Debug)]
enum Of<'a> {
    Clip([[f32; 4]; 4]),
    View(&'a View),
}

#[derive(Clone, Copy, Debug)]
pub struct Joined<'a> {
    pub function: &'a ShadowFunction,
    pub bindings: &'a BindGroup,
    pub lights: &'a [usize],
}

impl<'a> MaskView<'a> {
    /// A depth texture, and the perspective matrix that it was rendered with, in columns; depth may be
    /// reversed or infinite. Formats: depth16unorm, depth24plus, depth32float, these with stencil, and
    /// r32float.
    pub fn new(clip_from_world: [[f32; 4]; 4], depth: &'a Texture) -> Self {
        let of = Of::Clip(clip_from_world);
        Self { depth, layer: 0, of, normals: None, is_view_space: false, joined: None }
    }

    /// A texture of light depth: distance along the view's axis, from 0 at its near plane to 1 at its far
    /// plane, where there is no surface.
    pub fn light_depth(view: &'a View, depth: &'a Texture) -> Self {
        Self { of: Of::View(view), ..Self::new([[0.0; 4]; 4], depth) }
    }

    /// Sets the layer of a texture array.
    #[must_use]
    pub fn layer(self, layer: u32) -> Self {
        Self { layer, ..self }
    }

    /// Sets normals in world space, of the depths' size; in a unorm format, 0 is -1. Without them, normals
    /// are derived from neighbouring depths.
    #[must_use]
    pub fn normals(self, normals: &'a Texture) -> Self {
        Self { normals: Some(normals), is_view_space: false, ..self }
    }

    /// Like [`Self::normals`], in view space: x right, y up, z to the eye.
    #[must_use]
    pub fn view_normals(self, normals: &'a Texture) -> Self {
        Self { is_view_space: true, ..self.normals(normals) }
    }

    /// Sets a shadow function for some lights, given as indices into the lights that masks are prepared for.
    /// `bindings`: of its layout.
    #[must_use]
    pub fn joined(
        self,
        function: &'a ShadowFunction,
        bindings: &'a BindGroup,
        lights: &'a [usize],
    ) -> Self {
        Self { joined: Some(Joined { function, bindings, lights }), ..self }
    }

    pub(super) fn camera(
        &self,
        device: &wgpu::Device,
        shelf: Option<&Shelf>,
    ) -> Result<MaskCamera, Error> {
        let invalid = |problem| Input::MaskView.invalid(0, problem);
        let mut textures = [self.depth].into_iter().chain(self.normals);
        if !textures.all(|texture| has_texture(device, texture)) {
            return Err(invalid("one of its textures was destroyed, or is another device's"));
        }
        let size = UVec2::new(self.depth.width(), self.depth.height());
        let depths = depth_view(self.depth, self.layer, shelf).map_err(invalid)?;
        let (view, world_from_clip, empty) = match self.of {
            Of::View(view) if !has_numbers(view) => {
                return Err(invalid(
                    "its view's numbers must be finite, near before far, scale above 0",
                ));
            }
            Of::View(view) if view.size == size => (view.clone(), Mat4::IDENTITY, 1.0),
            Of::View(_) => return Err(invalid("its depths are not of the view's size")),
            Of::Clip(clip) => of_clip(clip, size).map_err(invalid)?,
        };
        let (normals, kind) = match self.normals {
            None => (None, NORMALS_NONE),
            Some(normals) => {
                if UVec2::new(normals.width(), normals.height()) != size {
                    return Err(invalid("its normals are not of the size of its depths"));
                }
                let kind = normal_kind(normals).map_err(invalid)?;
                (Some(flat_view(normals, TextureAspect::All, 0, shelf)), kind)
            }
        };
        let turned = view.view_from_world.inverse();
        let params = HostView {
            world_from_clip,
            world_from_normal: if self.is_view_space { turned } else { Mat4::IDENTITY },
            empty,
            is_light_depth: u32::from(matches!(self.of, Of::View(_))),
            normals: kind,
            pad_0: 0,
        };
        Ok(MaskCamera { view, params, depths, normals })
    }
}

fn has_numbers(view: &View) -> bool {
    let all = [view.near, view.far, view.scale];
    view.view_from_world.is_finite()
        && all.iter().all(|number| number.is_finite())
        && view.near < view.far
        && view.scale > 0.0
}

/// Camera of a host, checked.
pub(super) struct MaskCamera {
    pub view: View,
    pub params: HostView,
    pub depths: TextureView,
    pub normals: Option<TextureView>,
}

/// View of a matrix, the matrix's inverse, and its depth without a surface.
fn of_clip(clip: [[f32; 4]; 4], size: UVec2) -> Result<(View, Mat4, f32), &'static str> {
    let camera = Camera::from_clip(clip, size).map_err(|error| error.0)?;
    let clip = DMat4::from_cols_array_2d(&clip.map(|column| column.map(f64::from)));
    let ahead = (camera.target - camera.eye).normalize().as_dvec3();
    let at =
        |distance: f64| -> DVec4 { clip * (camera.eye.as_dvec3() + ahead * distance).extend(1.0) };
    // Along the axis, both clip coordinates are linear in the distance; w is 0 at the eye.
    let (one, two) = (at(1.0), at(2.0));
    let (slope, w) = (two.z - one.z, two.w - one.w);
    let start = one.z - slope;
    let empty = if start * w > 0.0 { 0.0 } else { 1.0 };
    let end = start / (empty * w - slope);
    let far = if end.is_finite() && end > 0.0 { end.min(FARTHEST) } else { FARTHEST };
    let bounds = Bounds { min: Vec3::splat(-1.0), max: Vec3::ONE };
    let view = View { near: 0.0, far: far as f32, ..View::from_camera(&camera, &bounds) };
    let inverse = clip.inverse();
    if !inverse.is_finite() {
        return Err("its matrix cannot be inverted");
    }
    Ok((view, inverse.as_mat4(), empty as f32))
}

/// View of one layer, for `textureLoad`.
fn depth_view(
    texture: &Texture,
    layer: u32,
    shelf: Option<&Shelf>,
) -> Result<TextureView, &'static str> {
    let aspect = depth_aspect(texture.format())
        .ok_or("the format of its depths must be one of depth, or r32float")?;
    check(texture)?;
    if layer >= texture.depth_or_array_layers() {
        return Err("its depths have no such layer");
    }
    Ok(flat_view(texture, aspect, layer, shelf))
}

fn normal_kind(texture: &Texture) -> Result<u32, &'static str> {
    use TextureFormat::{Rgb10a2Unorm, Rgba8Snorm, Rgba8Unorm, Rgba16Float, Rgba32Float};
    check(texture)?;
    match texture.format() {
        Rgba8Unorm | Rgb10a2Unorm => Ok(NORMALS_UNORM),
        Rgba8Snorm | Rgba16Float | Rgba32Float => Ok(NORMALS_SIGNED),
        _ => Err("the format of its normals must be rgba8unorm, rgba8snorm, rgb10a2unorm, \
                  rgba16float or rgba32float"),
    }
}

fn check(texture: &Texture) -> Result<(), &'static str> {
    if texture.dimension() != wgpu::TextureDimension::D2 || texture.sample_count() != 1 {
        return Err("its textures must have two dimensions and one sample a texel");
    }
    if !texture.usage().contains(TextureUsages::TEXTURE_BINDING) {
        return Err("the usage of its textures lacks TEXTURE_BINDING");
    }
    Ok(())
}

fn flat_view(
    texture: &Texture,
    aspect: TextureAspect,
    layer: u32,
    shelf: Option<&Shelf>,
) -> TextureView {
    let made = || layer_view(texture, aspect, layer);
    shelf.map_or_else(made, |shelf| shelf.view(texture, aspect, layer, made))
}
