//! Closed furnaces: walls that emit e and reflect a have radiance e · (1 + a + a² + …) = e / (1 − a) everywhere.

use crate::render::*;
use ondine::scene::description::{Description, Strategy};

/// Emission of the walls.
const EMISSION: [f64; 3] = [0.5, 1.0, 0.25];

/// e (1 + a + … + aⁿ⁻¹): what paths of up to n edges find.
fn series(albedo: f64, edges: u32) -> [f64; 3] {
    let sum: f64 = (0..edges).map(|k| albedo.powi(k as i32)).sum();
    EMISSION.map(|e| e * sum)
}

fn header(albedo: f64) -> String {
    format!(
        "[camera]\nposition = [0.3, 0.1, 0.4]\nlook_at = [0.0, 0.0, -1.0]\nup = [0.0, 1.0, 0.0]\nvertical_fov = 70.0\n\
         [materials.wall]\ntype = \"lambert\"\nalbedo = [{albedo}, {albedo}, {albedo}]\n"
    )
}

fn sphere(albedo: f64) -> Description {
    scene(&format!(
        "{}[[lights]]\nsphere = {{ center = [0.0, 0.0, 0.0], radius = 1.0 }}\nradiance = {EMISSION:?}\n\
         two_sided = true\nmaterial = \"wall\"\n",
        header(albedo)
    ))
}

/// Six quads, each one-sided and facing inwards.
fn room(albedo: f64) -> Description {
    let mut text = header(albedo);
    for (corner, u, v) in [
        ([-1, -1, 3], [2, 0, 0], [0, 0, -4]),
        ([-1, 1, -1], [2, 0, 0], [0, 0, 4]),
        ([-1, -1, -1], [2, 0, 0], [0, 2, 0]),
        ([1, -1, 3], [-2, 0, 0], [0, 2, 0]),
        ([-1, -1, 3], [0, 0, -4], [0, 2, 0]),
        ([1, -1, -1], [0, 0, 4], [0, 2, 0]),
    ] {
        text += &format!(
            "[[lights]]\nquad = {{ corner = {corner:?}, u = {u:?}, v = {v:?} }}\nradiance = {EMISSION:?}\nmaterial = \"wall\"\n"
        );
    }
    scene(&text)
}

/// Renders with paths of that many edges.
fn shot(description: &Description, strategy: Strategy, edges: u32, spp: u32) -> ondine::film::Film {
    let mut settings = settings(description, (32, 32), spp);
    settings.strategy = strategy;
    settings.path_length = edges;
    film(description, &settings)
}

/// Samples per pixel that bring the standard error to some 0.03 %, by the variance in closed form.
fn samples(strategy: Strategy, albedo: f64) -> u32 {
    match strategy {
        // Each sample is the whole series.
        Strategy::Cosine => 16,
        Strategy::Uniform if albedo > 0.6 => 8192,
        _ => 1024,
    }
}

#[test]
fn a_closed_sphere_of_albedo_one_half_has_radiance_twice_its_emission() {
    let description = sphere(0.5);
    for strategy in STRATEGIES {
        let film = shot(&description, strategy, 64, samples(strategy, 0.5));
        let want = EMISSION.map(|e| e / (1.0 - 0.5));
        assert_mean(&film, want, 1e-3, &strategy.to_string());
    }
}

#[test]
fn a_closed_sphere_of_albedo_four_fifths_has_radiance_five_times_its_emission() {
    let description = sphere(0.8);
    for strategy in STRATEGIES {
        let film = shot(&description, strategy, 64, samples(strategy, 0.8));
        let want = EMISSION.map(|e| e / (1.0 - 0.8));
        assert_mean(&film, want, 1e-3, &strategy.to_string());
    }
}

/// Where walls that emit meet, light sampling alone has infinite variance (the density of a point next to the edge goes
/// with its squared distance): no number of samples here brings it within a tenth of a percent.
fn tolerance(strategy: Strategy, otherwise: f64) -> f64 {
    if strategy == Strategy::Light {
        2e-2
    } else {
        otherwise
    }
}

#[test]
fn a_closed_room_of_six_glowing_quads_is_a_furnace_too() {
    let description = room(0.5);
    for strategy in STRATEGIES {
        let film = shot(&description, strategy, 24, 2 * samples(strategy, 0.5));
        let want = EMISSION.map(|e| e / (1.0 - 0.5));
        assert_mean(
            &film,
            want,
            tolerance(strategy, 1e-3),
            &strategy.to_string(),
        );
    }
}

#[test]
fn a_path_of_n_edges_finds_the_first_n_terms_of_the_series() {
    for (name, description) in [("sphere", sphere(0.8)), ("room", room(0.8))] {
        for strategy in STRATEGIES {
            for edges in 1..=6 {
                let film = shot(&description, strategy, edges, 512);
                let what = format!("{name}, {strategy}, {edges} edges");
                assert_mean(&film, series(0.8, edges), tolerance(strategy, 5e-3), &what);
            }
        }
    }
}

#[test]
fn paths_stay_in_closed_spheres_and_rooms() {
    for (name, description) in [("sphere", sphere(1.0)), ("room", room(1.0))] {
        let mut settings = settings(&description, (32, 32), 64);
        (settings.strategy, settings.path_length) = (Strategy::Cosine, 100);
        let stats = stats(&description, &settings);
        let lost = 32 * 32 * 64 - stats.queue_sizes()[99];
        // Quads reach half a millionth beyond their edges. A hit there is beyond the neighbour, and may see the outside.
        let most = if name == "room" {
            stats.rays() / 1_000_000
        } else {
            0
        };
        assert!(lost <= most, "{name}: {lost} paths got out");
    }
}

#[test]
fn every_pixel_of_a_furnace_without_variance_is_exact() {
    let film = shot(&sphere(0.5), Strategy::Cosine, 20, 1);
    for pixel in film.means() {
        for (got, want) in pixel.into_iter().zip(series(0.5, 20)) {
            assert!(
                (f64::from(got) - want).abs() < 3e-6 * want,
                "{got} is not {want}"
            );
        }
    }
}

#[test]
fn russian_roulette_leaves_the_radiance_of_a_furnace_as_it_is() {
    let description = sphere(0.5);
    for strategy in STRATEGIES {
        for first in [1, 3] {
            let mut settings = settings(&description, (32, 32), 4096);
            settings.strategy = strategy;
            settings.path_length = 64;
            settings.roulette = Some(first);
            let want = EMISSION.map(|e| e / (1.0 - 0.5));
            assert_mean(
                &film(&description, &settings),
                want,
                2e-3,
                &format!("{strategy}, roulette {first}"),
            );
        }
    }
}

#[test]
fn russian_roulette_leaves_the_mean_of_coloured_scenes_as_it_is() {
    for name in ["cornell", "materials", "glossy"] {
        let description = builtin(name);
        let mut settings = settings(&description, (32, 32), 512);
        let whole = mean_and_error(&film(&description, &settings));
        settings.roulette = Some(2);
        settings.seed = 2;
        let cut = mean_and_error(&film(&description, &settings));
        for c in 0..3 {
            let z = (whole.0[c] - cut.0[c]) / whole.1[c].hypot(cut.1[c]);
            assert!(
                z.abs() < 4.0,
                "{name}, channel {c}: {} and {}",
                whole.0[c],
                cut.0[c]
            );
        }
    }
}
