//! Renders that succeed.

use crate::{folder, names, ondine};
use serde_json::Value;

const TINY: &str = "render cornell --size 32x32 --spp 4";

#[test]
fn a_built_in_scene_renders_in_any_folder_to_an_exr_and_a_png() {
    let folder = folder();
    let run = ondine(&folder, TINY);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(run.stderr, "", "no bar where stderr is no terminal");
    assert_eq!(names(folder.path()), ["cornell.exr", "cornell.png"]);
    assert!((2..=5).contains(&run.stdout.lines().count()));
    for word in [
        "cornell.exr and cornell.png",
        "32x32",
        "4 samples",
        "paths/s",
        "rays/s",
        "hash",
    ] {
        assert!(run.stdout.contains(word), "{}\nlacks {word:?}", run.stdout);
    }
}

#[test]
fn json_is_one_object_with_every_key() {
    let folder = folder();
    let run = ondine(
        &folder,
        &format!("{TINY} --threads 2 --seed 7 --json --no-png -o a.exr"),
    );
    let json = run.json();
    let keys = "scene scene_hash width height region spp samples path_length strategy sampler seed threads camera \
                paths rays build_s load_s render_s mpaths_per_s mrays_per_s peak_rss_bytes stages queue_sizes \
                rejected_samples image_hash outputs interrupted version target_features";
    for key in keys.split_whitespace() {
        assert!(json.get(key).is_some(), "{key} is missing");
    }
    let expected: Value = serde_json::json!({
        "scene": "cornell", "camera": "camera", "width": 32, "height": 32, "region": [0, 0, 32, 32], "spp": 4,
        "seed": 7, "threads": 2, "strategy": "mis", "sampler": "sobol", "paths": 4096, "rejected_samples": 0,
        "outputs": ["a.exr"], "interrupted": false,
    });
    for (key, value) in expected.as_object().unwrap() {
        assert_eq!(&json[key], value, "{key}");
    }
    for stage in ["generate", "intersect", "shade", "nee", "accumulate"] {
        for key in ["seconds", "items", "lane_use"] {
            assert!(json["stages"][stage][key].is_number(), "{stage} {key}");
        }
    }
    assert_eq!(json["queue_sizes"][0], 4096);
    assert!(json["rays"].as_u64() > json["paths"].as_u64());
    assert_eq!(json["image_hash"].as_str().unwrap().len(), 64);
    assert_eq!(json["scene_hash"].as_str().unwrap().len(), 64);
    assert_eq!(names(folder.path()), ["a.exr"]);
}

#[test]
fn the_image_is_its_scene_settings_and_seed_and_nothing_else() {
    let folder = folder();
    let hash = |more: &str| {
        let run = ondine(&folder, &format!("{TINY} --json --no-png {more}"));
        run.json()["image_hash"].as_str().unwrap().to_owned()
    };
    let same = hash("");
    assert_eq!(same, hash("--threads 1 --wave 16"));
    assert_eq!(
        same,
        hash("--threads 3 --wave 5000 --time 1000 --aov normal")
    );
    assert_eq!(same, hash("--tonemap aces --exposure -2.5 -q"));
    for other in [
        "--seed 1",
        "--sampler pcg",
        "--strategy light",
        "--path-length 2",
        "--roulette 2",
    ] {
        assert_ne!(same, hash(other), "{other}");
    }
}

#[test]
fn a_crop_is_bit_for_bit_that_part_of_the_whole() {
    let folder = folder();
    let whole = ondine(&folder, &format!("{TINY} -o whole.exr --json")).json();
    let crop = "--crop 5,7,21,30";
    let part = ondine(&folder, &format!("{TINY} {crop} -o part.exr --json")).json();
    assert_ne!(part["image_hash"], whole["image_hash"]);
    assert_eq!(part["region"], serde_json::json!([5, 7, 21, 30]));
    let info = ondine(&folder, &format!("info whole.exr {crop} --json")).json();
    assert_eq!(info["image_hash"], part["image_hash"]);
}

