//! Images that differ by noise alone are seldom called biased.

use crate::{bare, image, render};
use ondine::compare::{Image, Options, Verdict, compare};
use ondine::scene::description::SamplerKind;

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
