//! Particle files: every PLY encoding, CSV, and invalid files.
use crate::common::files::TempFile;
use gobo::{
    glam::{Vec3, Vec4},
    model::{Material, Particle, Transfer},
};
use gobo_scene::{ParticleFile, SceneError, load_particles};

/// Seeded random numbers (xorshift64*; Vigna 2016).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % end
    }
}

fn load_as(
    name: &str,
    bytes: impl AsRef<[u8]>,
    material: &Material,
) -> Result<ParticleFile, SceneError> {
    load_particles(&TempFile::new(name, bytes).0, material, 3, Some(0.25), 100)
}

fn load(name: &str, bytes: impl AsRef<[u8]>) -> Result<ParticleFile, SceneError> {
    load_as(name, bytes, &Material::default())
}

fn error(name: &str, bytes: impl AsRef<[u8]>) -> String {
    let error = load(name, bytes).expect_err("a wrong file was accepted").to_string();
    assert!(error.contains(name), "{error} does not name the file {name}");
    error
}

/// A vertex with every type of number, a foreign element with a list before it and a list in it.
const HEADER: &str = "comment made by hand
element face 2
property list uchar int vertex_index
property short kind
element vertex 2
property uchar red
property uchar green
property double z
property short y
property list ushort double weights
property int x
property uchar blue
property uchar alpha
property float radius
property ushort id
property char rotation
property float nx
element edge 1
property int a
end_header
";

fn expected() -> Vec<Particle> {
    vec![
        Particle {
            center: Vec3::new(70000.0, -300.0, 0.1),
            radius: 0.5,
            color: Vec4::new(1.0, 0.0, 0.215_860_53, 51.0 / 255.0),
            rotation: -2.0,
            material: 3,
            id: 60000,
        },
        Particle {
            center: Vec3::new(-1.0, 2.0, 3.0),
            radius: 0.125,
            color: Vec4::new(0.0, 1.0, 0.0, 1.0),
            rotation: 1.0,
            material: 3,
            id: 7,
        },
    ]
}

fn ascii() -> Vec<u8> {
    let rows = "3 0 1 2 -5\n0 9\n\
        255 0 .1 -300 2 0.5 1e3 70000 128 51 0.5 60000 -2 0\n\
        0 255 3 2 0 -1 0 255 0.125 7 1 0\r\n4\n";
    format!("ply\nformat ascii 1.0\n{HEADER}{rows}").into_bytes()
}

fn binary(big: bool) -> Vec<u8> {
    let name = if big { "big" } else { "little" };
    let mut bytes = format!("ply\nformat binary_{name}_endian 1.0\n{HEADER}").into_bytes();
    let mut put = |mut number: Vec<u8>| {
        if big {
            number.reverse();
        }
        bytes.extend(number);
    };
    macro_rules! put {
        ($($value:expr),*) => { $(put($value.to_le_bytes().to_vec());)* };
    }
    put!(3u8, 0i32, 1i32, 2i32, -5i16, 0u8, 9i16);
    put!(
        255u8, 0u8, 0.1f64, -300i16, 2u16, 0.5f64, 1e3f64, 70000i32, 128u8, 51u8, 0.5f32, 60000u16
    );
    put!(-2i8, 0f32);
    put!(0u8, 255u8, 3f64, 2i16, 0u16, -1i32, 0u8, 255u8, 0.125f32, 7u16, 1i8, 0f32);
    put!(4i32);
    bytes
}

fn assert_expected(file: &ParticleFile) {
    assert!(file.skipped.is_empty(), "{:?}", file.skipped);
    assert_eq!(file.particles.len(), 2);
    for (mut got, want) in file.particles.iter().copied().zip(expected()) {
        assert!(got.color.abs_diff_eq(want.color, 1e-6), "{got:?} is not {want:?}");
        got.color = want.color;
        assert_eq!(got, want);
    }
}

#[test]
fn every_encoding_order_and_type() {
    assert_expected(&load("a.ply", ascii()).unwrap());
    assert_expected(&load("l.ply", binary(false)).unwrap());
    assert_expected(&load("b.ply", binary(true)).unwrap());
}

#[test]
#[should_panic(expected = "assertion")]
fn a_wrong_byte_is_noticed() {
    let mut bytes = binary(false);
    let end = bytes.len();
    bytes[end - 8 - 1 - 2] ^= 1;
    assert_expected(&load("wrong.ply", bytes).unwrap());
}

#[test]
fn float_colours_are_linear_and_the_rest_has_defaults() {
    let text = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
        property float z\nproperty float red\nend_header\n1 2 3 .5\n4 5 6 0.25";
    let file = load("float.ply", text).unwrap();
    assert_eq!(file.particles[0].color, Vec4::new(0.5, 1.0, 1.0, 1.0));
    assert_eq!(file.particles[1].color.x, 0.25);
    assert!(file.particles.iter().all(|p| p.radius == 0.25 && p.rotation == 0.0));
    assert_eq!([file.particles[0].id, file.particles[1].id], [100, 101]);
}

