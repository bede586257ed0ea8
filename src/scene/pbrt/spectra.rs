//! Spectra to linear sRGB.
//!
//! What a light of spectrum L shows, pbrt-v4 divides by ∫ L ȳ dλ (`SpectrumToPhotometric`), so that all but `rgb` lights
//! have a luminance of 1 times their `scale`; `rgb` ones have their own value times `scale`.

use crate::lanes::Rgb;

/// A spectrum as a parameter gives it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Spectrum {
    /// The same at all wavelengths.
    Constant(f32),
    /// Linear sRGB.
    Rgb(Rgb),
    /// Of an ideal radiator at this many kelvin.
    Blackbody(f32),
    /// pbrt's name of it.
    Named(String),
    /// Rising wavelengths in nm, and values between which it is linear.
    Sampled(Vec<(f32, f32)>),
}

/// CIE standard illuminant D65, from 380 nm in steps of 20 (ISO/CIE 11664-2:2022, table B.1).
const D65: [f64; 21] = [
    49.9755, 82.7549, 93.4318, 104.865, 117.812, 115.923, 109.354, 104.790, 104.405, 100.0, 95.788,
    90.0062, 87.6987, 83.6992, 80.2146, 78.2842, 71.6091, 61.604, 75.087, 46.4182, 63.3828,
];
/// Where [`D65`] begins, nm.
const SHORTEST: f64 = 380.0;
/// Between entries of [`D65`], nm.
const STEP: f64 = 20.0;

/// Chromaticities x, y of the illuminants that pbrt-v4 names (CIE 15:2018, tables T.3 and T.6; ACES, TB-2018-001).
const ILLUMINANTS: [(&str, f64, f64); 16] = [
    ("stdillum-A", 0.44758, 0.40745),
    ("stdillum-D50", 0.34567, 0.35851),
    ("stdillum-D65", 0.31272, 0.32903),
    ("illum-acesD60", 0.32168, 0.33767),
    ("stdillum-F1", 0.3131, 0.3371),
    ("stdillum-F2", 0.3721, 0.3751),
    ("stdillum-F3", 0.4091, 0.3941),
    ("stdillum-F4", 0.4402, 0.4031),
    ("stdillum-F5", 0.3138, 0.3452),
    ("stdillum-F6", 0.3779, 0.3882),
    ("stdillum-F7", 0.3129, 0.3292),
    ("stdillum-F8", 0.3458, 0.3586),
    ("stdillum-F9", 0.3741, 0.3727),
    ("stdillum-F10", 0.3458, 0.3588),
    ("stdillum-F11", 0.3805, 0.3769),
    ("stdillum-F12", 0.4370, 0.4042),
];

/// Reflectance at normal incidence, linear sRGB, of the metals that pbrt-v4 names (Akenine-Möller et al. 2018,
/// "Real-Time Rendering", 4th ed., table 9.2).
const METALS: [(&str, [f32; 3]); 5] = [
    ("Ag", [0.972, 0.960, 0.915]),
    ("Al", [0.913, 0.922, 0.924]),
    ("Au", [1.0, 0.782, 0.344]),
    ("Cu", [0.955, 0.638, 0.538]),
    ("CuZn", [0.910, 0.778, 0.423]),
];

/// Index of refraction at 587.6 nm of the glasses that pbrt-v4 names (SCHOTT, "Optical Glass" data sheets, n_d).
const GLASSES: [(&str, f32); 7] = [
    ("glass-BK7", 1.5168),
    ("glass-BAF10", 1.67003),
    ("glass-FK51A", 1.48656),
    ("glass-LASF9", 1.85025),
    ("glass-F5", 1.6727),
    ("glass-F10", 1.72825),
    ("glass-F11", 1.78472),
];

impl Spectrum {
    /// Radiance in linear sRGB of a light of this spectrum whose scale is 1; none where its name is unknown.
    pub fn emitted(&self) -> Option<Rgb> {
        match self {
            Self::Constant(value) => Some(Rgb::splat(value.max(0.0))),
            Self::Rgb(rgb) => Some(Rgb::new(rgb.r.max(0.0), rgb.g.max(0.0), rgb.b.max(0.0))),
            Self::Blackbody(kelvin) => {
                let kelvin = f64::from(*kelvin);
                Some(at_luminance_one(weighted(|nm| planck(nm, kelvin))))
            }
            Self::Sampled(samples) => {
                Some(at_luminance_one(weighted(|nm| interpolated(samples, nm))))
            }
            Self::Named(name) => {
                let &(_, x, y) = ILLUMINANTS.iter().find(|(known, ..)| known == name)?;
                let xyz = |x: f64, y: f64| [x / y, 1.0, (1.0 - x - y) / y];
                let white = linear_srgb(xyz(0.31272, 0.32903));
                Some(at_luminance_one(divided(linear_srgb(xyz(x, y)), white)))
            }
        }
    }

    /// Reflectance in linear sRGB, at least 0; none where its name is unknown.
    pub fn reflectance(&self) -> Option<Rgb> {
        let [r, g, b] = match self {
            Self::Constant(value) => [*value; 3],
            Self::Rgb(rgb) => rgb.to_array(),
            Self::Sampled(samples) => {
                weighted(|nm| d65(nm) * interpolated(samples, nm)).map(|c| c as f32)
            }
            Self::Blackbody(_) | Self::Named(_) => return None,
        }
        .map(|channel| channel.max(0.0));
        Some(Rgb::new(r, g, b))
    }

