//! LAS 1.0 to 1.4 (ASPRS), and LAZ with its compressed records.
use super::{
    DAMAGED, Fault, Point, Points, Room,
    classes::is_noise,
    copc::{self, OctreeNode},
    laz_chunks::{check_layers, check_table},
    linear,
    part::Part,
};
use crate::{read::Readable, share::Share};
use glam::{DVec3, Vec3};
use laz::{
    LasZipDecompressor, LazVlr,
    laszip::ChunkTable,
    record::{LayeredPointRecordDecompressor, RecordDecompressor},
};
use std::io::{Cursor, Seek as _, SeekFrom};

/// Least length of a header, and length of one of version 1.4 \[bytes\].
const HEADER: usize = 227;
const HEADER_4: usize = 375;

/// Length of the head of a variable length record \[bytes\].
const RECORD_HEAD: usize = 54;

/// Records that are decompressed at a time.
const BATCH: u64 = 1 << 14;

/// Formats from this one on are compressed in layers.
const LAYERED: u8 = 6;

/// Least size of a record by its format \[bytes\].
const SIZES: [u16; 11] = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];

fn number<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    std::array::from_fn(|i| bytes[at + i])
}

struct LasHeader {
    format: u8,
    is_packed: bool,
    /// Size of a record \[bytes\].
    size: u16,
    count: u64,
    /// Offset of the points, and of the variable length records \[bytes\].
    start: u64,
    records: usize,
    record_count: u32,
    scale: DVec3,
    offset: DVec3,
}

impl LasHeader {
    fn parse(bytes: &[u8]) -> Result<Self, Fault> {
        let least = if bytes.get(25) == Some(&4) { HEADER_4 } else { HEADER };
        if bytes.len() < least {
            return Err(("the file ends in its header".to_owned(), DAMAGED));
        }
        let minor = bytes[25];
        if bytes[24] != 1 || minor > 4 {
            let message = format!("is LAS {}.{minor}", bytes[24]);
            return Err((message, "gobo reads LAS 1.0 to 1.4"));
        }
        let (packed, size) = (bytes[104], u16::from_le_bytes(number(bytes, 105)));
        // The upper bits are set for compressed records.
        let (format, is_packed) = (packed & 0x3f, packed & 0xc0 != 0);
        let least = SIZES.get(usize::from(format));
        if least.is_none_or(|least| size < *least) {
            let message = format!("points of format {format} with {size} bytes each");
            return Err((message, DAMAGED));
        }
        let mut count = u64::from(u32::from_le_bytes(number(bytes, 107)));
        if minor == 4 {
            count = count.max(u64::from_le_bytes(number(bytes, 247)));
        }
        let three = |at: usize| {
            DVec3::from_array([0, 1, 2].map(|i| f64::from_le_bytes(number(bytes, at + 8 * i))))
        };
        Ok(Self {
            format,
            is_packed,
            size,
            count,
            start: u32::from_le_bytes(number(bytes, 96)).into(),
            records: u16::from_le_bytes(number(bytes, 94)).into(),
            record_count: u32::from_le_bytes(number(bytes, 100)),
            scale: three(131),
            offset: three(155),
        })
    }

    /// Offset of a record's colour \[bytes\].
    fn color(&self) -> Option<usize> {
        match self.format {
            2 => Some(20),
            3 | 5 => Some(28),
            7 | 8 | 10 => Some(30),
            _ => None,
        }
    }

    /// Class of a record, and whether it is marked as deleted.
    fn class(&self, record: &[u8]) -> (u8, bool) {
        if self.format < 6 {
            (record[15] & 31, record[15] & 128 != 0)
        } else {
            (record[16], record[15] & 4 != 0)
        }
    }
}

/// Number of points that a header announces; `None` if the file is too short for them, or has an octree, of
/// which a part may be read.
pub(super) fn announced(head: &[u8], length: u64) -> Option<u64> {
    let header = LasHeader::parse(head).ok().filter(|_| !copc::has_octree(head))?;
    let bytes = header.count.checked_mul(header.size.into())?.checked_add(header.start)?;
    (header.is_packed || bytes <= length).then_some(header.count)
}

/// Version, point format and box of a file, in its own axes.
pub(super) fn facts(head: &[u8]) -> Vec<(&'static str, String)> {
    let Ok(header) = LasHeader::parse(head) else { return Vec::new() };
    let double = |i: usize| f64::from_le_bytes(number(head, 179 + 8 * i));
    // Largest and least x, then y, then z.
    let [most, least] = [0, 1].map(|k| [0, 2, 4].map(|i| double(i + k)));
    vec![
        ("version", format!("{}.{}", head[24], head[25])),
        ("point format", header.format.to_string()),
        ("points", header.count.to_string()),
        ("box in the file", format!("{least:?} to {most:?}")),
        ("colour", (if header.color().is_some() { "yes" } else { "no" }).to_owned()),
        ("compressed", (if header.is_packed { "yes" } else { "no" }).to_owned()),
        ("octree", (if copc::has_octree(head) { "yes (COPC)" } else { "no" }).to_owned()),
    ]
}

