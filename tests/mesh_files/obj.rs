//! OBJ and MTL.

use super::common::mutations;
use glam::{Vec2, Vec3};
use ondine::lanes::Rgb;
use ondine::material::Material;
use ondine::scene::description::Description;
use ondine::scene::obj::{load, read};
use std::fs;
use std::path::Path;

const SQUARE: &str = "# two squares
mtllib a.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 0
vt 1 1
vn 0 0 2
usemtl red
f 1/1/1 2/2/1 3/3/1 4//1
g other
usemtl blue
f -4 -3 \\
  -2
usemtl red
f 1/1/1 3/3/1 4//1
";

const MATERIALS: &str = "newmtl red
Kd 1 0 0
newmtl blue
Kd 0 0 1
Ks 0.5 0.5 0.5
Ns 20
illum 2
newmtl window
Kd 1 1 1
d 0.1
Ni 1.4
illum 7
newmtl lamp
Ke 4 3 2
newmtl metal
Kd 1 0.8 0.2
Pm 1
Pr 0.3
newmtl leaf
map_Kd -s 2 2 1 -clamp on leaf.png
map_d leaf.png
map_Bump heights.png
";

fn parse(text: &[u8]) -> Result<Description, String> {
    read(text, Path::new("none/a.obj")).map_err(|error| error.to_string())
}

/// Reads an OBJ beside an MTL and two pictures.
fn with_materials(obj: &str, mtl: &str) -> Result<Description, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name);
    fs::write(file("a.obj"), obj).expect("a file");
    fs::write(file("a.mtl"), mtl).expect("a file");
    for name in ["leaf.png", "heights.png"] {
        let picture = image::RgbImage::from_pixel(2, 2, image::Rgb([90, 90, 90]));
        picture.save(file(name)).expect("a picture");
    }
    load(&file("a.obj")).map_err(|error| error.to_string())
}

#[track_caller]
fn refuses(from: &str, to: &str, words: &str) {
    assert!(SQUARE.contains(from), "{from:?} is not in the file");
    let message = parse(SQUARE.replacen(from, to, 1).as_bytes()).expect_err("a refusal");
    assert!(message.starts_with("none/a.obj: "), "{message}");
    assert!(message.contains(words), "{message}\nlacks {words:?}");
}

/// The material of a triangle.
fn material(name: &str) -> (Material, Description) {
    let text = format!("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl {name}\nf 1 2 3\n");
    let scene = with_materials(&text, MATERIALS).expect("a scene");
    (scene.materials[0].material, scene)
}

#[test]
fn each_material_is_a_mesh() {
    let (plain, _) = MATERIALS.split_once("newmtl leaf").expect("a leaf");
    let scene = with_materials(SQUARE, plain).expect("a scene");
    assert_eq!(scene.warnings, [""; 0]);
    let [red, blue] = &scene.meshes[..] else {
        panic!("{} meshes", scene.meshes.len());
    };
    assert_eq!(red.triangles, [[0, 1, 2], [0, 2, 3], [0, 2, 3]]);
    assert_eq!(red.positions[2], Vec3::new(1.0, 1.0, 0.0));
    assert_eq!(red.normals, [Vec3::Z; 4]);
    assert_eq!(red.uvs, [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::ZERO]);
    assert_eq!(
        blue.positions,
        [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)]
    );
    assert!(blue.normals.is_empty() && blue.uvs.is_empty());
    assert!(blue.name.ends_with("a.obj (blue)"), "{}", blue.name);
    let albedo = Rgb::new(1.0, 0.0, 0.0);
    assert_eq!(scene.materials[0].material, Material::Lambert { albedo });
}

#[test]
fn a_material_is_the_closest_that_there_is() {
    let phong = Material::Phong {
        diffuse: Rgb::new(0.0, 0.0, 1.0),
        // What the diffuse part leaves.
        specular: Rgb::new(0.5, 0.5, 0.0),
        exponent: 20.0,
    };
    assert_eq!(material("blue").0, phong);
    assert_eq!(material("window").0, Material::Glass { ior: 1.4 });
    let metal = Material::Principled {
        base_color: Rgb::new(1.0, 0.8, 0.2),
        metallic: 1.0,
        roughness: 0.3,
        ior: 1.5,
    };
    assert_eq!(material("metal").0, metal);
    let (_, lamp) = material("lamp");
    assert!(lamp.objects.is_empty());
    assert_eq!(lamp.lights[0].radiance, Rgb::new(4.0, 3.0, 2.0));
}

