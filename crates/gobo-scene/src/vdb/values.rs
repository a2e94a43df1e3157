//! Values of a node: numbers after masks, compressed by zlib or Blosc, or plain.
use super::input::{Input, VolumeFault};
use half::f16;

/// Bytes of a mask with a bit for each of `values`.
pub(super) const fn mask_bytes(values: usize) -> usize {
    values / 8
}

/// Whether bit `i` of a mask is set.
pub(super) fn is_set(mask: &[u8], i: usize) -> bool {
    mask[i / 8] >> (i % 8) & 1 == 1
}

pub(super) fn count_set(mask: &[u8]) -> usize {
    mask.iter().map(|byte| byte.count_ones() as usize).sum()
}

/// Storage type of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum VdbNumber {
    Half,
    Float,
    Double,
}

impl VdbNumber {
    pub(super) const fn bytes(self) -> usize {
        match self {
            Self::Half => 2,
            Self::Float => 4,
            Self::Double => 8,
        }
    }

    fn value(self, bytes: &[u8]) -> f32 {
        match *bytes {
            [a, b] => f16::from_le_bytes([a, b]).to_f32(),
            [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
            [a, b, c, d, e, f, g, h] => f64::from_le_bytes([a, b, c, d, e, f, g, h]) as f32,
            _ => unreachable!("a number has 2, 4 or 8 bytes"),
        }
    }
}

/// First version whose inactive values are left out, as [`Masked`] says.
pub(super) const NODE_MASKS: u32 = 222;

/// Code of the left out values: the byte before a node's values.
#[derive(Clone, Copy)]
struct Masked(u8);

impl Masked {
    /// No value is left out.
    const NOTHING: Self = Self(6);

    fn read(input: &mut Input<'_>) -> Result<Self, VolumeFault> {
        match input.u8("the kind of a node's values")? {
            kind @ 0..=6 => Ok(Self(kind)),
            kind => {
                Err(VolumeFault::damaged(format!("a node's values are of kind {kind}, of 0 to 6")))
            }
        }
    }

    fn leaves_out(self) -> bool {
        self.0 != Self::NOTHING.0
    }

    /// The values of inactive voxels with bit 0 and with bit 1.
    fn inactive(self, encoding: &Encoding, input: &mut Input<'_>) -> Result<[f32; 2], VolumeFault> {
        let mut given = || encoding.single(input, "an inactive value");
        let background = encoding.background;
        Ok(match self.0 {
            2 | 4 => [given()?, background],
            5 => [given()?, given()?],
            0 => [background; 2],
            _ => [-background, background],
        })
    }

    /// Whether a mask selects between two values for inactive voxels.
    fn has_selection(self) -> bool {
        matches!(self.0, 3..=5)
    }
}

/// Encoding of a grid's values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Encoding {
    pub(super) version: u32,
    /// Type of single values.
    pub(super) number: VdbNumber,
    /// Type of the numbers in nodes.
    pub(super) stored: VdbNumber,
    /// Numbers per value, and the index of the one that is read: a channel of a colour.
    pub(super) width: usize,
    pub(super) channel: usize,
    /// Whether unset voxels have the background's value, not 0.
    pub(super) is_filled: bool,
    pub(super) zip: bool,
    pub(super) blosc: bool,
    /// Whether inactive values are left out.
    pub(super) masked: bool,
    /// Value of all voxels outside nodes.
    pub(super) background: f32,
}

/// Most values of a node: those of an upper inner node.
pub(super) const MOST_VALUES: usize = 32 * 32 * 32;

/// Memory for the values of one node.
#[derive(Default)]
pub(super) struct Scratch {
    unpacked: Vec<u8>,
    shuffled: Vec<u8>,
}

impl Encoding {
    /// A single value.
    pub(super) fn single(&self, input: &mut Input<'_>, what: &str) -> Result<f32, VolumeFault> {
        let bytes = input.take(self.number.bytes() * self.width, what)?;
        Ok(self.of_value(self.number, bytes))
    }

    fn of_value(&self, number: VdbNumber, bytes: &[u8]) -> f32 {
        number.value(&bytes[number.bytes() * self.channel..][..number.bytes()])
    }

    /// Value of unset voxels.
    pub(super) fn unset(&self) -> f32 {
        if self.is_filled { self.background } else { 0.0 }
    }

    /// Reads as many values as `values` has; `active` has a bit for each, which version 222 and later need.
    pub(super) fn read(
        &self,
        input: &mut Input<'_>,
        active: &[u8],
        values: &mut [f32],
        scratch: &mut Scratch,
    ) -> Result<(), VolumeFault> {
        let has_kind = self.version >= NODE_MASKS;
        let masked = if has_kind { Masked::read(input)? } else { Masked::NOTHING };
        let inactive = masked.inactive(self, input)?;
        let selection = if masked.has_selection() {
            input.take(active.len(), "a mask of inactive values")?
        } else {
            &[]
        };
        let leaves_out = self.masked && masked.leaves_out();
        let count = if leaves_out { count_set(active) } else { values.len() };
        let numbers = self.unpacked(input, count, scratch)?;
        let mut stored = numbers
            .chunks_exact(self.stored.bytes() * self.width)
            .map(|bytes| self.of_value(self.stored, bytes));
        for (i, value) in values.iter_mut().enumerate() {
            *value = if !leaves_out || is_set(active, i) {
                stored.next().unwrap_or_default()
            } else {
                inactive[usize::from(!selection.is_empty() && is_set(selection, i))]
            };
        }
        Ok(())
    }

