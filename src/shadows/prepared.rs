//! Maps of a frame in the host's hands.
use super::{
    Maps, PreparedMaps,
    kernels::Variant,
    shadows::{Engine, lock},
};
use crate::{
    error::Error,
    frame::{Commands, Kernels},
    gpu::{Kernel, Memory, Timeline},
    model::{ShadowSettings, View},
    stage::features::Features,
};
use std::sync::{Arc, Mutex};

/// Maps of a frame, ready to be recorded any number of times, until a later
/// [`prepare`](crate::shadows::Shadows::prepare) takes them over.
#[derive(Debug)]
pub struct Prepared {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) kernels: Kernels,
    pub(super) engine: Arc<Mutex<Engine>>,
    pub(super) frame: u64,
    pub(super) caster_count: u64,
    /// Whether blending depends on the order of the casters.
    pub(super) ordered: bool,
    /// Whether some material filters light.
    pub(super) tints: bool,
    pub(super) views: Vec<View>,
    pub(super) settings: ShadowSettings,
    pub(super) maps: Maps,
    pub(super) memory: Memory,
}

impl Prepared {
    /// Records every stage of every view that must be rendered. Allocates nothing and submits nothing.
    ///
    /// # Errors
    /// [`Error::Superseded`] if a later [`prepare`](crate::shadows::Shadows::prepare) has taken the maps over; then
    /// nothing is recorded.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder) -> Result<(), Error> {
        self.record_timed(encoder, &mut Timeline::untimed())
    }

    /// Like [`Self::record`], with timestamps around each stage.
    ///
    /// # Errors
    /// Those of [`Self::record`].
    pub fn record_timed(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) -> Result<(), Error> {
        self.with_maps(|maps| {
            maps.record(encoder, timeline);
            timeline.end(encoder);
            Ok(())
        })
    }

    /// Replaces the bindings of the host's casters of `set`, an index, by others of the same layout, from
    /// the next [`Self::record`] on: for hosts that alternate between two buffers.
    ///
    /// # Errors
    /// If there is no such set, or a later [`prepare`](crate::shadows::Shadows::prepare) has taken the maps over.
    pub fn rebind(&self, set: usize, bindings: &wgpu::BindGroup) -> Result<(), Error> {
        let engine = lock(&self.engine);
        let host = self.current(&engine)?.host.as_ref();
        let problem = "there is none, or it has no caster";
        let none = Error::Invalid { what: "set of host casters", index: set, problem };
        host.is_some_and(|host| host.rebind(set, bindings)).then_some(()).ok_or(none)
    }

    /// A kernel of this device, compiled if needed.
    pub(super) fn kernel(&self, variant: Variant, features: Features) -> Result<Kernel, Error> {
        let kernel = self.kernels.of(variant, features)?;
        kernel.make()?;
        Ok(kernel)
    }

    /// The commands of the frame: for its export.
    ///
    /// # Errors
    /// If a later [`prepare`](crate::shadows::Shadows::prepare) has taken the maps over.
    #[doc(hidden)]
    pub fn commands(&self) -> Result<Commands, Error> {
        self.with_maps(|maps| Ok(maps.commands.clone()))
    }

    /// Device and queue of the maps.
    pub(super) fn device(&self) -> (&wgpu::Device, &wgpu::Queue) {
        (&self.device, &self.queue)
    }

    /// Records only the counting of pairs: if nothing of a scene is known, [`Self::counters`] then gives
    /// the needed capacity at a fraction of a frame's time, so that no frame takes the slower scatter path.
    ///
    /// # Errors
    /// Those of [`Self::record`].
    pub fn record_counts(&self, encoder: &mut wgpu::CommandEncoder) -> Result<(), Error> {
        self.with_maps(|maps| {
            maps.counting.record(encoder, &mut Timeline::untimed());
            Ok(())
        })
    }

    pub(super) fn with_maps<T>(
        &self,
        act: impl FnOnce(&PreparedMaps) -> Result<T, Error>,
    ) -> Result<T, Error> {
        act(self.current(&lock(&self.engine))?)
    }

    fn current<'a>(&self, engine: &'a Engine) -> Result<&'a PreparedMaps, Error> {
        engine.maps.as_ref().filter(|_| engine.frame == self.frame).ok_or(Error::Superseded)
    }

    /// Textures and rectangles of the maps of all views.
    pub fn maps(&self) -> &Maps {
        &self.maps
    }

    /// Bytes by buffer and texture.
    pub fn memory(&self) -> &Memory {
        &self.memory
    }
}
