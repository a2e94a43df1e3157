//! A glTF document and its bytes, validated before anything is read through them: the `gltf` crate's readers
//! trust offsets, counts and indices.
use super::{
    coat::{self, Coat},
    diffuse::{self, Diffuse},
    draco,
    film::{self, Film},
    json::{self, Instancing},
    meshopt,
    splat_json::{self, SplatPrimitive},
    variants,
};
use crate::{
    SceneError,
    error::{Fault, quoted},
    limits, read,
};
use ::gltf::{
    Document,
    accessor::sparse::IndexType,
    buffer,
    json::{Root, camera::Type as CameraType, validation::Checked},
};
use base64::{Engine as _, engine::general_purpose::STANDARD as BASE64};
use std::{
    borrow::Cow,
    collections::HashMap,
    path::{Path, PathBuf},
};

/// Items that may be zeros without bytes in the file, in any file.
const FEW_ZEROS: usize = 1 << 16;

#[derive(Debug)]
pub(crate) struct GltfFile {
    pub(crate) path: PathBuf,
    pub(crate) document: Document,
    buffers: Vec<Vec<u8>>,
    /// Decompressed views by index.
    unpacked: HashMap<usize, Vec<u8>>,
    instancing: Vec<Option<Instancing>>,
    films: Vec<Option<Film>>,
    diffuse: Vec<Option<Diffuse>>,
    coats: Vec<Option<Coat>>,
    /// Dispersion by material.
    dispersion: Vec<f32>,
    /// Primitives of splats, taken out of the document.
    pub(crate) splats: Vec<SplatPrimitive>,
    /// Features of the file that are ignored, a sentence each.
    pub(crate) notes: Vec<String>,
}

impl GltfFile {
    pub(crate) fn open(path: &Path) -> Result<Self, SceneError> {
        Self::open_variant(path, None)
    }

