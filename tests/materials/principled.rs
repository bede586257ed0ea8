//! The metallic-roughness model, and textures on all materials.

use crate::common::*;
use crate::{
    COSINES, agrees_with, conductor_oracle, is_reciprocal, keeps_energy, lambert_oracle, load,
    mirror_of, pairs, samples_rightly,
};
use ondine::lanes::{Rgb, Rgbx8, Table, Vec3x8, WIDTH, f32x8, u32x8};
use ondine::material::{
    Bsdf, Conductor, EvalX8, Glass, Lambert, Material, Mirror, ModulationX8, Phong, Principled,
};
use ondine::sampling::warp;
use std::f64::consts::PI;

const IOR: f32 = 1.5;

fn material(base_color: Rgb, metallic: f32, roughness: f32, ior: f32) -> Material {
    Material::Principled {
        base_color,
        metallic,
        roughness,
        ior,
    }
}

fn principled(base: f32, metallic: f32, roughness: f32) -> Principled {
    load(material(Rgb::splat(base), metallic, roughness, IOR))
}

/// GGX × cos θi of a surface that reflects everything, its density, and the cosine to the half-vector.
fn ggx_oracle(alpha: f64, wo: V, wi: V) -> (f64, f64, f64) {
    let (value, pdf) = conductor_oracle(alpha, 1.0, wo, wi);
    // Half of |wo + wi|, which both directions share: near grazing, wo · h depends on which of them f32 made longer.
    let h = [wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2]];
    (value, pdf, 0.5 * dot(h, h).sqrt())
}

struct Oracle {
    base: f64,
    metallic: f64,
    alpha: f64,
    /// Reflectance of the coat along its normal and at grazing angles.
    coat: [f64; 2],
    mean_through: f64,
}

impl Oracle {
    fn new([base, metallic, roughness, ior]: [f64; 4]) -> Self {
        let normal = ((ior - 1.0) / (ior + 1.0)).powi(2);
        let mut oracle = Self {
            base,
            metallic,
            alpha: roughness * roughness,
            coat: [normal, (50.0 * normal).min(1.0)],
            mean_through: 0.0,
        };
        const STEPS: i32 = 10_000;
        for i in 0..STEPS {
            let cos = (f64::from(i) + 0.5) / f64::from(STEPS);
            oracle.mean_through += 2.0 * cos * oracle.through(cos) / f64::from(STEPS);
        }
        oracle
    }

    /// The bound of what a surface of reflectance (1 − cos)⁵ reflects.
    fn bound(&self, cos: f64) -> f64 {
        let (x, alpha) = (1.0 - cos, self.alpha);
        let polynomial =
            0.01 * alpha + (0.23 + 1.2 * alpha) * x.powi(3) + (0.77 - 0.92 * alpha) * x.powi(5);
        polynomial / (1.0 + 6.0 * alpha + 20.0 * alpha * alpha)
    }

    fn through(&self, cos: f64) -> f64 {
        let [normal, grazing] = self.coat;
        1.0 - normal - (grazing - normal) * self.bound(cos)
    }

    fn eval(&self, wo: V, wi: V) -> (f64, f64) {
        let (metallic, dielectric) = (self.metallic, 1.0 - self.metallic);
        let [normal, grazing] = self.coat;
        let (specular, density, cos_h) = ggx_oracle(self.alpha, wo, wi);
        let schlick = |f0: f64, f90: f64| f0 + (f90 - f0) * (1.0 - cos_h).powi(5);
        let fresnel = dielectric * schlick(normal, grazing) + metallic * schlick(self.base, 1.0);

        let (out, into) = (self.through(wo[2]), self.through(wi[2]));
        let diffuse = dielectric * self.base / PI * out * into / self.mean_through;

        let along = dielectric * normal + metallic * self.base;
        let grazing = dielectric * grazing + metallic;
        let reflected = along + (grazing - along) * self.bound(wo[2]);
        let p = reflected / (reflected + dielectric * self.base * out);
        (
            fresnel * specular + diffuse * wi[2],
            p * density + (1.0 - p) * wi[2] / PI,
        )
    }
}

#[test]
fn principled_agrees_with_its_oracle() {
    for (roughness, relative) in [(1.0f32, 1e-5), (0.5, 1e-5), (0.3, 3e-5), (0.15, 2e-4)] {
        for metallic in [0.0, 0.25, 1.0] {
            for ior in [1.0, 1.1, 1.5, 2.4] {
                let bsdf: Principled = load(material(Rgb::splat(0.6), metallic, roughness, ior));
                let oracle = Oracle::new([0.6f32, metallic, roughness, ior].map(f64::from));
                let spread = roughness * roughness;
                agrees_with(bsdf, 80, spread, [relative, 1e-9], |o, w| oracle.eval(o, w));
            }
        }
    }
}

