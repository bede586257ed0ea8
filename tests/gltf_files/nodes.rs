//! Where things stand: transforms, instances, cameras and lights.

use super::*;
use glam::{Mat4, Vec3};
use ondine::lanes::Rgb;
use ondine::scene::description::{Environment, Punctual};
use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4};

/// Matrices agree to rounding.
#[track_caller]
fn assert_near(got: Mat4, want: [[f32; 4]; 4]) {
    let want = Mat4::from_cols_array_2d(&want);
    assert!(got.abs_diff_eq(want, 1e-6), "{got:?}\nis not\n{want:?}");
}

#[test]
fn transforms_of_nodes_are_composed() {
    let mut asset = Asset::triangle();
    asset.json["nodes"] = json!([
        { "translation": [1, 2, 3], "children": [1, 2] },
        // A quarter turn around y takes x to −z.
        { "rotation": [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2], "scale": [2, 3, 4], "children": [3] },
        { "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1], "mesh": 0 },
        { "translation": [10, 20, 30], "mesh": 0 }
    ]);
    let scene = asset.load();
    let transforms: Vec<Mat4> = scene
        .objects
        .iter()
        .map(|object| instance(object.shape).1)
        .collect();
    assert_eq!(transforms.len(), 2);
    // Depth first: the grandchild before its uncle. T(1,2,3) · R · S · T(10,20,30), columns by hand.
    assert_near(
        transforms[0],
        [
            [0.0, 0.0, -2.0, 0.0],
            [0.0, 3.0, 0.0, 0.0],
            [4.0, 0.0, 0.0, 0.0],
            [1.0 + 120.0, 2.0 + 60.0, 3.0 - 20.0, 1.0],
        ],
    );
    assert_near(
        transforms[1],
        [
            [0.0, 1.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
            [6.0, 8.0, 10.0, 1.0],
        ],
    );
}

#[test]
fn nodes_of_a_mesh_share_it() {
    let mut asset = Asset::triangle();
    asset.node(json!({ "mesh": 0, "translation": [3, 0, 0] }));
    asset.node(json!({ "mesh": 0, "scale": [-1, 1, 1] }));
    let scene = asset.load();
    assert_eq!((scene.meshes.len(), scene.materials.len()), (1, 1));
    let instances: Vec<(usize, Mat4)> = scene
        .objects
        .iter()
        .map(|object| instance(object.shape))
        .collect();
    assert_eq!(
        instances,
        [
            (0, Mat4::IDENTITY),
            (0, Mat4::from_translation(Vec3::new(3.0, 0.0, 0.0))),
            (0, Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)))
        ]
    );
}

#[test]
fn instances_on_the_gpu_are_instances() {
    let mut asset = Asset::triangle();
    let translations = asset.floats("VEC3", &[0.0, 0.0, 0.0, 4.0, 5.0, 6.0]);
    let scales = asset.floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    // Half turns around z, normalised integers.
    let turns = [0i16, 0, 0, 32767, 0, 0, 32767, 0].map(i16::to_le_bytes);
    let rotations = asset.accessor("VEC4", I16, 2, turns.as_flattened());
    asset.json["accessors"][rotations]["normalized"] = true.into();
    asset.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    asset.json["nodes"][0] = json!({
        "mesh": 0,
        "translation": [0, 0, 1],
        "extensions": { "EXT_mesh_gpu_instancing": { "attributes": {
            "TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales
        } } }
    });
    let scene = asset.load();
    assert_eq!(scene.objects.len(), 2);
    let (mesh, first) = instance(scene.objects[0].shape);
    assert_eq!((mesh, first), (0, Mat4::from_translation(Vec3::Z)));
    let (mesh, second) = instance(scene.objects[1].shape);
    assert_eq!(mesh, 0);
    assert_near(
        second,
        [
            [-2.0, 0.0, 0.0, 0.0],
            [0.0, -2.0, 0.0, 0.0],
            [0.0, 0.0, 2.0, 0.0],
            [4.0, 5.0, 7.0, 1.0],
        ],
    );
}

