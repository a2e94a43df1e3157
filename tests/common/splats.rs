//! Small splat files, written after the formats' descriptions, byte by byte.
use flate2::{Compression, write::GzEncoder};
use image::{ImageFormat, RgbaImage};
use std::{
    fmt::Write as _,
    io::{Cursor, Write as _},
};
use zip::{ZipWriter, write::SimpleFileOptions};

/// Three numbers of a splat.
type Column = dyn Fn(&Stored) -> [f64; 3];

/// A splat in a file: plain numbers, the rotation as w x y z.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stored {
    pub(crate) center: [f64; 3],
    pub(crate) sigma: [f64; 3],
    pub(crate) rotation: [f64; 4],
    pub(crate) opacity: f64,
    pub(crate) color: [f64; 3],
}

/// Three splats with different axes; the largest parts of their rotations are w, y and z.
pub(crate) const SPLATS: [Stored; 3] = [
    Stored {
        center: [0.0, 0.0, 0.0],
        sigma: [0.1, 0.2, 0.3],
        rotation: [1.0, 0.0, 0.0, 0.0],
        opacity: 0.5,
        color: [0.5, 0.25, 0.75],
    },
    Stored {
        center: [1.0, -0.5, 0.25],
        sigma: [0.01, 0.4, 0.05],
        rotation: [0.5, 0.1, -0.8, 0.316_227_766],
        opacity: 0.9,
        color: [0.9, 0.1, 0.3],
    },
    Stored {
        center: [-1.0, 2.0, -3.0],
        sigma: [0.05, 0.05, 0.02],
        rotation: [-0.3, 0.4, 0.1, 0.860_232_527],
        opacity: 0.02,
        color: [0.4, 0.6, 0.5],
    },
];

/// `1 / (2 sqrt(pi))`.
const HARMONIC: f64 = 0.282_094_791_773_878_14;

fn logit(share: f64) -> f64 {
    (share / (1.0 - share)).ln()
}

fn bytes(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect()
}

fn byte(share: f64) -> u8 {
    (share * 255.0).round().clamp(0.0, 255.0) as u8
}

/// PLY of 3D Gaussian splatting, with `rest` coefficients of higher harmonics.
pub(crate) fn ply(format: &str, splats: &[Stored], rest: usize) -> Vec<u8> {
    let mut text = format!("ply\nformat {format} 1.0\nelement vertex {}\n", splats.len());
    let mut names: Vec<String> = ["x", "y", "z", "nx", "ny", "nz"].map(str::to_owned).to_vec();
    names.extend((0..3).map(|i| format!("f_dc_{i}")));
    names.extend((0..rest).map(|i| format!("f_rest_{i}")));
    names.push("opacity".to_owned());
    names.extend((0..3).map(|i| format!("scale_{i}")));
    names.extend((0..4).map(|i| format!("rot_{i}")));
    for name in names {
        let _ = writeln!(text, "property float {name}");
    }
    text += "end_header\n";
    let row = |splat: &Stored| {
        let mut row = splat.center.to_vec();
        row.extend([0.0; 3]);
        row.extend(splat.color.map(|c| (c - 0.5) / HARMONIC));
        row.extend(vec![0.125; rest]);
        row.push(logit(splat.opacity));
        row.extend(splat.sigma.map(f64::ln));
        // Trainers do not normalise.
        row.extend(splat.rotation.map(|part| part * 3.0));
        row
    };
    if format == "ascii" {
        for splat in splats {
            let words: Vec<String> = row(splat).iter().map(f64::to_string).collect();
            text += &(words.join(" ") + "\n");
        }
        return text.into_bytes();
    }
    let mut file = text.into_bytes();
    splats.iter().for_each(|splat| file.extend(bytes(&row(splat))));
    file
}

/// The three parts of a rotation without its largest, which is made positive; and the largest's index.
/// `parts`: in any order.
fn smallest_three(parts: [f64; 4]) -> ([f64; 3], usize) {
    let largest = (0..4).max_by(|&a, &b| parts[a].abs().total_cmp(&parts[b].abs())).unwrap();
    let sign = parts[largest].signum();
    let rest: Vec<f64> = (0..4).filter(|&i| i != largest).map(|i| parts[i] * sign).collect();
    (rest.try_into().unwrap(), largest)
}

