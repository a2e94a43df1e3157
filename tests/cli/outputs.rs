//! Behaviour of all commands towards the files, devices and pipes that they write.
use super::{
    commands::{Folder, files},
    hostile::ends,
    light::array,
    pack,
};
use crate::common::splats;
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
};

/// An output of a command.
pub(super) struct Case {
    /// Arguments; `OUT` is the file or folder.
    pub(super) arguments: &'static [&'static str],
    /// Ending of a file's name, or the file in a folder.
    file: Name,
    /// A file that it reads.
    input: Option<&'static str>,
    /// Whether two runs write the same bytes.
    repeats: bool,
}

enum Name {
    Ends(&'static str),
    InFolder(&'static str),
}

const CPU: [&str; 2] = ["--backend", "cpu"];

/// All outputs except those of `export`, which takes seconds.
pub(super) const CASES: [Case; 10] = [
    Case {
        arguments: &["light", "scene.toml", "--points", "p.npy", "-o", "OUT", CPU[0], CPU[1]],
        file: Name::Ends(".npy"),
        input: Some("p.npy"),
        repeats: true,
    },
    Case {
        arguments: &["maps", "scene.toml", "-o", "OUT", CPU[0], CPU[1]],
        file: Name::Ends(".gobo"),
        input: Some("scene.toml"),
        repeats: true,
    },
    Case {
        arguments: &["pack", "scene.toml", "-o", "OUT"],
        file: Name::Ends(".zip"),
        input: Some("scene.toml"),
        repeats: true,
    },
    Case {
        arguments: &["relight", "s.ply", "--scene", "scene.toml", "-o", "OUT", CPU[0], CPU[1]],
        file: Name::Ends(".ply"),
        input: Some("s.ply"),
        repeats: true,
    },
    Case {
        arguments: &["bench", "--scene", "scene.toml", "--runs", "1", "--json", "OUT"],
        file: Name::Ends(".json"),
        input: Some("scene.toml"),
        repeats: false,
    },
    Case {
        arguments: &["bench", "--splats", "s.ply", "--size", "64", "--runs", "1", "--html", "OUT"],
        file: Name::Ends(".html"),
        input: Some("s.ply"),
        repeats: false,
    },
    Case {
        arguments: &["render", "scene.toml", CPU[0], CPU[1], "--preview", "OUT"],
        file: Name::Ends(".png"),
        input: Some("scene.toml"),
        repeats: true,
    },
    Case {
        arguments: &["render", "scene.toml", CPU[0], CPU[1], "--maps", "-o", "OUT"],
        file: Name::InFolder("maps/frame_0000/views.json"),
        input: Some("scene.toml"),
        repeats: true,
    },
    Case {
        arguments: &["merge", "part.gobo", "-o", "OUT"],
        file: Name::InFolder("maps/frame_0000/views.json"),
        input: Some("part.gobo"),
        repeats: true,
    },
    Case {
        arguments: &["man", "-o", "OUT"],
        file: Name::InFolder("gobo.1"),
        input: None,
        repeats: true,
    },
];

const EXPORT: Case = Case {
    arguments: &["export", "--target", "wgsl", "--scene", "scene.toml", "-o", "OUT"],
    file: Name::InFolder("frame.json"),
    input: Some("scene.toml"),
    repeats: true,
};

/// Commands that write only to their streams.
const READERS: [&str; 4] = ["check", "verify", "info", "completions"];

/// Options whose value is no output.
const VALUES: &str = "--against --limit --frames --frame --shard --fps --backend --adapter --simulation \
    --debug --set --points --casters \
    --scene --target --splats --footprint --opacity --shape --case --layout --lights --size --vs \
    --stage --receiver \
    --nodes --runs --pair-budget --time --pick --scale --orbit";

/// Command and option of an output that needs a screen: `make view-test` tests it.
const ON_A_SCREEN: (&str, &str) = ("view", "--screenshot");

impl Case {
    fn command(&self) -> &'static str {
        self.arguments[0]
    }

    /// Path of the checked file, for an output in `root`.
    pub(super) fn path(&self, root: &Path) -> PathBuf {
        match self.file {
            Name::Ends(end) => root.join(format!("out{end}")),
            Name::InFolder(name) => root.join("out").join(name),
        }
    }

    /// A run in `folder` with the output in `root`.
    pub(super) fn run(&self, folder: &Folder, root: &Path) -> Command {
        let out = match self.file {
            Name::Ends(_) => self.path(root),
            Name::InFolder(_) => root.join("out"),
        };
        let out = out.display().to_string();
        let arguments = self.arguments.iter().map(|&it| if it == "OUT" { &out } else { it });
        let mut command = Command::new(env!("CARGO_BIN_EXE_gobo"));
        command
            .args(arguments)
            .current_dir(&folder.0)
            .env_remove("GOBO_LOG")
            .env("TMPDIR", folder.0.join("tmp"))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }
}

/// A folder with the inputs of all cases; `root` is a folder of its own.
pub(super) fn folder(name: &str) -> (Folder, PathBuf) {
    let folder = Folder::new(name);
    let small = fs::read_to_string(folder.0.join("scene.toml")).unwrap();
    let small =
        small.replace("size = [40, 24]", "size = [16, 8]").replace("size = 32", "size = 16");
    fs::write(folder.0.join("scene.toml"), small).unwrap();
    fs::write(folder.0.join("p.npy"), array("<f4", 3, &[0; 24])).unwrap();
    fs::write(folder.0.join("s.ply"), splats::ply("ascii", &splats::SPLATS, 0)).unwrap();
    folder.run(&["maps", "scene.toml", "-o", "part.gobo", CPU[0], CPU[1]]);
    for dir in ["tmp", "o"] {
        fs::create_dir(folder.0.join(dir)).unwrap();
    }
    let root = folder.0.join("o");
    (folder, root)
}

fn wait(child: Child) -> String {
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    said
}

/// Commands, and options with a value, that are in no case or list.
#[test]
fn no_command_or_option_is_left_out() {
    let folder = Folder::new("outputs-all");
    let help = folder.run(&["--help"]);
    let (_, commands) = help.split_once("Commands:\n").unwrap();
    let (commands, _) = commands.split_once("\n\n").unwrap();
    let names = commands.lines().filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    let mut written = BTreeMap::from([(ON_A_SCREEN.0, vec![ON_A_SCREEN.1])]);
    for case in CASES.iter().chain([&EXPORT]) {
        let at = case.arguments.iter().position(|&it| it == "OUT").unwrap();
        written.entry(case.command()).or_default().push(case.arguments[at - 1]);
    }
    for name in names.filter(|name| !["help", ""].contains(name)) {
        assert!(written.contains_key(name) || READERS.contains(&name), "{name} is in no list");
        let help = folder.run(&[name, "--help"]);
        let options = help.lines().map(str::trim).filter(|line| line.starts_with('-'));
        for option in options.filter(|line| line.contains('<')) {
            let option = option.split(" <").next().unwrap().rsplit(", ").next().unwrap();
            let is_output = written.get(name).is_some_and(|all| all.contains(&option));
            let is_value = VALUES.split_whitespace().any(|value| value == option);
            assert!(is_output || is_value, "{name} {option} is in no list");
        }
    }
}

/// A pipe receives the file's bytes and stays a pipe; a device stays a device.
#[cfg(unix)]
fn stays(case: &Case, folder: &Folder, root: &Path) {
    use std::os::unix::fs::FileTypeExt as _;
    let plain = root.join("plain");
    fs::create_dir(&plain).unwrap();
    wait(case.run(folder, &plain).spawn().unwrap());
    let expected = fs::read(case.path(&plain)).unwrap();
    assert!(!expected.is_empty());
    for (kind, make) in [("pipe", "mkfifo"), ("device", "mknod")] {
        for linked in [false, true] {
            let root = root.join(format!("{kind}-{linked}"));
            let path = case.path(&root);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            let node = if linked { root.join("node") } else { path.clone() };
            let mut make = Command::new(make);
            make.arg(&node).stderr(Stdio::null());
            if kind == "device" {
                make.args(["c", "1", "3"]);
            }
            let is_made = make.status().unwrap().success();
            if kind == "device" && !(is_made && fs::File::options().write(true).open(&node).is_ok())
            {
                // Only users who may make devices can destroy them.
                continue;
            }
            if linked {
                std::os::unix::fs::symlink(&node, &path).unwrap();
            }
            let mut child = case.run(folder, &root).spawn().unwrap();
            if kind == "pipe" {
                let from = node.clone();
                let reader = std::thread::spawn(move || fs::read(from).unwrap());
                assert_eq!(ends(&mut child), Some(0), "{:?}", case.arguments);
                let is_pipe = fs::metadata(&node).unwrap().file_type().is_fifo();
                assert!(is_pipe, "{:?}: the pipe is gone", case.arguments);
                let found = reader.join().unwrap();
                let same = if case.repeats { found == expected } else { !found.is_empty() };
                assert!(same, "{:?}: {} bytes", case.arguments, found.len());
            } else {
                assert_eq!(ends(&mut child), Some(0), "{:?}", case.arguments);
                let kind = fs::metadata(&node).unwrap().file_type();
                assert!(kind.is_char_device(), "{:?}: the device is gone", case.arguments);
            }
            let is_link = fs::symlink_metadata(&path).unwrap().is_symlink();
            assert_eq!(is_link, linked, "{:?}", case.arguments);
        }
    }
    assert_eq!(files(&folder.0.join("tmp")), [""; 0]);
}

/// Processes that have the old file open keep it whole.
#[cfg(unix)]
#[test]
fn regular_files_are_replaced() {
    use std::os::unix::fs::MetadataExt as _;
    for (i, case) in CASES.iter().enumerate() {
        let (folder, root) = folder(&format!("outputs-replaced{i}"));
        let (path, old) = (case.path(&root), folder.0.join("old"));
        wait(case.run(&folder, &root).spawn().unwrap());
        fs::hard_link(&path, &old).unwrap();
        let before = fs::read(&old).unwrap();
        wait(case.run(&folder, &root).spawn().unwrap());
        let [new, kept] = [&path, &old].map(|path| fs::metadata(path).unwrap().ino());
        assert_ne!(new, kept, "{:?} writes into the file", case.arguments);
        assert!(fs::read(&old).unwrap() == before);
    }
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_are_written_into() {
    for (i, case) in CASES.iter().enumerate() {
        let (folder, root) = folder(&format!("outputs-nodes{i}"));
        stays(case, &folder, &root);
    }
}

/// The frame is written before the kernels, whose translation takes seconds.
#[cfg(unix)]
#[test]
fn an_exported_frame_is_written_into_a_pipe() {
    use std::os::unix::fs::FileTypeExt as _;
    let (folder, root) = folder("outputs-export");
    let path = EXPORT.path(&root);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
    let mut child = EXPORT.run(&folder, &root).stdout(Stdio::null()).spawn().unwrap();
    let text = fs::read_to_string(&path).unwrap();
    Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert_eq!(ends(&mut child), Some(1));
    assert!(text.starts_with('{') && text.ends_with('}'));
    assert!(fs::metadata(&path).unwrap().file_type().is_fifo());
    assert!(!files(&folder.0).iter().any(|name| name.ends_with(".tmp")));
}

/// An input is recognised by its name, by another path, by a hard link and by a symbolic one.
#[test]
fn a_commands_own_inputs_are_refused() {
    for (i, case) in CASES.iter().chain([&EXPORT]).enumerate() {
        let Some(input) = case.input else { continue };
        let (folder, root) = folder(&format!("outputs-inputs{i}"));
        let input = folder.0.join(input);
        let before = fs::read(&input).unwrap();
        for link in ["hard", "symbolic"] {
            let root = root.join(link);
            let path = case.path(&root);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            #[cfg(unix)]
            if link == "symbolic" {
                std::os::unix::fs::symlink(&input, &path).unwrap();
            }
            if !path.exists() {
                fs::hard_link(&input, &path).unwrap();
            }
            refuses(case.run(&folder, &root), &folder, [&path, &input]);
        }
        assert_eq!(fs::read(&input).unwrap(), before);
    }
    let (folder, _) = folder("outputs-names");
    let before = fs::read(folder.0.join("s.ply")).unwrap();
    for name in ["s.ply", "./s.ply", "o/../s.ply"] {
        let all = ["relight", "s.ply", "--scene", "scene.toml", "-o", name, CPU[0], CPU[1]];
        let error = folder.fail(&all, 2);
        assert!(error.contains(&format!("{name}: ")) && error.contains("help: "), "{error}");
    }
    assert_eq!(fs::read(folder.0.join("s.ply")).unwrap(), before);
}

/// The command ends with status 2, names both files, and writes nothing.
fn refuses(mut command: Command, folder: &Folder, both: [&Path; 2]) {
    let before = files(&folder.0);
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{command:?}: {said}");
    let [out, input] = both.map(|path| path.file_name().unwrap().to_str().unwrap());
    assert!(said.contains(out) && said.contains(input) && said.contains("help: "), "{said}");
    assert_eq!(files(&folder.0), before, "{command:?}");
}

/// Scenes name files of many kinds; those of models are named by the models.
#[test]
fn every_file_of_a_scene_is_an_input() {
    let folder = pack::folder("outputs-files");
    fs::create_dir(folder.0.join("o")).unwrap();
    // The model's image belongs to no material.
    let is_read = |name: &String| name.starts_with("in/") && !name.ends_with("an image.png");
    let inputs: Vec<_> = files(&folder.0).into_iter().filter(is_read).collect();
    assert_eq!(inputs.len(), 7);
    let before: Vec<_> = inputs.iter().map(|name| fs::read(folder.0.join(name)).unwrap()).collect();
    for input in &inputs {
        let all = ["maps", "in/scenes/own.toml", "-o", input, "--backend", "cpu"];
        let error = folder.fail(&all, 2);
        assert!(error.contains(&format!("{input}: is a file that this command reads")), "{error}");
    }
    // With `--set` a scene reads another file.
    fs::copy(folder.0.join("in/scenes/gel.png"), folder.0.join("other.png")).unwrap();
    let set = ["--set", "material.gel.texture=../../other.png", "--backend", "cpu"];
    let all = [&["maps", "in/scenes/own.toml", "-o", "other.png"][..], &set].concat();
    assert!(folder.fail(&all, 2).contains("other.png: is a file that this command reads"));
    let after: Vec<_> = inputs.iter().map(|name| fs::read(folder.0.join(name)).unwrap()).collect();
    assert!(before == after);
}

/// A link is as good as its target, even if nothing is there yet.
#[cfg(unix)]
#[test]
fn links_lead_to_what_is_written() {
    use std::os::unix::fs::symlink;
    let (folder, root) = folder("outputs-links");
    fs::create_dir(root.join("far")).unwrap();
    symlink("far/b.zip", root.join("a.zip")).unwrap();
    symlink("a.zip", root.join("c.zip")).unwrap();
    for _ in 0..2 {
        folder.run(&["pack", "scene.toml", "-o", "o/c.zip"]);
        assert!(fs::symlink_metadata(root.join("far/b.zip")).unwrap().is_file());
        assert!(fs::symlink_metadata(root.join("a.zip")).unwrap().is_symlink());
    }
    assert_eq!(files(&root), ["a.zip", "c.zip", "far/b.zip"]);
    for (name, why) in [("o", "is a directory"), ("o/none/a.zip", "No such file")] {
        let output = folder.gobo(&["pack", "scene.toml", "-o", name]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && said.contains(why), "{said}");
    }
}

/// An array is alone on standard output.
#[cfg(target_os = "linux")]
#[test]
fn standard_output_can_be_the_file() {
    let (folder, _) = folder("outputs-stdout");
    folder.run(&["pack", "scene.toml", "-o", "a.zip"]);
    // Through a link of its own: a program that replaces it does no harm.
    std::os::unix::fs::symlink("/proc/self/fd/1", folder.0.join("stdout")).unwrap();
    let output = folder.gobo(&["pack", "scene.toml", "-o", "stdout"]);
    assert!(output.stdout == fs::read(folder.0.join("a.zip")).unwrap());
}
