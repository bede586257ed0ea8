//! Spherical harmonics: elements are directions, pixels, points or paths.

use crate::common::case::{Case, Face, Pace};
use glam::Vec3;
use ondine::lanes::{Rgb, Vec3x8, WIDTH, f32x8, u32x8};
use ondine::render::probes::bake;
use ondine::render::{Control, Settings};
use ondine::sampling::{Dimension, Sampler, warp};
use ondine::scene::builtin;
use ondine::sh::{Basis, Lobe, Probe, Shading, coefficients, project, published};
use std::hint::black_box;
use std::sync::atomic::AtomicBool;

/// Paths of a light probe.
const PATHS: u32 = 1 << 15;

/// Directions: as many as a wave has paths.
const DIRECTIONS: usize = 2048;

pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for degree in [2, 4, 8, 16, 64] {
        let name = |form| format!("basis/{form}/degree-{degree}");
        let lanes = move |face: Face| basis_in_lanes(degree, face);
        let rows = move |face: Face| basis_in_rows(degree, face);
        cases.push(Case::new(name("lanes"), Pace::Quick, lanes));
        cases.push(Case::new(name("rows"), Pace::Quick, rows));
    }
    for degree in [2, 8, 32] {
        let name = format!("project/degree-{degree}");
        let small = move |face: Face| projection(degree, face);
        cases.push(Case::new(name, Pace::Slow, small));
        for threads in [1, 2] {
            let name = format!("project/large/degree-{degree}/threads-{threads}");
            let large = move |face: Face| projection_on(threads, degree, face);
            cases.push(Case::timed(name, Pace::Slow, large));
        }
    }
    let grace = || published("grace").expect("a published probe");
    let even = || project(64, 32, &[Rgb::WHITE; 2048], 8).expect("a sky");
    let phong = Lobe::Phong(50.0);
    for (name, light, lobe) in [
        ("lambert/degree-2", grace as fn() -> Probe, Lobe::Cosine),
        ("phong/degree-2", grace, phong),
        ("phong/degree-8", even, phong),
    ] {
        let shade = move |face: Face| shading(&light(), lobe, face);
        cases.push(Case::new(format!("shade/{name}"), Pace::Quick, shade));
    }
    for degree in [0, 2, 8] {
        let probe = move |face: Face| probe(degree, face);
        let name = format!("probe/degree-{degree}");
        cases.push(Case::timed(name, Pace::Slow, probe));
    }
    cases
}

/// Uniform over the sphere.
fn directions() -> Vec<Vec3x8> {
    let sampler = Sampler::pcg(0, 1);
    (0..DIRECTIONS / WIDTH)
        .map(|batch| {
            let pixel = u32x8::splat(batch as u32);
            let path = sampler.path_key(pixel, u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]));
            warp::uniform_sphere(sampler.pair(path, Dimension::BsdfDirection, 0))
        })
        .collect()
}

/// As kernels use it.
fn basis_in_lanes(degree: usize, face: Face) {
    let directions = directions();
    let basis = Basis::new(degree);
    let mut values = vec![f32x8::ZERO; coefficients(degree)];
    face(DIRECTIONS, &mut || {
        for direction in black_box(&directions) {
            basis.evaluate(direction, &mut values);
            black_box(&mut values);
        }
    });
}

/// As NumPy has it.
fn basis_in_rows(degree: usize, face: Face) {
    let rows: Vec<[f32; 3]> = directions()
        .iter()
        .flat_map(|batch| (0..WIDTH).map(|lane| batch.lane(lane).to_array()))
        .collect();
    let basis = Basis::new(degree);
    let mut table = vec![0.0; DIRECTIONS * coefficients(degree)];
    face(DIRECTIONS, &mut || {
        basis.tabulate(black_box(&rows), black_box(&mut table));
    });
}

/// A sky of `2 * rows` × `rows` pixels.
fn sky(rows: usize) -> Vec<Rgb> {
    let value = |i: usize| (i as u32).wrapping_mul(2_654_435_761) as f32 / 4e9;
    (0..2 * rows * rows).map(|i| Rgb::splat(value(i))).collect()
}

/// On this thread.
fn projection(degree: usize, face: Face) {
    let pixels = sky(128);
    face(pixels.len(), &mut || {
        black_box(project(256, 128, black_box(&pixels), degree).expect("a sky"));
    });
}

/// A larger sky on threads of its own.
fn projection_on(threads: usize, degree: usize, face: Face) {
    let pixels = sky(1024);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("threads");
    face(pixels.len(), &mut || {
        let probe = pool.install(|| project(2048, 1024, black_box(&pixels), degree));
        black_box(probe.expect("a sky"));
    });
}

/// Eight points at a time.
fn shading(light: &Probe, lobe: Lobe, face: Face) {
    let normals = directions();
    let shading = Shading::new(light, lobe, Rgb::WHITE).expect("radiance");
    face(DIRECTIONS, &mut || {
        for &normal in black_box(&normals) {
            black_box(shading.shade(normal, Vec3x8::Z));
        }
    });
}

/// Paths from a point in the Cornell box, on one thread.
fn probe(degree: usize, face: Face) {
    let scene = builtin::open("cornell").expect("a built-in scene");
    let settings = Settings {
        spp: PATHS,
        path_length: 5,
        threads: Some(1),
        ..Settings::of(&scene)
    };
    let stop = AtomicBool::new(false);
    let control = Control {
        stop: &stop,
        progress: &|_| (),
    };
    face(PATHS as usize, &mut || {
        let point = black_box(&[Vec3::ZERO]);
        black_box(bake(&scene, point, degree, &settings, &control).expect("a probe"));
    });
}
