//! Every BSDF against the textbook in double precision, and its sampler against its density.

#[path = "../common/mod.rs"]
mod common;
mod principled;
mod specular;

use common::*;
use ondine::lanes::{Rgb, Table, Vec3x8, WIDTH, f32x8, u32x8};
use ondine::material::{Bsdf, Conductor, EvalX8, Lambert, Material, Phong};
use ondine::sampling::warp;
use std::f64::consts::PI;

fn load<B: Bsdf>(material: Material) -> B {
    assert_eq!(material.kind(), B::KIND);
    B::load(&Table::new(vec![material.row()]), u32x8::ZERO)
}

fn lambert(albedo: f32) -> Lambert {
    load(Material::Lambert {
        albedo: Rgb::new(albedo, 0.5 * albedo, 0.25 * albedo),
    })
}

fn phong(diffuse: f32, specular: f32, exponent: f32) -> Phong {
    load(Material::Phong {
        diffuse: Rgb::splat(diffuse),
        specular: Rgb::splat(specular),
        exponent,
    })
}

fn conductor(roughness: f32, reflectance: f32) -> Conductor {
    load(Material::Conductor {
        roughness,
        reflectance: Rgb::splat(reflectance),
    })
}

fn mirror_of(w: V) -> V {
    [-w[0], -w[1], w[2]]
}

/// Cosines of outgoing directions, near the normal to grazing.
const COSINES: [f64; 4] = [0.999, 0.7, 0.3, 0.05];

fn lambert_oracle(albedo: f64, _wo: V, wi: V) -> (f64, f64) {
    (albedo / PI * wi[2], wi[2] / PI)
}

fn phong_oracle(diffuse: f64, specular: f64, n: f64, wo: V, wi: V) -> (f64, f64) {
    let cos_alpha = dot(wi, mirror_of(wo));
    let lobe = if cos_alpha > 0.0 {
        cos_alpha.powf(n)
    } else {
        0.0
    };
    let f = diffuse / PI + specular * (n + 2.0) / (2.0 * PI) * lobe;
    let p = specular / (diffuse + specular);
    let pdf = (1.0 - p) * wi[2] / PI + p * (n + 1.0) / (2.0 * PI) * lobe;
    (f * wi[2], pdf)
}

fn conductor_oracle(alpha: f64, reflectance: f64, wo: V, wi: V) -> (f64, f64) {
    let h = unit([wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2]]);
    let tan2 = |w: V| (w[0] * w[0] + w[1] * w[1]) / (w[2] * w[2]);
    let d = 1.0 / (PI * alpha.powi(2) * h[2].powi(4) * (1.0 + tan2(h) / alpha.powi(2)).powi(2));
    let lambda = |w: V| 0.5 * ((1.0 + alpha * alpha * tan2(w)).sqrt() - 1.0);
    let g1 = 1.0 / (1.0 + lambda(wo));
    let g2 = 1.0 / (1.0 + lambda(wo) + lambda(wi));
    let f = reflectance * d * g2 / (4.0 * wo[2] * wi[2]);
    (f * wi[2], g1 * dot(wo, h) * d / wo[2] / (4.0 * dot(wo, h)))
}

/// Random pairs above the surface, a part of them near the mirror direction of each other.
fn pairs(seed: u64, batches: usize, spread: f32, mut check: impl FnMut(Vec3x8, Vec3x8)) {
    let mut random = Random::new(seed);
    for batch in 0..batches {
        let wo = warp::uniform_hemisphere(random.pair());
        let wi = if batch % 2 == 0 {
            warp::uniform_hemisphere(random.pair())
        } else {
            let jitter = warp::uniform_sphere(random.pair()) * f32x8::splat(spread);
            let near = (Vec3x8::new(-wo.x, -wo.y, wo.z) + jitter).normalize();
            Vec3x8::new(near.x, near.y, near.z.abs())
        };
        check(wo, wi);
    }
}

fn agrees_with<B: Bsdf>(
    bsdf: B,
    seed: u64,
    spread: f32,
    [relative, absolute]: [f64; 2],
    oracle: impl Fn(V, V) -> (f64, f64),
) {
    pairs(seed, 20_000, spread, |wo, wi| {
        let EvalX8 { value, pdf } = bsdf.eval(wo, wi);
        for i in 0..WIDTH {
            let (o, w) = (lane(&wo, i), lane(&wi, i));
            let (want_value, want_pdf) = oracle(o, w);
            let what = format!("{:?} wo {o:?} wi {w:?}", B::KIND);
            assert_close(
                f64::from(value.r.to_array()[i]),
                want_value,
                relative,
                absolute,
                &what,
            );
            assert_close(
                f64::from(pdf.to_array()[i]),
                want_pdf,
                relative,
                absolute,
                &what,
            );
        }
    });
}

