//! Exactness in memory.

use crate::{ALL, Random, assert_same, filled, waves};
use ondine::error::Error;
use ondine::film::{AovSample, AovSet, Film, Layers, Region};

const REGION: Region = Region::full(23, 19);

fn new(aovs: AovSet) -> Film {
    Film::new(23, 19, REGION, aovs).unwrap()
}

#[test]
fn any_order_of_waves_gives_the_same_bits() {
    let expected = filled(23, 19, REGION, 40);
    let mut all = waves(REGION, 40);
    let mut random = Random(1);
    for _ in 0..5 {
        random.shuffle(&mut all);
        let film = new(ALL);
        all.iter().for_each(|wave| wave.add_to(&film));
        assert_same(&film, &expected);
    }
}

#[test]
fn any_grouping_into_shards_merges_to_the_same_bits() {
    let expected = filled(23, 19, REGION, 40);
    let all = waves(REGION, 40);
    let mut random = Random(2);
    for count in [2, 3, 7] {
        let mut shards: Vec<Film> = (0..count).map(|_| new(ALL)).collect();
        for wave in &all {
            wave.add_to(&shards[random.below(count)]);
        }
        random.shuffle(&mut shards);
        let mut merged = new(ALL);
        for shard in &shards {
            merged.merge(shard).unwrap();
        }
        assert_same(&merged, &expected);
    }
}

#[test]
fn threads_adding_at_once_give_the_same_hash() {
    let expected = filled(23, 19, REGION, 64);
    let all = waves(REGION, 64);
    let film = new(ALL);
    let next = std::sync::atomic::AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                while let Some(wave) =
                    all.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed))
                {
                    wave.add_to(&film);
                }
            });
        }
    });
    assert_same(&film, &expected);
}

#[test]
fn mean_variance_and_aovs_agree_with_the_textbook() {
    let film = filled(23, 19, REGION, 40);
    let all = waves(REGION, 40);
    for (x, y) in [(0, 0), (22, 18), (7, 8), (13, 5)] {
        let (mut values, mut depths) = (Vec::new(), Vec::new());
        for wave in all.iter().filter(|wave| wave.tile.has(x, y)) {
            let pixel = (y - wave.tile.y0) * wave.tile.width() + x - wave.tile.x0;
            let slots = (pixel * wave.samples) as usize..((pixel + 1) * wave.samples) as usize;
            values.extend_from_slice(&wave.radiance[slots.clone()]);
            depths.extend(wave.aovs[slots].iter().map(|aov| f64::from(aov.depth)));
        }
        let n = values.len() as f64;
        assert_eq!(film.count(x, y), 40);
        for c in 0..3 {
            let channel = || values.iter().map(|v| f64::from(v[c]));
            let mean = channel().sum::<f64>() / n;
            let variance = channel().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
            let close = |a: f32, b: f64| (f64::from(a) / b - 1.0).abs() < 1e-6;
            assert!(close(film.mean(x, y)[c], mean));
            assert!(close(film.variance(x, y)[c], variance));
        }
        let depth = depths.iter().sum::<f64>() / n;
        assert!((f64::from(film.aov(x, y).depth) / depth - 1.0).abs() < 1e-6);
    }
    let empty = new(AovSet::default());
    assert_eq!(
        (empty.mean(0, 0), empty.variance(0, 0)),
        ([0.0; 3], [0.0; 3])
    );
}

#[test]
fn what_is_not_finite_or_too_large_is_counted_and_kept_out() {
    let pixel = Region::full(1, 1);
    let film = Film::new(1, 1, pixel, ALL).unwrap();
    let largest = 4_294_967_040.0; // the last f32 below 2^32
    let bad = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        4_294_967_296.0,
        -1e30,
    ];
    let mut radiance = vec![[1.0, largest, 2.0, f32::INFINITY]];
    for (i, &x) in bad.iter().enumerate() {
        let mut sample = [5.0; 4];
        sample[i % 3] = x;
        radiance.push(sample);
    }
    radiance.push([3.0, -largest, -4.0, 0.0]);
    let mut aovs = vec![
        AovSample {
            depth: 2.0,
            ..AovSample::default()
        };
        radiance.len()
    ];
    aovs[6].albedo = [f32::NAN, 1.0, f32::INFINITY];
    let by_length = [radiance.clone(), vec![[f32::NAN, 2.0, 1.0, 0.0]; 7]];
    let layers = Layers {
        first_hits: &aovs,
        by_length: &by_length,
    };
    film.add(pixel, 7, &radiance, layers);
    assert_eq!(film.rejected(), bad.len() as u64);
    assert_eq!(film.count(0, 0), 2);
    assert_eq!(film.mean(0, 0), [2.0, 0.0, -1.0]);
    assert_eq!(film.aov(0, 0).albedo, [0.0, 0.5, 0.0]);
    assert_eq!(film.aov(0, 0).depth, 2.0);
    assert_eq!(film.sums_of_length(1, 0, 0), film.sums(0, 0));
    assert_eq!(film.sums_of_length(2, 0, 0), Default::default());

    let clean = Film::new(1, 1, pixel, AovSet::default()).unwrap();
    clean.add(pixel, 2, &[radiance[0], radiance[6]], Layers::default());
    assert_eq!(film.image_hash(), clean.image_hash());
}

