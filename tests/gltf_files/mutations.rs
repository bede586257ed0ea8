//! Damaged files are read or refused: nothing panics.

use super::common::mutations;
use super::*;

/// Something of everything.
fn rich() -> Asset {
    let mut asset = Asset::triangle();
    let texture = asset.texture();
    asset.material(json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": texture, "extensions": { "KHR_texture_transform": { "rotation": 1.0 } } },
            "metallicRoughnessTexture": { "index": texture }
        },
        "normalTexture": { "index": texture, "extensions": { "KHR_texture_transform": { "scale": [2, 2] } } },
        "emissiveTexture": { "index": texture },
        "emissiveFactor": [1, 1, 1],
        "alphaMode": "MASK",
        "extensions": { "KHR_materials_ior": { "ior": 1.4 } }
    }));
    let indices = asset.accessor("SCALAR", U16, 3, &[0, 0, 1, 0, 2, 0]);
    asset.json["meshes"][0]["primitives"][0]["indices"] = indices.into();
    let at = asset.view(&[2]);
    let new = asset.view([0f32, 2.0, 0.0].map(f32::to_le_bytes).as_flattened());
    asset.json["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": at, "componentType": U8 },
        "values": { "bufferView": new }
    });
    asset.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1, "aspectRatio": 1.5 } }]);
    asset.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "spot", "spot": {} }] } });
    asset.node(json!({ "camera": 0, "translation": [0, 0, 3] }));
    asset.node(json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } }, "rotation": [0, 0, 0, 1] }));
    let scales = asset.floats("VEC3", &[1.0; 6]);
    asset.push("nodes", json!({ "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "SCALE": scales } } } }));
    asset.node(
        json!({ "children": [3], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }),
    );
    asset
}

/// Reads each copy; says how many were read, and how many refused.
fn read_all(name: &str, copies: impl Iterator<Item = Vec<u8>>) -> (usize, usize) {
    let folder = TempDir::new().expect("a folder");
    let (mut read, mut refused) = (0, 0);
    for copy in copies {
        std::fs::write(folder.path().join(name), &copy).expect("a file");
        match read_in(folder.path(), name) {
            Ok(_) => read += 1,
            Err(error) => {
                refused += 1;
                let message = error.to_string();
                assert!(!message.contains('\n'), "{message}");
            }
        }
    }
    (read, refused)
}

#[test]
fn a_damaged_file_is_read_or_refused() {
    let asset = rich();
    assert_eq!(asset.load().lights.len(), 3);
    let (read, refused) = read_all("a.gltf", mutations(1, &asset.text(), 6_000));
    assert!(
        read > 100 && refused > 100,
        "{read} read, {refused} refused"
    );
    let (read, refused) = read_all("a.glb", mutations(2, &asset.binary(), 3_000));
    assert!(read > 10 && refused > 100, "{read} read, {refused} refused");
}

/// Damage that leaves the chunks of a `.glb` as long as they are goes deeper.
#[test]
fn damage_within_the_chunks_is_read_or_refused() {
    let asset = rich();
    let damaged_bytes = mutations(3, &asset.bytes, 3_000).map(|bytes| {
        let mut copy = asset.clone();
        copy.bytes = bytes;
        copy.binary()
    });
    let (read, refused) = read_all("a.glb", damaged_bytes);
    assert!(
        read > 100 && refused > 100,
        "{read} read, {refused} refused"
    );

    let text = asset.json.to_string();
    let numbers: Vec<(usize, char)> = text
        .char_indices()
        .filter(|(_, c)| c.is_ascii_digit())
        .collect();
    let damaged_numbers = (0..10 * numbers.len()).map(|index| {
        let (at, _) = numbers[index / 10];
        let mut text = text.clone();
        let digit = [
            "0",
            "1",
            "2",
            "3",
            "7",
            "9",
            "-1",
            "4294967295",
            "1e39",
            "99999",
        ][index % 10];
        text.replace_range(at..=at, digit);
        let mut text = text.into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        glb(&[(b"JSON", &text), (b"BIN\0", &asset.bytes)])
    });
    let (read, refused) = read_all("a.glb", damaged_numbers);
    assert!(
        read > 100 && refused > 100,
        "{read} read, {refused} refused"
    );
}