/// Compressed PLY of `PlayCanvas`: one chunk.
pub(crate) fn packed_ply(splats: &[Stored]) -> Vec<u8> {
    let mut text = "ply\nformat binary_little_endian 1.0\nelement chunk 1\n".to_owned();
    for name in ["", "scale_"] {
        for end in ["min", "max"] {
            for axis in ["x", "y", "z"] {
                let _ = writeln!(text, "property float {end}_{name}{axis}");
            }
        }
    }
    for name in ["min_r", "min_g", "min_b", "max_r", "max_g", "max_b"] {
        let _ = writeln!(text, "property float {name}");
    }
    let _ = writeln!(text, "element vertex {}", splats.len());
    for name in ["position", "rotation", "scale", "color"] {
        let _ = writeln!(text, "property uint packed_{name}");
    }
    let mut file = (text + "end_header\n").into_bytes();
    let bounds = |of: &Column| {
        let end = |pick: fn(f64, f64) -> f64, start: f64| {
            [0, 1, 2].map(|k| splats.iter().map(|s| of(s)[k]).fold(start, pick))
        };
        [end(f64::min, f64::INFINITY), end(f64::max, f64::NEG_INFINITY)]
    };
    let columns: [&Column; 3] = [&|s| s.center, &|s| s.sigma.map(f64::ln), &|s| s.color];
    let all = columns.map(bounds);
    all.iter().for_each(|ends| file.extend(bytes(ends.as_flattened())));
    let share = |value: f64, [least, most]: [f64; 2], bits: u32| {
        let largest = f64::from((1_u32 << bits) - 1);
        ((value - least) / (most - least) * largest).round() as u32
    };
    for splat in splats {
        let [center, scale, color] = [0, 1, 2].map(|i| {
            let value = columns[i](splat);
            let bits = if i == 2 { [8; 3] } else { [11, 10, 11] };
            [0, 1, 2].map(|k| share(value[k], [all[i][0][k], all[i][1][k]], bits[k]))
        });
        let (parts, largest) = smallest_three(splat.rotation);
        let root = 0.5f64.sqrt();
        let turned = parts.map(|part| share(part, [-root, root], 10));
        let words = [
            center[0] << 21 | center[1] << 11 | center[2],
            (largest as u32) << 30 | turned[0] << 20 | turned[1] << 10 | turned[2],
            scale[0] << 21 | scale[1] << 11 | scale[2],
            color[0] << 24 | color[1] << 16 | color[2] << 8 | u32::from(byte(splat.opacity)),
        ];
        file.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    }
    file
}

/// Records of 32 bytes.
pub(crate) fn bare(splats: &[Stored]) -> Vec<u8> {
    let mut file = Vec::new();
    for splat in splats {
        file.extend(bytes(&splat.center));
        file.extend(bytes(&splat.sigma));
        file.extend(splat.color.map(byte));
        file.push(byte(splat.opacity));
        file.extend(splat.rotation.map(|part| (part * 128.0 + 128.0).round().min(255.0) as u8));
    }
    file
}

/// Header and attributes of an SPZ file without compression: positions, alphas, colours, scales, rotations,
/// harmonics of degree 1.
pub(crate) fn spz_parts(version: u32, splats: &[Stored]) -> (Vec<u8>, [Vec<u8>; 6]) {
    let mut header = b"NGSP".to_vec();
    header.extend(version.to_le_bytes());
    header.extend((splats.len() as u32).to_le_bytes());
    header.extend([1, 12, 0, 0]);
    let mut parts = <[Vec<u8>; 6]>::default();
    for splat in splats {
        for part in splat.center {
            if version == 1 {
                parts[0].extend(half::f16::from_f64(part).to_le_bytes());
            } else {
                parts[0].extend(&((part * 4096.0).round() as i32).to_le_bytes()[..3]);
            }
        }
        parts[1].push(byte(splat.opacity));
        parts[2].extend(splat.color.map(|c| byte((c - 0.5) / HARMONIC * 0.15 + 0.5)));
        parts[3].extend(splat.sigma.map(|s| ((s.ln() + 10.0) * 16.0).round() as u8));
        let [w, x, y, z] = splat.rotation;
        if version < 3 {
            let sign = w.signum();
            parts[4].extend([x, y, z].map(|part| (part * sign * 127.5 + 127.5).round() as u8));
        } else {
            let (rest, largest) = smallest_three([x, y, z, w]);
            let word = rest.iter().fold(largest as u32, |word, part| {
                let size = (part.abs() * 2f64.sqrt() * 511.0).round() as u32;
                word << 10 | u32::from(*part < 0.0) << 9 | size
            });
            parts[4].extend(word.to_le_bytes());
        }
        parts[5].extend([128; 9]);
    }
    (header, parts)
}

