//! Point clouds: stored values are read, and truncated or wrong files are refused.
use crate::common::{
    files::Folder,
    points::{DOTS, Dot, copc, e57, las, laz, pcd},
};
use gobo::{
    glam::{DVec3, Vec3},
    model::{Bounds, Particle},
};
use gobo_scene as scene;
use gobo_scene::{LoadOptions, Scene, SceneError, Share, generate::Chance};

/// Loads a single file with a meaningless name.
fn load(bytes: impl AsRef<[u8]>) -> Result<Scene, SceneError> {
    let folder = Folder::new();
    scene::load(&folder.write("some.file", bytes))
}

fn refusal(bytes: impl AsRef<[u8]>) -> String {
    match load(bytes) {
        Err(error) => format!("{error}; {}", error.help().expect("a remedy")),
        Ok(scene) => panic!("{} points read without an error", scene.particles.len()),
    }
}

/// Linear value of an sRGB byte.
fn linear(byte: u8) -> f32 {
    let c = f32::from(byte) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

fn assert_near(read: &[Particle], dots: &[Dot], moved: DVec3, what: &str) {
    assert_eq!(read.len(), dots.len(), "{what}");
    for (particle, dot) in read.iter().zip(dots) {
        let [x, y, z] = (DVec3::from_array(dot.place) + moved).to_array();
        let place = DVec3::new(x, z, -y);
        assert!((particle.center.as_dvec3() - place).length() < 1e-3, "{what}: {particle:?}");
        let color = Vec3::from_array(dot.rgb.map(linear));
        assert!((particle.color.truncate() - color).length() < 1e-3, "{what}: {particle:?}");
        assert_eq!(particle.color.w, 1.0, "{what}");
    }
}

#[test]
fn every_format_gives_what_it_stores() {
    let still = DVec3::ZERO;
    for (format, depth) in [(2, 257), (3, 257), (7, 257), (2, 1)] {
        let offset = [100.0, -50.0, 0.125];
        let scene = load(las(format, &DOTS, offset, depth)).unwrap();
        assert_near(&scene.particles, &DOTS, still, &format!("LAS {format}, {depth}"));
    }
    for format in [2, 3, 7] {
        let scene = load(laz(format, &DOTS, [0.0; 3])).unwrap();
        assert_near(&scene.particles, &DOTS, still, &format!("LAZ {format}"));
    }
    for encoding in ["ascii", "binary", "binary_compressed"] {
        let scene = load(pcd(encoding, &DOTS)).unwrap();
        assert_near(&scene.particles, &DOTS, still, encoding);
        assert!(scene.notes.iter().any(|note| note.contains("`normal`")), "{:?}", scene.notes);
    }
    let scene = load(e57(&DOTS)).unwrap();
    assert_near(&scene.particles, &DOTS, DVec3::Z * 10.0, "E57");
}

/// A scene of a cloud with a budget of points.
fn load_within(bytes: &[u8], budget: u64) -> Result<Scene, SceneError> {
    let folder = Folder::new();
    folder.write("cloud.laz", bytes);
    let text = format!(
        "[[material]]\nname = 'm'\n[[particles]]\nfile = 'cloud.laz'\nmaterial = 'm'\npoint_budget = {budget}\n"
    );
    scene::load(&folder.write("scene.toml", text))
}

#[test]
fn an_octree_is_read_down_to_the_budget() {
    // One, two and one points.
    let levels = [&DOTS[..1], &DOTS[1..3], &DOTS[3..]];
    let file = copc(&levels);
    // All of it is LAZ like any other, and so is one with room for all.
    assert_near(&load(&file).unwrap().particles, &DOTS, DVec3::ZERO, "LAZ");
    for (budget, read) in [(1, 1), (2, 1), (3, 3), (4, 4), (1000, 4)] {
        let scene = load_within(&file, budget).unwrap();
        assert_near(&scene.particles, &DOTS[..read], DVec3::ZERO, &format!("{budget} points"));
        let deepest = [0, 0, 1][read.min(3) - 1];
        let note = format!("levels 0 to {deepest} of 2 of its octree are read: {read} of 4 points");
        assert_eq!(scene.notes.iter().any(|it| it.contains(&note)), read < 4, "{:?}", scene.notes);
    }
    let refused = |bytes: &[u8], budget: u64| {
        let error = load_within(bytes, budget).expect_err("read without an error");
        format!("{error}; {}", error.help().expect("a remedy"))
    };
    assert!(refused(&file, 0).contains("level 0 of its octree has more than 0 points"));
    assert!(refused(&laz(7, &DOTS, [0.0; 3]), 3).contains("4 points without levels of detail"));
    // Pages that name each other, and nodes behind the end.
    let entries = file.len() - 32 * 4;
    let change = |at: usize, bytes: &[u8]| {
        let mut changed = file.clone();
        changed[entries + at..entries + at + bytes.len()].copy_from_slice(bytes);
        refused(&changed, 3)
    };
    assert!(change(32 + 16, &(entries as u64).to_le_bytes()).contains("is named twice"));
    assert!(change(16, &u64::MAX.to_le_bytes()).contains("ends in its octree"));
    assert!(change(24, &(-5_i32).to_le_bytes()).contains("ends in its octree"));
    assert!(change(0, &(-1_i32).to_le_bytes()).contains("has level -1"));
    // A node that promises more points than its bytes hold.
    assert!(change(28, &2_i32.to_le_bytes()).contains("cannot be read"));
    for length in 0..file.len() {
        let _ = load_within(&file[..length], 3);
    }
}

/// Shares of a cloud have all of its points, each once, with the colours, ids, origin and bounds of the
/// whole.
#[test]
fn shares_of_a_cloud_are_read_alone() {
    let far = [500_000.0, 5_400_000.0, 120.0];
    let dots: Vec<Dot> = (0..5000_u32)
        .map(|i| Dot {
            place: [f64::from(i % 71), f64::from(i / 71), f64::from(i % 13)].map(|at| at * 0.25),
            rgb: [i as u8, (i / 16) as u8, 51],
            // Strong echoes, known classes and colours are in a share alone; one of a hundred is noise.
            intensity: if i > 4096 { (i - 4096) as u16 } else { (i % 5) as u16 },
            class: if i % 100 == 7 { 7 } else { u8::from(i < 900) * 2 },
        })
        .map(|dot| Dot { place: [0, 1, 2].map(|k| dot.place[k] + far[k]), ..dot })
        .collect();
    let dark: Vec<Dot> = dots.iter().map(|dot| Dot { intensity: 0, ..*dot }).collect();
    let folder = Folder::new();
    let text = "[[material]]\nname = 'm'\ntint = [1, 1, 1, 0.5]\nradius = 0.25\n[[particles]]\n\
        file = 'a.las'\nmaterial = 'm'\n[[particles]]\nfile = 'a.las'\nmaterial = 'm'\n";
    let path = folder.write("s.toml", text);
    let shared = |share: Option<Share>| {
        let mut options = LoadOptions::default();
        options.share = share;
        scene::load_as(&path, &options).unwrap()
    };
    for file in
        [las(2, &dots, far, 257), laz(7, &dots, far), las(0, &dots, far, 1), las(6, &dark, far, 1)]
    {
        folder.write("a.las", file);
        let whole = shared(None);
        assert_eq!(whole.skipped["noise"], 100);
        let mut all = Vec::new();
        for share in (0..3).map(|index| Share::new(index, 3)) {
            let part = shared(share);
            assert!(part.particles.len() < 5000 && part.skipped == whole.skipped);
            assert_eq!(part.origin, whole.origin);
            let [own, around] = [&whole, &part].map(|scene| {
                let of = |bounds: Bounds, p: &Particle| bounds.with_sphere(p.center, p.radius);
                scene.particles.iter().fold(scene.around, of)
            });
            assert_eq!((own.min, own.max), (around.min, around.max));
            all.extend(part.particles);
        }
        all.sort_by_key(|particle| particle.id);
        assert_eq!(all, whole.particles);
    }
}

#[test]
fn budgets_are_of_clouds() {
    let folder = Folder::new();
    let text = "[[material]]\nname = 'm'\n[[particles]]\ngenerate = { kind = 'smoke', count = 3 }\n\
        material = 'm'\npoint_budget = 3\n";
    let error = scene::load(&folder.write("scene.toml", text)).unwrap_err().to_string();
    assert!(error.contains("no cloud of points"), "{error}");
}

/// The bytes of a colour may be stored as a float, as in old PCL.
#[test]
fn colors_of_pcd_may_be_floats() {
    let bits = 0x00ff_0033_u32;
    let text = format!(
        "VERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\n\
         POINTS 2\nDATA ascii\n0 0 0 {:e}\nnan nan nan 0\n",
        f32::from_bits(bits)
    );
    let scene = load(text).unwrap();
    assert_near(&scene.particles, &DOTS[..1], DVec3::ZERO, "float");
    assert_eq!(scene.skipped.get("not finite"), Some(&1));
}

#[test]
fn points_without_colors_are_grey_or_of_their_class() {
    let scene = load(las(0, &DOTS, [0.0; 3], 1)).unwrap();
    let greys: Vec<f32> = scene.particles.iter().map(|particle| particle.color.x).collect();
    // 98 % of the echoes are at most white: here the second strongest is.
    assert_eq!(greys, [1.0, 1.0, 0.5, 0.25]);
    assert!(scene.particles.iter().all(|particle| particle.color.y == particle.color.x));
    let dark = DOTS.map(|dot| Dot { intensity: 0, ..dot });
    let scene = load(las(6, &dark, [0.0; 3], 1)).unwrap();
    let [ground, tree, house, plain] = [0, 1, 2, 3].map(|i| scene.particles[i].color.truncate());
    assert!(tree.y > tree.x && tree.y > tree.z && house.x > house.y, "{tree} {house}");
    assert!(ground != plain && plain == Vec3::splat(0.6));
    // Low and high noise, and deleted points.
    let noise = [DOTS[0], Dot { class: 7, ..DOTS[1] }, Dot { class: 128, ..DOTS[2] }];
    let scene = load(las(2, &noise, [0.0; 3], 257)).unwrap();
    assert_eq!(
        (scene.particles.len(), scene.skipped["noise"], scene.skipped["withheld"]),
        (1, 1, 1)
    );
}

#[test]
fn classes_have_alphas() {
    let folder = Folder::new();
    let load = |name: &str, file: Vec<u8>, classes: &str| {
        folder.write(name, file);
        let text = format!(
            "[[material]]\nname = 'm'\n[[particles]]\nfile = '{name}'\nmaterial = 'm'\nclasses = {classes}\n"
        );
        scene::load(&folder.write("s.toml", text))
    };
    // Classes 2, 5, 6 and 1.
    let scene = load("a.laz", laz(7, &DOTS, [0.0; 3]), "[[5, 0.25], [6, 0], [40, 0.5]]").unwrap();
    let alphas: Vec<_> = scene.particles.iter().map(|p| (p.id, p.color.w)).collect();
    assert_eq!(alphas, [(0, 1.0), (1, 0.25), (3, 1.0)]);
    assert_eq!(scene.skipped["class of alpha 0"], 1);
    let refused = |name: &str, file: Vec<u8>, classes: &str| {
        load(name, file, classes).expect_err("read without an error").to_string()
    };
    assert!(refused("a.e57", e57(&DOTS), "[[2, 0]]").contains("no classes"));
    assert!(refused("a.csv", b"x,y,z\n0,0,0\n".to_vec(), "[[2, 0]]").contains("no cloud"));
    let las = || las(2, &DOTS, [0.0; 3], 257);
    for classes in ["[[2, 1.5]]", "[[2, -1]]", "[[256, 0]]", "[[2]]", "2", "[[2, nan]]"] {
        assert!(refused("a.las", las(), classes).contains("s.toml:6"), "{classes}");
    }
}

/// Web Mercator reaches 2e7 m, where 32 bits round to two metres.
#[test]
fn coordinates_far_out_get_an_origin() {
    let far = [18_000_300.0, 6_000_300.0, 120.0];
    let dots = DOTS.map(|dot| Dot { place: [0, 1, 2].map(|k| dot.place[k] + far[k]), ..dot });
    let folder = Folder::new();
    folder.write("a.las", las(2, &dots[..2], far, 257));
    folder.write("b.laz", laz(2, &dots[2..], far));
    let text = "[[material]]\nname = \"m\"\n[[particles]]\nfile = \"a.las\"\nmaterial = \"m\"\n\
        [[particles]]\nfile = \"b.laz\"\nmaterial = \"m\"\n";
    let scene = scene::load(&folder.write("s.toml", text)).unwrap();
    let origin = DVec3::new(18_000_000.0, 6_000_000.0, 0.0);
    let said = "x = 18000000, y = 6000000, z = 0 m of the file is the scene's origin";
    assert_eq!(
        scene.notes.iter().filter(|note| note.contains(said)).count(),
        2,
        "{:?}",
        scene.notes
    );
    // The scene may have an origin of its own, too.
    let moved = DVec3::from_array(far) - origin;
    let own = scene.origin.as_dvec3();
    let particles: Vec<Particle> = (scene.particles.iter())
        .map(|p| Particle { center: (p.center.as_dvec3() + own).as_vec3(), ..*p })
        .collect();
    assert_near(&particles, &DOTS, moved, "far");
}

#[test]
fn discs_close_the_surface() {
    let grid: Vec<Dot> = (0..400)
        .map(|i| Dot { place: [f64::from(i % 20) * 0.5, f64::from(i / 20) * 0.5, 0.0], ..DOTS[0] })
        .collect();
    let scene = load(pcd("binary", &grid)).unwrap();
    assert!(scene.particles.iter().all(|particle| (particle.radius - 0.5).abs() < 1e-5));
    assert!(scene.notes.iter().any(|note| note.contains("0.500 m")), "{:?}", scene.notes);
    // Gaps wider than the largest disc stay open.
    let far = [-9e6, 9e6].map(|x| Dot { place: [x, 0.0, 0.0], ..DOTS[0] });
    let scene = load(pcd("binary", &far)).unwrap();
    assert!(scene.casters().check().is_ok());
    assert!(scene.particles.iter().all(|particle| particle.radius == 1e7));
    // A material's own radius takes precedence.
    let folder = Folder::new();
    folder.write("a.pcd", pcd("binary", &grid));
    let text = "[[material]]\nname = \"m\"\nradius = 0.125\n[[particles]]\nfile = \"a.pcd\"\n\
        material = \"m\"\n";
    let scene = scene::load(&folder.write("s.toml", text)).unwrap();
    assert!(scene.particles.iter().all(|particle| particle.radius == 0.125));
}

#[test]
fn files_that_lie_are_refused() {
    let with = |mut file: Vec<u8>, at: usize, bytes: &[u8]| {
        file[at..at + bytes.len()].copy_from_slice(bytes);
        refusal(file)
    };
    let plain = || las(2, &DOTS, [0.0; 3], 257);
    for (text, words) in [
        (with(plain(), 107, &[5]), "ends in point 5 of 5"),
        (with(plain(), 107, &u32::MAX.to_le_bytes()), "4294967295 points"),
        (with(plain(), 24, &[2]), "is LAS 2.2"),
        (with(plain(), 104, &[9]), "format 9 with 26 bytes"),
        (with(plain(), 96, &u32::MAX.to_le_bytes()), "ends in point 1 of 4"),
        (with(laz(2, &DOTS, [0.0; 3]), 107, &u32::MAX.to_le_bytes()), "4294967295 particles"),
        (with(laz(2, &DOTS, [0.0; 3]), 100, &[1]), "no record of LASzip"),
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    // Sizes of layers stand behind a chunk's first record: a gigabyte of them is not allocated.
    let (packed, tree) = (laz(7, &DOTS, [0.0; 3]), copc(&[&DOTS[..1], &DOTS[1..]]));
    for file in [packed, tree] {
        let start = u32::from_le_bytes(std::array::from_fn(|i| file[96 + i])) as usize;
        let text = with(file, start + 8 + 36 + 4 + 4, &(1_u32 << 30).to_le_bytes());
        assert!(text.contains("ends in its layers"), "{text}");
    }
    let text = String::from_utf8(pcd("ascii", &DOTS)).unwrap();
    for (from, to, words) in [
        ("POINTS 4", "POINTS 9", "WIDTH times HEIGHT"),
        ("WIDTH 4", "WIDTH 5", "WIDTH times HEIGHT"),
        ("FIELDS x", "FIELDS w", "no column `x`"),
        ("SIZE 4", "SIZE 3", "size of `x`"),
        ("DATA ascii", "DATA text", "DATA `text`"),
        ("\n1 0 0", "\none 0 0", "`one` is not a number"),
        ("\n1 0 0", "\n1 0", "7 numbers, not 8"),
    ] {
        let found = refusal(text.replacen(from, to, 1));
        assert!(found.contains(words), "{words}: {found}");
    }
    let many = text.replace("WIDTH 4", "WIDTH 4000000000").replace("POINTS 4", "POINTS 4000000000");
    assert!(refusal(many).contains("long enough for"));
}

/// Each prefix, and files with changed bytes: refused, or read without a panic.
#[test]
fn damaged_files_do_not_panic() {
    let files = [
        las(2, &DOTS, [0.0; 3], 257),
        las(7, &DOTS, [0.0; 3], 257),
        laz(3, &DOTS, [0.0; 3]),
        laz(7, &DOTS, [0.0; 3]),
        pcd("binary", &DOTS),
        pcd("binary_compressed", &DOTS),
        e57(&DOTS),
    ];
    let mut chance = Chance::new(5);
    for (which, file) in files.iter().enumerate() {
        for length in (0..file.len()).step_by(7) {
            // LAZ of one chunk is whole before its table.
            assert!(load(&file[..length]).is_err(), "file {which}, {length} of {}", file.len());
        }
        for _ in 0..150 {
            let mut changed = file.clone();
            for _ in 0..=chance.bits() % 3 {
                let at = (chance.bits() % file.len() as u64) as usize;
                changed[at] = chance.bits() as u8;
            }
            let _ = load(&changed);
        }
    }
}
