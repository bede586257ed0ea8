//! What makes rooms quick changes no image: a scene whose shapes are all asked in turn looks the same.

#[path = "common/render.rs"]
mod render;

use ondine::film::Film;
use ondine::render::Settings;
use ondine::scene::Scene;
use ondine::scene::description::{SamplerKind, Strategy};
use render::*;

const MATERIALS: &str = r#"
[materials.white]
type = "lambert"
albedo = [0.7, 0.6, 0.5]
[materials.mirror]
type = "mirror"
reflectance = [0.9, 0.9, 0.9]
[materials.glass]
type = "glass"
ior = 1.5
"#;

const LIGHTS: &str = r#"
[[lights]]
sphere = { center = [0.0, 0.5, 0.0], radius = 0.2 }
radiance = [5.0, 4.0, 3.0]
[environment]
constant = [1.0, 0.9, 0.8]
"#;

/// With it no six quads close a box around everything.
const FAR_AWAY: &str = r#"
[[objects]]
sphere = { center = [0.0, 0.0, -10000.0], radius = 0.0001 }
material = "white"
"#;

const INSIDE: &str = "position = [0.2, 0.1, -0.8]\nlook_at = [0.0, 0.0, 1.0]";
const OUTSIDE: &str = "position = [2.5, 2.0, 4.0]\nlook_at = [0.0, 0.0, 0.0]";
/// Its lens reaches through a wall.
const BETWEEN: &str =
    "position = [0.8, 0.0, 0.9]\nlook_at = [0.0, 0.0, -1.0]\naperture_radius = 0.5";

/// The cube [-1, 1]³ of five white walls and one of another material.
fn room(camera: &str, wall: &str, more: &str) -> String {
    let quads = [
        ("[-1.0, -1.0, -1.0]", "[2.0, 0.0, 0.0]", "[0.0, 0.0, 2.0]"),
        ("[-1.0, 1.0, -1.0]", "[2.0, 0.0, 0.0]", "[0.0, 0.0, 2.0]"),
        ("[-1.0, -1.0, -1.0]", "[0.0, 2.0, 0.0]", "[0.0, 0.0, 2.0]"),
        ("[1.0, -1.0, -1.0]", "[0.0, 2.0, 0.0]", "[0.0, 0.0, 2.0]"),
        ("[-1.0, -1.0, -1.0]", "[2.0, 0.0, 0.0]", "[0.0, 2.0, 0.0]"),
        ("[-1.0, -1.0, 1.0]", "[2.0, 0.0, 0.0]", "[0.0, 2.0, 0.0]"),
    ];
    let materials = ["white", "white", "white", "white", "white", wall];
    let walls: String = quads
        .iter()
        .zip(materials)
        .map(|((corner, u, v), material)| {
            format!(
                "[[objects]]\nquad = {{ corner = {corner}, u = {u}, v = {v} }}\nmaterial = \"{material}\"\n"
            )
        })
        .collect();
    format!("[camera]\n{camera}\nvertical_fov = 60.0\n{MATERIALS}{walls}{more}{LIGHTS}")
}

fn image(text: &str, strategy: Strategy) -> Film {
    let description = scene(text);
    let settings = Settings {
        strategy,
        ..settings(&description, (32, 32), 64)
    };
    film(&description, &settings)
}

#[test]
fn a_room_looks_the_same_from_inside_and_outside_and_through_its_walls() {
    for camera in [INSIDE, OUTSIDE, BETWEEN] {
        for wall in ["white", "mirror", "glass"] {
            // Without light samples, whose choice depends on the size of the scene, both draw the same paths.
            let near = image(&room(camera, wall, ""), Strategy::Cosine);
            let far = image(&room(camera, wall, FAR_AWAY), Strategy::Cosine);
            let ((near, _), (far, _)) = (mean_and_error(&near), mean_and_error(&far));
            for (a, b) in near.into_iter().zip(far) {
                // A path in a thousand turns another way by rounding.
                assert!((a - b).abs() < 2e-3 * b, "{camera}, {wall}: {a} is not {b}");
            }
        }
    }
}

#[test]
fn light_samples_and_encounters_agree_on_a_room_seen_from_outside() {
    for wall in ["white", "glass"] {
        let text = room(OUTSIDE, wall, "");
        let [cosine, mis] = [Strategy::Cosine, Strategy::Mis].map(|s| image(&text, s));
        let (cosine, mis) = (mean_and_error(&cosine), mean_and_error(&mis));
        for c in 0..3 {
            let z = (cosine.0[c] - mis.0[c]) / cosine.1[c].hypot(mis.1[c]);
            assert!(z.abs() < 4.0, "{wall}, channel {c}: z = {z:.2}");
        }
    }
}

#[test]
fn glass_walls_make_no_room() {
    let compile = |wall| Scene::compile(&scene(&room(INSIDE, wall, "")));
    assert!(compile("white").room.is_some());
    assert!(compile("mirror").room.is_some());
    assert!(compile("glass").room.is_none());
}

#[test]
fn a_light_flush_with_a_wall_has_the_same_bits_in_every_wave_under_a_sky() {
    let lamp = r#"
[[lights]]
quad = { corner = [-0.3, 1.0, -0.3], u = [0.6, 0.0, 0.0], v = [0.0, 0.0, 0.6] }
radiance = [5.0, 5.0, 5.0]
"#;
    let description = scene(&room(INSIDE, "white", lamp));
    let hash = |wave| {
        let settings = Settings {
            wave,
            sampler: SamplerKind::Sobol,
            ..settings(&description, (32, 32), 37)
        };
        film(&description, &settings).image_hash()
    };
    let whole = hash(4096);
    for wave in [16, 100, 2048] {
        assert_eq!(hash(wave), whole, "waves of {wave}");
    }
}
