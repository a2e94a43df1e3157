//! Splat files: stored values are read, and truncated or wrong files are refused.
use crate::common::{
    files::Folder,
    splats::{SPLATS, Stored, bare, gltf, gltf_spz, ksplat, packed_ply, ply, sog, spz, spz_parts},
};
use flate2::{Compression, write::GzEncoder};
use gobo::{
    glam::{DMat3, DQuat, DVec3},
    model::Gaussian,
};
use gobo_scene::{
    SceneError, load_harmonics, load_splats,
    splats::{self, Harmonics, SplatCloud},
};
use std::io::Write as _;

fn load(bytes: impl AsRef<[u8]>) -> Result<SplatCloud, SceneError> {
    // The name is meaningless.
    let folder = Folder::new();
    let path = folder.write("some.file", bytes);
    // Read for `relight` alone: refused or not, never a panic.
    let _ = load_harmonics(&path);
    load_splats(&path)
}

fn refusal(bytes: impl AsRef<[u8]>) -> String {
    match load(bytes) {
        Err(SceneError::Invalid { path, message, help }) => {
            assert!(path.ends_with("some.file"));
            format!("{message}; {}", help.expect("a remedy"))
        }
        Err(other) => panic!("{other}"),
        Ok(cloud) => panic!("{} splats read without an error", cloud.splats.len()),
    }
}

/// Largest rounding errors of a format.
#[derive(Clone, Copy)]
struct Rounding {
    /// Error of a centre [m].
    center: f64,
    /// Relative error of a deviation.
    sigma: f64,
    /// Error of a part of the rotation matrix.
    rotation: f64,
    /// Error of opacities and colours.
    share: f64,
}

const EXACT: Rounding = Rounding { center: 1e-6, sigma: 1e-6, rotation: 1e-6, share: 1e-6 };
/// Half a step of 8 bits.
const BYTE: f64 = 0.5 / 255.0 + 1e-6;

fn matrix([w, x, y, z]: [f64; 4]) -> DMat3 {
    DMat3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize())
}

fn assert_near(read: &[Gaussian], stored: &[Stored], rounding: Rounding, what: &str) {
    assert_eq!(read.len(), stored.len(), "{what}");
    let near = |a: f64, b: f64, most: f64, part: &str| {
        assert!((a - b).abs() <= most, "{what}, {part}: {a}, stored {b}");
    };
    for (read, stored) in read.iter().zip(stored) {
        let (center, sigma) = (read.center.as_dvec3(), read.sigma.as_dvec3());
        for k in 0..3 {
            near(center[k], stored.center[k], rounding.center, "centre");
            near(sigma[k] / stored.sigma[k], 1.0, rounding.sigma, "deviation");
            near(
                f64::from(read.color[k]),
                stored.color[k],
                rounding.share.max(1e-6) * 1.9,
                "colour",
            );
        }
        near(f64::from(read.opacity), stored.opacity, rounding.share, "opacity");
        let [x, y, z, w] = read.rotation.to_array().map(f64::from);
        assert!((read.rotation.length() - 1.0).abs() < 1e-6, "{what}");
        let (own, wanted) = (matrix([w, x, y, z]), matrix(stored.rotation));
        for (a, b) in own.to_cols_array().into_iter().zip(wanted.to_cols_array()) {
            near(a, b, rounding.rotation, "rotation");
        }
    }
}