#[test]
fn the_default_scene_is_read_then_the_first_then_all_roots() {
    let mut asset = Asset::triangle();
    asset.json["nodes"] = json!([
        { "mesh": 0 },
        { "mesh": 0, "translation": [1, 0, 0] },
        { "mesh": 0, "translation": [2, 0, 0], "children": [1] }
    ]);
    asset.json["scenes"] = json!([{ "nodes": [0] }, { "nodes": [1] }]);
    let places = |asset: &Asset| -> Vec<f32> {
        let objects = asset.load().objects;
        objects
            .iter()
            .map(|object| instance(object.shape).1.w_axis.x)
            .collect()
    };
    asset.json["scene"] = 1.into();
    assert_eq!(places(&asset), [1.0]);
    let root = asset.json.as_object_mut().expect("an object");
    root.remove("scene");
    assert_eq!(places(&asset), [0.0]);
    let root = asset.json.as_object_mut().expect("an object");
    root.remove("scenes");
    assert_eq!(places(&asset), [0.0, 2.0, 3.0]);
}

#[test]
fn a_chain_of_100_000_nodes_is_walked() {
    let mut asset = Asset::triangle();
    let last = 100_000;
    let nodes: Vec<Value> = (0..last)
        .map(|index| json!({ "translation": [1, 0, 0], "children": [index + 1] }))
        .chain([json!({ "mesh": 0 })])
        .collect();
    asset.json["nodes"] = nodes.into();
    let scene = asset.load();
    assert_eq!(instance(scene.objects[0].shape).1.w_axis.x, last as f32);
}

#[test]
fn a_flattened_mesh_is_left_out() {
    let mut asset = Asset::triangle();
    asset.node(json!({ "mesh": 0, "scale": [0, 0, 0] }));
    let scene = asset.load();
    assert_eq!(scene.objects.len(), 1);
    assert_eq!(
        scene.warnings,
        ["a.gltf: nodes[1]: meshes that their node flattens are left out"]
    );
}

#[test]
fn a_camera_looks_along_minus_z_of_its_node() {
    let mut asset = Asset::triangle();
    let wide = json!({
        "type": "perspective",
        "name": "unused",
        "perspective": { "yfov": FRAC_PI_2, "aspectRatio": 2.0, "znear": 0.1 }
    });
    let tall = json!({
        "type": "perspective",
        "perspective": { "yfov": FRAC_PI_4, "aspectRatio": 0.5, "znear": 0.1 }
    });
    let flat = json!({
        "type": "orthographic",
        "orthographic": { "xmag": 1, "ymag": 1, "zfar": 10, "znear": 1 }
    });
    asset.json["cameras"] = json!([wide, tall, flat]);
    // A quarter turn around y takes −z to −x.
    asset.node(json!({ "camera": 0, "name": "left", "translation": [8, 2, 4], "rotation": [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2] }));
    asset.node(json!({ "camera": 1 }));
    asset.node(json!({ "camera": 1, "name": "left" }));
    asset.node(json!({ "camera": 2 }));
    let scene = asset.load();
    let names: Vec<&str> = scene
        .cameras
        .iter()
        .map(|camera| camera.name.as_str())
        .collect();
    assert_eq!(names, ["left", "camera 1", "left 2"]);
    assert_eq!((scene.film.width, scene.film.height), (512, 256));
    let first = scene.cameras[0].camera;
    assert_eq!(first.position, Vec3::new(8.0, 2.0, 4.0));
    assert!(
        (first.look_at - Vec3::new(0.0, 2.0, 4.0)).length() < 1e-6,
        "{}",
        first.look_at
    );
    assert!((first.up - Vec3::Y).length() < 1e-6);
    assert_eq!(first.vertical_fov, 90.0);
    assert_eq!(first.aperture_radius, 0.0);
    let second = scene.cameras[1].camera;
    assert_eq!((second.position, second.look_at), (Vec3::ZERO, Vec3::NEG_Z));
    assert_eq!(second.vertical_fov, 45.0);
    assert_eq!(
        scene.warnings,
        ["a.gltf: nodes[4]: orthographic cameras are left out"]
    );
}

