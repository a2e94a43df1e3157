//! Arrays that are packed, within memory that the packed bytes can fill.
use crate::{limits::has_memory, vdb::VolumeFault};
use flate2::read::{MultiGzDecoder, ZlibDecoder};
use std::io::Read;

/// Largest array that is unpacked \[bytes\].
pub(super) const MOST_BYTES: usize = 1 << 31;
/// What a byte of a deflated stream unpacks to at most \[bytes\].
const MOST_RATIO: usize = 1032;

/// How bytes are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    Zlib,
    Gzip,
}

/// The first `length` bytes of what is packed.
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

/// Room for unpacked bytes.
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
