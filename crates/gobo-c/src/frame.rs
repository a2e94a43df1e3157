//! Rendered frames in the callers' format.
use crate::fault::{Fault, code, free, object};
use gobo::{
    Scene,
    glam::{DMat4, DVec3, Mat4},
    records::{CurveMap, Picture, ViewMaps},
};
use gobo_picture::Frame;
use std::{
    ffi::{CString, c_char, c_int},
    ptr::null,
};

/// Numbers of a node: start, end, red, green, blue.
const FIELDS: usize = 5;
/// Start of an unused node: beyond the far plane.
const UNUSED: f32 = 2.0;

/// `gobo_picture` of the header.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct CPicture {
    pub(crate) size: [u32; 2],
    pub(crate) srgb: *const u8,
    pub(crate) light: *const f32,
}

/// `gobo_map` of the header.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct CMap {
    pub(crate) light: u32,
    pub(crate) view: *const c_char,
    pub(crate) size: [u32; 2],
    pub(crate) nodes: u32,
    pub(crate) near_plane: f32,
    pub(crate) far_plane: f32,
    pub(crate) filter: *const f32,
    pub(crate) nearest: *const f32,
    pub(crate) opaque: *const f32,
    pub(crate) colored: *const f32,
    pub(crate) curve: *const f32,
    pub(crate) clip_from_world: [f64; 16],
    pub(crate) view_from_world: [f64; 16],
}

/// A frame behind the callers' pointer.
#[derive(Debug)]
pub(crate) struct HeldFrame {
    picture: Option<Picture>,
    maps: Vec<HeldMap>,
}

#[derive(Debug)]
struct HeldMap {
    maps: ViewMaps,
    light: usize,
    view: CString,
    /// Nodes of all texels.
    curve: Option<Vec<[f32; FIELDS]>>,
    /// World position of the scene's origin [m].
    origin: DVec3,
}

impl HeldFrame {
    pub(crate) fn of(frame: Frame, scene: &Scene, has_picture: bool) -> Self {
        let origin = scene.origin.as_dvec3();
        let of_light = |mut maps: ViewMaps| {
            let light = maps.view.light.filter(|&light| light < scene.lights.len())?;
            let view = CString::new(maps.view.name).unwrap_or_default();
            let curve = maps.curve.as_ref().map(unpacked);
            if let Some(curve) = &mut maps.curve {
                curve.packed = Vec::new();
            }
            Some(HeldMap { maps, light, view, curve, origin })
        };
        let maps = frame.maps.into_iter().filter_map(of_light).collect();
        Self { picture: has_picture.then_some(frame.picture), maps }
    }
}

/// Nodes of all texels, as `gobo render --maps` writes them: used ones first; unused ones have the light
/// behind the last used one.
fn unpacked(curve: &CurveMap) -> Vec<[f32; FIELDS]> {
    let mut nodes = Vec::with_capacity(curve.packed.len());
    for texel in 0..curve.texel_count() {
        let (end, mut behind) = (nodes.len() + curve.nodes, [1.0; 3]);
        for (start, stop, light) in curve.ramps(texel) {
            behind = light.to_array();
            nodes.push([start, stop, behind[0], behind[1], behind[2]]);
        }
        nodes.resize(end, [UNUSED, UNUSED, behind[0], behind[1], behind[2]]);
    }
    nodes
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_frame_free(frame: *mut HeldFrame) {
    // SAFETY: the caller's promise.
    unsafe { free(frame) }
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_frame_picture(
    frame: *const HeldFrame,
    picture: *mut CPicture,
) -> c_int {
    code(|| {
        // SAFETY: the caller's promise.
        let held = unsafe { object(frame, "frame")? };
        let Some(seen) = &held.picture else {
            return Err(Fault::input("the frame has no picture; render GOBO_PICTURE"));
        };
        let described = CPicture {
            size: seen.size.to_array(),
            srgb: seen.rgb.as_flattened().as_ptr(),
            light: seen.light.as_flattened().as_ptr(),
        };
        // SAFETY: the caller's promise.
        unsafe { put(picture, "picture", described) }
    })
}

/// # Safety
/// `out` is NULL, or valid for a write.
unsafe fn put<T>(out: *mut T, name: &str, value: T) -> Result<(), Fault> {
    if out.is_null() {
        return Err(Fault::input(format!("{name} is NULL")));
    }
    // SAFETY: not NULL; the rest is the caller's promise.
    unsafe { out.write(value) };
    Ok(())
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_frame_map_count(frame: *const HeldFrame) -> usize {
    // SAFETY: the caller's promise.
    unsafe { frame.as_ref() }.map_or(0, |held| held.maps.len())
}

/// # Safety
/// As `gobo.h` says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn gobo_frame_map(
    frame: *const HeldFrame,
    index: usize,
    map: *mut CMap,
) -> c_int {
    code(|| {
        // SAFETY: the caller's promise.
        let held = unsafe { object(frame, "frame")? };
        let Some(of) = held.maps.get(index) else {
            let count = held.maps.len();
            return Err(Fault::input(format!("index is {index}, and the frame has {count} maps")));
        };
        // SAFETY: the caller's promise.
        unsafe { put(map, "map", of.described()) }
    })
}

impl HeldMap {
    fn described(&self) -> CMap {
        let ViewMaps { view, filter, nearest, opaque, colored, .. } = &self.maps;
        let from_world = DMat4::from_translation(-self.origin);
        let columns = |matrix: Mat4| (matrix.as_dmat4() * from_world).to_cols_array();
        let colored = colored.as_flattened();
        CMap {
            light: self.light as u32,
            view: self.view.as_ptr(),
            size: view.size.to_array(),
            nodes: self.maps.curve.as_ref().map_or(0, |curve| curve.nodes as u32),
            near_plane: view.near,
            far_plane: view.far,
            filter: filter.as_flattened().as_ptr(),
            nearest: nearest.as_ptr(),
            opaque: opaque.as_ptr(),
            colored: if colored.is_empty() { null() } else { colored.as_ptr() },
            curve: self.curve.as_ref().map_or(null(), |curve| curve.as_flattened().as_ptr()),
            clip_from_world: columns(view.clip_from_world()),
            view_from_world: columns(view.view_from_world),
        }
    }
}
