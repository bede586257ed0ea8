//! What pages are shown is what there is.

use crate::Server;
use half::f16;
use ondine::film::exr;
use serde_json::json;
use std::path::Path;

#[test]
fn the_last_picture_is_the_film_in_half_floats() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), "materials --size 40x30 --spp 32 --threads 2");
    let mut page = server.open();
    let mut view = page.view.clone();
    view["aovs"] = json!({"first_hits": true, "lengths": true});
    page.look(&view);
    let save = server.get("image.exr");
    assert_eq!(save.code, 200, "{}", save.text());
    page.wait("the end", |page| page.stats["state"] == "done");
    let path = folder.path().join("saved.exr");
    std::fs::write(&path, server.get("image.exr").body).unwrap();
    let (film, metadata) = exr::read(&path).unwrap();
    assert_eq!(metadata.samples(), (32, 32));

    type Read = Box<dyn Fn(u32, u32) -> Vec<f32>>;
    let film = std::sync::Arc::new(film);
    let by = |read: fn(&ondine::film::Film, u32, u32) -> Vec<f32>| -> Read {
        let film = film.clone();
        Box::new(move |x, y| read(&film, x, y))
    };
    let layers: [(&str, Read); 6] = [
        ("radiance", by(|film, x, y| film.mean(x, y).to_vec())),
        (
            "error",
            by(|film, x, y| film.variance(x, y).map(f32::sqrt).to_vec()),
        ),
        ("albedo", by(|film, x, y| film.aov(x, y).albedo.to_vec())),
        ("normal", by(|film, x, y| film.aov(x, y).normal.to_vec())),
        ("depth", by(|film, x, y| vec![film.aov(x, y).depth])),
        (
            "length:3",
            by(|film, x, y| film.sums_of_length(3, x, y).mean(film.count(x, y)).to_vec()),
        ),
    ];
    for (layer, expected) in layers {
        view["layer"] = layer.into();
        page.say(&json!({"type": "view", "id": 2, "view": view}));
        let picture = page.picture(|_, picture| {
            picture.header["layer"] == layer && picture.header["sides"][0]["samples"] == 32
        });
        let side = &picture.header["sides"][0];
        assert_eq!((&side["width"], &side["height"]), (&json!(40), &json!(30)));
        assert_eq!(side["coarse"], false);
        let pixels = (0..30).flat_map(|y| (0..40).map(move |x| (x, y)));
        let values: Vec<u16> = pixels
            .flat_map(|(x, y)| expected(x, y))
            .map(|value| f16::from_f32(value.min(65504.0)).to_bits())
            .collect();
        assert_eq!(picture.sides[0], values, "{layer}");
    }
    assert_eq!(page.generation, 2, "another layer begins nothing anew");
}

#[test]
fn a_coarse_picture_comes_first_and_fills_what_has_no_sample() {
    // One thread, and an image that takes it long.
    let server = Server::start(Path::new("."), "cornell --size 1600x1200 --threads 1");
    let mut page = server.open();
    let first = page.picture(|_, _| true);
    let side = &first.header["sides"][0];
    assert_eq!(side["coarse"], true);
    assert!(side["width"].as_u64().unwrap() < 1600);
    assert!(first.sides[0].iter().any(|&half| half != 0));
    let whole = page.picture(|_, picture| picture.header["sides"][0]["coarse"] == false);
    assert_eq!(whole.header["sides"][0]["samples"], 0);
    // The last row has no sample yet, and shows something.
    let last = &whole.sides[0][whole.sides[0].len() - 1600 * 3..];
    assert!(last.iter().filter(|&&half| half != 0).count() > 1600);
}

#[test]
fn two_sides_have_as_many_samples_or_as_much_time() {
    let server = Server::start(
        Path::new("."),
        "cornell --size 64x64 --threads 2 --spp 2048",
    );
    let mut page = server.open();
    let mut view = page.view.clone();
    let mut other = view["sides"][0].clone();
    other["strategy"] = "uniform".into();
    other["path_length"] = 2.into();
    view["sides"] = json!([view["sides"][0], other]);
    page.look(&view);
    page.wait("the end", |page| page.stats["state"] == "done");
    let number = |page: &crate::Page, side: usize, key: &str| {
        page.stats["sides"][side][key].as_f64().unwrap()
    };
    assert_eq!(
        (number(&page, 0, "samples"), number(&page, 1, "samples")),
        (2048.0, 2048.0)
    );
    let picture = page.picture(|page, picture| picture.header["generation"] == page.generation);
    assert_eq!(picture.sides.len(), 2);

    view["balance"] = "time".into();
    view["sides"][0]["seed"] = 1.into();
    page.look(&view);
    page.wait("some time", |page| {
        page.stats["generation"] == page.generation
            && page.stats["sides"][0]["seconds"].as_f64() > Some(1.0)
    });
    let (a, b) = (number(&page, 0, "seconds"), number(&page, 1, "seconds"));
    // Rounds take a tenth of a second; on a busy machine some more.
    assert!((a - b).abs() < 0.5, "{a} s and {b} s");
    let (a, b) = (number(&page, 0, "samples"), number(&page, 1, "samples"));
    assert!(b > 1.3 * a, "short paths are quick: {a} and {b} samples");
}

#[test]
fn what_is_picked_is_where_the_pixel_looks() {
    let server = Server::start(Path::new("."), "cornell --size 256x256 --threads 1");
    let mut page = server.open();
    let mut view = page.view.clone();
    // A wide lens: what is picked does not depend on it.
    view["lens"]["aperture_radius"] = 0.3.into();
    page.look(&view);
    let mut pick =
        |x: u32, y: u32| page.ask(&json!({"type": "pick", "id": 3, "x": x, "y": y}))["hit"].clone();
    let wall = pick(128, 40);
    assert_eq!(wall["material"], "white");
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let at: Vec<f64> = wall["position"]
        .as_array()
        .unwrap()
        .iter()
        .map(number)
        .collect();
    let lens = view["lens"]["position"].as_array().unwrap();
    let offset: Vec<f64> = at.iter().zip(lens).map(|(a, b)| a - number(b)).collect();
    let distance = offset.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!((number(&wall["distance"]) - distance).abs() < 1e-4);
    assert!(
        (number(&wall["depth"]) + offset[2]).abs() < 1e-4,
        "the camera looks along -z"
    );
    // The lamp does not scatter.
    let lamp = pick(128, 63);
    assert!(lamp["material"].is_null(), "{lamp}");
    assert!(number(&lamp["position"][1]) > 0.5, "{lamp}");
}
