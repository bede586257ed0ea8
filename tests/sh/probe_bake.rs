//! Light probes: what arrives at a point, by its coefficients.

use crate::common::*;
use crate::render::{builtin, scene, settings};
use glam::Vec3;
use ondine::render::probes::{Baked, BakedProbes, SETS, bake};
use ondine::render::{Control, Settings};
use ondine::scene::description::{Description, Environment, Harmonics, SamplerKind};
use std::f64::consts::PI;
use std::sync::atomic::AtomicBool;

fn baked(
    description: &Description,
    positions: &[Vec3],
    degree: usize,
    settings: &Settings,
) -> BakedProbes {
    let stop = AtomicBool::new(false);
    let control = Control {
        stop: &stop,
        progress: &|_| (),
    };
    bake(description, positions, degree, settings, &control).unwrap()
}

/// (coefficient − want) / error of each coefficient and channel.
fn scores(probe: &Baked, want: &[[f64; 3]]) -> Vec<f64> {
    let probe = &probe.probe;
    let errors = probe.standard_errors.as_ref().unwrap();
    let each = probe.coefficients.iter().zip(errors).zip(want);
    each.flat_map(|((got, error), want)| (0..3).map(move |c| (got[c] - want[c]) / error[c]))
        .collect()
}

fn light() -> Vec<[f64; 3]> {
    (0..16)
        .map(|i| {
            let i = f64::from(i);
            [1.0 / (i + 1.0), (0.3 * i).sin(), -0.1 * i]
        })
        .collect()
}

fn empty(environment: Option<Environment>) -> Description {
    let mut description = scene(
        "[camera]\nposition = [0.0, 0.0, 4.0]\nlook_at = [0.0, 0.0, 0.0]\nvertical_fov = 20.0\n\
         [environment]\nconstant = [1.0, 1.0, 1.0]\n",
    );
    description.environment = environment;
    description
}

#[test]
fn a_probe_in_a_furnace_is_constant() {
    // Walls of albedo ½ that emit ½ have radiance 1 everywhere; paths of 40 edges find all but 2⁻⁴⁰ of it.
    let description = builtin("furnace");
    let mut settings = settings(&description, (8, 8), 1 << 12);
    settings.sampler = SamplerKind::Sobol;
    settings.path_length = 40;
    let inside = baked(&description, &[Vec3::new(0.1, -0.2, 0.05)], 3, &settings);
    let probe = &inside.probes[0].probe;
    let errors = probe.standard_errors.as_ref().unwrap();
    let radiance = probe.coefficients[0].map(|c| c / (4.0 * PI).sqrt());
    for c in 0..3 {
        // Four standard errors of Student's t with 15 degrees of freedom.
        let error = errors[0][c] / (4.0 * PI).sqrt();
        assert_close(radiance[c], 1.0, 1e-4, 5.0 * error, "radiance");
        for (coefficient, error) in probe.coefficients.iter().zip(errors).skip(1) {
            let part = (coefficient[c] / probe.coefficients[0][c]).abs();
            let error = error[c] / probe.coefficients[0][c];
            assert!(
                part < 5.0 * error + 1e-6,
                "{part} of the constant, error {error}"
            );
            assert!(error < 4e-3, "error {error}");
        }
    }
    assert_eq!(inside.rejected, 0);
}

#[test]
fn light_that_is_the_same_from_everywhere_has_one_coefficient_to_rounding() {
    let grey = ondine::lanes::Rgb::new(0.7, 0.3, 1.9);
    let description = empty(Some(Environment::Constant(grey)));
    for sampler in [SamplerKind::Pcg, SamplerKind::Sobol] {
        let mut settings = settings(&description, (8, 8), 64);
        settings.sampler = sampler;
        let probe = &baked(&description, &[Vec3::ZERO], 4, &settings).probes[0].probe;
        let errors = probe.standard_errors.as_ref().unwrap();
        for (coefficient, error) in probe.coefficients.iter().zip(errors).skip(1) {
            let most = coefficient.iter().chain(error).map(|x| x.abs());
            assert!(
                most.fold(0.0, f64::max) < 2e-6,
                "{coefficient:?} ± {error:?}"
            );
        }
    }
}