#[test]
fn principled_samples_follow_their_pdf() {
    for (seed, base, metallic, roughness) in [
        (81, 0.5, 0.0, 0.25),
        (82, 0.8, 0.5, 0.5),
        (83, 0.7, 1.0, 0.4),
        (84, 0.0, 0.0, 0.9),
    ] {
        for cos in COSINES {
            let what = format!("principled {base} {metallic} {roughness}");
            samples_rightly(principled(base, metallic, roughness), seed, cos, &what);
        }
    }
}

#[test]
fn principled_light_may_go_either_way() {
    for roughness in [0.2, 0.5, 1.0] {
        for metallic in [0.0, 0.5, 1.0] {
            is_reciprocal(principled(0.7, metallic, roughness), 85, 0.2, 2e-5);
        }
    }
}

#[test]
fn white_principled_materials_never_gain_energy() {
    for roughness in [0.15, 0.2, 0.3, 0.4, 0.55, 0.7, 0.85, 1.0] {
        for (metallic, ior) in [(0.0, 1.2), (0.0, 1.5), (0.0, 2.4), (0.5, 1.5), (1.0, 1.5)] {
            let bsdf: Principled = load(material(Rgb::WHITE, metallic, roughness, ior));
            let what = format!("metallic {metallic}, roughness {roughness}, ior {ior}");
            keeps_energy(bsdf, &what);
        }
    }
}

#[test]
fn white_dielectrics_keep_nearly_all_light() {
    for roughness in [0.15, 0.3, 0.5, 0.75, 1.0] {
        for cos in [1.0, 0.8, 0.6, 0.4, 0.2] {
            let wo = at(cos, 70.0);
            let bsdf = principled(1.0, 0.0, roughness);
            let albedo = integrate_sphere(mirror_of(wo), |wi| bsdf.eval(splat(wo), wi).value.r);
            let what = format!("roughness {roughness}, cosine {cos}");
            assert!(albedo > 0.93, "{what}: {albedo}");
        }
    }
}

#[test]
fn a_principled_metal_is_a_conductor_by_schlick() {
    let (base, roughness) = (0.6f32, 0.5);
    let metal = principled(base, 1.0, roughness);
    let conductor: Conductor = load(Material::Conductor {
        roughness: roughness * roughness,
        reflectance: Rgb::WHITE,
    });
    pairs(86, 20_000, 0.2, |wo, wi| {
        let (metal, conductor) = (metal.eval(wo, wi), conductor.eval(wo, wi));
        for i in 0..WIDTH {
            let (o, w) = (lane(&wo, i), lane(&wi, i));
            let (_, _, cos_h) = ggx_oracle(0.25, o, w);
            let base = f64::from(base);
            let fresnel = base + (1.0 - base) * (1.0 - cos_h).powi(5);
            let [got, white] = [metal, conductor].map(|e| f64::from(e.value.r.to_array()[i]));
            assert_close(got, white * fresnel, 5e-6, 0.0, "value");
            let [got, want] = [metal, conductor].map(|e| f64::from(e.pdf.to_array()[i]));
            assert_close(got, want, 1e-6, 0.0, "density");
        }
    });
}

#[test]
fn a_principled_dielectric_of_index_one_is_lambert() {
    let bsdf: Principled = load(material(Rgb::splat(0.8), 0.0, 0.4, 1.0));
    agrees_with(bsdf, 87, 0.1, [1e-6, 0.0], |o, w| {
        lambert_oracle(f64::from(0.8f32), o, w)
    });
}

#[test]
fn smooth_principled_materials_and_grazing_angles_stay_finite() {
    let mut random = Random::new(88);
    for (metallic, roughness, ior) in [
        (0.0, 0.0, 1.5),
        (1.0, 0.0, 1.5),
        (0.5, 0.02, 1e6),
        (0.0, 1.0, 1.0),
    ] {
        for base in [Rgb::BLACK, Rgb::WHITE] {
            let bsdf: Principled = load(material(base, metallic, roughness, ior));
            for cos in [1.0, 0.5, 1e-2, 1e-4, 1e-7, 1e-20, 0.0] {
                let wo = splat(at(cos, 10.0));
                for _ in 0..2000 {
                    let sample = bsdf.sample(wo, random.pair(), random.eight());
                    let eval = bsdf.eval(wo, sample.wi);
                    for value in [sample.weight.r, sample.pdf, eval.value.r, eval.pdf] {
                        assert!((value.is_finite() & value.simd_ge(f32x8::ZERO)).all());
                    }
                }
            }
        }
    }
}

