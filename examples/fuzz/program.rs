//! Files that only the program reads: sidecars, by `gobo verify`, arrays of points, by `gobo light`, and
//! parts, by `gobo merge`.
use crate::{End, Outcome, cost::Clock};
use std::{
    env, fs,
    io::{self, Error},
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
};

/// A file in a folder that a command of the program reads.
pub(super) struct Program {
    gobo: PathBuf,
    folder: PathBuf,
    /// Name of the file in the folder.
    file: &'static str,
    arguments: &'static [&'static str],
    /// Whether the folder is checked for files other than the one that is read and the folder `joined`.
    is_confined: bool,
}

/// Names in a folder.
fn names(folder: &Path) -> io::Result<Vec<String>> {
    let name =
        |entry: io::Result<fs::DirEntry>| Ok(entry?.file_name().to_string_lossy().into_owned());
    fs::read_dir(folder)?.map(name).collect()
}

const SCENE: &str = "[[material]]\nname = 'm'\n[[shape]]\nkind = 'pane'\nmaterial = 'm'\n[[light]]\n\
    kind = 'spot'\nposition = [0, 3, 0]\ndirection = [0, -1, 0]\nangle = 40\n[camera]\nsize = [8, 4]\n\
    [shadow]\nsize = 16\n";

impl Program {
    /// Frames with sidecars, and the first sidecar.
    pub(super) fn of_sidecars(out: &Path) -> io::Result<(Self, Vec<Vec<u8>>)> {
        let program = Self::new(out.join("job"), "frame_0000.json", &["verify", "."])?;
        let job = [
            "render",
            "../scene.toml",
            "--backend",
            "cpu",
            "-o",
            ".",
            "--skip-existing",
            "--frames",
            "0..2",
        ];
        program.make(&job)?;
        let seed = fs::read(program.folder.join(program.file))?;
        Ok((program, vec![seed]))
    }

    /// Points, with normals and without.
    pub(super) fn of_points(out: &Path) -> io::Result<(Self, Vec<Vec<u8>>)> {
        let light =
            ["light", "../scene.toml", "--points", "p.npy", "-o", "l.npy", "--backend", "cpu"];
        let program = Self::new(out.join("points"), "p.npy", Box::leak(Box::new(light)))?;
        let array = |columns: usize| {
            let head =
                format!("{{'descr': '<f4', 'fortran_order': False, 'shape': (4, {columns}), }}");
            let head = format!("{head:<117}\n");
            let rows = (0..4 * columns).flat_map(|i| (i as f32 * 0.3).to_le_bytes());
            b"\x93NUMPY\x01\x00\x76\x00"
                .iter()
                .copied()
                .chain(head.into_bytes())
                .chain(rows)
                .collect()
        };
        Ok((program, vec![array(3), array(6)]))
    }

    /// A part with all casters. Joining it may write only to the folder `joined`.
    pub(super) fn of_parts(out: &Path) -> io::Result<(Self, Vec<Vec<u8>>)> {
        let mut program =
            Self::new(out.join("parts"), "p.gobo", &["merge", "p.gobo", "-o", "joined"])?;
        program.is_confined = true;
        let seed = |receiver: &str| {
            let receiver = format!("shadow.receiver='{receiver}'");
            let maps = ["maps", "../scene.toml", "--casters", "0/1", "-o", "p.gobo"];
            program.make(&[&maps[..], &["--backend", "cpu", "--set", &receiver]].concat())?;
            fs::read(program.folder.join(program.file))
        };
        let seeds = ["nearest", "curve"].map(seed).into_iter().collect::<io::Result<_>>()?;
        Ok((program, seeds))
    }

    fn new(
        folder: PathBuf,
        file: &'static str,
        arguments: &'static [&'static str],
    ) -> io::Result<Self> {
        // Beside this example's folder, unless GOBO names it.
        let beside = env::current_exe()?.with_file_name("gobo");
        let built = beside.parent().and_then(Path::parent).map(|folder| folder.join("gobo"));
        let named = env::var_os("GOBO").map(PathBuf::from);
        let gobo = named.or(built).ok_or_else(|| Error::other("GOBO must name the program"))?;
        let gobo = gobo.canonicalize().map_err(|error| {
            Error::other(format!("{}: {error}; build it first, or name it by GOBO", gobo.display()))
        })?;
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder)?;
        fs::write(folder.with_file_name("scene.toml"), SCENE)?;
        Ok(Self { gobo, folder, file, arguments, is_confined: false })
    }

    fn run(&self, arguments: &[&str]) -> io::Result<Output> {
        Command::new(&self.gobo)
            .args(arguments)
            .current_dir(&self.folder)
            .stdin(Stdio::null())
            .output()
    }

    fn make(&self, arguments: &[&str]) -> io::Result<()> {
        let output = self.run(arguments)?;
        let said = String::from_utf8_lossy(&output.stderr);
        if output.status.success() { Ok(()) } else { Err(Error::other(said.into_owned())) }
    }

    /// Whether the program accepts the file, or its fault: it must end with a status of its own, soon, and
    /// give a short reason.
    pub(super) fn read(&self, bytes: &[u8]) -> io::Result<Outcome> {
        fs::write(self.folder.join(self.file), bytes)?;
        let clock = Clock::start();
        let output = self.run(self.arguments)?;
        let took = clock.elapsed();
        let is_stray = |name: &str| ![self.file, "joined"].contains(&name);
        let strays = self.is_confined && names(&self.folder)?.iter().any(|name| is_stray(name));
        Ok(match output.status.code() {
            _ if strays => (Err("writes beside its folder"), took),
            _ if output.stdout.len() + output.stderr.len() > 1 << 16 => {
                (Err("says too much"), took)
            }
            Some(0) => (Ok(End::Used), took),
            Some(1 | 2) if !output.stdout.is_empty() || !output.stderr.is_empty() => {
                (Ok(End::Refused), took)
            }
            Some(1 | 2) => (Err("says nothing"), took),
            _ => (Err("panics or is killed"), took),
        })
    }
}