#[test]
fn a_probe_under_a_sky_has_the_coefficients_of_the_sky() {
    let want = light();
    let sky = Environment::Harmonics(Harmonics {
        source: String::from("test"),
        probe: ondine::sh::Probe::radiance(want.clone()).unwrap(),
        rotate_degrees: 0.0,
        clamp: false,
    });
    let description = empty(Some(sky));
    for sampler in [SamplerKind::Pcg, SamplerKind::Sobol] {
        let mut all = Vec::new();
        for seed in 0..20 {
            let mut settings = settings(&description, (8, 8), 1 << 12);
            (settings.sampler, settings.seed) = (sampler, seed);
            let found = baked(&description, &[Vec3::ZERO], 3, &settings);
            all.extend(scores(&found.probes[0], &want));
        }
        // Student's t with 15 degrees of freedom: variance 15/13, and 1 in 1200 beyond 4.2 either way.
        let n = all.len() as f64;
        let mean = all.iter().sum::<f64>() / n;
        let variance = all.iter().map(|t| t * t).sum::<f64>() / n;
        let far = all.iter().filter(|t| t.abs() > 4.2).count();
        // Channels of a probe share their directions: a third of the numbers are independent at worst.
        assert!(
            mean.abs() < 4.0 * (3.0 / n).sqrt(),
            "{sampler}: mean {mean}"
        );
        assert!(
            (0.9..1.45).contains(&variance),
            "{sampler}: variance {variance}"
        );
        assert!(far <= 6, "{sampler}: {far}");
    }
}

#[test]
fn threads_and_waves_do_not_change_a_bit_of_a_probe() {
    let description = builtin("cornell");
    let positions = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.5, -0.4, 0.3)];
    let mut settings = settings(&description, (8, 8), 777);
    settings.path_length = 4;
    let mut found = Vec::new();
    for (threads, wave) in [(1, 2048), (2, 16), (3, 100), (2, 65_536)] {
        settings.threads = Some(threads);
        settings.wave = wave;
        let probes = baked(&description, &positions, 4, &settings).probes;
        found.push(
            probes
                .into_iter()
                .map(|baked| baked.probe)
                .collect::<Vec<_>>(),
        );
    }
    assert!(found.iter().all(|each| each == &found[0]));
    assert_ne!(found[0][0], found[0][1]);
}

#[test]
fn samples_are_rounded_up_to_whole_sets() {
    let description = empty(Some(Environment::Constant(ondine::lanes::Rgb::WHITE)));
    for (spp, want) in [(1, SETS), (16, 16), (17, 32)] {
        let settings = settings(&description, (8, 8), spp);
        let found = baked(&description, &[Vec3::ZERO], 0, &settings);
        assert_eq!((found.spp, found.stats.paths()), (want, u64::from(want)));
        assert_close(
            found.probes[0].probe.coefficients[0][0],
            (4.0 * PI).sqrt(),
            1e-6,
            0.0,
            "L00",
        );
    }
}

#[test]
fn what_cannot_be_baked_is_refused() {
    let description = builtin("cornell");
    let settings = settings(&description, (8, 8), 16);
    let stop = AtomicBool::new(false);
    let control = Control {
        stop: &stop,
        progress: &|_| (),
    };
    let refused = |positions: &[Vec3], degree| {
        bake(&description, positions, degree, &settings, &control)
            .unwrap_err()
            .to_string()
    };
    let far = Vec3::new(0.0, f32::NAN, 1.0);
    assert!(refused(&[Vec3::ZERO, far], 2).contains("probe 1 (counted from 0)"));
    assert!(refused(&[Vec3::ZERO], 129).contains("it can be 0 to 128"));
    assert!(refused(&[], 2).contains("1 to 65535"));
}
