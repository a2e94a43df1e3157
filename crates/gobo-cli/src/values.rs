//! Values of arguments.
use clap::{Args, ValueEnum};
use gobo::gpu::Backend;
use gobo_picture::{Renderer, picture::debug::DebugMode};
use gobo_scene::Share;
use std::{ops::Range, str::FromStr};

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum BackendName {
    Auto,
    Vulkan,
    Metal,
    Dx12,
    Gl,
    Cpu,
}

impl From<BackendName> for Backend {
    fn from(name: BackendName) -> Self {
        match name {
            BackendName::Auto => Self::Auto,
            BackendName::Vulkan => Self::Vulkan,
            BackendName::Metal => Self::Metal,
            BackendName::Dx12 => Self::Dx12,
            BackendName::Gl => Self::Gl,
            BackendName::Cpu => Self::Cpu,
        }
    }
}

// Options shared by several commands: a doc comment would replace the command's help.
#[derive(Clone, Debug, Args)]
pub(crate) struct DeviceArguments {
    /// The interface to the hardware
    #[arg(long, default_value = "auto")]
    backend: BackendName,
    /// Part of the adapter's name, as `gobo info` prints it
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
}

impl DeviceArguments {
    pub(crate) fn renderer(&self) -> Result<Renderer, gobo::Error> {
        Renderer::new(self.backend(), self.adapter.as_deref())
    }

    pub(crate) fn backend(&self) -> Backend {
        self.backend.into()
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SimulationName {
    Auto,
    Device,
    Cpu,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum DebugName {
    /// Lights of the cluster that each pixel is in
    Clusters,
    /// Pairs that each pixel walked, and lights that it evaluated
    Cost,
    /// The cascade that each pixel's surface is in
    Cascades,
    /// The maps of all views as they are packed
    Atlas,
    /// The shadow masks of the picture, if the scene has a `[mask]`
    Masks,
}

impl From<DebugName> for DebugMode {
    fn from(name: DebugName) -> Self {
        match name {
            DebugName::Clusters => Self::Clusters,
            DebugName::Cost => Self::Cost,
            DebugName::Cascades => Self::Cascades,
            DebugName::Atlas => Self::Atlas,
            DebugName::Masks => Self::Masks,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Target {
    Spirv,
    Hlsl,
    Msl,
    Glsl,
    Wgsl,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Frames(pub(super) Range<u32>);

impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("{text:?} is not a range of frames such as 0..24");
        let (start, end) = text.split_once("..").ok_or_else(expected)?;
        let range = start.parse().map_err(|_| expected())?..end.parse().map_err(|_| expected())?;
        if range.is_empty() {
            return Err(format!("{text} holds no frame: the end is not part of the range"));
        }
        Ok(Self(range))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shard {
    pub(super) index: u32,
    pub(super) count: u32,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("{text:?} is not a shard such as 0/4");
        let (index, count) = text.split_once('/').ok_or_else(expected)?;
        let index = index.parse().map_err(|_| expected())?;
        let count = count.parse().map_err(|_| expected())?;
        if index >= count {
            return Err(format!(
                "shard {text}: the shards are 0/{count} up to, but not {count}/{count}"
            ));
        }
        Ok(Self { index, count })
    }
}

pub(super) fn share(text: &str) -> Result<Share, String> {
    let Shard { index, count } = text.parse()?;
    Share::new(index, count).ok_or_else(|| format!("{text:?} is not a share such as 0/4"))
}

pub(super) fn frame_rate(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(rate) if (0.001..=1000.0).contains(&rate) => Ok(rate),
        _ => Err(format!("{text:?} is not a number of frames a second, 0.001 to 1000")),
    }
}

pub(super) fn key_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => {
            Ok((key.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err(format!("{text:?} is not KEY=VALUE, such as shadow.size=512")),
    }
}
