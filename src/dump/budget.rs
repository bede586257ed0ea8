//! How far a port may be off: one table, by field.
//!
//! Units in the last place (ulp) are those of single precision, of the greatest component of a vector or colour.

/// What a field is, and so how two values of it are held against each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// A whole number that follows from settings alone: the same.
    Same,
    /// A whole number that says what was met or chosen. Where it differs, the path has parted from ours.
    Choice,
    /// A point or a direction. Where it is off by more than [`PARTED`], the path has parted from ours.
    Place,
    /// A quantity.
    Value,
}

/// From here on, 2⁻¹⁰ of the greatest component, a point or a direction is another one, not the same one rounded otherwise.
pub const PARTED: f64 = 16_384.0;

/// How many paths may part from ours: 1 in so many. A ray that passes the edge of a primitive to a rounding error may pass
/// it on the other side, and a random number that is a probability to a rounding error decide otherwise.
pub const PATHS_PER_PARTING: usize = 256;

/// Of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// How it is measured.
    pub measure: Measure,
    /// Ulp on the first edge, of a stage that was given the same input.
    pub ulp: f64,
}

/// What one edge's errors grow to on the next: directions of a curved mirror part by twice its curvature × distance.
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

const fn place(ulp: f64) -> Budget {
    Budget {
        measure: Measure::Place,
        ulp,
    }
}

const fn value(ulp: f64) -> Budget {
    Budget {
        measure: Measure::Value,
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
    ("origin", place(64.0)),
    ("position", place(64.0)),
    ("direction", place(64.0)),
    ("wo", place(64.0)),
    ("normal", place(64.0)),
    ("ng", place(64.0)),
    ("offset", value(64.0)),
    ("distance", value(64.0)),
    ("throughput", value(64.0)),
    ("pdf", value(64.0)),
    ("color", value(64.0)),
    ("roughness", value(64.0)),
    ("metallic", value(64.0)),
    ("u", value(64.0)),
    ("v", value(64.0)),
    ("emitted", value(64.0)),
    ("light_pdf", value(64.0)),
    ("weight", value(64.0)),
    ("contribution", value(64.0)),
    ("radiance", value(64.0)),
    ("sum", value(64.0)),
    ("square", value(64.0)),
    ("exact_sum", value(64.0)),
    ("exact_square", value(64.0)),
];

/// That of a field on an edge, which counts from 1; none for a field that no record has.
pub fn of(field: &str, edge: u32) -> Option<Budget> {
    let (_, budget) = BUDGETS.iter().find(|(name, _)| *name == field)?;
    // Beyond it a place has parted anyway.
    let grown = budget.ulp * libm::pow(GROWTH, f64::from(edge.saturating_sub(1)));
    Some(Budget {
        ulp: grown.min(PARTED),
        ..*budget
    })
}
