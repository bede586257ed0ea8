//! The four strategies, and the two samplers, estimate the same image: block by block and in the mean.

#[path = "common/mod.rs"]
mod common;
#[path = "common/render.rs"]
mod render;

use common::gamma_q;
use ondine::film::Film;
use ondine::material::Material;
use ondine::scene::description::{Description, SamplerKind, Strategy};
use render::*;

/// Pixels on a side of an image.
const SIZE: u32 = 32;

/// Pixels on a side of a block.
const BLOCK: u32 = 4;

/// Where directions are uniform, a sample in thousands that hits a highlight or a lamp makes up a pixel: its sum is
/// farther from normal, its variance comes out too small with the mean, and it takes larger blocks to tell what differs.
const LARGE_BLOCK: u32 = 8;

/// Least p-value of a comparison; there are 8 × 6 × 3 of them here.
const LEAST_P: f64 = 1e-4;

/// Sum of the means of each block and its variance, of one channel.
fn blocks(film: &Film, size: u32, channel: usize) -> Vec<(f64, f64)> {
    let (means, variances) = (film.means(), film.variances());
    let side = SIZE / size;
    (0..side * side)
        .map(|block| {
            let (mut mean, mut variance) = (0.0, 0.0);
            for i in 0..size * size {
                let x = block % side * size + i % size;
                let y = block / side * size + i / size;
                let pixel = (y * SIZE + x) as usize;
                mean += f64::from(means[pixel][channel]);
                variance += f64::from(variances[pixel][channel]);
            }
            (mean, variance)
        })
        .collect()
}

/// χ² of the differences of blocks over their standard errors.
fn block_p(a: &Film, b: &Film, size: u32, channel: usize) -> f64 {
    let (mut statistic, mut freedom) = (0.0, 0u32);
    for ((a, va), (b, vb)) in blocks(a, size, channel)
        .into_iter()
        .zip(blocks(b, size, channel))
    {
        if va + vb > 0.0 {
            statistic += (a - b).powi(2) / (va + vb);
            freedom += 1;
        } else {
            assert!((a - b).abs() <= 1e-5 * a, "{a} and {b}, without variance");
        }
    }
    gamma_q(0.5 * f64::from(freedom), 0.5 * statistic)
}

fn assert_mean_agrees(a: &Film, b: &Film, what: &str) {
    let (a, b) = (mean_and_error(a), mean_and_error(b));
    for c in 0..3 {
        let error = a.1[c].hypot(b.1[c]);
        let z = (a.0[c] - b.0[c]) / error;
        let (a, b) = (a.0[c], b.0[c]);
        assert!(
            z.abs() < 4.0,
            "{what}, channel {c}: means {a} and {b}, z = {z:.2}"
        );
    }
}

/// Renders with each strategy at its number of samples per pixel, and compares each pair.
fn check(name: &str, spp: [u32; 4]) {
    check_scene(name, &builtin(name), spp);
}

fn check_scene(name: &str, description: &Description, spp: [u32; 4]) {
    let films: Vec<(Strategy, Film)> = (100..)
        .zip(STRATEGIES.into_iter().zip(spp))
        .map(|(seed, (strategy, spp))| {
            let mut settings = settings(description, (SIZE, SIZE), spp);
            settings.strategy = strategy;
            // Of its own, or else all see the same camera rays and agree better than chance.
            settings.seed = seed;
            (strategy, film(description, &settings))
        })
        .collect();
    for (i, (strategy, film)) in films.iter().enumerate() {
        for (other, against) in &films[..i] {
            let what = format!("{name}: {other} and {strategy}");
            let uniform = [strategy, other].contains(&&Strategy::Uniform);
            let size = if uniform { LARGE_BLOCK } else { BLOCK };
            for channel in 0..3 {
                let p = block_p(film, against, size, channel);
                println!("{what}, channel {channel}: p = {p:.4}");
                assert!(p > LEAST_P, "{what}, channel {channel}: p = {p:e}");
            }
            assert_mean_agrees(film, against, &what);
        }
    }
}

#[test]
fn strategies_agree_on_lambert() {
    check("cornell", [4096, 4096, 512, 512]);
}

#[test]
fn strategies_agree_on_mirrors_and_glass() {
    check("materials", [4096, 4096, 2048, 2048]);
}

#[test]
fn strategies_agree_on_rough_metals() {
    check("glossy", [32768, 8192, 2048, 1024]);
}

#[test]
fn strategies_agree_on_phong() {
    check("phong", [32768, 8192, 1024, 1024]);
}

#[test]
fn strategies_agree_on_principled_materials() {
    let mut description = builtin("cornell");
    for (i, named) in description.materials.iter_mut().enumerate() {
        named.material = Material::Principled {
            base_color: named.material.albedo(),
            metallic: if i == 0 { 0.0 } else { 0.5 },
            roughness: 0.5,
            ior: 1.5,
        };
    }
    check_scene("principled", &description, [8192, 8192, 1024, 1024]);
}

#[test]
fn strategies_agree_on_many_lights() {
    check("many-lights", [16384, 8192, 1024, 512]);
}

#[test]
fn strategies_agree_under_a_sky_and_a_sun() {
    check("sky", [8192, 8192, 1024, 512]);
}

#[test]
fn strategies_agree_through_a_lens() {
    check("blur", [32768, 8192, 1024, 1024]);
}

#[test]
fn samplers_agree() {
    for name in ["cornell", "materials", "sky", "many-lights"] {
        let description = builtin(name);
        let mut settings = settings(&description, (SIZE, SIZE), 1024);
        let independent = film(&description, &settings);
        settings.sampler = SamplerKind::Sobol;
        let stratified = film(&description, &settings);
        // The film's variance is that of independent samples: of stratified ones a bound, so p is too great, never too small.
        for channel in 0..3 {
            let p = block_p(&stratified, &independent, BLOCK, channel);
            assert!(p > LEAST_P, "{name}, channel {channel}: p = {p:e}");
        }
        assert_mean_agrees(&stratified, &independent, name);
    }
}

#[test]
fn a_difference_of_three_percent_in_one_material_is_found() {
    let mut description = builtin("cornell");
    let settings = settings(&description, (SIZE, SIZE), 1024);
    let right = film(&description, &settings);
    let white = ondine::lanes::Rgb::splat(0.73 * 0.97);
    description.materials[0].material = Material::Lambert { albedo: white };
    let wrong = film(&description, &settings);
    assert!(block_p(&right, &wrong, BLOCK, 0) < 1e-10);
}
