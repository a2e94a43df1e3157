//! Shadow maps for other code on the device.
use super::{Gobo, of_show};
use crate::Knobs;
use gobo::wgpu;
use js_sys::{Array, Float32Array, Object, Reflect};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** A shadow map: one of a light's views. */
export interface MapView {
    light: number;
    name: string;
    /** Edges [texels]. */
    size: [number, number];
    /** Its first texel in the textures. */
    origin: [number, number];
    /** Its layer in the textures. */
    layer: number;
    near: number;
    far: number;
    /** Columns; depths are linear along the axis: 0 at `near`, 1 at `far`. */
    view_from_world: Float32Array;
    clip_from_world: Float32Array;
}

/** Shadow maps of all views, textures of the device, until the next call of `maps`. */
export interface Maps {
    /** `rgba16float`: transmittance of the translucent casters in front of the opaque depth. */
    filter: GPUTexture;
    /** `r32float`: depth of the nearest translucent caster. */
    nearest: GPUTexture;
    /** `r32float`: depth of the nearest opaque caster. */
    opaque: GPUTexture;
    /** `rgba32uint`: `nodes` / 2 layers for each layer of the others. */
    curve: GPUTexture;
    nodes: number;
    views: MapView[];
}
"#;

fn set(object: &Object, key: &str, value: impl Into<JsValue>) {
    // A plain object takes every key.
    let _ = Reflect::set(object, &key.into(), &value.into());
}

fn texture(texture: &wgpu::Texture) -> JsValue {
    texture.as_webgpu().map_or(JsValue::UNDEFINED, |texture| texture.clone().into())
}

fn pair([a, b]: [u32; 2]) -> Array {
    [a, b].into_iter().map(JsValue::from).collect()
}

#[wasm_bindgen]
impl Gobo {
    /// Renders the shadow maps of the scene's lights, as textures of `device`.
    ///
    /// @param {number} [size] Edge of a map, 16 to 4096 [texels]; 1024 by default.
    #[wasm_bindgen(unchecked_return_type = "Maps")]
    pub fn maps(&mut self, size: Option<u32>) -> Result<JsValue, JsError> {
        let show = self.shown()?;
        show.set_most_texels(size.unwrap_or(1024).clamp(16, super::LARGEST_MAP));
        let knobs = Knobs::default();
        let maps = show.shade_maps(&knobs).map_err(of_show)?.maps().clone();
        let views = Array::new();
        for (view, slot) in show.map_views().iter().zip(&maps.slots) {
            let of = Object::new();
            set(
                &of,
                "light",
                view.light.map_or(JsValue::NULL, |light| JsValue::from(light as u32)),
            );
            set(&of, "name", view.name);
            set(&of, "size", pair(view.size.into()));
            set(&of, "origin", pair(slot.origin.into()));
            set(&of, "layer", slot.layer);
            set(&of, "near", view.near);
            set(&of, "far", view.far);
            let columns =
                |matrix: gobo::glam::Mat4| Float32Array::from(&matrix.to_cols_array()[..]);
            set(&of, "view_from_world", columns(view.view_from_world));
            set(&of, "clip_from_world", columns(view.clip_from_world()));
            views.push(&of);
        }
        let all = Object::new();
        set(&all, "filter", texture(&maps.filters));
        set(&all, "nearest", texture(&maps.nearests));
        set(&all, "opaque", texture(&maps.opaques));
        set(&all, "curve", texture(&maps.curves));
        set(&all, "nodes", maps.nodes);
        set(&all, "views", views);
        Ok(all.into())
    }
}
