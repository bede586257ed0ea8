//! Job files: what they expand to, and what is refused with place and remedy.

mod batch {
    mod outputs;
}

use ondine::batch::file::JobFile;
use ondine::batch::plan::{Job, MOST_JOBS, expand};
use ondine::batch::scenes::Scenes;
use ondine::error::Error;
use std::collections::HashSet;
use std::path::Path;

/// The jobs of a file whose scenes are built-in, `version` aside.
fn jobs(text: &str) -> Result<Vec<Job>, Error> {
    let text = format!("version = 1\n{text}");
    let file = JobFile::parse(&text, Path::new("jobs.toml"))?;
    let mut scenes = Scenes::default();
    expand(&file, &mut |scene, changes| scenes.open(scene, changes))
}

fn names(text: &str) -> Vec<String> {
    let jobs = jobs(text).unwrap_or_else(|error| panic!("{error}"));
    jobs.into_iter().map(|job| job.name).collect()
}

#[track_caller]
fn refuses(text: &str, place: &str, words: &[&str]) {
    let message = match jobs(text) {
        Ok(jobs) => panic!("read without complaint: {jobs:?}"),
        Err(error) => error.to_string(),
    };
    let start = format!("jobs.toml:{place}: ");
    assert!(message.starts_with(&start), "{message}\nis not at {place}");
    for word in words {
        assert!(message.contains(word), "{message}\nlacks {word}");
    }
    assert_eq!(message.lines().count(), 1, "{message}");
}

#[test]
fn the_grid_is_every_combination_and_the_seed_varies_fastest() {
    let text = r#"
        [[jobs]]
        scene = ["glossy", "cornell"]
        set = { "camera.vertical_fov" = [40, 50], "film.filter" = "tent" }
        seed = [0, 1]
        spp = 4
        output = "out/{scene}-{camera.vertical_fov}-{filter}-{seed}.exr"
    "#;
    assert_eq!(
        names(text),
        [
            "out/glossy-40-tent-0.exr",
            "out/glossy-40-tent-1.exr",
            "out/glossy-50-tent-0.exr",
            "out/glossy-50-tent-1.exr",
            "out/cornell-40-tent-0.exr",
            "out/cornell-40-tent-1.exr",
            "out/cornell-50-tent-0.exr",
            "out/cornell-50-tent-1.exr",
        ]
    );
    let jobs = jobs(text).unwrap();
    assert!(
        jobs.iter()
            .enumerate()
            .all(|(index, job)| job.index == index)
    );
    let hashes: Vec<_> = jobs
        .iter()
        .map(|job| job.ready.as_ref().unwrap().scene_hash().to_owned())
        .collect();
    assert_eq!(hashes[0], hashes[1]);
    assert_ne!(hashes[1], hashes[2]);
    let ready = jobs[3].ready.as_ref().unwrap();
    assert_eq!((ready.settings.seed, ready.settings.spp), (1, 4));
    assert_eq!(ready.settings.path_length, 7, "the scene's");
    assert_eq!(ready.exr, Path::new("out/glossy-50-tent-1.exr"));
}

#[test]
fn a_job_overrides_the_defaults_key_by_key() {
    let text = r#"
        [defaults]
        spp = 16
        size = "64x48"
        camera = "camera"
        output = "{scene}-{size}-{spp}.exr"
        tonemap = "aces"
        [[jobs]]
        scene = "cornell"
        [[jobs]]
        scene = "cornell"
        spp = [1, 2]
        crop = "0,0,8,8"
        png = false
    "#;
    assert_eq!(
        names(text),
        [
            "cornell-64x48-16.exr",
            "cornell-64x48-1.exr",
            "cornell-64x48-2.exr"
        ]
    );
    let jobs = jobs(text).unwrap();
    let ready = |index: usize| jobs[index].ready.as_ref().unwrap();
    assert_eq!(ready(0).png.unwrap().operator.to_string(), "aces");
    assert_eq!(ready(1).png, None);
    assert_eq!(ready(1).settings.region.to_string(), "0,0,8,8");
    assert_eq!(ready(1).paths(), 64);
}

#[test]
fn without_a_template_names_show_what_has_several_values() {
    let text = r#"
        [[jobs]]
        scene = "glossy"
        cameras = "all"
        set.materials.satin_copper = { roughness = [0.1, 0.2], reflectance = [[0.9, 0.5, 0.1]] }
        spp = [1, 16]
        strategy = ["mis", "light"]
        path_length = 3
    "#;
    let names = names(text);
    assert_eq!(names.len(), 8);
    assert_eq!(names[0], "glossy-roughness0.1-camera-mis-spp1.exr");
    assert_eq!(names[7], "glossy-roughness0.2-camera-light-spp16.exr");
}