#[test]
fn every_format_gives_what_it_stores() {
    // A third of a step of nine bits and a sign, and the largest part, which follows from the others.
    let three = Rounding { center: 0.5 / 4096.0, sigma: 0.033, rotation: 8e-3, share: BYTE };
    let byte_axes = Rounding { center: 0.5 / 4096.0, sigma: 0.033, rotation: 0.04, share: BYTE };
    for format in ["ascii", "binary_little_endian"] {
        assert_near(&load(ply(format, &SPLATS, 9)).unwrap().splats, &SPLATS, EXACT, format);
    }
    // Shares of the bounds in 10 bits: 5 m, and a logarithm of 3.
    let packed = Rounding { center: 5.0 / 2046.0, sigma: 2e-3, rotation: 6e-3, share: BYTE };
    assert_near(&load(packed_ply(&SPLATS)).unwrap().splats, &SPLATS, packed, "packed");
    let bytes = Rounding { rotation: 0.02, share: BYTE, ..EXACT };
    assert_near(&load(bare(&SPLATS)).unwrap().splats, &SPLATS, bytes, "splat");
    for (version, rounding) in
        [(1, Rounding { center: 2e-3, ..byte_axes }), (2, byte_axes), (3, three), (4, three)]
    {
        // Versions 1 and 2 store no sign of w.
        let cloud = load(spz(version, &SPLATS)).unwrap();
        assert_near(&cloud.splats, &SPLATS, rounding, &format!("spz {version}"));
    }
    // Positions are logarithms in 16 bits.
    let sog_rounding = Rounding { center: 3e-4, sigma: 1e-6, rotation: 0.02, share: BYTE };
    assert_near(&load(sog(&SPLATS)).unwrap().splats, &SPLATS, sog_rounding, "sog");
    // A step of 8 m / 32767, and half floats.
    let halves = Rounding { center: 1.3e-4, sigma: 5e-4, rotation: 2e-3, share: BYTE };
    for (level, rounding) in [(0, Rounding { share: BYTE, ..EXACT }), (1, halves), (2, halves)] {
        let cloud = load(ksplat(level, &SPLATS)).unwrap();
        assert_near(&cloud.splats, &SPLATS, rounding, &format!("ksplat {level}"));
    }
    let moved = SPLATS.map(|splat| {
        let [x, y, z] = splat.center;
        Stored { center: [x, y + 1.0, z], ..splat }
    });
    let packed = load(gltf_spz(&SPLATS)).unwrap();
    for (read, stored) in packed.splats.iter().zip(&moved) {
        assert!((read.center.as_dvec3() - DVec3::from_array(stored.center)).length() < 3e-4);
        assert!((f64::from(read.opacity) - stored.opacity).abs() <= BYTE);
    }
    for logarithms in [false, true] {
        let cloud = load(gltf(&SPLATS, logarithms)).unwrap();
        // Axes may be in another order: the covariance counts.
        for (read, stored) in cloud.splats.iter().zip(&moved) {
            let covariance = |axes: DMat3, sigma: DVec3| {
                axes * DMat3::from_diagonal(sigma * sigma) * axes.transpose()
            };
            let [x, y, z, w] = read.rotation.to_array().map(f64::from);
            let own = covariance(matrix([w, x, y, z]), read.sigma.as_dvec3());
            let wanted = covariance(matrix(stored.rotation), DVec3::from_array(stored.sigma));
            let far = (own - wanted).to_cols_array();
            assert!(far.iter().all(|part| part.abs() < 1e-6), "glTF, {logarithms}: {far:?}");
            assert!((read.center.as_dvec3() - DVec3::from_array(stored.center)).length() < 1e-6);
            assert!((f64::from(read.opacity) - stored.opacity).abs() < 1e-6);
        }
    }
}

#[test]
fn harmonics_are_left_out_with_a_note() {
    let files = [
        (ply("ascii", &SPLATS, 45), "15 coefficients"),
        (spz(2, &SPLATS), "3 coefficients"),
        (sog(&SPLATS), "8 coefficients"),
        (gltf(&SPLATS, false).into_bytes(), "1 coefficient"),
        (gltf_spz(&SPLATS).into_bytes(), "3 coefficients"),
        (ksplat(1, &SPLATS), "3 coefficients"),
    ];
    for (file, words) in files {
        let notes = load(file).unwrap().notes;
        assert!(notes.iter().any(|note| note.contains(words)), "{words}: {notes:?}");
    }
    assert!(load(ply("ascii", &SPLATS, 0)).unwrap().notes.is_empty());
}

#[test]
fn a_medium_has_the_extinction_of_its_normalised_kernels() {
    let mut text = "ply\nformat ascii 1.0\nelement vertex 2\n".to_owned();
    for name in
        "x y z albedo_0 albedo_1 albedo_2 sigma_t_0 scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3"
            .split(' ')
    {
        text += &format!("property float {name}\n");
    }
    let log = 0.1f64.ln();
    text += &format!("end_header\n1 2 3 0.9 0.8 0.7 0.002 {log} {log} {log} 1 0 0 0\n");
    text += &format!("0 0 0 0.9 0.8 0.7 0.001 {log} {log} {log} 1 0 0 0\n");
    let cloud = load(text).unwrap();
    // A Gaussian of integral 0.002 and three deviations of 0.1.
    let densest = 0.002 / (std::f64::consts::TAU.powf(1.5) * 1e-3);
    let extinction = f64::from(cloud.extinction.unwrap());
    assert!((extinction / densest - 1.0).abs() < 1e-5, "{extinction}, by definition {densest}");
    let opacities: Vec<f32> = cloud.splats.iter().map(|splat| splat.opacity).collect();
    assert!((opacities[0] - 1.0).abs() < 1e-6 && (opacities[1] - 0.5).abs() < 1e-6);
}

