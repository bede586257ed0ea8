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
        for layers in ["depth", "albedo,normal,depth"] {
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
        "1968bf985b48e8f8c8f86a1fdb6a1501fb432312e5a7af5eda727f29c8f39e6a",
    ),
    (
        "mirror",
        "e1ef9f5d3453bebc0580c824c8683c648362f7548d15aa3b50ed17e42b0c1611",
    ),
    (
        "glass",
        "de324552e7eedf75cddec89a0b2594f4373bbe25a8be728e36612fae94c32495",
    ),
    (
        "glossy",
        "7f9cb4e3b8c8a88a724ee54aef84de24008794cc67f8deb534dce05d113d3d26",
    ),
    (
        "phong",
        "7bfe9ec2d627bbf0a38f0bf2a59f0a9b644f7d725ff4ce7f921d1d42d5cf1b56",
    ),
    (
        "blur",
        "1d5fb96e573de7f5d69f575e77d9e3dfe00290b83451a2769d97ffb164b8315f",
    ),
    (
        "materials",
        "983e9c765586bfbc6c8364baf39d95f1675c4a6dfdc6c8f172dfeb2f86e330bd",
    ),
    (
        "many-lights",
        "e9b35b65feb417b5c11875a3292978b7e98b4b727ee4dae815c41af16722965a",
    ),
    (
        "sky",
        "b32cc3ae7ddab2b3782421294c7274c73f86ee21da0c5c3d3731e5ec51f52d9f",
    ),
    (
        "furnace",
        "8b8710e8658c6f30bad9768a7dc305ca96100926dce6eed987e5a75b5e1140cd",
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
