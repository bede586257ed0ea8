//! Small valid files of each format, with as much of the format in them as fits.

use std::io::Cursor;

/// The files of one scene.
pub struct Files {
    /// The one that is opened.
    pub scene: &'static str,
    pub all: Vec<(&'static str, Vec<u8>)>,
    /// How many of them, from the first, are damaged.
    pub damaged: usize,
}

#[derive(Clone, Copy)]
pub enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A pyramid: position, normal, texture coordinates of each vertex.
const VERTICES: [[f32; 8]; 5] = [
    [0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.5, 0.5],
    [-1.0, 0.0, -1.0, -0.6, 0.5, -0.6, 0.0, 0.0],
    [-1.0, 0.0, 1.0, -0.6, 0.5, 0.6, 0.0, 1.0],
    [1.0, 0.0, 1.0, 0.6, 0.5, 0.6, 1.0, 1.0],
    [1.0, 0.0, -1.0, 0.6, 0.5, -0.6, 1.0, 0.0],
];

const TRIANGLES: [[u16; 3]; 4] = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];

const ONE_MESH: &str = r#"version = 1
[camera]
position = [0.0, 1.0, 4.0]
look_at = [0.0, 0.5, 0.0]
vertical_fov = 45.0
[materials.white]
type = "lambert"
albedo = [0.7, 0.7, 0.7]
[[objects]]
mesh = { file = "FILE" }
material = "white"
[environment]
constant = [1.0, 1.0, 1.0]
"#;

fn scene_of(file: &str) -> Vec<u8> {
    ONE_MESH.replace("FILE", file).into_bytes()
}

fn ply_bytes(encoding: Encoding) -> Vec<u8> {
    let format = match encoding {
        Encoding::Ascii => "ascii",
        Encoding::LittleEndian => "binary_little_endian",
        Encoding::BigEndian => "binary_big_endian",
    };
    let mut file = format!(
        "ply\nformat {format} 1.0\ncomment a pyramid\nelement vertex 5\n{}property uchar red\nelement face 5\n\
         property list uchar int vertex_indices\nelement edge 1\nproperty double length\nend_header\n",
        ["x", "y", "z", "nx", "ny", "nz", "u", "v"].map(|name| format!("property float {name}\n")).concat(),
    )
    .into_bytes();
    let mut faces: Vec<Vec<i32>> = TRIANGLES
        .map(|corners| corners.map(i32::from).to_vec())
        .to_vec();
    faces.push(vec![1, 4, 3, 2]);
    match encoding {
        Encoding::Ascii => {
            for vertex in VERTICES {
                file.extend(vertex.map(|c| format!("{c} ")).concat().bytes());
                file.extend(b"255\n");
            }
            for face in faces {
                let corners: Vec<String> = face.iter().map(i32::to_string).collect();
                file.extend(format!("{} {}\n", face.len(), corners.join(" ")).bytes());
            }
            file.extend(b"1.5\n");
        }
        Encoding::LittleEndian | Encoding::BigEndian => {
            let is_little = matches!(encoding, Encoding::LittleEndian);
            let word = |bits: u32| {
                if is_little {
                    bits.to_le_bytes()
                } else {
                    bits.to_be_bytes()
                }
            };
            for vertex in VERTICES {
                file.extend(vertex.iter().flat_map(|c| word(c.to_bits())));
                file.push(255);
            }
            for face in faces {
                file.push(face.len() as u8);
                file.extend(face.iter().flat_map(|&corner| word(corner as u32)));
            }
            file.extend([0; 8]);
        }
    }
    file
}

pub fn ply(encoding: Encoding) -> Files {
    Files {
        scene: "scene.toml",
        all: vec![
            ("mesh.ply", ply_bytes(encoding)),
            ("scene.toml", scene_of("mesh.ply")),
        ],
        damaged: 1,
    }
}

