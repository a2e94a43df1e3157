//! Writers of dense array files, after the formats' descriptions.
use base64::{Engine as _, engine::general_purpose::STANDARD};
use flate2::{
    Compression,
    write::{GzEncoder, ZlibEncoder},
};
use std::io::{Cursor, Write as _};

/// Voxels along x, y and z: past the edge of a brick.
pub(crate) const SIZE: [usize; 3] = [10, 4, 3];

/// Value of a voxel: 1 to 120, each once.
pub(crate) fn value([x, y, z]: [usize; 3]) -> f64 {
    (1 + x + 10 * y + 40 * z) as f64
}

/// Storage type of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
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

pub(crate) const KINDS: [Kind; 11] = [
    Kind::I8,
    Kind::U8,
    Kind::I16,
    Kind::U16,
    Kind::I32,
    Kind::U32,
    Kind::I64,
    Kind::U64,
    Kind::F16,
    Kind::F32,
    Kind::F64,
];

pub(crate) fn bytes_of(kind: Kind, is_big: bool, values: &[f64]) -> Vec<u8> {
    let bytes = |&value: &f64| {
        let mut bytes = match kind {
            Kind::I8 => (value as i8).to_le_bytes().to_vec(),
            Kind::U8 => vec![value as u8],
            Kind::I16 => (value as i16).to_le_bytes().to_vec(),
            Kind::U16 => (value as u16).to_le_bytes().to_vec(),
            Kind::I32 => (value as i32).to_le_bytes().to_vec(),
            Kind::U32 => (value as u32).to_le_bytes().to_vec(),
            Kind::I64 => (value as i64).to_le_bytes().to_vec(),
            Kind::U64 => (value as u64).to_le_bytes().to_vec(),
            Kind::F16 => half::f16::from_f64(value).to_le_bytes().to_vec(),
            Kind::F32 => (value as f32).to_le_bytes().to_vec(),
            Kind::F64 => value.to_le_bytes().to_vec(),
        };
        if is_big {
            bytes.reverse();
        }
        bytes
    };
    values.iter().flat_map(bytes).collect()
}

/// All values, x fastest.
pub(crate) fn values() -> Vec<f64> {
    let [width, height, _] = SIZE;
    let count = SIZE.iter().product();
    (0..count).map(|i| value([i % width, i / width % height, i / (width * height)])).collect()
}

/// All values, z fastest.
fn values_backwards() -> Vec<f64> {
    let [_, height, depth] = SIZE;
    let count = SIZE.iter().product();
    (0..count).map(|i| value([i / (depth * height), i / depth % height, i % depth])).collect()
}

pub(crate) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::default());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

pub(crate) fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

fn lz4(block: &[u8]) -> Vec<u8> {
    let mut packed = vec![0; lz4_flex::block::get_maximum_output_size(block.len())];
    let length = lz4_flex::block::compress_into(block, &mut packed).unwrap();
    packed.truncate(length);
    packed
}

/// An array with a shape in `NumPy`'s order.
pub(crate) fn npy_of(descr: &str, is_fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if is_fortran { "True" } else { "False" };
    let mut text =
        format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': ({shape}), }}");
    while (text.len() + 11) % 64 != 0 {
        text.push(' ');
    }
    text.push('\n');
    let mut bytes = b"\x93NUMPY\x01\0".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.into_bytes());
    bytes.extend(data);
    bytes
}

pub(crate) fn npy(kind: Kind, is_big: bool, is_fortran: bool) -> Vec<u8> {
    let name = match kind {
        Kind::I8 => "i1",
        Kind::U8 => "u1",
        Kind::I16 => "i2",
        Kind::U16 => "u2",
        Kind::I32 => "i4",
        Kind::U32 => "u4",
        Kind::I64 => "i8",
        Kind::U64 => "u8",
        Kind::F16 => "f2",
        Kind::F32 => "f4",
        Kind::F64 => "f8",
    };
    let order = if is_big { '>' } else { '<' };
    let [width, height, depth] = SIZE;
    let values = if is_fortran { values_backwards() } else { values() };
    let shape = format!("{depth}, {height}, {width}");
    npy_of(&format!("{order}{name}"), is_fortran, &shape, &bytes_of(kind, is_big, &values))
}

