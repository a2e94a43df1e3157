//! Sequences: a frame is the same alone and among others, and all make one animated picture.
use super::commands::Folder;
use std::fs;

const SCENE: &str = "[camera]\neye = [0, 2, 6]\ntarget = [0, 0.5, 0]\nsize = [48, 32]\n[shadow]\nsize = 64\n\
    [[material]]\nname = 'ground'\ntransfer = 'opaque'\n[[material]]\nname = 'glass'\n\
    tint = [0.9, 0.2, 0.1, 0.8]\n\
    [[shape]]\nkind = 'plane'\nmaterial = 'ground'\nscale = [9, 1, 9]\n\
    [[shape]]\nname = 'pane'\nkind = 'pane'\nmaterial = 'glass'\n\
    [[animate]]\ntarget = 'shape.pane.translation'\ntimes = [0, 1]\nvalues = [[-2, 1, 0], [2, 1, 0]]\n\
    [[animate]]\ntarget = 'material.glass.tint'\ntimes = [0, 1]\n\
    values = [[1, 0, 0, 1], [0, 0, 1, 0.5]]\nmode = 'smooth'\n\
    [[animate]]\ntarget = 'light.sun.direction'\ntimes = [0, 1]\nvalues = [[1, -1, 0], [-1, -1, 0]]\n\
    [[animate]]\ntarget = 'camera.eye'\ntimes = [0, 1]\nvalues = [[0, 2, 6], [1, 3, 5]]\n\
    [[emitter]]\nmaterial = 'glass'\nrate = 400\nlifetime = 0.5\nstart = -1\nspread = 1\n\
    extent = [2, 1, 2]\nshape = 'box'\n\
    drag = 1\nturbulence = 3\n";

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    fs::write(folder.0.join("moving.toml"), SCENE).unwrap();
    folder
}

#[test]
fn a_frame_alone_is_that_of_the_sequence() {
    let folder = folder("alone");
    assert_alone(&folder, "cpu", "auto", "cpu");
    // Frame 6 of 8 a second is frame 3 of 4.
    folder.run(&[
        "render",
        "moving.toml",
        "--backend",
        "cpu",
        "--frame",
        "6",
        "--fps",
        "8",
        "-o",
        "fast",
    ]);
    let fast = fs::read(folder.0.join("fast/frame_0006.png")).unwrap();
    assert!(fast == fs::read(folder.0.join("cpu-one/frame_0003.png")).unwrap());
    for rate in ["0", "-1", "many", "nan", "1e9"] {
        let refused = folder.gobo(&["render", "moving.toml", &format!("--fps={rate}")]);
        assert_eq!(refused.status.code(), Some(2), "{rate}");
    }
}

#[test]
#[ignore = "kernels in four processes: make test-all"]
fn a_frame_alone_of_the_kernels_is_that_of_the_sequence() {
    let folder = folder("alone-kernels");
    assert_alone(&folder, "auto", "cpu", "gpu");
    assert_alone(&folder, "auto", "device", "device");
}

fn assert_alone(folder: &Folder, backend: &str, simulation: &str, name: &str) {
    let render = |more: &[&str]| folder.run(&[&["render", "moving.toml"], more].concat());
    let (all, one) = (format!("{name}-all"), format!("{name}-one"));
    let by = ["--backend", backend, "--simulation", simulation];
    render(&[&by[..], &["--frames=0..4", "--fps", "4", "-o", &all]].concat());
    render(&[&by[..], &["--frame", "3", "--fps", "4", "-o", &one]].concat());
    let read = |dir: &str, frame: u32| {
        fs::read(folder.0.join(dir).join(format!("frame_{frame:04}.png"))).unwrap()
    };
    assert!(read(&all, 3) == read(&one, 3), "{name}");
    assert!(read(&all, 3) != read(&all, 0), "{name}: nothing moves");
}

