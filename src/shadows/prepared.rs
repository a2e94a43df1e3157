//! Maps of a frame in the host's hands.
use super::{
    Caustics, LightShelf, Maps,
    frame_mark::Mark,
    prepare::FrameCommands,
    statistics::{Planned, Statistics},
};
use crate::{
    error::{Error, Input},
    frame::{Commands, Kernels},
    gpu::{Memory, Timeline, check_alive},
    model::{ShadowSettings, View},
    records::GpuView,
};
use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering},
};

/// Maps of a frame, ready to be recorded any number of times, until a later
/// [`prepare`](crate::shadows::Shadows::prepare) takes them over.
#[derive(Debug)]
pub struct Prepared {
    pub(super) queue: wgpu::Queue,
    pub(super) kernels: Kernels,
    pub(super) commands: Arc<FrameCommands>,
    /// Number of the frame, and of the last one that was prepared.
    pub(super) frame: u64,
    pub(super) last: Arc<AtomicU64>,
    /// Mark by which the next frame knows that this one ran, so that it keeps the maps.
    pub(super) mark: Arc<Mark>,
    pub(super) planned: Planned,
    /// Statistics of all frames of the `Shadows`.
    pub(super) statistics: Arc<Statistics>,
    /// Whether some material filters light.
    pub(super) tints: bool,
    pub(super) views: Vec<View>,
    pub(super) settings: ShadowSettings,
    pub(super) maps: Maps,
    /// Light that glass throws, if some light asked for it.
    pub caustics: Option<Caustics>,
    /// Shelf of all frames of the `Shadows`.
    pub(super) light_shelf: Arc<LightShelf>,
}

impl Prepared {
    /// Records every stage of every view that must be rendered. Allocates nothing and submits nothing.
    ///
    /// Maps count as rendered once these commands run: where their encoder is dropped or the device refuses
    /// their submission, the next [`prepare`](crate::shadows::Shadows::prepare) has them rendered again.
    /// Submit the commands before that call: afterwards the device refuses them, naming a mark that was
    /// destroyed or is mapped.
    ///
    /// # Errors
    /// [`Error::Superseded`] if a later [`prepare`](crate::shadows::Shadows::prepare) has taken the maps
    /// over; then nothing is recorded.
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
        self.check_current()?;
        self.commands.rendering.record(encoder, timeline);
        if self.commands.draws {
            self.light_shelf.redraw();
        }
        timeline.end(encoder);
        self.mark.record(encoder);
        Ok(())
    }

    /// Replaces the bindings of the host's casters with index `set` by others of the same layout, from the
    /// next [`Self::record`] on: for hosts that alternate between two buffers.
    ///
    /// # Errors
    /// If there is no such set, the bindings are of another layout, the device is lost, or a later
    /// [`prepare`](crate::shadows::Shadows::prepare) has taken the maps over.
    pub fn rebind(&self, set: usize, bindings: &wgpu::BindGroup) -> Result<(), Error> {
        self.check_usable()?;
        let host = self.commands.counted.host.as_ref();
        let is_bound = host.map_or(Ok(false), |host| host.rebind(set, bindings))?;
        let problem = "there is none, or it has no caster";
        is_bound.then_some(()).ok_or(Input::HostCasters.invalid(set, problem))
    }

    /// Like [`Self::rebind`], for the host's grid with index `grid`, whose voxels a loader reads.
    ///
    /// # Errors
    /// If there is no such grid, the bindings are of another layout, the device is lost, or a later
    /// [`prepare`](crate::shadows::Shadows::prepare) has taken the maps over.
    pub fn rebind_grid(&self, grid: usize, bindings: &wgpu::BindGroup) -> Result<(), Error> {
        self.check_usable()?;
        let host = self.commands.counted.host.as_ref();
        let is_bound = host.map_or(Ok(false), |host| host.rebind_grid(grid, bindings))?;
        let problem = "there is none, or no loader reads it";
        is_bound.then_some(()).ok_or(Input::HostGrid.invalid(grid, problem))
    }

    /// The commands of the frame, for its export.
    #[doc(hidden)]
    pub fn commands(&self) -> &Commands {
        &self.commands.rendering
    }

    /// Device and queue of the maps.
    pub(super) fn device(&self) -> (&wgpu::Device, &wgpu::Queue) {
        (self.kernels.device(), &self.queue)
    }

    /// Records only the counting of pairs: for an unknown scene, [`Self::counters`] then gives the needed
    /// capacity at a fraction of a frame's time, so that no frame takes the slower scatter path.
    ///
    /// # Errors
    /// Those of [`Self::record`].
    pub fn record_counts(&self, encoder: &mut wgpu::CommandEncoder) -> Result<(), Error> {
        self.check_current()?;
        self.commands.counting.record(encoder, &mut Timeline::untimed());
        Ok(())
    }

    /// # Errors
    /// [`Error::Superseded`] if a later `prepare` has taken the maps over.
    pub fn check_current(&self) -> Result<(), Error> {
        let is_last = self.last.load(Ordering::Relaxed) == self.frame;
        is_last.then_some(()).ok_or(Error::Superseded)
    }

    /// # Errors
    /// Those of [`Self::check_current`], and [`Error::Lost`].
    pub(crate) fn check_usable(&self) -> Result<(), Error> {
        self.check_current()?;
        check_alive(self.device().0)
    }

    /// Objects for look-ups in the maps.
    pub fn light_shelf(&self) -> &Arc<LightShelf> {
        &self.light_shelf
    }

    /// The views of the maps.
    pub fn views(&self) -> &[View] {
        &self.views
    }

    /// The views in kernel form, each with its rectangle.
    pub fn gpu_views(&self) -> Vec<GpuView> {
        let views = self.views.iter().zip(&self.maps.slots);
        views.map(|(view, slot)| view.to_gpu(0, slot.origin, slot.layer)).collect()
    }

    /// Textures and rectangles of the maps of all views.
    pub fn maps(&self) -> &Maps {
        &self.maps
    }

    /// Bytes by buffer and texture.
    pub fn memory(&self) -> &Memory {
        &self.commands.memory
    }
}
