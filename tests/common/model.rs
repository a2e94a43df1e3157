//! glTF models, made by tests.
use serde_json::{Value, json};

/// A `.glb` whose buffer grows with its contents.
pub(crate) struct Glb {
    pub(crate) json: Value,
    bytes: Vec<u8>,
}

pub(crate) const FLOAT: u32 = 5126;
pub(crate) const BYTE: u32 = 5120;
pub(crate) const UBYTE: u32 = 5121;
pub(crate) const SHORT: u32 = 5122;
pub(crate) const USHORT: u32 = 5123;

pub(crate) fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

impl Glb {
    pub(crate) fn new() -> Self {
        let json = json!({ "asset": { "version": "2.0" }, "scenes": [{ "nodes": [] }] });
        Self { json, bytes: Vec::new() }
    }

    /// Appends to a list of the document; returns the item's index.
    pub(crate) fn push(&mut self, key: &str, item: Value) -> usize {
        let list = self.json.as_object_mut().unwrap().entry(key).or_insert_with(|| json!([]));
        let list = list.as_array_mut().unwrap();
        list.push(item);
        list.len() - 1
    }

    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        self.push("bufferViews", view)
    }

    /// An accessor; `more`: further properties.
    pub(crate) fn items(
        &mut self,
        (component, kind, count): (u32, &str, usize),
        bytes: &[u8],
        more: Value,
    ) -> usize {
        let view = self.view(bytes);
        let mut accessor =
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        if let (Some(accessor), Value::Object(more)) = (accessor.as_object_mut(), more) {
            accessor.extend(more);
        }
        self.push("accessors", accessor)
    }

    pub(crate) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "MAT4" => 16,
            _ => 4,
        };
        let more = match kind {
            "VEC3" => json!({ "min": [-9, -9, -9], "max": [9, 9, 9] }),
            _ => json!({}),
        };
        self.items((FLOAT, kind, values.len() / width), &floats(values), more)
    }

    /// A texture of rgba bytes, stored as PNG.
    pub(crate) fn texture(&mut self, width: u32, height: u32, rgba: &[u8]) -> usize {
        let image = image::RgbaImage::from_raw(width, height, rgba.to_vec()).unwrap();
        let mut png = std::io::Cursor::new(Vec::new());
        image.write_to(&mut png, image::ImageFormat::Png).unwrap();
        let view = self.view(&png.into_inner());
        let source = self.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
        self.push("textures", json!({ "source": source }))
    }

    /// A square in xz of 1 m that faces up, with texture coordinates whose u grows with x and v with z: a
    /// primitive.
    pub(crate) fn square(&mut self, material: Value) -> Value {
        let corners = [[-0.5, 0.0, 0.5], [0.5, 0.0, 0.5], [0.5, 0.0, -0.5], [-0.5, 0.0, -0.5]];
        let uvs = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        let position = self.floats("VEC3", corners.as_flattened());
        let uv = self.floats("VEC2", uvs.as_flattened());
        let indices: Vec<u8> = [0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect();
        let indices = self.items((USHORT, "SCALAR", 6), &indices, json!({}));
        let material = self.push("materials", material);
        json!({
            "attributes": { "POSITION": position, "TEXCOORD_0": uv },
            "indices": indices,
            "material": material
        })
    }

    /// A node of the scene.
    pub(crate) fn node(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(index.into());
        index
    }

    /// A node with a mesh of one primitive.
    pub(crate) fn place(&mut self, primitive: Value, at: [f32; 3]) -> usize {
        let mesh = self.push("meshes", json!({ "primitives": Value::Array(vec![primitive]) }));
        self.node(json!({ "mesh": mesh, "translation": at }))
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut document = self.json.clone();
        if !self.bytes.is_empty() {
            document["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        }
        let mut chunks = Vec::new();
        let text = document.to_string().into_bytes();
        for (kind, mut bytes, fill) in [(b"JSON", text, b' '), (b"BIN\0", self.bytes.clone(), 0)] {
            bytes.resize(bytes.len().next_multiple_of(4), fill);
            chunks.extend((bytes.len() as u32).to_le_bytes());
            chunks.extend(kind);
            chunks.extend(bytes);
        }
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        glb.extend((chunks.len() as u32 + 12).to_le_bytes());
        glb.extend(chunks);
        glb
    }
}
