//! Noise is told from bias: no false alarms, no fault that goes unseen, no file that stops the program.

mod common;
#[path = "common/render.rs"]
mod render;

mod compare {
    mod faults;
    mod files;
    mod noise;
    pub mod port;
    mod small;
}

use ondine::compare::{Image, Layer};
use ondine::film::Film;
use std::path::PathBuf;

/// A film as it is read from its file.
fn image(film: &Film) -> Image {
    let of_length = |length: u32| {
        let pixels = || film.region().coordinates();
        let sums = || pixels().map(|(x, y)| (film.sums_of_length(length, x, y), film.count(x, y)));
        let means: Vec<_> = sums().map(|(sums, count)| sums.mean(count)).collect();
        let variances: Vec<_> = sums().map(|(sums, count)| sums.variance(count)).collect();
        (means, variances)
    };
    let planes = |pixels: &[[f32; 3]]| [0, 1, 2].map(|c| pixels.iter().map(|p| p[c]).collect());
    let region = film.region();
    Image {
        path: PathBuf::from("film"),
        width: region.width() as usize,
        height: region.height() as usize,
        image: Layer {
            radiance: planes(&film.means()),
            variance: Some(planes(&film.variances())),
        },
        samples: Some(
            region
                .coordinates()
                .map(|(x, y)| film.count(x, y) as f32)
                .collect(),
        ),
        lengths: (1..=film.aovs().lengths)
            .map(|length| {
                let (means, variances) = of_length(length);
                let layer = Layer {
                    radiance: planes(&means),
                    variance: Some(planes(&variances)),
                };
                (length, layer)
            })
            .collect(),
        ..Image::default()
    }
}

/// The same image of a program that writes neither variances nor counts.
fn bare(image: &Image) -> Image {
    let mut bare = image.clone();
    bare.image.variance = None;
    bare.samples = None;
    bare.lengths.clear();
    bare
}