#[test]
fn what_is_no_splat_is_left_out_and_counted() {
    let one = SPLATS[0];
    let all = [
        Stored { center: [f64::NAN, 0.0, 0.0], ..one },
        one,
        Stored { center: [2e7, 0.0, 0.0], ..one },
        Stored { rotation: [0.0; 4], ..one },
        Stored { color: [1.4, 0.5, -0.2], ..one },
        Stored { sigma: [0.0, 0.1, 0.1], ..one },
    ];
    let cloud = load(ply("binary_little_endian", &all, 0)).unwrap();
    assert_eq!(cloud.splats.len(), 3);
    assert_eq!(cloud.skipped.values().sum::<u64>(), 3);
    assert_eq!(cloud.skipped.get("gaussian too far"), Some(&1), "{:?}", cloud.skipped);
    assert_eq!(cloud.rows, [1, 4, 5], "rows of the file that are left");
    // A clamped colour is reported; a flat splat becomes a very thin one.
    assert_eq!(cloud.splats[1].color.to_array(), [1.0, 0.5, 0.0]);
    assert!(
        cloud.notes.iter().any(|note| note.contains("1 splats are clamped")),
        "{:?}",
        cloud.notes
    );
    let thin = cloud.splats[2].sigma.x;
    assert!(thin > 0.0 && thin < 1e-6, "{thin}");
}

/// Each prefix of a file is refused, or has fewer splats; none panics.
#[test]
fn files_that_are_cut_off_are_refused() {
    let files = [
        ply("ascii", &SPLATS, 3),
        ply("binary_little_endian", &SPLATS, 3),
        packed_ply(&SPLATS),
        spz(1, &SPLATS),
        spz(2, &SPLATS),
        spz(3, &SPLATS),
        spz(4, &SPLATS),
        sog(&SPLATS),
        gltf(&SPLATS, false).into_bytes(),
        gltf_spz(&SPLATS).into_bytes(),
    ];
    for (which, file) in files.iter().enumerate() {
        // The last number of an ascii row may be cut to another number.
        let whole = if which == 0 { file.len() - 30 } else { file.len() };
        for length in 0..whole {
            if let Ok(cloud) = load(&file[..length]) {
                panic!(
                    "file {which}, {length} of {} bytes: {} splats",
                    file.len(),
                    cloud.splats.len()
                );
            }
        }
    }
    for level in 0..3 {
        let file = ksplat(level, &SPLATS);
        // Lengths after the header are interesting; those before are all alike.
        for length in (0..4096).step_by(997).chain(4096 + 1024..file.len()) {
            assert!(load(&file[..length]).is_err(), "ksplat {level}, {length} bytes");
        }
    }
    let records = bare(&SPLATS);
    assert_eq!(load(&records[..64]).unwrap().splats.len(), 2);
    assert!(refusal(&records[..63]).contains("no splats of a known kind"));
}

