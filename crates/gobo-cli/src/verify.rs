//! `gobo verify`: checks that all frames of a job exist, belong together and are unchanged.
use super::{
    failure::Failure,
    files::{self, entries},
    sidecar::{Sidecar, SidecarFault, frame_of, frame_of_any, maps, stem},
    values::DebugName,
};
use clap::ValueEnum as _;
use gobo_picture::picture::debug::DebugMode;
use std::{
    collections::{BTreeMap, BTreeSet, HashMap, HashSet},
    fs,
    path::Path,
};

/// Prints a line for each frame that must be rendered again, and one for each run of missing frames.
pub(crate) fn run(dir: &Path) -> Result<(), Failure> {
    let entries = entries(dir)?;
    let names: HashSet<&str> =
        entries.iter().filter_map(|path| path.file_name()?.to_str()).collect();
    let sidecars: BTreeMap<u32, Option<Sidecar>> = names
        .iter()
        .filter_map(|name| frame_of(name))
        .map(|frame| (frame, Sidecar::read(dir, frame)))
        .collect();
    let Some(job) = job(&sidecars) else {
        return Err(Failure::Wrong(format!(
            "{}: no frame has a sidecar; `gobo render --skip-existing` writes them",
            dir.display()
        )));
    };
    let of_job = sidecars.values().flatten().filter(|sidecar| identity(sidecar) == job);
    let ranges = of_job.map(|sidecar| sidecar.frames);
    let [first, end] =
        ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).expect("a job has a frame");
    // Frames to be rendered again, and files to be removed.
    let (mut bad, mut foreign) = (0_u64, 0_u64);
    let mut next = first;
    for (&frame, sidecar) in &sidecars {
        let is_asked = (first..end).contains(&frame);
        if is_asked {
            bad += missing(next, frame)?;
            next = frame + 1;
        }
        let problem = match sidecar {
            None => Some("has a damaged sidecar".to_owned()),
            Some(sidecar) if identity(sidecar) != job => {
                Some("is of another scene, other options or another version than most".to_owned())
            }
            Some(sidecar) => sidecar.faults(dir).next().map(|(name, fault)| match fault {
                SidecarFault::Missing => format!("lacks {name}"),
                SidecarFault::Damaged => format!("has a damaged {name}"),
            }),
        };
        if let Some(problem) = problem {
            files::print(&format!("frame {frame} {problem}"))?;
            *(if is_asked { &mut bad } else { &mut foreign }) += 1;
        } else if let Some(sidecar) = sidecar {
            for name in strays(dir, frame, sidecar, &names) {
                files::print(&format!("frame {frame} has {name} of another run"))?;
                foreign += 1;
            }
        }
    }
    bad += missing(next, end)?;
    let is_known = |frame: &u32| (first..end).contains(frame) || sidecars.contains_key(frame);
    for frame in pictured(dir, &names).into_iter().filter(|frame| !is_known(frame)) {
        for name in own(dir, frame, &names) {
            files::print(&format!("frame {frame} has {name} of another run"))?;
            foreign += 1;
        }
    }
    let count = end - first;
    if bad > 0 {
        return Err(Failure::Wrong(format!(
            "{bad} of {count} frames must be rendered again: the same `gobo render --skip-existing` \
             does that and leaves the others"
        )));
    }
    if foreign > 0 {
        return Err(Failure::Wrong(format!(
            "{foreign} files or frames are not of this job: remove them, or give each job its own folder"
        )));
    }
    files::print(&format!("{count} frames are whole"))
}

/// Frames of equal identity were made by the same version from the same inputs.
fn identity(sidecar: &Sidecar) -> (&str, &str) {
    (&sidecar.gobo, &sidecar.inputs)
}

/// Identity of most frames; in a tie, that of the first.
fn job(sidecars: &BTreeMap<u32, Option<Sidecar>>) -> Option<(&str, &str)> {
    let mut counts = HashMap::new();
    for (&frame, sidecar) in sidecars {
        if let Some(sidecar) = sidecar {
            counts.entry(identity(sidecar)).or_insert((0, std::cmp::Reverse(frame))).0 += 1;
        }
    }
    counts.into_iter().max_by_key(|&(_, count)| count).map(|(job, _)| job)
}

/// Reports missing frames up to `end`, and returns their number.
fn missing(first: u32, end: u32) -> Result<u64, Failure> {
    match end - first {
        0 => {}
        1 => files::print(&format!("frame {first} is missing"))?,
        _ => files::print(&format!("frames {first} to {} are missing", end - 1))?,
    }
    Ok(u64::from(end - first))
}

/// Frames with a file or a folder of maps.
fn pictured(dir: &Path, names: &HashSet<&str>) -> BTreeSet<u32> {
    // Without maps there is no such folder.
    let maps = fs::read_dir(dir.join("maps")).into_iter().flatten().flatten();
    let maps = maps.filter_map(|entry| frame_of_any(entry.file_name().to_str()?));
    names.iter().filter_map(|name| frame_of_any(name)).chain(maps).collect()
}

/// Files in a frame's places that it did not write.
fn strays(dir: &Path, frame: u32, sidecar: &Sidecar, names: &HashSet<&str>) -> Vec<String> {
    let mut strays = own(dir, frame, names);
    strays.retain(|name| !sidecar.names(name));
    strays
}

/// Files in a frame's places.
fn own(dir: &Path, frame: u32, names: &HashSet<&str>) -> Vec<String> {
    let stem = stem(frame);
    let modes = DebugName::value_variants().iter().map(|&mode| DebugMode::from(mode).name());
    let beside = modes.map(|mode| format!("{stem}.{mode}.png"));
    let beside = beside.chain(["exr", "png"].map(|end| format!("{stem}.{end}")));
    let mut own: Vec<String> = beside.filter(|name| names.contains(name.as_str())).collect();
    let folder = maps(frame);
    // A frame without maps has no such folder.
    let found = entries(&dir.join(&folder)).unwrap_or_default();
    let found = found.iter().filter_map(|path| path.file_name()?.to_str());
    own.extend(found.map(|name| format!("{folder}/{name}")));
    own.sort();
    own
}
