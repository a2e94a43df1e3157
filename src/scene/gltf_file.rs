//! A glTF document and its bytes, checked before anything is read through them: the crate's readers
//! trust offsets, counts and percent signs.
use super::SceneError;
use ::gltf::{
    accessor::sparse::IndexType,
    buffer,
    json::{self, camera::Type as CameraType, validation::Checked},
};
use std::path::{Path, PathBuf};

/// Extensions that a file may require.
const EXTENSIONS: [&str; 7] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_texture_transform",
];

#[derive(Debug)]
pub(super) struct File {
    pub(super) path: PathBuf,
    pub(super) document: gltf::Document,
    buffers: Vec<Vec<u8>>,
}

impl File {
    pub(super) fn open(path: &Path) -> Result<Self, SceneError> {
        let invalid = |message: String, help: &str| SceneError::invalid(path, message, help);
        let damaged = |error: gltf::Error| {
            let message = format!("not a valid glTF 2.0 file: {error}");
            invalid(message, "check it with a glTF validator, or export it again")
        };
        let bytes = read(path)?;
        if let Some(length) = bytes.strip_prefix(b"glTF").and_then(|rest| rest.get(4..8)) {
            // The crate subtracts the header's size unchecked.
            if u32::from_le_bytes([length[0], length[1], length[2], length[3]]) < 12 {
                let message = "the header promises fewer bytes than it has itself".to_owned();
                return Err(invalid(message, "the file is damaged: export it again"));
            }
        }
        let file = gltf::Gltf::from_slice_without_validation(&bytes).map_err(damaged)?;
        let (mut root, mut blob) = (file.document.into_json(), file.blob);
        for name in &root.extensions_required {
            if !EXTENSIONS.contains(&name.as_str()) {
                let help = "export without compression or optional extensions";
                return Err(invalid(format!("requires {name}, which gobo does not read"), help));
            }
        }
        check_json(&root).map_err(|message| invalid(message, "export the file again"))?;
        // The crate reads volumes, but its validation refuses files that require them.
        root.extensions_required.retain(|name| name != "KHR_materials_volume");
        let document = gltf::Document::from_json(root).map_err(damaged)?;
        let mut file = Self { path: path.to_owned(), document, buffers: Vec::new() };
        let mut buffers = Vec::new();
        for buffer in file.document.buffers() {
            let (index, length) = (buffer.index(), buffer.length());
            let data = match buffer.source() {
                buffer::Source::Bin => blob.take().unwrap_or_default(),
                buffer::Source::Uri(uri) => file.read_uri(uri)?,
            };
            if data.len() < length {
                let message = format!("buffer {index} has {} bytes, not {length}", data.len());
                return Err(invalid(message, "the file is cut off: export it again"));
            }
            buffers.push(data);
        }
        file.buffers = buffers;
        Ok(file)
    }

    pub(super) fn invalid(&self, message: impl Into<String>, help: &str) -> SceneError {
        SceneError::invalid(&self.path, message, help)
    }

    /// A data URI, or a file beside this one.
    pub(super) fn read_uri(&self, uri: &str) -> Result<Vec<u8>, SceneError> {
        if uri.starts_with("data:") {
            return buffer::Data::from_source(buffer::Source::Uri(uri), None)
                .map(|data| data.0)
                .map_err(|error| {
                    self.invalid(format!("data URI: {error}"), "encode it in base64")
                });
        }
        if uri.contains(':') {
            let help = "put the file beside this one and name it relative to it";
            return Err(self.invalid(format!("cannot open `{uri}`"), help));
        }
        read(&self.path.with_file_name("").join(percent_decode(uri)))
    }

    /// The bytes of a buffer or of one of its views.
    pub(super) fn buffer(&self, buffer: &buffer::Buffer<'_>) -> Option<&[u8]> {
        self.buffers.get(buffer.index()).map(Vec::as_slice)
    }