#[test]
fn lambert_agrees_with_its_oracle() {
    agrees_with(lambert(0.8), 30, 0.1, [1e-6, 0.0], |o, w| {
        lambert_oracle(f64::from(0.8f32), o, w)
    });
}

#[test]
fn phong_agrees_with_its_oracle() {
    for (exponent, relative) in [(0.0, 1e-5), (1.0, 1e-5), (20.0, 3e-5), (500.0, 2e-4)] {
        let (d, s) = (0.25, 0.5);
        // cos α has an absolute error, which counts where it is small and the exponent too.
        agrees_with(phong(d, s, exponent), 31, 0.05, [relative, 1e-7], |o, w| {
            phong_oracle(d.into(), s.into(), exponent.into(), o, w)
        });
    }
}

#[test]
fn conductor_agrees_with_its_oracle() {
    for (alpha, relative) in [(1.0, 1e-5), (0.5, 1e-5), (0.1, 2e-5), (0.02, 2e-4)] {
        agrees_with(conductor(alpha, 0.5), 32, alpha, [relative, 0.0], |o, w| {
            conductor_oracle(alpha.into(), 0.5, o, w)
        });
    }
}

/// χ² of the sampler, sample against eval, and the directional albedo of the weights against quadrature.
fn samples_rightly<B: Bsdf>(bsdf: B, seed: u64, cos: f64, what: &str) {
    let outgoing = at(cos, 40.0);
    let wo = splat(outgoing);
    let mut random = Random::new(seed);
    let mut lost = 0u32;
    let (p, integral) = chi_square_of_directions(
        |wi| bsdf.eval(wo, wi).pdf,
        || {
            let sample = bsdf.sample(wo, random.pair(), random.eight());
            let eval = bsdf.eval(wo, sample.wi);
            let found = sample.pdf.simd_gt(f32x8::ZERO);
            for i in 0..WIDTH {
                let [w, v, p, q] = [sample.weight.r, eval.value.r, sample.pdf, eval.pdf]
                    .map(|x| f64::from(x.to_array()[i]));
                assert_close(p, q, 1e-6, 0.0, "pdf of the sample");
                if p > 0.0 {
                    assert_close(w * p, v, 1e-5, 1e-30, "weight · pdf");
                    let d = lane(&sample.wi, i);
                    assert_close(dot(d, d), 1.0, 2e-6, 0.0, "length");
                } else {
                    lost += 1;
                    assert_eq!((w, v), (0.0, 0.0));
                }
            }
            (sample.wi, found)
        },
    );
    assert!(p > SIGNIFICANCE, "{what}, cosine {cos}: p = {p}");

    // The density integrates to the part that is not lost: a binomial, 4 standard errors.
    let rejected = f64::from(lost) / SAMPLES as f64;
    let error = 4.0 * (rejected / SAMPLES as f64).sqrt() + 2e-5;
    assert_close(
        integral,
        1.0 - rejected,
        0.0,
        error,
        &format!("{what}, cosine {cos}: ∫ pdf"),
    );

    let albedo = integrate_sphere(mirror_of(outgoing), |wi| bsdf.eval(wo, wi).value.r);
    let (mean, error) = mean(SAMPLES / WIDTH, || {
        bsdf.sample(wo, random.pair(), random.eight()).weight
    });
    assert_close(
        mean,
        albedo,
        2e-5,
        4.0 * error,
        &format!("{what}, cosine {cos}: albedo"),
    );
}

#[test]
fn lambert_samples_follow_their_pdf() {
    samples_rightly(lambert(0.8), 40, 0.3, "lambert");
}

#[test]
fn phong_samples_follow_their_pdf() {
    for (seed, exponent) in [(41, 1.0), (42, 20.0), (43, 500.0)] {
        for cos in COSINES {
            let what = format!("phong {exponent}");
            samples_rightly(phong(0.25, 0.5, exponent), seed, cos, &what);
        }
    }
    samples_rightly(phong(0.0, 0.5, 20.0), 44, 0.3, "phong without diffuse");
    samples_rightly(phong(0.5, 0.0, 20.0), 45, 0.3, "phong without specular");
}

#[test]
fn conductor_samples_follow_their_pdf() {
    for (seed, alpha) in [(46, 0.05), (47, 0.2), (48, 0.8)] {
        for cos in COSINES {
            let what = format!("conductor {alpha}");
            samples_rightly(conductor(alpha, 0.75), seed, cos, &what);
        }
    }
}

#[test]
fn black_materials_send_nothing_on() {
    let mut random = Random::new(49);
    let black = phong(0.0, 0.0, 20.0);
    for _ in 0..1000 {
        let wo = warp::uniform_hemisphere(random.pair());
        let sample = black.sample(wo, random.pair(), random.eight());
        assert_eq!(sample.weight.r.to_array(), [0.0; 8]);
        assert!(sample.pdf.is_finite().all());
    }
}

