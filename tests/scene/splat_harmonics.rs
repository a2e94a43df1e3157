//! Higher spherical harmonics of splats: what each format stores is read, and what is written is read again.
use crate::common::{
    files::Folder,
    splats::{SPLATS, Stored, gltf, gltf_spz, ksplat, ply, sog_files, spz_parts},
};
use flate2::{Compression, write::GzEncoder};
use gobo::glam::Vec3;
use gobo_scene::{
    LoadOptions, load_harmonics, load_splats, load_with_splats,
    splats::{self, Harmonics, SplatCloud},
};
use image::{ImageFormat, RgbaImage};
use std::{
    fs,
    io::{Cursor, Write as _},
    path::Path,
};

fn harmonics(folder: &Folder, name: &str, bytes: &[u8]) -> Option<Harmonics> {
    let path = folder.0.join(name);
    fs::write(&path, bytes).unwrap();
    load_harmonics(&path).unwrap()
}

/// Coefficient `k` of a channel of splat `i`, a multiple of 1/128 below 1: SPZ holds it exactly.
fn stored(i: usize, k: usize, channel: usize) -> f32 {
    ((i * 37 + k * 11 + channel * 5) % 256) as f32 / 128.0 - 1.0
}

fn expected(count: usize, splats: usize) -> Harmonics {
    let of = |n: usize| [0, 1, 2].map(|channel| stored(n / count, n % count, channel));
    Harmonics { count, coefficients: (0..splats * count).map(of).collect() }
}

#[test]
fn columns_of_ply_are_channel_by_channel() {
    let folder = Folder::new();
    for count in [3, 8, 15] {
        let text = String::from_utf8(ply("ascii", &SPLATS, 3 * count)).unwrap();
        let (header, rows) = text.split_once("end_header\n").unwrap();
        let mut text = format!("{header}end_header\n");
        for (i, row) in rows.lines().enumerate() {
            let mut words: Vec<String> = row.split(' ').map(str::to_owned).collect();
            for column in 0..3 * count {
                // Behind the centre, the normal and the base colour.
                words[9 + column] = stored(i, column % count, column / count).to_string();
            }
            text += &(words.join(" ") + "\n");
        }
        let found = harmonics(&folder, "in.ply", text.as_bytes()).unwrap();
        assert_eq!(found, expected(count, SPLATS.len()));
        // A column more is of no degree.
        let more = text
            .replace("property float opacity", "property float f_rest_99\nproperty float opacity");
        fs::write(folder.0.join("more.ply"), more).unwrap();
        let error = load_harmonics(&folder.0.join("more.ply")).unwrap_err().to_string();
        assert!(error.contains("f_rest_*"), "{error}");
    }
}

#[test]
fn bytes_of_spz_are_coefficient_by_coefficient() {
    let folder = Folder::new();
    let (header, mut parts) = spz_parts(3, &SPLATS);
    let bytes = |i: usize| (0..9).map(move |n| (stored(i, n / 3, n % 3) * 128.0 + 128.0) as u8);
    parts[5] = (0..SPLATS.len()).flat_map(bytes).collect();
    let mut file = GzEncoder::new(Vec::new(), Compression::fast());
    file.write_all(&header).unwrap();
    parts.iter().for_each(|part| file.write_all(part).unwrap());
    let found = harmonics(&folder, "in.spz", &file.finish().unwrap()).unwrap();
    assert_eq!(found, expected(3, SPLATS.len()));
}

/// Labels of the splats of [`write_sog`].
const LABELS: [u16; 3] = [65, 3, 64];

/// Writes a SOG with harmonics of degree 1. Two rows of a palette of 70 entries: entry 65 is the second of
/// the second row.
fn write_sog(folder: &Path) {
    let book: Vec<f32> = (0..256).map(|i| i as f32 / 128.0 - 1.0).collect();
    let entries = 70;
    let mut palette = RgbaImage::new(64 * 3, 2);
    for (entry, k) in (0..entries).flat_map(|entry| (0..3).map(move |k| (entry, k))) {
        let byte =
            |channel: usize| ((entry as usize * 37 + k as usize * 11 + channel * 5) % 256) as u8;
        palette.put_pixel(
            entry % 64 * 3 + k,
            entry / 64,
            image::Rgba([byte(0), byte(1), byte(2), 255]),
        );
    }
    let texels =
        LABELS.iter().flat_map(|label| [label.to_le_bytes()[0], label.to_le_bytes()[1], 0, 255]);
    let labelled = RgbaImage::from_raw(3, 1, texels.collect()).unwrap();
    let named = [("p.webp", palette), ("n.webp", labelled)];
    for (name, bytes) in sog_files(&SPLATS) {
        let text = String::from_utf8_lossy(&bytes).replace(
            "{\"bands\": 2}",
            &format!(
                "{{\"bands\": 1, \"count\": {entries}, \"codebook\": {book:?}, \
                  \"files\": [\"p.webp\", \"n.webp\"]}}"
            ),
        );
        let is_meta = name == "meta.json";
        fs::write(folder.join(name), if is_meta { text.as_bytes() } else { &bytes }).unwrap();
    }
    for (name, image) in &named {
        let mut file = Cursor::new(Vec::new());
        image.write_to(&mut file, ImageFormat::WebP).unwrap();
        fs::write(folder.join(name), file.into_inner()).unwrap();
    }
}

