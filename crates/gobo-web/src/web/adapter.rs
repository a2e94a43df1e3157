//! The browser's adapter, with subgroups: wgpu 30 neither detects nor requests them in browsers.
use gobo::wgpu;
use js_sys::{Array, Function, Object, Promise, Reflect};
use wasm_bindgen::prelude::*;
use wasm_bindgen_futures::JsFuture;

/// An adapter whose devices have subgroups if the browser supports them, and whether it does.
///
/// # Errors
/// If the browser has none.
pub(super) async fn adapter(
    instance: &wgpu::Instance,
    wants_subgroups: bool,
) -> Result<(wgpu::Adapter, bool), JsError> {
    let options = wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::HighPerformance,
        ..Default::default()
    };
    if wants_subgroups && let Some((gpu, own)) = with_subgroups().await {
        // In place only while wgpu asks, which it does at once.
        let give = Closure::once_into_js(move |_: JsValue| Promise::resolve(&own));
        let is_set = Reflect::set(&gpu, &"requestAdapter".into(), &give).unwrap_or(false);
        let asked = instance.request_adapter(&options);
        let _ = Reflect::delete_property(&gpu, &"requestAdapter".into());
        return Ok((asked.await?, is_set));
    }
    Ok((instance.request_adapter(&options).await?, false))
}

fn function(of: &JsValue, name: &str) -> Option<Function> {
    Reflect::get(of, &name.into()).ok()?.dyn_into().ok()
}

/// The browser's `GPU`, and an adapter of it that adds subgroups to each device request.
async fn with_subgroups() -> Option<(Object, JsValue)> {
    let navigator = Reflect::get(&js_sys::global(), &"navigator".into()).ok()?;
    let gpu: Object = Reflect::get(&navigator, &"gpu".into()).ok()?.dyn_into().ok()?;
    let options = Object::new();
    Reflect::set(&options, &"powerPreference".into(), &"high-performance".into()).ok()?;
    let asked = function(&gpu, "requestAdapter")?.call1(&gpu, &options).ok()?;
    let adapter = JsFuture::from(asked.dyn_into::<Promise>().ok()?).await.ok()?;
    let features = Reflect::get(&adapter, &"features".into()).ok()?;
    let has = function(&features, "has")?.call1(&features, &"subgroups".into()).ok()?;
    if !has.is_truthy() {
        return None;
    }
    let (request, of) = (function(&adapter, "requestDevice")?, adapter.clone());
    let asks = move |wanted: JsValue| -> Result<JsValue, JsValue> {
        let key = "requiredFeatures".into();
        let features = Reflect::get(&wanted, &key)?.dyn_into::<Array>().unwrap_or_default();
        features.push(&"subgroups".into());
        Reflect::set(&wanted, &key, &features)?;
        request.call1(&of, &wanted)
    };
    let asks = Closure::once_into_js(asks);
    Reflect::set(&adapter, &"requestDevice".into(), &asks).ok()?;
    Some((gpu, adapter))
}
