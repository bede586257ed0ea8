//! Help, `info` and `scenes`.

use crate::{command, folder, ondine};
use ondine::scene::builtin;
use std::process::Stdio;

#[test]
fn help_mentions_every_option() {
    let folder = folder();
    let help = ondine(&folder, "render --help");
    assert_eq!((help.code, help.stderr.as_str()), (0, ""));
    let options = "-o --output --spp --size --path-length --strategy --sampler --seed --threads --camera --crop --time \
                   --aov --tonemap --exposure --no-png --wave --roulette --json --quiet uniform cosine light mis pcg \
                   sobol linear reinhard aces albedo normal depth";
    for option in options.split_whitespace() {
        assert!(help.stdout.contains(option), "{option}");
    }
    let help = ondine(&folder, "--help");
    assert_eq!(help.code, 0);
    for name in ["render", "info", "scenes"] {
        assert!(help.stdout.contains(name), "{name}");
        assert_eq!(ondine(&folder, &format!("{name} --help")).code, 0);
    }
    let version = ondine(&folder, "--version");
    assert_eq!(version.code, 0);
    assert!(version.stdout.contains(env!("CARGO_PKG_VERSION")));
}

#[test]
fn scenes_lists_every_scene_and_prints_each_to_the_byte() {
    let folder = folder();
    let list = ondine(&folder, "scenes").stdout;
    assert_eq!(list.lines().count(), builtin::ALL.len());
    let column = |line: &str, title: &str| line.find(title).unwrap();
    let columns: Vec<usize> = list
        .lines()
        .zip(builtin::ALL)
        .map(|(line, scene)| {
            assert!(line.starts_with(scene.name), "{line}");
            column(line, scene.title())
        })
        .collect();
    assert!(columns.iter().all(|&at| at == columns[0]), "{list}");
    for scene in builtin::ALL {
        let run = ondine(&folder, &format!("scenes {}", scene.name));
        assert_eq!((run.code, run.stdout.as_str()), (0, scene.text));
        let info = ondine(&folder, &format!("info {}", scene.name));
        assert_eq!(info.code, 0, "{}", info.stderr);
    }
}

#[test]
fn info_tells_what_a_scene_holds() {
    let folder = folder();
    let json = ondine(&folder, "info cornell --json").json();
    assert_eq!(
        (&json["width"], &json["height"]),
        (&256.into(), &256.into())
    );
    assert_eq!(json["objects"], serde_json::json!({"quad": 6, "sphere": 2}));
    assert_eq!(json["lights"], serde_json::json!({"sphere": 1}));
    assert_eq!(json["materials"], serde_json::json!({"lambert": 4}));
    assert_eq!(json["environment"], serde_json::Value::Null);
    assert_eq!(json["defaults"]["spp"], 64);
    assert_eq!(json["cameras"][0]["name"], "camera");
    let text = ondine(&folder, "info cornell").stdout;
    for word in [
        "256x256",
        "6 × quad",
        "mis",
        json["scene_hash"].as_str().unwrap(),
    ] {
        assert!(text.contains(word), "{text}\nlacks {word}");
    }
}

#[test]
fn the_scene_hash_is_of_the_text_and_of_its_image() {
    let folder = folder();
    let scene = |comment: &str| {
        let text = format!(
            "version = 1\n{comment}\n[camera]\nposition = [0.0, 0.0, 1.0]\nlook_at = [0.0, 0.0, 0.0]\n\
             vertical_fov = 50.0\n[environment]\nimage = \"sky.exr\"\n"
        );
        std::fs::write(folder.path().join("sky.toml"), text).unwrap();
    };
    let sky = |seed: u32| {
        let line = format!("render cornell --size 8x4 --spp 1 --no-png -o sky.exr --seed {seed}");
        assert_eq!(ondine(&folder, &line).code, 0);
    };
    let hash = || ondine(&folder, "info sky.toml --json").json()["scene_hash"].clone();
    scene("");
    sky(1);
    let first = hash();
    assert_eq!(first, hash());
    scene("# a comment");
    assert_ne!(first, hash());
    scene("");
    assert_eq!(first, hash());
    sky(2);
    assert_ne!(first, hash());

    // By its own name the image would replace the sky that it shows.
    let before = std::fs::read(folder.path().join("sky.exr")).unwrap();
    let run = ondine(&folder, "render sky.toml --size 4x4 --spp 1");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("name another output"), "{}", run.stderr);
    assert_eq!(
        std::fs::read(folder.path().join("sky.exr")).unwrap(),
        before
    );
}

