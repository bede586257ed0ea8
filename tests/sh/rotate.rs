//! Rotation of coefficients.

use crate::common::Random;
use crate::draws::{difference, direction, random_coefficients};
use crate::oracle::sum;
use glam::{DMat3, DVec3};
use ondine::sh::{Probe, rotated};

fn rotation(random: &mut Random) -> DMat3 {
    let axis = DVec3::from_array(direction(random));
    DMat3::from_axis_angle(axis, 6.0 * f64::from(random.one()) - 3.0)
}

#[test]
fn a_turned_function_has_at_the_turned_direction_what_it_had() {
    let mut random = Random::new(1);
    for degree in [0, 1, 2, 3, 8, 64] {
        let before = random_coefficients(&mut random, degree);
        for _ in 0..4 {
            let rotation = rotation(&mut random);
            let after = rotated(&before, &rotation);
            for _ in 0..32 {
                let d = direction(&mut random);
                let turned = (rotation * DVec3::from_array(d)).to_array();
                let error = difference(&[sum(&before, d)], &[sum(&after, turned)]);
                // Of a sum of (degree + 1)² terms up to 1.
                let scale = (degree + 1).pow(2) as f64;
                assert!(error < 2e-14 * scale, "degree {degree}: {error:e}");
            }
        }
    }
}

#[test]
fn two_rotations_are_their_product_and_keep_the_energy_of_each_band() {
    let mut random = Random::new(2);
    let before = random_coefficients(&mut random, 128);
    let (first, second) = (rotation(&mut random), rotation(&mut random));
    let one_by_one = rotated(&rotated(&before, &first), &second);
    let at_once = rotated(&before, &(second * first));
    let error = difference(&one_by_one, &at_once);
    assert!(error < 1e-12, "{error:e}");
    let back = rotated(&rotated(&before, &first), &first.transpose());
    let error = difference(&before, &back);
    assert!(error < 1e-12, "{error:e}");
    let energy = |values: &[[f64; 3]], l: usize| {
        let band = values[l * l..(l + 1) * (l + 1)].iter().flatten();
        band.map(|value| value * value).sum::<f64>()
    };
    for l in 0..=128 {
        let (was, is) = (energy(&before, l), energy(&at_once, l));
        assert!((is / was - 1.0).abs() < 1e-12, "band {l}: {was} {is}");
    }
}

#[test]
fn no_rotation_changes_no_bit_and_a_quarter_turn_moves_coefficients() {
    let mut random = Random::new(3);
    let before = random_coefficients(&mut random, 20);
    assert_eq!(rotated(&before, &DMat3::IDENTITY), before);
    // x to y, y to −x: Y11 becomes Y1-1, which becomes −Y11.
    let turn = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
    let after = rotated(&before, &turn);
    let wanted = [before[3], before[2], before[1].map(|value| -value)];
    assert!(difference(&after[1..4], &wanted) < 1e-15);
}

#[test]
fn turned_light_has_no_standard_errors() {
    let mut random = Random::new(4);
    let mut probe = Probe::radiance(random_coefficients(&mut random, 6)).unwrap();
    probe.standard_errors = Some(probe.coefficients.clone());
    let turned = probe.rotated(&rotation(&mut random));
    assert_eq!(turned.standard_errors, None);
}
