//! What the report prints: A. Benyoub 2014, "IFT6095, Travail pratique numéro 3: SH et Path Tracing", section 2.

/// Values of one lobe, by degree; those of other degrees are not printed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Printed {
    /// What the report calls it.
    pub name: &'static str,
    /// The exponent that explains the numbers; the report does not say it.
    pub exponent: f64,
    /// Degree and value.
    pub values: &'static [(usize, f64)],
}

/// Every table of the section, in its order.
pub(super) const ALL: [Printed; 6] = [
    Printed {
        name: "clamped cosine",
        exponent: 1.0,
        values: &[
            (0, 2.4987924944310436),
            (2, 1.3803589958677969),
            (4, -0.29992783197988493),
        ],
    },
    Printed {
        name: "Maple",
        exponent: 1.0,
        values: &[(0, 2.506628274), (2, 1.401247804), (4, -0.3133285342)],
    },
    Printed {
        name: "POW 0",
        exponent: 1.0,
        values: &[
            (0, 2.4756159450847597),
            (2, 1.3767345593614992),
            (4, -0.28411281924042253),
        ],
    },
    Printed {
        name: "POW 1",
        exponent: 5.0,
        values: &[
            (0, 2.494064980142964),
            (2, 3.584045033781966),
            (3, 0.12493407875654114),
            (4, 1.4645887928749453),
        ],
    },
    Printed {
        name: "POW 2",
        exponent: 10.0,
        values: &[
            (0, 2.5119348175482865),
            (1, 0.13738217582817872),
            (2, 4.298680906543962),
            (3, -0.3831145860474819),
            (4, 3.1162073572816205),
        ],
    },
    Printed {
        name: "POW 3",
        exponent: 50.0,
        values: &[
            (0, 2.5073073578266403),
            (1, 0.13130146961612968),
            (2, 5.57585063584913),
            (3, 0.11917510806978339),
            (4, 6.16933987163121),
            (5, 0.5290615255307245),
        ],
    },
];

/// Why these are not the coefficients of a clamped lobe.
pub(super) const WHY: &str = "The report integrates |cos|^n over the whole sphere, not max(cos, 0)^n: its even degrees are \
twice as large and its odd ones vanish, so that what it prints of these is noise of its Monte Carlo estimate. It also \
multiplies order 0 by sqrt(2), a factor that belongs to the other orders alone, and does not say that POW 0 to 3 are the \
exponents 1, 5, 10 and 50.";