#[test]
fn emitters_are_simulated_where_the_user_says() {
    let folder = folder("simulation");
    let json = |simulation: &str| -> serde_json::Value {
        let by = ["render", "moving.toml", "--frame", "9", "--json", "--simulation", simulation];
        serde_json::from_str(&folder.run(&by)).unwrap()
    };
    let [on_cpu, on_device] = ["cpu", "device"].map(json);
    assert!(on_cpu["casters"].as_u64() > Some(190));
    assert_eq!(on_cpu["casters"], on_device["casters"]);
    assert_eq!(on_cpu["skipped"], on_device["skipped"]);
    assert!(on_cpu["stages"]["simulate"].is_null() && on_cpu["bytes"]["emitted"].is_null());
    assert!(on_device["stages"]["simulate"].is_f64());
    assert!(on_device["bytes"]["emitted"].as_u64() >= Some(200 * 32));
    // A software adapter is faster with many steps.
    let auto = |lifetime: &str| -> serde_json::Value {
        let set = format!("emitter.0.lifetime={lifetime}");
        let by = ["render", "moving.toml", "--json", "--set", "emitter.0.rate=5000", "--set", &set];
        serde_json::from_str(&folder.run(&by)).unwrap()
    };
    assert!(auto("0.5")["stages"]["simulate"].is_null());
    assert!(auto("10")["stages"]["simulate"].is_f64());
    let by = ["render", "moving.toml", "--backend", "cpu", "--simulation", "device"];
    assert!(folder.fail(&by, 2).contains("--simulation"));
    // Emitters that stay on the CPU are reported.
    let fluid = format!("{SCENE}fluid = {{ spacing = 0.2 }}\n");
    fs::write(folder.0.join("fluid.toml"), fluid).unwrap();
    let said = |simulation: &str| {
        let by = ["render", "fluid.toml", "-o", "fluid", "--simulation", simulation];
        let output = folder.gobo(&by);
        assert_eq!(output.status.code(), Some(0));
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(
        said("device").contains("emitter 0 is simulated on the CPU: its particles are a fluid")
    );
    assert!(!said("cpu").contains("emitter"));
}

#[test]
fn a_preview_holds_all_frames_or_is_not_there() {
    let folder = folder("preview");
    let job = ["render", "moving.toml", "--backend", "cpu", "--frames=0..5", "--fps=12.5"];
    let with = [&job[..], &["--preview", "moving.png", "--skip-existing"]].concat();
    folder.run(&with);
    let path = folder.0.join("moving.png");
    let first = fs::read(&path).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&first)).read_info().unwrap();
    let animation = *reader.info().animation_control().expect("it is animated");
    assert_eq!((animation.num_frames, animation.num_plays), (5, 0));
    for frame in 0..5 {
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        let control = reader.info().frame_control().unwrap();
        let delay = f64::from(control.delay_num) / f64::from(control.delay_den);
        assert!((delay - 0.08).abs() < 1e-4, "{delay}");
        let file = folder.0.join(format!("out/frame_{frame:04}.png"));
        assert_eq!(pixels, image::open(file).unwrap().into_rgb8().into_raw(), "{frame}");
    }
    // Frames that exist already count, too.
    fs::remove_file(&path).unwrap();
    folder.run(&with);
    assert_eq!(fs::read(&path).unwrap(), first);
    // A frame that cannot be made is missing.
    fs::remove_file(&path).unwrap();
    fs::create_dir(folder.0.join("blocked")).unwrap();
    fs::create_dir(folder.0.join("blocked/frame_0003.png")).unwrap();
    let failed = [&job[..], &["-o", "blocked", "--preview", "moving.png"]].concat();
    assert_eq!(folder.gobo(&failed).status.code(), Some(1));
    assert!(!path.exists());
    let shard = [&job[..], &["--shard", "0/2", "--preview", "moving.png"]].concat();
    assert_eq!(folder.gobo(&shard).status.code(), Some(2));
}