#[test]
fn values_become_parts_of_a_name_that_lead_nowhere() {
    let text = r#"
        [[jobs]]
        scene = "glossy"
        set = { "materials.satin_copper.reflectance" = [[0.9, 0.5, 0.1]], "film.filter" = ["box"] }
        output = "{{{reflectance}}}/{filter}{roulette}.exr"
    "#;
    assert_eq!(names(text), ["{0.9-0.5-0.1}/boxnone.exr"]);
    let text = r#"
        [[jobs]]
        scene = "glossy"
        set = { "film.filter" = ["../../box", "..", "a/b\\c d"] }
        output = "out/{filter}/x.exr"
    "#;
    // No such filters: these jobs are there with their reasons, and names that stay below.
    let jobs = jobs(text).unwrap();
    let names: Vec<_> = jobs.iter().map(|job| job.name.as_str()).collect();
    assert_eq!(
        names,
        ["out/..-..-box/x.exr", "out/__/x.exr", "out/a-b-c-d/x.exr"]
    );
    let why = jobs[0].ready.as_ref().unwrap_err();
    assert!(
        why.starts_with("jobs.toml:5:34: set film.filter = \"../../box\": "),
        "{why}"
    );
    assert!(why.contains("unknown filter"), "{why}");
}

#[test]
fn a_job_that_cannot_be_rendered_is_there_with_its_reason() {
    let text = r#"
        [[jobs]]
        scene = ["cornell", "missing.toml"]
        cameras = ["camera", "front"]
        set = { "materials.white.albdo" = [[1, 1, 1]] }
        [[jobs]]
        scene = "cornell"
        cameras = ["camera", "front"]
        crop = ["0,0,8,8", "0,0,999,8"]
        output = "b-{camera}-{crop}.exr"
    "#;
    let jobs = jobs(text).unwrap();
    let why = |index: usize| jobs[index].ready.clone().err().unwrap_or_default();
    assert_eq!(jobs.len(), 8);
    assert!(why(0).contains("did you mean \"albedo\"?"), "{}", why(0));
    assert!(why(2).contains("there is no file"), "{}", why(2));
    assert_eq!(why(4), "");
    assert!(
        why(5).starts_with("jobs.toml:7:9: the crop 0,0,999,8"),
        "{}",
        why(5)
    );
    assert!(
        why(6).contains("has no camera \"front\"; it has camera"),
        "{}",
        why(6)
    );
}

#[test]
fn two_jobs_of_one_output_are_refused_with_what_tells_them_apart() {
    let grid =
        "[[jobs]]\nscene = \"cornell\"\nspp = [1, 2]\nseed = [0, 1]\noutput = \"a-{spp}.exr\"";
    refuses(
        grid,
        "6:10",
        &[
            "jobs 0 (cornell) and 1 (cornell) have the same output a-1.exr",
            "they differ in {seed}",
        ],
    );
    let twice = "[[jobs]]\nscene = \"cornell\"\n[[jobs]]\nscene = \"cornell\"\nset = { \"render.spp\" = 3 }";
    refuses(
        twice,
        "4:1",
        &[
            "jobs 0 (cornell) and 1 (cornell render.spp=3)",
            "they differ in {spp} and {render.spp}",
        ],
    );
    let same = "[[jobs]]\nscene = \"cornell\"\nseed = [1, 1]";
    refuses(same, "2:1", &["remove it"]);
    let roundabout = "[[jobs]]\nscene = \"cornell\"\noutput = \"a/b.exr\"\n[[jobs]]\nscene = \"cornell\"\noutput = \"a/.//b.EXR\"";
    refuses(roundabout, "7:10", &["have the same output"]);
}

