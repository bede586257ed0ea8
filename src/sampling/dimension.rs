//! The names of random numbers.

/// What a random number decides. Each decision has numbers of its own at each path edge, so no two are correlated.
///
/// The order is part of what an image's bits depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Where in the pixel's filter, or on the sphere around a probe (a pair).
    PixelFilter,
    /// Where on the lens (a pair).
    Lens,
    /// Which light source (one).
    LightChoice,
    /// Where on the light source (a pair).
    LightPoint,
    /// Which lobe of the BSDF (one).
    BsdfLobe,
    /// Which direction of the lobe (a pair).
    BsdfDirection,
    /// Whether the path goes on (one).
    Roulette,
}

impl Dimension {
    /// Every dimension.
    pub const ALL: [Dimension; 7] = [
        Dimension::PixelFilter,
        Dimension::Lens,
        Dimension::LightChoice,
        Dimension::LightPoint,
        Dimension::BsdfLobe,
        Dimension::BsdfDirection,
        Dimension::Roulette,
    ];

    /// Numbers that are set aside for one path edge: two for each dimension.
    pub const PER_BOUNCE: u32 = 2 * Self::ALL.len() as u32;

    /// Position of the (first) number of this dimension at a bounce; the camera is bounce 0.
    #[inline]
    pub const fn position(self, bounce: u32) -> u32 {
        bounce * Self::PER_BOUNCE + 2 * self as u32
    }
}