#[test]
fn info_counts_triangles_and_tells_what_was_left_out() {
    let folder = folder();
    let mesh = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 1 1\n";
    std::fs::write(folder.path().join("a.ply"), mesh).unwrap();
    let scene = "version = 1\n[camera]\nposition = [0, 0, 3]\nlook_at = [0, 0, 0]\nvertical_fov = 50\n\
        [[objects]]\nmesh = { file = \"a.ply\" }\n[[objects]]\nmesh = { file = \"a.ply\" }\n\
        [[lights]]\npoint = { position = [0, 0, 3], intensity = [1, 1, 1] }\n";
    std::fs::write(folder.path().join("a.toml"), scene).unwrap();
    let json = ondine(&folder, "info a.toml --json").json();
    assert_eq!(json["triangles"], 4);
    assert_eq!(json["instances"], 2);
    assert_eq!(json["meshes"]["count"], 1);
    assert_eq!(json["meshes"]["bytes"], 4 * 12 + 2 * 12);
    assert_eq!(json["memory_bytes"], json["meshes"]["bytes"]);
    assert_eq!(json["lights"], serde_json::json!({"point": 1}));
    assert_eq!(
        json["warnings"][0],
        "a.ply: 1 triangle without an area left out"
    );
    let text = ondine(&folder, "info a.ply").stdout;
    for line in [
        "triangles    2 (instances: 1, meshes: 1, 0.0 MiB)\n",
        "environment  gradient\n",
        "warning      a.ply: 1 triangle without an area left out\n",
    ] {
        assert!(text.contains(line), "{text}\nlacks {line:?}");
    }
}

#[test]
fn info_computes_the_hash_that_the_render_told() {
    let folder = folder();
    let render = ondine(&folder, "render glass --size 20x10 --spp 17 --json").json();
    let info = ondine(&folder, "info glass.exr --json").json();
    for key in [
        "image_hash",
        "scene_hash",
        "samples",
        "rejected_samples",
        "spp",
        "seed",
        "strategy",
        "sampler",
        "path_length",
        "camera",
        "rays",
        "width",
        "height",
        "region",
        "version",
        "target_features",
    ] {
        assert_eq!(info[key], render[key], "{key}");
    }
    assert_eq!(
        info["parts"][0]["data_window"],
        serde_json::json!([0, 0, 20, 10])
    );
    let text = ondine(&folder, "info glass.exr").stdout;
    for word in [
        "20x10",
        "17 in each pixel",
        render["image_hash"].as_str().unwrap(),
    ] {
        assert!(text.contains(word), "{text}\nlacks {word}");
    }
}

#[test]
fn info_tells_an_image_that_others_wrote_from_one_of_ours_that_is_damaged() {
    let folder = folder();
    let path = folder.path().join("other.exr");
    exr::prelude::write_rgb_file(&path, 4, 2, |_, _| (1.0f32, 0.5f32, 0.25f32)).unwrap();
    let info = ondine(&folder, "info other.exr --json").json();
    assert_eq!(
        info["parts"][0]["data_window"],
        serde_json::json!([0, 0, 4, 2])
    );
    assert!(info.get("image_hash").is_none());
    let run = ondine(&folder, "info other.exr --crop 0,0,1,1");
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains("no image that Ondine wrote"),
        "{}",
        run.stderr
    );

    assert_eq!(
        ondine(&folder, "render cornell --size 16x16 --spp 1").code,
        0
    );
    let path = folder.path().join("cornell.exr");
    let whole = std::fs::read(&path).unwrap();
    std::fs::write(&path, &whole[..whole.len() - 50]).unwrap();
    let run = ondine(&folder, "info cornell.exr");
    assert_eq!((run.code, run.stdout.as_str()), (2, ""));
    assert!(
        run.stderr.starts_with("error: cornell.exr: "),
        "{}",
        run.stderr
    );
}

#[test]
fn a_reader_that_has_had_enough_is_no_error() {
    let folder = folder();
    for line in ["scenes", "scenes cornell", "info cornell --json", "--help"] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = command(folder.path(), line)
            .stdout(writer)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{line}");
        assert!(output.stderr.is_empty(), "{line}");
    }
}
