//! Shapes, where they stand, and which way they face.

use super::*;
use glam::Vec3;
use ondine::scene::builtin;
use ondine::scene::mesh::Mesh;

/// World-space triangles of all meshes, with the side they face.
fn triangles(scene: &Description) -> Vec<[Vec3; 3]> {
    let mut all = Vec::new();
    let shapes = scene.objects.iter().map(|object| object.shape);
    for shape in shapes.chain(scene.lights.iter().map(|light| light.shape)) {
        let Shape::Mesh { mesh, transform } = shape else {
            continue;
        };
        assert!(
            transform.matrix3.determinant() > 0.0,
            "meshes are not mirrored by their places"
        );
        let Mesh {
            positions,
            triangles,
            ..
        } = &*scene.meshes[mesh];
        let corner = |corner: u32| transform.transform_point3(positions[corner as usize]);
        all.extend(triangles.iter().map(|corners| corners.map(corner)));
    }
    all
}

fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

const CORNELL: &str = r#"
Scale -1 1 1
LookAt 0 0 2.95  0 0 -1  0 1 0
Camera "perspective" "float fov" 50 "float focaldistance" 3.3
Film "rgb" "integer xresolution" 256 "integer yresolution" 256
Sampler "zsobol" "integer pixelsamples" 64
Integrator "path" "integer maxdepth" 5
PixelFilter "box"
WorldBegin
MakeNamedMaterial "white" "string type" "diffuse" "rgb reflectance" [.73 .73 .73]
MakeNamedMaterial "red" "string type" "diffuse" "rgb reflectance" [.65 .05 .05]
MakeNamedMaterial "green" "string type" "diffuse" "rgb reflectance" [.12 .45 .15]
MakeNamedMaterial "blue" "string type" "diffuse" "rgb reflectance" [.3 .4 .73]
NamedMaterial "white"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 -1 3  1 -1 3  1 -1 -1  -1 -1 -1]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 1 -1  1 1 -1  1 1 3  -1 1 3]
Shape "bilinearmesh" "point3 P" [-1 -1 -1  1 -1 -1  -1 1 -1  1 1 -1]
Shape "bilinearmesh" "point3 P" [1 -1 3  -1 -1 3  1 1 3  -1 1 3]
NamedMaterial "red"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 -1 3  -1 -1 -1  -1 1 -1  -1 1 3]
NamedMaterial "green"
Shape "trianglemesh" "integer indices" [0 1 2 2 3 0] "point3 P" [1 -1 -1  1 -1 3  1 1 3  1 1 -1]
NamedMaterial "white"
AttributeBegin
  Translate -.42 -.65 -.35
  Shape "sphere" "float radius" .35
AttributeEnd
NamedMaterial "blue"
TransformBegin
  Translate .42 -.7 .25
  Shape "sphere" "float radius" .3
TransformEnd
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [20 18 15]
  Material "interface"
  Translate 0 .7 0
  Shape "sphere" "float radius" .15
AttributeEnd
"#;

#[test]
fn the_cornell_box_is_that_of_the_built_in_scene() {
    let (ours, theirs) = (
        read(CORNELL),
        builtin::find("cornell").unwrap().load().unwrap(),
    );
    assert_eq!(ours.objects.len(), theirs.objects.len());
    for (a, b) in ours.objects.iter().zip(&theirs.objects) {
        assert_eq!(a.shape, b.shape);
        let material = |scene: &Description, index: usize| {
            let named = &scene.materials[index];
            (named.name.clone(), named.material)
        };
        assert_eq!(material(&ours, a.material), material(&theirs, b.material));
    }
    let [a, b] = [&ours.lights[0], &theirs.lights[0]];
    assert_eq!(
        (a.shape, a.radiance, a.material),
        (b.shape, b.radiance, b.material)
    );
    let [a, b] = [ours.cameras[0].camera, theirs.cameras[0].camera];
    close(a.position.to_array(), b.position.to_array());
    let axis =
        |camera: ondine::scene::description::Camera| (camera.look_at - camera.position).normalize();
    close(axis(a).to_array(), axis(b).to_array());
    close(a.up.to_array(), b.up.to_array());
    close(
        [a.vertical_fov, a.focus_distance],
        [b.vertical_fov, b.focus_distance],
    );
    assert_eq!(ours.render.spp, theirs.render.spp);
    assert_eq!(ours.render.path_length, theirs.render.path_length);
    assert!(ours.warnings.is_empty(), "{:?}", ours.warnings);
}

