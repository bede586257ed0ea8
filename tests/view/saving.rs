//! What is saved has the bits of the command line that comes with it.

use crate::Server;
use percent_encoding::percent_decode_str;
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;

/// Runs a command line as a shell does, with `ondine` on the path, and gives the hash of the image that it wrote.
fn run(folder: &Path, line: &str) -> String {
    let program = Path::new(env!("CARGO_BIN_EXE_ondine")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    let output = Command::new("sh")
        .args(["-c", line])
        .env("PATH", path)
        .current_dir(folder)
        .output()
        .unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{line}\n{error}");
    let said = String::from_utf8(output.stdout).unwrap();
    let hash = said
        .lines()
        .find_map(|line| line.strip_prefix("Image hash "));
    hash.unwrap().to_owned()
}

/// Saves a side, and makes sure that its command line renders the same.
fn saves_the_same(server: &Server, folder: &Path, side: usize) -> String {
    let saved = server.get(&format!("image.exr?side={side}"));
    assert_eq!(saved.code, 200, "{}", saved.text());
    let line = saved.header("ondine-command-line").unwrap();
    let line = percent_decode_str(line).decode_utf8().unwrap().into_owned();
    assert!(line.starts_with("ondine render "), "{line}");
    let disposition = saved.header("content-disposition").unwrap();
    let name = disposition.split('"').nth(1).unwrap();
    assert!(line.contains(name), "{line} writes {name}");
    let path = folder.join("saved.exr");
    std::fs::write(&path, &saved.body).unwrap();
    let (film, saved) = ondine::film::exr::read(&path).unwrap();
    assert_eq!(run(folder, &line), film.image_hash(), "{line}");
    let (_, rendered) = ondine::film::exr::read(&folder.join(name)).unwrap();
    assert_eq!(saved.difference(&rendered), None, "{line}");
    assert_eq!(saved.spp, rendered.spp);
    line
}

fn with(view: &Value, changes: &[(&str, Value)]) -> Value {
    let mut view = view.clone();
    for (pointer, value) in changes {
        *view
            .pointer_mut(pointer)
            .unwrap_or_else(|| panic!("{pointer}")) = value.clone();
    }
    view
}

#[test]
fn saved_images_have_the_bits_of_their_command_lines() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(
        folder.path(),
        "cornell --size 48x32 --threads 2 --set materials.red.albedo=[0.1,0.2,0.3]",
    );
    let mut page = server.open();
    let start = page.view.clone();
    let plain = saves_the_same(&server, folder.path(), 0);
    assert!(
        plain.contains("'--set=materials.red.albedo=[0.1,0.2,0.3]'"),
        "{plain}"
    );

    // A camera that moved, with numbers that no decimal of few digits is; other materials; two sides.
    let mut other = start["sides"][0].clone();
    (other["strategy"], other["sampler"]) = ("cosine".into(), "pcg".into());
    (other["seed"], other["path_length"], other["roulette"]) = (17.into(), 7.into(), 3.into());
    let view = with(
        &start,
        &[
            ("/lens/position", json!([0.1, 1.0 / 3.0, 2.6543219])),
            ("/lens/look_at", json!([-1e-7, 0.2, -0.7])),
            ("/lens/aperture_radius", json!(0.01)),
            ("/lens/focus_distance", json!(3.1234567)),
            ("/sides", json!([start["sides"][0], other])),
            (
                "/materials",
                json!({
                    "white": {"type": "lambert", "albedo": [0.5, 0.6, 0.7]},
                    "green": {"type": "conductor", "roughness": 0.15, "reflectance": [0.9, 0.8, 0.3]},
                    "blue": {"type": "principled", "base_color": [0.2, 0.3, 0.9], "metallic": 0.5, "roughness": 0.3, "ior": 1.4},
                }),
            ),
            ("/aovs", json!({"first_hits": true, "lengths": true})),
        ],
    );
    page.look(&view);
    for side in [0, 1] {
        let line = saves_the_same(&server, folder.path(), side);
        assert!(line.contains("--aov=albedo,normal,depth,bounces"), "{line}");
    }
    // While it is paused in the middle of a pass, and after it went on.
    page.say(&json!({"type": "pause", "paused": true}));
    saves_the_same(&server, folder.path(), 1);
    page.say(&json!({"type": "pause", "paused": false}));
    page.wait_for_samples(64);
    saves_the_same(&server, folder.path(), 0);
    assert_eq!(server.get("image.exr?side=2").code, 409);
    assert_eq!(server.get("image.exr?side=-1").code, 400);
}

#[test]
fn a_scene_of_another_program_is_saved_likewise() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/still-life.glb");
    std::fs::copy(scene, folder.path().join("still life.glb")).unwrap();
    std::fs::rename(
        folder.path().join("still life.glb"),
        folder.path().join("still-life.glb"),
    )
    .unwrap();
    let server = Server::start(folder.path(), "still-life.glb --size 40x30 --threads 2");
    let mut page = server.open();
    let material = page.hello["materials"][0].clone();
    let name = material["name"].as_str().unwrap();
    let mut position = page.view["lens"]["position"].clone();
    position[0] = (position[0].as_f64().unwrap() * 0.8 + 0.123).into();
    let mut changed = material["material"].clone();
    assert_eq!(changed["type"], "principled");
    changed["roughness"] = 0.77.into();
    let view = with(
        &page.view,
        &[
            ("/lens/position", position),
            ("/materials", json!({name: changed})),
        ],
    );
    page.look(&view);
    let line = saves_the_same(&server, folder.path(), 0);
    assert!(line.contains(".roughness=0.77"), "{line}");
}

#[test]
fn a_png_is_the_one_that_render_writes() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), "sky --size 32x24 --threads 1 --spp 16");
    let mut page = server.open();
    page.wait("the end", |page| page.stats["state"] == "done");
    let saved = server.get("image.png?tonemap=aces&exposure=-0.5");
    assert_eq!(saved.code, 200);
    assert_eq!(saved.header("content-type"), Some("image/png"));
    let line = server.get("command?tonemap=aces&exposure=-0.5");
    let line = line.text();
    assert!(line.contains("--tonemap=aces --exposure=-0.5"), "{line}");
    run(folder.path(), line);
    let name = line
        .rsplit_once("--output=")
        .unwrap()
        .1
        .replace(".exr", ".png");
    assert!(saved.body == std::fs::read(folder.path().join(name)).unwrap());
    for wrong in [
        "tonemap=film",
        "exposure=65",
        "exposure=NaN",
        "side=x",
        "other=1",
    ] {
        assert!(
            [400, 409].contains(&server.get(&format!("image.png?{wrong}")).code),
            "{wrong}"
        );
    }
}

#[test]
fn nothing_can_be_saved_that_nobody_looks_at() {
    let server = Server::start(Path::new("."), "cornell --size 32x32 --threads 1");
    let saved = server.get("image.exr");
    assert_eq!(saved.code, 409);
    assert_eq!(saved.text(), "no page is open, so nothing is rendered");
}
