//! Mirror and glass.

use crate::common::*;
use crate::{load, mirror_of};
use ondine::lanes::{Rgb, Rgbx8, WIDTH, f32x8};
use ondine::material::{Bsdf, Glass, Material, Mirror};
use ondine::sampling::warp;

#[test]
fn mirrors_reflect() {
    let mirror: Mirror = load(Material::Mirror {
        reflectance: Rgb::new(0.9, 0.8, 0.7),
    });
    let mut random = Random::new(70);
    let wo = warp::uniform_hemisphere(random.pair());
    let sample = mirror.sample(wo, random.pair(), random.eight());
    for i in 0..WIDTH {
        assert_eq!(lane(&sample.wi, i), mirror_of(lane(&wo, i)));
        assert_eq!(sample.weight.lane(i), Rgb::new(0.9, 0.8, 0.7));
        assert_eq!(sample.pdf.to_array()[i], f32::INFINITY);
    }
    assert_eq!(mirror.eval(wo, sample.wi).value.r.to_array(), [0.0; 8]);
}

/// Fresnel's equations and Snell's law, from a medium of index 1 to one of `eta_t`; None is total reflection.
fn fresnel_oracle(eta_i: f64, eta_t: f64, cos_i: f64) -> Option<(f64, f64)> {
    let sin_t = eta_i / eta_t * (1.0 - cos_i * cos_i).max(0.0).sqrt();
    if sin_t >= 1.0 {
        return None;
    }
    let cos_t = (1.0 - sin_t * sin_t).sqrt();
    let s = (eta_i * cos_i - eta_t * cos_t) / (eta_i * cos_i + eta_t * cos_t);
    let p = (eta_t * cos_i - eta_i * cos_t) / (eta_t * cos_i + eta_i * cos_t);
    Some((0.5 * (s * s + p * p), cos_t))
}