/// An archive of arrays by name.
pub(crate) fn npz(arrays: &[(&str, Vec<u8>)], is_packed: bool) -> Vec<u8> {
    let method =
        if is_packed { zip::CompressionMethod::Deflated } else { zip::CompressionMethod::Stored };
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in arrays {
        archive.start_file(format!("{name}.npy"), options).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// A header with `fields` besides the sizes; the data follow.
pub(crate) fn nrrd_of(kind: &str, fields: &str, data: &[u8]) -> Vec<u8> {
    let [width, height, depth] = SIZE;
    let head = format!(
        "NRRD0004\n# a comment\ntype: {kind}\ndimension: 3\nsizes: {width} {height} {depth}\n\
         {fields}key:=value\n\n"
    );
    [head.as_bytes(), data].concat()
}

pub(crate) fn nrrd(kind: Kind, is_big: bool, encoding: &str) -> Vec<u8> {
    let name = match kind {
        Kind::I8 => "int8",
        Kind::U8 => "unsigned char",
        Kind::I16 => "short",
        Kind::U16 => "uint16",
        Kind::I32 => "int",
        Kind::U32 => "unsigned int",
        Kind::I64 => "long long int",
        Kind::U64 => "uint64_t",
        Kind::F16 => "float16",
        Kind::F32 => "float",
        Kind::F64 => "double",
    };
    let plain = bytes_of(kind, is_big, &values());
    let data = match encoding {
        "gzip" => gzip(&plain),
        "ascii" => text(&values()),
        _ => plain,
    };
    let endian = if is_big { "big" } else { "little" };
    nrrd_of(name, &format!("encoding: {encoding}\nendian: {endian}\n"), &data)
}

fn text(values: &[f64]) -> Vec<u8> {
    let words: Vec<String> = values.iter().map(|value| format!("{value}")).collect();
    words.join(" \n").into_bytes()
}

/// Encoding of an array by VTK.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Vti {
    Ascii,
    Inline,
    Appended,
    Raw,
}

/// `extent` begins at 2, 0, 1; `packer`: `vtkZLibDataCompressor` or `vtkLZ4DataCompressor`, in blocks.
pub(crate) fn vti(kind: Kind, is_big: bool, way: Vti, packer: Option<&str>) -> Vec<u8> {
    const BLOCK: usize = 200;
    let plain = bytes_of(kind, is_big, &values());
    let length = |value: usize| {
        let bytes = (value as u64).to_le_bytes();
        if is_big { (value as u64).to_be_bytes() } else { bytes }
    };
    let blocks: Vec<Vec<u8>> = plain
        .chunks(BLOCK)
        .map(|block| match packer {
            Some("vtkLZ4DataCompressor") => lz4(block),
            _ => zlib(block),
        })
        .collect();
    let head: Vec<u8> = match packer {
        None => length(plain.len()).to_vec(),
        Some(_) => {
            let sizes = blocks.iter().map(Vec::len);
            let numbers = [blocks.len(), BLOCK, plain.len() % BLOCK].into_iter().chain(sizes);
            numbers.flat_map(length).collect()
        }
    };
    let body = if packer.is_some() { blocks.concat() } else { plain };
    let encoded = match packer {
        None => STANDARD.encode([head.clone(), body.clone()].concat()),
        Some(_) => STANDARD.encode(&head) + &STANDARD.encode(&body),
    };
    let [width, height, depth] = SIZE;
    let extent = format!("2 {} 0 {} 1 {}", width + 1, height - 1, depth);
    let order = if is_big { "BigEndian" } else { "LittleEndian" };
    let packer = packer.map_or(String::new(), |name| format!(" compressor=\"{name}\""));
    let name = match kind {
        Kind::I8 => "Int8",
        Kind::U8 => "UInt8",
        Kind::I16 => "Int16",
        Kind::U16 => "UInt16",
        Kind::I32 => "Int32",
        Kind::U32 => "UInt32",
        Kind::I64 => "Int64",
        Kind::U64 => "UInt64",
        Kind::F16 | Kind::F32 => "Float32",
        Kind::F64 => "Float64",
    };
    let (format, inline) = match way {
        Vti::Ascii => ("ascii", String::from_utf8(text(&values())).unwrap()),
        Vti::Inline => ("binary", encoded.clone()),
        Vti::Appended | Vti::Raw => ("appended\" offset=\"0", String::new()),
    };
    let mut bytes = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"{order}\" \
         header_type=\"UInt64\"{packer}>\n<ImageData WholeExtent=\"{extent}\" Origin=\"1 2 3\" \
         Spacing=\"0.5 2 4\" Direction=\"0 -1 0 1 0 0 0 0 1\">\n<Piece Extent=\"{extent}\">\n\
         <PointData Scalars=\"s\">\n<DataArray type=\"{name}\" Name=\"s\" format=\"{format}\">\n{inline}\n\
         </DataArray>\n</PointData>\n<CellData></CellData>\n</Piece>\n</ImageData>\n"
    )
    .into_bytes();
    match way {
        Vti::Appended => bytes.extend(
            format!("<AppendedData encoding=\"base64\">\n _{encoded}\n</AppendedData>")
                .into_bytes(),
        ),
        Vti::Raw => {
            bytes.extend(b"<AppendedData encoding=\"raw\">\n_");
            bytes.extend([head, body].concat());
            bytes.extend(b"\n</AppendedData>");
        }
        Vti::Ascii | Vti::Inline => {}
    }
    bytes.extend(b"\n</VTKFile>\n");
    bytes
}