#[test]
fn principled_materials_reflect_nothing_below_the_surface() {
    let mut random = Random::new(89);
    let bsdf = principled(1.0, 0.5, 0.5);
    for _ in 0..1000 {
        let above = warp::uniform_hemisphere(random.pair());
        let below = -warp::uniform_hemisphere(random.pair());
        for (wo, wi) in [(above, below), (below, above), (below, below)] {
            let EvalX8 { value, pdf } = bsdf.eval(wo, wi);
            assert!((value.r.simd_eq(f32x8::ZERO) & pdf.simd_eq(f32x8::ZERO)).all());
        }
    }
}

/// A material under a texture is the material of the products.
fn is_modulated<B: Bsdf>(plain: Material, [color, metallic, roughness]: [f32; 3], want: Material) {
    let by = ModulationX8::new(
        Rgbx8::splat(Rgb::new(color, 1.0, 0.5 * color)),
        f32x8::splat(metallic),
        f32x8::splat(roughness),
    );
    let got = load::<B>(plain).modulate(&by);
    let want = load::<B>(want);
    let mut random = Random::new(90);
    for _ in 0..1000 {
        let wo = warp::uniform_hemisphere(random.pair());
        let (direction, lobe) = (random.pair(), random.eight());
        let [got, want] = [got, want].map(|bsdf| {
            let sample = bsdf.sample(wo, direction, lobe);
            let eval = bsdf.eval(wo, warp::uniform_hemisphere(direction));
            [
                sample.wi.x,
                sample.weight.r,
                sample.weight.g,
                sample.weight.b,
                eval.value.r,
                eval.value.b,
                eval.pdf,
            ]
            .map(|numbers| numbers.to_array())
        });
        for (got, want) in got.as_flattened().iter().zip(want.as_flattened()) {
            assert_close(
                f64::from(*got),
                f64::from(*want),
                1e-6,
                1e-12,
                &format!("{:?}", B::KIND),
            );
        }
    }
}

#[test]
fn textures_multiply_what_a_material_says() {
    let half = Rgb::new(0.5, 0.8, 0.25);
    let (white, gray) = (Rgb::splat(0.5), Rgb::new(0.25, 0.5, 0.125));
    let by = [0.5, 0.25, 0.75];
    is_modulated::<Lambert>(
        Material::Lambert { albedo: white },
        by,
        Material::Lambert { albedo: gray },
    );
    is_modulated::<Mirror>(
        Material::Mirror { reflectance: white },
        by,
        Material::Mirror { reflectance: gray },
    );
    is_modulated::<Glass>(
        Material::Glass { ior: 1.5 },
        by,
        Material::Glass { ior: 1.5 },
    );
    let phong = |diffuse| Material::Phong {
        diffuse,
        specular: half,
        exponent: 20.0,
    };
    is_modulated::<Phong>(phong(white), by, phong(gray));
    let conductor = |reflectance| Material::Conductor {
        roughness: 0.3,
        reflectance,
    };
    is_modulated::<Conductor>(conductor(white), by, conductor(gray));
    is_modulated::<Principled>(
        material(white, 0.5, 0.8, 1.5),
        by,
        material(gray, 0.125, 0.8 * 0.75, 1.5),
    );
}

#[test]
fn textures_above_one_are_cut_off() {
    let plain = Material::Lambert {
        albedo: Rgb::new(0.5, 0.5, 0.5),
    };
    let by = ModulationX8::new(Rgbx8::gray(f32x8::splat(3.0)), f32x8::ONE, f32x8::ONE);
    let bsdf = load::<Lambert>(plain).modulate(&by);
    let sample = bsdf.sample(Vec3x8::Z, (f32x8::ZERO, f32x8::ZERO), f32x8::ZERO);
    assert_eq!(sample.weight.r.to_array(), [0.5; WIDTH]);
}

#[test]
fn lanes_of_one_batch_may_have_different_principled_materials() {
    let materials: Vec<Material> = (0..20)
        .map(|i| {
            let part = i as f32 / 20.0;
            material(Rgb::splat(part), 1.0 - part, 0.2 + 0.5 * part, 1.0 + part)
        })
        .collect();
    let table = Table::new(materials.iter().map(Material::row).collect());
    let ids = u32x8::new([0, 19, 3, 7, 11, 2, 16, 5]);
    let mixed = Principled::load(&table, ids);
    pairs(91, 100, 0.1, |wo, wi| {
        let together = mixed.eval(wo, wi);
        for (i, id) in ids.to_array().into_iter().enumerate() {
            let alone: Principled = load(materials[id as usize]);
            let alone = alone.eval(wo, wi);
            let bits = |e: EvalX8| [e.value.r, e.pdf].map(|x| x.to_array()[i].to_bits());
            assert_eq!(bits(together), bits(alone));
        }
    });
}
