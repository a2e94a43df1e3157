//! The pipeline, stage by stage, in dispatch order.

/// Every kernel: what the shader tests and `gobo export` walk.
pub const KERNELS: &[&crate::gpu::KernelDesc] = &[];
