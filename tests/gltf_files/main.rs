//! glTF files, built here part by part: what becomes of each, and what is refused with which words.

mod changes;
#[path = "../common/mod.rs"]
mod common;
mod files;
mod materials;
mod mutations;
mod nodes;
mod primitives;
mod refusals;
mod still_life;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use ondine::error::Result;
use ondine::scene::builtin;
use ondine::scene::description::{Description, Shape};
use ondine::scene::mesh::Mesh;
use serde_json::{Value, json};
use std::path::Path;
use tempfile::TempDir;

const U8: u32 = 5121;
const I16: u32 = 5122;
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

/// A file in the making: its JSON and its only buffer.
#[derive(Clone)]
struct Asset {
    json: Value,
    bytes: Vec<u8>,
}

impl Asset {
    /// No node, no mesh.
    fn empty() -> Self {
        let json = json!({
            "asset": { "version": "2.0" },
            "buffers": [{}], "bufferViews": [], "accessors": [], "meshes": [], "nodes": [],
            "scenes": [{ "nodes": [] }], "scene": 0
        });
        Self {
            json,
            bytes: Vec::new(),
        }
    }

    /// The triangle (0, 0, 0), (1, 0, 0), (0, 1, 0) with texture coordinates, in one node.
    fn triangle() -> Self {
        let mut asset = Self::empty();
        let positions = asset.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let uvs = asset.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        asset.mesh(json!({ "attributes": { "POSITION": positions, "TEXCOORD_0": uvs } }));
        asset.node(json!({ "mesh": 0 }));
        asset
    }

    /// Adds to one of the file's lists, and says where.
    fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json.get(list).is_none() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.push(
            "bufferViews",
            json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }),
        )
    }

    fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }),
        )
    }

    fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(kind, F32, values.len() / width, &bytes)
    }

    /// A mesh of one primitive.
    fn mesh(&mut self, primitive: Value) -> usize {
        self.push("meshes", json!({ "primitives": [primitive] }))
    }

    /// A node of the scene.
    fn node(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        let roots = self.json["scenes"][0]["nodes"]
            .as_array_mut()
            .expect("roots");
        roots.push(index.into());
        index
    }

    /// Gives the first primitive a material, and says which.
    fn material(&mut self, material: Value) -> usize {
        let index = self.push("materials", material);
        self.json["meshes"][0]["primitives"][0]["material"] = index.into();
        index
    }

    /// An image of two pixels, red and half-transparent green, and a texture of it.
    fn texture(&mut self) -> usize {
        let mut png = Vec::new();
        let mut encoder = png::Encoder::new(&mut png, 2, 1);
        encoder.set_color(png::ColorType::Rgba);
        let mut writer = encoder.write_header().expect("a header");
        writer
            .write_image_data(&[255, 0, 0, 255, 0, 255, 0, 128])
            .expect("two pixels");
        writer.finish().expect("an image");
        let view = self.view(&png);
        let image = self.push(
            "images",
            json!({ "bufferView": view, "mimeType": "image/png" }),
        );
        self.push("textures", json!({ "source": image }))
    }

    /// As `.gltf`, the buffer inside.
    fn text(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        let data = BASE64_STANDARD.encode(&self.bytes);
        let uri = format!("data:application/octet-stream;base64,{data}");
        json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": uri }]);
        json.to_string().into_bytes()
    }

    /// As `.glb`.
    fn binary(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        glb(&[(b"JSON", &text), (b"BIN\0", &self.bytes)])
    }

    /// Reads it.
    #[track_caller]
    fn load(&self) -> Description {
        read("a.gltf", &self.text()).unwrap_or_else(|error| panic!("{error}"))
    }

    /// The words with which it is refused.
    #[track_caller]
    fn refusal(&self) -> String {
        refusal("a.gltf", &self.text())
    }

    /// The warnings, without the name of the file.
    #[track_caller]
    fn warnings(&self) -> Vec<String> {
        self.load().warnings
    }
}

fn glb(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let length: usize = 12 + chunks.iter().map(|(_, data)| 8 + data.len()).sum::<usize>();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((length as u32).to_le_bytes());
    for (kind, data) in chunks {
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(*kind);
        bytes.extend(*data);
    }
    bytes
}

/// Reads a file of these bytes; the folder's name is taken out of all messages.
fn read(name: &str, bytes: &[u8]) -> Result<Description> {
    let folder = TempDir::new().expect("a folder");
    std::fs::write(folder.path().join(name), bytes).expect("a file");
    read_in(folder.path(), name)
}

fn read_in(folder: &Path, name: &str) -> Result<Description> {
    let file = folder.join(name);
    let mut scene = builtin::open(file.to_str().expect("a name"))?;
    let prefix = format!("{}/", folder.display());
    for line in &mut scene.warnings {
        *line = line.replace(&prefix, "");
    }
    Ok(scene)
}

#[track_caller]
fn refusal(name: &str, bytes: &[u8]) -> String {
    let folder = TempDir::new().expect("a folder");
    std::fs::write(folder.path().join(name), bytes).expect("a file");
    refusal_in(folder.path(), name)
}

#[track_caller]
fn refusal_in(folder: &Path, name: &str) -> String {
    match read_in(folder, name) {
        Ok(_) => panic!("read without complaint"),
        Err(error) => error
            .to_string()
            .replace(&format!("{}/", folder.display()), ""),
    }
}

/// The transform of an object.
#[track_caller]
fn instance(shape: Shape) -> (usize, glam::Mat4) {
    match shape {
        Shape::Mesh { mesh, transform } => (mesh, transform.into()),
        other => panic!("{other:?} is no mesh"),
    }
}

/// The only mesh.
#[track_caller]
fn only_mesh(scene: &Description) -> &Mesh {
    assert_eq!(scene.meshes.len(), 1);
    &scene.meshes[0]
}
