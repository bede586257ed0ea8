//! Which light is chosen: by power, black ones never.

use crate::common::*;
use crate::{FIRST_ID, MANY, World, quad, sphere, toward};
use ondine::lanes::{Rgb, Vec3x8, WIDTH, f32x8, u32x8};
use ondine::scene::Scene;
use ondine::scene::description::{Environment, Light, Shape};
use ondine::shape::NO_PRIMITIVE;
use std::f64::consts::PI;

fn luminance(c: Rgb) -> f64 {
    0.2126 * f64::from(c.r) + 0.7152 * f64::from(c.g) + 0.0722 * f64::from(c.b)
}

/// Radiance × area × sides × π; of a sphere, of a quad.
fn power(light: &Light) -> f64 {
    let area = match light.shape {
        Shape::Mesh { .. } => unreachable!("no mesh here"),
        Shape::Sphere { radius, .. } => 4.0 * PI * f64::from(radius).powi(2),
        Shape::Quad { u, v, .. } => u.as_dvec3().cross(v.as_dvec3()).length(),
    };
    luminance(light.radiance) * area * PI * if light.two_sided { 2.0 } else { 1.0 }
}

/// Lights of many powers, some black, and a constant sky or none.
fn mix(count: usize, seed: u64) -> Vec<Light> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|i| {
            let center = toward(i as f64, 3.0 + f64::from(random.one()));
            let mut light = if i % 3 == 0 {
                quad(center, [0.4, 0.0, 0.1], [0.0, 0.5, 0.0], i % 2 == 0)
            } else {
                sphere(center, 0.05 + 0.2 * f64::from(random.one()), i % 2 == 0)
            };
            let strength = if i % 5 == 4 {
                0.0
            } else {
                40.0 * random.one().powi(3)
            };
            light.radiance = Rgb::new(strength, 0.5 * strength, random.one() * strength);
            light
        })
        .collect()
}

#[test]
fn lights_are_chosen_by_power_black_ones_never_and_the_pdf_counts_the_choice() {
    for (seed, count, radiance) in [
        (260, 2, None),
        (261, 9, None),
        (262, 24, Some(0.05)),
        (263, 1, Some(0.02)),
        (264, 100, Some(0.0)),
        (265, 0, Some(1.0)),
    ] {
        let lights = mix(count, seed);
        let sky = radiance.map(|r: f64| Environment::Constant(Rgb::splat(r as f32)));
        let world = World::new(&lights, sky);
        // The disk that the scene covers, as the sky sees it: the radius given to `World` is 2.
        let sky_power = 4.0 * PI * radiance.unwrap_or(0.0) * PI * 4.0;
        let mut powers: Vec<f64> = lights.iter().map(power).collect();
        powers.push(sky_power);
        let sources = count + usize::from(radiance.is_some());
        let least = 1e-3 * powers.iter().sum::<f64>() / sources as f64;
        for power in powers.iter_mut().filter(|power| **power > 0.0) {
            *power = power.max(least);
        }
        let total: f64 = powers.iter().sum();
        let mut observed = vec![0u64; count + 1];
        let mut random = Random::new(seed + 1000);
        for _ in 0..MANY / WIDTH {
            let s = world.sample(Vec3x8::ZERO, &mut random);
            for i in 0..WIDTH {
                let primitive = s.primitive.as_array()[i];
                let id = if primitive == NO_PRIMITIVE {
                    count
                } else {
                    (primitive - FIRST_ID) as usize
                };
                observed[id] += 1;
                let (eight, pdf) = if id == count {
                    world
                        .lights
                        .sky(world.sky.as_ref().expect("chosen"), s.direction)
                } else {
                    world.lights.emitted(
                        u32x8::splat(id as u32),
                        Vec3x8::ZERO,
                        s.direction,
                        s.distance,
                    )
                };
                if s.pdf().as_array()[i] > 0.0 {
                    let (got, want) = (s.pdf().as_array()[i], pdf.as_array()[i]);
                    assert_close(f64::from(got), f64::from(want), 2e-5, 0.0, "pdf");
                    assert_eq!(s.radiance.lane(i), eight.lane(i));
                }
                if id == count {
                    let want = powers[count] / total / (4.0 * PI);
                    assert_close(f64::from(s.pdf().as_array()[i]), want, 1e-5, 0.0, "sky pdf");
                    assert_eq!(s.distance.as_array()[i], f32::INFINITY);
                }
            }
        }
        for (id, power) in powers.iter().enumerate() {
            assert!(
                *power > 0.0 || observed[id] == 0,
                "black light {id} was chosen"
            );
        }
        if powers.iter().filter(|p| **p > 0.0).count() > 1 {
            let expected: Vec<f64> = powers.iter().map(|p| p / total * MANY as f64).collect();
            let p = chi_square(&observed, &expected);
            assert!(p > SIGNIFICANCE, "{count} lights: p = {p}");
        }
    }
}

