//! The commands of a frame, and their recording.
use super::Dispatch;
use crate::gpu::{KernelError, Timeline};
use std::fmt;
use wgpu::{Buffer, Extent3d, TexelCopyBufferInfo, TexelCopyTextureInfo, Texture};
use wgpu::{TexelCopyBufferLayout, TexelCopyTextureInfoBase};

/// A command of a frame. Labels are those of the timeline's stages.
#[derive(Clone)]
pub enum Command {
    /// Dispatches of one compute pass, in order: each sees the writes of those before.
    Pass {
        /// Label of its stage.
        label: &'static str,
        /// The dispatches.
        dispatches: Vec<Dispatch>,
    },
    /// Sets a buffer to zero.
    Clear {
        /// Label of its stage.
        label: &'static str,
        /// The buffer.
        buffer: Buffer,
    },
    /// Copies bytes; each buffer with an offset \[bytes\].
    CopyBuffer {
        /// Label of its stage.
        label: &'static str,
        /// Source.
        from: (Buffer, u64),
        /// Destination.
        to: (Buffer, u64),
        /// Size \[bytes\].
        size: u64,
    },
    /// Copies texels from a buffer.
    CopyBufferToTexture {
        /// Label of its stage.
        label: &'static str,
        /// Source.
        from: (Buffer, TexelCopyBufferLayout),
        /// Destination.
        to: TexelCopyTextureInfoBase<Texture>,
        /// Size \[texels\].
        size: Extent3d,
    },
    /// Copies texels between textures.
    CopyTexture {
        /// Label of its stage.
        label: &'static str,
        /// Source.
        from: TexelCopyTextureInfoBase<Texture>,
        /// Destination.
        to: TexelCopyTextureInfoBase<Texture>,
        /// Size \[texels\].
        size: Extent3d,
    },
}

impl Command {
    /// Label of the stage that it belongs to.
    pub fn label(&self) -> &'static str {
        match self {
            Self::Pass { label, .. }
            | Self::Clear { label, .. }
            | Self::CopyBuffer { label, .. }
            | Self::CopyBufferToTexture { label, .. }
            | Self::CopyTexture { label, .. } => label,
        }
    }

    /// Dispatches of a pass.
    fn dispatches(&self) -> Option<&[Dispatch]> {
        match self {
            Self::Pass { dispatches, .. } => Some(dispatches),
            _ => None,
        }
    }
}

/// Commands in the order of their recording.
#[derive(Clone, Default)]
pub struct Commands(Vec<Command>);

impl Commands {
    /// No commands.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a compute pass. A pass without dispatches is recorded too, so that each frame has a time for it.
    /// Neighbouring passes are recorded as one where nothing is timed.
    pub fn pass(&mut self, label: &'static str, dispatches: impl IntoIterator<Item = Dispatch>) {
        let dispatches = dispatches.into_iter().collect();
        self.0.push(Command::Pass { label, dispatches });
    }

    /// Sets a buffer to zero.
    pub fn clear(&mut self, label: &'static str, buffer: &Buffer) {
        self.0.push(Command::Clear { label, buffer: buffer.clone() });
    }

    /// Copies `size` bytes; offsets in bytes.
    pub fn copy_buffer(
        &mut self,
        label: &'static str,
        (from, from_offset): (&Buffer, u64),
        (to, to_offset): (&Buffer, u64),
        size: u64,
    ) {
        let (from, to) = ((from.clone(), from_offset), (to.clone(), to_offset));
        self.0.push(Command::CopyBuffer { label, from, to, size });
    }

    /// Adds a copy of texels from a buffer, with the layout there.
    pub fn copy_buffer_to_texture(
        &mut self,
        label: &'static str,
        from: &TexelCopyBufferInfo<'_>,
        to: TexelCopyTextureInfo<'_>,
        size: Extent3d,
    ) {
        let from = (from.buffer.clone(), from.layout);
        self.0.push(Command::CopyBufferToTexture { label, from, to: owned(to), size });
    }

    /// Adds a copy of texels between textures.
    pub fn copy_texture(
        &mut self,
        label: &'static str,
        from: TexelCopyTextureInfo<'_>,
        to: TexelCopyTextureInfo<'_>,
        size: Extent3d,
    ) {
        self.0.push(Command::CopyTexture { label, from: owned(from), to: owned(to), size });
    }

    /// Adds the commands of `other` behind these.
    pub fn append(&mut self, other: Self) {
        self.0.extend(other.0);
    }

