//! Command line arguments.
use super::{
    bench::BenchArguments,
    values::{
        DebugName, DeviceArguments, Frames, Shard, SimulationName, Target, frame_rate, key_value,
        share,
    },
};
use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use gobo_picture::picture::debug::DebugMode;
use gobo_scene::{Scene, Share};
use std::{ops::Range, path::PathBuf};

/// Coloured translucent shadows by compute shaders alone
#[derive(Debug, Parser)]
#[command(name = "gobo", version, arg_required_else_help = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene's frames, and its shadow maps
    Render(RenderArguments),
    /// Show a scene in a window, and again whenever its files change
    View(ViewArguments),
    /// Measure the shadow maps, also against the raster pipeline
    Bench(BenchArguments),
    /// Read and validate a scene; no GPU is touched
    Check {
        /// A scene file, or any other file that `gobo info --formats` lists
        scene: PathBuf,
    },
    /// Write a scene with all files that it names as one archive, for other machines
    Pack {
        /// A scene file, or any other file that `gobo info --formats` lists
        scene: PathBuf,
        /// The archive to write
        #[arg(short, value_name = "SCENE.zip")]
        out: PathBuf,
    },
    /// Look up the share of each light that reaches each of some points
    Light(LightArguments),
    /// Render the shadow maps of a share of a scene's casters, as a part for `gobo merge`
    Maps(MapsArguments),
    /// Join the parts of all shares: writes what `gobo render --maps` writes
    Merge {
        /// The files that `gobo maps` wrote, one of each share, in any order
        #[arg(required = true, value_name = "PART.gobo")]
        parts: Vec<PathBuf>,
        /// The folder to write to
        #[arg(short, default_value = "out", value_name = "DIR")]
        out: PathBuf,
    },
    /// Multiply the colours of splats by the light that reaches them in a scene
    Relight(RelightArguments),
    /// Tell which frames of a folder are missing or damaged, by what --skip-existing wrote
    Verify {
        /// The folder that frames were rendered to
        dir: PathBuf,
    },
    /// List the adapters, their limits, and the tier that each would run
    Info(InfoArguments),
    /// Write the kernels and a manifest for engines without wgpu
    Export {
        /// The shading language
        #[arg(long)]
        target: Target,
        /// The folder to write to
        #[arg(short)]
        out: PathBuf,
        /// Also write what a frame of a scene uploads, and its maps: to check an engine against
        #[arg(long, value_name = "SCENE")]
        scene: Option<PathBuf>,
        /// Replace a value of that scene file: shadow.size=512
        #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value, requires = "scene")]
        set: Vec<(String, String)>,
    },
    /// Print the manual's page, or write a page for each command
    Man {
        /// The folder to write all pages to
        #[arg(short, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Print a script by which a shell completes the command line
    Completions {
        /// The shell
        shell: Shell,
    },
}

// A scene at a time: a doc comment would replace the command's help.
#[derive(Debug, Args)]
pub(crate) struct MomentArguments {
    /// The time, as that of a frame
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) frame: u32,
    /// Frames of a second: frame N is N/F s from the start
    #[arg(long, value_name = "F", default_value_t = Scene::FRAME_RATE, value_parser = frame_rate)]
    pub(crate) fps: f64,
    #[command(flatten)]
    pub(crate) device: DeviceArguments,
    /// Replace a value of the scene file: shadow.size=512
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub(crate) set: Vec<(String, String)>,
}

