//! Images that differ by noise alone are seldom called biased.

use crate::{bare, image, render};
use ondine::compare::{Image, Options, Verdict, compare};
use ondine::scene::description::{SamplerKind, Strategy};

/// Pairs of images of one scene, each with seeds of its own.
fn pairs(count: u64, spp: [u32; 2]) -> Vec<[Image; 2]> {
    const SCENES: [&str; 5] = ["cornell", "mirror", "glass", "many-lights", "sky"];
    let scenes = SCENES.map(render::builtin);
    (0..count)
        .map(|i| {
            let scene = &scenes[i as usize % scenes.len()];
            let mut settings = render::settings(scene, (64, 64), 1);
            settings.sampler = match i / 5 % 2 {
                0 => SamplerKind::Pcg,
                _ => SamplerKind::Sobol,
            };
            [0, 1].map(|k| {
                settings.spp = spp[k];
                settings.seed = 1000 + 2 * i + k as u64;
                image(&render::film(scene, &settings))
            })
        })
        .collect()
}

fn alarms(pairs: &[[Image; 2]], alpha: f64, seen: fn(&Image) -> Image) -> usize {
    let options = Options {
        alpha,
        ..Options::default()
    };
    let biased = pairs.iter().filter(|pair| {
        let [reference, test] = [seen(&pair[0]), seen(&pair[1])];
        let report = compare(&reference, &test, &options).unwrap();
        report.verdict == Verdict::Biased
    });
    biased.count()
}

/// At most 1 % at the default significance; and no more than it says at one where alarms can be counted: with 5 % of 200, more
/// than 22 have a probability of 10⁻⁴.
fn seldom_alarmed(count: u64, spp: [u32; 2]) {
    let pairs = pairs(count, spp);
    for (what, seen) in [
        ("with variances", Image::clone as fn(&Image) -> Image),
        ("bare", bare),
    ] {
        let few = alarms(&pairs, Options::default().alpha, seen);
        let many = alarms(&pairs, 0.05, seen);
        assert!(few as u64 * 100 <= count, "{what}: {few} false alarms");
        assert!(
            many as u64 * 100 <= 11 * count,
            "{what}: {many} alarms at 0.05"
        );
    }
}

#[test]
fn two_hundred_pairs_of_equal_samples_give_no_false_alarm_but_two() {
    seldom_alarmed(200, [16, 16]);
}

#[test]
fn pairs_of_unequal_samples_give_no_false_alarms_either() {
    seldom_alarmed(100, [64, 8]);
}

/// How many of some images of one scene are called biased.
fn alarms_against(reference: &Image, tests: impl Iterator<Item = Image>) -> usize {
    tests
        .filter(|test| {
            let report = compare(reference, test, &Options::default()).unwrap();
            report.verdict == Verdict::Biased
        })
        .count()
}

#[test]
fn a_strategy_that_misses_small_lights_is_not_called_a_bias_of_one_that_does_not() {
    for name in ["cornell", "many-lights", "sky"] {
        let scene = render::builtin(name);
        let mut settings = render::settings(&scene, (64, 64), 128);
        settings.sampler = SamplerKind::Sobol;
        let reference = image(&render::film(&scene, &settings));
        settings.sampler = SamplerKind::Pcg;
        settings.strategy = Strategy::Uniform;
        let tests = (2..10).map(|seed| {
            settings.seed = seed;
            image(&render::film(&scene, &settings))
        });
        assert_eq!(alarms_against(&reference, tests), 0, "{name}");
    }
}

#[test]
fn rare_paths_of_few_samples_are_not_called_a_bias_of_their_length() {
    for name in ["glass", "materials"] {
        let scene = render::builtin(name);
        let mut settings = render::settings(&scene, (64, 64), 1024);
        settings.aovs = "bounces".parse().unwrap();
        let reference = image(&render::film(&scene, &settings));
        settings.spp = 8;
        let tests = (2..17).map(|seed| {
            settings.seed = seed;
            image(&render::film(&scene, &settings))
        });
        assert_eq!(alarms_against(&reference, tests), 0, "{name}");
    }
}

#[test]
fn an_image_upside_down_is_biased_or_said_to_be_too_noisy_to_tell() {
    for (name, flips_rows) in [("cornell", true), ("sky", false)] {
        let scene = render::builtin(name);
        let mut settings = render::settings(&scene, (64, 64), 64);
        let reference = image(&render::film(&scene, &settings));
        settings.seed = 2;
        let mut test = image(&render::film(&scene, &settings));
        let turn = |plane: &mut Vec<f32>| match flips_rows {
            true => *plane = plane.chunks(64).rev().flatten().copied().collect(),
            false => plane.chunks_mut(64).for_each(<[f32]>::reverse),
        };
        test.image.radiance.iter_mut().for_each(turn);
        test.image.variance.iter_mut().flatten().for_each(turn);
        let report = compare(&reference, &test, &Options::default()).unwrap();
        assert_eq!(
            report.verdict,
            Verdict::Biased,
            "{name}: {}",
            report.summary
        );
        let report = compare(&bare(&reference), &bare(&test), &Options::default()).unwrap();
        let says_so = report.summary.contains("so much noise");
        assert!(
            report.verdict == Verdict::Biased || says_so,
            "{name}: {}",
            report.summary
        );
    }
}