/// SPZ of a version from 1 to 4.
pub(crate) fn spz(version: u32, splats: &[Stored]) -> Vec<u8> {
    let (header, parts) = spz_parts(version, splats);
    if version < 4 {
        let mut file = GzEncoder::new(Vec::new(), Compression::fast());
        file.write_all(&header).unwrap();
        parts.iter().for_each(|part| file.write_all(part).unwrap());
        return file.finish().unwrap();
    }
    let packed = parts.clone().map(|part| {
        let level = ruzstd::encoding::CompressionLevel::Fastest;
        ruzstd::encoding::compress_to_vec(&part[..], level)
    });
    let mut file = header;
    file[15] = 6;
    // An extension may follow the header.
    file.extend(40_u32.to_le_bytes());
    file.extend([0; 20]);
    for (packed, plain) in packed.iter().zip(&parts) {
        file.extend((packed.len() as u64).to_le_bytes());
        file.extend((plain.len() as u64).to_le_bytes());
    }
    packed.iter().for_each(|part| file.extend(part));
    file
}

/// SOG in a zip.
pub(crate) fn sog(splats: &[Stored]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    // Not compressed, so that tests find the bytes that they change.
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, bytes) in sog_files(splats) {
        archive.start_file(name, options).unwrap();
        archive.write_all(&bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// Names and bytes of a SOG's files, with codebooks that hold each number of `splats`, at most 28;
/// `meta.json` is the first.
pub(crate) fn sog_files(splats: &[Stored]) -> Vec<(&'static str, Vec<u8>)> {
    let mut books = [vec![0.0; 256], vec![0.0; 256]];
    let mut images = <[Vec<u8>; 5]>::default();
    let stored = |x: f64| (x.abs() + 1.0).ln().copysign(x);
    for (i, splat) in splats.iter().enumerate() {
        let words = splat.center.map(|x| ((stored(x) + 2.0) / 4.0 * 65535.0).round() as u16);
        for (image, k) in [(0, 0), (1, 1)] {
            images[image].extend(words.map(|word| word.to_le_bytes()[k]));
            images[image].push(255);
        }
        for k in 0..3 {
            books[0][3 * i + k] = splat.sigma[k].ln();
            books[1][3 * i + k] = (splat.color[k] - 0.5) / HARMONIC;
        }
        let indices = [0, 1, 2].map(|k| (3 * i + k) as u8);
        let (rest, largest) = smallest_three(splat.rotation);
        images[2].extend(indices);
        images[2].push(255);
        images[3].extend(rest.map(|part| byte(part / 2f64.sqrt() + 0.5)));
        images[3].push(252 + largest as u8);
        images[4].extend(indices);
        images[4].push(byte(splat.opacity));
    }
    let files = ["l.webp", "u.webp", "s.webp", "q.webp", "c.webp"];
    let [scales, colors] = &books;
    let meta = format!(
        "{{\"version\": 2, \"count\": {}, \
          \"means\": {{\"mins\": [-2, -2, -2], \"maxs\": [2, 2, 2], \"files\": [\"l.webp\", \"u.webp\"]}}, \
          \"scales\": {{\"codebook\": {scales:?}, \"files\": [\"s.webp\"]}}, \
          \"quats\": {{\"files\": [\"q.webp\"]}}, \
          \"sh0\": {{\"codebook\": {colors:?}, \"files\": [\"c.webp\"]}}, \
          \"shN\": {{\"bands\": 2}}}}",
        splats.len()
    );
    let mut all = vec![("meta.json", meta.into_bytes())];
    for (name, mut texels) in files.into_iter().zip(images) {
        // A last texel that belongs to no splat.
        texels.extend([9; 4]);
        let image = RgbaImage::from_raw(splats.len() as u32 + 1, 1, texels).unwrap();
        let mut file = Cursor::new(Vec::new());
        image.write_to(&mut file, ImageFormat::WebP).unwrap();
        all.push((name, file.into_inner()));
    }
    all
}

/// `.ksplat` 0.1 at a compression level, with harmonics of degree 1: a section with full buckets of one splat
/// and a last bucket of all others, and a section without splats.
pub(crate) fn ksplat(level: u16, splats: &[Stored]) -> Vec<u8> {
    const EDGE: f64 = 16.0;
    let half = |x: f64| half::f16::from_f64(x).to_le_bytes();
    let full = 1;
    let partial = [(splats.len() - full) as u32];
    let centers = [[0.5, 0.0, -1.0], [-2.0, 1.0, 2.0]];
    let (plain, number) = [(44, 4), (24, 2), (24, 1)][usize::from(level)];
    let size = plain + 9 * number;
    let mut file = vec![0; 4096 + 2 * 1024];
    let mut put = |at: usize, bytes: &[u8]| file[at..at + bytes.len()].copy_from_slice(bytes);
    let count = splats.len() as u32;
    put(0, &[0, 1]);
    // Sections, splats, and space for both; the level.
    for (i, word) in [2, 2, count, count].into_iter().enumerate() {
        put(4 + 4 * i, &u32::to_le_bytes(word));
    }
    put(20, &level.to_le_bytes());
    let buckets = if level == 0 { 0 } else { centers.len() as u32 };
    let (full, partial) = if level == 0 { (0, &[][..]) } else { (full as u32, &partial[..]) };
    // There is space for two more splats.
    for (i, word) in [count, count + 2, 1, buckets].into_iter().enumerate() {
        put(4096 + 4 * i, &u32::to_le_bytes(word));
    }
    put(4096 + 16, &(EDGE as f32).to_le_bytes());
    put(4096 + 20, &12_u16.to_le_bytes());
    put(4096 + 24, &32767_u32.to_le_bytes());
    put(4096 + 32, &full.to_le_bytes());
    put(4096 + 36, &(partial.len() as u32).to_le_bytes());
    put(4096 + 40, &1_u16.to_le_bytes());
    partial.iter().for_each(|length| file.extend(length.to_le_bytes()));
    if level > 0 {
        file.extend(bytes(centers.as_flattened()));
    }
    for (i, splat) in splats.iter().enumerate() {
        if level == 0 {
            file.extend(bytes(&splat.center));
            file.extend(bytes(&splat.sigma));
            file.extend(bytes(&splat.rotation));
        } else {
            let center = centers[i.min(1)];
            let step = EDGE / 2.0 / 32767.0;
            let word = |k: usize| ((splat.center[k] - center[k]) / step + 32767.0).round() as u16;
            file.extend([0, 1, 2].map(word).iter().flat_map(|word| word.to_le_bytes()));
            file.extend(splat.sigma.into_iter().flat_map(half));
            file.extend(splat.rotation.into_iter().flat_map(half));
        }
        file.extend(splat.color.map(byte));
        file.push(byte(splat.opacity));
        file.extend(vec![7; 9 * number]);
    }
    file.extend(vec![0; 2 * size]);
    file
}

/// glTF with splats in an SPZ file in a view (`KHR_gaussian_splatting_compression_spz_2`). Moved by (0, 1,
/// 0).
pub(crate) fn gltf_spz(splats: &[Stored]) -> String {
    use base64::{Engine as _, engine::general_purpose::STANDARD};
    let own = "KHR_gaussian_splatting";
    let packed = format!("{own}_compression_spz_2");
    let data = spz(2, splats);
    let (length, count) = (data.len(), splats.len());
    format!(
        "{{\"asset\": {{\"version\": \"2.0\"}}, \"extensionsUsed\": [\"{own}\", \"{packed}\"], \
          \"extensionsRequired\": [\"{own}\", \"{packed}\"], \
          \"scene\": 0, \"scenes\": [{{\"nodes\": [0]}}], \
          \"nodes\": [{{\"mesh\": 0, \"translation\": [0, 1, 0]}}], \
          \"meshes\": [{{\"primitives\": [{{\"mode\": 0, \"attributes\": {{\"POSITION\": 0, \
          \"COLOR_0\": 1}}, \
            \"extensions\": {{\"{own}\": {{\"extensions\": {{\"{packed}\": {{\"bufferView\": \
            0}}}}}}}}}}]}}], \
          \"accessors\": [{{\"componentType\": 5126, \"count\": {count}, \"type\": \"VEC3\", \
            \"min\": [-1, -1, -3], \"max\": [1, 2, 1]}}, \
            {{\"componentType\": 5121, \"normalized\": true, \"count\": {count}, \"type\": \"VEC4\"}}], \
          \"bufferViews\": [{{\"buffer\": 0, \"byteOffset\": 0, \"byteLength\": {length}}}], \
          \"buffers\": [{{\"byteLength\": {length}, \"uri\": \
          \"data:application/octet-stream;base64,{}\"}}]}}",
        STANDARD.encode(&data)
    )
}

/// glTF with `KHR_gaussian_splatting`: plain scales, or logarithms as in drafts. Moved by (0, 1, 0).
pub(crate) fn gltf(splats: &[Stored], logarithms: bool) -> String {
    use base64::{Engine as _, engine::general_purpose::STANDARD};
    let columns: [(&str, Vec<f64>); 5] = [
        ("VEC3", splats.iter().flat_map(|s| s.center).collect()),
        ("VEC4", splats.iter().flat_map(|s| [1, 2, 3, 0].map(|i| s.rotation[i])).collect()),
        (
            "VEC3",
            splats
                .iter()
                .flat_map(|s| if logarithms { s.sigma.map(f64::ln) } else { s.sigma })
                .collect(),
        ),
        ("SCALAR", splats.iter().map(|s| s.opacity).collect()),
        ("VEC3", splats.iter().flat_map(|s| s.color.map(|c| (c - 0.5) / HARMONIC)).collect()),
    ];
    let (mut data, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    for (i, (kind, values)) in columns.iter().enumerate() {
        let (start, length) = (data.len(), values.len() * 4);
        data.extend(bytes(values));
        views.push(format!("{{\"buffer\": 0, \"byteOffset\": {start}, \"byteLength\": {length}}}"));
        let count = splats.len();
        accessors.push(format!(
            "{{\"bufferView\": {i}, \"componentType\": 5126, \"count\": {count}, \"type\": \"{kind}\"}}"
        ));
    }
    let own = "KHR_gaussian_splatting";
    format!(
        "{{\"asset\": {{\"version\": \"2.0\"}}, \"extensionsUsed\": [\"{own}\"], \
          \"scene\": 0, \"scenes\": [{{\"nodes\": [0]}}], \
          \"nodes\": [{{\"mesh\": 0, \"translation\": [0, 1, 0]}}], \
          \"meshes\": [{{\"primitives\": [{{\"mode\": 0, \"attributes\": {{\"POSITION\": 0, \
            \"{own}:ROTATION\": 1, \"{own}:SCALE\": 2, \"{own}:OPACITY\": 3, \
            \"{own}:SH_DEGREE_0_COEF_0\": 4, \"{own}:SH_DEGREE_1_COEF_0\": 4}}, \
            \"extensions\": {{\"{own}\": {{\"kernel\": \"ellipse\"}}}}}}]}}], \
          \"bufferViews\": [{}], \"accessors\": [{}], \
          \"buffers\": [{{\"byteLength\": {}, \"uri\": \"data:application/octet-stream;base64,{}\"}}]}}",
        views.join(", "),
        accessors.join(", "),
        data.len(),
        STANDARD.encode(&data)
    )
}
