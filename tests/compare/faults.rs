//! A port without faults is consistent with this program; each fault is called a bias.

use super::port::{self, Fault, PATH_LENGTH};
use crate::{bare, image, render};
use ondine::compare::{Image, Options, Report, Verdict, compare};
use ondine::scene::description::SamplerKind;
use std::ops::Range;

const FAULTS: [Fault; 4] = [
    Fault::DropsABounce,
    Fault::WrongCosine,
    Fault::PdfOff,
    Fault::Clamps,
];

fn verdict(reference: &Image, test: &Image) -> Report {
    compare(reference, test, &Options::default()).unwrap()
}

fn ours(side: u32, spp: u32, seed: u64) -> Image {
    let scene = render::builtin("cornell");
    let mut settings = render::settings(&scene, (side, side), spp);
    settings.sampler = SamplerKind::Sobol;
    settings.path_length = PATH_LENGTH as u32;
    settings.seed = seed;
    image(&render::film(&scene, &settings))
}

/// In images of 256×256 pixels with 256 samples.
fn faults_are_found(seeds: Range<u64>) {
    const SIDE: usize = 256;
    const SPP: u32 = 256;
    let reference = ours(SIDE as u32, 2 * SPP, 1);
    for seed in seeds {
        let faithful = port::render(SIDE, SPP, seed, Fault::None);
        for test in [&faithful, &bare(&faithful)] {
            let report = verdict(&reference, test);
            assert_eq!(report.verdict, Verdict::Consistent, "{}", report.summary);
        }
        for fault in FAULTS {
            let wrong = port::render(SIDE, SPP, seed, fault);
            for test in [&wrong, &bare(&wrong)] {
                let report = verdict(&reference, test);
                assert_eq!(
                    report.verdict,
                    Verdict::Biased,
                    "{fault:?}: {}",
                    report.summary
                );
            }
        }
    }
}

#[test]
fn each_fault_of_a_port_is_called_a_bias() {
    faults_are_found(0..1);
}

#[test]
#[ignore = "minutes"]
fn each_fault_of_a_port_is_called_a_bias_every_time() {
    faults_are_found(1..6);
}

#[test]
fn the_bounce_where_a_bias_begins_is_named() {
    let reference = port::render(64, 256, 100, Fault::None);
    let faithful = verdict(&reference, &port::render(64, 256, 101, Fault::None));
    assert_eq!(
        faithful.verdict,
        Verdict::Consistent,
        "{}",
        faithful.summary
    );
    assert_eq!(faithful.lengths.len(), PATH_LENGTH);
    for (fault, length) in [
        (Fault::DarkThirdEdge, 3),
        (Fault::DropsABounce, 5),
        (Fault::WrongCosine, 2),
    ] {
        let report = verdict(&reference, &port::render(64, 256, 102, fault));
        assert_eq!(
            report.verdict,
            Verdict::Biased,
            "{fault:?}: {}",
            report.summary
        );
        let begins = report.bias.unwrap().length;
        assert_eq!(begins, Some(length), "{fault:?}: {}", report.summary);
        let words = format!("the bias is first seen at path length {length}");
        assert!(report.summary.contains(&words), "{}", report.summary);
    }
}

#[test]
fn a_mean_that_is_off_by_three_in_a_thousand_is_found() {
    let reference = ours(64, 1024, 1);
    for seed in 2..5 {
        let mut test = ours(64, 1024, seed);
        let report = verdict(&reference, &test);
        assert_eq!(report.verdict, Verdict::Consistent, "{}", report.summary);
        assert!(report.detectable.unwrap() < 3e-3, "{:?}", report.detectable);
        for plane in &mut test.image.radiance {
            plane.iter_mut().for_each(|x| *x *= 1.003);
        }
        let report = verdict(&reference, &test);
        assert_eq!(report.verdict, Verdict::Biased, "{}", report.summary);
        let [low, high] = report.image.channels[3].mean.relative.unwrap().interval;
        assert!(
            low > 0.0 && low < 3.3e-3 && high > 2.7e-3,
            "{low} to {high}"
        );
    }
}
