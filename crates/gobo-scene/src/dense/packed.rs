//! Unpacks compressed arrays; the memory for one is bounded by its packed size.
use crate::{limits::has_memory, vdb::VolumeFault};
use flate2::read::{MultiGzDecoder, ZlibDecoder};
use std::io::Read;

/// Largest array that is unpacked \[bytes\].
pub(super) const MOST_BYTES: usize = 1 << 31;
/// Most bytes that a byte of a deflated stream unpacks to.
const MOST_RATIO: usize = 1032;

/// Compression of an array's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    Zlib,
    Gzip,
}

/// The first `length` unpacked bytes.
pub(super) fn unpacked(
    packing: Packing,
    packed: &[u8],
    length: usize,
) -> Result<Vec<u8>, VolumeFault> {
    if length > packed.len().saturating_mul(MOST_RATIO) {
        let message = format!("{length} bytes of voxels in {} packed ones", packed.len());
        return Err(VolumeFault::damaged(message));
    }
    let mut bytes = room(length)?;
    let read = match packing {
        Packing::Zlib => ZlibDecoder::new(packed).take(length as u64).read_to_end(&mut bytes),
        Packing::Gzip => MultiGzDecoder::new(packed).take(length as u64).read_to_end(&mut bytes),
    };
    if let Err(error) = read {
        return Err(VolumeFault::damaged(format!("its voxels do not unpack: {error}")));
    }
    Ok(bytes)
}

/// An empty buffer with capacity for unpacked bytes.
pub(super) fn room(length: usize) -> Result<Vec<u8>, VolumeFault> {
    if length > MOST_BYTES {
        let message = format!("{} MiB of packed voxels", length >> 20);
        return Err(VolumeFault::new(
            message,
            "write the array unpacked, or cut it into several files",
        ));
    }
    if !has_memory(length as u64) {
        let message = format!("no memory for {} MiB of voxels", length >> 20);
        return Err(VolumeFault::new(
            message,
            "use a smaller array, or a machine with more memory",
        ));
    }
    Ok(Vec::with_capacity(length))
}
