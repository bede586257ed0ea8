//! Light probes and the comparison of the double sum with rays, as their users meet them.

use super::refusals::refuses;
use crate::{folder, names, ondine};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap().iter();
    list.flat_map(|item| match item {
        Value::Array(_) => numbers(item),
        _ => vec![item.as_f64().unwrap()],
    })
    .collect()
}

#[test]
fn a_probe_is_written_as_a_file_that_a_scene_reads() {
    let folder = folder();
    let line = "sh probe cornell --at 0,0,0 --bands 3 --spp 256 -o probe.json --json";
    let report = ondine(&folder, line).json();
    assert_eq!(
        (&report["l_max"], &report["coefficients"]),
        (&3.into(), &16.into())
    );
    assert_eq!((&report["spp"], &report["sets"]), (&256.into(), &16.into()));
    assert_eq!(report["outputs"], serde_json::json!(["probe.json"]));
    let probe = &report["probes"][0];
    assert_eq!(numbers(&probe["position"]), [0.0; 3]);

    let text = std::fs::read_to_string(folder.path().join("probe.json")).unwrap();
    let file: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (&file["format"], &file["l_max"]),
        (&"ondine-sh".into(), &3.into())
    );
    for key in ["coefficients", "standard_errors"] {
        assert_eq!(numbers(&file[key]), numbers(&probe[key]), "{key}");
        assert_eq!(numbers(&file[key]).len(), 48, "{key}");
    }

    let sky = ondine(&folder, "scenes sh-grace").stdout;
    let scene = sky.replace("sh = \"grace\"", "sh = \"probe.json\"");
    assert_ne!(scene, sky);
    std::fs::write(folder.path().join("a.toml"), &scene).unwrap();
    let info = ondine(&folder, "info a.toml --json").json();
    let environment = &info["environment"];
    assert_eq!(
        (&environment["sh"], &environment["l_max"]),
        (&"probe.json".into(), &3.into())
    );
    let run = ondine(&folder, "info a.toml");
    assert!(
        run.stdout
            .contains("spherical harmonics probe.json to l = 3"),
        "{}",
        run.stdout
    );

    // The file's bytes are part of the scene's hash.
    std::fs::write(folder.path().join("probe.json"), text + " ").unwrap();
    let other = ondine(&folder, "info a.toml --json").json();
    assert_ne!(other["scene_hash"], info["scene_hash"]);
    let line = "render a.toml --size 24x8 --spp 4";
    assert_eq!(ondine(&folder, line).code, 0);
    assert_eq!(
        names(folder.path()),
        ["a.exr", "a.png", "a.toml", "probe.json"]
    );
}

#[test]
fn a_grid_is_one_file_with_x_fastest_and_each_probe_as_if_alone_but_for_its_random_numbers() {
    let folder = folder();
    let line = "sh probe cornell --grid -0.5,0,0:0.5,0,1:3,1,2 --bands 1 --spp 64 -o grid.json";
    let run = ondine(&folder, line);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stdout
            .contains("6 probes to l = 1 (4 coefficients), 64 samples each"),
        "{}",
        run.stdout
    );
    let text = std::fs::read_to_string(folder.path().join("grid.json")).unwrap();
    let file: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(file["format"], "ondine-sh-grid");
    let probes = file["probes"].as_array().unwrap();
    let places: Vec<Vec<f64>> = probes
        .iter()
        .map(|probe| numbers(&probe["position"]))
        .collect();
    let want = [
        [-0.5, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.5, 0.0, 0.0],
        [-0.5, 0.0, 1.0],
        [0.0, 0.0, 1.0],
        [0.5, 0.0, 1.0],
    ];
    assert_eq!(places, want);
    assert!(
        probes
            .iter()
            .all(|probe| numbers(&probe["coefficients"]).len() == 12)
    );
    refuses(
        &folder,
        "sh probe cornell --grid 0,0,0:1,1,1:2,2,2 -o grid.csv",
        &["a grid is written as JSON; use -o grid.json"],
    );
}

