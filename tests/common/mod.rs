pub(crate) mod brute_force;
pub(crate) mod compare;
pub(crate) mod scenes;

use gobo::gpu::Gpu;

/// A missing GPU fails the test; it never skips it.
pub(crate) fn gpu() -> Gpu {
    Gpu::headless().unwrap_or_else(|error| panic!("{error}"))
}
