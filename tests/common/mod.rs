pub(crate) mod brute_force;
pub(crate) mod compare;
pub(crate) mod scenes;

use gobo::gpu::{Gpu, KernelDesc};

/// A missing GPU fails the test; it never skips it.
pub(crate) fn gpu() -> Gpu {
    Gpu::headless().unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn parse(desc: &KernelDesc) -> naga::Module {
    let wgsl = desc.wgsl();
    naga::front::wgsl::parse_str(&wgsl)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string_with_path(&wgsl, desc.name)))
}