#[test]
fn textures_are_colours_and_cut_outs_and_heights_are_told() {
    let (leaf, scene) = material("leaf");
    assert_eq!(leaf, Material::Lambert { albedo: Rgb::WHITE });
    let maps = scene.materials[0].maps;
    let color = &scene.textures[maps.color.expect("a colour")];
    assert_eq!(
        color.transform.transform_point2(Vec2::splat(0.25)),
        Vec2::splat(0.5)
    );
    assert!(maps.alpha.is_some());
    assert_eq!(maps.normal, None);
    assert!(
        scene.warnings[0].contains("holds heights, not normals"),
        "{:?}",
        scene.warnings
    );
}

#[test]
fn what_is_missing_is_white_and_told() {
    let scene = parse(SQUARE.as_bytes()).expect("a scene");
    let warnings = scene.warnings.join("\n");
    assert!(
        warnings.contains("none/a.obj:2: cannot read none/a.mtl"),
        "{warnings}"
    );
    assert!(
        warnings.contains("none/a.obj:11: material \"red\" is in no MTL file"),
        "{warnings}"
    );
}

#[test]
fn refusals_name_the_line() {
    refuses(
        "f 1/1/1 2",
        "f 9/1/1 2",
        "line 12: there is no number 9 of the 4 vertices",
    );
    refuses(
        "2/2/1",
        "2/7/1",
        "line 12: there is no number 7 of the 3 texture coordinates",
    );
    refuses(
        "2/2/1",
        "2/2/-2",
        "line 12: there is no number -2 of the 1 normals",
    );
    refuses("f 1/1/1 2", "f 0/1/1 2", "line 12: there is no number 0");
    refuses("f 1/1/1 2", "f x 2", "line 12: \"x\" is no corner");
    refuses(
        "f 1/1/1 2",
        "f 1/1/1/1 2",
        "line 12: \"1/1/1/1\" is no corner",
    );
    refuses(
        "v 1 0 0",
        "v 1 nan 0",
        "line 4: v must be three finite numbers",
    );
    refuses(
        "v 1 0 0",
        "v 1 0",
        "line 4: v must be three finite numbers, and this is not: the line ends",
    );
    refuses(
        "v 1 0 0",
        "v 1 2e9 0",
        "coordinates are finite numbers within",
    );
    refuses(
        "-4 -3 \\\n  -2",
        "-4 -3",
        "line 15: a face has at least 3 corners",
    );
    let none = parse(b"v 0 0 0\n").expect_err("no faces");
    assert!(none.contains("it has no faces with an area"), "{none}");
    let flat = parse(b"v 0 0 0\nv 1 0 0\nf 1 2 1\n").expect_err("no faces");
    assert!(flat.contains("it has no faces with an area"), "{flat}");
    let message = with_materials(SQUARE, "newmtl a\nKd 1 1\n").expect_err("a refusal");
    assert!(
        message.contains("a.obj: line 2: ")
            && message.contains("a.mtl, line 2: Kd must be three numbers"),
        "{message}"
    );
    let message = with_materials(SQUARE, "newmtl a\nNs much\n").expect_err("a refusal");
    assert!(
        message.contains("a.mtl, line 2: this is no Ns of a material"),
        "{message}"
    );
}

#[test]
fn a_damaged_file_is_refused_or_read_and_never_a_panic() {
    let (mut read, mut refused) = (0, 0);
    let mut tally = |result: Result<Description, String>| match result {
        Ok(_) => read += 1,
        Err(message) => {
            assert!(!message.contains('\n'), "{message:?}");
            refused += 1;
        }
    };
    for bytes in mutations(11, SQUARE.as_bytes(), 10_000) {
        tally(parse(&bytes));
    }
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name);
    fs::write(file("a.obj"), SQUARE).expect("a file");
    for bytes in mutations(12, MATERIALS.as_bytes(), 5000) {
        fs::write(file("a.mtl"), bytes).expect("a file");
        tally(load(&file("a.obj")).map_err(|error| error.to_string()));
    }
    assert!(
        read > 1000 && refused > 1000,
        "{read} read, {refused} refused"
    );
}

#[test]
fn a_comment_that_ends_in_a_backslash_ends_there() {
    let text = "# C:\\exports\\\nv 0 0 0\nv 1 0 0 # right \\\nv 0 1 0\nf 1 2 \\\n3 \\";
    assert!(text.contains("exports\\\nv"));
    let scene = parse(text.as_bytes()).unwrap();
    assert_eq!(scene.meshes[0].positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(scene.meshes[0].triangles.len(), 1);
}
