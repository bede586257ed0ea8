//! Buffers, chunks and what URIs name.

use super::*;
use sha2::{Digest, Sha256};

#[test]
fn a_glb_is_what_its_gltf_is() {
    let asset = Asset::triangle();
    let (text, binary) = (
        asset.load(),
        read("a.glb", &asset.binary()).expect("a scene"),
    );
    assert_eq!(only_mesh(&text).positions, only_mesh(&binary).positions);
    assert_eq!(only_mesh(&text).uvs, only_mesh(&binary).uvs);
    assert_eq!(text.objects.len(), binary.objects.len());
}

#[test]
fn buffers_are_found_beside_the_file_by_percent_encoded_names() {
    let folder = TempDir::new().expect("a folder");
    let mut asset = Asset::triangle();
    asset.json["buffers"] =
        json!([{ "byteLength": asset.bytes.len(), "uri": "data/a%20b%C3%A9.bin" }]);
    std::fs::create_dir(folder.path().join("data")).expect("a folder");
    std::fs::write(folder.path().join("data/a bé.bin"), &asset.bytes).expect("a file");
    std::fs::write(folder.path().join("a.gltf"), asset.json.to_string()).expect("a file");
    let scene = read_in(folder.path(), "a.gltf").expect("a scene");
    assert_eq!(only_mesh(&scene).triangles, [[0, 1, 2]]);

    let mut hasher = Sha256::new();
    hasher.update(asset.json.to_string());
    hasher.update(&asset.bytes);
    let hash: String = hasher
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    assert_eq!(scene.hash, hash);
}

#[test]
fn an_image_beside_the_file_enters_its_hash() {
    let folder = TempDir::new().expect("a folder");
    let mut asset = Asset::triangle();
    let texture = asset.texture();
    let png = {
        let view = &asset.json["bufferViews"][2];
        let at = view["byteOffset"].as_u64().expect("an offset") as usize;
        asset.bytes[at..].to_vec()
    };
    asset.json["images"] = json!([{ "uri": "a.png" }]);
    asset.material(json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }));
    std::fs::write(folder.path().join("a.gltf"), asset.text()).expect("a file");
    std::fs::write(folder.path().join("a.png"), &png).expect("a file");
    let first = read_in(folder.path(), "a.gltf").expect("a scene");
    assert_eq!(first.textures[0].image.width, 2);
    std::fs::write(folder.path().join("a.png"), [&png[..], b"x"].concat()).expect("a file");
    let second = read_in(folder.path(), "a.gltf").expect("a scene");
    assert_ne!(first.hash, second.hash);
}

#[test]
fn data_uris_need_no_padding_and_may_be_percent_encoded() {
    let mut asset = Asset::triangle();
    let text = String::from_utf8(asset.text()).expect("text");
    let stripped = text.replace('=', "");
    let scene = read("a.gltf", stripped.as_bytes()).expect("a scene");
    let encoded: String = asset
        .bytes
        .iter()
        .map(|byte| format!("%{byte:02X}"))
        .collect();
    asset.json["buffers"] =
        json!([{ "byteLength": asset.bytes.len(), "uri": format!("data:,{encoded}") }]);
    let other = read("a.gltf", asset.json.to_string().as_bytes()).expect("a scene");
    assert_eq!(only_mesh(&scene).positions, only_mesh(&other).positions);
}

#[test]
fn a_buffer_that_cannot_be_had_is_refused() {
    let mut asset = Asset::triangle();
    let length = asset.bytes.len();
    let mut refusal_of = |buffer: Value| {
        asset.json["buffers"] = json!([buffer]);
        refusal("a.gltf", asset.json.to_string().as_bytes())
    };
    assert_eq!(
        refusal_of(json!({ "byteLength": length, "uri": "a.bin" })),
        "a.gltf: buffers[0]: cannot read \"a.bin\": No such file or directory (os error 2); put it there, or export the file again"
    );
    assert_eq!(
        refusal_of(json!({ "byteLength": length, "uri": "https://x.org/a.bin" })),
        "a.gltf: buffers[0]: \"https://x.org/a.bin\" is on a network; save it beside the scene"
    );
    assert_eq!(
        refusal_of(json!({ "byteLength": length, "uri": "data:;base64,AA*A" })),
        "a.gltf: buffers[0]: its data URI is not base64 (Invalid symbol 42, offset 2.); export the file again"
    );
    assert_eq!(
        refusal_of(json!({ "byteLength": length, "uri": "data:AAAA" })),
        "a.gltf: buffers[0]: its data URI has no comma before the data; export the file again"
    );
    assert_eq!(
        refusal_of(json!({ "byteLength": 100, "uri": "data:;base64,AAAA" })),
        "a.gltf: buffers[0]: it is 100 bytes by its byteLength, and 3 are there; copy or export the file again"
    );
    assert_eq!(
        refusal_of(json!({ "byteLength": length })),
        "a.gltf: buffers[0]: it has no uri, and only the first buffer of a .glb is part of the file; export the file again"
    );
}

#[test]
fn a_damaged_glb_is_refused() {
    let right = Asset::triangle().binary();
    let damaged = |damage: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = right.clone();
        damage(&mut bytes);
        refusal("a.glb", &bytes)
    };
    assert_eq!(
        damaged(&|bytes| bytes[0] = b'x'),
        "a.glb: it does not begin with \"glTF\", so it is no .glb; export the file again"
    );
    assert_eq!(
        damaged(&|bytes| bytes[4] = 1),
        "a.glb: it is a .glb of version 1; convert it to glTF 2.0"
    );
    let length = right.len();
    assert_eq!(
        damaged(&|bytes| bytes.truncate(length - 1)),
        format!(
            "a.glb: it is {length} bytes by its header, and {} are there; copy or export the file again",
            length - 1
        )
    );
    assert_eq!(
        damaged(&|bytes| bytes.truncate(11)),
        "a.glb: it ends within its header; copy or export the file again"
    );
    assert_eq!(
        damaged(&|bytes| bytes[16] = b'B'),
        "a.glb: its first chunk is no whole JSON chunk; copy or export the file again"
    );
    assert_eq!(
        damaged(&|bytes| bytes[15] = 0x7f),
        "a.glb: its first chunk is no whole JSON chunk; copy or export the file again"
    );
    let text = u32::from_le_bytes([right[12], right[13], right[14], right[15]]) as usize;
    assert_eq!(
        damaged(&|bytes| bytes[20 + text + 3] = 1),
        "a.glb: its second chunk is no whole BIN chunk; copy or export the file again"
    );
}

#[test]
fn what_is_not_the_json_of_gltf_2_is_refused_with_its_place() {
    assert_eq!(
        refusal("a.gltf", b"{\n  \"asset\": {},\n}"),
        "a.gltf:2:13: this is not the JSON of glTF: missing field `version`; export the file again"
    );
    assert_eq!(
        refusal("a.gltf", b"{ \"asset\": { \"version\": \"1.0\" } }"),
        "a.gltf: asset: version \"1.0\" is not read; convert it to glTF 2.0"
    );
    let deep = "[".repeat(100_000);
    assert!(refusal("a.gltf", deep.as_bytes()).contains("this is not the JSON of glTF"));
}
