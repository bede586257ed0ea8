//! A colour by direction, from its coefficients.

use super::{coefficients, index, legendre};
use crate::lanes::{Rgbx8, Vec3x8, f32x8};

/// `Σ cₗₘ Yₗₘ(d)`, summed while the basis is evaluated: no room for its values is needed, whatever the degree.
#[derive(Clone, Debug)]
pub struct Series {
    /// For each order m from 0 on: its first function over sinᵐθ, and the terms of degrees m to the greatest.
    orders: Vec<(f32, Vec<Term>)>,
}

/// One degree of an order.
#[derive(Clone, Copy, Debug)]
struct Term {
    /// Coefficients of orders m and −m; of m = 0 the second are 0.
    even: [f32; 3],
    odd: [f32; 3],
    /// The next degree's function is `a · z · this − b · the one before`.
    a: f32,
    b: f32,
}

impl Series {
    /// From coefficients of degrees 0 to `degree`, in the order of [`index`].
    ///
    /// # Panics
    /// Where there are not [`coefficients`] of them.
    #[must_use]
    pub fn new(degree: usize, values: &[[f64; 3]]) -> Self {
        assert_eq!(values.len(), coefficients(degree));
        let mut first = 1.0;
        let orders = (0..=degree).map(|m| {
            first *= legendre::first(m);
            let terms = (m..=degree).map(|l| {
                let [a, b] = legendre::step(l, m);
                let order = m as isize;
                let at = |order| values[index(l, order)].map(|value| value as f32);
                Term {
                    even: at(order),
                    odd: if m == 0 { [0.0; 3] } else { at(-order) },
                    a: a as f32,
                    b: b as f32,
                }
            });
            (first as f32, terms.collect())
        });
        Self {
            orders: orders.collect(),
        }
    }

    /// The sum in eight unit directions.
    #[inline]
    #[must_use]
    pub fn evaluate(&self, direction: Vec3x8) -> Rgbx8 {
        let Vec3x8 { x, y, z } = direction;
        // sinᵐθ cos mφ and sinᵐθ sin mφ.
        let (mut cos, mut sin) = (f32x8::ONE, f32x8::ZERO);
        let mut sum = Rgbx8::ZERO;
        for (first, terms) in &self.orders {
            let (mut below, mut here) = (f32x8::ZERO, f32x8::splat(*first));
            let (mut even, mut odd) = (Rgbx8::ZERO, Rgbx8::ZERO);
            for term in terms {
                let [even_rgb, odd_rgb] = [term.even, term.odd].map(|rgb| Rgbx8::splat(rgb.into()));
                even = even_rgb.mul_add(here, even);
                odd = odd_rgb.mul_add(here, odd);
                let next = (z * here).mul_sub(f32x8::splat(term.a), below * f32x8::splat(term.b));
                (below, here) = (here, next);
            }
            sum = even.mul_add(cos, odd.mul_add(sin, sum));
            (cos, sin) = (x.mul_sub(cos, y * sin), x.mul_add(sin, y * cos));
        }
        sum
    }
}