#[derive(Debug, Args)]
pub(crate) struct RenderArguments {
    /// A scene file, or any other file that `gobo info --formats` lists
    pub(crate) scene: PathBuf,
    /// The folder to write to
    #[arg(short, default_value = "out", value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Frames from A up to, but not including, B
    #[arg(long, value_name = "A..B", conflicts_with = "frame")]
    frames: Option<Frames>,
    /// One frame
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..i64::from(u32::MAX)))]
    frame: Option<u32>,
    /// Only each of those frames i with i mod N = I
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Frames of a second: frame N is N/F s from the start
    #[arg(long, value_name = "F", default_value_t = Scene::FRAME_RATE, value_parser = frame_rate)]
    pub(crate) fps: f64,
    /// Also write the frames as one animated PNG or, by ffmpeg, .mp4, when all are there
    #[arg(long, value_name = "FILE", conflicts_with = "shard")]
    pub(crate) preview: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) device: DeviceArguments,
    /// Where the particles of emitters are simulated: `device` keeps them there, `cpu` gives the same
    /// frames on every machine, `auto` is `device` on a GPU, and on a software adapter where steps are many
    #[arg(long, default_value = "auto")]
    pub(crate) simulation: SimulationName,
    /// Write the shadow maps too
    #[arg(long)]
    pub(crate) maps: bool,
    /// Write the linear light too, before exposure and tone curve, as `OpenEXR`
    #[arg(long)]
    pub(crate) exr: bool,
    /// Write layers of the same file for compositors, too: what each light adds, its shadows, albedo, normal,
    /// depth, motion and numbers of objects and materials
    #[arg(long, requires = "exr")]
    pub(crate) layers: bool,
    /// A model or particle file by itself gets no floor
    #[arg(long)]
    pub(crate) no_ground: bool,
    /// Also draw a debug picture
    #[arg(long, value_name = "MODE")]
    pub(crate) debug: Vec<DebugName>,
    /// Replace a value of the scene file: shadow.size=512
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub(crate) set: Vec<(String, String)>,
    /// Skip frames that are there already, whole and of the same scene and options; writes a sidecar,
    /// `frame_0000.json`, beside each to tell
    #[arg(long)]
    pub(crate) skip_existing: bool,
    /// Print one line of JSON a frame
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct ViewArguments {
    /// A scene file, or any other file that `gobo info --formats` lists
    pub(crate) scene: PathBuf,
    /// Both receivers side by side: the nearest depth, and the curve
    #[arg(long)]
    pub(crate) beside: bool,
    /// Where a scene that moves stands at first [s]
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    pub(crate) time: f64,
    /// Play it
    #[arg(long)]
    pub(crate) play: bool,
    /// Each light's share at a place of the picture, right and down from its corner, 0 to 1
    #[arg(long, value_names = ["X", "Y"], num_args = 2)]
    pub(crate) pick: Vec<f32>,
    /// The window [points]
    #[arg(long, value_names = ["WIDTH", "HEIGHT"], num_args = 2, default_values_t = [1280.0, 800.0])]
    pub(crate) size: Vec<f32>,
    /// Pixels of the picture to one of the window, along an edge
    #[arg(long, default_value_t = 1.0)]
    pub(crate) scale: f32,
    #[command(flatten)]
    pub(crate) device: DeviceArguments,
    /// Replace a value of the scene file: shadow.size=512
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub(crate) set: Vec<(String, String)>,
    /// Write the window as a PNG file after the last of --frames, and close it
    #[arg(long, value_name = "FILE")]
    pub(crate) screenshot: Option<PathBuf>,
    /// Pictures before the screenshot
    #[arg(long, value_name = "N", default_value_t = 1, requires = "screenshot")]
    pub(crate) frames: u32,
    /// How far the camera turns before the last of them [degrees]
    #[arg(
        long,
        value_name = "DEGREES",
        default_value_t = 0.0,
        allow_hyphen_values = true,
        requires = "screenshot"
    )]
    pub(crate) orbit: f32,
}

#[derive(Debug, Args)]
pub(crate) struct InfoArguments {
    /// A file that is read: what is in it, instead of adapters
    #[arg(conflicts_with_all = ["tries", "formats", "backend", "adapter"])]
    pub(crate) file: Option<PathBuf>,
    /// List the kinds of files that are read
    #[arg(long, conflicts_with_all = ["tries", "backend", "adapter"])]
    pub(crate) formats: bool,
    /// Render a small scene, and say whether its maps and picture are those of the CPU reference
    #[arg(long = "try")]
    pub(crate) tries: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) device: DeviceArguments,
}

#[derive(Debug, Args)]
pub(crate) struct LightArguments {
    /// A scene file, or any other file that `gobo info --formats` lists
    pub(crate) scene: PathBuf,
    /// `NumPy` array of 32-bit floats: N x 3 positions [m], or N x 6 positions and unit normals
    #[arg(long, value_name = "P.npy")]
    pub(crate) points: PathBuf,
    /// The array to write: N x lights x 3 shares, 1 where nothing is between
    #[arg(short, value_name = "L.npy")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) moment: MomentArguments,
}

