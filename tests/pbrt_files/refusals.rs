//! What cannot be rendered: the place, what is wrong, and what to do.

use super::*;

#[test]
fn what_is_no_directive_is_refused_with_the_nearest() {
    refuses(
        "WorldBegin\n  Shap \"sphere\"",
        "a.pbrt:2:3: unknown directive \"Shap\"; did you mean \"Shape\"? Directives are Accelerator, ActiveTransform, AreaLightSource, Attribute, AttributeBegin, AttributeEnd, Camera, ColorSpace, ConcatTransform, CoordSysTransform, CoordinateSystem, Film, Identity, Import, Include, Integrator and 23 more",
    );
    refuses(
        "WorldBegin ]",
        "a.pbrt:1:12: \"]\" stands where a directive should, such as Shape or Translate; remove it",
    );
}

#[test]
fn numbers_are_as_many_as_they_should_be() {
    refuses(
        "Translate 1 2",
        "a.pbrt:1:1: Translate needs 3 numbers; write Translate x y z",
    );
    refuses(
        "Translate 1 2 x",
        "a.pbrt:1:15: \"x\" is not a finite number",
    );
    refuses(
        "Scale 1 1 1e999",
        "a.pbrt:1:11: \"1e999\" is not a finite number",
    );
    refuses(
        "Rotate 3 0 0 0",
        "a.pbrt:1:1: the axis of Rotate has no length; write Rotate degrees x y z",
    );
    refuses(
        "LookAt 0 0 0 0 0 0 0 1 0",
        "a.pbrt:1:1: the camera stands where it looks at; move either point",
    );
    refuses(
        "LookAt 0 0 0 0 1 0 0 1 0",
        "a.pbrt:1:1: the up vector is parallel to the view direction, or has no length; choose another",
    );
    refuses(
        "Transform [1 0 0 1  0 1 0 0  0 0 1 0  0 0 0 1]",
        "a.pbrt:1:1: this matrix is a projection; its numbers 4, 8 and 12 must be 0 and its last one 1",
    );
}

#[test]
fn parameters_are_of_their_type() {
    for (text, message) in [
        (
            "\"radius\" 1",
            "a.pbrt:1:16: \"radius\" declares no parameter; write \"type name\", as in \"float radius\"",
        ),
        (
            "\"flaot radius\" 1",
            "a.pbrt:1:16: unknown parameter type \"flaot\"; did you mean \"float\"?",
        ),
        (
            "\"float radius\" true",
            "a.pbrt:1:31: \"true\" is not a finite number",
        ),
        (
            "\"float radius\" \"1\"",
            "a.pbrt:1:31: \"1\" is no value of type float",
        ),
        (
            "\"float radius\" 1e39",
            "a.pbrt:1:31: \"1e39\" is too large for a 32-bit float",
        ),
        (
            "\"integer radius\" 1.5",
            "a.pbrt:1:33: \"1.5\" is not an integer of 32 bits",
        ),
        (
            "\"float radius\" [1",
            "a.pbrt:1:16: the values of \"radius\" have no closing bracket; add ]",
        ),
        (
            "\"float radius\"",
            "a.pbrt:1:16: the parameter \"radius\" has no value; add one, or several in [ ]",
        ),
        (
            "\"float radius\" [1 2]",
            "a.pbrt:1:16: radius is one float, and this is 2 of type float; write one float",
        ),
        (
            "\"float radius\" -1",
            "a.pbrt:1:16: radius is -1; it must be from 1e-9 to 1e9",
        ),
        (
            "\"float radius",
            "a.pbrt:1:16: this text has no closing quote on its line; add it",
        ),
    ] {
        refuses(&format!("Shape \"sphere\" {text}"), message);
    }
}

#[test]
fn blocks_end_as_they_began() {
    refuses(
        "WorldBegin\nAttributeEnd",
        "a.pbrt:2:1: AttributeEnd has no AttributeBegin before it; add that, or remove this",
    );
    refuses(
        "WorldBegin\nAttributeBegin",
        "a.pbrt:2:1: this AttributeBegin has no AttributeEnd; add it",
    );
    let folder = Folder::new("AttributeBegin\nTransformEnd");
    let path = folder.path("a.pbrt").display().to_string();
    assert!(folder.read().unwrap_err().to_string().ends_with(&format!(
        "a.pbrt:2:1: TransformEnd meets the AttributeBegin of {path}:1:1; add AttributeEnd before"
    )));
    let deep = "AttributeBegin ".repeat(10_001);
    refuses(
        &deep,
        "a.pbrt:1:150001: AttributeBegin is nested more than 10000 deep; end some before",
    );
}

