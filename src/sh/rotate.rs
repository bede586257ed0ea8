//! Exact rotation of coefficients.
//!
//! About z, then y, then z: about z, cos mφ and sin mφ of an order turn into each other, and about y, Wigner's d-functions give
//! the matrix of each band. They come from a recursion over degrees, as Legendre functions do, which keeps its digits; the
//! recursions from one band's matrix to the next (Ivanic & Ruedenberg 1996) lose a digit every eight degrees or so.

use super::{Probe, index};
use glam::DMat3;

/// The coefficients of a function turned with `rotation`: what was seen in direction `d` is seen in `rotation · d`.
///
/// `values` are those of whole bands, in the order of [`index`]. To degree 128 the error is below 10⁻¹² of the greatest.
#[must_use]
pub fn rotated(values: &[[f64; 3]], rotation: &DMat3) -> Vec<[f64; 3]> {
    let Some(degree) = values.len().isqrt().checked_sub(1) else {
        return Vec::new();
    };
    // rotation = Z(first) Y(angle) Z(last), active and counter-clockwise about each axis.
    let tip = rotation.z_axis;
    let first = libm::atan2(tip.y, tip.x);
    let angle = libm::atan2(libm::hypot(tip.x, tip.y), tip.z);
    let (sin, cos) = libm::sincos(first);
    // What the first turn's new y axis, which the second leaves alone, is made from.
    let y = glam::DVec3::new(-sin, cos, 0.0);
    let last = libm::atan2(rotation.x_axis.dot(y), rotation.y_axis.dot(y));
    let turned = about_z(values, degree, last);
    // Upright, it is a turn about z alone, and the other two leave every bit.
    let turned = match angle == 0.0 {
        true => turned,
        false => about_y(&turned, degree, angle),
    };
    about_z(&turned, degree, first)
}

impl Probe {
    /// The light turned with `rotation`: what came from direction `d` comes from `rotation · d`. It has no standard errors, for
    /// turned coefficients are correlated.
    #[must_use]
    pub fn rotated(&self, rotation: &DMat3) -> Self {
        Self {
            coefficients: rotated(&self.coefficients, rotation),
            standard_errors: None,
            ..self.clone()
        }
    }
}

/// Where orders m and −m of a degree stand.
fn pair(l: usize, m: usize) -> [usize; 2] {
    let order = m.cast_signed();
    [index(l, order), index(l, -order)]
}

fn about_z(values: &[[f64; 3]], degree: usize, angle: f64) -> Vec<[f64; 3]> {
    let mut turned = values.to_vec();
    for m in 1..=degree {
        let (sin, cos) = libm::sincos(m as f64 * angle);
        for l in m..=degree {
            let [even, odd] = pair(l, m);
            for channel in 0..3 {
                let (a, b) = (values[even][channel], values[odd][channel]);
                turned[even][channel] = a * cos - b * sin;
                turned[odd][channel] = a * sin + b * cos;
            }
        }
    }
    turned
}

/// Mirrored at y = 0, a turn about y is the same: functions with cos mφ, which are even there, and those with sin mφ do not mix.
fn about_y(values: &[[f64; 3]], degree: usize, angle: f64) -> Vec<[f64; 3]> {
    let wigner = Wigner::new(angle, degree);
    let sign = |even: bool| if even { 1.0 } else { -1.0 };
    let mut turned = vec![[0.0; 3]; values.len()];
    for row in 0..=degree {
        for column in 0..=degree {
            let lowest = row.max(column);
            let [plus, minus] = [row.cast_signed(), -row.cast_signed()]
                .map(|row| wigner.degrees(row, column.cast_signed(), degree));
            // Of complex functions with the Condon–Shortley sign Cₘ is √2 (−1)ᵐ Re Yₘ, Sₘ is √2 (−1)ᵐ Im Yₘ, and Y₋ₘ is (−1)ᵐ Ȳₘ.
            let both = sign((row + column).is_multiple_of(2));
            let mirrored = sign(row.is_multiple_of(2));
            let scale = match (row, column) {
                (0, 0) => 0.5,
                (0, _) | (_, 0) => std::f64::consts::FRAC_1_SQRT_2,
                _ => 1.0,
            };
            for (l, (plus, minus)) in (lowest..=degree).zip(plus.zip(minus)) {
                let minus = mirrored * minus;
                let ([to_even, to_odd], [even, odd]) = (pair(l, row), pair(l, column));
                let of_even = both * scale * (plus + minus);
                let of_odd = both * (plus - minus);
                for channel in 0..3 {
                    turned[to_even][channel] += of_even * values[even][channel];
                    if row > 0 && column > 0 {
                        turned[to_odd][channel] += of_odd * values[odd][channel];
                    }
                }
            }
        }
    }
    turned
}

/// Wigner's small d of one angle, `dˡ_mn = ⟨l m| exp(−iβ J_y) |l n⟩`.
struct Wigner {
    cos: f64,
    /// Powers of cos β/2 and sin β/2, to twice the greatest degree.
    powers: Vec<[f64; 2]>,
}

impl Wigner {
    fn new(angle: f64, degree: usize) -> Self {
        let (sin, cos) = libm::sincos(0.5 * angle);
        let powers = std::iter::successors(Some([1.0, 1.0]), |[c, s]| Some([c * cos, s * sin]));
        Self {
            cos: libm::cos(angle),
            powers: powers.take(2 * degree + 1).collect(),
        }
    }

    /// `d^l_ln` for |n| ≤ l: √(2l over l + n) cosˡ⁺ⁿ β/2 (−sin β/2)ˡ⁻ⁿ.
    fn first(&self, l: isize, n: isize) -> f64 {
        let (up, down) = ((l + n).cast_unsigned(), (l - n).cast_unsigned());
        let (most, least) = (up.max(down), up.min(down));
        let choose = (1..=least).fold(1.0, |product, k| product * (most + k) as f64 / k as f64);
        let sign = if down.is_multiple_of(2) { 1.0 } else { -1.0 };
        sign * choose.sqrt() * self.powers[up][0] * self.powers[down][1]
    }

    /// `dˡ_mn` for l from the greater of |m| and |n| to `degree`, n ≥ 0, by the recursion of Jacobi's polynomials (Kostelec &
    /// Rockmore 2008, "FFTs on the rotation group", eq. 10).
    fn degrees(&self, m: isize, n: isize, degree: usize) -> impl Iterator<Item = f64> {
        // d_mn = d_−n−m = (−1)^(m−n) d_nm.
        let (lowest, same) = (m.abs().max(n), (m - n) % 2 == 0);
        let flip = if same { 1.0 } else { -1.0 };
        let first = match m {
            _ if m == lowest => self.first(m, n),
            _ if -m == lowest => flip * self.first(-m, -n),
            _ => flip * self.first(n, m),
        };
        let (m, n, cos) = (m as f64, n as f64, self.cos);
        let root = move |l: f64| ((l * l - m * m) * (l * l - n * n)).sqrt();
        let (mut below, mut here) = (0.0, first);
        (lowest.cast_unsigned()..=degree).map(move |l| {
            let value = here;
            let l = l as f64;
            let next = match l {
                0.0 => cos * here,
                _ => {
                    let straight = (2.0 * l + 1.0) * (l * (l + 1.0) * cos - m * n) * here;
                    (straight - (l + 1.0) * root(l) * below) / (l * root(l + 1.0))
                }
            };
            (below, here) = (here, next);
            value
        })
    }
}