#[test]
fn a_probe_that_cannot_be_baked_is_refused() {
    let folder = folder();
    std::fs::write(
        folder.path().join("dark.toml"),
        "version = 1\n[camera]\nposition = [0,0,1]\nlook_at = [0,0,0]\nvertical_fov = 50.0\n",
    )
    .unwrap();
    let cases: &[(&str, &[&str])] = &[
        (
            "cornell --at 0,0",
            &["--at", "three finite numbers, as in 0,1.5,-2"],
        ),
        ("cornell --at 0,nan,0", &["--at", "three finite numbers"]),
        ("cornell --at 1e39,0,0", &["--at", "three finite numbers"]),
        ("cornell", &["--at <x,y,z>", "--grid"]),
        (
            "cornell --at 0,0,0 --grid 0,0,0:1,1,1:2,2,2",
            &["--grid", "cannot be used with"],
        ),
        (
            "cornell --grid 0,0,0:1,1,1",
            &["--grid", "as in -1,0,-1:1,2,1:5,3,5"],
        ),
        ("cornell --grid 0,0,0:1,1,1:0,2,2", &["1 to 65535 probes"]),
        (
            "cornell --grid 0,0,0:1,1,1:999,999,999",
            &["1 to 65535 probes"],
        ),
        (
            "cornell --grid 0,0,0:1,1,1:40,40,40 --bands 128",
            &["the most at a time; ask for fewer probes or bands"],
        ),
        (
            "cornell --at 0,0,0 --bands 129",
            &["--bands", "from 0 to 128"],
        ),
        (
            "cornell --at 0,0,0 --bands -1",
            &["--bands", "from 0 to 128"],
        ),
        ("cornell --at 0,0,0 --spp 0", &["--spp", "from 1 to"]),
        ("cornell --at 0,0,0 --path-length 0", &["path length is 0"]),
        (
            "cornell --at 0,0,0 --threads 0",
            &["--threads", "from 1 to 1024"],
        ),
        ("cornel --at 0,0,0", &["did you mean \"cornell\""]),
        (
            "dark.toml --at 0,0,0",
            &["dark.toml:1:1", "add [[lights]]", "[environment]"],
        ),
        (
            "cornell --at 0,0,0 --spp 16 -o nowhere/probe.json",
            &["nowhere/probe.json: cannot write", "mkdir -p nowhere"],
        ),
    ];
    for (arguments, words) in cases {
        refuses(&folder, &format!("sh probe {arguments}"), words);
    }
}

