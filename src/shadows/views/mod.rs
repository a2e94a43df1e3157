//! Maps of the views, kept from frame to frame, and depth maps of the host.
pub(super) mod cache;
pub(super) mod curve_pages;
pub(super) mod host_depths;
pub(super) mod maps;
