//! Outputs that would replace each other, or what is read.

use crate::jobs;
use ondine::batch::file::JobFile;
use ondine::batch::plan::expand;
use ondine::batch::scenes::Scenes;

#[test]
fn an_output_that_a_scene_is_read_from_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let rendered = jobs("[[jobs]]\nscene = \"cornell\"").unwrap();
    assert_eq!(rendered.len(), 1);
    let sky = "version = 1\n[camera]\nposition = [0, 0, 3]\nlook_at = [0, 0, 0]\nvertical_fov = 50\n\
               [materials.wood]\ntype = \"lambert\"\nalbedo = { texture = \"wood.png\" }\n\
               [environment]\nconstant = [1, 1, 1]\n";
    std::fs::write(at("sky.toml"), sky).unwrap();
    let pixel: &[u8] = b"P6"; // Not an image: the scene is refused, the job is there.
    std::fs::write(at("wood.png"), pixel).unwrap();
    let text = "version = 1\n[[jobs]]\nscene = \"sky.toml\"\noutput = \"wood.exr\"";
    let file = JobFile::parse(text, &at("jobs.toml")).unwrap();
    let mut scenes = Scenes::default();
    let mut open = |scene: &str, changes: &[_]| scenes.open(scene, changes);
    assert!(expand(&file, &mut open).unwrap()[0].ready.is_err());
    let one = image::RgbImage::new(1, 1);
    one.save(at("wood.png")).unwrap();
    let message = expand(&file, &mut open).unwrap_err().to_string();
    assert!(message.contains("jobs.toml:4:10: the output "), "{message}");
    assert!(
        message.contains("wood.png (the PNG beside an image) is a file that the batch reads"),
        "{message}"
    );
}

#[test]
fn outputs_that_are_one_file_however_they_are_spelt_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("out")).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(at("out"), at("link")).unwrap();
    let message = |one: &str, other: &str| {
        let job = |output| format!("[[jobs]]\nscene = \"cornell\"\noutput = \"{output}.exr\"\n");
        let text = format!("version = 1\n{}{}", job(one), job(other));
        let file = JobFile::parse(&text, &at("jobs.toml")).unwrap();
        let mut scenes = Scenes::default();
        match expand(&file, &mut |scene, changes| scenes.open(scene, changes)) {
            Ok(jobs) => format!("{} jobs", jobs.len()),
            Err(error) => error.to_string(),
        }
    };
    let mut pairs = vec![("out/../g", "g"), ("new/../g", "g"), ("new/./h", "new//h")];
    if cfg!(unix) {
        pairs.extend([
            ("out/h", "link/h"),
            ("link/../g", "g"),
            ("link/new/h", "out/new/h"),
        ]);
    }
    for (one, other) in pairs {
        let message = message(one, other);
        assert!(message.contains("jobs.toml:7:10: jobs 0"), "{message}");
        assert!(message.contains("have the same output"), "{message}");
    }
    for (one, other) in [("f", "f.checkpoint"), ("f.checkpoint", "f")] {
        let message = message(one, other);
        assert!(
            message.ends_with("f.checkpoint.exr (the checkpoint of an image); name another"),
            "{message}"
        );
    }
    assert_eq!(message("out/g", "g"), "2 jobs");
}

#[test]
fn a_checkpoint_that_a_scene_is_read_from_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let sky = "version = 1\n[camera]\nposition = [0, 0, 3]\nlook_at = [0, 0, 0]\nvertical_fov = 50\n\
               [environment]\nimage = \"sky.checkpoint.exr\"\n";
    std::fs::write(at("scene.toml"), sky).unwrap();
    exr::prelude::write_rgb_file(at("sky.checkpoint.exr"), 2, 1, |_, _| (1f32, 1f32, 1f32))
        .unwrap();
    let text = "version = 1\n[[jobs]]\nscene = \"scene.toml\"\noutput = \"sky.exr\"";
    let file = JobFile::parse(text, &at("jobs.toml")).unwrap();
    let mut scenes = Scenes::default();
    let message = expand(&file, &mut |scene, changes| scenes.open(scene, changes))
        .unwrap_err()
        .to_string();
    assert!(
        message.contains(
            "sky.checkpoint.exr (the checkpoint of an image) is a file that the batch reads"
        ),
        "{message}"
    );
}

#[test]
fn an_output_called_as_the_job_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("jobs.exr");
    let text = "version = 1\n[[jobs]]\nscene = \"cornell\"\noutput = \"jobs.exr\"";
    std::fs::write(&path, text).unwrap();
    let file = JobFile::read(&path).unwrap();
    let mut scenes = Scenes::default();
    let message = expand(&file, &mut |scene, changes| scenes.open(scene, changes))
        .unwrap_err()
        .to_string();
    assert!(
        message.ends_with("jobs.exr is a file that the batch reads; name another"),
        "{message}"
    );
}