#[test]
fn an_environment_of_harmonics_that_cannot_be_used_is_refused_at_its_place() {
    let folder = folder();
    let right = ondine(&folder, "scenes sh-grace").stdout;
    let probe = "sh probe cornell --at 0,0,0 --bands 1 --spp 16 -o probe.json";
    assert_eq!(ondine(&folder, probe).code, 0);
    let whole = std::fs::read_to_string(folder.path().join("probe.json")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("few.json", &whole.replace("\"l_max\": 1", "\"l_max\": 2"));
    write(
        "other.json",
        &whole.replace("without the Condon-Shortley", "with the Condon-Shortley"),
    );
    let irradiance = whole.replace("\"radiance\"", "\"irradiance\"");
    write(
        "irradiance.json",
        &irradiance.replacen("\"version\"", "\"lobe\": \"cosine\",\n  \"version\"", 1),
    );
    write("text.json", "hello");
    let cases: &[(&str, &[&str])] = &[
        (
            "sh = \"grase\"",
            &["59:6", "cannot read", "did you mean \"grace\"?"],
        ),
        (
            "sh = \"few.json\"",
            &["59:6", "few.json", "coefficients has 4 rows", "needs 9"],
        ),
        ("sh = \"other.json\"", &["59:6", "other.json", "convention"]),
        (
            "sh = \"irradiance.json\"",
            &["59:6", "an environment is radiance"],
        ),
        (
            "sh = \"text.json\"",
            &["59:6", "text.json:1:1", "no coefficients"],
        ),
        (
            "sh = \"\"",
            &["59:6", "grace, eucalyptus, st-peters, uffizi"],
        ),
        ("sh = 3", &["59:6"]),
        ("sh = \"grace\"\nconstant = [1, 1, 1]", &["has both"]),
        (
            "constant = [1, 1, 1]",
            &["clamp cuts off what is below 0 in sh", "remove it"],
        ),
    ];
    for (environment, words) in cases {
        write("a.toml", &right.replace("sh = \"grace\"", environment));
        refuses(&folder, "render a.toml", words);
    }
}

#[test]
fn light_below_zero_is_told_unless_the_scene_says_that_it_knows() {
    let folder = folder();
    let said = ondine(&folder, "scenes sh-grace").stdout;
    let told = |text: &str| {
        std::fs::write(folder.path().join("a.toml"), text).unwrap();
        let run = ondine(&folder, "render a.toml --size 24x8 --spp 1");
        assert_eq!(run.code, 0, "{}", run.stderr);
        run.stderr
    };
    assert_eq!(told(&said), "");
    assert_eq!(told(&said.replace("clamp = false", "clamp = true")), "");
    let warning = told(&said.replace("clamp = false", ""));
    for word in [
        "warning: a.toml:59:6: ",
        "negative over 40.7 % of the sphere",
        "clamp = true cuts it off",
    ] {
        assert!(warning.contains(word), "{warning}");
    }
}

#[test]
fn the_comparison_writes_a_table_a_plot_and_a_strip_and_finds_that_the_two_agree() {
    let folder = folder();
    let line = "sh compare --light uffizi --bsdf lambert --size 64x64 --spp 64 -o out --json";
    let report = ondine(&folder, line).json();
    assert_eq!(report["agreement"]["agrees"], true, "{report:#}");
    let rows = report["by_degree"].as_array().unwrap();
    let apart: Vec<f64> = rows
        .iter()
        .map(|row| row["relative_rms"][0].as_f64().unwrap())
        .collect();
    assert_eq!(apart.len(), 3);
    assert!(apart[0] > 0.3 && apart[2] < 0.3 * apart[0], "{apart:?}");
    assert_eq!(
        names(&folder.path().join("out")),
        ["difference.csv", "difference.svg", "strip.png"]
    );
    let csv = std::fs::read_to_string(folder.path().join("out/difference.csv")).unwrap();
    assert!(csv.starts_with("l,\"path traced\"\n0,"), "{csv}");
    // Threads change nothing.
    let again = ondine(&folder, &format!("{line} --threads 1")).json();
    assert_eq!(again["by_degree"], report["by_degree"]);

    let run = ondine(
        &folder,
        "sh compare --light grace --bsdf phong:20 --size 48x48 --spp 64",
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    for word in ["lobe rays", "phong material", "they agree within noise"] {
        assert!(run.stdout.contains(word), "{}", run.stdout);
    }
}

#[test]
fn a_comparison_that_cannot_be_made_is_refused() {
    let folder = folder();
    for (name, scale) in [("black", 0.0), ("vast", 1e290), ("bright", 0.9)] {
        scaled(&folder, name, scale);
    }
    std::fs::write(folder.path().join("file"), "").unwrap();
    let cases: &[(&str, &[&str])] = &[
        (
            "--light graze --bsdf lambert",
            &["no file and no published probe", "grace, eucalyptus"],
        ),
        ("--light grace --bsdf phongg", &["--bsdf", "phong:N"]),
        (
            "--light grace --bsdf phong:-1",
            &["--bsdf", "exponent N from 0"],
        ),
        (
            "--light grace --bsdf lambert --bands 3",
            &["coefficients to degree 2"],
        ),
        (
            "--light grace --bsdf lambert --spp 1",
            &["--spp", "from 4 to"],
        ),
        (
            "--light grace --bsdf lambert --shape cornell --size 16x16",
            &["cornell: no light of the environment reaches it", "--shape"],
        ),
        (
            "--light grace --bsdf phong:9 --shape glass --size 16x16",
            &["glass: no light of the environment reaches it", "--shape"],
        ),
        (
            "--light black.json --bsdf lambert",
            &["black.json is black"],
        ),
        (
            "--light vast.json --bsdf lambert",
            &["and 2^32 is the greatest; choose another unit"],
        ),
        (
            "--light bright.json --bsdf lambert --size 32x32 --spp 64",
            &["samples are not finite or not below 2^32"],
        ),
        (
            "--light grace --bsdf lambert -o file",
            &["-o file: this is a file; name a folder"],
        ),
        (
            "--light grace --bsdf lambert -o file/folder",
            &["-o file/folder: ", "name a folder"],
        ),
        (
            "--light grace --bsdf lambert --size 1x1 --spp 64",
            &["covers no pixel of 1x1", "--size"],
        ),
        (
            "--light grace --bsdf lambert --shape cornel",
            &["did you mean"],
        ),
        ("--bsdf lambert", &["--light"]),
    ];
    for (arguments, words) in cases {
        refuses(&folder, &format!("sh compare {arguments}"), words);
    }
}

/// A file of coefficients, all the same: 2^32 times `scale`.
fn scaled(folder: &tempfile::TempDir, name: &str, scale: f64) {
    let file = serde_json::json!({
        "format": "ondine-sh",
        "version": 1,
        "convention": ondine::sh::CONVENTION,
        "quantity": "radiance",
        "l_max": 20,
        "coefficients": vec![[scale * 4_294_967_296.0; 3]; 441],
    });
    let path = folder.path().join(format!("{name}.json"));
    std::fs::write(path, file.to_string()).unwrap();
}

#[test]
fn too_few_samples_are_no_verdict() {
    let folder = folder();
    let line = "sh compare --light grace --bsdf lambert --size 16x16 --spp 8";
    let run = ondine(&folder, line);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stdout.contains("cannot tell") && run.stdout.contains("greater --size or --spp"),
        "{}",
        run.stdout
    );
    assert!(!run.stdout.contains("they "), "{}", run.stdout);
    let report = ondine(&folder, &format!("{line} --json")).json();
    assert_eq!(report["agreement"]["agrees"], Value::Null);
    assert_eq!(report["agreement"]["regions"], 0);
    assert_eq!(report["agreement"]["greatest_z"], Value::Null);
}

#[test]
fn what_has_no_noise_agrees_by_rounding_alone() {
    let folder = folder();
    let line = "sh compare --light grace --bands 0 --bsdf lambert --strategy cosine --size 48x48 --spp 16 --json";
    let agreement = &ondine(&folder, line).json()["agreement"];
    assert_eq!(agreement["agrees"], true, "{agreement:#}");
    assert!(
        agreement["variance_z"].as_f64().unwrap() < 0.1,
        "{agreement:#}"
    );
}

#[test]
fn outputs_that_cannot_be_written_are_found_before_the_work_and_none_is_written() {
    let folder = folder();
    std::fs::create_dir_all(folder.path().join("out/difference.csv")).unwrap();
    // Millions of samples: the refusal comes before them.
    let compare = "sh compare --light grace --bsdf lambert --size 4096x64 --spp 1000000";
    refuses(
        &folder,
        &format!("{compare} -o out"),
        &["out/difference.csv: cannot write: it is a folder"],
    );
    assert_eq!(names(&folder.path().join("out")), ["difference.csv"]);

    let bake = "sh probe a.toml --at 0,0,3 --spp 100000000";
    let sky = ondine(&folder, "scenes sh-grace").stdout;
    let light = "sh probe cornell --at 0,0,0 --spp 16 -o sky.json";
    assert_eq!(ondine(&folder, light).code, 0);
    let scene = sky.replace("sh = \"grace\"", "sh = \"sky.json\"");
    std::fs::write(folder.path().join("a.toml"), &scene).unwrap();
    let cases = [
        ("nowhere/probe.json", "mkdir -p nowhere"),
        ("a.toml", "a.toml: this file is read; name another output"),
        ("./sky.json", "environment is read from this file"),
    ];
    for (output, words) in cases {
        refuses(&folder, &format!("{bake} -o {output}"), &[words]);
    }
    let kept = std::fs::read_to_string(folder.path().join("a.toml")).unwrap();
    assert_eq!(kept, scene);
}
