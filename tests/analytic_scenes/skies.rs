//! Skies: seen directly, by a reflecting plane, and by spheres that lose no light.

use crate::common::{self, V, dot, unit};
use crate::render::*;
use ondine::lanes::Rgb;
use ondine::scene::description::{Description, Environment, LatLong, Strategy};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

fn camera(position: V, look_at: V, fov: f64) -> String {
    format!(
        "[camera]\nposition = {position:?}\nlook_at = {look_at:?}\nup = [0.0, 1.0, 0.02]\nvertical_fov = {fov:?}\n"
    )
}

fn seen(description: &Description, size: (u32, u32), spp: u32) -> ondine::film::Film {
    let mut settings = settings(description, size, spp);
    settings.path_length = 1;
    film(description, &settings)
}

#[test]
fn a_constant_sky_is_its_radiance_in_every_pixel_for_every_strategy() {
    let text =
        camera([0.0; 3], [1.0, 0.3, 0.2], 90.0) + "[environment]\nconstant = [0.3, 1.7, 2.5]\n";
    let description = scene(&text);
    for strategy in STRATEGIES {
        for edges in [1, 2, 5] {
            let mut settings = settings(&description, (16, 9), 5);
            (settings.strategy, settings.path_length) = (strategy, edges);
            let means = film(&description, &settings).means();
            assert_eq!(means, vec![[0.3, 1.7, 2.5]; 16 * 9]);
        }
    }
}

/// The direction through a point of the image, pixels, by the pinhole's definition.
fn direction(description: &Description, (width, height): (u32, u32), x: f64, y: f64) -> V {
    let camera = &description.cameras[0].camera;
    let forward = (camera.look_at - camera.position).as_dvec3().normalize();
    let right = forward.cross(camera.up.as_dvec3()).normalize();
    let up = right.cross(forward);
    let tan = (f64::from(camera.vertical_fov).to_radians() / 2.0).tan();
    let (width, height) = (f64::from(width), f64::from(height));
    let d = forward
        + right * (tan * width / height * (2.0 * x / width - 1.0))
        + up * (tan * (1.0 - 2.0 * y / height));
    d.normalize().to_array()
}

#[test]
fn a_gradient_sky_is_its_average_over_every_pixel() {
    let size = (12, 8);
    for look_at in [[1.0, 0.1, 0.3], [0.2, 1.0, 0.1], [-0.3, -1.0, 0.6]] {
        let text = camera([0.0; 3], look_at, 80.0)
            + "[environment]\ngradient = { zenith = [0.1, 0.3, 2.0], horizon = [1.0, 0.8, 0.6], ground = [0.2, 0.0, 0.05] }\n";
        let description = scene(&text);
        let film = seen(&description, size, 4096);
        for y in 0..size.1 {
            for x in 0..size.0 {
                const STEPS: usize = 32;
                let mut want = [0.0; 3];
                for i in 0..STEPS * STEPS {
                    let at = |i: usize| (i as f64 + 0.5) / STEPS as f64;
                    let (dx, dy) = (at(i % STEPS), at(i / STEPS));
                    let up = direction(&description, size, f64::from(x) + dx, f64::from(y) + dy)[1];
                    let end = if up > 0.0 {
                        [0.1, 0.3, 2.0]
                    } else {
                        [0.2, 0.0, 0.05]
                    };
                    let horizon = [1.0, 0.8, 0.6];
                    for c in 0..3 {
                        want[c] += (horizon[c] + (end[c] - horizon[c]) * up.abs())
                            / (STEPS * STEPS) as f64;
                    }
                }
                let (mean, variance) = (film.mean(x, y), film.variance(x, y));
                for c in 0..3 {
                    // 864 numbers: |z| > 5 has probability 5e-4 in all of them together.
                    let slack = 5.0 * f64::from(variance[c]).sqrt() + 1e-5;
                    common::assert_close(f64::from(mean[c]), want[c], 0.0, slack, "gradient");
                }
            }
        }
    }
}

