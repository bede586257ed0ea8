//! An image is a function of scene, settings and seed: not of threads, waves, crops or layers; nor of build or machine.

#[path = "common/render.rs"]
mod render;

use ondine::film::{AovSet, Film, Region};
use ondine::render::Settings;
use ondine::scene::builtin as all;
use ondine::scene::description::{Description, SamplerKind};
use render::*;

const SCENES: [&str; 4] = ["cornell", "materials", "many-lights", "sky"];

const SAMPLERS: [SamplerKind; 2] = [SamplerKind::Pcg, SamplerKind::Sobol];

/// 37 is no multiple of 16, nor is the width of any tile.
fn small(description: &Description, sampler: SamplerKind) -> Settings {
    let mut settings = settings(description, (45, 29), 37);
    settings.sampler = sampler;
    settings.threads = Some(1);
    settings
}

/// Every scene and sampler, with its image on one thread.
fn each(check: impl Fn(&Description, &Settings, &Film)) {
    for name in SCENES {
        let description = builtin(name);
        for sampler in SAMPLERS {
            let settings = small(&description, sampler);
            check(&description, &settings, &film(&description, &settings));
        }
    }
}

#[test]
fn the_image_does_not_depend_on_the_number_of_threads() {
    each(|description, settings, film| {
        for threads in [2, 7] {
            let settings = Settings {
                threads: Some(threads),
                ..settings.clone()
            };
            let other = render::film(description, &settings);
            assert_eq!(other.image_hash(), film.image_hash(), "{threads} threads");
        }
    });
}

#[test]
fn the_image_does_not_depend_on_the_size_of_a_wave() {
    each(|description, settings, film| {
        for wave in [16, 256, 500, 1024, 4096] {
            let settings = Settings {
                wave,
                threads: Some(2),
                ..settings.clone()
            };
            let other = render::film(description, &settings);
            assert_eq!(other.image_hash(), film.image_hash(), "waves of {wave}");
        }
    });
}

#[test]
fn a_crop_is_that_part_of_the_whole_image() {
    each(|description, settings, film| {
        for crop in [
            "0,0,1,1",
            "7,3,30,22",
            "44,0,45,29",
            "0,28,45,29",
            "16,8,32,16",
        ] {
            let region: Region = crop.parse().expect("a region");
            let settings = Settings {
                region,
                ..settings.clone()
            };
            let part = render::film(description, &settings);
            let same_part = film.image_hash_of(region).expect("within");
            assert_eq!(part.image_hash(), same_part, "{crop}");
        }
    });
}

#[test]
fn the_image_does_not_depend_on_the_layers_beside_it() {
    each(|description, settings, film| {
        for layers in ["depth", "bounces", "albedo,normal,depth,bounces"] {
            let aovs: AovSet = layers.parse().expect("layers");
            let settings = Settings {
                aovs,
                ..settings.clone()
            };
            let other = render::film(description, &settings);
            assert_eq!(other.image_hash(), film.image_hash(), "{layers}");
        }
    });
}

#[test]
fn path_lengths_keep_their_bits_whatever_the_wave_and_however_long_the_longest() {
    each(|description, settings, _| {
        let film = |path_length, threads, wave| {
            let settings = Settings {
                aovs: "bounces".parse().expect("layers"),
                path_length,
                threads: Some(threads),
                wave,
                ..settings.clone()
            };
            render::film(description, &settings)
        };
        let films = [film(5, 1, 2048), film(5, 3, 100), film(7, 2, 777)];
        let sums = |film: &Film, length| -> Vec<_> {
            let pixels = film.region().coordinates();
            pixels
                .map(|(x, y)| film.sums_of_length(length, x, y))
                .collect()
        };
        for length in 1..=5 {
            let [one, other, longer] = &films;
            assert!(sums(one, length) == sums(other, length), "{length}");
            // The last edge looks for light alone, from one side: the same light to rounding.
            assert!(
                length == 5 || sums(one, length) == sums(longer, length),
                "{length}"
            );
        }
    });
}

#[test]
fn path_lengths_add_up_to_the_image() {
    each(|description, settings, film| {
        let settings = Settings {
            aovs: "bounces".parse().expect("layers"),
            ..settings.clone()
        };
        let layered = render::film(description, &settings);
        let mut lit = vec![false; settings.path_length as usize];
        for (x, y) in layered.region().coordinates() {
            let count = layered.count(x, y);
            let mut sum = [0.0; 3];
            for (length, lit) in (1..).zip(&mut lit) {
                let mean = layered.sums_of_length(length, x, y).mean(count);
                *lit |= mean != [0.0; 3];
                (0..3).for_each(|c| sum[c] += f64::from(mean[c]));
            }
            for (sum, mean) in sum.into_iter().zip(film.mean(x, y)) {
                let mean = f64::from(mean);
                assert!(
                    (sum - mean).abs() <= 2e-6 * mean,
                    "{x},{y}: {sum} is not {mean}"
                );
            }
        }
        assert!(
            lit.iter().all(|lit| *lit),
            "light on paths of every length: {lit:?}"
        );
    });
}

