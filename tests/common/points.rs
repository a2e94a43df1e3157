//! Small point clouds, written after the formats' descriptions, byte by byte.
use laz::{LasZipCompressor, LazItemRecordBuilder, LazVlr, LazVlrBuilder, laszip::ChunkTable};
use std::{fmt::Write as _, io::Cursor};

/// A point in a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dot {
    /// Position in the file's axes, z up [m].
    pub(crate) place: [f64; 3],
    pub(crate) rgb: [u8; 3],
    pub(crate) intensity: u16,
    pub(crate) class: u8,
}

pub(crate) const DOTS: [Dot; 4] = [
    Dot { place: [0.0, 0.0, 0.0], rgb: [255, 0, 51], intensity: 100, class: 2 },
    Dot { place: [1.0, 0.0, 0.5], rgb: [0, 128, 255], intensity: 200, class: 5 },
    Dot { place: [0.0, 2.0, -0.25], rgb: [10, 20, 30], intensity: 50, class: 6 },
    Dot { place: [-1.5, 1.0, 3.0], rgb: [255, 255, 255], intensity: 25, class: 1 },
];

/// Scale of coordinates in LAS files [m].
pub(crate) const SCALE: f64 = 0.001;

/// Records in a point format.
fn records(format: u8, dots: &[Dot], offset: [f64; 3], depth: u16) -> (u16, Vec<u8>) {
    let size: u16 = match format {
        0 => 20,
        2 => 26,
        3 => 34,
        6 => 30,
        7 => 36,
        _ => panic!("no such format in the tests"),
    };
    let mut all = Vec::new();
    for dot in dots {
        let mut record = vec![0; usize::from(size)];
        for k in 0..3 {
            let word = ((dot.place[k] - offset[k]) / SCALE).round() as i32;
            record[4 * k..4 * k + 4].copy_from_slice(&word.to_le_bytes());
        }
        record[12..14].copy_from_slice(&dot.intensity.to_le_bytes());
        record[14] = 0b0000_1001;
        record[if format < 6 { 15 } else { 16 }] = dot.class;
        if let Some(at) = [(2, 20), (3, 28), (7, 30)].iter().find(|known| known.0 == format) {
            for k in 0..3 {
                let word = u16::from(dot.rgb[k]) * depth;
                record[at.1 + 2 * k..at.1 + 2 * k + 2].copy_from_slice(&word.to_le_bytes());
            }
        }
        all.extend(record);
    }
    (size, all)
}

/// LAS in a point format; 1.4 from format 6 on, 1.2 below. `depth`: step of a colour.
pub(crate) fn las(format: u8, dots: &[Dot], offset: [f64; 3], depth: u16) -> Vec<u8> {
    let (size, records) = records(format, dots, offset, depth);
    let mut file = head(format, size, dots.len(), offset, &[]);
    file.extend(records);
    file
}

/// LAZ, compressed by the tested crate.
pub(crate) fn laz(format: u8, dots: &[Dot], offset: [f64; 3]) -> Vec<u8> {
    let (size, records) = records(format, dots, offset, 257);
    let items = LazItemRecordBuilder::default_for_point_format_id(format, 0).unwrap();
    let vlr = LazVlr::from_laz_items(items);
    let mut record = Vec::new();
    vlr.write_to(&mut record).unwrap();
    let mut file = Cursor::new(head(format | 128, size, dots.len(), offset, &record));
    file.set_position(file.get_ref().len() as u64);
    let mut packed = LasZipCompressor::new(&mut file, vlr).unwrap();
    packed.compress_many(&records).unwrap();
    packed.done().unwrap();
    drop(packed);
    file.into_inner()
}

