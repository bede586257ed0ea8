//! What cannot be rendered: the place in the file, and what to do.

use super::*;

const AGAIN: &str = "export the file again";

/// The refusal of a triangle that was changed.
#[track_caller]
fn refused(change: impl FnOnce(&mut Asset)) -> String {
    let mut asset = Asset::triangle();
    change(&mut asset);
    asset.refusal()
}

#[test]
fn an_index_that_names_nothing_is_refused() {
    let place = |change: fn(&mut Value)| {
        let message = refused(|asset| change(&mut asset.json));
        let end = format!(": it names something that is not there; {AGAIN}");
        let place = message.strip_suffix(&end).map(str::to_owned);
        place.unwrap_or_else(|| panic!("{message}"))
    };
    assert_eq!(
        place(|json| json["nodes"][0]["mesh"] = 9.into()),
        "a.gltf: nodes[0].mesh"
    );
    assert_eq!(
        place(|json| json["nodes"][0]["children"] = json!([9])),
        "a.gltf: nodes[0].children[0]"
    );
    assert_eq!(place(|json| json["scene"] = 9.into()), "a.gltf: scene");
    assert_eq!(
        place(|json| json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 9.into()),
        "a.gltf: meshes[0].primitives[0].attributes"
    );
    assert_eq!(
        place(|json| json["meshes"][0]["primitives"][0]["material"] = 9.into()),
        "a.gltf: meshes[0].primitives[0].material"
    );
    assert_eq!(
        place(|json| json["accessors"][0]["bufferView"] = 9.into()),
        "a.gltf: accessors[0].bufferView"
    );
    assert_eq!(
        place(|json| json["bufferViews"][1]["buffer"] = 9.into()),
        "a.gltf: bufferViews[1].buffer"
    );
    assert_eq!(
        place(|json| json["nodes"][0]["extensions"] =
            json!({ "KHR_lights_punctual": { "light": 0 } })),
        "a.gltf: nodes[0].extensions.khrLightsPunctual.light"
    );
    assert_eq!(
        place(|json| {
            json["nodes"][0]["extensions"] =
                json!({ "EXT_mesh_gpu_instancing": { "attributes": { "SCALE": 9 } } });
        }),
        "a.gltf: nodes[0].extensions.EXT_mesh_gpu_instancing.attributes.SCALE"
    );
}

#[test]
fn an_accessor_beyond_its_buffer_is_refused() {
    assert_eq!(
        refused(|asset| asset.json["accessors"][0]["count"] = 4.into()),
        format!(
            "a.gltf: accessors[0]: 4 elements of 12 bytes, 12 apart, from byte 0 do not fit in the 36 bytes of bufferViews[0]; {AGAIN}"
        )
    );
    assert_eq!(
        refused(|asset| asset.json["accessors"][0]["count"] = (1u64 << 62).into()),
        format!(
            "a.gltf: accessors[0]: 4611686018427387904 elements of 12 bytes, 12 apart, from byte 0 do not fit in the 36 bytes of bufferViews[0]; {AGAIN}"
        )
    );
    assert_eq!(
        refused(|asset| asset.json["bufferViews"][1]["byteLength"] = 25.into()),
        format!("a.gltf: bufferViews[1]: it has 25 bytes from 36, and buffers[0] has 60; {AGAIN}")
    );
    assert_eq!(
        refused(|asset| {
            asset.json["accessors"][0] = json!({
                "componentType": F32, "count": 1u64 << 40, "type": "VEC3",
                "sparse": {
                    "count": 1,
                    "indices": { "bufferView": 0, "componentType": U8 },
                    "values": { "bufferView": 0 }
                }
            });
        }),
        "a.gltf: accessors[0]: it has 1099511627776 elements and no bufferView; at most 4194304 are read"
    );
    assert_eq!(
        refused(|asset| {
            let at = asset.view(&[3]);
            asset.json["accessors"][0]["sparse"] = json!({
                "count": 1,
                "indices": { "bufferView": at, "componentType": U8 },
                "values": { "bufferView": 0 }
            });
        }),
        format!(
            "a.gltf: accessors[0].sparse: it replaces element 3 of 3 (counted from 0); {AGAIN}"
        )
    );
}

