//! Whatever is done to a file, the program does not panic: damaged files of each format go all the way to a picture.
//!
//! `ONDINE_MUTATIONS=100000 cargo test --release --test mutations` tries more of them.

mod files;
#[path = "../common/mutation.rs"]
mod mutation;

use files::Files;
use mutation::mutated;
use ondine::render::{Control, Settings, render};
use ondine::scene::builtin;
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// What no file of a few kilobytes may take, on a busy machine.
const PATIENCE: Duration = Duration::from_secs(30);

/// Reads the scene and renders a few pixels of it; whether it could be read.
fn open_and_render(scene: &Path) -> bool {
    let Ok(description) = builtin::open(&scene.to_string_lossy()) else {
        return false;
    };
    let mut settings = Settings::of(&description);
    settings.set_size(4, 4);
    settings.spp = 1;
    settings.path_length = settings.path_length.min(4);
    settings.threads = Some(1);
    let control = Control {
        stop: &AtomicBool::new(false),
        progress: &|_| {},
    };
    render(&description, &settings, &control).is_ok()
}

/// Damages one file of the scene after the other, and counts what still renders.
fn assert_survives(files: &Files) {
    let rounds =
        std::env::var("ONDINE_MUTATIONS").map_or(400, |count| count.parse().expect("a number"));
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in &files.all {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let scene = folder.path().join(files.scene);
    if let Err(error) = builtin::open(&scene.to_string_lossy()) {
        panic!("the undamaged {}: {error}", files.scene);
    }
    let mut random = Pcg32::new(301, 7);
    let (mut rendered, mut slowest) = (0, Duration::ZERO);
    for _ in 0..rounds {
        let (name, bytes) = &files.all[random.next_u32() as usize % files.damaged];
        let path = folder.path().join(name);
        let damaged = mutated(bytes, &mut random);
        std::fs::write(&path, &damaged).unwrap();
        let start = Instant::now();
        match catch_unwind(AssertUnwindSafe(|| open_and_render(&scene))) {
            Ok(is_rendered) => rendered += u32::from(is_rendered),
            Err(_) => panic!("{name} panics when it is {}", damaged.escape_ascii()),
        }
        slowest = slowest.max(start.elapsed());
        assert!(
            slowest < PATIENCE,
            "{name} takes {slowest:?} when it is {}",
            damaged.escape_ascii()
        );
        std::fs::write(&path, bytes).unwrap();
    }
    println!(
        "{}: {rendered} of {rounds} render, the slowest in {slowest:?}",
        files.scene
    );
    // Some damage is refused and some is none: both happen, or the edits test nothing.
    assert!(
        rendered > rounds / 100 && rendered < rounds - rounds / 100,
        "{rendered} of {rounds}"
    );
}

macro_rules! survives {
    ($($test:ident: $files:expr;)+) => {
        $(
            #[test]
            fn $test() {
                assert_survives(&$files);
            }
        )+
    };
}

survives! {
    no_damage_to_an_ascii_ply_panics: files::ply(files::Encoding::Ascii);
    no_damage_to_a_little_endian_ply_panics: files::ply(files::Encoding::LittleEndian);
    no_damage_to_a_big_endian_ply_panics: files::ply(files::Encoding::BigEndian);
    no_damage_to_an_obj_or_its_materials_panics: files::obj();
    no_damage_to_a_gltf_or_its_buffer_panics: files::gltf();
    no_damage_to_a_glb_panics: files::glb();
    no_damage_to_a_pbrt_scene_panics: files::pbrt();
    no_damage_to_a_scene_of_meshes_and_textures_panics: files::scene();
    no_damage_to_a_png_panics: files::textured(image::ImageFormat::Png, "paint.png");
    no_damage_to_a_jpeg_panics: files::textured(image::ImageFormat::Jpeg, "paint.jpg");
    no_damage_to_a_tga_panics: files::textured(image::ImageFormat::Tga, "paint.tga");
    no_damage_to_a_bmp_panics: files::textured(image::ImageFormat::Bmp, "paint.bmp");
    no_damage_to_a_hdr_panics: files::textured(image::ImageFormat::Hdr, "paint.hdr");
}