#[test]
fn a_scene_file_is_rendered_with_its_own_settings_and_camera() {
    let folder = folder();
    let text = ondine(&folder, "scenes cornell").stdout;
    let text = text
        .replace("[camera]", "[cameras.left]")
        .replace("spp = 64", "spp = 3\nseed = 11")
        .replace("width = 256", "width = 24")
        .replace("height = 256", "height = 16")
        + "\n[cameras.right]\nposition = [0.5, 0.0, 2.9]\nlook_at = [0.0, 0.0, 0.0]\nvertical_fov = 40.0\n";
    std::fs::write(folder.path().join("my.room.toml"), text).unwrap();
    let left = ondine(&folder, "render my.room.toml --json").json();
    assert_eq!(left["camera"], "left");
    assert_eq!((&left["spp"], &left["seed"]), (&3.into(), &11.into()));
    assert_eq!((&left["width"], &left["height"]), (&24.into(), &16.into()));
    let files = ["my.room.exr", "my.room.png", "my.room.toml"];
    assert_eq!(names(folder.path()), files);
    let right = ondine(&folder, "render my.room.toml --camera right --json").json();
    assert_eq!(right["camera"], "right");
    assert_ne!(left["image_hash"], right["image_hash"]);
    assert_eq!(left["scene_hash"], right["scene_hash"]);
}

#[test]
fn what_is_no_scene_file_is_rendered_with_other_values() {
    let folder = folder();
    let obj = "v 0 0 0\nv 1 0 0.3\nv 0 1 0\nf 1 2 3\n";
    std::fs::write(folder.path().join("a.obj"), obj).unwrap();
    let info = ondine(&folder, "info a.obj --json").json();
    let render = |changes: &str| {
        let line = format!("render a.obj --size 16x12 --spp 1 --no-png --json {changes}");
        ondine(&folder, &line)
    };
    let plain = render("").json();
    let [position, fov] =
        ["position", "vertical_fov"].map(|key| info["cameras"][0][key].to_string());
    let same = render(&format!(
        "--set camera.position={position} --set camera.vertical_fov={fov}"
    ));
    for key in ["image_hash", "scene_hash"] {
        assert_eq!(same.json()[key], plain[key], "{key}");
    }
    let dark = render("--set materials.white.albedo=[0.1,0.1,0.1]").json();
    assert_ne!(dark["image_hash"], plain["image_hash"]);
    assert_ne!(dark["scene_hash"], plain["scene_hash"]);
    let refused = render("--set film.width=3");
    assert_eq!(refused.code, 2);
    assert!(
        refused.stderr.contains("is no .toml scene"),
        "{}",
        refused.stderr
    );
}

#[test]
fn time_alone_takes_as_many_samples_as_fit() {
    let folder = folder();
    let line = "render cornell --size 8x8 --time 0.3 --no-png --json";
    let json = ondine(&folder, line).json();
    let seconds = json["render_s"].as_f64().unwrap();
    assert!((0.3..10.0).contains(&seconds), "{seconds}");
    assert_eq!(json["interrupted"], false);
    assert_eq!(json["spp"], json["samples"]["max"]);
    let info = ondine(&folder, "info cornell.exr --json").json();
    assert_eq!(info["samples"], json["samples"]);
    assert_eq!(info["spp"], json["spp"]);
    assert_eq!(info["interrupted"], false);
}

#[test]
fn extra_layers_are_in_the_file() {
    let folder = folder();
    let line = format!("{TINY} --aov depth,albedo");
    assert_eq!(ondine(&folder, &line).code, 0);
    let info = ondine(&folder, "info cornell.exr").stdout;
    assert!(
        info.contains("albedo.R") && info.contains("depth.Z"),
        "{info}"
    );
    assert!(!info.contains("normal.X"), "{info}");
}

#[test]
fn samples_that_cannot_be_added_are_told_and_kept_out() {
    let folder = folder();
    let scene = folder.path().join("bright.toml");
    let text = "version = 1\n[camera]\nposition = [0, 0, 3]\nlook_at = [0, 0, 0]\nvertical_fov = 50\n\
                [[lights]]\nsphere = { center = [0, 0, 0], radius = 0.5 }\nradiance = [1e30, 1.0, 1.0]\n";
    std::fs::write(&scene, text).unwrap();
    let run = ondine(&folder, "render bright.toml --size 16x16 --spp 1 --json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let rejected = run.json()["rejected_samples"].as_u64().unwrap();
    assert!(rejected > 0);
    let told = format!("warning: {rejected} of 256 samples were not finite or not below 2^32");
    assert!(run.stderr.contains(&told), "{}", run.stderr);
}
