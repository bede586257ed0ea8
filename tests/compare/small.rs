//! Images made by hand.

use crate::bare;
use ondine::compare::{Image, Layer, Options, Verdict, compare};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

/// All channels alike, from a function of the pixel.
fn gray(width: usize, height: usize, mut value: impl FnMut(usize, usize) -> f32) -> Image {
    let plane: Vec<f32> = (0..width * height)
        .map(|i| value(i % width, i / width))
        .collect();
    Image {
        width,
        height,
        image: Layer {
            radiance: [0, 1, 2].map(|_| plane.clone()),
            variance: None,
        },
        ..Image::default()
    }
}

/// Near 0, of variance 1.
fn noise(seed: u64) -> impl FnMut() -> f32 {
    let mut random = Pcg32::new(seed, 1);
    move || {
        let sum: f64 = (0..12)
            .map(|_| f64::from(random.next_u32()) / 4_294_967_296.0)
            .sum();
        (sum - 6.0) as f32
    }
}

fn verdict(reference: &Image, test: &Image) -> Verdict {
    compare(reference, test, &Options::default())
        .unwrap()
        .verdict
}

#[test]
fn images_without_noise_are_equal_or_biased() {
    for (width, height) in [(1, 1), (7, 3), (64, 64), (300, 5)] {
        let black = gray(width, height, |_, _| 0.0);
        let one = gray(width, height, |_, _| 1.0);
        assert_eq!(verdict(&black, &black), Verdict::BitEqual);
        assert_eq!(verdict(&one, &one), Verdict::BitEqual);
        // Below what is tolerated.
        let close = gray(width, height, |_, _| 1.0 + 1e-5);
        assert_eq!(
            verdict(&one, &close),
            Verdict::Consistent,
            "{width}x{height}"
        );
    }
    let pair = [1.0, 100.0].map(|value| gray(3, 3, |_, _| value));
    let report = compare(&pair[0], &pair[1], &Options::default()).unwrap();
    assert_eq!(report.detectable, None);
    assert!(
        report.summary.contains("too few pixels"),
        "{}",
        report.summary
    );
    let (black, one) = (gray(64, 64, |_, _| 0.0), gray(64, 64, |_, _| 1.0));
    assert_eq!(verdict(&black, &one), Verdict::Biased);
    assert_eq!(verdict(&one, &black), Verdict::Biased);
    assert_eq!(verdict(&one, &gray(64, 64, |_, _| 1.001)), Verdict::Biased);
}

#[test]
fn a_report_is_whole_json_whatever_the_images() {
    for (width, height) in [(1, 1), (2, 1), (17, 9), (65, 63)] {
        let mut random = noise(3);
        let a = gray(width, height, |_, _| 1.0 + random());
        let mut b = gray(width, height, |_, _| 1.0 + random());
        b.image.variance = Some(
            b.image
                .radiance
                .clone()
                .map(|p| p.iter().map(|x| x * x).collect()),
        );
        for (a, b) in [
            (&a, &b),
            (&b, &a),
            (&b, &bare(&b)),
            (&a, &gray(width, height, |_, _| 0.0)),
        ] {
            let report = compare(a, b, &Options::default()).unwrap();
            let json = serde_json::to_value(&report).unwrap();
            let z = &json["image"]["channels"][0]["blocks"]["worst"]["z"];
            assert!(z.is_number(), "{width}x{height}: {json:#}");
        }
    }
}

#[test]
fn windows_that_differ_are_refused() {
    let image = gray(4, 4, |_, _| 1.0);
    let mut moved = image.clone();
    moved.x0 = 1;
    for other in [
        gray(4, 5, |_, _| 1.0),
        gray(5, 4, |_, _| 1.0),
        moved,
        Image::default(),
    ] {
        let error = compare(&image, &other, &Options::default()).unwrap_err();
        assert!(error.to_string().contains("same pixels"), "{error}");
    }
    compare(&Image::default(), &Image::default(), &Options::default()).unwrap_err();
}

/// A sample is splatted into the pixels around it by many renderers: here by a tent two pixels wide.
#[test]
fn noise_that_pixels_share_is_no_bias() {
    let (mut alarms, mut correlation) = (0, 0.0);
    for seed in 0..50 {
        let [a, b] = [2 * seed, 2 * seed + 1].map(|seed| {
            let mut random = noise(seed);
            let white: Vec<f32> = (0..66 * 66).map(|_| random()).collect();
            gray(64, 64, |x, y| {
                let at = |dx: usize, dy: usize| white[(y + dy) * 66 + x + dx];
                let mut sum = 10.0;
                for (dy, wy) in [(0, 0.25), (1, 0.5), (2, 0.25)] {
                    for (dx, wx) in [(0, 0.25), (1, 0.5), (2, 0.25)] {
                        sum += wx * wy * at(dx, dy);
                    }
                }
                sum
            })
        });
        let report = compare(&a, &b, &Options::default()).unwrap();
        alarms += usize::from(report.verdict == Verdict::Biased);
        correlation += report.image.channels[0].mean.correlation / 50.0;
    }
    // Each axis: 1 / (1/16 + 1/4 + 1/16), squared.
    assert!((6.0..8.5).contains(&correlation), "{correlation}");
    assert!(alarms <= 1, "{alarms} false alarms of 50");
}

#[test]
fn a_wrong_pixel_is_found_by_its_variance() {
    let (mut first, mut second) = (noise(1), noise(2));
    let with_noise = |image: Image| Image {
        samples: Some(vec![256.0; 64 * 64]),
        image: Layer {
            variance: Some([0, 1, 2].map(|_| vec![0.01; 64 * 64])),
            ..image.image
        },
        ..image
    };
    let a = with_noise(gray(64, 64, |_, _| 5.0 + 0.1 * first()));
    let b = with_noise(gray(64, 64, |x, y| {
        5.0 + 0.1 * second() + if (x, y) == (40, 21) { 2.0 } else { 0.0 }
    }));
    let report = compare(&a, &b, &Options::default()).unwrap();
    assert_eq!(report.verdict, Verdict::Biased, "{}", report.summary);
    let worst = &report.image.channels[1].pixels.as_ref().unwrap().worst;
    assert_eq!((worst.x, worst.y), (40, 21));
    assert!(report.summary.contains("pixel 40,21"), "{}", report.summary);
}

#[test]
fn the_bits_of_a_report_do_not_depend_on_threads() {
    let (mut first, mut second) = (noise(1), noise(2));
    let a = gray(200, 150, |_, _| 5.0 + first());
    let b = gray(200, 150, |_, _| 5.0 + second());
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| compare(&a, &b, &Options::default()).unwrap())
    };
    let (one, many) = (with(1), with(5));
    assert_eq!(one, many);
    assert_eq!(
        serde_json::to_string(&one).unwrap(),
        serde_json::to_string(&many).unwrap()
    );
}