#[test]
fn labels_of_sog_find_their_entries() {
    let folder = Folder::new();
    write_sog(&folder.0);
    let found = load_harmonics(&folder.0.join("meta.json")).unwrap().unwrap();
    let of = |n: usize| [0, 1, 2].map(|channel| stored(LABELS[n / 3].into(), n % 3, channel));
    assert_eq!(found, Harmonics { count: 3, coefficients: (0..9).map(of).collect() });
    // A label past the palette.
    let meta = fs::read_to_string(folder.0.join("meta.json")).unwrap();
    fs::write(folder.0.join("meta.json"), meta.replace("\"count\": 70", "\"count\": 65")).unwrap();
    let error = load_harmonics(&folder.0.join("meta.json")).unwrap_err().to_string();
    assert!(error.contains("entry 65 of 65"), "{error}");
}

/// Level 0: splats 1 and 2 of a file with harmonics, then one without; level 1: one splat.
const LEVELS: &str = r#"{"version": 1, "lodLevels": 2, "filenames": ["a/meta.json", "b/meta.json"],
"tree": {"children": [
{"lods": {"0": {"file": 1, "offset": 0, "count": 1}, "1": {"file": 0, "offset": 0, "count": 1}}},
{"lods": {"0": {"file": 0, "offset": 1, "count": 2}}}]}}"#;

#[test]
fn runs_of_a_streamed_sog_have_their_own_rows() {
    let folder = Folder::new();
    let [with, without] = ["a", "b"].map(|name| folder.0.join(name));
    [&with, &without].into_iter().for_each(|folder| fs::create_dir(folder).unwrap());
    write_sog(&with);
    for (name, bytes) in sog_files(&SPLATS[..1]) {
        let text = String::from_utf8_lossy(&bytes).replace(", \"shN\": {\"bands\": 2}", "");
        let is_meta = name == "meta.json";
        fs::write(without.join(name), if is_meta { text.as_bytes() } else { &bytes }).unwrap();
    }
    let path = folder.write("lod-meta.json", LEVELS);
    let row = |splat: usize| {
        (0..3).map(move |k| [0, 1, 2].map(|channel| stored(LABELS[splat].into(), k, channel)))
    };
    let rows = row(1).chain(row(2)).chain([[0.0; 3]; 3]).collect();
    let found = load_harmonics(&path).unwrap().unwrap();
    assert_eq!(found, Harmonics { count: 3, coefficients: rows });
    assert_eq!(load_splats(&path).unwrap().splats.len(), 3);
    // At the level that a scene names.
    let scene = folder.write("s.toml", "[[splats]]\nfile = 'lod-meta.json'\nlod = 1\n");
    let relit = load_with_splats(&scene, &LoadOptions::default(), &path).unwrap();
    assert_eq!((relit.cloud.splats.len(), relit.range.len()), (1, 1));
    let found = relit.harmonics(&path).unwrap().unwrap();
    assert_eq!(found, Harmonics { count: 3, coefficients: row(0).collect() });
    // Splats that a file does not have.
    fs::write(&path, LEVELS.replace("\"count\": 2", "\"count\": 3")).unwrap();
    let error = load_harmonics(&path).unwrap_err().to_string();
    assert!(error.contains("has 3 splats, and the tree names 4"), "{error}");
}

/// Records of `size` bytes, with their harmonics from `plain` on, channel by channel.
fn with_numbers(
    mut file: Vec<u8>,
    [plain, size]: [usize; 2],
    number: impl Fn(usize, usize) -> Vec<u8>,
) -> Vec<u8> {
    // Space for two more splats is behind them.
    let start = file.len() - (SPLATS.len() + 2) * size;
    for i in 0..SPLATS.len() {
        let numbers: Vec<u8> = (0..9).flat_map(|n| number(i, n)).collect();
        let at = start + i * size + plain;
        file[at..at + numbers.len()].copy_from_slice(&numbers);
    }
    file
}