#[test]
fn an_accessor_of_another_kind_is_refused() {
    assert_eq!(
        refused(
            |asset| asset.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 1.into()
        ),
        format!(
            "a.gltf: meshes[0].primitives[0].attributes.POSITION: accessors[1] holds Vec2 of F32, and vectors of 3 are needed; {AGAIN}"
        )
    );
    assert_eq!(
        refused(|asset| asset.json["meshes"][0]["primitives"][0]["indices"] = 0.into()),
        format!(
            "a.gltf: meshes[0].primitives[0].indices: accessors[0] holds Vec3 of F32, and unsigned numbers are needed; {AGAIN}"
        )
    );
    assert_eq!(
        refused(|asset| asset.json["accessors"][0]["componentType"] = 9.into()),
        format!("a.gltf: accessors[0].componentType: it is nothing that glTF 2.0 knows; {AGAIN}")
    );
}

#[test]
fn a_mesh_that_cannot_be_rendered_is_refused() {
    assert_eq!(
        refused(|asset| {
            let bytes = f32::NAN.to_le_bytes();
            asset.bytes[16..20].copy_from_slice(&bytes);
        }),
        format!(
            "a.gltf: meshes[0].primitives[0]: vertex 1 is at (1, NaN, 0); coordinates are finite numbers within ±1e9; {AGAIN}"
        )
    );
    assert_eq!(
        refused(|asset| {
            let indices = asset.accessor("SCALAR", U8, 3, &[0, 1, 3]);
            asset.json["meshes"][0]["primitives"][0]["indices"] = indices.into();
        }),
        format!(
            "a.gltf: meshes[0].primitives[0]: triangle 0 has corner 3, and there are 3 vertices (counted from 0); {AGAIN}"
        )
    );
    assert_eq!(
        refused(|asset| {
            let uvs = asset.floats("VEC2", &[0.0; 4]);
            asset.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = uvs.into();
        }),
        format!(
            "a.gltf: meshes[0].primitives[0]: it has 2 texture coordinates for 3 vertices; give one for each, or none; {AGAIN}"
        )
    );
    assert_eq!(
        refused(|asset| asset.json["nodes"][0] = json!({})),
        format!(
            "a.gltf: scene: there are no triangles to render; {AGAIN}, with meshes in its scene"
        )
    );
}

#[test]
fn nodes_that_form_no_tree_are_refused() {
    let message = "it has two parents or is its own ancestor, and nodes form trees; copy the node, or share its mesh";
    assert_eq!(
        refused(|asset| asset.json["nodes"][0]["children"] = json!([0])),
        format!("a.gltf: nodes[0]: {message}")
    );
    assert_eq!(
        refused(|asset| {
            asset.json["nodes"] = json!([{ "children": [1, 2] }, { "children": [3] }, { "children": [3] }, { "mesh": 0 }]);
        }),
        format!("a.gltf: nodes[3]: {message}")
    );
}

#[test]
fn a_transform_that_leads_nowhere_is_refused() {
    assert_eq!(
        refused(|asset| asset.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0])),
        format!("a.gltf: nodes[0]: its rotation has no direction; {AGAIN}")
    );
    assert_eq!(
        refused(|asset| {
            // Nine scales that single precision holds, one in the other.
            asset.json["nodes"][0]["scale"] = json!([1e38, 1, 1]);
            let mut root = 0;
            for _ in 0..8 {
                let nodes = asset.json["nodes"].as_array_mut().unwrap();
                nodes.push(json!({ "children": [root], "scale": [1e38, 1, 1] }));
                root = nodes.len() - 1;
            }
            asset.json["scenes"][0]["nodes"] = json!([root]);
        }),
        format!("a.gltf: nodes[0]: its transform is not finite; {AGAIN}")
    );
    let refusal = refused(|asset| asset.json["nodes"][0]["scale"] = json!([1e60, 1, 1]));
    assert!(
        refusal.starts_with("a.gltf:1:") && refusal.contains("number out of range"),
        "{refusal}"
    );
    assert_eq!(
        refused(|asset| asset.json["nodes"][0]["translation"] = json!([2e9, 1, 1])),
        format!(
            "a.gltf: nodes[0]: its mesh reaches beyond ±1e9; {AGAIN}, nearer to the origin or smaller"
        )
    );
    assert_eq!(
        refused(|asset| {
            let scales = asset.floats("VEC3", &[1.0; 6]);
            let places = asset.floats("VEC3", &[1.0; 9]);
            asset.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": {
                "attributes": { "SCALE": scales, "TRANSLATION": places }
            } });
        }),
        format!(
            "a.gltf: nodes[0].extensions.EXT_mesh_gpu_instancing.attributes: they have different counts, and each instance needs one of each; {AGAIN}"
        )
    );
}