#[test]
fn csv_and_each_reason_to_skip() {
    let text = "x, y ,z,radius,red,green,blue,alpha,rotation,note\n\
        1,2,3,.5,.1,.2,.3,.4,.5,hello\n\
        nan,2,3,1,1,1,1,1,0,\n\
        1,inf,3,1,1,1,1,1,0,\n\
        1,1e300,3,1,1,1,1,1,0,\n\
        1,2,-1.1e7,1,1,1,1,1,0,\n\
        1,2,3,0,1,1,1,1,0,\n\
        1,2,3,-1,1,1,1,1,0,\n\
        1,2,3,1,1.5,1,1,1,0,\n\
        1,2,3,1,1,1,-0.1,1,0,\n\
        1,2,3,1,1,1,1,1.01,0,\n\
        1e7,2,3,1,1,1,1,0,0,\n";
    let file = load("skip.csv", text).unwrap();
    let want = [
        ("alpha out of range", 1),
        ("colour out of range", 2),
        ("not finite", 3),
        ("radius not positive", 2),
        ("too far", 1),
    ];
    assert_eq!(file.skipped.into_iter().collect::<Vec<_>>(), want);
    let first = file.particles[0];
    assert_eq!(first.color, Vec4::new(0.1, 0.2, 0.3, 0.4));
    assert_eq!((first.center, first.radius, first.rotation), (Vec3::new(1.0, 2.0, 3.0), 0.5, 0.5));
    // Skipped rows keep their numbers.
    assert_eq!(file.particles.iter().map(|p| p.id).collect::<Vec<_>>(), [100, 110]);
    let gain = Material { transfer: Transfer::Gain, ..Material::default() };
    let file = load_as("gain.csv", "x,y,z,red\n0,0,0,16\n0,0,0,16.1\n", &gain).unwrap();
    assert_eq!((file.particles.len(), file.skipped["colour out of range"]), (1, 1));
}

#[test]
fn radius_without_a_column_is_half_the_spacing() {
    let spaced = |extra: &str| {
        let mut text = String::from("x,y,z\n");
        for i in 0..1000 {
            text += &format!("{},{},{}\n", i % 10, i / 10 % 10, i / 100);
        }
        let file = TempFile::new("spaced.csv", text + extra);
        load_particles(&file.0, &Material::default(), 0, None, 0).unwrap().particles[0].radius
    };
    let radius = spaced("");
    assert!((radius - 0.45).abs() < 1e-6, "{radius}");
    assert_eq!(spaced("nan,0,0\n1e9,0,0\n"), radius, "skipped particles change the spacing");
    let lone = TempFile::new("lone.csv", "x,y,z\n1,2,3\n");
    let file = load_particles(&lone.0, &Material::default(), 0, None, 0).unwrap();
    assert!(file.particles[0].radius > 0.0);
}

#[test]
fn errors_name_what_is_wrong() {
    let csv = |rows: &str| error("bad.csv", format!("x,y,z\n1,2,3\n{rows}\n"));
    assert!(csv("1,two,3").contains("line 3, column `y`: `two` is not a number"));
    assert!(csv("1,2").contains("line 3"));
    assert!(error("no.csv", "x,y\n1,2\n").contains("column `z`"));
    assert!(error("twice.csv", "x,y,z,x\n1,2,3,4\n").contains("two columns are named `x`"));
    assert!(error("dots.obj", "").contains(".ply, .csv"));
    assert!(error("empty.ply", "").contains("header"));
    let ply = |header: &str| error("bad.ply", format!("ply\n{header}"));
    assert!(ply("format ascii 1.0\nelement vertex 1\n").contains("end_header"));
    assert!(ply("format rot13 1.0\nend_header\n").contains("rot13"));
    assert!(ply("format ascii 1.0\nend_header\n").contains("`vertex`"));
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let big = "format binary_little_endian 1.0\nelement vertex 18446744073709551615\n";
    assert!(ply(&format!("{big}{xyz}end_header\n0")).contains("promises"));
    assert!(ply(&format!("{big}end_header\n0")).contains("column `x`"));
    let faces = "format ascii 1.0\nelement face 99\nelement vertex 1\n";
    assert!(ply(&format!("{faces}{xyz}end_header\n1 2 3\n")).contains("promises"));
    let one = "format ascii 1.0\nelement vertex 1\n";
    assert!(ply(&format!("{one}{xyz}end_header\n1 b 3\n")).contains("line 8: `b` is not"));
    assert!(ply(&format!("{one}{xyz}end_header\n1 2\n")).contains("line 8: the row has too few"));
    assert!(
        ply(&format!("{one}{xyz}property int x\nend_header\n1 2 3 4\n"))
            .contains("second property")
    );
    let missing = std::env::temp_dir().join("gobo-missing.ply");
    let error = load_particles(&missing, &Material::default(), 0, None, 0).unwrap_err();
    assert!(matches!(error, SceneError::Read { .. }));
    let error = load_particles(&std::env::temp_dir(), &Material::default(), 0, None, 0);
    assert!(error.is_err());
}

#[test]
fn truncated_anywhere() {
    for (name, bytes) in [("l", binary(false)), ("b", binary(true)), ("a", ascii())] {
        for end in 0..bytes.len() {
            if let Ok(file) = load(&format!("cut-{name}.ply"), &bytes[..end]) {
                assert!(bytes.len() - end <= 36, "{name} cut at {end} still gave all particles");
                assert!(file.particles.len() <= 2);
            }
        }
    }
}

#[test]
fn mutated_files_never_panic() {
    let mut random = Random(7);
    let csv = b"x,y,z,red\n1,2,3,4\n5,6,7,8\n".to_vec();
    let files =
        [("a.ply", ascii()), ("l.ply", binary(false)), ("b.ply", binary(true)), ("c.csv", csv)];
    for (name, bytes) in files {
        for _ in 0..1500 {
            let mut bytes = bytes.clone();
            for _ in 0..1 + random.below(4) {
                let at = random.below(bytes.len());
                bytes[at] = random.below(256) as u8;
            }
            if let Ok(file) = load(&format!("mutated-{name}"), &bytes) {
                assert!(file.particles.capacity() <= bytes.len());
            }
        }
    }
}
