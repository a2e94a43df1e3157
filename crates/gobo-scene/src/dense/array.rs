//! Arrays of numbers in a file's byte order, and the offsets of their voxels.
use crate::vdb::VolumeFault;
use gobo::model::MAX_INDEX;
use half::f16;

/// Storage type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F16,
    F32,
    F64,
}

impl Number {
    /// Size of a number \[bytes\].
    pub(super) const fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 | Self::F16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Number that stands for 1 in a colour.
    pub(super) fn one(self) -> f64 {
        match self {
            Self::F16 | Self::F32 | Self::F64 => 1.0,
            Self::U8 | Self::I8 => f64::from(u8::MAX),
            Self::U16 | Self::I16 => f64::from(u16::MAX),
            _ => f64::from(u32::MAX),
        }
    }

    /// The number in the first bytes; `is_big`: the highest byte comes first.
    fn value(self, bytes: &[u8], is_big: bool) -> f64 {
        fn first<const N: usize>(bytes: &[u8], is_big: bool) -> [u8; N] {
            std::array::from_fn(|i| bytes[if is_big { N - 1 - i } else { i }])
        }
        match self {
            Self::I8 => f64::from(bytes[0].cast_signed()),
            Self::U8 => f64::from(bytes[0]),
            Self::I16 => f64::from(i16::from_le_bytes(first(bytes, is_big))),
            Self::U16 => f64::from(u16::from_le_bytes(first(bytes, is_big))),
            Self::I32 => f64::from(i32::from_le_bytes(first(bytes, is_big))),
            Self::U32 => f64::from(u32::from_le_bytes(first(bytes, is_big))),
            Self::I64 => i64::from_le_bytes(first(bytes, is_big)) as f64,
            Self::U64 => u64::from_le_bytes(first(bytes, is_big)) as f64,
            Self::F16 => f16::from_le_bytes(first(bytes, is_big)).to_f64(),
            Self::F32 => f64::from(f32::from_le_bytes(first(bytes, is_big))),
            Self::F64 => f64::from_le_bytes(first(bytes, is_big)),
        }
    }
}

/// Meaning of an array's axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    X,
    Y,
    Z,
    /// Red, green, blue and perhaps opacity.
    Channel,
    /// Time or another axis: only its first index is read.
    Other,
}

impl Axis {
    pub(super) const SPACE: [Self; 3] = [Self::X, Self::Y, Self::Z];
}

/// Offsets of voxels in an array.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) number: Number,
    /// Whether the highest byte comes first.
    pub(super) is_big: bool,
    /// Voxels along x, y and z.
    pub(super) size: [usize; 3],
    /// Numbers from a voxel to the next along x, y and z.
    strides: [usize; 3],
    /// Channels: 1, or 3 or 4 of a colour.
    pub(super) channels: usize,
    channel_stride: usize,
    /// Volumes along axes of neither space nor colour.
    pub(super) others: u64,
}

impl Layout {
    /// `axes`: lengths and meanings, the fastest first. A missing axis of space has one voxel.
    pub(super) fn new(
        number: Number,
        is_big: bool,
        axes: &[(u64, Axis)],
    ) -> Result<Self, VolumeFault> {
        const HELP: &str = "write an array of three axes, or of four with colours along one";
        let mut layout = Self {
            number,
            is_big,
            size: [1; 3],
            strides: [0; 3],
            channels: 1,
            channel_stride: 0,
            others: 1,
        };
        let mut stride: u64 = 1;
        for &(length, axis) in axes {
            if length == 0 {
                return Err(VolumeFault::new("an axis of the array has no voxels", HELP));
            }
            if axis != Axis::Other && length > MAX_INDEX as u64 {
                let message = format!("{length} voxels along an axis of at most {MAX_INDEX}");
                return Err(VolumeFault::new(message, "cut it into several files"));
            }
            match axis {
                Axis::Channel => {
                    (layout.channels, layout.channel_stride) = (length as usize, stride as usize);
                }
                Axis::Other => layout.others = layout.others.saturating_mul(length),
                Axis::X | Axis::Y | Axis::Z => {
                    let i = axis as usize;
                    (layout.size[i], layout.strides[i]) = (length as usize, stride as usize);
                }
            }
            // Below 2^56, no sum of offsets overflows.
            stride = stride.checked_mul(length).filter(|&all| all < 1 << 56).ok_or_else(|| {
                VolumeFault::damaged("the lengths of its axes are more than any file holds")
            })?;
        }
        if ![1, 3, 4].contains(&layout.channels) {
            let message = format!("{} numbers for each voxel", layout.channels);
            return Err(VolumeFault::new(
                message,
                "give each voxel one number, or three or four of a colour",
            ));
        }
        Ok(layout)
    }

    /// Bytes up to the end of the last voxel that is read.
    pub(super) fn bytes(&self) -> usize {
        let last: usize = (0..3).map(|i| (self.size[i] - 1) * self.strides[i]).sum();
        (last + (self.channels - 1) * self.channel_stride + 1) * self.number.bytes()
    }

    /// A channel of a voxel; `bytes` holds at least [`Self::bytes`] bytes.
    pub(super) fn at(&self, bytes: &[u8], voxel: [usize; 3], channel: usize) -> f64 {
        let [x, y, z] = voxel;
        let [along_x, along_y, along_z] = self.strides;
        let place = x * along_x + y * along_y + z * along_z + channel * self.channel_stride;
        self.number.value(&bytes[place * self.number.bytes()..], self.is_big)
    }
}