/// A header and its data, in voxels of 0.5, 2 and 4 mm; values are stored as (value - 2) / 0.5.
pub(crate) fn nifti(kind: Kind, is_big: bool) -> Vec<u8> {
    let code: i16 = match kind {
        Kind::U8 => 2,
        Kind::I16 => 4,
        Kind::I32 => 8,
        Kind::F32 | Kind::F16 => 16,
        Kind::F64 => 64,
        Kind::I8 => 256,
        Kind::U16 => 512,
        Kind::U32 => 768,
        Kind::I64 => 1024,
        Kind::U64 => 1280,
    };
    let mut head = vec![0; 352];
    let mut put = |at: usize, bytes: Vec<u8>| head[at..at + bytes.len()].copy_from_slice(&bytes);
    let shorts = |values: &[f64]| bytes_of(Kind::I16, is_big, values);
    let floats = |values: &[f64]| bytes_of(Kind::F32, is_big, values);
    put(0, bytes_of(Kind::I32, is_big, &[348.0]));
    let [width, height, depth] = SIZE.map(|size| size as f64);
    put(40, shorts(&[3.0, width, height, depth, 1.0, 1.0, 1.0, 1.0]));
    put(70, shorts(&[f64::from(code)]));
    put(76, floats(&[1.0, 0.5, 2.0, 4.0]));
    put(108, floats(&[352.0, 0.5, 2.0]));
    put(123, vec![2]);
    // Turned by 90 degrees about z: x of the array goes along y.
    put(252, shorts(&[1.0, 0.0]));
    put(256, floats(&[0.0, 0.0, 0.5_f64.sqrt(), 10.0, 20.0, 30.0]));
    put(344, b"n+1\0".to_vec());
    let stored: Vec<f64> = values().iter().map(|value| (value - 2.0) / 0.5).collect();
    head.extend(bytes_of(kind, is_big, &stored));
    head
}

/// `data`: name of the data's file, or `LOCAL`.
pub(crate) fn meta_head(kind: &str, is_big: bool, is_packed: bool, data: &str) -> String {
    let [width, height, depth] = SIZE;
    let word = |is: bool| if is { "True" } else { "False" };
    format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = {}\nCompressedData = {}\n\
         TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 10 20 30\nElementSpacing = 0.5 2 4\n\
         DimSize = {width} {height} {depth}\nElementType = {kind}\nElementDataFile = {data}\n",
        word(is_big),
        word(is_packed),
    )
}

