//! PLY: notes about ignored contents, refusal of files without particles, and errors of headers.
use crate::common::files::Folder;
use gobo::model::Material;
use gobo_scene as scene;
use gobo_scene::{ParticleFile, SceneError, load_particles};

fn load(text: impl AsRef<[u8]>) -> Result<ParticleFile, SceneError> {
    let folder = Folder::new();
    load_particles(&folder.write("dots.ply", text), &Material::default(), 0, Some(0.1), 0)
}

fn refusal(text: impl AsRef<[u8]>) -> String {
    match load(text) {
        Err(SceneError::Invalid { path, message, help }) => {
            assert!(path.ends_with("dots.ply"));
            format!("{message}; {}", help.expect("a remedy"))
        }
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("read without an error"),
    }
}

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";

/// An ascii file of vertices with columns after x, y and z.
fn with(columns: &str, rows: &str) -> String {
    let count = rows.lines().count();
    format!("ply\nformat ascii 1.0\nelement vertex {count}\n{XYZ}{columns}end_header\n{rows}")
}

#[test]
fn columns_that_nobody_reads_are_named_once() {
    let columns = "property float nx\nproperty list uchar int tags\nproperty float heat\n";
    let file = load(with(columns, "1 2 3 0 2 7 7 36.6\n4 5 6 1 0 37\n")).unwrap();
    assert_eq!(file.particles.len(), 2);
    let [note] = &file.notes[..] else { panic!("{:?}", file.notes) };
    for word in ["dots.ply", "nx", "tags", "heat"] {
        assert!(note.contains(word), "{note}");
    }
    assert!(load(with("property float radius\n", "1 2 3 0.5\n")).unwrap().notes.is_empty());

    let folder = Folder::new();
    let csv = folder.write("dots.csv", "x,y,z,mass,note\n1,2,3,4,hello\n");
    let [note] = &scene::load(&csv).unwrap().notes[..] else { panic!("one note") };
    assert!(note.contains("dots.csv") && note.contains("mass"), "{note}");
}

#[test]
fn faces_beside_the_vertices_are_named() {
    let text = format!(
        "ply\nformat ascii 1.0\nelement vertex 1\n{XYZ}element face 1\n\
         property list uchar int vertex_indices\nend_header\n1 2 3\n3 0 0 0\n"
    );
    let [note] = &load(text).unwrap().notes[..] else { panic!("one note") };
    assert!(note.contains("face"), "{note}");
}

#[test]
fn splats_are_refused_with_the_reason() {
    let gaussian = "property float scale_0\nproperty float scale_1\nproperty float scale_2\n\
                    property float rot_0\nproperty float rot_1\nproperty float rot_2\nproperty float rot_3\n";
    let text = refusal(with(gaussian, "1 2 3 1 1 1 0 0 0 1\n"));
    assert!(text.contains("Gaussian") && text.contains("[[splats]]"), "{text}");
    let text = refusal(with("property float f_dc_0\n", "1 2 3 1\n"));
    assert!(text.contains("Gaussian"), "{text}");
    let packed = "ply\nformat binary_little_endian 1.0\nelement chunk 0\nproperty float min_x\n\
                  element vertex 0\nproperty uint packed_position\nproperty uint packed_rotation\n\
                  end_header\n";
    assert!(refusal(packed).contains("Gaussian"));
}

#[test]
fn headers_are_faulted_by_line_in_plain_words() {
    for (header, line, said) in [
        ("ply\nformat ascii 2.0\nelement vertex 1\n", 2, "2.0"),
        ("ply\nformat rot13 1.0\n", 2, "rot13"),
        ("ply\nformat ascii 1.0\nelement vertex lots\n", 3, "lots"),
        ("ply\nformat ascii 1.0\nelement vertex -3\n", 3, "-3"),
        ("ply\nformat ascii 1.0\nproperty float x\n", 3, "element"),
        ("ply\nformat ascii 1.0\nelement vertex 1\nproperty quaternion q\n", 4, "quaternion"),
        ("ply\nformat ascii 1.0\nelement vertex 1\nproperty list float int q\n", 4, "list"),
        ("ply\nformat ascii 1.0\nelement vertex 1\nelement vertex 1\n", 4, "second"),
        (
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty int x\n",
            5,
            "second",
        ),
        ("ply\nformat ascii 1.0\nelment vertex 1\n", 3, "elment"),
        ("obj\nformat ascii 1.0\n", 1, "ply"),
    ] {
        let text = refusal(format!("{header}end_header\n1 2 3\n"));
        assert!(text.contains(&format!("line {line} ")), "{header}: {text}");
        assert!(text.contains(said), "{header}: {text}");
        assert!(!text.contains("ParseError") && !text.contains('{'), "{header}: {text}");
    }
    assert!(refusal("ply\nformat ascii 1.0\n").contains("end_header"));
    assert!(refusal("ply\nend_header\n").contains("format"));
    let long = format!("ply\nformat ascii 1.0\n{}\nend_header\n", "w".repeat(1 << 20));
    assert!(refusal(long).len() < 1000);
    assert!(!refusal("ply\nformat \x1b[31m 1.0\nend_header\n").contains('\x1b'));
}