#[test]
fn extensions_that_are_not_read_are_refused_if_required_and_told_if_used() {
    assert_eq!(
        refused(|asset| asset.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"])),
        "a.gltf: extensionsRequired: \"KHR_draco_mesh_compression\" is not read; export the file without it"
    );
    let mut asset = Asset::triangle();
    asset.json["extensionsUsed"] = json!([
        "KHR_materials_ior",
        "KHR_materials_sheen",
        "KHR_materials_clearcoat",
        "KHR_materials_sheen"
    ]);
    assert_eq!(
        asset.warnings(),
        [
            "a.gltf: extensionsUsed and 1 more: \"KHR_materials_sheen\" is not read",
            "a.gltf: extensionsUsed: \"KHR_materials_clearcoat\" is not read"
        ]
    );
}

#[test]
fn cameras_that_see_nothing_are_refused() {
    let camera = |perspective: Value| {
        refused(|asset| {
            asset.json["cameras"] = json!([{ "type": "perspective", "perspective": perspective }]);
            asset.node(json!({ "camera": 0 }));
        })
    };
    assert_eq!(
        camera(json!({ "yfov": 0, "znear": 1 })),
        format!(
            "a.gltf: cameras[0].perspective.yfov: it is 0, and a camera sees more than 0 and less than pi; {AGAIN}"
        )
    );
    assert_eq!(
        camera(json!({ "yfov": 1, "znear": 1, "aspectRatio": 0 })),
        format!(
            "a.gltf: cameras[0].perspective.aspectRatio: it is 0, and a ratio of sides is above 0; {AGAIN}"
        )
    );
    assert_eq!(
        refused(|asset| asset.json["cameras"] = json!([{ "type": "perspective" }])),
        format!("a.gltf: cameras[0].perspective: it is missing; {AGAIN}")
    );
    assert_eq!(
        refused(|asset| {
            let perspective = json!({ "yfov": 1, "znear": 1 });
            asset.json["cameras"] = json!([{ "type": "perspective", "perspective": perspective }]);
            asset.node(json!({ "camera": 0, "scale": [1, 0, 1] }));
        }),
        format!("a.gltf: nodes[1]: its camera is flattened or beyond ±1e9; {AGAIN}")
    );
}

#[test]
fn light_that_is_no_light_is_refused() {
    let light = |light: Value| {
        refused(|asset| {
            asset.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
            asset.node(json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
        })
    };
    let place = "a.gltf: extensions.KHR_lights_punctual.lights[0]";
    assert_eq!(
        light(json!({ "type": "point", "intensity": -1 })),
        format!(
            "{place}: its light is [-1.0, -1.0, -1.0], and light is finite and at least 0; {AGAIN}"
        )
    );
    assert_eq!(
        light(json!({ "type": "spot", "spot": { "innerConeAngle": 1.0, "outerConeAngle": 0.5 } })),
        format!("{place}: its cone is from 1 to 0.5, and angles grow from 0 to pi / 2; {AGAIN}")
    );
    assert_eq!(
        refused(|asset| {
            asset.material(json!({ "emissiveFactor": [1, 0, -1] }));
        }),
        format!(
            "a.gltf: materials[0]: its emission is [1.0, 0.0, -1.0], and radiance is finite and at least 0; {AGAIN}"
        )
    );
}

#[test]
fn an_image_that_cannot_be_read_is_refused() {
    let message = refused(|asset| {
        let texture = asset.texture();
        asset.material(
            json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }),
        );
        asset.json["images"] = json!([{ "uri": "none.png" }]);
    });
    assert_eq!(
        message,
        "a.gltf: images[0]: cannot read \"none.png\": No such file or directory (os error 2); put it there, or export the file again"
    );
    let message = refused(|asset| {
        let texture = asset.texture();
        asset.material(
            json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }),
        );
        asset.json["images"] = json!([{ "uri": "data:image/png;base64,AAAA" }]);
    });
    assert!(message.starts_with("a.gltf: images[0]: "), "{message}");
}