#[test]
fn a_triangle_mesh_keeps_its_attributes() {
    let scene = read_whole(
        "WorldBegin Translate 1 2 3 Scale 2 2 2 Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \
         \"normal3 N\" [0 0 1 0 0 1 0 1 1] \"point2 uv\" [0 0 1 0 .5 1]",
    );
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert_eq!(mesh.uvs[2].to_array(), [0.5, 1.0]);
    close(
        mesh.normals[2].to_array(),
        [0.0, 0.5f32.sqrt(), 0.5f32.sqrt()],
    );
    assert_eq!(
        triangles(&scene),
        [[
            Vec3::new(1., 2., 3.),
            Vec3::new(3., 2., 3.),
            Vec3::new(1., 4., 3.)
        ]]
    );
}

#[test]
fn triangles_face_where_pbrt_has_them_face() {
    // A triangle facing +z; what is expected of its world-space normal's z.
    let shape = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]";
    let with_normals = format!("{shape} \"normal3 N\" [0 0 -1 0 0 -1 0 0 -1]");
    for (transformation, shape, z) in [
        ("", shape, 1.0),
        ("ReverseOrientation", shape, -1.0),
        // Mirrored in its own plane: still its own upper side.
        ("Scale -1 1 1", shape, 1.0),
        ("Scale 1 1 -1", shape, -1.0),
        ("Scale -1 1 1 ReverseOrientation", shape, -1.0),
        ("", &with_normals, -1.0),
        ("Scale -1 1 1", &with_normals, -1.0),
        ("ReverseOrientation", &with_normals, 1.0),
    ] {
        for camera in [
            "",
            "Camera \"perspective\"",
            "Scale -1 1 1 Camera \"perspective\"",
        ] {
            let scene = read_whole(&format!("{camera} WorldBegin {transformation} {shape}"));
            let [triangle] = triangles(&scene).try_into().unwrap();
            assert!(normal(triangle).z * z > 0.0, "{transformation} {shape}");
            let Shape::Mesh { mesh, .. } = scene.objects[0].shape else {
                panic!("a mesh");
            };
            for normal in &scene.meshes[mesh].normals {
                assert!(normal.z * z > 0.0);
            }
        }
    }
}

#[test]
fn a_parallelogram_faces_where_its_triangles_did() {
    for (transformation, z) in [
        ("", 1.0),
        ("Scale -1 1 1", 1.0),
        ("ReverseOrientation", -1.0),
        ("Scale 1 1 -1", -1.0),
    ] {
        let scene = read_whole(&format!(
            "WorldBegin {transformation} Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]"
        ));
        let Shape::Quad { u, v, .. } = scene.objects[0].shape else {
            panic!("a quad");
        };
        assert_eq!(u.cross(v).z, z, "{transformation}");
    }
}

#[test]
fn a_sphere_stays_one_where_it_is_scaled_alike() {
    let scene = read_whole(
        "WorldBegin Translate 1 2 3 Rotate 30 1 1 0 Scale 2 -2 2 Shape \"sphere\" \"float radius\" 3",
    );
    let Shape::Sphere { center, radius } = scene.objects[0].shape else {
        panic!("a sphere");
    };
    close(center.to_array(), [1.0, 2.0, 3.0]);
    close([radius], [6.0]);
}

#[test]
fn other_spheres_disks_and_cylinders_are_meshes_that_face_outwards() {
    let around =
        |text: &str, area: f32, tolerance: f32, is_outward: &dyn Fn(Vec3, Vec3) -> bool| {
            let scene = read_whole(&format!("WorldBegin {text}"));
            let triangles = triangles(&scene);
            let total: f32 = triangles.iter().map(|&t| normal(t).length() / 2.0).sum();
            assert!(
                (total / area - 1.0).abs() < tolerance,
                "{text}: {total}, not {area}"
            );
            for triangle in triangles {
                let middle = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
                assert!(is_outward(middle, normal(triangle)), "{text}");
            }
        };
    use std::f32::consts::PI;
    let from_origin = |middle: Vec3, normal: Vec3| middle.dot(normal) > 0.0;
    let upwards = |_: Vec3, normal: Vec3| normal.z > 0.0;
    around(
        "Shape \"sphere\" \"float zmin\" 0",
        2.0 * PI,
        2e-3,
        &from_origin,
    );
    around(
        "Shape \"sphere\" \"float phimax\" 90",
        PI,
        2e-3,
        &from_origin,
    );
    around("Scale 1 1 2 Shape \"sphere\"", 21.48, 2e-3, &from_origin);
    around(
        "ReverseOrientation Shape \"sphere\"",
        4.0 * PI,
        2e-3,
        &|m, n| m.dot(n) < 0.0,
    );
    around(
        "Shape \"disk\" \"float radius\" 2 \"float height\" 1",
        4.0 * PI,
        1e-3,
        &upwards,
    );
    around(
        "Shape \"disk\" \"float innerradius\" .5 \"float phimax\" 180",
        0.375 * PI,
        1e-3,
        &upwards,
    );
    around(
        "Shape \"cylinder\" \"float zmin\" 0 \"float zmax\" 3",
        6.0 * PI,
        1e-3,
        &|m, n| m.with_z(0.0).dot(n) > 0.0 && n.z.abs() < 1e-6,
    );
}