#[derive(Debug, Args)]
pub(crate) struct MapsArguments {
    /// A scene file, or any other file that `gobo info --formats` lists
    pub(crate) scene: PathBuf,
    /// Only every N-th share of the casters that filter light; those that block it are in all shares
    #[arg(long, value_name = "I/N", default_value = "0/1", value_parser = share)]
    pub(crate) casters: Share,
    /// The part to write
    #[arg(short, value_name = "PART.gobo")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) moment: MomentArguments,
}

#[derive(Debug, Args)]
pub(crate) struct RelightArguments {
    /// A file of splats; if the scene names it, placed and casting as there, otherwise as it is
    pub(crate) splats: PathBuf,
    /// A .toml file with lights and casters
    #[arg(long)]
    pub(crate) scene: PathBuf,
    /// The file of splats to write, .ply or .spz
    #[arg(short, value_name = "OUT")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) moment: MomentArguments,
}

impl Command {
    /// Whether the command opens a device.
    pub(crate) fn opens_a_device(&self) -> bool {
        match self {
            Self::Render(_)
            | Self::View(_)
            | Self::Bench(_)
            | Self::Light(_)
            | Self::Maps(_)
            | Self::Relight(_)
            | Self::Info(_) => true,
            Self::Export { scene, .. } => scene.is_some(),
            Self::Check { .. }
            | Self::Pack { .. }
            | Self::Merge { .. }
            | Self::Verify { .. }
            | Self::Man { .. }
            | Self::Completions { .. } => false,
        }
    }
}

impl RenderArguments {
    /// Debug modes without repetitions, in order.
    pub(crate) fn debug(&self) -> Vec<DebugMode> {
        let mut modes: Vec<DebugMode> = Vec::new();
        for mode in self.debug.iter().map(|&name| name.into()) {
            if !modes.contains(&mode) {
                modes.push(mode);
            }
        }
        modes
    }

    /// Frames of all shards; frame 0 if none are given.
    pub(crate) fn all_frames(&self) -> Range<u32> {
        match (&self.frames, self.frame) {
            (Some(Frames(range)), _) => range.clone(),
            (None, Some(frame)) => frame..frame.saturating_add(1),
            (None, None) => 0..1,
        }
    }

    /// The frames of this shard, ascending.
    pub(crate) fn frames(&self) -> std::iter::StepBy<Range<u32>> {
        let Range { start, end } = self.all_frames();
        let Shard { index, count } = self.shard.unwrap_or(Shard { index: 0, count: 1 });
        // Distance of the shard's first frame from `start`.
        let skip =
            (u64::from(index) + u64::from(count) - u64::from(start % count)) % u64::from(count);
        let first = u64::from(start).saturating_add(skip).min(u64::from(end)) as u32;
        (first..end).step_by(count as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(arguments: &[&str]) -> Option<Vec<u32>> {
        let all = ["gobo", "render", "scene.toml"].iter().chain(arguments);
        match Arguments::try_parse_from(all).ok()?.command {
            Command::Render(render) => Some(render.frames().collect()),
            _ => None,
        }
    }

    #[test]
    fn shards_part_the_frames() {
        assert_eq!(frames(&[]).unwrap(), [0]);
        assert_eq!(frames(&["--frame", "7"]).unwrap(), [7]);
        assert_eq!(frames(&["--frames", "2..5"]).unwrap(), [2, 3, 4]);
        let shards = ["0/3", "1/3", "2/3"]
            .map(|shard| frames(&["--frames", "4..12", "--shard", shard]).unwrap());
        assert_eq!(shards, [vec![6, 9], vec![4, 7, 10], vec![5, 8, 11]]);
        assert!(frames(&["--frame", "1", "--shard", "0/2"]).unwrap().is_empty());
        let last = ["--frames", "4294967290..4294967295", "--shard", "4294967293/4294967294"];
        assert_eq!(frames(&last).unwrap(), [4_294_967_293]);
    }

    #[test]
    fn nonsense_is_refused() {
        for bad in [
            ["--frames", "3..3"],
            ["--frames", "5"],
            ["--frames", "a..b"],
            ["--frame", "-1"],
            ["--shard", "2/2"],
            ["--shard", "0/0"],
            ["--shard", "1"],
            ["--set", "novalue"],
            ["--set", "=1"],
            ["--backend", "cuda"],
            ["--debug", "everything"],
        ] {
            assert_eq!(frames(&bad), None, "{bad:?}");
        }
    }
}