/// Whether a file, by its head, has records without compression.
pub(super) fn is_plain(head: &[u8]) -> bool {
    LasHeader::parse(head).is_ok_and(|header| !header.is_packed)
}

/// Reads a file of `length` bytes without compression, some records at a time; parameters as of [`read`].
pub(super) fn read_plain(
    head: &[u8],
    length: u64,
    source: &mut dyn Readable,
    room: Room,
    share: Option<Share>,
) -> Result<Points, Fault> {
    let mut reader = Reader::new(LasHeader::parse(head)?);
    reader.make_room(room, share)?;
    reader.plain(source, length)?;
    Ok(reader.finish())
}

/// Reads a compressed file; of a `share` its points alone, unless the file is read by levels of detail.
pub(super) fn read(bytes: &[u8], room: Room, share: Option<Share>) -> Result<Points, Fault> {
    let mut reader = Reader::new(LasHeader::parse(bytes)?);
    if reader.header.count > room.most() && copc::has_octree(bytes) {
        reader.levels(bytes, room.most())?;
        return Ok(reader.finish());
    }
    reader.make_room(room, share)?;
    reader.packed(bytes)?;
    Ok(reader.finish())
}

/// Says why compressed points cannot be read.
fn bad(error: &dyn std::fmt::Display) -> Fault {
    (format!("its compressed points cannot be read: {error}"), DAMAGED)
}

struct Reader {
    points: Points,
    header: LasHeader,
    /// Largest component of all colours.
    brightest: u16,
}

impl Reader {
    fn new(header: LasHeader) -> Self {
        Self { points: Points::default(), header, brightest: 0 }
    }

    /// Makes room for all points, or those of a share.
    fn make_room(&mut self, room: Room, share: Option<Share>) -> Result<(), Fault> {
        let count = self.header.count;
        let own = share.map_or(count, |share| share.count_of(count));
        room.check(own)?;
        self.points.part = share.map(Part::new);
        self.points.reserve(own as usize)
    }

    fn plain(&mut self, source: &mut dyn Readable, length: u64) -> Result<(), Fault> {
        let (start, count) = (self.header.start, self.header.count);
        let have = length.saturating_sub(start) / u64::from(self.header.size);
        if have < count {
            return Err((format!("the file ends in point {} of {count}", have + 1), DAMAGED));
        }
        let bad = |error| (format!("its points cannot be read: {error}"), DAMAGED);
        source.seek(SeekFrom::Start(start)).map_err(bad)?;
        self.batches(count, |part| source.read_exact(part).map_err(bad))
    }

    /// The parameters of the compression.
    fn laz_vlr(&self, bytes: &[u8]) -> Result<LazVlr, Fault> {
        let vlr = self.laz_record(bytes).ok_or_else(|| bad(&"it has no record of LASzip"))?;
        let vlr = LazVlr::from_buffer(vlr).map_err(|error| bad(&error))?;
        if vlr.items_size() == u64::from(self.header.size) {
            Ok(vlr)
        } else {
            Err(bad(&"sizes of points differ"))
        }
    }

    /// Reads the finest levels of an octree with at most `most` points.
    fn levels(&mut self, bytes: &[u8], most: u64) -> Result<(), Fault> {
        let nodes = copc::nodes(bytes)?;
        let Some(levels) = copc::levels(&nodes, most) else {
            let message = format!("level 0 of its octree has more than {most} points");
            return Err((message, "allow more points, or thin the cloud out"));
        };
        let deepest = nodes.iter().map(|node| node.level).max().unwrap_or_default();
        let nodes: Vec<_> = nodes.iter().filter(|node| levels.contains(&node.level)).collect();
        let count: u64 = nodes.iter().map(|node| node.count).sum();
        self.points.reserve(count as usize)?;
        let vlr = self.laz_vlr(bytes)?;
        for node in nodes {
            self.node(bytes, &vlr, node)?;
        }
        self.points.notes.push(format!(
            "levels 0 to {} of {deepest} of its octree are read: {count} of {} points",
            levels.end(),
            self.header.count
        ));
        Ok(())
    }

