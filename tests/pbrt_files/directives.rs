//! Transformations, attributes, includes, and the text itself.

use super::*;
use glam::Vec3;

#[track_caller]
fn centers(scene: &str) -> Vec<[f32; 3]> {
    let scene = read(scene);
    let center = |shape| match shape {
        Shape::Sphere { center, .. } => center.to_array(),
        other => panic!("{other:?}"),
    };
    scene
        .objects
        .iter()
        .map(|object| center(object.shape))
        .collect()
}

#[test]
fn transformations_apply_to_what_follows_from_the_inside_out() {
    for (text, expected) in [
        ("Translate 1 2 3 Scale 2 2 2 Translate 1 0 0", [3., 2., 3.]),
        ("Rotate 90 0 0 1 Translate 1 0 0", [0., 1., 0.]),
        (
            "Transform [1 0 0 0  0 1 0 0  0 0 1 0  4 5 6 1]",
            [4., 5., 6.],
        ),
        (
            "Translate 9 9 9 Transform [1 0 0 0  0 1 0 0  0 0 1 0  4 5 6 1]",
            [4., 5., 6.],
        ),
        (
            "Translate 1 1 1 ConcatTransform [0 1 0 0  -1 0 0 0  0 0 1 0  4 5 6 1] Translate 1 0 0",
            [5., 7., 7.],
        ),
        ("Translate 1 1 1 Identity", [0., 0., 0.]),
        (
            "Translate 1 1 1 CoordinateSystem \"a\" Identity CoordSysTransform \"a\"",
            [1., 1., 1.],
        ),
        (
            "Translate 1 1 1 AttributeBegin Translate 1 1 1 AttributeEnd",
            [1., 1., 1.],
        ),
        ("TransformBegin Translate 1 1 1 TransformEnd", [0., 0., 0.]),
        (
            "Translate 1 1 1 ActiveTransform EndTime Translate 5 5 5 ActiveTransform All",
            [1., 1., 1.],
        ),
    ] {
        let [center] = centers(&format!("WorldBegin {text} Shape \"sphere\""))
            .try_into()
            .unwrap();
        close(center, expected);
    }
}

#[test]
fn the_camera_names_its_coordinate_system() {
    let text = "Scale -1 1 1 LookAt 1 2 3 1 2 0 0 1 0 Camera \"perspective\" WorldBegin CoordSysTransform \"camera\" Translate 0 0 2 Shape \"sphere\"";
    close(centers(text)[0], [1.0, 2.0, 1.0]);
}

#[test]
fn attributes_end_with_their_block() {
    let scene = read_whole(
        "WorldBegin AttributeBegin Material \"dielectric\" AreaLightSource \"diffuse\" AttributeEnd Shape \"sphere\"\n\
         TransformBegin Material \"dielectric\" TransformEnd Shape \"sphere\"",
    );
    assert!(scene.lights.is_empty());
    let of = |index: usize| scene.materials[scene.objects[index].material].material;
    assert_eq!(
        of(0),
        Material::Lambert {
            albedo: Rgb::splat(0.5)
        }
    );
    assert_eq!(of(1), Material::Glass { ior: 1.5 });
}

#[test]
fn attribute_sets_what_directives_do_not_say() {
    let scene = read_whole(
        "WorldBegin Attribute \"shape\" \"float radius\" 3 Shape \"sphere\" Shape \"sphere\" \"float radius\" 2\n\
         Attribute \"material\" \"rgb reflectance\" [1 0 0] Material \"diffuse\" Shape \"sphere\"",
    );
    let radius = |index: usize| match scene.objects[index].shape {
        Shape::Sphere { radius, .. } => radius,
        _ => panic!("a sphere"),
    };
    assert_eq!([radius(0), radius(1)], [3.0, 2.0]);
    assert_eq!(
        scene.materials[1].material,
        Material::Lambert {
            albedo: Rgb::new(1., 0., 0.)
        }
    );
}

#[test]
fn includes_stand_where_they_are_named_and_imports_keep_to_themselves() {
    let folder = Folder::new(
        "WorldBegin\nInclude \"sub/b.pbrt\"\nShape \"sphere\"\nImport \"c.pbrt\"\nShape \"sphere\"\nInclude \"d.pbrt.gz\"",
    );
    std::fs::create_dir(folder.path("sub")).unwrap();
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut packed, b"Translate 0 1 0 Shape \"sphere\"").unwrap();
    let folder = folder
        // Names are relative to the scene file, not to the including one.
        .with("sub/b.pbrt", "Translate 1 0 0 Include \"e.pbrt\"")
        .with("e.pbrt", "# nothing but a translation\nTranslate 1 0 0")
        .with(
            "c.pbrt",
            "Translate 1 0 0 Shape \"sphere\" MakeNamedMaterial \"m\" \"string type\" \"diffuse\"",
        )
        .with("d.pbrt.gz", packed.finish().unwrap());
    let scene = read_folder(&folder);
    let centers: Vec<Vec3> = scene
        .objects
        .iter()
        .map(|object| match object.shape {
            Shape::Sphere { center, .. } => center,
            _ => panic!("a sphere"),
        })
        .collect();
    let at = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    assert_eq!(centers, [at(2., 0.), at(3., 0.), at(2., 0.), at(2., 1.)]);
    // All files count.
    let before = scene.hash;
    let folder = folder.with("e.pbrt", "Translate 1 0 0");
    assert_ne!(read_folder(&folder).hash, before);
}

#[test]
fn the_text_may_be_written_in_any_way() {
    let scene = read_whole(
        "# a comment \"with [ quotes\nWorldBegin Shape\"sphere\"\"float radius\"[2.5]#close\n\tShape \"sphere\" \"float  radius\"+2.5e0\r\nShape \"sphere\" \"float radius\" [ 25e-1 ]",
    );
    assert_eq!(scene.objects.len(), 3);
    for object in &scene.objects {
        assert_eq!(
            object.shape,
            Shape::Sphere {
                center: Vec3::ZERO,
                radius: 2.5
            }
        );
    }
    // A comment in another encoding than UTF-8, and a name that ends a line.
    let folder = Folder::new("").with("a.pbrt", b"# caf\xe9\nWorldBegin Shape \"sphere\"");
    assert_eq!(read_folder(&folder).objects.len(), 1);
}

#[test]
fn directives_of_what_is_not_there_are_told_once() {
    let scene = read(
        "Option \"bool disablepixeljitter\" true\nAccelerator \"bvh\"\nColorSpace \"rec2020\"\nTransformTimes 0 1\n\
         MakeNamedMedium \"m\" \"string type\" \"homogeneous\"\nWorldBegin\nMediumInterface \"m\" \"\"\nMediumInterface \"m\"\nCoordSysTransform \"x\"",
    );
    assert_eq!(
        scene.warnings,
        [
            "a.pbrt:3:1: the colour space \"rec2020\" is not supported; colours are read as linear sRGB",
            "a.pbrt:5:1: participating media are not supported; everything stands in a vacuum",
            "a.pbrt:9:1: the coordinate system \"x\" is not known; the transformation stays",
        ]
    );
}