#[test]
fn bands_of_ksplat_are_channel_by_channel() {
    let folder = Folder::new();
    let value = |i: usize, n: usize| stored(i, n % 3, n / 3);
    let plain =
        with_numbers(ksplat(0, &SPLATS), [44, 80], |i, n| value(i, n).to_le_bytes().to_vec());
    assert_eq!(harmonics(&folder, "0.ksplat", &plain).unwrap(), expected(3, SPLATS.len()));
    let half = |i: usize, n: usize| half::f16::from_f32(value(i, n)).to_le_bytes().to_vec();
    let halves = with_numbers(ksplat(1, &SPLATS), [24, 42], half);
    assert_eq!(harmonics(&folder, "1.ksplat", &halves).unwrap(), expected(3, SPLATS.len()));
    // Bytes of -1.5 to 1.5, or of the range that the header states.
    for range in [1.5_f32, 2.0] {
        let byte = |i: usize, n: usize| vec![((value(i, n) / range + 1.0) * 127.5).round() as u8];
        let mut bytes = with_numbers(ksplat(2, &SPLATS), [24, 33], byte);
        if range != 1.5 {
            bytes[36..40].copy_from_slice(&(-range).to_le_bytes());
            bytes[40..44].copy_from_slice(&range.to_le_bytes());
        }
        let found = harmonics(&folder, "2.ksplat", &bytes).unwrap();
        let off = largest(&found, &expected(3, SPLATS.len()));
        assert!(off <= 1.001 * range / 255.0, "{range}: {off}");
    }
    // Degree 2: the second band follows the first whole.
    let mut file = ksplat(0, &SPLATS[..1]);
    let record: Vec<u8> = file[6144..6144 + 44].to_vec();
    file.truncate(6144);
    file[4096 + 40] = 2;
    file.extend(record);
    for band in [0..3, 3..8] {
        for channel in 0..3 {
            file.extend(band.clone().flat_map(|k| stored(0, k, channel).to_le_bytes()));
        }
    }
    file.extend(vec![0; 2 * 140]);
    assert_eq!(harmonics(&folder, "3.ksplat", &file).unwrap(), expected(8, 1));
}

/// Attributes of a degree are its coefficients; those of turned splats would be others.
#[test]
fn harmonics_of_gltf_are_kept_where_nodes_do_not_turn_them() {
    let folder = Folder::new();
    let own = "\"KHR_gaussian_splatting:SH_DEGREE_1_COEF_";
    // Accessors of colours, centres and deviations take the place of coefficients.
    let all = format!("{own}0\": 4, {own}1\": 0, {own}2\": 2");
    let whole = gltf(&SPLATS, false).replace(&format!("{own}0\": 4"), &all);
    let of = |splat: usize| {
        let Stored { color, center, sigma, .. } = SPLATS[splat];
        let vectors = [color.map(|part| (part - 0.5) / 0.282_094_791_8), center, sigma];
        vectors.map(|parts| Vec3::from_array(parts.map(|part| part as f32)))
    };
    let found = harmonics(&folder, "in.gltf", whole.as_bytes()).unwrap();
    assert_eq!((found.count, found.coefficients.len()), (3, 3 * SPLATS.len()));
    for (i, k) in (0..SPLATS.len()).flat_map(|i| (0..3).map(move |k| (i, k))) {
        let off = (Vec3::from_array(found.of(i)[k]) - of(i)[k]).abs().max_element();
        assert!(off < 1e-4, "splat {i}, coefficient {k}: {off}");
    }
    for (node, is_kept) in [
        ("\"scale\": [2, 3, 1]", true),
        ("\"rotation\": [0, 0.6, 0, 0.8]", false),
        ("\"scale\": [-1, 1, 1]", false),
    ] {
        let text = whole.replace("\"translation\": [0, 1, 0]", node);
        assert_eq!(harmonics(&folder, "in.gltf", text.as_bytes()).is_some(), is_kept, "{node}");
    }
    let packed = harmonics(&folder, "in.gltf", gltf_spz(&SPLATS).as_bytes()).unwrap();
    let zeros = vec![[0.0; 3]; 3 * SPLATS.len()];
    assert_eq!(packed, Harmonics { count: 3, coefficients: zeros });
}

