//! Images, kept as compact as their files.

use crate::lanes::Rgb;
use std::sync::LazyLock;

/// An image, row 0 on top.
#[derive(Clone, Debug)]
pub struct Image {
    /// Where it came from, as errors and `info` name it.
    pub file: String,
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// RGBA, row-major.
    pub pixels: Pixels,
}

/// The pixels of an image.
#[derive(Clone, Debug)]
pub enum Pixels {
    /// Eight bits, colour by the sRGB curve, alpha linear.
    Srgb8(Vec<[u8; 4]>),
    /// Eight bits, linear.
    Linear8(Vec<[u8; 4]>),
    /// Linear, finite, not negative.
    Float(Vec<[f32; 4]>),
}

impl Image {
    /// The mean colour, linear: what a light of this texture emits, over what it would emit if the texture were white.
    /// White for an image without pixels.
    pub fn mean(&self) -> Rgb {
        let count = self.pixels.len();
        if count == 0 {
            return Rgb::WHITE;
        }
        let mut sum = [0.0; 3];
        for texel in (0..count).filter_map(|index| self.pixels.get(index)) {
            for (sum, channel) in sum.iter_mut().zip(texel) {
                *sum += f64::from(channel);
            }
        }
        Rgb::from(sum.map(|sum| (sum / count as f64) as f32))
    }
}

impl Pixels {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Pixels::Srgb8(texels) | Pixels::Linear8(texels) => texels.len(),
            Pixels::Float(texels) => texels.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One pixel: linear RGBA.
    #[inline]
    pub(super) fn get(&self, index: usize) -> Option<[f32; 4]> {
        match self {
            Pixels::Srgb8(texels) => texels.get(index).map(|&[r, g, b, a]| {
                let [r, g, b] = [r, g, b].map(|code| SRGB[usize::from(code)]);
                [r, g, b, LINEAR[usize::from(a)]]
            }),
            Pixels::Linear8(texels) => texels
                .get(index)
                .map(|texel| texel.map(|code| LINEAR[usize::from(code)])),
            Pixels::Float(texels) => texels.get(index).copied(),
        }
    }
}

/// n / 255.
static LINEAR: [f32; 256] = {
    let mut table = [0.0; 256];
    let mut code = 0;
    while code < 256 {
        table[code] = code as f32 / 255.0;
        code += 1;
    }
    table
};

/// The sRGB curve (IEC 61966-2-1), from codes to linear values.
static SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|code| {
        let value = code as f64 / 255.0;
        let linear = if value <= 0.04045 {
            value / 12.92
        } else {
            libm::pow((value + 0.055) / 1.055, 2.4)
        };
        linear as f32
    })
});