#[test]
fn aovs_do_not_change_the_image_hash() {
    let with = filled(23, 19, REGION, 16);
    let without = new(AovSet::default());
    for wave in waves(REGION, 16) {
        without.add(wave.tile, wave.samples, &wave.radiance, Layers::default());
    }
    assert_eq!(with.image_hash(), without.image_hash());
}

#[test]
fn a_crop_has_the_hash_of_that_region_of_the_whole() {
    let crop = Region {
        x0: 4,
        y0: 3,
        x1: 17,
        y1: 16,
    };
    let whole = filled(23, 19, REGION, 20);
    let part = filled(23, 19, crop, 20);
    assert_eq!(whole.image_hash_of(crop).unwrap(), part.image_hash());
    assert_ne!(whole.image_hash(), part.image_hash());
    assert!(part.image_hash_of(REGION).is_err());
}

#[test]
fn crops_merge_into_the_whole() {
    let expected = filled(23, 19, REGION, 20);
    let cut = |x0, y0, x1, y1| filled(23, 19, Region { x0, y0, x1, y1 }, 20);
    let mut merged = cut(0, 0, 11, 6);
    // Corner to corner: until the others come, two quarters hold nothing.
    merged.merge(&cut(11, 6, 23, 19)).unwrap();
    assert_eq!(merged.region(), REGION);
    assert_eq!(merged.count(20, 2), 0);
    merged.merge(&cut(11, 0, 23, 6)).unwrap();
    merged.merge(&cut(0, 6, 11, 19)).unwrap();
    assert_same(&merged, &expected);
}

#[test]
fn a_merge_that_cannot_be_adds_nothing() {
    let mut film = filled(23, 19, REGION, 16);
    let hash = film.image_hash();
    let wider = Film::new(24, 19, REGION, ALL).unwrap();
    let fewer = new(AovSet::default());
    let longer = new(AovSet { lengths: 3, ..ALL });
    for other in [wider, fewer, longer] {
        assert!(matches!(film.merge(&other), Err(Error::Usage(_))));
    }
    // Doubling passes 2^27 samples at the 24th time.
    let mut results = (0..40).map(|_| {
        let mut copy = new(ALL);
        copy.merge(&film).unwrap();
        film.merge(&copy)
    });
    let refused = results.find_map(Result::err).unwrap().to_string();
    assert!(refused.contains("134217728 samples"), "{refused}");
    assert_eq!(film.count(3, 3), 1 << 27);
    assert_ne!(film.image_hash(), hash);
}

#[test]
fn regions_and_aovs_are_read_with_good_errors() {
    assert_eq!(
        "1, 2,3,4".parse::<Region>().unwrap(),
        Region {
            x0: 1,
            y0: 2,
            x1: 3,
            y1: 4
        }
    );
    for wrong in ["", "1,2,3", "1,2,3,x", "3,0,3,4", "1,2,3,4,5", "-1,0,3,4"] {
        assert!(
            matches!(wrong.parse::<Region>(), Err(Error::Usage(_))),
            "{wrong}"
        );
    }
    let set: AovSet = "depth,albedo".parse().unwrap();
    assert_eq!(
        (set.to_string(), set.components()),
        ("albedo,depth".to_owned(), 4)
    );
    assert_eq!("".parse::<AovSet>().unwrap(), AovSet::default());
    let bounces: AovSet = "bounces".parse().unwrap();
    assert_eq!(bounces.up_to(7).lengths, 7);
    assert!(bounces.check().is_err());
    let error = "normals".parse::<AovSet>().unwrap_err().to_string();
    assert!(error.contains("did you mean \"normal\"?"), "{error}");
    for wrong in [
        Region::full(0, 4),
        Region::full(24, 19),
        Region {
            x0: 5,
            y0: 0,
            x1: 5,
            y1: 9,
        },
    ] {
        assert!(matches!(
            Film::new(23, 19, wrong, ALL),
            Err(Error::Usage(_))
        ));
    }
}
