//! Rendering from inside a test: a scene's text, a few settings, and statistics of the film.
#![allow(dead_code, reason = "each test file uses a part")]

use ondine::film::Film;
use ondine::render::{Control, Rendered, Settings, render};
use ondine::scene::description::{Description, SamplerKind, Strategy};
use ondine::scene::{builtin, toml};
use ondine::stats::Stats;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

pub const STRATEGIES: [Strategy; 4] = [
    Strategy::Uniform,
    Strategy::Cosine,
    Strategy::Light,
    Strategy::Mis,
];

/// A scene from its text, `version` aside.
pub fn scene(text: &str) -> Description {
    let text = format!("version = 1\n{text}");
    toml::parse(&text, "test", None).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

pub fn builtin(name: &str) -> Description {
    let found = builtin::find(name).unwrap_or_else(|| panic!("no scene {name}"));
    found.load().unwrap_or_else(|error| panic!("{error}"))
}

/// A scene's settings with independent samples: their variance is what the film says it is.
pub fn settings(description: &Description, size: (u32, u32), spp: u32) -> Settings {
    let mut settings = Settings::of(description);
    settings.set_size(size.0, size.1);
    settings.spp = spp;
    settings.sampler = SamplerKind::Pcg;
    settings.seed = 1;
    settings.threads = Some(2);
    settings
}

fn rendered(description: &Description, settings: &Settings) -> Rendered {
    let control = Control {
        stop: &AtomicBool::new(false),
        progress: &|_| {},
    };
    let rendered =
        render(description, settings, &control).unwrap_or_else(|error| panic!("{error}"));
    assert!(!rendered.interrupted);
    assert_eq!(rendered.film.rejected(), 0, "samples that are not finite");
    rendered
}

pub fn film(description: &Description, settings: &Settings) -> Film {
    Arc::into_inner(rendered(description, settings).film).expect("nobody else holds it")
}

pub fn stats(description: &Description, settings: &Settings) -> Stats {
    rendered(description, settings).stats
}

/// Mean of all pixels, and its standard error, each channel.
pub fn mean_and_error(film: &Film) -> ([f64; 3], [f64; 3]) {
    let (means, variances) = (film.means(), film.variances());
    let n = means.len() as f64;
    let sum = |values: &[[f32; 3]], c: usize| values.iter().map(|v| f64::from(v[c])).sum::<f64>();
    (
        std::array::from_fn(|c| sum(&means, c) / n),
        std::array::from_fn(|c| sum(&variances, c).sqrt() / n),
    )
}

/// Within 4 standard errors and `relative`: a mean of what does not vary at all has only rounding, below 1e-5.
#[track_caller]
pub fn assert_mean(film: &Film, want: [f64; 3], relative: f64, what: &str) {
    let (mean, error) = mean_and_error(film);
    for c in 0..3 {
        let off = (mean[c] - want[c]).abs();
        let statistics = 4.0 * error[c] + 1e-5 * want[c];
        let (got, want, error) = (mean[c], want[c], error[c]);
        assert!(
            off <= statistics && off <= relative * want,
            "{what}, channel {c}: {got} +- {error} is not {want} ({:.1} standard errors, {:.3} %)",
            off / error,
            100.0 * off / want,
        );
    }
}
