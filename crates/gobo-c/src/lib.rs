//! gobo from C: `include/gobo.h` is its documentation, and states the callers' promises.
//!
//! Every function returns to its caller, whatever happens: panics become `GOBO_BUG`.
mod fault;
mod frame;
mod render;
mod scene;
#[cfg(test)]
mod tests;

use std::ffi::{CStr, c_char};

/// Version of the library.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn gobo_version() -> *const c_char {
    const TEXT: &CStr =
        match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
            Ok(text) => text,
            Err(_) => c"",
        };
    TEXT.as_ptr()
}