/// COPC of points of format 7: LAZ with a chunk and a node a level, the coarsest first. Level 1 and finer are
/// in a page of their own.
pub(crate) fn copc(levels: &[&[Dot]]) -> Vec<u8> {
    let items = LazItemRecordBuilder::default_for_point_format_id(7, 0).unwrap();
    let vlr = LazVlrBuilder::new(items).with_variable_chunk_size().build();
    let mut record = Vec::new();
    vlr.write_to(&mut record).unwrap();
    let count = levels.iter().map(|dots| dots.len()).sum();
    let mut file = head(7 | 128, 36, count, [0.0; 3], &record);
    // The record of the octree is the first.
    let mut info = vec![0; 54 + 160];
    info[2..6].copy_from_slice(b"copc");
    info[18] = 1;
    info[20] = 160;
    let first = 375..375 + 54 + 3;
    file.splice(first, info.clone());
    let start = file.len() as u64;
    file[96..100].copy_from_slice(&(start as u32).to_le_bytes());
    let mut file = Cursor::new(file);
    file.set_position(start);
    let mut packed = LasZipCompressor::new(&mut file, vlr.clone()).unwrap();
    for dots in levels {
        packed.compress_many(&records(7, dots, [0.0; 3], 257).1).unwrap();
        packed.finish_current_chunk().unwrap();
    }
    packed.done().unwrap();
    drop(packed);
    file.set_position(start);
    let chunks = ChunkTable::read_from(&mut file, &vlr).unwrap();
    let mut file = file.into_inner();
    let mut offset = start + 8;
    let mut entries: Vec<Vec<u8>> = Vec::new();
    for ((level, chunk), dots) in (0_i32..).zip(&chunks).zip(levels) {
        let mut entry: Vec<u8> = [level, 0, 0, 0].iter().flat_map(|k| k.to_le_bytes()).collect();
        entry.extend(offset.to_le_bytes());
        entry.extend((chunk.byte_count as i32).to_le_bytes());
        entry.extend((dots.len() as i32).to_le_bytes());
        entries.push(entry);
        offset += chunk.byte_count;
    }
    // A page that names another, whose key is that of level 1.
    let (root, rest) = entries.split_at(1);
    let page = file.len() as u64;
    let mut link: Vec<u8> = [1_i32, 0, 0, 0].iter().flat_map(|k| k.to_le_bytes()).collect();
    link.extend((page + 64).to_le_bytes());
    link.extend((32 * rest.len() as i32).to_le_bytes());
    link.extend((-1_i32).to_le_bytes());
    file.extend([&root.concat()[..], &link, &rest.concat()].concat());
    file[429 + 40..429 + 48].copy_from_slice(&page.to_le_bytes());
    file[429 + 48..429 + 56].copy_from_slice(&64_u64.to_le_bytes());
    file
}

fn head(format: u8, size: u16, count: usize, offset: [f64; 3], laz: &[u8]) -> Vec<u8> {
    let is_new = format & 63 >= 6;
    let length: u16 = if is_new { 375 } else { 227 };
    let mut head = vec![0; usize::from(length)];
    let mut put = |at: usize, bytes: &[u8]| head[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, b"LASF");
    put(24, &[1, if is_new { 4 } else { 2 }]);
    put(94, &length.to_le_bytes());
    // An unrelated record precedes that of the compression.
    let vlrs = 54 + 3 + if laz.is_empty() { 0 } else { 54 + laz.len() };
    put(96, &(u32::from(length) + vlrs as u32).to_le_bytes());
    put(100, &[if laz.is_empty() { 1 } else { 2 }]);
    put(104, &[format]);
    put(105, &size.to_le_bytes());
    if is_new {
        put(247, &(count as u64).to_le_bytes());
    } else {
        put(107, &(count as u32).to_le_bytes());
    }
    for (k, offset) in offset.iter().enumerate() {
        put(131 + 8 * k, &SCALE.to_le_bytes());
        put(155 + 8 * k, &offset.to_le_bytes());
    }
    let mut record = |user: &[u8], id: u16, bytes: &[u8]| {
        let start = head.len();
        head.resize(start + 54, 0);
        head[start + 2..start + 2 + user.len()].copy_from_slice(user);
        head[start + 18..start + 20].copy_from_slice(&id.to_le_bytes());
        head[start + 20..start + 22].copy_from_slice(&(bytes.len() as u16).to_le_bytes());
        head.extend(bytes);
    };
    record(b"someone", 7, b"abc");
    if !laz.is_empty() {
        record(b"laszip encoded", 22204, laz);
    }
    head
}