    /// Reads a node, which is compressed by itself.
    fn node(&mut self, bytes: &[u8], vlr: &LazVlr, node: &OctreeNode) -> Result<(), Fault> {
        if self.header.format < LAYERED {
            return Err(bad(&"points of an octree have format 6, 7 or 8"));
        }
        let chunk = copc::part(bytes, node.offset, node.size).unwrap_or_default();
        check_layers(chunk, vlr.items(), self.header.size.into()).map_err(|what| bad(&what))?;
        let mut unpacked = LayeredPointRecordDecompressor::new(Cursor::new(chunk));
        unpacked.set_fields_from(vlr.items()).map_err(|error| bad(&error))?;
        self.batches(node.count, |part| unpacked.decompress_many(part).map_err(|error| bad(&error)))
    }

    /// Adds points that `unpack` writes, some at a time.
    fn batches(
        &mut self,
        count: u64,
        mut unpack: impl FnMut(&mut [u8]) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let size = usize::from(self.header.size);
        let mut batch = vec![0; size * BATCH.min(count) as usize];
        let mut left = count;
        while left > 0 {
            let part = &mut batch[..size * left.min(BATCH) as usize];
            unpack(part)?;
            part.chunks_exact(size).for_each(|record| self.push(record));
            left -= left.min(BATCH);
        }
        Ok(())
    }

    fn packed(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        let vlr = self.laz_vlr(bytes)?;
        check_table(bytes, self.header.start).map_err(|what| bad(&what))?;
        let mut source = Cursor::new(bytes);
        source.seek(SeekFrom::Start(self.header.start)).map_err(|error| bad(&error))?;
        if self.header.format >= LAYERED {
            let table = ChunkTable::read_from(source, &vlr).map_err(|error| bad(&error))?;
            return self.chunks(bytes, &vlr, &table);
        }
        let mut unpacked = LasZipDecompressor::new(source, vlr).map_err(|error| bad(&error))?;
        let count = self.header.count;
        self.batches(count, |part| unpacked.decompress_many(part).map_err(|error| bad(&error)))
    }

    /// Reads chunks with layers, which are compressed as the nodes of an octree are.
    fn chunks(&mut self, bytes: &[u8], vlr: &LazVlr, table: &ChunkTable) -> Result<(), Fault> {
        let mut left = self.header.count;
        let mut offset = self.header.start + ChunkTable::OFFSET_SIZE as u64;
        for entry in table {
            // Chunks of equal counts: the last has fewer points.
            let (count, size) = (entry.point_count.min(left), entry.byte_count);
            if count > 0 {
                self.node(bytes, vlr, &OctreeNode { level: 0, count, offset, size })?;
            }
            left -= count;
            offset = offset.saturating_add(size);
        }
        if left == 0 { Ok(()) } else { Err(bad(&"chunks of its points are missing")) }
    }

    /// The record about the compression of points.
    fn laz_record<'a>(&self, bytes: &'a [u8]) -> Option<&'a [u8]> {
        let mut rest = bytes.get(self.header.records..)?;
        for _ in 0..self.header.record_count {
            let (head, behind) = rest.split_at_checked(RECORD_HEAD)?;
            let length = usize::from(u16::from_le_bytes(number(head, 20)));
            let (record, behind) = behind.split_at_checked(length)?;
            let is_laz = head[2..18].starts_with(LazVlr::USER_ID.as_bytes())
                && u16::from_le_bytes(number(head, 18)) == LazVlr::RECORD_ID;
            if is_laz {
                return Some(record);
            }
            rest = behind;
        }
        None
    }

    fn push(&mut self, record: &[u8]) {
        let (class, is_deleted) = self.header.class(record);
        if is_deleted {
            return self.points.skip("withheld");
        }
        if is_noise(class) {
            return self.points.skip("noise");
        }
        let stored = [0, 4, 8].map(|at| f64::from(i32::from_le_bytes(number(record, at))));
        let color = self.header.color().map(|at| {
            let rgb = [0, 2, 4].map(|i| u16::from_le_bytes(number(record, at + i)));
            self.brightest = rgb.into_iter().fold(self.brightest, u16::max);
            Vec3::from_array(rgb.map(f32::from))
        });
        self.points.push(Point {
            position: DVec3::from_array(stored) * self.header.scale + self.header.offset,
            color,
            intensity: Some(u16::from_le_bytes(number(record, 12)).into()),
            class: Some(class),
        });
    }

    /// Colours have 16 bits, of which many programs use only 8.
    fn finish(mut self) -> Points {
        let most = if self.brightest > 255 { 65535.0 } else { 255.0 };
        for color in &mut self.points.colors {
            *color = linear((*color / most).to_array());
        }
        self.points
    }
}