#[test]
fn what_is_wrong_with_a_job_file_has_a_place_and_a_remedy() {
    let with = |line: &str| format!("[[jobs]]\nscene = \"cornell\"\n{line}");
    let refuses_line = |line: &str, place: &str, words: &[&str]| refuses(&with(line), place, words);
    refuses_line(
        "sp = 4",
        "4:1",
        &["unknown key \"sp\" in [[jobs]]; did you mean \"spp\"?"],
    );
    refuses_line("spp = 0", "4:7", &["from 1 to 134217728"]);
    refuses_line("spp = []", "4:7", &["spp is an empty list"]);
    refuses_line("spp = [1, [2]]", "4:11", &["spp must be a whole number"]);
    refuses_line("size = \"64\"", "4:8", &["as in 640x480"]);
    refuses_line("size = \"64x70000\"", "4:8", &["from 1 to 65535"]);
    refuses_line(
        "strategy = [\"mis\", \"ligth\"]",
        "4:20",
        &["did you mean \"light\"?"],
    );
    refuses_line("crop = \"1,2,3\"", "4:8", &["not four numbers"]);
    refuses_line("aov = \"albdo\"", "4:7", &["did you mean \"albedo\"?"]);
    refuses_line("exposure = 100", "4:12", &["from -64 to 64"]);
    refuses_line("png = \"yes\"", "4:7", &["true or false"]);
    refuses_line("set = { \"a b\" = 1 }", "4:17", &["\"a b\" is no key"]);
    refuses_line(
        "camera = \"a\"\ncameras = \"b\"",
        "4:1",
        &["both camera and cameras"],
    );
    refuses_line(
        "output = \"a\\nb.exr\"",
        "4:10",
        &["the name \"a\\nb.exr\" has a line break"],
    );
    refuses_line(
        "set = { \"materials.white\" = {} }",
        "4:29",
        &["set materials.white is an empty table"],
    );
    refuses_line(
        "set = { \"materials.white.albedo\" = [[1, 1, 1]], materials.white.\"albedo\" = [[0, 0, 0]] }",
        "4:65",
        &["set names materials.white.albedo twice", "in one list"],
    );
    refuses_line(
        "output = \"a.png\"",
        "4:10",
        &["end the name \"a.png\" with .exr"],
    );
    refuses_line("output = \"{spp.exr\"", "4:10", &["a { stands alone"]);
    refuses_line("output = \"spp}.exr\"", "4:10", &["a } stands alone"]);
    refuses_line(
        "output = \"{sead}.exr\"",
        "4:10",
        &["no field {sead}; did you mean \"seed\"? There are: scene, camera"],
    );
    let set = "set = { \"a.x\" = 1, \"b.x\" = 2 }\noutput = \"{x}.exr\"";
    refuses_line(set, "5:10", &["{x} may be a.x or b.x"]);
    refuses(
        "[defaults]\nfoo = 1\n[[jobs]]\nscene = \"cornell\"",
        "3:1",
        &["in [defaults]"],
    );
    refuses("[[jobs]]\nspp = 1", "2:1", &["this job has no scene"]);
    refuses("jobs = []", "2:8", &["there are no jobs"]);
    refuses("[defaults]\nspp = 1", "1:1", &["has no jobs; add [[jobs]]"]);
    refuses("spp = ", "2:7", &["not valid TOML"]);
    let other_version = JobFile::parse("version = 2", Path::new("jobs.toml"));
    let message = other_version.unwrap_err().to_string();
    assert_eq!(
        message,
        "jobs.toml:1:11: version 2 is not supported; this program reads version 1"
    );
}

#[test]
fn too_many_jobs_are_refused_before_they_are_made() {
    let hundred = (0..100)
        .map(|i| i.to_string())
        .collect::<Vec<_>>()
        .join(", ");
    let axes: String = (0..40)
        .map(|i| format!("\"materials.white.x{i}\" = [{hundred}], "))
        .collect();
    let text = format!("[[jobs]]\nscene = \"cornell\"\nset = {{ {axes} }}");
    refuses(
        &text,
        "2:1",
        &[&format!("more than {MOST_JOBS} jobs"), "split the file"],
    );
}

#[test]
fn what_is_no_scene_file_is_changed_like_one() {
    let folder = tempfile::tempdir().unwrap();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::write(folder.path().join("a.obj"), obj).unwrap();
    let text = r#"
        version = 1
        [[jobs]]
        scene = "a.obj"
        [jobs.set]
        "camera.vertical_fov" = [20, 30]
        "materials.white" = [
            { type = "mirror", reflectance = [1, 1, 1] },
            { type = "glass", ior = 1.5 },
        ]
        [[jobs]]
        scene = "a.obj"
        set = { "film.width" = 3 }
    "#;
    let file = JobFile::parse(text, &folder.path().join("jobs.toml")).unwrap();
    let mut scenes = Scenes::default();
    let mut opened = Vec::new();
    let jobs = expand(&file, &mut |scene, changes| {
        let found = scenes.open(scene, changes)?;
        opened.push(found.clone());
        Ok(found)
    });
    let jobs = jobs.unwrap();
    let hashes: HashSet<&str> = opened.iter().map(|scene| scene.hash.as_str()).collect();
    assert_eq!((jobs.len(), opened.len(), hashes.len()), (5, 4, 4));
    assert!(jobs[..4].iter().all(|job| job.ready.is_ok()));
    let message = jobs[4].ready.as_ref().unwrap_err();
    assert!(message.contains("jobs.toml:13:"), "{message}");
    assert!(message.contains("is no .toml scene"), "{message}");
}
