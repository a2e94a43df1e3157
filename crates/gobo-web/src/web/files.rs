//! Files of the page: their bytes stay in JavaScript until a reader asks for them.
use gobo_scene::{FORMATS, HeldFile, HeldFiles, hold_files};
use js_sys::{Object, Uint8Array};
use std::{
    cell::RefCell,
    collections::HashMap,
    io,
    path::{Path, PathBuf},
};
use wasm_bindgen::prelude::*;

/// Largest file \[bytes\]: it and the reader's results fit the 4 GiB of a page.
const LARGEST: u64 = 1 << 29;

thread_local! {
    static BYTES: RefCell<HashMap<PathBuf, Uint8Array>> = RefCell::default();
}

/// Files by name.
#[derive(Debug)]
pub(super) struct Dropped(Vec<(PathBuf, Uint8Array)>);

impl Dropped {
    pub(super) fn new(files: &Object) -> Result<Self, JsError> {
        let mut all = Vec::new();
        for entry in Object::entries(files) {
            let entry: js_sys::Array = entry.unchecked_into();
            let name = entry.get(0).as_string().unwrap_or_default();
            let bytes: Uint8Array = entry.get(1).dyn_into().map_err(|_| {
                JsError::new(&format!("{name}: is no Uint8Array\n  help: await file.arrayBuffer()"))
            })?;
            if u64::from(bytes.length()) > LARGEST {
                let message = format!(
                    "{name}: has {} MiB\n  help: a page reads files of up to {} MiB; the program reads \
                     larger ones",
                    bytes.length() >> 20,
                    LARGEST >> 20
                );
                return Err(JsError::new(&message));
            }
            all.push((PathBuf::from(name), bytes));
        }
        Ok(Self(all))
    }

    /// The file that is the scene: a scene file, a model or particles, before images.
    pub(super) fn scene(&self) -> Result<PathBuf, JsError> {
        let row = |path: &Path| {
            let ending =
                path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
            let is_row = |format: &gobo_scene::Format| {
                format.family.is_alone() && format.endings.contains(&&*ending)
            };
            FORMATS.iter().position(is_row).unwrap_or(FORMATS.len())
        };
        let first = self.0.iter().map(|(path, _)| path).min_by_key(|path| row(path));
        first
            .cloned()
            .ok_or_else(|| JsError::new("no file\n  help: give one that the program renders"))
    }

    /// Makes readers find them.
    pub(super) fn hold(self) -> Held {
        let held = |(path, bytes): (PathBuf, Uint8Array)| {
            let length = u64::from(bytes.length());
            BYTES.with_borrow_mut(|all| all.insert(path.clone(), bytes));
            let key = path.clone();
            let file = HeldFile::new(length, move |range| {
                let gone = || io::Error::from(io::ErrorKind::NotFound);
                let read = |all: &HashMap<PathBuf, Uint8Array>| {
                    let part = all.get(&key)?.subarray(range.start as u32, range.end as u32);
                    Some(part.to_vec())
                };
                BYTES.with_borrow(read).ok_or_else(gone)
            });
            (path, file)
        };
        Held { _files: hold_files(self.0.into_iter().map(held)) }
    }
}

/// Files that readers find until this is dropped.
#[derive(Debug)]
pub(super) struct Held {
    _files: HeldFiles,
}

impl Drop for Held {
    fn drop(&mut self) {
        BYTES.with_borrow_mut(HashMap::clear);
    }
}
