//! Why a command ended early, and its exit status.
use gobo::scene::SceneError;
use miette::Diagnostic as _;
use std::path::{Path, PathBuf};

#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Gpu(#[from] gobo::error::Error),
    #[error("{}: {source}", .path.display())]
    File { path: PathBuf, source: std::io::Error },
    #[error("{0}")]
    Usage(String),
    /// A benchmark whose maps are wrong.
    #[error("{0}")]
    Wrong(String),
    #[error("standard output: {0}")]
    Output(std::io::Error),
}

impl Failure {
    pub(crate) fn file(path: &Path, source: std::io::Error) -> Self {
        Self::File { path: path.to_owned(), source }
    }

    /// On stderr; of a scene file with the lines around the place and what to do.
    pub(crate) fn print(self) {
        eprintln!("gobo: {self}");
        if let Some(remedy) = self.remedy() {
            eprintln!("  help: {remedy}");
        }
        let Self::Scene(error) = self else { return };
        match (&error, error.help().map(|help| help.to_string())) {
            (SceneError::Document { .. }, _) => eprintln!("{:?}", miette::Report::new(error)),
            (_, Some(help)) => eprintln!("  help: {help}"),
            (_, None) => {}
        }
    }

    /// What the command line can do about it.
    fn remedy(&self) -> Option<&'static str> {
        use gobo::error::Error;
        match self {
            Self::Gpu(Error::Adapter { found, .. }) if !found.is_empty() => {
                Some("`gobo info` lists the adapters; --backend cpu renders without one")
            }
            Self::Gpu(Error::Adapter { .. } | Error::Device { .. } | Error::Limit { .. }) => {
                Some("--backend cpu renders without a GPU")
            }
            Self::Gpu(Error::Memory(_)) => {
                Some("--set shadow.size=512 takes less memory, --backend cpu none of the GPU's")
            }
            _ => None,
        }
    }

    /// 2: bad usage or input; 3: no usable adapter or device; 1: anything else.
    pub(crate) fn status(&self) -> u8 {
        use gobo::error::Error;
        match self {
            Self::Scene(_) | Self::Usage(_) => 2,
            Self::Gpu(Error::Adapter { .. } | Error::Device { .. } | Error::Limit { .. }) => 3,
            Self::Gpu(_) | Self::File { .. } | Self::Wrong(_) | Self::Output(_) => 1,
        }
    }
}
