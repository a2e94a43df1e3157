//! The pipeline, stage by stage, in dispatch order.
pub mod sort;

/// Every kernel: what the layout and shader tests and the export walk.
pub const KERNELS: &[&crate::gpu::KernelDesc] = &[
    &sort::SERIAL_COUNT,
    &sort::SERIAL_SCAN,
    &sort::SERIAL_SCATTER,
    &sort::WIDE_COUNT,
    &sort::WIDE_SCAN,
    &sort::WIDE_SCATTER,
];
