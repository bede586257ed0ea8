//! Triangles, strips, fans; indices; attributes of every kind.

use super::*;
use glam::{Vec2, Vec3};

/// Five points, no three in a line.
const POINTS: [f32; 15] = [
    0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.5, 0.0, 3.0, 0.0, 1.0,
];

/// The triangles of a primitive of these points.
#[track_caller]
fn triangles(mode: u32, indices: Option<(u32, &[u8])>) -> Vec<[u32; 3]> {
    let mut asset = Asset::empty();
    let positions = asset.floats("VEC3", &POINTS);
    let mut primitive = json!({ "attributes": { "POSITION": positions }, "mode": mode });
    if let Some((component, bytes)) = indices {
        let size = match component {
            U8 => 1,
            U16 => 2,
            _ => 4,
        };
        let indices = asset.accessor("SCALAR", component, bytes.len() / size, bytes);
        primitive["indices"] = indices.into();
    }
    asset.mesh(primitive);
    asset.node(json!({ "mesh": 0 }));
    only_mesh(&asset.load()).triangles.clone()
}

#[test]
fn strips_and_fans_turn_as_the_standard_says() {
    assert_eq!(triangles(4, None), [[0, 1, 2]]);
    assert_eq!(triangles(5, None), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    assert_eq!(triangles(6, None), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
}

#[test]
fn indices_have_one_two_or_four_bytes() {
    let expected = [[4, 3, 2], [2, 1, 0]];
    assert_eq!(triangles(4, Some((U8, &[4, 3, 2, 2, 1, 0]))), expected);
    let two = [4u16, 3, 2, 2, 1, 0].map(u16::to_le_bytes);
    assert_eq!(triangles(4, Some((U16, two.as_flattened()))), expected);
    let four = [4u32, 3, 2, 2, 1, 0].map(u32::to_le_bytes);
    assert_eq!(triangles(4, Some((U32, four.as_flattened()))), expected);
    assert_eq!(
        triangles(5, Some((U8, &[4, 3, 2, 1, 0]))),
        [[4, 3, 2], [3, 1, 2], [2, 1, 0]]
    );
}

#[test]
fn each_primitive_keeps_the_vertices_that_it_uses() {
    let mut asset = Asset::empty();
    let positions = asset.floats("VEC3", &POINTS);
    let normals = asset.floats(
        "VEC3",
        &[
            1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, -1.0, 0.0, 0.0,
        ],
    );
    let uvs = asset.floats("VEC2", &[0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]);
    let indices = asset.accessor("SCALAR", U8, 3, &[4, 1, 3]);
    asset.mesh(json!({
        "attributes": { "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs },
        "indices": indices
    }));
    asset.node(json!({ "mesh": 0 }));
    let scene = asset.load();
    let mesh = only_mesh(&scene);
    assert_eq!(mesh.triangles, [[2, 0, 1]]);
    assert_eq!(
        mesh.positions,
        [Vec3::X, Vec3::new(1.0, 1.5, 0.0), Vec3::new(3.0, 0.0, 1.0)]
    );
    assert_eq!(mesh.normals, [Vec3::Y, Vec3::Z, Vec3::NEG_X]);
    assert_eq!(
        mesh.uvs,
        [
            Vec2::new(0.2, 0.3),
            Vec2::new(0.6, 0.7),
            Vec2::new(0.8, 0.9)
        ]
    );
}

#[test]
fn normalised_integers_are_fractions() {
    let mut asset = Asset::triangle();
    let bytes = [0u16, 65535, 13107, 0, 65535, 32768].map(u16::to_le_bytes);
    let uvs = asset.accessor("VEC2", U16, 3, bytes.as_flattened());
    asset.json["accessors"][uvs]["normalized"] = true.into();
    let attributes = &mut asset.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["TEXCOORD_0"] = uvs.into();
    let scene = asset.load();
    assert_eq!(
        only_mesh(&scene).uvs,
        [
            Vec2::new(0.0, 1.0),
            Vec2::new(0.2, 0.0),
            Vec2::new(1.0, 32768.0 / 65535.0)
        ]
    );
}

#[test]
fn quantised_positions_are_read_with_their_stride() {
    let mut asset = Asset::empty();
    let bytes = [0i16, 0, 0, 99, 16384, 0, 0, 99, -32768, 32767, -1, 99].map(i16::to_le_bytes);
    let positions = asset.accessor("VEC3", I16, 3, bytes.as_flattened());
    asset.json["bufferViews"][0]["byteStride"] = 8.into();
    asset.json["accessors"][positions]["normalized"] = true.into();
    asset.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    asset.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    asset.mesh(json!({ "attributes": { "POSITION": positions } }));
    asset.node(json!({ "mesh": 0 }));
    let scene = asset.load();
    let most = 32767.0;
    assert_eq!(
        only_mesh(&scene).positions,
        [
            Vec3::ZERO,
            Vec3::new(16384.0 / most, 0.0, 0.0),
            Vec3::new(-1.0, 1.0, -1.0 / most)
        ]
    );
    assert_eq!(scene.warnings, [""; 0]);
}

#[test]
fn sparse_accessors_replace_elements() {
    let mut asset = Asset::triangle();
    let at = asset.view(&[2]);
    let new = asset.view([0f32, 7.0, 0.0].map(f32::to_le_bytes).as_flattened());
    asset.json["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": at, "componentType": U8 },
        "values": { "bufferView": new }
    });
    let scene = asset.load();
    assert_eq!(
        only_mesh(&scene).positions,
        [Vec3::ZERO, Vec3::X, Vec3::new(0.0, 7.0, 0.0)]
    );

    asset.json["accessors"][0]["count"] = 4.into();
    let accessor = asset.json["accessors"][0]
        .as_object_mut()
        .expect("an accessor");
    accessor.remove("bufferView");
    let at = asset.view(&[1, 3]);
    let new = asset.view(
        [1f32, 0.0, 0.0, 0.0, 0.0, 1.0]
            .map(f32::to_le_bytes)
            .as_flattened(),
    );
    asset.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": { "bufferView": at, "componentType": U8 },
        "values": { "bufferView": new }
    });
    let indices = asset.accessor("SCALAR", U8, 3, &[0, 1, 3]);
    let primitive = &mut asset.json["meshes"][0]["primitives"][0];
    primitive["indices"] = indices.into();
    primitive["attributes"] = json!({ "POSITION": 0 });
    let scene = asset.load();
    assert_eq!(only_mesh(&scene).positions, [Vec3::ZERO, Vec3::X, Vec3::Z]);
}

