//! Every key of scene files, with odd values.
use crate::{Outcome, cost::Clock, load};
use gobo_scene as scene;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs, io,
    path::{Path, PathBuf},
    time::Duration,
};

/// Values that fit no key: of another kind, at the ends of ranges or beyond, of another length.
const VALUES: [&str; 14] = [
    "0",
    "-1",
    "1e-45",
    "1e38",
    "nan",
    "-inf",
    "9223372036854775807",
    "true",
    "''",
    "'../\\u0000'",
    "[]",
    "[1, 2]",
    "[0, 0, 0, 0]",
    "{ kind = 'none' }",
];

/// A scene file, the keys that its reader asks for, and its length [bytes].
type Seed = (PathBuf, Vec<String>, u64);

/// Number of pairs of key and value that failed, as far as time allows; the time limit of a scene is
/// [`crate::SLOW`].
pub(super) fn run(folders: &[PathBuf], time: Duration, out: &Path) -> io::Result<usize> {
    let (keys, clock) = (asked(folders)?, Clock::start());
    let (mut count, mut accepted, mut findings) = (0, 0, 0);
    let all = keys.len() * VALUES.len();
    // Value by value, so that every key has its turn even in a short time.
    'values: for value in VALUES {
        for ((_, key), scene) in &keys {
            if clock.elapsed() > time {
                break 'values;
            }
            let set = [(key.clone(), value.to_owned())];
            let (result, took): Outcome = load(scene, &set);
            let fault = match result {
                Err(fault) => Some(fault),
                Ok(_) if took > crate::SLOW => Some("is slow"),
                Ok(end) => {
                    accepted += usize::from(end != crate::End::Refused);
                    None
                }
            };
            if let Some(fault) = fault {
                let line = format!("{}: --set {key}={value}: {fault}", scene.display());
                println!("keys: {line}");
                fs::write(out.join(format!("keys-{count}.txt")), line)?;
                findings += 1;
            }
            count += 1;
        }
    }
    println!("keys: {count} of {all} values, {accepted} accepted, {findings} findings");
    Ok(findings)
}

/// The keys of each kind of table, each with its first place in the shortest scene file that asks for it.
fn asked(folders: &[PathBuf]) -> io::Result<BTreeMap<(String, String), PathBuf>> {
    let mut seeds: Vec<Seed> = Vec::new();
    for folder in folders {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            if path.extension().is_some_and(|extension| extension == "toml") {
                let keys = scene::asked_keys(&path).map_err(io::Error::other)?;
                let length = fs::metadata(&path)?.len();
                seeds.push((path, keys, length));
            }
        }
    }
    seeds.sort_by_key(|(path, _, length)| (*length, path.clone()));
    let mut found = BTreeMap::new();
    let mut met = BTreeSet::new();
    for (path, keys, _) in seeds {
        for key in keys {
            // Tables in a list have the same keys.
            let parts = key.split('.').filter(|part| part.parse::<usize>().is_err());
            let kind = parts.collect::<Vec<_>>().join(".");
            if met.insert(kind.clone()) {
                found.insert((kind, key), path.clone());
            }
        }
    }
    Ok(found)
}