#[test]
fn files_that_lie_are_refused() {
    // More splats than the limit, in a few bytes.
    let (header, parts) = spz_parts(2, &SPLATS);
    let gzip = |header: &[u8], parts: &[Vec<u8>]| {
        let mut file = GzEncoder::new(Vec::new(), Compression::fast());
        file.write_all(header).unwrap();
        parts.iter().for_each(|part| file.write_all(part).unwrap());
        file.finish().unwrap()
    };
    let with = |at: usize, bytes: &[u8]| {
        let mut changed = header.clone();
        changed[at..at + bytes.len()].copy_from_slice(bytes);
        gzip(&changed, &parts)
    };
    for (file, words) in [
        (with(8, &u32::MAX.to_le_bytes()), "4294967295 splats"),
        (with(8, &16_000_000_u32.to_le_bytes()), "ends in the positions"),
        (with(4, &9_u32.to_le_bytes()), "version 9"),
        (with(12, &[3]), "ends in the spherical harmonics"),
        (with(12, &[9]), "degree 9"),
        (with(13, &[99]), "99 bits"),
    ] {
        let text = refusal(file);
        assert!(text.contains(words), "{text}");
    }
    // Version 4: the list of streams against the header.
    let four = spz(4, &SPLATS);
    let changed = |at: usize, byte: u8| {
        let mut file = four.clone();
        file[at] = byte;
        refusal(file)
    };
    assert!(changed(8, 4).contains("the positions have 27 bytes, not 36"));
    assert!(changed(15, 2).contains("2 streams"));
    assert!(changed(16, 255).contains("list of streams"));
    assert!(changed(40, 255).contains("positions"));
    // Sections against the header and the file.
    for level in 0..3 {
        let file = ksplat(level, &SPLATS);
        let changed = |at: usize, bytes: &[u8]| {
            let mut file = file.clone();
            file[at..at + bytes.len()].copy_from_slice(bytes);
            refusal(file)
        };
        assert!(changed(16, &[2]).contains("its sections have 3 splats, and it says 2"));
        assert!(changed(5120, &[9]).contains("its sections have 12 splats"));
        assert!(changed(5124, &[9]).contains("ends in its sections"));
        assert!(changed(5160, &[9]).contains("degree 9"));
        let many = changed(12, &[0, 0, 0, 1, 0, 0, 0, 1]);
        assert!(many.contains("16777216 splats"), "{many}");
        if level > 0 {
            let astray = changed(6144, &[1]);
            assert!(astray.contains("splat 3 is in no bucket"), "{astray}");
        }
    }
    // A count larger than that of the rows.
    let text = String::from_utf8(ply("ascii", &SPLATS, 0)).unwrap();
    assert!(refusal(text.replace("vertex 3", "vertex 3000000")).contains("3000000"));
    assert!(refusal(text.replace("float opacity", "float opacify")).contains("`opacity`"));
    // Images smaller than the count.
    let long = sog(&SPLATS);
    let at = long.windows(10).position(|window| window == b"\"count\": 3").unwrap();
    let mut long = long;
    long[at + 9] = b'9';
    // The checksum of the changed file in the archive does not match.
    assert!(refusal(long).contains("meta.json"));
    let gltf = gltf(&SPLATS, false);
    assert!(refusal(gltf.replace(":OPACITY\": 3", ":OPACITY\": 0")).contains("wrong type"));
    assert!(refusal(gltf.replace(":OPACITY\"", ":OPAQUE\"")).contains("OPACITY"));
    assert!(
        refusal(
            gltf.replace(
                "\"count\": 3, \"type\": \"SCALAR\"",
                "\"count\": 2, \"type\": \"SCALAR\""
            )
        )
        .contains("differ in count")
    );
    let packed = gltf.replace("\"kernel\": \"ellipse\"", "\"extensions\": {\"X_packed\": {}}");
    assert!(refusal(packed).contains("X_packed"));
}

/// Written files are read back unchanged.
#[test]
fn written_files_are_read_again() {
    let cloud = load(ply("ascii", &SPLATS, 0)).unwrap();
    let colors: Vec<_> = cloud.splats.iter().map(|splat| splat.color).collect();
    let again = load(splats::to_ply(&cloud.splats, &colors, &Harmonics::default())).unwrap();
    assert_near(&again.splats, &SPLATS, EXACT, "PLY");
    let fine =
        Rounding { center: 0.5 / f64::from(1 << 20), sigma: 0.033, rotation: 8e-3, share: BYTE };
    let again =
        load(splats::to_spz(&cloud.splats, &colors, &Harmonics::default()).unwrap()).unwrap();
    assert_near(&again.splats, &SPLATS, fine, "SPZ");
    // Far centres cost fractional bits; too far ones are an error.
    let far = |x: f32| {
        let mut splats = cloud.splats.clone();
        splats[0].center.x = x;
        splats::to_spz(&splats, &colors, &Harmonics::default())
    };
    let read = load(far(100_000.5).unwrap()).unwrap();
    assert!((read.splats[0].center.x - 100_000.5).abs() < 0.01, "{}", read.splats[0].center);
    assert!(far(9e6).is_err());
}