pub(crate) fn meta(kind: Kind, is_big: bool, is_packed: bool) -> Vec<u8> {
    let name = match kind {
        Kind::I8 => "MET_CHAR",
        Kind::U8 => "MET_UCHAR",
        Kind::I16 => "MET_SHORT",
        Kind::U16 => "MET_USHORT",
        Kind::I32 => "MET_INT",
        Kind::U32 => "MET_UINT",
        Kind::I64 => "MET_LONG_LONG",
        Kind::U64 => "MET_ULONG_LONG",
        Kind::F16 | Kind::F32 => "MET_FLOAT",
        Kind::F64 => "MET_DOUBLE",
    };
    let plain = bytes_of(kind, is_big, &values());
    let data = if is_packed { zlib(&plain) } else { plain };
    [meta_head(name, is_big, is_packed, "LOCAL").into_bytes(), data].concat()
}

/// A page per z, a strip each, plain or deflated; texels of 1/2 and 1/4 micrometre, pages 3 apart.
pub(crate) fn tiff(kind: Kind, is_big: bool, is_packed: bool) -> Vec<u8> {
    let (bits, format) = match kind {
        Kind::I8 => (8, 2),
        Kind::U8 => (8, 1),
        Kind::I16 => (16, 2),
        Kind::U16 => (16, 1),
        Kind::I32 => (32, 2),
        Kind::U32 => (32, 1),
        Kind::I64 => (64, 2),
        Kind::U64 => (64, 1),
        Kind::F16 => (16, 3),
        Kind::F32 => (32, 3),
        Kind::F64 => (64, 3),
    };
    let short = |value: u16| bytes_of(Kind::U16, is_big, &[f64::from(value)]);
    let long = |value: usize| bytes_of(Kind::U32, is_big, &[value as f64]);
    let [width, height, depth] = SIZE;
    let mut bytes = if is_big { b"MM".to_vec() } else { b"II".to_vec() };
    bytes.extend(short(42));
    let mut link = bytes.len();
    bytes.extend(long(0));
    let description = b"ImageJ=1.11a\nunit=micron\nspacing=3.0\n\0";
    let description_at = bytes.len();
    bytes.extend(description);
    let [across, down] = [(2, 1), (4, 1)].map(|(above, below)| {
        let at = bytes.len();
        bytes.extend([long(above), long(below)].concat());
        at
    });
    for page in values().chunks(width * height).take(depth) {
        let plain = bytes_of(kind, is_big, page);
        let strip = if is_packed { zlib(&plain) } else { plain };
        let strip_at = bytes.len();
        bytes.extend(&strip);
        if bytes.len() % 2 == 1 {
            bytes.push(0);
        }
        let start = long(bytes.len());
        bytes[link..link + 4].copy_from_slice(&start);
        // Tag, type, count, value.
        let packing = if is_packed { 8 } else { 1 };
        let entries = [
            (256, 4, 1, width),
            (257, 4, 1, height),
            (258, 3, 1, bits),
            (259, 3, 1, packing),
            (262, 3, 1, 1),
            (270, 2, description.len(), description_at),
            (273, 4, 1, strip_at),
            (277, 3, 1, 1),
            (278, 4, 1, height),
            (279, 4, 1, strip.len()),
            (282, 5, 1, across),
            (283, 5, 1, down),
            (339, 3, 1, format),
        ];
        bytes.extend(short(entries.len() as u16));
        for (tag, kind, count, value) in entries {
            bytes.extend([short(tag), short(kind), long(count)].concat());
            if kind == 3 {
                bytes.extend([short(value as u16), short(0)].concat());
            } else {
                bytes.extend(long(value));
            }
        }
        link = bytes.len();
        bytes.extend(long(0));
    }
    bytes
}