#[test]
fn roulette_and_strategies_keep_their_bits_too() {
    let description = builtin("materials");
    for strategy in STRATEGIES {
        let one = Settings {
            strategy,
            roulette: Some(2),
            ..small(&description, SamplerKind::Sobol)
        };
        let other = Settings {
            threads: Some(3),
            wave: 333,
            ..one.clone()
        };
        let hashes = [one, other].map(|settings| film(&description, &settings).image_hash());
        assert_eq!(hashes[0], hashes[1], "{strategy}");
    }
}

#[test]
fn every_setting_that_is_to_change_the_image_does() {
    let description = builtin("materials");
    let base = small(&description, SamplerKind::Sobol);
    let mut hashes: Vec<String> = [
        base.clone(),
        Settings {
            seed: 2,
            ..base.clone()
        },
        Settings {
            seed: 1 << 32 | 1,
            ..base.clone()
        },
        Settings {
            spp: 38,
            ..base.clone()
        },
        Settings {
            path_length: 4,
            ..base.clone()
        },
        Settings {
            sampler: SamplerKind::Pcg,
            ..base.clone()
        },
        Settings {
            strategy: STRATEGIES[0],
            ..base.clone()
        },
        Settings {
            strategy: STRATEGIES[1],
            ..base.clone()
        },
        Settings {
            strategy: STRATEGIES[2],
            ..base.clone()
        },
        Settings {
            roulette: Some(2),
            ..base
        },
    ]
    .iter()
    .map(|settings| film(&description, settings).image_hash())
    .collect();
    let count = hashes.len();
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), count);
}

/// The image hash of every built-in scene at 24x16 pixels and 5 samples per pixel, all else as the scene has it.
///
/// Debug and release builds and all machines of one architecture are held to the same bits by this table. A change of the
/// estimator's arithmetic (the order of a sum, a fused multiply-add, a random dimension) changes it legitimately: paste
/// what the failure prints, and say so in CHANGELOG.md, for users' images change too.
const GOLDEN: &[(&str, &str)] = &[
    (
        "cornell",
        "b706786f276ff125edceca2a58cb236d076e39a2669994e9488b7537020655a7",
    ),
    (
        "mirror",
        "114ec09798d49e707f3d6348aab4461f06a19715f28339984d06ac04bc7429a0",
    ),
    (
        "glass",
        "fb07dacb434811de45a80103f824ec5bdff020ccfe34194883433fa34705723b",
    ),
    (
        "glossy",
        "2f778949ec5dabbc03ad51a144cb7f75d8925d609488737accaf75d8eb45113e",
    ),
    (
        "phong",
        "79da261f7fb5e4608bba298638b13125161278b63721581415e86c3ad45f6cbe",
    ),
    (
        "blur",
        "ea496aaf6d255a8e5f6d3e8e06578658138e541916a82dcea2dfdeeef9e87b56",
    ),
    (
        "materials",
        "83b03a617c8ed77d0e274bde5dacf158ac486e4ad6ba14f3dfc71d43402d6e00",
    ),
    (
        "many-lights",
        "5898cb01e1df5bd9d709708df7c2cbbbf2aaaa03f347b6d8f9e0df19b3b59a7d",
    ),
    (
        "sky",
        "4deb5307a04c673c1843a9991a7e22962009174dd6a089c085a30c38baea70cf",
    ),
    (
        "sh-grace",
        "26b805d8ac250caa26963dfde8582e23aa5c2ffb125bd78573e21d15b14bcea4",
    ),
    (
        "sh-eucalyptus",
        "3cedfd6f77692ae265f210347ea80500e37404876921e5e445992ec414ab30f3",
    ),
    (
        "furnace",
        "61bbee264da4078c87414db635397e324d61030f889c812eadcf1a2f27c7a414",
    ),
];

#[test]
fn images_are_those_of_the_table() {
    let found: Vec<(&str, String)> = all::ALL
        .iter()
        .map(|scene| {
            let description = builtin(scene.name);
            let mut settings = Settings::of(&description);
            settings.set_size(24, 16);
            settings.spp = 5;
            (scene.name, film(&description, &settings).image_hash())
        })
        .collect();
    let same = found.len() == GOLDEN.len()
        && found
            .iter()
            .zip(GOLDEN)
            .all(|((a, hash), (b, golden))| a == b && hash == golden);
    let lines: Vec<String> = found
        .iter()
        .map(|(name, hash)| format!("    (\n        \"{name}\",\n        \"{hash}\",\n    ),\n"))
        .collect();
    assert!(
        same,
        "images changed; if that is meant, this is the table to paste:\nconst GOLDEN: &[(&str, &str)] = &[\n{}];",
        lines.concat()
    );
}