#[test]
fn each_pixel_within_a_texel_of_an_image_sky_is_that_texel() {
    let (width, height) = (16, 8);
    let texel = |x: usize, y: usize| Rgb::new(1.0 + x as f32, 0.25 * y as f32, (x * y) as f32);
    let image = Arc::new(LatLong {
        file: "test".into(),
        width,
        height,
        pixels: (0..width * height)
            .map(|i| texel(i % width, i / width))
            .collect(),
    });
    let mut inside = 0;
    for rotate_degrees in [0.0f32, 37.0] {
        for look_at in [[1.0, 0.2, 0.3], [-0.4, -0.5, 0.6], [0.0, 0.1, -1.0]] {
            let mut description = scene(
                &(camera([0.0; 3], look_at, 70.0) + "[environment]\nconstant = [1.0, 1.0, 1.0]\n"),
            );
            description.environment = Some(Environment::Image {
                image: Arc::clone(&image),
                rotate_degrees,
            });
            let size = (40, 40);
            let film = seen(&description, size, 4);
            for y in 0..size.1 {
                for x in 0..size.0 {
                    // (sin θ sin φ, cos θ, −sin θ cos φ), turned counter-clockwise around +y.
                    let at = |dx: f64, dy: f64| {
                        let [a, b, c] =
                            direction(&description, size, f64::from(x) + dx, f64::from(y) + dy);
                        let turns = a.atan2(-c) / TAU + f64::from(rotate_degrees) / 360.0;
                        let column = turns.rem_euclid(1.0) * width as f64;
                        (column as usize, (b.acos() / PI * height as f64) as usize)
                    };
                    let corner = at(-0.01, -0.01);
                    if [at(1.01, -0.01), at(-0.01, 1.01), at(1.01, 1.01)]
                        .iter()
                        .all(|other| *other == corner)
                    {
                        inside += 1;
                        assert_eq!(
                            film.mean(x, y),
                            texel(corner.0, corner.1).to_array(),
                            "{x},{y}"
                        );
                    }
                }
            }
        }
    }
    assert!(inside > 6000, "{inside} pixels are within one texel");
}

/// A plane y = 0 under a white sky, looked at from the direction of that cosine.
fn plane(material: &str, cosine: f64) -> Description {
    let from = common::at(cosine, 25.0);
    scene(&format!(
        "{}[environment]\nconstant = [1.0, 1.0, 1.0]\n[materials.plane]\n{material}\n\
         [[objects]]\nquad = {{ corner = [-500.0, 0.0, 500.0], u = [1000.0, 0.0, 0.0], v = [0.0, 0.0, -1000.0] }}\nmaterial = \"plane\"\n",
        camera(
            [from[0] * 5.0, from[2] * 5.0, from[1] * 5.0],
            [0.0; 3],
            0.05
        ),
    ))
}

/// ∫ f(wi) dω over the hemisphere, midpoints.
fn hemisphere(f: impl Fn(V) -> f64) -> f64 {
    const RINGS: usize = 2000;
    const SECTORS: usize = 2000;
    let mut sum = 0.0;
    for ring in 0..RINGS {
        // cos θ = 1 − s²: finer towards the normal.
        let s = (ring as f64 + 0.5) / RINGS as f64;
        for sector in 0..SECTORS {
            let wi = common::at(1.0 - s * s, (sector as f64 + 0.5) / SECTORS as f64 * 360.0);
            sum += f(wi) * 2.0 * s;
        }
    }
    sum * TAU / (RINGS * SECTORS) as f64
}

fn check_plane(material: &str, cosine: f64, want: f64, spp: [u32; 4]) {
    let description = plane(material, cosine);
    for (strategy, spp) in STRATEGIES.into_iter().zip(spp) {
        let mut settings = settings(&description, (16, 16), spp);
        (settings.strategy, settings.path_length) = (strategy, 2);
        let film = film(&description, &settings);
        assert_mean(
            &film,
            [want; 3],
            5e-3,
            &format!("{material} at {cosine}, {strategy}"),
        );
    }
}

#[test]
fn a_lambert_plane_under_a_white_sky_has_its_albedo() {
    check_plane(
        "type = \"lambert\"\nalbedo = [0.7, 0.7, 0.7]",
        0.4,
        0.7,
        [4096, 64, 4096, 1024],
    );
}

#[test]
fn a_phong_plane_under_a_white_sky_has_its_directional_albedo() {
    for (cosine, n) in [(0.9, 8.0), (0.4, 30.0), (0.2, 3.0)] {
        let wo = common::at(cosine, 0.0);
        let mirrored = [-wo[0], -wo[1], wo[2]];
        let want = hemisphere(|wi| {
            let lobe = dot(wi, mirrored).max(0.0).powf(n);
            (0.3 / PI + 0.6 * (n + 2.0) / TAU * lobe) * wi[2]
        });
        let material = format!(
            "type = \"phong\"\ndiffuse = [0.3, 0.3, 0.3]\nspecular = [0.6, 0.6, 0.6]\nexponent = {n:?}"
        );
        check_plane(&material, cosine, want, [16384, 2048, 16384, 4096]);
    }
}