    /// Index of refraction, at the sodium line; none where its name is unknown.
    pub fn ior(&self) -> Option<f32> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Rgb(rgb) => Some(rgb.g),
            Self::Sampled(samples) => Some(interpolated(samples, 587.6) as f32),
            Self::Named(name) => {
                let (_, ior) = GLASSES.iter().find(|(known, _)| known == name)?;
                Some(*ior)
            }
            Self::Blackbody(_) => None,
        }
    }

    /// Red, green and blue of η or k: spectra at the dominant wavelengths of the sRGB primaries.
    fn channels(&self) -> Option<[f32; 3]> {
        match self {
            Self::Constant(value) => Some([*value; 3]),
            Self::Rgb(rgb) => Some(rgb.to_array()),
            Self::Sampled(samples) => {
                Some([611.4, 549.1, 464.2].map(|nm| interpolated(samples, nm) as f32))
            }
            Self::Blackbody(_) | Self::Named(_) => None,
        }
    }
}

/// What a conductor of η and k reflects at normal incidence, `((η − 1)² + k²) / ((η + 1)² + k²)` (Pharr, Jakob &
/// Humphreys, PBR 4th ed., sec. 9.3.6), or a named metal; none where the names are unknown.
pub(super) fn conductor_reflectance(eta: &Spectrum, k: &Spectrum) -> Option<Rgb> {
    if let Spectrum::Named(name) = eta {
        let metal = name.strip_prefix("metal-")?.strip_suffix("-eta")?;
        let &(_, [r, g, b]) = METALS.iter().find(|(known, _)| *known == metal)?;
        return Some(Rgb::new(r, g, b));
    }
    let (eta, k) = (eta.channels()?, k.channels()?);
    let [r, g, b] = std::array::from_fn(|channel| {
        let (eta, k) = (f64::from(eta[channel]), f64::from(k[channel]));
        let part = ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k);
        if part.is_finite() {
            part.clamp(0.0, 1.0) as f32
        } else {
            1.0
        }
    });
    Some(Rgb::new(r, g, b))
}

/// Linear sRGB of a spectrum, in units of that of D65.
fn weighted(spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
    divided(linear_srgb(xyz(spectrum)), linear_srgb(xyz(d65)))
}

fn divided(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|channel| a[channel] / b[channel])
}

/// ∫ spectrum · (x̄, ȳ, z̄) dλ over 380 to 780 nm, in steps of 2.
fn xyz(spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for step in 0..=200 {
        let nm = SHORTEST + 2.0 * f64::from(step);
        let value = spectrum(nm);
        for (sum, matching) in sum.iter_mut().zip(color_matching(nm)) {
            *sum += value * matching;
        }
    }
    sum
}

/// The CIE 1931 colour-matching functions (Wyman, Sloan & Shirley 2013, "Simple Analytic Approximations to the CIE XYZ
/// Color Matching Functions", JCGT 2(2), sec. 2.2, the multi-lobe fit).
fn color_matching(nm: f64) -> [f64; 3] {
    let lobe = |height: f64, center: f64, below: f64, above: f64| {
        let width = if nm < center { below } else { above };
        height * libm::exp(-0.5 * ((nm - center) / width).powi(2))
    };
    [
        lobe(1.056, 599.8, 37.9, 31.0)
            + lobe(0.362, 442.0, 16.0, 26.7)
            + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    ]
}

fn d65(nm: f64) -> f64 {
    let at = ((nm - SHORTEST) / STEP).max(0.0);
    let index = (at as usize).min(D65.len() - 2);
    let part = at - index as f64;
    D65[index] + (D65[index + 1] - D65[index]) * part
}

/// Planck's law, up to a factor.
fn planck(nm: f64, kelvin: f64) -> f64 {
    // hc / k in nm·K.
    const SECOND_RADIATION: f64 = 1.438_777e7;
    let microns = nm * 1e-3;
    microns.powi(-5) / libm::expm1(SECOND_RADIATION / (nm * kelvin))
}

/// Linear between samples, 0 outside them.
fn interpolated(samples: &[(f32, f32)], nm: f64) -> f64 {
    let above = samples.partition_point(|&(at, _)| f64::from(at) <= nm);
    let at = |index: usize| {
        samples
            .get(index)
            .map(|&(nm, value)| (f64::from(nm), f64::from(value)))
    };
    match (above.checked_sub(1).and_then(at), at(above)) {
        (Some((low, a)), Some((high, b))) => a + (b - a) * (nm - low) / (high - low),
        (Some((last, value)), None) if last == nm => value,
        _ => 0.0,
    }
}

/// CIE XYZ to linear sRGB (IEC 61966-2-1).
fn linear_srgb([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.240_625_5 * x - 1.537_208_0 * y - 0.498_628_6 * z,
        -0.968_930_7 * x + 1.875_756_1 * y + 0.041_517_5 * z,
        0.055_710_1 * x - 0.204_021_1 * y + 1.056_995_9 * z,
    ]
}

/// The colour, with what sRGB cannot show cut off, at a luminance of 1; black stays black.
fn at_luminance_one(rgb: [f64; 3]) -> Rgb {
    let [r, g, b] = rgb.map(|channel| channel.max(0.0));
    let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let scaled = |channel: f64| {
        if luminance > 0.0 && luminance.is_finite() {
            (channel / luminance) as f32
        } else {
            0.0
        }
    };
    Rgb::new(scaled(r), scaled(g), scaled(b))
}