#[test]
fn points_and_lines_are_left_out_and_told_once() {
    let mut asset = Asset::triangle();
    for mode in 0..4 {
        let primitive = json!({ "attributes": { "POSITION": 0 }, "mode": mode });
        let mesh = asset.mesh(primitive);
        asset.node(json!({ "mesh": mesh }));
    }
    let scene = asset.load();
    assert_eq!(scene.meshes.len(), 1);
    assert_eq!(
        scene.warnings,
        ["a.gltf: meshes[1].primitives[0] and 3 more: points and lines are left out"]
    );
}

#[test]
fn triangles_without_an_area_are_left_out_and_counted() {
    let mut asset = Asset::triangle();
    let indices = asset.accessor("SCALAR", U8, 9, &[0, 1, 2, 0, 1, 1, 2, 2, 2]);
    asset.json["meshes"][0]["primitives"][0]["indices"] = indices.into();
    let flat = asset.accessor("SCALAR", U8, 3, &[1, 1, 1]);
    let primitives = asset.json["meshes"][0]["primitives"]
        .as_array_mut()
        .expect("a list");
    primitives.push(json!({ "attributes": { "POSITION": 0 }, "indices": flat }));
    let scene = asset.load();
    assert_eq!(only_mesh(&scene).triangles, [[0, 1, 2]]);
    assert_eq!(
        scene.warnings,
        [
            "a.gltf: meshes[0].primitives[1]: primitives without an area are left out",
            "a.gltf: 2 triangles without an area left out"
        ]
    );
}

#[test]
fn without_normals_a_mesh_is_flat() {
    let scene = Asset::triangle().load();
    assert!(only_mesh(&scene).normals.is_empty());
    assert_eq!(only_mesh(&scene).name, "meshes[0].primitives[0]");
}