#[test]
fn names_are_defined() {
    refuses(
        "WorldBegin MakeNamedMaterial \"white\" \"string type\" \"diffuse\"\nNamedMaterial \"whit\" Shape \"sphere\"",
        "a.pbrt:2:1: material \"whit\" is not defined; did you mean \"white\"?",
    );
    refuses(
        "WorldBegin NamedMaterial \"a\"",
        "a.pbrt:1:12: material \"a\" is not defined; add MakeNamedMaterial",
    );
    refuses(
        "WorldBegin Material \"diffuse\" \"texture reflectance\" \"a\" Shape \"sphere\"",
        "a.pbrt:1:31: texture \"a\" is not defined; define it before",
    );
    refuses(
        "WorldBegin ObjectInstance \"a\"",
        "a.pbrt:1:12: object \"a\" is not defined; add ObjectBegin",
    );
    refuses(
        "MakeNamedMaterial \"a\"",
        "a.pbrt:1:1: the material \"a\" has no type; add \"string type\" \"diffuse\"",
    );
    refuses(
        "MakeNamedMaterial \"a\" \"string type\" \"mix\" \"string materials\" [\"a\" \"a\"] NamedMaterial \"a\" Shape \"sphere\"",
        "a.pbrt:1:1: this mix is a mix of itself; name other materials",
    );
}

#[test]
fn objects_are_not_nested() {
    refuses(
        "ObjectBegin \"a\" ObjectBegin \"b\"",
        "a.pbrt:1:17: objects are not defined within objects; add ObjectEnd before",
    );
    refuses(
        "ObjectBegin \"a\" ObjectInstance \"a\"",
        "a.pbrt:1:17: an object has no instances of others in it; place them in the world",
    );
    refuses(
        "ObjectBegin \"a\" ObjectEnd ObjectBegin \"a\"",
        "a.pbrt:1:27: the object \"a\" is defined twice; rename one",
    );
}

#[test]
fn meshes_are_whole() {
    for (text, message) in [
        (
            "",
            "Shape \"trianglemesh\" has no vertices; add \"point3 P\" [x y z ...]",
        ),
        (
            "\"point3 P\" [0 0 0 1 0 0]",
            "Shape \"trianglemesh\" has no faces; add \"integer indices\", 3 to a face",
        ),
        (
            "\"point3 P\" [0 0 0 1 0 0] \"integer indices\" [0 1]",
            "Shape \"trianglemesh\" has 2 indices, and a face has 3; add or remove some",
        ),
        (
            "\"point3 P\" [0 0 0 1 0 0] \"integer indices\" [0 1 -1]",
            "Shape \"trianglemesh\" has a negative index; indices count from 0",
        ),
        (
            "\"point3 P\" [0 0 0 1 0 0] \"integer indices\" [0 1 2]",
            "Shape \"trianglemesh\": triangle 0 has corner 2, and there are 2 vertices (counted from 0)",
        ),
        (
            "\"point3 P\" [0 0 0 1 0 0 1 1 1] \"point2 uv\" [0 0]",
            "Shape \"trianglemesh\": it has 1 texture coordinates for 3 vertices; give one for each, or none",
        ),
        (
            "\"point3 P\" [0 0 0 1 0 0 1 1 2e9]",
            "Shape \"trianglemesh\": vertex 2 is at (1, 1, 2000000000); coordinates are finite numbers within ±1e9",
        ),
    ] {
        refuses(
            &format!("Shape \"trianglemesh\" {text}"),
            &format!("a.pbrt:1:1: {message}"),
        );
    }
    refuses(
        "Shape \"plymesh\"",
        "a.pbrt:1:1: a plymesh needs \"string filename\" \"mesh.ply\"",
    );
    let folder = Folder::new("Shape \"plymesh\" \"string filename\" \"m.ply\"");
    let message = folder.plain(&folder.read().unwrap_err().to_string());
    assert!(
        message.starts_with("a.pbrt:1:1: m.ply: cannot read: "),
        "{message}"
    );
}