#[test]
fn smooth_conductors_and_grazing_angles_stay_finite() {
    let mut random = Random::new(50);
    for alpha in [1e-6, 1e-3, 0.01, 1.0] {
        let bsdf = conductor(alpha, 1.0);
        for cos in [1.0, 0.5, 1e-2, 1e-4, 1e-7, 1e-20, 0.0] {
            let wo = splat(at(cos, 10.0));
            for _ in 0..5000 {
                let sample = bsdf.sample(wo, random.pair(), random.eight());
                let eval = bsdf.eval(wo, sample.wi);
                let weight = sample.weight.r;
                assert!(
                    (weight.simd_ge(f32x8::ZERO) & weight.simd_le(f32x8::splat(1.00001))).all()
                );
                assert!((sample.pdf.is_finite() & sample.pdf.simd_ge(f32x8::ZERO)).all());
                assert!((eval.value.r.is_finite() & eval.value.r.simd_ge(f32x8::ZERO)).all());
                // Below 10⁻³ the half-vector of two f32 directions is what rounds.
                if alpha >= 1e-3 && cos >= 1e-2 {
                    let back = weight * sample.pdf - eval.value.r;
                    assert!(back.abs().simd_le(eval.value.r * 1e-5).all());
                }
            }
        }
    }
}

#[test]
fn smooth_conductors_lose_no_energy() {
    // Smith masking hides nothing of a smooth surface that is not seen at grazing angles.
    let mut random = Random::new(51);
    let (bsdf, wo) = (conductor(1e-3, 1.0), splat(at(0.5, 10.0)));
    let (mean, _) = mean(10_000, || {
        bsdf.sample(wo, random.pair(), random.eight()).weight
    });
    assert_close(mean, 1.0, 0.0, 1e-5, "albedo");
}

fn is_reciprocal<B: Bsdf>(bsdf: B, seed: u64, spread: f32, relative: f64) {
    pairs(seed, 100_000 / WIDTH, spread, |wo, wi| {
        let (there, back) = (bsdf.eval(wo, wi).value.r, bsdf.eval(wi, wo).value.r);
        for i in 0..WIDTH {
            let (o, w) = (lane(&wo, i), lane(&wi, i));
            let there = f64::from(there.to_array()[i]) / w[2];
            let back = f64::from(back.to_array()[i]) / o[2];
            assert_close(there, back, relative, 1e-30, &format!("{:?}", B::KIND));
        }
    });
}

#[test]
fn light_may_go_either_way() {
    is_reciprocal(lambert(0.8), 60, 0.1, 1e-6);
    for n in [1.0, 20.0, 500.0] {
        is_reciprocal(phong(0.25, 0.5, n), 61, 0.1, 2e-4);
    }
    for alpha in [0.02, 0.2, 0.8] {
        is_reciprocal(conductor(alpha, 0.75), 62, alpha, 1e-5);
    }
}

fn keeps_energy<B: Bsdf>(bsdf: B, what: &str) {
    for i in 0..20 {
        let outgoing = at((f64::from(i) * 4.7).to_radians().cos(), 70.0);
        let wo = splat(outgoing);
        let albedo = integrate_sphere(mirror_of(outgoing), |wi| bsdf.eval(wo, wi).value.r);
        assert!(
            (0.0..=1.0001).contains(&albedo),
            "{what}, angle {i}: {albedo}"
        );
    }
}

#[test]
fn white_materials_never_gain_energy() {
    keeps_energy(lambert(1.0), "lambert");
    for n in [0.0, 1.0, 10.0, 100.0, 1000.0] {
        for specular in [0.0, 0.5, 1.0] {
            keeps_energy(
                phong(1.0 - specular, specular, n),
                &format!("phong {n} {specular}"),
            );
        }
    }
    for alpha in [0.02, 0.1, 0.3, 0.6, 1.0] {
        keeps_energy(conductor(alpha, 1.0), &format!("conductor {alpha}"));
    }
}

#[test]
fn nothing_is_reflected_below_the_surface() {
    let mut random = Random::new(63);
    for _ in 0..1000 {
        let wo = warp::uniform_hemisphere(random.pair());
        let below = -warp::uniform_hemisphere(random.pair());
        for EvalX8 { value, pdf } in [
            lambert(1.0).eval(wo, below),
            phong(0.5, 0.5, 5.0).eval(wo, below),
            conductor(0.5, 1.0).eval(wo, below),
            conductor(0.5, 1.0).eval(below, wo),
        ] {
            assert!((value.r.simd_eq(f32x8::ZERO) & pdf.simd_eq(f32x8::ZERO)).all());
        }
    }
}