#[test]
fn without_a_camera_and_a_light_both_are_added() {
    let scene = Asset::triangle().load();
    assert_eq!(scene.cameras.len(), 1);
    let camera = scene.cameras[0].camera;
    assert!(camera.position.is_finite() && camera.position != camera.look_at);
    assert!(scene.environment.is_some());
    assert_eq!((scene.film.width, scene.film.height), (512, 512));
}

#[test]
fn punctual_lights_stand_where_their_nodes_do() {
    let mut asset = Asset::triangle();
    asset.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "point", "color": [1.0, 0.5, 0.25], "intensity": 4 },
        { "type": "directional", "intensity": 3 },
        { "type": "spot", "spot": { "innerConeAngle": 0.0, "outerConeAngle": FRAC_PI_2 }, "range": 7 },
        { "type": "point", "intensity": 0 }
    ] } });
    let light = |index: usize| json!({ "KHR_lights_punctual": { "light": index } });
    asset.node(json!({ "extensions": light(0), "translation": [1, 2, 3] }));
    // Half a turn around x takes −z to z; sizes do not matter.
    asset.node(json!({ "extensions": light(1), "rotation": [1, 0, 0, 0], "scale": [5, 5, 5] }));
    asset.node(json!({ "extensions": light(2), "translation": [0, 9, 0] }));
    asset.node(json!({ "extensions": light(3) }));
    let scene = asset.load();
    assert_eq!(scene.punctual.len(), 3);
    assert_eq!(
        scene.punctual[0],
        Punctual::Point {
            position: Vec3::new(1.0, 2.0, 3.0),
            intensity: Rgb::new(4.0, 2.0, 1.0)
        }
    );
    assert_eq!(
        scene.punctual[1],
        Punctual::Distant {
            direction: Vec3::Z,
            irradiance: Rgb::splat(3.0)
        }
    );
    let Punctual::Spot {
        position,
        direction,
        intensity,
        cos_inner,
        cos_outer,
    } = scene.punctual[2]
    else {
        panic!("{:?} is no spot", scene.punctual[2]);
    };
    assert_eq!(
        (position, direction),
        (Vec3::new(0.0, 9.0, 0.0), Vec3::NEG_Z)
    );
    assert_eq!((intensity, cos_inner), (Rgb::WHITE, 1.0));
    assert!(cos_outer.abs() < 1e-7);
    assert!(scene.environment.is_none());
    assert_eq!(scene.warnings, [""; 0]);
}

#[test]
fn a_cone_without_a_soft_edge_has_a_narrow_one() {
    let mut asset = Asset::triangle();
    asset.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "spot", "spot": { "innerConeAngle": 0.5, "outerConeAngle": 0.5 } }
    ] } });
    asset.node(json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
    let scene = asset.load();
    let [
        Punctual::Spot {
            cos_inner,
            cos_outer,
            ..
        },
    ] = scene.punctual[..]
    else {
        panic!("{:?} is no spot", scene.punctual);
    };
    assert!(cos_inner > cos_outer && cos_inner - cos_outer < 1e-6);
}

#[test]
fn the_sky_is_the_light_of_a_scene_without() {
    let scene = Asset::triangle().load();
    assert!(matches!(
        scene.environment,
        Some(Environment::Gradient { .. } | Environment::Constant(_))
    ));
    let mut lit = Asset::triangle();
    lit.material(json!({ "emissiveFactor": [1, 1, 1] }));
    assert!(lit.load().environment.is_none());
}
