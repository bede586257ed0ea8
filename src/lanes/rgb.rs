//! Linear RGB, in one lane and in eight.

use super::{f32x8, queue::Lane};
use std::ops::{Add, Mul};

/// Linear RGB: a radiance, a reflectance or a throughput.
#[derive(Clone, Copy, Default, Debug, PartialEq)]
pub struct Rgb {
    /// Red.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
}

impl Rgb {
    /// No light.
    pub const BLACK: Self = Self::splat(0.0);
    /// One in each channel.
    pub const WHITE: Self = Self::splat(1.0);

    /// From channels.
    pub const fn new(r: f32, g: f32, b: f32) -> Self {
        Self { r, g, b }
    }

    /// The same value in each channel.
    pub const fn splat(v: f32) -> Self {
        Self::new(v, v, v)
    }

    /// The channels as an array.
    pub const fn to_array(self) -> [f32; 3] {
        [self.r, self.g, self.b]
    }

    /// Rec. 709 luminance. Used to weigh choices, never to make an image.
    pub fn luminance(self) -> f32 {
        0.2126 * self.r + 0.7152 * self.g + 0.0722 * self.b
    }

    /// The greatest channel.
    pub fn max_channel(self) -> f32 {
        self.r.max(self.g).max(self.b)
    }
}

impl From<[f32; 3]> for Rgb {
    fn from([r, g, b]: [f32; 3]) -> Self {
        Self::new(r, g, b)
    }
}

/// Eight linear RGB values.
#[derive(Clone, Copy, Default, Debug)]
#[repr(C)]
pub struct Rgbx8 {
    /// Red of each lane.
    pub r: f32x8,
    /// Green of each lane.
    pub g: f32x8,
    /// Blue of each lane.
    pub b: f32x8,
}

impl Rgbx8 {
    /// No light in any lane.
    pub const ZERO: Self = Self::gray(f32x8::ZERO);
    /// One in each channel of each lane.
    pub const ONE: Self = Self::gray(f32x8::ONE);

    /// From channels.
    #[inline]
    pub const fn new(r: f32x8, g: f32x8, b: f32x8) -> Self {
        Self { r, g, b }
    }

    /// The same value in the three channels of a lane.
    #[inline]
    pub const fn gray(v: f32x8) -> Self {
        Self::new(v, v, v)
    }

    /// The same colour in every lane.
    #[inline]
    pub fn splat(c: Rgb) -> Self {
        Self::new(f32x8::splat(c.r), f32x8::splat(c.g), f32x8::splat(c.b))
    }

    /// `self * s + b`, fused.
    #[inline]
    pub fn mul_add(self, s: f32x8, b: Self) -> Self {
        Self::new(
            self.r.mul_add(s, b.r),
            self.g.mul_add(s, b.g),
            self.b.mul_add(s, b.b),
        )
    }

    /// The greatest channel of each lane.
    #[inline]
    pub fn max_channel(self) -> f32x8 {
        self.r.fast_max(self.g).fast_max(self.b)
    }

    /// The greatest channel of each lane without its sign: above 0 where there is any light, for a band-limited sky may be
    /// negative.
    #[inline]
    pub fn max_magnitude(self) -> f32x8 {
        Self::new(self.r.abs(), self.g.abs(), self.b.abs()).max_channel()
    }

    /// Rec. 709 luminance.
    #[inline]
    pub fn luminance(self) -> f32x8 {
        self.r.mul_add(
            f32x8::splat(0.2126),
            self.g
                .mul_add(f32x8::splat(0.7152), self.b * f32x8::splat(0.0722)),
        )
    }

    /// `on` where the mask is on, `off` elsewhere.
    #[inline]
    pub fn select(mask: f32x8, on: Self, off: Self) -> Self {
        Self::new(
            mask.select(on.r, off.r),
            mask.select(on.g, off.g),
            mask.select(on.b, off.b),
        )
    }

    /// The value where the mask is on, black elsewhere.
    #[inline]
    pub fn masked(self, mask: f32x8) -> Self {
        Self::new(self.r & mask, self.g & mask, self.b & mask)
    }

    /// One lane.
    #[inline]
    pub fn lane(&self, lane: usize) -> Rgb {
        Rgb::new(
            self.r.as_array()[lane],
            self.g.as_array()[lane],
            self.b.as_array()[lane],
        )
    }
}

impl Add for Rgbx8 {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self::new(self.r + o.r, self.g + o.g, self.b + o.b)
    }
}

impl Mul for Rgbx8 {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Self::new(self.r * o.r, self.g * o.g, self.b * o.b)
    }
}

impl Mul<f32x8> for Rgbx8 {
    type Output = Self;
    #[inline]
    fn mul(self, s: f32x8) -> Self {
        Self::new(self.r * s, self.g * s, self.b * s)
    }
}

impl Lane for Rgb {
    type Wide = Rgbx8;
    #[inline]
    fn get(wide: &Rgbx8, lane: usize) -> Self {
        wide.lane(lane)
    }
    #[inline]
    fn set(self, wide: &mut Rgbx8, lane: usize) {
        wide.r.as_mut_array()[lane] = self.r;
        wide.g.as_mut_array()[lane] = self.g;
        wide.b.as_mut_array()[lane] = self.b;
    }
}