#[test]
fn rows_have_what_the_header_says_and_no_more() {
    let text = refusal(with("", "1 2 3\n4 5 6 7\n"));
    assert!(text.contains("line 9"), "{text}");
    let text = refusal(with("property list int int tags\n", "1 2 3 -1\n"));
    assert!(text.contains("-1") && text.contains("line 9"), "{text}");
    assert!(refusal(with("property list int int tags\n", "1 2 3 1.5 7\n")).contains("1.5"));
    let mut binary = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\n{XYZ}property list int uchar tags\n\
         end_header\n"
    )
    .into_bytes();
    binary.extend([1f32, 2., 3.].map(f32::to_le_bytes).concat());
    let mut negative = binary.clone();
    negative.extend((-1i32).to_le_bytes());
    assert!(refusal(&negative).contains("-1"));
    // A list at the end of the file, and one more byte than expected.
    binary.extend(2i32.to_le_bytes());
    binary.extend([5, 6]);
    assert!(load(&binary).unwrap().notes.iter().all(|note| !note.contains("byte")));
    binary.push(7);
    let notes = load(&binary).unwrap().notes;
    assert!(notes.iter().any(|note| note.contains("1 byte")), "{notes:?}");
}

#[test]
fn lines_may_end_as_on_any_system() {
    let unix = with("property float heat\n", "1 2 3 0\n4 5 6 0\n");
    let want: Vec<_> = load(&unix).unwrap().particles.iter().map(|p| p.center).collect();
    for end in ["\r\n", "\r"] {
        let text = unix.replace('\n', end);
        let found: Vec<_> = load(&text).unwrap().particles.iter().map(|p| p.center).collect();
        assert_eq!(found, want, "{end:?}");
    }
    // The first byte of a binary body may look like the end of a line.
    let mut binary = format!(
        "ply\rformat binary_little_endian 1.0\relement vertex 1\r{}end_header\r",
        XYZ.replace('\n', "\r")
    )
    .into_bytes();
    let x = f32::from_bits(0x3f00_000a);
    binary.extend([x, 2., 3.].map(f32::to_le_bytes).concat());
    assert_eq!(load(&binary).unwrap().particles[0].center.x, x);
}

/// Rows of one size are read on all cores: all rows, in order, whatever their number.
#[test]
fn threads_do_not_change_what_is_read() {
    const COUNT: usize = 40_000;
    // Every thousandth row has no radius, but still has its number.
    let row = |i: usize| [i as f32, 0.5 * i as f32, -1.0, if i % 1000 == 7 { 0.0 } else { 0.1 }];
    let columns = format!("{XYZ}property float radius\n");
    let header = |kind: &str| {
        format!("ply\nformat {kind} 1.0\nelement vertex {COUNT}\n{columns}end_header\n")
    };
    let mut binary = header("binary_big_endian").into_bytes();
    let mut ascii = header("ascii");
    for i in 0..COUNT {
        binary.extend(row(i).iter().flat_map(|number| number.to_be_bytes()));
        ascii += &row(i).map(|number| number.to_string()).join(" ");
        ascii += "\n";
    }
    let sequential = load(ascii).unwrap();
    assert_eq!(sequential.particles.len(), COUNT - COUNT / 1000);
    for threads in [1, 2, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let ParticleFile { particles, skipped, .. } = pool.install(|| load(&binary)).unwrap();
        assert!(particles == sequential.particles, "{threads} threads");
        assert_eq!(skipped, sequential.skipped);
        assert!(particles.iter().all(|p| p.center.x == p.id as f32), "{threads} threads");
    }
    let mut cut = binary;
    cut.truncate(cut.len() - 1);
    assert!(refusal(cut).contains("ends in row 40000 of 40000"));
}
