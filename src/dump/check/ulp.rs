//! How far apart two records of an array are.

use super::super::budget::Measure;
use crate::npy::{Array, Numbers};

/// How far apart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Apart {
    /// No bit differs.
    pub same_bits: bool,
    /// The greatest difference of a component, in units in the last place (of single precision) of our greatest.
    /// Of whole numbers, and where a number is not finite: 0 or +∞.
    pub ulp: f64,
}

/// Words of an exact sum, and of three.
const WORDS: usize = 4;
const EXACT: usize = 3 * WORDS;

/// A row of ours and one of theirs, of arrays of the same dtype and width.
pub(super) fn apart(
    (ours, row): (&Array, usize),
    (theirs, other): (&Array, usize),
    measure: Measure,
) -> Apart {
    let (a, b) = (values(ours, row), values(theirs, other));
    let same_bits = match (&ours.numbers, &theirs.numbers) {
        (Numbers::F32(x), Numbers::F32(y)) => {
            let bits = |all: &[f32]| all.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            bits(of_row(ours, x, row)) == bits(of_row(theirs, y, other))
        }
        (Numbers::F64(x), Numbers::F64(y)) => {
            let bits = |all: &[f64]| all.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            bits(of_row(ours, x, row)) == bits(of_row(theirs, y, other))
        }
        (Numbers::U32(x), Numbers::U32(y)) => of_row(ours, x, row) == of_row(theirs, y, other),
        _ => false,
    };
    let whole = matches!(measure, Measure::Same | Measure::Choice);
    let least = if measure == Measure::Fraction {
        1.0
    } else {
        0.0
    };
    Apart {
        same_bits,
        ulp: match (same_bits, whole) {
            (true, _) => 0.0,
            (false, true) => f64::INFINITY,
            (false, false) => distance(&a, &b, least),
        },
    }
}

/// For people.
pub(super) fn shown(array: &Array, row: usize) -> String {
    let all: Vec<String> = match &array.numbers {
        Numbers::F32(all) => of_row(array, all, row)
            .iter()
            .map(|x| format!("{x:?}"))
            .collect(),
        Numbers::F64(all) => of_row(array, all, row)
            .iter()
            .map(|x| format!("{x:?}"))
            .collect(),
        Numbers::U32(all) => match of_row(array, all, row) {
            words if words.len() == EXACT => exact(words).map(|sum| sum.to_string()).collect(),
            all => all.iter().map(u32::to_string).collect(),
        },
    };
    match &all[..] {
        [one] => one.clone(),
        all => format!("({})", all.join(", ")),
    }
}

fn of_row<'a, T>(array: &Array, all: &'a [T], row: usize) -> &'a [T] {
    let width: usize = array.shape.iter().skip(1).product();
    all.get(row * width..(row + 1) * width).unwrap_or_default()
}

fn values(array: &Array, row: usize) -> Vec<f64> {
    match &array.numbers {
        Numbers::F32(all) => of_row(array, all, row).iter().map(|&x| x.into()).collect(),
        Numbers::F64(all) => of_row(array, all, row).to_vec(),
        Numbers::U32(all) => match of_row(array, all, row) {
            words if words.len() == EXACT => exact(words).map(|sum| sum as f64).collect(),
            all => all.iter().map(|&x| x.into()).collect(),
        },
    }
}

/// The integers of 128 bits, the least word first.
fn exact(words: &[u32]) -> impl Iterator<Item = i128> {
    words.chunks_exact(WORDS).map(|words| {
        let bits = words
            .iter()
            .rev()
            .fold(0, |bits: u128, &word| bits << 32 | u128::from(word));
        bits.cast_signed()
    })
}

/// In units of the greatest of ours, or of `least` if that is more.
fn distance(ours: &[f64], theirs: &[f64], least: f64) -> f64 {
    let greatest = ours.iter().fold(least, |greatest, x| greatest.max(x.abs()));
    let apart = ours
        .iter()
        .zip(theirs)
        .map(|(a, b)| match a == b || (a.is_nan() && b.is_nan()) {
            true => 0.0,
            false => (a - b).abs(),
        });
    // `max` would pass over NaN.
    let apart = apart.fold(
        0.0_f64,
        |worst, x| if x > worst || x.is_nan() { x } else { worst },
    );
    match apart == 0.0 {
        true => 0.0,
        false if apart.is_nan() || !greatest.is_finite() => f64::INFINITY,
        false => apart / unit(greatest),
    }
}

/// The last place of a number in single precision.
fn unit(x: f64) -> f64 {
    let exponent = libm::frexp(x).1 - 1;
    libm::ldexp(1.0, exponent.max(-126) - 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(numbers: Numbers, shape: &[usize]) -> Array {
        Array {
            shape: shape.to_vec(),
            numbers,
        }
    }

    #[test]
    fn neighbours_are_one_unit_apart_and_a_vector_counts_in_its_greatest() {
        for x in [1.0_f32, 1.5, 3.0e-41, 7.0e30, -2.5] {
            let next = f32::from_bits(x.to_bits() + 1);
            let [a, b] = [x, next].map(|x| array(Numbers::F32(vec![x]), &[1]));
            assert_eq!(apart((&a, 0), (&b, 0), Measure::Value).ulp, 1.0, "{x}");
        }
        let a = array(Numbers::F32(vec![0.0, 1.0, 1e-9]), &[1, 3]);
        let b = array(Numbers::F32(vec![f32::EPSILON, 1.0, 0.0]), &[1, 3]);
        let found = apart((&a, 0), (&b, 0), Measure::Value);
        assert!(!found.same_bits && found.ulp == 1.0, "{found:?}");
    }

    #[test]
    fn what_is_not_finite_is_infinitely_far_from_what_is() {
        let found = |a: f32, b: f32| {
            let [a, b] = [a, b].map(|x| array(Numbers::F32(vec![x]), &[1]));
            apart((&a, 0), (&b, 0), Measure::Value)
        };
        assert_eq!(found(f32::INFINITY, f32::INFINITY).ulp, 0.0);
        assert_eq!(found(1.0, f32::NAN).ulp, f64::INFINITY);
        assert_eq!(found(f32::INFINITY, 1.0).ulp, f64::INFINITY);
        assert_eq!(found(1.0, f32::INFINITY).ulp, f64::INFINITY);
        let zeros = found(0.0, -0.0);
        assert!(!zeros.same_bits && zeros.ulp == 0.0);
    }

    #[test]
    fn exact_words_are_one_number() {
        let words = |low: u32| {
            let sum = [low, 0, 5, 0];
            array(Numbers::U32([sum; 3].concat()), &[1, 3, 4])
        };
        assert!(apart((&words(1), 0), (&words(2), 0), Measure::Value).ulp < 1e-10);
        assert_eq!(
            shown(&words(0), 0).matches("92233720368547758080").count(),
            3
        );
    }
}
