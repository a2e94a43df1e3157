//! Error scopes around objects made on a device, which may be a host's: its own error handler must not hear
//! of our errors.
use crate::error::Error;
use std::{
    pin::pin,
    task::{Context, Poll, Waker},
};
use wgpu::{Device, ErrorFilter};

/// The result of `make`, or the device's validation error.
pub(super) fn guarded<T>(device: &Device, make: impl FnOnce() -> T) -> Result<T, String> {
    let (made, error) = scoped(device, ErrorFilter::Validation, make);
    error.map_or(Ok(made), Err)
}

/// Whether a host's texture is the device's and not destroyed, which only its use shows.
pub fn has_texture(device: &Device, texture: &wgpu::Texture) -> bool {
    guarded(device, || texture.create_view(&wgpu::TextureViewDescriptor::default())).is_ok()
}

/// The result of `make`, or [`Error::Memory`] where the device has no memory for its allocations.
pub fn allocated<T>(device: &Device, make: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    // Any use of an object without memory is invalid.
    let invalid = || scoped(device, ErrorFilter::Validation, make);
    let ((made, invalid), full) = scoped(device, ErrorFilter::OutOfMemory, invalid);
    let full = full.map(Error::Memory);
    full.or(invalid.map(Error::Refused)).map_or(made, Err)
}

fn scoped<T>(
    device: &Device,
    filter: ErrorFilter,
    make: impl FnOnce() -> T,
) -> (T, Option<String>) {
    // A browser reports errors later, on its console.
    if cfg!(target_arch = "wasm32") {
        return (make(), None);
    }
    let scope = device.push_error_scope(filter);
    let made = make();
    let mut context = Context::from_waker(Waker::noop());
    match pin!(scope.pop()).as_mut().poll(&mut context) {
        Poll::Ready(Some(error)) => (made, Some(error.to_string())),
        _ => (made, None),
    }
}