#[test]
fn the_dimmest_light_is_chosen_as_often_as_its_density_says() {
    let mut lights = mix(2, 266);
    lights[0].radiance = Rgb::splat(1e9);
    lights[1].radiance = Rgb::splat(1e-9);
    let world = World::new(&lights, None);
    // Every choice that 23 bits can make.
    let (mut chosen, mut inverse_pdf) = (0, 0.0);
    for first in (0..1u32 << 23).step_by(WIDTH) {
        let u = f32x8::new(std::array::from_fn(|i| {
            (first + i as u32) as f32 / (1u32 << 23) as f32
        }));
        let half = f32x8::HALF;
        let s = world
            .lights
            .sample(None, Vec3x8::ZERO, || (u, half), (half, half));
        for i in 0..WIDTH {
            if s.primitive.as_array()[i] == FIRST_ID + 1 {
                chosen += 1;
                inverse_pdf = f64::from(s.inverse_pdf.as_array()[i]);
            }
        }
    }
    assert!(chosen > 0, "never");
    let alone = World::new(&lights[1..], None);
    let half = f32x8::HALF;
    let s = alone
        .lights
        .sample(None, Vec3x8::ZERO, || (half, half), (half, half));
    let solid_angle = f64::from(s.inverse_pdf.as_array()[0]);
    let mean = inverse_pdf * f64::from(chosen) / f64::from(1u32 << 23);
    assert_close(mean, solid_angle, 1e-3, 0.0, "share × weight");
}

#[test]
fn a_black_light_is_not_chosen_by_the_last_number_below_one_either() {
    let mut lights = mix(7, 270);
    for id in [0, 3, 6] {
        lights[id].radiance = Rgb::BLACK;
        let world = World::new(&lights, Some(Environment::Constant(Rgb::BLACK)));
        for numerator in 0..=700u32 {
            // Every edge of a column of the table, and the numbers next to it.
            let edge = numerator as f32 / 700.0;
            let u = [
                edge,
                edge.next_down(),
                edge.next_up(),
                1.0f32.next_down(),
                0.0,
                edge,
                edge,
                edge,
            ];
            let u = f32x8::new(u.map(|u| u.clamp(0.0, 1.0f32.next_down())));
            let s = world
                .lights
                .sample(world.sky.as_ref(), Vec3x8::ZERO, || (u, u), (u, u));
            for primitive in s.primitive.to_array() {
                assert!(primitive != NO_PRIMITIVE && primitive != FIRST_ID + id as u32);
            }
        }
    }
}

#[test]
fn a_scene_whose_lights_are_all_black_is_dark() {
    let mut lights = mix(6, 280);
    assert!(!World::new(&lights, None).lights.is_dark());
    lights
        .iter_mut()
        .for_each(|light| light.radiance = Rgb::BLACK);
    for sky in [None, Some(Environment::Constant(Rgb::BLACK))] {
        assert!(World::new(&lights, sky.clone()).lights.is_dark());
        assert!(World::new(&[], sky).lights.is_dark());
    }
    let bright = Environment::Constant(Rgb::WHITE);
    assert!(!World::new(&lights, Some(bright)).lights.is_dark());
    let furnace = ondine::scene::builtin::find("furnace")
        .expect("built in")
        .load()
        .expect("valid");
    assert!(!Scene::compile(&furnace).lights.is_dark());
}
