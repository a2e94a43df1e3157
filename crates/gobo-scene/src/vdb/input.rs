//! Bytes of a `.vdb` file, and errors in them.
use glam::{DVec3, IVec3};

/// Reason why a file, or one of its grids, cannot be read.
#[derive(Debug)]
pub(crate) struct VolumeFault {
    pub(crate) message: String,
    /// The remedy.
    pub(crate) help: &'static str,
}

/// Remedy for a file whose contents contradict each other.
const DAMAGED: &str = "the file is damaged: write or copy it again";

impl VolumeFault {
    pub(crate) fn new(message: impl Into<String>, help: &'static str) -> Self {
        Self { message: message.into(), help }
    }

    pub(crate) fn damaged(message: impl Into<String>) -> Self {
        Self::new(message, DAMAGED)
    }
}

/// The rest of a file; all numbers are little-endian.
#[derive(Clone, Copy)]
pub(super) struct Input<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Input<'a> {
    /// `bytes` from `at` on.
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Result<Self, VolumeFault> {
        if at > bytes.len() {
            let length = bytes.len();
            return Err(VolumeFault::damaged(format!(
                "byte {at} is behind the end of {length} bytes"
            )));
        }
        Ok(Self { bytes, at })
    }

    /// Offset from the start of the file \[bytes\].
    pub(super) fn at(&self) -> usize {
        self.at
    }

    /// The next `length` bytes; `what` names them in messages.
    pub(super) fn take(&mut self, length: usize, what: &str) -> Result<&'a [u8], VolumeFault> {
        let rest = &self.bytes[self.at..];
        let Some(taken) = rest.get(..length) else {
            let (at, left) = (self.at, rest.len());
            let message =
                format!("{what} at byte {at} is cut off: {length} bytes, but {left} are left");
            return Err(VolumeFault::damaged(message));
        };
        self.at += length;
        Ok(taken)
    }

    fn number<const N: usize>(&mut self, what: &str) -> Result<[u8; N], VolumeFault> {
        self.take(N, what).map(|bytes| std::array::from_fn(|i| bytes[i]))
    }

    pub(super) fn u8(&mut self, what: &str) -> Result<u8, VolumeFault> {
        self.number::<1>(what).map(|[byte]| byte)
    }

    pub(super) fn u32(&mut self, what: &str) -> Result<u32, VolumeFault> {
        self.number(what).map(u32::from_le_bytes)
    }

    pub(super) fn i64(&mut self, what: &str) -> Result<i64, VolumeFault> {
        self.number(what).map(i64::from_le_bytes)
    }

    pub(super) fn f64(&mut self, what: &str) -> Result<f64, VolumeFault> {
        self.number(what).map(f64::from_le_bytes)
    }

    pub(super) fn ivec3(&mut self, what: &str) -> Result<IVec3, VolumeFault> {
        let [x, y, z] = [self.u32(what)?, self.u32(what)?, self.u32(what)?].map(u32::cast_signed);
        Ok(IVec3::new(x, y, z))
    }

    pub(super) fn dvec3(&mut self, what: &str) -> Result<DVec3, VolumeFault> {
        Ok(DVec3::new(self.f64(what)?, self.f64(what)?, self.f64(what)?))
    }

    /// A text after its length.
    pub(super) fn text(&mut self, what: &str) -> Result<String, VolumeFault> {
        let length = self.u32(what)? as usize;
        self.take(length, what).map(|bytes| String::from_utf8_lossy(bytes).into_owned())
    }
}