#[test]
fn a_conductor_plane_under_a_white_sky_has_its_directional_albedo() {
    for (cosine, alpha) in [(0.9, 0.5), (0.4, 0.3), (0.2, 0.9)] {
        let wo = common::at(cosine, 0.0);
        let tan2 = |w: V| (1.0 - w[2] * w[2]) / (w[2] * w[2]);
        let lambda = |w: V| 0.5 * ((1.0 + alpha * alpha * tan2(w)).sqrt() - 1.0);
        let want = hemisphere(|wi| {
            let h = unit([wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2]]);
            let d = 1.0
                / (PI * alpha * alpha * h[2].powi(4) * (1.0 + tan2(h) / (alpha * alpha)).powi(2));
            0.9 * d / (1.0 + lambda(wo) + lambda(wi)) / (4.0 * wo[2])
        });
        let material =
            format!("type = \"conductor\"\nroughness = {alpha:?}\nreflectance = [0.9, 0.9, 0.9]");
        check_plane(&material, cosine, want, [16384, 1024, 16384, 4096]);
    }
}

#[test]
fn glass_and_mirror_spheres_vanish_in_a_white_sky() {
    for (name, material) in [
        ("mirror", "type = \"mirror\"\nreflectance = [1.0, 1.0, 1.0]"),
        ("glass", "type = \"glass\"\nior = 1.5"),
        ("diamond", "type = \"glass\"\nior = 2.4"),
        ("bubble", "type = \"glass\"\nior = 0.7"),
    ] {
        let description = scene(&format!(
            "{}[environment]\nconstant = [1.0, 1.0, 1.0]\n[materials.it]\n{material}\n\
             [[objects]]\nsphere = {{ center = [0.0, 0.0, 0.0], radius = 1.0 }}\nmaterial = \"it\"\n",
            camera([0.0, 0.0, 3.0], [0.0; 3], 45.0)
        ));
        for strategy in STRATEGIES {
            // Many internal reflections near the rim: what is still inside after 500 edges is below 1e-5 of the light.
            let mut settings = settings(&description, (32, 32), 64);
            (settings.strategy, settings.path_length) = (strategy, 500);
            let film = film(&description, &settings);
            for pixel in film.means() {
                assert!(
                    pixel.iter().all(|c| (c - 1.0).abs() < 2e-2),
                    "{name}, {strategy}: {pixel:?}"
                );
            }
            let (mean, _) = mean_and_error(&film);
            assert!(
                mean.iter().all(|c| (c - 1.0).abs() < 1e-4),
                "{name}, {strategy}: {mean:?}"
            );
        }
    }
}

#[test]
fn a_texture_of_the_sky_lights_a_plane_as_its_integral_says() {
    // One bright texel at 45° above a lambert plane: E = L · ∫ cos dω over the texel.
    let (width, height) = (32, 16);
    let mut pixels = vec![Rgb::splat(0.1); width * height];
    pixels[4 * width + 7] = Rgb::new(200.0, 100.0, 50.0);
    let mut description = plane("type = \"lambert\"\nalbedo = [0.5, 0.5, 0.5]", 0.8);
    description.environment = Some(Environment::Image {
        image: Arc::new(LatLong {
            file: "test".into(),
            width,
            height,
            pixels,
        }),
        rotate_degrees: 20.0,
    });
    let row = |y: usize| PI * y as f64 / height as f64;
    // ∫ cos θ dω of a row's texel, θ from +y.
    let texel = TAU / width as f64 * 0.5 * (row(5).sin().powi(2) - row(4).sin().powi(2));
    let want = [200.0, 100.0, 50.0].map(|l: f64| 0.5 / PI * (0.1 * (PI - texel) + l * texel));
    for (strategy, spp) in STRATEGIES.into_iter().zip([16384, 16384, 2048, 2048]) {
        let mut settings = settings(&description, (16, 16), spp);
        (settings.strategy, settings.path_length) = (strategy, 2);
        assert_mean(
            &film(&description, &settings),
            want,
            1e-2,
            &strategy.to_string(),
        );
    }
}

#[test]
fn a_dark_scene_is_black_and_nothing_is_rejected() {
    let mut description = plane("type = \"lambert\"\nalbedo = [0.5, 0.5, 0.5]", 0.8);
    for environment in [None, Some(Environment::Constant(Rgb::BLACK))] {
        description.environment = environment;
        for strategy in [Strategy::Uniform, Strategy::Light, Strategy::Mis] {
            let mut settings = settings(&description, (8, 8), 4);
            settings.strategy = strategy;
            assert_eq!(film(&description, &settings).means(), vec![[0.0; 3]; 64]);
        }
    }
}