/// `copies` of the splats, a metre apart.
fn cloud(folder: &Folder, copies: usize) -> SplatCloud {
    let path = folder.0.join("cloud.ply");
    fs::write(&path, ply("binary_little_endian", &SPLATS, 0)).unwrap();
    let mut cloud = load_splats(&path).unwrap();
    let few = cloud.splats.clone();
    let moved = |i: usize| few.iter().map(move |splat| (i, *splat));
    cloud.splats = (0..copies)
        .flat_map(moved)
        .map(|(i, mut splat)| {
            splat.center.x += i as f32;
            splat
        })
        .collect();
    cloud
}

fn largest(found: &Harmonics, wanted: &Harmonics) -> f32 {
    assert_eq!((found.count, found.coefficients.len()), (wanted.count, wanted.coefficients.len()));
    let pairs = found.coefficients.as_flattened().iter().zip(wanted.coefficients.as_flattened());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn written_harmonics_are_read_again() {
    let folder = Folder::new();
    let cloud = cloud(&folder, 4);
    let colors: Vec<Vec3> = cloud.splats.iter().map(|splat| splat.color).collect();
    for count in [0, 3, 8, 15, 24] {
        let wanted = if count == 0 { Harmonics::default() } else { expected(count, colors.len()) };
        let ply = splats::to_ply(&cloud.splats, &colors, &wanted);
        assert_eq!(harmonics(&folder, "out.ply", &ply).unwrap(), wanted);
        let spz = splats::to_spz(&cloud.splats, &colors, &wanted).unwrap();
        assert_eq!(harmonics(&folder, "out.spz", &spz).unwrap(), wanted);
        // Fewer splats than entries, and 256 numbers: nothing is lost.
        let sog = splats::to_sog(&cloud.splats, &colors, &wanted).unwrap();
        assert_eq!(harmonics(&folder, "out.sog", &sog).unwrap(), wanted);
        assert_eq!(splats::to_sog(&cloud.splats, &colors, &wanted).unwrap(), sog, "same bytes");
    }
    let none = Harmonics::default();
    assert!(splats::to_sog(&[], &[], &none).is_err());
    let odd = Harmonics { count: 2, coefficients: vec![[0.0; 3]; 2 * colors.len()] };
    assert!(splats::to_sog(&cloud.splats, &colors, &odd).is_err());
    assert!(splats::to_spz(&cloud.splats, &colors, &odd).is_err());
    let bright = vec![Vec3::splat(f32::INFINITY); colors.len()];
    assert!(splats::to_sog(&cloud.splats, &bright, &none).is_err());
}

/// Centres have 16 bits of the logarithm of their extent, deviations, colours and harmonics 8 bits of a
/// codebook.
#[test]
fn written_sog_has_the_splats() {
    let folder = Folder::new();
    let cloud = cloud(&folder, 700);
    let all = cloud.splats.len();
    let colors: Vec<Vec3> = (0..all).map(|i| Vec3::splat(i as f32 / all as f32)).collect();
    // As many kinds of harmonics as splats, near each other in kind.
    let smooth = |n: usize| {
        let (i, k) = ((n / 3) as f32 / all as f32, (n % 3) as f32);
        [0.0, 1.0, 2.0].map(|channel| 0.4 * (6.0 * i + k + channel).sin())
    };
    let wanted = Harmonics { count: 3, coefficients: (0..3 * all).map(smooth).collect() };
    let path = folder.0.join("out.sog");
    fs::write(&path, splats::to_sog(&cloud.splats, &colors, &wanted).unwrap()).unwrap();
    let again = load_splats(&path).unwrap();
    assert_eq!(again.splats.len(), all);
    // ln(1 + x) up to 701 m, in 65,535 steps: half a step at 701 m.
    let far = 0.6 * (702.0_f32.ln() * 2.0 / 65535.0) * 702.0;
    for (i, (found, splat)) in again.splats.iter().zip(&cloud.splats).enumerate() {
        let off = (found.center - splat.center).abs().max_element();
        assert!(off < far, "splat {i}: {off} m");
        assert!((found.sigma / splat.sigma - 1.0).abs().max_element() < 1e-5, "splat {i}");
        assert!(found.rotation.dot(splat.rotation).abs() > 0.9999, "splat {i}");
        assert!((found.opacity - splat.opacity).abs() < 0.5 / 255.0 + 1e-6, "splat {i}");
        assert!((found.color - colors[i]).abs().max_element() < 0.6 / 256.0, "splat {i}");
    }
    let found = load_harmonics(&path).unwrap().unwrap();
    // 64 entries along a curve of length 2.4 pi a coefficient.
    let off = largest(&found, &wanted);
    assert!(off < 0.08, "{off}");
}
