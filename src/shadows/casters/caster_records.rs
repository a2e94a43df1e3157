//! The records of particles, Gaussians, bricks and capsules on the device.
use super::upload::{ROW_BYTES, upload, upload_parts};
use crate::{
    error::Error,
    frame::Commands,
    gpu::{Allocator, RecordForm, Resource},
    records::{CASTER_TEXELS, CasterRecord, ROW},
};
use std::ops::Range;
use wgpu::{
    Buffer, BufferUsages, Extent3d, Origin3d, Queue, TexelCopyBufferInfo, TexelCopyBufferLayout,
    TexelCopyTextureInfo, Texture,
};

/// Records in a row of a texture.
const ROW_RECORDS: u32 = ROW / CASTER_TEXELS;
/// Most bytes of a write, which is staged in one buffer.
const STRETCH: usize = 32 << 20;

/// Uploaded records, and behind them those that kernels write.
#[derive(Debug)]
pub(in crate::shadows) enum CasterRecords {
    /// All in one buffer.
    InBuffer(Buffer),
    /// All in a texture. Kernels write theirs to `loaded`, from which they are copied.
    InTexture {
        texture: Texture,
        loaded: Option<Buffer>,
        /// First record of `loaded`.
        first: u32,
    },
}

/// First of the records that kernels write, behind `count` uploaded ones: in a texture, the first of a row.
pub(super) fn first_written(form: RecordForm, count: u32) -> u32 {
    match form {
        RecordForm::Buffers => count,
        RecordForm::Textures => count.next_multiple_of(ROW_RECORDS),
    }
}

impl CasterRecords {
    /// Uploads records. `written`: those that kernels write, from [`first_written`] on.
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        queue: &Queue,
        form: RecordForm,
        records: &[CasterRecord],
        written: &Range<u32>,
    ) -> Result<Self, Error> {
        let end = if written.is_empty() { records.len() as u32 } else { written.end };
        let mut buffer = |name, count: u64| {
            allocator.storage::<CasterRecord>(name, count, BufferUsages::COPY_SRC)
        };
        match form {
            RecordForm::Buffers => {
                let buffer = buffer("casters", end.into())?;
                write(queue, &buffer, 0, records);
                Ok(Self::InBuffer(buffer))
            }
            RecordForm::Textures => {
                let rows = (end - written.start.min(end)).div_ceil(ROW_RECORDS);
                let room = u64::from(rows) * u64::from(ROW_RECORDS);
                let loaded = (rows > 0).then(|| buffer("loaded_casters", room)).transpose()?;
                let reserved = end - records.len() as u32;
                let texture = upload(allocator, queue, "casters", records, reserved)?;
                Ok(Self::InTexture { texture, loaded, first: written.start })
            }
        }
    }

    pub(super) fn form(&self) -> RecordForm {
        match self {
            Self::InBuffer(_) => RecordForm::Buffers,
            Self::InTexture { .. } => RecordForm::Textures,
        }
    }

    /// The resource that kernels read.
    pub(super) fn read(&self) -> Resource {
        match self {
            Self::InBuffer(buffer) => buffer.into(),
            Self::InTexture { texture, .. } => texture.into(),
        }
    }

    /// The buffer that kernels write, if records are reserved, and its first record.
    pub(in crate::shadows) fn written(&self) -> (Option<&Buffer>, u32) {
        match self {
            Self::InBuffer(buffer) => (Some(buffer), 0),
            Self::InTexture { loaded, first, .. } => (loaded.as_ref(), *first),
        }
    }

    /// Copies records that kernels have written to where kernels read them.
    pub(in crate::shadows) fn copy(
        &self,
        commands: &mut Commands,
        label: &'static str,
        written: &Range<u32>,
    ) {
        let Self::InTexture { texture, loaded: Some(buffer), first } = self else { return };
        if written.is_empty() {
            return;
        }
        let rows = written.start / ROW_RECORDS..written.end.div_ceil(ROW_RECORDS);
        let layout = TexelCopyBufferLayout {
            offset: u64::from(rows.start - first / ROW_RECORDS) * ROW_BYTES as u64,
            bytes_per_row: Some(ROW_BYTES as u32),
            rows_per_image: None,
        };
        let origin = Origin3d { x: 0, y: rows.start, z: 0 };
        commands.copy_buffer_to_texture(
            label,
            &TexelCopyBufferInfo { buffer, layout },
            TexelCopyTextureInfo { origin, ..texture.as_image_copy() },
            Extent3d { height: rows.len() as u32, ..texture.size() },
        );
    }

    /// Uploads the records of `parts`, which are sorted.
    pub(super) fn update(&self, queue: &Queue, records: &[CasterRecord], parts: &[Range<u32>]) {
        match self {
            Self::InBuffer(buffer) => {
                let mut parts = parts.iter().peekable();
                while let Some(part) = parts.next() {
                    let mut end = part.end;
                    while let Some(next) = parts.next_if(|next| next.start <= end) {
                        end = end.max(next.end);
                    }
                    let new = &records[part.start as usize..end as usize];
                    write(queue, buffer, part.start, new);
                }
            }
            Self::InTexture { texture, .. } => upload_parts(queue, texture, records, parts),
        }
    }
}

/// Writes records from record `first` on.
fn write(queue: &Queue, buffer: &Buffer, first: u32, records: &[CasterRecord]) {
    let mut at = u64::from(first) * size_of::<CasterRecord>() as u64;
    for stretch in bytemuck::cast_slice(records).chunks(STRETCH) {
        queue.write_buffer(buffer, at, stretch);
        at += stretch.len() as u64;
    }
}