    pub(super) fn view(&self, view: &buffer::View<'_>) -> Result<&[u8], SceneError> {
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| self.buffer(&view.buffer())?.get(view.offset()..end)).ok_or_else(|| {
            let message = format!("bufferView {} leaves its buffer", view.index());
            self.invalid(message, "the file is damaged: export it again")
        })
    }

    /// Makes sure that reading `accessor` as items of `size` bytes stays within its buffers.
    pub(super) fn check(
        &self,
        accessor: &gltf::Accessor<'_>,
        size: usize,
    ) -> Result<(), SceneError> {
        let bad = |problem: &str| {
            let message = format!("accessor {}: {problem}", accessor.index());
            self.invalid(message, "the file is damaged: export it again")
        };
        let fits = |view: &buffer::View<'_>, offset: usize, count: usize, size: usize| {
            let stride = view.stride().unwrap_or(size);
            let end = count
                .checked_sub(1)
                .and_then(|last| last.checked_mul(stride))
                .and_then(|start| start.checked_add(offset)?.checked_add(size));
            let room = self.view(view)?.len();
            if stride >= size && end.is_some_and(|end| end <= room) {
                return Ok(());
            }
            Err(bad("reaches beyond its buffer view, or is empty"))
        };
        if accessor.size() != size {
            return Err(bad("has items of the wrong type"));
        }
        if let Some(view) = accessor.view() {
            fits(&view, accessor.offset(), accessor.count(), size)?;
        }
        let Some(sparse) = accessor.sparse() else {
            return accessor
                .view()
                .map(|_| ())
                .ok_or_else(|| bad("has no data; compressed meshes need their uncompressed copy"));
        };
        // Where there is no base, items are zero, and only the file's size bounds their number.
        if accessor.view().is_none() && accessor.count() > self.byte_count() {
            return Err(bad("promises more items than the file justifies"));
        }
        let index_size = match sparse.indices().index_type() {
            IndexType::U8 => 1,
            IndexType::U16 => 2,
            IndexType::U32 => 4,
        };
        let (indices, values) = (sparse.indices(), sparse.values());
        fits(&indices.view(), indices.offset(), sparse.count(), index_size)?;
        fits(&values.view(), values.offset(), sparse.count(), size)
    }

    fn byte_count(&self) -> usize {
        self.buffers.iter().map(Vec::len).sum()
    }
}

/// What the crate's own validation lets pass, or trips over.
fn check_json(json: &json::Root) -> Result<(), String> {
    for (index, camera) in json.cameras.iter().enumerate() {
        let is_perspective = camera.type_ == Checked::Valid(CameraType::Perspective);
        let has_lens = if is_perspective {
            camera.perspective.is_some()
        } else {
            camera.orthographic.is_some()
        };
        if !has_lens {
            return Err(format!("camera {index} has no lens of its type"));
        }
    }
    for (index, mesh) in json.meshes.iter().enumerate() {
        for accessor in mesh.primitives.iter().flat_map(|primitive| primitive.attributes.values()) {
            if accessor.value() >= json.accessors.len() {
                return Err(format!("mesh {index}: there is no accessor {}", accessor.value()));
            }
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<Vec<u8>, SceneError> {
    let read_error = |source| SceneError::Read { path: path.to_owned(), source };
    if !std::fs::metadata(path).map_err(read_error)?.is_file() {
        return Err(SceneError::invalid(path, "is not a file", "name a file"));
    }
    std::fs::read(path).map_err(read_error)
}

/// RFC 3986, section 2.1.
fn percent_decode(uri: &str) -> String {
    let hex = |byte: Option<&u8>| byte.and_then(|b| char::from(*b).to_digit(16));
    let bytes = uri.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while let Some(&byte) = bytes.get(i) {
        match (byte, hex(bytes.get(i + 1)), hex(bytes.get(i + 2))) {
            (b'%', Some(high), Some(low)) => {
                decoded.push((high * 16 + low) as u8);
                i += 3;
            }
            _ => {
                decoded.push(byte);
                i += 1;
            }
        }
    }
    String::from_utf8_lossy(&decoded).into_owned()
}
