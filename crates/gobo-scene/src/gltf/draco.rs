//! Compressed primitives of glTF files: `KHR_draco_mesh_compression`.
use super::file::GltfFile;
use crate::{SceneError, error::Fault, limits::Limit};
use draco_core::{DecodeLimits, DecoderBuffer, FaceIndex, Mesh, MeshDecoder};
use serde_json::{Value, json};
use std::collections::HashMap;

pub(crate) const EXTENSION: &str = "KHR_draco_mesh_compression";

const DAMAGED: &str = "check it with a glTF validator, or compress it again";

/// A compressed primitive: the view with its stream, and the views that accessors read its data from.
#[derive(Debug)]
pub(crate) struct PackedPrimitive {
    /// Name in messages.
    name: String,
    stream: usize,
    indices: Decoded,
    attributes: Vec<(u32, Decoded)>,
}

/// Items of one accessor.
#[derive(Clone, Copy, Debug)]
struct Decoded {
    accessor: usize,
    view: usize,
    count: usize,
    /// Components of an item.
    components: usize,
    number: ComponentType,
}

/// Type of a component.
#[derive(Clone, Copy, Debug)]
enum ComponentType {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

/// The file's compressed primitives. Their accessors get new views, whose bytes [`unpack`] makes. An accessor
/// with a view keeps it: it holds the same data uncompressed.
pub(crate) fn packed(root: &mut Value) -> Result<Vec<PackedPrimitive>, Fault> {
    let mut found = Vec::new();
    for (mesh, value) in list(root, "meshes").iter().enumerate() {
        for (index, primitive) in list(value, "primitives").iter().enumerate() {
            if let Some(packed) = primitive.get("extensions").and_then(|all| all.get(EXTENSION)) {
                let name = format!("mesh {mesh}, primitive {index}");
                found.push((name, primitive.clone(), packed.clone()));
            }
        }
    }
    let mut all = Vec::new();
    for (name, primitive, packed) in found {
        all.extend(of_primitive(root, name, &primitive, &packed)?);
    }
    Ok(all)
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

fn index(value: Option<&Value>) -> Option<usize> {
    value.and_then(Value::as_u64).and_then(|index| usize::try_from(index).ok())
}

/// `None` if no accessor needs the compressed data.
fn of_primitive(
    root: &mut Value,
    name: String,
    primitive: &Value,
    packed: &Value,
) -> Result<Option<PackedPrimitive>, Fault> {
    let damaged = |what: &str| (format!("{name}: {what} of its compression is wrong"), DAMAGED);
    let stream = index(packed.get("bufferView")).ok_or_else(|| damaged("bufferView"))?;
    let buffer = list(root, "bufferViews").get(stream).and_then(|view| view.get("buffer"));
    let buffer = buffer.cloned().ok_or_else(|| damaged("bufferView"))?;
    if index(primitive.get("mode")).unwrap_or(4) != 4 {
        return Err(damaged("mode"));
    }
    let accessor = index(primitive.get("indices")).ok_or_else(|| damaged("indices"))?;
    let indices = decoded(root, accessor, &buffer).ok_or_else(|| damaged("indices"))?;
    let names = packed.get("attributes").and_then(Value::as_object);
    let mut attributes = Vec::new();
    for (key, id) in names.into_iter().flatten() {
        let id = id.as_u64().and_then(|id| u32::try_from(id).ok());
        let accessor = index(primitive.get("attributes").and_then(|all| all.get(key)));
        let both = id.zip(accessor).and_then(|(id, at)| Some((id, decoded(root, at, &buffer)?)));
        let (id, decoded) = both.ok_or_else(|| damaged(key))?;
        attributes.extend(decoded.map(|decoded| (id, decoded)));
    }
    let is_needed = indices.is_some() || !attributes.is_empty();
    let indices = match indices {
        Some(indices) => indices,
        None if is_needed => return Err(damaged("indices")),
        None => return Ok(None),
    };
    Ok(Some(PackedPrimitive { name, stream, indices, attributes }))
}

/// Gives an accessor without a view a new one; `Some(None)` if it has one, `None` if it is damaged.
fn decoded(root: &mut Value, index_of: usize, buffer: &Value) -> Option<Option<Decoded>> {
    let view = list(root, "bufferViews").len();
    let accessor = root.get_mut("accessors")?.get_mut(index_of)?.as_object_mut()?;
    if accessor.contains_key("bufferView") {
        return Some(None);
    }
    let number = ComponentType::of(accessor.get("componentType")?.as_u64()?)?;
    let components = match accessor.get("type")?.as_str()? {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => return None,
    };
    let count = index(accessor.get("count"))?;
    accessor.insert("bufferView".to_owned(), view.into());
    accessor.remove("byteOffset");
    let length = count.checked_mul(components * number.size())?;
    let views = root.get_mut("bufferViews")?.as_array_mut()?;
    views.push(json!({ "buffer": buffer, "byteLength": length }));
    Some(Some(Decoded { accessor: index_of, view, count, components, number }))
}

/// Contents of compressed primitives.
#[derive(Debug, Default)]
pub(crate) struct Unpacked {
    /// Bytes of each accessor's view.
    pub(crate) views: HashMap<usize, Vec<u8>>,
    /// Item counts of accessors that announce another count than their stream.
    pub(crate) counts: HashMap<usize, usize>,
}

/// Decompresses primitives to the views of their accessors.
pub(crate) fn unpack(file: &GltfFile, packed: &[PackedPrimitive]) -> Result<Unpacked, SceneError> {
    let mut unpacked = Unpacked::default();
    let mut bytes = 0;
    for primitive in packed {
        let damaged = |problem: &str| {
            let message = format!("{}: its compression: {problem}", primitive.name);
            file.invalid(message, DAMAGED)
        };
        // Few bytes may announce much.
        Limit::Unpacked.grown_in(&file.path, bytes, primitive.size())?;
        let view = file.document.views().nth(primitive.stream);
        let stream = file.view(&view.ok_or_else(|| damaged("there is no such bufferView"))?)?;
        let mesh = decode(stream, Limit::Unpacked.most() - bytes);
        let mesh = mesh.map_err(|error| damaged(&error.to_string()))?;
        let triangles = (0..mesh.num_faces()).flat_map(|i| mesh.face(FaceIndex(i as u32)));
        let indices: Vec<u32> = triangles.map(|point| point.0).collect();
        if indices.iter().any(|&index| !primitive.indices.number.holds(index)) {
            return Err(damaged("its indices do not fit their componentType"));
        }
        let of_stream = |decoded: &Decoded, count| Decoded { count, ..*decoded };
        let of_indices = of_stream(&primitive.indices, indices.len());
        let of_points =
            primitive.attributes.iter().map(|(id, it)| (*id, of_stream(it, mesh.num_points())));
        let of_points: Vec<(u32, Decoded)> = of_points.collect();
        let all = of_points.iter().map(|(_, decoded)| decoded).chain([&of_indices]);
        bytes = Limit::Unpacked.grown_in(&file.path, bytes, size_of(all))?;
        unpacked.put(&primitive.indices, &of_indices, indices.into_iter().map(f64::from));
        for ((_, announced), (id, decoded)) in primitive.attributes.iter().zip(&of_points) {
            let attribute = mesh.attribute_by_unique_id(*id);
            let attribute = attribute.ok_or_else(|| damaged(&format!("no attribute {id}")))?;
            if usize::from(attribute.num_components()) < decoded.components {
                return Err(damaged(&format!("attribute {id} has too few components")));
            }
            // Exact: no attribute has integers of 32 bits.
            let numbers = attribute.read_f32s(decoded.count, decoded.components);
            unpacked.put(announced, decoded, numbers.into_iter().map(f64::from));
        }
    }
    Ok(unpacked)
}

/// `most`: memory limit \[bytes\].
fn decode(stream: &[u8], most: u64) -> Result<Mesh, draco_core::DracoError> {
    let faces = Limit::Triangles.most();
    let limits = DecodeLimits::default()
        .with_max_points(3 * faces)
        .with_max_faces(faces)
        .with_max_decoded_bytes(most);
    let mut buffer = DecoderBuffer::new(stream).with_limits(limits);
    let mut mesh = Mesh::new();
    MeshDecoder::new().decode(&mut buffer, &mut mesh)?;
    Ok(mesh)
}

/// Bytes of all decoded accessors, at four per component.
fn size_of<'a>(all: impl Iterator<Item = &'a Decoded>) -> u64 {
    let size =
        |decoded: &Decoded| (decoded.count as u64).saturating_mul((decoded.components * 4) as u64);
    all.map(size).fold(0, u64::saturating_add)
}

impl Unpacked {
    fn put(&mut self, announced: &Decoded, decoded: &Decoded, numbers: impl Iterator<Item = f64>) {
        self.views.insert(decoded.view, decoded.bytes(numbers));
        if decoded.count != announced.count {
            self.counts.insert(decoded.accessor, decoded.count);
        }
    }
}

impl PackedPrimitive {
    fn size(&self) -> u64 {
        size_of(self.attributes.iter().map(|(_, decoded)| decoded).chain([&self.indices]))
    }
}

impl Decoded {
    fn bytes(&self, numbers: impl Iterator<Item = f64>) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.count * self.components * self.number.size());
        for number in numbers {
            match self.number {
                ComponentType::I8 => bytes.extend((number as i8).to_le_bytes()),
                ComponentType::U8 => bytes.push(number as u8),
                ComponentType::I16 => bytes.extend((number as i16).to_le_bytes()),
                ComponentType::U16 => bytes.extend((number as u16).to_le_bytes()),
                ComponentType::U32 => bytes.extend((number as u32).to_le_bytes()),
                ComponentType::F32 => bytes.extend((number as f32).to_le_bytes()),
            }
        }
        bytes
    }
}

impl ComponentType {
    fn of(component_type: u64) -> Option<Self> {
        Some(match component_type {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    /// Whether the type is wide enough for an index.
    const fn holds(self, index: u32) -> bool {
        match self {
            Self::U8 => index <= u8::MAX as u32,
            Self::U16 => index <= u16::MAX as u32,
            Self::U32 => true,
            Self::I8 | Self::I16 | Self::F32 => false,
        }
    }

    const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}
