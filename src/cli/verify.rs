//! `gobo verify`: checks that all frames of a job exist and are as they were written.
use super::{
    failure::Failure,
    files::{self, entries},
    sidecar::{Fault, Sidecar, frame_of},
};
use std::{collections::BTreeMap, path::Path};

/// Prints a line for each frame that must be rendered again.
pub(crate) fn run(dir: &Path) -> Result<(), Failure> {
    let names = entries(dir)?;
    let names = names.iter().filter_map(|path| path.file_name()?.to_str());
    let sidecars: BTreeMap<u32, Option<Sidecar>> =
        names.filter_map(frame_of).map(|frame| (frame, Sidecar::read(dir, frame))).collect();
    let ranges = sidecars.values().flatten().map(|sidecar| sidecar.frames);
    let frames = ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let Some([first, end]) = frames else {
        return Err(Failure::Wrong(format!(
            "{}: no frame has a sidecar; `gobo render --skip-existing` writes them",
            dir.display()
        )));
    };
    let mut bad = 0;
    for frame in first..end {
        let problem = match sidecars.get(&frame) {
            None => Some("is missing".to_owned()),
            Some(None) => Some("has a damaged sidecar".to_owned()),
            Some(Some(sidecar)) => sidecar.faults(dir).next().map(|(name, fault)| match fault {
                Fault::Missing => format!("lacks {name}"),
                Fault::Damaged => format!("has a damaged {name}"),
            }),
        };
        if let Some(problem) = problem {
            files::print(&format!("frame {frame} {problem}"))?;
            bad += 1;
        }
    }
    let count = end - first;
    if bad > 0 {
        return Err(Failure::Wrong(format!(
            "{bad} of {count} frames must be rendered again: the same `gobo render --skip-existing` \
             does that and leaves the others"
        )));
    }
    files::print(&format!("{count} frames are whole"))
}