pub fn obj() -> Files {
    const OBJ: &str = "# a pyramid\nmtllib mesh.mtl\no pyramid\nv 0 1 0\nv -1 0 -1\nv -1 0 1 1.0\nv 1 0 1 0.5 0.5 0.5\n\
        v 1 0 -1\nvt 0.5 0.5\nvt 0 0\nvt 0 1 0\nvt 1 1\nvn 0 1 0\nvn -0.6 0.5 0\ng sides\nusemtl paint\ns 1\nf 1/1/1 2/2/2 3/3/2\n\
        f 1/1 3/3 4/4\nf 1//1 4//2 5//2\nusemtl lamp\nf -5 -1 -4\ns off\nf 2 5 4 3\n";
    const MTL: &str = "newmtl paint\nKd 0.7 0.6 0.5\nKs 0.1 0.1 0.1\nNs 30\nd 1.0\nillum 2\nmap_Kd paint.png\n\n\
        newmtl lamp\nKd 0 0 0\nKe 5 4 3\nNi 1.5\nTr 0\n";
    Files {
        scene: "scene.toml",
        all: vec![
            ("mesh.obj", OBJ.into()),
            ("mesh.mtl", MTL.into()),
            ("scene.toml", scene_of("mesh.obj")),
            ("paint.png", picture(image::ImageFormat::Png)),
        ],
        damaged: 2,
    }
}

/// Vertices, then corners.
fn gltf_buffer() -> Vec<u8> {
    let corners = TRIANGLES
        .iter()
        .flatten()
        .flat_map(|corner| corner.to_le_bytes());
    VERTICES
        .iter()
        .flatten()
        .flat_map(|c| c.to_le_bytes())
        .chain(corners)
        .collect()
}

fn gltf_json(buffer: &str) -> String {
    r#"{
"asset": {"version": "2.0"},
"extensionsUsed": ["KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_ior",
 "KHR_materials_transmission", "KHR_texture_transform"],
"extensions": {"KHR_lights_punctual": {"lights": [
 {"type": "point", "intensity": 40, "color": [1, 0.9, 0.8]},
 {"type": "spot", "intensity": 40, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.6}},
 {"type": "directional", "intensity": 3}]}},
"scene": 0,
"scenes": [{"nodes": [0, 3, 4, 5]}],
"nodes": [
 {"name": "root", "children": [1, 2], "rotation": [0, 0.7071068, 0, 0.7071068]},
 {"mesh": 0, "translation": [1, 0, 0], "scale": [0.5, 1, 2]},
 {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0.5, 0, 1]},
 {"camera": 0, "translation": [0, 1, 5]},
 {"extensions": {"KHR_lights_punctual": {"light": 1}}, "translation": [0, 3, 0], "rotation": [-0.7071068, 0, 0, 0.7071068]},
 {"extensions": {"KHR_lights_punctual": {"light": 2}}, "children": [6]},
 {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [2, 2, 2]}],
"cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "aspectRatio": 1.5}}],
"meshes": [{"primitives": [
 {"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0},
 {"attributes": {"POSITION": 0}, "indices": 3, "material": 1, "mode": 5},
 {"attributes": {"POSITION": 0}, "material": 2, "mode": 6}]}],
"materials": [
 {"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.7, 0.6, 1], "metallicFactor": 0.5, "roughnessFactor": 0.4,
  "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.1, 0], "rotation": 0.3, "scale": [2, 2]}}},
  "metallicRoughnessTexture": {"index": 0}}, "normalTexture": {"index": 0, "scale": 0.5}, "alphaMode": "MASK", "alphaCutoff": 0.4},
 {"emissiveFactor": [1, 0.5, 0.2], "emissiveTexture": {"index": 0}, "doubleSided": true,
  "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}},
 {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.45}}}],
"textures": [{"source": 0, "sampler": 0}],
"samplers": [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}],
"images": [{"uri": "paint.png"}],
"accessors": [
 {"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3", "min": [-1, 0, -1], "max": [1, 1, 1]},
 {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "count": 5, "type": "VEC3"},
 {"bufferView": 0, "byteOffset": 24, "componentType": 5126, "count": 5, "type": "VEC2"},
 {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
"bufferViews": [
 {"buffer": 0, "byteLength": 160, "byteStride": 32, "target": 34962},
 {"buffer": 0, "byteOffset": 160, "byteLength": 24, "target": 34963}],
"buffers": [{BUFFER"byteLength": 184}]
}"#
    .replace("BUFFER", buffer)
}

