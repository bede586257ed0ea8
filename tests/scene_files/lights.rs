//! Lights without a surface.

use super::*;
use glam::Vec3;
use ondine::scene::description::Punctual;

const LAMP: &str =
    "quad = { corner = [-1, 3, -1], u = [2, 0, 0], v = [0, 0, 2] }\nradiance = [5, 5, 5]\n";

fn light(text: &str) -> Punctual {
    let scene = accepts(LAMP, text);
    assert!(scene.lights.is_empty());
    scene.punctual[0]
}

#[test]
fn lights_without_a_surface_are_read() {
    let gray = Rgb::new(1.0, 2.0, 3.0);
    assert_eq!(
        light("point = { position = [0, 3, 0], intensity = [1, 2, 3] }\n"),
        Punctual::Point {
            position: Vec3::new(0.0, 3.0, 0.0),
            intensity: gray
        }
    );
    assert_eq!(
        light("distant = { direction = [0, -2, 0], irradiance = [1, 2, 3] }\n"),
        Punctual::Distant {
            direction: Vec3::NEG_Y,
            irradiance: gray
        }
    );
    let spot = light(
        "spot = { position = [0, 3, 0], direction = [0, 0, -9], intensity = [1, 2, 3], outer_degrees = 60 }\n",
    );
    let Punctual::Spot {
        direction,
        cos_inner,
        cos_outer,
        ..
    } = spot
    else {
        panic!("{spot:?}");
    };
    assert_eq!((direction, cos_inner), (Vec3::NEG_Z, 1.0));
    assert!((cos_outer - 0.5).abs() < 1e-7, "{cos_outer}");
}

#[test]
fn lights_without_a_surface_are_refused_where_they_are_wrong() {
    let refuses = |text: &str, place: &str, words: &[&str]| refuses(LAMP, text, place, words);
    refuses(
        "point = { position = [0, 3, 0] }\n",
        "13:9",
        &["has no intensity; add"],
    );
    refuses(
        "point = { position = [0, 3, 0], intensity = [1, 1, 1] }\nmaterial = \"white\"\n",
        "14:1",
        &["unknown key \"material\"", "no surface"],
    );
    refuses(
        "distant = { direction = [0, 0, 0], irradiance = [1, 1, 1] }\n",
        "13:25",
        &["direction has no length"],
    );
    refuses(
        "spot = { position = [0, 3, 0], direction = [0, -1, 0], intensity = [1, 1, 1], outer_degrees = 20, inner_degrees = 30 }\n",
        "13:115",
        &["below outer_degrees"],
    );
}