/// The least `lobe` (a multiple of 2⁻²⁴) that refracts is the reflectance, rounded up; 1 where none does.
fn reflectance(glass: Glass, wo: V) -> f64 {
    let reflects = |step: u32| {
        let lobe = f32x8::splat(step as f32 / 16_777_216.0);
        let sample = glass.sample(splat(wo), (f32x8::ZERO, f32x8::ZERO), lobe);
        f64::from(sample.wi.z.to_array()[0]) * wo[2] >= 0.0
    };
    let (mut low, mut high) = (0, 1 << 24);
    while low < high {
        let middle = (low + high) / 2;
        if reflects(middle) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    f64::from(low) / 16_777_216.0
}

#[test]
fn glass_reflects_by_fresnel_and_refracts_by_snell() {
    for ior in [1.0001f32, 1.1, 1.5, 2.4, 0.75] {
        let glass: Glass = load(Material::Glass { ior });
        for i in 1..200 {
            for side in [1.0, -1.0] {
                // Even in angle, and some at grazing.
                let angle = f64::from(i) * 0.4522;
                let cos = f64::from(angle.to_radians().cos() as f32);
                let wo = at(cos, 25.0).map(|c| c * side);
                let ior = f64::from(ior);
                let (eta_i, eta_t) = if side > 0.0 { (1.0, ior) } else { (ior, 1.0) };
                let got = reflectance(glass, wo);
                let what = format!("ior {ior} side {side} angle {angle}");
                let Some((want, cos_t)) = fresnel_oracle(eta_i, eta_t, cos) else {
                    assert_eq!(got, 1.0, "{what}: total reflection");
                    continue;
                };
                // At the critical angle F has a vertical tangent: allow the angle its rounding.
                let slope = if cos_t < 0.05 { 1e-6 / cos_t } else { 0.0 };
                assert_close(got, want, 2e-6, 2e-7 + slope, &what);

                let beyond = f32x8::splat((got + 1e-6) as f32);
                let sample = glass.sample(splat(wo), (f32x8::ZERO, f32x8::ZERO), beyond);
                if beyond.to_array()[0] < 1.0 {
                    let wi = lane(&sample.wi, 0);
                    let ratio = eta_i / eta_t;
                    let absolute = 1e-6 + slope;
                    assert_close(wi[0], -ratio * wo[0], 1e-6, 1e-6, &what);
                    assert_close(wi[1], -ratio * wo[1], 1e-6, 1e-6, &what);
                    assert_close(wi[2], -side * cos_t, 1e-5, absolute, &what);
                    assert_close(dot(wi, wi), 1.0, 1e-5, 0.0, &what);
                    let weight = f64::from(sample.weight.r.to_array()[0]);
                    assert_close(weight, ratio * ratio, 1e-6, 0.0, &what);
                    assert_eq!(sample.pdf.to_array()[0], f32::INFINITY);
                }
                let reflected = glass.sample(splat(wo), (f32x8::ZERO, f32x8::ZERO), f32x8::ZERO);
                if got > 0.0 {
                    assert_eq!(reflected.weight.lane(0), Rgb::WHITE);
                    let want = mirror_of(lane(&splat(wo), 0));
                    assert_eq!(lane(&reflected.wi, 0), want);
                }
            }
        }
    }
}

#[test]
fn glass_keeps_energy_and_reflectances_agree_from_both_sides() {
    // What is not reflected is refracted: weights over (ηi/ηt)² average to 1, and by Stokes' relations the reflectance at
    // an angle is that at the refracted angle from the other side.
    let glass: Glass = load(Material::Glass { ior: 1.5 });
    let mut random = Random::new(71);
    for i in 0..20 {
        let cos = f64::from(i).mul_add(0.05, 0.02);
        let wo = at(cos, 25.0);
        let (want, cos_t) =
            fresnel_oracle(1.0, 1.5, cos).expect("no total reflection from outside");
        let (mean, error) = mean(10_000, || {
            let sample = glass.sample(splat(wo), random.pair(), random.eight());
            let reflected = sample.wi.z.simd_gt(f32x8::ZERO);
            let refracted = sample.weight.r * 2.25;
            let energy = reflected.select(sample.weight.r, refracted);
            assert!(
                (energy - f32x8::ONE)
                    .abs()
                    .simd_lt(f32x8::splat(1e-6))
                    .all()
            );
            Rgbx8::gray(reflected.select(f32x8::ONE, f32x8::ZERO))
        });
        assert_close(mean, want, 0.0, 4.0 * error, "part reflected");
        let inside = at(cos_t, 25.0).map(|c| -c);
        assert_close(reflectance(glass, inside), want, 1e-5, 1e-6, "from inside");
    }
}

#[test]
fn glass_of_index_one_is_not_there() {
    let glass: Glass = load(Material::Glass { ior: 1.0 });
    let mut random = Random::new(72);
    for _ in 0..10_000 {
        let wo = warp::uniform_sphere(random.pair());
        let sample = glass.sample(wo, random.pair(), f32x8::ZERO);
        for i in 0..WIDTH {
            assert_eq!(lane(&sample.wi, i), lane(&-wo, i));
            assert_eq!(sample.weight.lane(i), Rgb::WHITE);
        }
    }
}

#[test]
fn glass_stays_finite_at_extreme_angles() {
    let mut random = Random::new(73);
    let critical = (1.0 - 1.0 / 2.25f64).sqrt();
    for ior in [1.0, 1.000_001, 1.5, 4.0] {
        let glass: Glass = load(Material::Glass { ior });
        for cos in [0.0, 1e-30, 1e-10, 1e-4, 1.0, critical, critical + 1e-7] {
            for side in [1.0, -1.0] {
                let wo = splat(at(cos, 3.0).map(|c| c * side));
                for _ in 0..1000 {
                    let sample = glass.sample(wo, random.pair(), random.eight());
                    let length = sample.wi.length_squared();
                    assert!(
                        (length - f32x8::ONE)
                            .abs()
                            .simd_lt(f32x8::splat(1e-5))
                            .all()
                    );
                    assert!(sample.weight.r.is_finite().all());
                }
            }
        }
    }
}

#[test]
fn albedos_are_what_the_layer_shows() {
    let phong = Material::Phong {
        diffuse: Rgb::splat(0.25),
        specular: Rgb::splat(0.5),
        exponent: 3.0,
    };
    let conductor = Material::Conductor {
        roughness: 0.3,
        reflectance: Rgb::splat(0.5),
    };
    assert_eq!(phong.albedo(), Rgb::splat(0.75));
    assert_eq!(conductor.albedo(), Rgb::splat(0.5));
    assert_eq!(Material::Glass { ior: 1.5 }.albedo(), Rgb::WHITE);
}