    /// Skips `count` values, none of them left out by a mask.
    pub(super) fn skip(
        &self,
        input: &mut Input<'_>,
        count: usize,
        scratch: &mut Scratch,
    ) -> Result<(), VolumeFault> {
        self.unpacked(input, count, scratch).map(|_| ())
    }

    /// The bytes of `count` numbers.
    fn unpacked<'s, 'f: 's>(
        &self,
        input: &mut Input<'f>,
        count: usize,
        scratch: &'s mut Scratch,
    ) -> Result<&'s [u8], VolumeFault> {
        const WHAT: &str = "a node's values";
        let length = count * self.stored.bytes() * self.width;
        // An empty list of half floats is not written at all.
        let is_nothing = count == 0 && self.stored != self.number;
        if !(self.zip || self.blosc) || is_nothing {
            return input.take(length, WHAT);
        }
        let packed = input.i64("the length of a node's values")?;
        let size = usize::try_from(packed.unsigned_abs()).unwrap_or(usize::MAX);
        let bytes = input.take(size, WHAT)?;
        if packed <= 0 {
            if size != length {
                return Err(wrong_length(size, length));
            }
            return Ok(bytes);
        }
        scratch.unpacked.clear();
        scratch.unpacked.resize(length, 0);
        if self.blosc {
            blosc(bytes, &mut scratch.unpacked, &mut scratch.shuffled)?;
        } else {
            inflate(bytes, &mut scratch.unpacked)?;
        }
        Ok(&scratch.unpacked)
    }
}

fn wrong_length(found: usize, expected: usize) -> VolumeFault {
    VolumeFault::damaged(format!("a node's values have {found} bytes instead of {expected}"))
}

/// Unpacks a zlib stream.
pub(super) fn inflate(packed: &[u8], unpacked: &mut [u8]) -> Result<(), VolumeFault> {
    let mut stream = flate2::Decompress::new(true);
    let end = stream.decompress(packed, unpacked, flate2::FlushDecompress::Finish);
    match end {
        Ok(flate2::Status::StreamEnd) if stream.total_out() == unpacked.len() as u64 => Ok(()),
        Ok(_) => Err(VolumeFault::damaged(format!(
            "a node's values are not {} bytes when unpacked",
            unpacked.len()
        ))),
        Err(error) => Err(VolumeFault::damaged(format!("a node's values do not unpack: {error}"))),
    }
}

/// Unpacks a frame of Blosc 1 (Alted 2010, `README_HEADER.rst`): blocks of LZ4 streams, with the bytes of
/// numbers shuffled.
pub(super) fn blosc(
    frame: &[u8],
    unpacked: &mut [u8],
    shuffled: &mut Vec<u8>,
) -> Result<(), VolumeFault> {
    /// The streams of a block are split if each part has enough numbers.
    const MOST_SPLITS: usize = 16;
    const LEAST_SPLIT: usize = 128;
    const HEADER: usize = 16;
    let mut header = Input::new(frame, 2)?;
    let flags = header.u8("the head of a Blosc frame")?;
    let number = usize::from(header.u8("the head of a Blosc frame")?);
    let mut length = || header.u32("the head of a Blosc frame").map(|length| length as usize);
    let (whole, block, packed) = (length()?, length()?, length()?);
    let (is_shuffled, is_copied, has_bits, never_splits, format) =
        (flags & 1 != 0, flags & 2 != 0, flags & 4 != 0, flags & 16 != 0, flags >> 5);
    if whole != unpacked.len() {
        return Err(wrong_length(whole, unpacked.len()));
    }
    if packed != frame.len() {
        return Err(VolumeFault::damaged(format!(
            "a Blosc frame has {} bytes and says {packed}",
            frame.len()
        )));
    }
    if is_copied {
        let copied = Input::new(frame, HEADER)?.take(whole, "a Blosc frame")?;
        unpacked.copy_from_slice(copied);
        return Ok(());
    }
    if format != 1 || has_bits {
        const HELP: &str = "write the file with zip or Blosc LZ4, as OpenVDB does";
        return Err(VolumeFault::new("values packed by Blosc in another way than LZ4", HELP));
    }
    if block == 0 || number == 0 {
        return Err(VolumeFault::damaged("a Blosc frame has blocks or numbers without bytes"));
    }
    for (i, out) in unpacked.chunks_mut(block).enumerate() {
        let start = Input::new(frame, HEADER + 4 * i)?.u32("the start of a Blosc block")?;
        let mut input = Input::new(frame, start as usize)?;
        let is_split = !never_splits
            && number <= MOST_SPLITS
            && block / number >= LEAST_SPLIT
            && out.len() == block
            && out.len().is_multiple_of(number);
        let stream = out.len() / if is_split { number } else { 1 };
        let is_shuffled = is_shuffled && number > 1;
        shuffled.clear();
        shuffled.resize(out.len(), 0);
        for part in shuffled.chunks_mut(stream) {
            let length = input.u32("the length of a Blosc stream")? as usize;
            let bytes = input.take(length, "a Blosc stream")?;
            if length == part.len() {
                part.copy_from_slice(bytes);
            } else if !lz4_flex::block::decompress_into(bytes, part)
                .is_ok_and(|unpacked| unpacked == part.len())
            {
                return Err(VolumeFault::damaged("a node's LZ4 values do not unpack"));
            }
        }
        // Bytes after the last whole number are not shuffled.
        let count = if is_shuffled { out.len() / number } else { 0 };
        for (i, byte) in out.iter_mut().enumerate() {
            let is_sorted = i < count * number;
            *byte = shuffled[if is_sorted { i % number * count + i / number } else { i }];
        }
    }
    Ok(())
}