pub fn gltf() -> Files {
    Files {
        scene: "scene.gltf",
        all: vec![
            ("scene.gltf", gltf_json("\"uri\": \"mesh.bin\", ").into()),
            ("mesh.bin", gltf_buffer()),
            ("paint.png", picture(image::ImageFormat::Png)),
        ],
        damaged: 2,
    }
}

pub fn glb() -> Files {
    let (mut json, binary) = (gltf_json("").into_bytes(), gltf_buffer());
    json.resize(json.len().next_multiple_of(4), b' ');
    let word = |length: usize| (length as u32).to_le_bytes();
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend(word(12 + 8 + json.len() + 8 + binary.len()));
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", binary)] {
        file.extend(word(chunk.len()));
        file.extend(kind);
        file.extend(chunk);
    }
    Files {
        scene: "scene.glb",
        all: vec![
            ("scene.glb", file),
            ("paint.png", picture(image::ImageFormat::Png)),
        ],
        damaged: 1,
    }
}

pub fn pbrt() -> Files {
    const SCENE: &str = r#"# a little of everything
LookAt 0 2 6  0 0.5 0  0 1 0
Camera "perspective" "float fov" [ 45 ] "float lensradius" 0.01 "float focaldistance" [ 5 ]
Film "rgb" "integer xresolution" [ 64 ] "integer yresolution" 48 "string filename" "out.exr"
Sampler "zsobol" "integer pixelsamples" 16
Integrator "volpath" "integer maxdepth" [ 5 ]
PixelFilter "gaussian" "float xradius" 1.5
WorldBegin
LightSource "infinite" "rgb L" [ 0.3 0.4 0.5 ] "float scale" 2
LightSource "distant" "point3 from" [ 1 2 3 ] "point3 to" [ 0 0 0 ] "blackbody L" 5000
LightSource "point" "rgb I" [ 5 5 5 ] "point3 from" [ 0 3 0 ]
LightSource "spot" "rgb I" [ 5 5 5 ] "point3 from" [ 0 3 2 ] "point3 to" [ 0 0 0 ] "float coneangle" 40
Texture "paint" "spectrum" "imagemap" "string filename" "paint.png" "string wrap" "clamp"
Texture "scaled" "spectrum" "scale" "texture tex" "paint" "rgb scale" [ 0.5 0.5 0.5 ]
MakeNamedMaterial "matte" "string type" "diffuse" "texture reflectance" "paint"
MakeNamedMaterial "metal" "string type" "conductor" "spectrum eta" "metal-Cu-eta" "spectrum k" "metal-Cu-k" "float roughness" 0.2
MakeNamedMaterial "coat" "string type" "coateddiffuse" "rgb reflectance" [ 0.4 0.5 0.6 ] "float roughness" 0.1
AttributeBegin
  NamedMaterial "matte"
  Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point3 P" [ -3 0 -3  -3 0 3  3 0 3  3 0 -3 ]
    "normal N" [ 0 1 0  0 1 0  0 1 0  0 1 0 ] "point2 uv" [ 0 0 0 1 1 1 1 0 ]
AttributeEnd
AttributeBegin
  Translate 1 0.5 0
  Rotate 30 0 1 0
  Scale 0.5 0.5 -0.5
  Material "dielectric" "float eta" 1.5
  Shape "sphere" "float radius" 0.8
  ReverseOrientation
  Material "coateddiffuse" "float roughness" [ 0.3 ]
  Shape "disk" "float height" 1 "float radius" 0.4 "float innerradius" 0.1
AttributeEnd
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [ 8 8 8 ] "bool twosided" true
  Shape "bilinearmesh" "point3 P" [ -0.5 2.5 0  0.5 2.5 0  -0.5 2.5 1  0.5 2.5 1 ]
AttributeEnd
ObjectBegin "thing"
  NamedMaterial "metal"
  Shape "plymesh" "string filename" "mesh.ply"
  Shape "loopsubdiv" "integer levels" 1 "integer indices" [ 0 1 2 ] "point3 P" [ 0 0 0 1 0 0 0 1 0 ]
ObjectEnd
AttributeBegin
  ConcatTransform [ 1 0 0 0  0 1 0 0  0 0 1 0  -1 0.2 0 1 ]
  ObjectInstance "thing"
AttributeEnd
Include "more.pbrt"
"#;
    const MORE: &str = "AttributeBegin\nCoordinateSystem \"here\"\nTransform [ 1 0 0 0 0 1 0 0 0 0 1 0 0 1 0 1 ]\n\
        NamedMaterial \"coat\"\nObjectInstance \"thing\"\nCoordSysTransform \"here\"\nShape \"sphere\" \"float radius\" [ 0.1 ]\nAttributeEnd\n";
    Files {
        scene: "scene.pbrt",
        all: vec![
            ("scene.pbrt", SCENE.into()),
            ("more.pbrt", MORE.into()),
            ("mesh.ply", ply_bytes(Encoding::LittleEndian)),
            ("paint.png", picture(image::ImageFormat::Png)),
        ],
        damaged: 2,
    }
}