#[test]
fn transformations_have_an_inverse() {
    for text in ["Scale 1 0 1", "Scale 1e-20 1e-20 1e-20"] {
        refuses(
            &format!("{text} Shape \"sphere\""),
            &format!(
                "a.pbrt:1:{}: the transformation of this shape has no inverse in 32-bit floats; remove the scale of 0, or of almost 0, before it",
                text.len() + 2
            ),
        );
    }
    refuses(
        "Scale 1e10 1 1 Shape \"sphere\"",
        "a.pbrt:1:16: this shape reaches farther than 1e9 from the origin; scale the scene down",
    );
    let grown = "Scale 1e200 1 1 ".repeat(2);
    refuses(
        &grown,
        "a.pbrt:1:17: the transformation grows beyond 64-bit numbers here; use smaller ones",
    );
    refuses(
        "Scale 0 1 1 Camera \"perspective\"",
        "a.pbrt:1:13: the camera's transformation has no inverse; remove the scale of 0 before it",
    );
}

#[test]
fn a_camera_comes_first_and_has_a_field_of_view() {
    refuses(
        "Shape \"sphere\" Camera \"perspective\"",
        "a.pbrt:1:16: the camera must come before the world; move it before WorldBegin",
    );
    refuses(
        "Camera \"perspective\" \"float fov\" 180",
        "a.pbrt:1:22: fov is 180; it must be above 0 and below 180 degrees",
    );
    refuses(
        "Film \"rgb\" \"integer xresolution\" 0",
        "a.pbrt:1:12: xresolution is 0; it must be from 1 to 65535",
    );
    refuses(
        "Sampler \"halton\" \"integer pixelsamples\" 0",
        "a.pbrt:1:18: pixelsamples is 0; it must be from 1 to 4294967295"
            .replace("4294967295", &most_samples())
            .as_str(),
    );
}

fn most_samples() -> String {
    i32::try_from(ondine::film::MAX_SAMPLES)
        .unwrap_or(i32::MAX)
        .to_string()
}

#[test]
fn includes_end() {
    let folder = Folder::new("Include \"b.pbrt\"").with("b.pbrt", "\nInclude \"./a.pbrt\"");
    refuses_folder(
        &folder,
        "b.pbrt:2:1: a.pbrt includes b.pbrt includes ./a.pbrt: this would never end; remove one of these includes",
    );
    let mut folder = Folder::new("Include \"1\"");
    for depth in 1..70 {
        folder = folder.with(&depth.to_string(), format!("Include \"{}\"", depth + 1));
    }
    refuses_folder(
        &folder,
        "63:1:1: includes are nested more than 64 deep; include fewer levels",
    );
    let message = Folder::new("Include \"no.pbrt\"")
        .read()
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("a.pbrt:1:1: cannot include \"no.pbrt\": "),
        "{message}"
    );
    refuses(
        "Include",
        "a.pbrt:1:1: Include needs a text in quotes; write Include \"name\"",
    );
}

#[test]
fn skies_are_square_images() {
    let folder = Folder::new("LightSource \"infinite\" \"string filename\" \"sky.exr\"");
    exr::prelude::write_rgb_file(folder.path("sky.exr"), 3, 2, |_, _| (1f32, 1f32, 1f32)).unwrap();
    refuses_folder(
        &folder,
        "a.pbrt:1:1: the image of an infinite light is 3×2; it must be square (equal-area octahedral), convert it by pbrt's `imgtool makeequiarea`",
    );
}

#[test]
fn a_line_does_not_ask_for_a_mountain() {
    let long = "1 ".repeat(65);
    refuses(
        &format!("Attribute \"shape\" \"point3 P\" [{long}]"),
        "a.pbrt:1:19: P has more than 64 values, too many for all that follows; write it where it is used",
    );
    refuses(
        "Attribute \"shapes\" \"float radius\" 1",
        "a.pbrt:1:1: Attribute is for one of shape, light, material, medium, texture, not for \"shapes\"; write one of them",
    );
    let parts: String = (0..1025)
        .map(|part| {
            format!(
                "Shape \"disk\" \"float phimax\" {}\n",
                1.0 + part as f32 / 8.0
            )
        })
        .collect();
    refuses(
        &parts,
        "a.pbrt:1025:1: the scene has more than 1024 different parts of spheres, disks and cylinders; write some as meshes",
    );
    let object = "Shape \"sphere\" ".repeat(5000);
    let instances = "ObjectInstance \"o\"\n".repeat(4000);
    refuses(
        &format!("ObjectBegin \"o\" {object} ObjectEnd\n{instances}"),
        "a.pbrt:3357:1: the scene has more than 16777216 shapes; have fewer instances",
    );
}