/// PCD 0.7 as `ascii`, `binary` or `binary_compressed`.
pub(crate) fn pcd(encoding: &str, dots: &[Dot]) -> Vec<u8> {
    let mut text = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n\
        FIELDS x normal y z rgb intensity\nSIZE 4 4 8 4 4 2\nTYPE F F F F U U\nCOUNT 1 3 1 1 1 1\n"
        .to_owned();
    let _ = write!(
        text,
        "WIDTH {}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA {encoding}\n",
        dots.len(),
        dots.len()
    );
    let word = |dot: &Dot| {
        let [r, g, b] = dot.rgb.map(u32::from);
        r << 16 | g << 8 | b
    };
    let columns = |dot: &Dot| -> [Vec<u8>; 6] {
        let [x, y, z] = dot.place;
        [
            (x as f32).to_le_bytes().to_vec(),
            [7; 12].to_vec(),
            y.to_le_bytes().to_vec(),
            (z as f32).to_le_bytes().to_vec(),
            word(dot).to_le_bytes().to_vec(),
            dot.intensity.to_le_bytes().to_vec(),
        ]
    };
    if encoding == "ascii" {
        for dot in dots {
            let ([x, y, z], color) = (dot.place, word(dot));
            let _ = writeln!(text, "{x} 0 0 1 {y} {z} {color} {}", dot.intensity);
        }
        return text.into_bytes();
    }
    let mut file = text.into_bytes();
    let rows: Vec<[Vec<u8>; 6]> = dots.iter().map(columns).collect();
    if encoding == "binary" {
        file.extend(rows.iter().flatten().flatten());
        return file;
    }
    let plain: Vec<u8> =
        (0..6).flat_map(|k| rows.iter().flat_map(move |row| row[k].clone())).collect();
    // LZF without a run: each 32 bytes follow their number less one.
    let packed: Vec<u8> =
        plain.chunks(32).flat_map(|chunk| [&[chunk.len() as u8 - 1], chunk].concat()).collect();
    file.extend((packed.len() as u32).to_le_bytes());
    file.extend((plain.len() as u32).to_le_bytes());
    file.extend(packed);
    file
}

/// E57 with one scan, written by the tested crate, moved by (0, 0, 10).
pub(crate) fn e57(dots: &[Dot]) -> Vec<u8> {
    use e57::{
        E57Writer, Quaternion, Record, RecordDataType, RecordName, RecordValue, Transform,
        Translation,
    };
    let double = |name| Record { name, data_type: RecordDataType::Double { min: None, max: None } };
    let byte = |name| Record { name, data_type: RecordDataType::Integer { min: 0, max: 255 } };
    let mut file = Cursor::new(Vec::new());
    let mut writer = E57Writer::new(&mut file, "file").unwrap();
    let prototype = vec![
        double(RecordName::CartesianX),
        double(RecordName::CartesianY),
        double(RecordName::CartesianZ),
        byte(RecordName::ColorRed),
        byte(RecordName::ColorGreen),
        byte(RecordName::ColorBlue),
    ];
    let mut scan = writer.add_pointcloud("scan", prototype).unwrap();
    scan.set_transform(Some(Transform {
        rotation: Quaternion { w: 1.0, x: 0.0, y: 0.0, z: 0.0 },
        translation: Translation { x: 0.0, y: 0.0, z: 10.0 },
    }));
    for dot in dots {
        let place = dot.place.map(RecordValue::Double);
        let rgb = dot.rgb.map(|c| RecordValue::Integer(c.into()));
        scan.add_point([place, rgb].concat()).unwrap();
    }
    scan.finalize().unwrap();
    writer.finalize().unwrap();
    drop(writer);
    file.into_inner()
}
