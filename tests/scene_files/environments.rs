//! What surrounds a scene: one thing, and an image beside the file.

use super::*;

#[test]
fn an_environment_is_exactly_one_thing() {
    refuses_appended(
        "[environment]\n",
        "15:1",
        &["[environment] is empty; add constant"],
    );
    let gradient = "gradient = { zenith = [0, 0, 1], horizon = [1, 1, 1], ground = [0, 1, 0] }\n";
    refuses_appended(
        &format!("[environment]\nconstant = [1, 1, 1]\n{gradient}"),
        "17:1",
        &["both constant and gradient; keep one"],
    );
    refuses_appended(
        "[environment]\nconstant = [1, 1, 1]\nrotate_degrees = 3\n",
        "17:1",
        &["turns an image", "remove it"],
    );
    refuses_appended(
        "[environment]\ngradient = { zenith = [1, 1, 1] }\n",
        "16:12",
        &["this gradient has no horizon; add horizon ="],
    );
    refuses_appended(
        "[environment]\nimage = \"sky.exr\"\n",
        "16:9",
        &["this scene is not a file", "absolute path"],
    );
    refuses_appended(
        "[environment]\nimage = \"\"\n",
        "16:9",
        &["name a lat-long EXR"],
    );
    let scene = read(&format!("{RIGHT}[environment]\n{gradient}")).unwrap();
    assert!(
        matches!(scene.environment, Some(Environment::Gradient { zenith, .. }) if zenith == Rgb::new(0.0, 0.0, 1.0))
    );
}

/// Writes an EXR whose pixel (x, y) is `pixel(x, y)`.
fn write_exr(
    path: &Path,
    width: usize,
    height: usize,
    pixel: impl Fn(usize, usize) -> [f32; 3] + Sync,
) {
    exr::prelude::write_rgb_file(path, width, height, |x, y| {
        let [r, g, b] = pixel(x, y);
        (r, g, b)
    })
    .unwrap();
}

fn with_image(folder: &Path, file: &str) -> Result<Description, Error> {
    let text = format!("{RIGHT}[environment]\nimage = \"{file}\"\nrotate_degrees = 90\n");
    toml::parse(&text, "a.toml", Some(folder))
}

#[test]
fn an_environment_image_is_read_beside_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    write_exr(&folder.path().join("sky.exr"), 8, 4, |x, y| {
        [x as f32, y as f32, 0.5]
    });
    let scene = with_image(folder.path(), "sky.exr").unwrap();
    let Some(Environment::Image {
        image,
        rotate_degrees,
    }) = scene.environment
    else {
        panic!("no image");
    };
    assert_eq!((image.width, image.height, rotate_degrees), (8, 4, 90.0));
    assert_eq!(image.pixels[2 * 8 + 5], Rgb::new(5.0, 2.0, 0.5));
}

#[test]
fn an_environment_image_that_cannot_be_used_is_refused_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    write_exr(&file("square.exr"), 4, 4, |_, _| [1.0; 3]);
    write_exr(&file("nan.exr"), 4, 2, |x, y| {
        [1.0, if (x, y) == (3, 1) { f32::NAN } else { 1.0 }, 1.0]
    });
    write_exr(&file("inf.exr"), 4, 2, |_, _| [f32::INFINITY; 3]);
    write_exr(&file("dark.exr"), 4, 2, |x, _| [1.0, 1.0, 1.0 - x as f32]);
    std::fs::write(file("text.exr"), "not an image").unwrap();
    let whole = std::fs::read(file("inf.exr")).unwrap();
    std::fs::write(file("cut.exr"), &whole[..whole.len() - 20]).unwrap();
    for (name, words) in [
        (
            "square.exr",
            "4×4 pixels, and a lat-long image is twice as wide as high; resize it to 8×4",
        ),
        ("nan.exr", "pixel (3, 1) has G = NaN"),
        ("inf.exr", "pixel (0, 0) has R = inf"),
        ("dark.exr", "pixel (2, 0) has B = -1"),
        ("text.exr", "is not an EXR image"),
        ("cut.exr", ""),
        ("missing.exr", "cannot read"),
        (".", "cannot read"),
    ] {
        let message = with_image(folder.path(), name).unwrap_err().to_string();
        assert!(message.starts_with("a.toml:16:9: image "), "{message}");
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn no_damage_to_an_environment_image_makes_its_reader_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.exr");
    write_exr(&path, 16, 8, |x, y| [x as f32, y as f32, 0.5]);
    let whole = std::fs::read(&path).unwrap();
    let mut random = Pcg32::new(3, 5);
    for _ in 0..500 {
        std::fs::write(&path, mutated(&whole, &mut random)).unwrap();
        let _ = with_image(folder.path(), "sky.exr");
    }
}

#[test]
fn a_file_that_is_no_text_is_refused_where_it_stops_being_text() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    std::fs::write(&path, b"version = 1\n# caf\xe9\n").unwrap();
    let message = toml::load(&path).unwrap_err().to_string();
    assert!(
        message.ends_with("a.toml:2:6: this is not UTF-8 text; save the file as UTF-8"),
        "{message}"
    );
    let message = toml::load(folder.path()).unwrap_err().to_string();
    assert!(message.contains("cannot read"), "{message}");
    std::fs::write(&path, RIGHT).unwrap();
    let scene = builtin::open(path.to_str().unwrap()).unwrap();
    assert_eq!(scene.name, path.to_str().unwrap());
}