/// Meshes, transforms, textures and lights without a surface, in the program's own format.
pub fn scene() -> Files {
    const SCENE: &str = r#"version = 1
[camera]
position = [0.0, 1.0, 4.0]
look_at = [0.0, 0.5, 0.0]
vertical_fov = 45.0
[materials.white]
type = "lambert"
albedo = { texture = "paint.png" }
[materials.paint]
type = "principled"
base_color = [0.7, 0.6, 0.5]
metallic = 0.5
roughness = 0.4
[[objects]]
mesh = { file = "mesh.ply" }
transform = { translate = [0.5, 0.0, 0.0], rotate_degrees = [0.0, 30.0, 0.0], scale = 1.5 }
material = "white"
[[objects]]
mesh = { file = "mesh.ply" }
transform = { translate = [-1.5, 0.0, 0.0] }
material = "paint"
[[lights]]
mesh = { file = "mesh.ply" }
transform = { translate = [0.0, 3.0, 0.0], scale = 0.25 }
radiance = [5.0, 5.0, 5.0]
[environment]
constant = [1.0, 1.0, 1.0]
"#;
    Files {
        scene: "scene.toml",
        all: vec![
            ("scene.toml", SCENE.into()),
            ("mesh.ply", ply_bytes(Encoding::LittleEndian)),
            ("paint.png", picture(image::ImageFormat::Png)),
        ],
        damaged: 1,
    }
}

/// A picture of a few pixels.
fn picture(format: image::ImageFormat) -> Vec<u8> {
    let color = |x, y| image::Rgb([x as u8 * 30, y as u8 * 60, 90]);
    let pixels = image::DynamicImage::ImageRgb8(image::RgbImage::from_fn(7, 4, color));
    let pixels = match format {
        image::ImageFormat::Hdr => pixels.to_rgb32f().into(),
        _ => pixels,
    };
    let mut file = Cursor::new(Vec::new());
    pixels.write_to(&mut file, format).unwrap();
    file.into_inner()
}

/// A mesh with a picture on it.
pub fn textured(format: image::ImageFormat, paint: &'static str) -> Files {
    let texture = format!("{{ texture = \"{paint}\" }}");
    let scene = ONE_MESH
        .replace("FILE", "mesh.ply")
        .replace("[0.7, 0.7, 0.7]", &texture);
    Files {
        scene: "scene.toml",
        all: vec![
            (paint, picture(format)),
            ("mesh.ply", ply_bytes(Encoding::Ascii)),
            ("scene.toml", scene.into()),
        ],
        damaged: 1,
    }
}