    /// Compute passes of an untimed recording.
    pub fn pass_count(&self) -> usize {
        let begins = |i: usize| {
            self.0[i].dispatches().is_some() && (i == 0 || self.0[i - 1].dispatches().is_none())
        };
        (0..self.0.len()).filter(|&i| begins(i)).count()
    }

    /// Dispatches, also those whose workgroups only the device knows.
    pub fn dispatch_count(&self) -> usize {
        self.0.iter().filter_map(Command::dispatches).map(<[Dispatch]>::len).sum()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The commands, in order.
    pub fn iter(&self) -> impl Iterator<Item = &Command> {
        self.0.iter()
    }

    /// Compiles the kernels of all dispatches, on this thread.
    pub fn compile(&self) -> Result<(), KernelError> {
        let mut dispatches = self.0.iter().filter_map(Command::dispatches).flatten();
        dispatches.try_for_each(|dispatch| dispatch.kernel.make())
    }

    /// Records all commands. Makes nothing on the device.
    ///
    /// # Panics
    /// If a kernel is not compiled and the device refuses it, which
    /// [`Kernels::finish`](super::Kernels::finish) would have returned as an error.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline) {
        let (mut step, mut commands) = (None, &self.0[..]);
        while let Some(command) = commands.first() {
            if let (Command::Pass { label, dispatches }, true) = (command, timeline.is_by_kernel())
            {
                for dispatch in dispatches {
                    let mut pass = timeline.kernel_pass(encoder, label, dispatch.kernel.name());
                    dispatch.record(&mut pass);
                }
                (step, commands) = (None, &commands[1..]);
                continue;
            }
            if let Command::Pass { label, .. } = command {
                // Each dispatch sees the writes of those before, in one pass as in several. A pass costs wgpu
                // more than a dispatch, and has a time of its own.
                let neighbours = commands.iter().map_while(Command::dispatches);
                let count = if timeline.is_timed() { 1 } else { neighbours.clone().count() };
                let mut pass = timeline.pass(encoder, label);
                let dispatches = neighbours.take(count).flatten();
                dispatches.for_each(|dispatch| dispatch.record(&mut pass));
                (step, commands) = (None, &commands[count..]);
                continue;
            }
            commands = &commands[1..];
            if step.replace(command.label()) != Some(command.label()) {
                timeline.step(encoder, command.label());
            }
            match command {
                Command::Pass { .. } => {}
                Command::Clear { buffer, .. } => encoder.clear_buffer(buffer, 0, None),
                Command::CopyBuffer { from, to, size, .. } => {
                    encoder.copy_buffer_to_buffer(&from.0, from.1, &to.0, to.1, *size);
                }
                Command::CopyBufferToTexture { from: (buffer, layout), to, size, .. } => {
                    let from = TexelCopyBufferInfo { buffer, layout: *layout };
                    encoder.copy_buffer_to_texture(from, borrowed(to), *size);
                }
                Command::CopyTexture { from, to, size, .. } => {
                    encoder.copy_texture_to_texture(borrowed(from), borrowed(to), *size);
                }
            }
        }
    }
}

fn owned(
    TexelCopyTextureInfo { texture, mip_level, origin, aspect }: TexelCopyTextureInfo<'_>,
) -> TexelCopyTextureInfoBase<Texture> {
    TexelCopyTextureInfoBase { texture: texture.clone(), mip_level, origin, aspect }
}

fn borrowed(of: &TexelCopyTextureInfoBase<Texture>) -> TexelCopyTextureInfo<'_> {
    let &TexelCopyTextureInfoBase { ref texture, mip_level, origin, aspect } = of;
    TexelCopyTextureInfo { texture, mip_level, origin, aspect }
}

impl fmt::Debug for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.label())?;
        match self {
            Self::Pass { dispatches, .. } => {
                dispatches.iter().try_for_each(|dispatch| write!(f, "\n  {dispatch:?}"))
            }
            Self::Clear { buffer, .. } => write!(f, "\n  clears {} bytes", buffer.size()),
            Self::CopyBuffer { size, .. } => write!(f, "\n  copies {size} bytes"),
            Self::CopyBufferToTexture { size, .. } | Self::CopyTexture { size, .. } => {
                let Extent3d { width, height, depth_or_array_layers } = size;
                write!(f, "\n  copies {width} x {height} x {depth_or_array_layers} texels")
            }
        }
    }
}

/// A line for each dispatch, below the label of its pass.
impl fmt::Debug for Commands {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|command| writeln!(f, "{command:?}"))
    }
}