    /// Like [`Self::open`], with a variant of the materials.
    pub(crate) fn open_variant(path: &Path, variant: Option<&str>) -> Result<Self, SceneError> {
        let invalid =
            |(message, help): (String, &'static str)| SceneError::invalid(path, message, help);
        let bytes = read::bytes(path)?;
        let (text, mut blob) = chunks(&bytes).map_err(invalid)?;
        let (mut value, ignored, unread) = json::parse(text).map_err(invalid)?;
        let variants = variants::choose(&mut value, path, variant)
            .map_err(|(message, help)| SceneError::invalid(path, message, &help))?;
        let hidden = variants::hide(&mut value);
        let primitives = draco::packed(&mut value).map_err(invalid)?;
        json::add_zeros(&mut value);
        let splats = splat_json::take(&mut value).map_err(invalid)?;
        let (instancing, films) = (json::instancing(&value), film::films(&value));
        let (diffuse, coats) = (diffuse::all(&value), coat::all(&value));
        let dispersion = json::dispersion(&value);
        let packed = meshopt::packed(&value).map_err(invalid)?;
        let fallbacks = meshopt::fallbacks(&value);
        let damaged = |error: &dyn std::fmt::Display| {
            let help = "check it with a glTF validator, or export it again";
            invalid((format!("not a valid glTF 2.0 file: {error}"), help))
        };
        let root: Root = serde_json::from_value(value).map_err(|error| damaged(&error))?;
        check_json(&root).map_err(|message| invalid((message, "export the file again")))?;
        let document = Document::from_json(root).map_err(|error| damaged(&error))?;
        let mut notes = ignored.notes(path);
        notes.extend(variants);
        if hidden > 0 {
            notes.push(format!(
                "{}: {hidden} meshes are not shown, as the file says",
                path.display()
            ));
        }
        if unread > 0 {
            let help = json::OTHER_IMAGES;
            notes.push(format!(
                "{}: {unread} textures are white, as their images cannot be read: {help}",
                path.display()
            ));
        }
        let mut file = Self {
            path: path.to_owned(),
            document,
            buffers: Vec::new(),
            unpacked: HashMap::new(),
            instancing,
            films,
            diffuse,
            coats,
            dispersion,
            splats,
            notes,
        };
        let mut buffers = Vec::new();
        for buffer in file.document.buffers() {
            let (index, length) = (buffer.index(), buffer.length());
            if fallbacks.get(index) == Some(&true) {
                buffers.push(Vec::new());
                continue;
            }
            let data = match buffer.source() {
                buffer::Source::Bin => copied(blob.take().unwrap_or_default(), path)?,
                buffer::Source::Uri(uri) => file.read_uri(uri)?,
            };
            if data.len() < length {
                let message = format!("buffer {index} has {} bytes, not {length}", data.len());
                return Err(invalid((message, "the file is cut off: export it again")));
            }
            buffers.push(data);
        }
        file.buffers = buffers;
        file.unpacked = meshopt::unpack(&file, &packed)?;
        let decoded = draco::unpack(&file, &primitives)?;
        file.unpacked.extend(decoded.views);
        file.recount(&decoded.counts).map_err(|error| damaged(&error))?;
        Ok(file)
    }

    /// Overrides the counts of accessors: streams have the last word, as in other readers.
    fn recount(&mut self, counts: &HashMap<usize, usize>) -> Result<(), gltf::Error> {
        if counts.is_empty() {
            return Ok(());
        }
        let mut root = self.document.clone().into_json();
        for (&accessor, &count) in counts {
            root.accessors[accessor].count = count.into();
        }
        self.document = Document::from_json(root)?;
        Ok(())
    }

    pub(crate) fn invalid(&self, message: impl AsRef<str>, help: &str) -> SceneError {
        SceneError::invalid(&self.path, message, help)
    }

    /// Instances of a node.
    pub(crate) fn instancing(&self, node: usize) -> Option<Instancing> {
        self.instancing.get(node).copied().flatten()
    }

    /// Thin film on a material.
    pub(crate) fn film(&self, material: usize) -> Option<Film> {
        self.films.get(material).copied().flatten()
    }

    /// Dispersion of a material: 20 over its Abbe number; 0 for none.
    pub(crate) fn dispersion(&self, material: &gltf::Material<'_>) -> f32 {
        material.index().and_then(|index| self.dispersion.get(index)).copied().unwrap_or(0.0)
    }

    /// Diffuse transmission of a material.
    pub(crate) fn diffuse(&self, material: &gltf::Material<'_>) -> Option<Diffuse> {
        self.diffuse.get(material.index()?).copied().flatten()
    }

    /// Clear coat of a material.
    pub(crate) fn coat(&self, material: &gltf::Material<'_>) -> Option<Coat> {
        self.coats.get(material.index()?).copied().flatten()
    }

    /// Bytes of a data URI, or of a file in the document's folder or below.
    pub(crate) fn read_uri(&self, uri: &str) -> Result<Vec<u8>, SceneError> {
        if let Some(data) = data_of(uri) {
            return self.decode(data);
        }
        read::bytes(&self.path_of(uri)?).map_err(|error| match error {
            SceneError::Read { source, .. } => self.beside(format!("{}: {source}", quoted(uri))),
            SceneError::Invalid { message, help, .. } => {
                let message = format!("{} {message}", quoted(uri));
                self.invalid(message, help.as_deref().unwrap_or_default())
            }
            other => other,
        })
    }

    /// Paths of its buffers and images.
    pub(crate) fn named(&self) -> Result<Vec<PathBuf>, SceneError> {
        let json = self.document.as_json();
        // Buffers that are fallbacks of compressed ones are not read.
        let is_read = |index: &usize| !self.buffers[*index].is_empty();
        let buffers = (0..json.buffers.len()).filter(is_read);
        let uris = buffers.filter_map(|index| json.buffers[index].uri.as_ref());
        let uris = uris.chain(json.images.iter().filter_map(|image| image.uri.as_ref()));
        uris.filter(|uri| data_of(uri).is_none()).map(|uri| self.path_of(uri)).collect()
    }

    /// Path of a file in the document's folder or below.
    fn path_of(&self, uri: &str) -> Result<PathBuf, SceneError> {
        if uri.contains(':') {
            return Err(self.beside(format!("cannot open {}", quoted(uri))));
        }
        let name = percent_decode(uri);
        if read::leaves_folder(Path::new(&name)) || name.contains('\\') {
            return Err(self.beside(format!("{} leaves the folder of the file", quoted(uri))));
        }
        Ok(self.path.with_file_name("").join(name))
    }

    fn beside(&self, message: String) -> SceneError {
        self.invalid(message, "put the file into the folder of this one and name it relative to it")
    }

    /// Decodes the part of a data URI after `data:`.
    fn decode(&self, rest: &str) -> Result<Vec<u8>, SceneError> {
        let bad =
            |problem: String| self.invalid(format!("data URI: {problem}"), "encode it in base64");
        let (head, data) = rest.split_once(',').ok_or_else(|| bad("it has no comma".to_owned()))?;
        let is_base64 =
            head.rsplit(';').next().is_some_and(|last| last.eq_ignore_ascii_case("base64"));
        if !is_base64 {
            return Err(bad("it is not in base64".to_owned()));
        }
        let mut bytes = Vec::new();
        let length = base64::decoded_len_estimate(data.len());
        limits::reserve(&mut bytes, length, "bytes of a data URI", &self.path)?;
        BASE64.decode_vec(data, &mut bytes).map_err(|error| bad(error.to_string()))?;
        Ok(bytes)
    }

    /// Bytes of a buffer.
    pub(crate) fn bytes(&self, buffer: usize) -> Option<&[u8]> {
        self.buffers.get(buffer).map(Vec::as_slice)
    }

    /// Bytes of a view, decompressed.
    pub(crate) fn view(&self, view: &buffer::View<'_>) -> Result<&[u8], SceneError> {
        if let Some(bytes) = self.unpacked.get(&view.index()) {
            return Ok(bytes);
        }
        let (buffer, end) = (view.buffer().index(), view.offset().checked_add(view.length()));
        end.and_then(|end| self.bytes(buffer)?.get(view.offset()..end)).ok_or_else(|| {
            let message = format!("bufferView {} leaves its buffer", view.index());
            self.invalid(message, "the file is damaged: export it again")
        })
    }

    /// Stored bytes of an image.
    pub(crate) fn image(&self, image: &gltf::Image<'_>) -> Result<Cow<'_, [u8]>, SceneError> {
        // `Image::source` would panic on a file that gives neither a type nor a position.
        let json = &self.document.as_json().images[image.index()];
        let view = json.buffer_view.and_then(|index| self.document.views().nth(index.value()));
        match (view, &json.uri) {
            (Some(view), _) => self.view(&view).map(Cow::Borrowed),
            (None, Some(uri)) => self.read_uri(uri).map(Cow::Owned),
            (None, None) => {
                let message =
                    format!("image {}: has neither a bufferView nor a uri", image.index());
                Err(self.invalid(message, "export the file again"))
            }
        }
    }

    /// Checks that reading `accessor` as items of `size` bytes stays within its buffers, and that its
    /// sparse items are among its own.
    pub(crate) fn check(
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
            let length = self.view(view)?.len();
            if stride >= size && end.is_some_and(|end| end <= length) {
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
            return accessor.view().map(|_| ()).ok_or_else(|| bad("has no data"));
        };
        // Without a base, items are zeros: only the file's size bounds their number.
        if accessor.view().is_none() && accessor.count() > self.byte_count().max(FEW_ZEROS) {
            return Err(bad("promises more items than the file justifies"));
        }
        let (indices, values) = (sparse.indices(), sparse.values());
        let index_size = match indices.index_type() {
            IndexType::U8 => 1,
            IndexType::U16 => 2,
            IndexType::U32 => 4,
        };
        fits(&indices.view(), indices.offset(), sparse.count(), index_size)?;
        fits(&values.view(), values.offset(), sparse.count(), size)?;
        let bytes = self.view(&indices.view())?;
        let stride = indices.view().stride().unwrap_or(index_size);
        let mut least = 0;
        for i in 0..sparse.count() {
            let start = indices.offset() + i * stride;
            let index = &bytes[start..start + index_size];
            let index = index.iter().rev().fold(0, |number, &byte| number << 8 | usize::from(byte));
            if index < least || index >= accessor.count() {
                return Err(bad("its sparse indices do not ascend, or leave it"));
            }
            least = index + 1;
        }
        Ok(())
    }

    fn byte_count(&self) -> usize {
        self.buffers.iter().chain(self.unpacked.values()).map(Vec::len).sum()
    }
}

fn copied(bytes: &[u8], path: &Path) -> Result<Vec<u8>, SceneError> {
    let mut copy = Vec::new();
    limits::reserve(&mut copy, bytes.len(), "bytes of a buffer", path)?;
    copy.extend_from_slice(bytes);
    Ok(copy)
}

/// JSON and binary chunk of a `.glb`, or a `.gltf` alone.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fault> {
    let damaged = || ("the file is cut off or damaged".to_owned(), "export it again");
    let Some(rest) = bytes.strip_prefix(b"glTF") else { return Ok((bytes, None)) };
    let number = |at: usize| {
        let word = rest.get(at..)?.first_chunk()?;
        Some(u32::from_le_bytes(*word) as usize)
    };
    let (version, length) = (number(0).ok_or_else(damaged)?, number(4).ok_or_else(damaged)?);
    if version != 2 {
        return Err((format!("is glTF version {version}"), "export it as glTF 2.0"));
    }
    // Lengths count from the magic on.
    let rest = length.checked_sub(4).and_then(|length| rest.get(8..length)).ok_or_else(damaged)?;
    let (text, rest) = chunk(rest, b"JSON").ok_or_else(damaged)?;
    let blob = if rest.is_empty() {
        None
    } else {
        // Other chunks are ignored.
        chunk(rest, b"BIN\0").map(|(blob, _)| blob)
    };
    Ok((text, blob))
}

/// The first chunk, which must be of `kind`, and the rest.
fn chunk<'a>(bytes: &'a [u8], kind: &[u8; 4]) -> Option<(&'a [u8], &'a [u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    let rest = rest.strip_prefix(kind)?;
    rest.split_at_checked(u32::from_le_bytes(*length) as usize)
}

/// Checks for errors that the crate's own validation misses or panics at.
fn check_json(json: &Root) -> Result<(), String> {
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
    for (index, animation) in json.animations.iter().enumerate() {
        for node in animation.channels.iter().map(|channel| channel.target.node.value()) {
            if node >= json.nodes.len() {
                return Err(format!("animation {index}: there is no node {node}"));
            }
        }
    }
    Ok(())
}

/// Part of a data URI after `data:`.
fn data_of(uri: &str) -> Option<&str> {
    let (scheme, data) = uri.split_once(':')?;
    scheme.eq_ignore_ascii_case("data").then_some(data)
}

/// Decodes percent escapes (RFC 3986, section 2.1).
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
