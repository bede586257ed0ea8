//! How far a port may be off: one table, by field.
//!
//! Units in the last place (ulp) are those of single precision, of the greatest component of a vector or colour. Budgets are
//! four times what a build of this program without fused multiply-adds, a port with other roundings, is off by on one path in
//! a thousand, or less: rays at grazing angles, narrow lobes and differences of near numbers have no greatest error.

/// What a field is, and so how two values of it are held against each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// A whole number that follows from settings alone: the same.
    Same,
    /// A whole number that says what was met or chosen.
    Choice,
    /// A quantity: in ulp of itself.
    Value,
    /// A sum of squares, whose errors are twice those of what is squared: in ulp of itself.
    Square,
    /// A quantity in [0, 1], whose errors do not shrink with it: in ulp of 1.
    Fraction,
}

/// No budget is more (of squares, twice this): from here on, 2⁻¹⁰, a value is another one, not the same one with other
/// roundings.
pub const PARTED: f64 = 16_384.0;

/// How many paths may part from ours, by another choice or by a value beyond its budget: 1 in so many. A ray that passes the
/// edge of a primitive to a rounding error may pass it on the other side, and a random number that is a probability to a
/// rounding error decide otherwise. Of the scenes that come with the program, the build above parts on 1 path in 10 000
/// (boxes) to 1 in 250 (normal maps).
pub const PATHS_PER_PARTING: usize = 100;

/// Of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// How it is measured.
    pub measure: Measure,
    /// Ulp on the first edge, of a stage that was given the same input.
    pub ulp: f64,
}

/// What the errors of one edge grow to on the next: a curved mirror turns directions by twice its curvature × distance more.
pub const GROWTH: f64 = 4.0;

const fn same() -> Budget {
    Budget {
        measure: Measure::Same,
        ulp: 0.0,
    }
}

const fn choice() -> Budget {
    Budget {
        measure: Measure::Choice,
        ulp: 0.0,
    }
}

const fn value(ulp: f64) -> Budget {
    Budget {
        measure: Measure::Value,
        ulp,
    }
}

const fn square(ulp: f64) -> Budget {
    Budget {
        measure: Measure::Square,
        ulp,
    }
}

const fn fraction(ulp: f64) -> Budget {
    Budget {
        measure: Measure::Fraction,
        ulp,
    }
}

/// Every field of every record, and those of the film.
pub const BUDGETS: &[(&str, Budget)] = &[
    ("path", same()),
    ("key", same()),
    ("index", same()),
    ("x", same()),
    ("y", same()),
    ("pixel", same()),
    ("sample", same()),
    ("first_sample", same()),
    ("count", same()),
    ("material", choice()),
    ("light", choice()),
    ("primitive", choice()),
    ("target", choice()),
    ("visible", choice()),
    ("origin", value(128.0)),
    ("position", value(128.0)),
    ("direction", value(512.0)),
    ("wo", value(512.0)),
    ("normal", value(256.0)),
    ("ng", value(16.0)),
    ("offset", value(128.0)),
    ("distance", value(128.0)),
    ("throughput", value(2048.0)),
    ("pdf", value(2048.0)),
    ("color", fraction(512.0)),
    ("roughness", fraction(512.0)),
    ("metallic", fraction(512.0)),
    ("u", fraction(256.0)),
    ("v", fraction(256.0)),
    ("emitted", value(256.0)),
    ("light_pdf", value(512.0)),
    ("weight", fraction(256.0)),
    ("contribution", value(4096.0)),
    ("radiance", value(4096.0)),
    ("sum", value(4096.0)),
    ("square", square(8192.0)),
    ("exact_sum", value(4096.0)),
    ("exact_square", square(8192.0)),
];

/// That of a field on an edge, which counts from 1; none for a field that no record has.
pub fn of(field: &str, edge: u32) -> Option<Budget> {
    let (_, budget) = BUDGETS.iter().find(|(name, _)| *name == field)?;
    let grown = budget.ulp * libm::pow(GROWTH, f64::from(edge.saturating_sub(1)));
    let most = match budget.measure {
        Measure::Square => 2.0 * PARTED,
        _ => PARTED,
    };
    Some(Budget {
        ulp: grown.min(most),
        ..*budget
    })
}