#[test]
fn a_bent_patch_lies_on_its_surface() {
    let scene =
        read_whole("WorldBegin Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1]");
    let all = triangles(&scene);
    assert!(all.len() > 100);
    for point in all.into_iter().flatten() {
        assert!((point.z - point.x * point.y).abs() < 1e-6);
    }
}

#[test]
fn ply_meshes_are_read_once_and_packed_ones_too() {
    const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut packed, PLY.as_bytes()).unwrap();
    let folder = Folder::new(
        "WorldBegin Shape \"plymesh\" \"string filename\" \"m.ply\"\nTranslate 0 0 1\n\
         Shape \"plymesh\" \"string filename\" \"m.ply\"\nShape \"plymesh\" \"string filename\" \"m.ply.gz\"",
    )
    .with("m.ply", PLY)
    .with("m.ply.gz", packed.finish().unwrap());
    let scene = read_folder(&folder);
    assert_eq!((scene.objects.len(), scene.meshes.len()), (3, 2));
    assert_eq!(triangles(&scene)[1][0], Vec3::Z);
    let before = scene.hash;
    let changed = folder.with("m.ply", PLY.replace("1 0 0", "2 0 0"));
    assert_ne!(read_folder(&changed).hash, before);
}

#[test]
fn objects_are_shared_by_their_instances() {
    let scene = read_whole(
        "WorldBegin\nObjectBegin \"o\" Translate 0 0 1 Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]\n\
         Shape \"sphere\" \"float radius\" 2 ObjectEnd\n\
         AttributeBegin Translate 10 0 0 ObjectInstance \"o\" AttributeEnd\n\
         AttributeBegin Scale 2 2 2 ObjectInstance \"o\" AttributeEnd\n\
         AttributeBegin Scale -1 1 1 ObjectInstance \"o\" AttributeEnd",
    );
    assert_eq!(scene.objects.len(), 6);
    // One as it is, one mirrored.
    assert_eq!(scene.meshes.len(), 2);
    let all = triangles(&scene);
    let mut corners: Vec<[f32; 3]> = all[2].iter().map(|p| p.to_array()).collect();
    corners.sort_by(f32_order);
    assert_eq!(corners, [[-1., 0., 1.], [0., 0., 1.], [0., 1., 1.]]);
    assert!(all.iter().all(|&triangle| normal(triangle).z > 0.0));
    assert_eq!(all[1][1].to_array(), [2.0, 0.0, 2.0]);
    let Shape::Sphere { center, radius } = scene.objects[3].shape else {
        panic!("a sphere");
    };
    assert_eq!((center.to_array(), radius), ([0.0, 0.0, 2.0], 4.0));
}

fn f32_order(a: &[f32; 3], b: &[f32; 3]) -> std::cmp::Ordering {
    a.partial_cmp(b).unwrap()
}

#[test]
fn many_spheres_and_quads_become_meshes() {
    let sphere = "Translate 3 0 0 Shape \"sphere\"\n".repeat(65);
    let quad = "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]\n".repeat(65);
    let scene = read(&format!("WorldBegin\n{sphere}{quad}"));
    assert!(
        scene
            .objects
            .iter()
            .all(|object| matches!(object.shape, Shape::Mesh { .. }))
    );
    assert_eq!(
        scene.warnings,
        ["a.pbrt:2:17: the scene has 65 spheres; more than 64 become meshes"]
    );
}

#[test]
fn shapes_that_are_not_supported_are_told_once_and_left_out() {
    let scene = read(
        "WorldBegin\nShape \"curve\" \"point3 P\" [0 0 0 1 0 0 1 1 0 1 1 1]\nShape \"curve\"\nShape \"sphere\" \"float radios\" 2\n\
        Shape \"loopsubdiv\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2] \"integer levels\" 3\n\
        Shape \"trianglemesh\" \"point3 P\" [0 0 0 0 0 0 0 1 0]",
    );
    assert_eq!(scene.objects.len(), 2);
    assert_eq!(
        scene.warnings,
        [
            "a.pbrt:2:1: the shape \"curve\" is not supported; such shapes are left out",
            "a.pbrt:4:16: \"radios\" of Shape \"sphere\" is not used",
            "a.pbrt:5:1: subdivision is not supported; the mesh it begins with stands in its place",
            "a.pbrt:6:1: this mesh has no triangle with an area; such meshes are left out",
        ]
    );
}
