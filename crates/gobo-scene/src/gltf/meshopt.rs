//! Compressed buffer views of glTF files: `EXT_meshopt_compression` and `KHR_meshopt_compression`.
use super::file::GltfFile;
use crate::{SceneError, error::Fault, limits::Limit};
use meshoptimizer_rs::{Error, Limits, Workspace, codec};
use serde_json::Value;
use std::collections::HashMap;

const EXTENSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

const DAMAGED: &str = "check it with a glTF validator, or compress it again";

/// A compressed view, and its bytes in a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PackedView {
    view: usize,
    buffer: usize,
    offset: usize,
    length: usize,
    /// Items, and the size of each \[bytes\].
    count: usize,
    stride: usize,
    mode: MeshoptMode,
    filter: Filter,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MeshoptMode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

fn extension(of: &Value) -> Option<&Value> {
    EXTENSIONS.iter().find_map(|name| of.get("extensions")?.get(name))
}

/// The file's compressed views.
pub(crate) fn packed(root: &Value) -> Result<Vec<PackedView>, Fault> {
    let views = root.get("bufferViews").and_then(Value::as_array).into_iter().flatten();
    let packed =
        views.enumerate().filter_map(|(view, value)| Some(of_view(view, extension(value)?)));
    packed.collect()
}

fn of_view(view: usize, value: &Value) -> Result<PackedView, Fault> {
    let damaged =
        |key: &str| (format!("bufferView {view}: {key} of its compression is wrong"), DAMAGED);
    let number = |key: &str| {
        let number = value.get(key).and_then(Value::as_u64);
        number.and_then(|number| usize::try_from(number).ok()).ok_or_else(|| damaged(key))
    };
    let mode = match value.get("mode").and_then(Value::as_str) {
        Some("ATTRIBUTES") => MeshoptMode::Attributes,
        Some("TRIANGLES") => MeshoptMode::Triangles,
        Some("INDICES") => MeshoptMode::Indices,
        _ => return Err(damaged("mode")),
    };
    let filter = match value.get("filter").map_or(Some("NONE"), Value::as_str) {
        Some("NONE") => Filter::None,
        Some("OCTAHEDRAL") => Filter::Octahedral,
        Some("QUATERNION") => Filter::Quaternion,
        Some("EXPONENTIAL") => Filter::Exponential,
        Some("COLOR") => Filter::Color,
        _ => return Err(damaged("filter")),
    };
    let offset = if value.get("byteOffset").is_some() { number("byteOffset")? } else { 0 };
    Ok(PackedView {
        view,
        buffer: number("buffer")?,
        offset,
        length: number("byteLength")?,
        count: number("count")?,
        stride: number("byteStride")?,
        mode,
        filter,
    })
}

/// Buffers that hold uncompressed copies for other readers, or nothing at all.
pub(crate) fn fallbacks(root: &Value) -> Vec<bool> {
    let buffers = root.get("buffers").and_then(Value::as_array).into_iter().flatten();
    let is_fallback = |buffer: &Value| {
        let fallback = extension(buffer).and_then(|decoded| decoded.get("fallback"));
        fallback.and_then(Value::as_bool).unwrap_or(false)
    };
    buffers.map(is_fallback).collect()
}

/// Decompresses views, by their indices.
pub(crate) fn unpack(
    file: &GltfFile,
    packed: &[PackedView],
) -> Result<HashMap<usize, Vec<u8>>, SceneError> {
    let mut unpacked = HashMap::new();
    let mut bytes = 0;
    for view in packed {
        let damaged = |problem: &str| {
            let message = format!("bufferView {}: its compression: {problem}", view.view);
            file.invalid(message, DAMAGED)
        };
        // Many views may name the same few bytes.
        let more = (view.count as u64).saturating_mul(view.stride as u64);
        bytes = Limit::Unpacked.grown_in(&file.path, bytes, more)?;
        let end = view.offset.checked_add(view.length);
        let source = end.and_then(|end| file.bytes(view.buffer)?.get(view.offset..end));
        let source = source.ok_or_else(|| damaged("its bytes leave their buffer"))?;
        let decoded = view.decode(source).map_err(|error| match error {
            Error::AllocationFailed => {
                let message = format!("no memory for a decompressed mesh ({} MiB)", more >> 20);
                SceneError::memory(&file.path, message)
            }
            other => damaged(&other.to_string()),
        })?;
        unpacked.insert(view.view, decoded);
    }
    Ok(unpacked)
}

impl PackedView {
    fn decode(&self, source: &[u8]) -> Result<Vec<u8>, Error> {
        let &Self { count, stride, .. } = self;
        let most = usize::try_from(Limit::Unpacked.most()).unwrap_or(usize::MAX);
        let workspace = &mut Workspace::new(Limits { max_bytes: most, ..Limits::default() });
        let decode = match self.mode {
            MeshoptMode::Attributes => codec::decode_vertex_buffer,
            MeshoptMode::Triangles => codec::decode_index_buffer,
            MeshoptMode::Indices => codec::decode_index_sequence,
        };
        let mut bytes = decode(count, stride, source, workspace)?;
        let filter = match self.filter {
            Filter::None => return Ok(bytes),
            Filter::Octahedral => codec::decode_filter_oct,
            Filter::Quaternion => codec::decode_filter_quat,
            Filter::Exponential => codec::decode_filter_exp,
            Filter::Color => codec::decode_filter_color,
        };
        filter(&mut bytes, count, stride, workspace)?;
        Ok(bytes)
    }
}
