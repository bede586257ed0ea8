//! From linear radiance to the eight bits of a screen.

use crate::error::Error;
use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

/// A tone curve, the same for each channel: monotone, from [0, ∞] to [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Operator {
    /// Cut off at 1.
    #[default]
    Linear,
    /// `x / (1 + x)` (Reinhard et al. 2002, eq. 3).
    Reinhard,
    /// A fit of the ACES reference rendering and output transforms (Narkowicz 2015, "ACES Filmic Tone Mapping Curve").
    Aces,
}

/// How radiance becomes a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tonemap {
    /// The tone curve.
    pub operator: Operator,
    /// Exposure value: radiance is multiplied by 2^exposure first.
    pub exposure: f32,
}

impl Operator {
    /// The curve, linear in and out. NaN and what is negative give 0, +∞ gives 1.
    pub fn apply(self, x: f32) -> f32 {
        // `max` drops a NaN, which `clamp` would keep; the limit keeps quotients finite; f64 keeps rounding below what
        // could upset the order.
        let x = f64::from(x.max(0.0)).min(f64::from(f32::MAX));
        let y = match self {
            Self::Linear => x,
            Self::Reinhard => x / (1.0 + x),
            Self::Aces => x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14),
        };
        y.min(1.0) as f32
    }
}

impl Tonemap {
    /// Whether an exposure is one that can be asked for: up to 64 either way.
    pub fn can_expose(exposure: f32) -> bool {
        exposure.abs() <= 64.0
    }

    /// The sRGB code of a channel, 0 to 255.
    pub fn encode(self, radiance: f32) -> u8 {
        self.encoder()(radiance)
    }

    /// [`encode`](Self::encode) for many channels.
    pub fn encoder(self) -> impl Fn(f32) -> u8 + Sync {
        let scale = libm::exp2f(self.exposure);
        move |radiance| to_srgb(self.operator.apply(radiance * scale))
    }
}

/// The linear value at which code `i + 1` begins: where the transfer function of IEC 61966-2-1, times 255, is `i + 1/2`.
static STARTS: LazyLock<[f32; 255]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let code = (i as f64 + 0.5) / 255.0;
        let linear = if code <= 0.04045 {
            code / 12.92
        } else {
            libm::pow((code + 0.055) / 1.055, 2.4)
        };
        linear as f32
    })
});

/// The nearest sRGB code of a linear value in [0, 1]; the table needs no power of each pixel and rounds rightly.
fn to_srgb(linear: f32) -> u8 {
    STARTS.partition_point(|&start| start <= linear) as u8
}

impl fmt::Display for Operator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Linear => "linear",
            Self::Reinhard => "reinhard",
            Self::Aces => "aces",
        })
    }
}

impl FromStr for Operator {
    type Err = Error;

    /// [`Error::Usage`] at an unknown name.
    fn from_str(name: &str) -> Result<Self, Error> {
        [Self::Linear, Self::Reinhard, Self::Aces]
            .into_iter()
            .find(|operator| operator.to_string() == name)
            .ok_or_else(|| {
                Error::Usage(format!(
                    "unknown tone curve \"{name}\"; there are linear, reinhard and aces"
                ))
            })
    }
}
