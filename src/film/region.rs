//! Rectangles of pixels.

use crate::error::{Error, Result};

/// The pixels `x0 ≤ x < x1`, `y0 ≤ y < y1`; x to the right, y down, from the top left corner of the full image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
pub struct Region {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// Past the last column.
    pub x1: u32,
    /// Past the last row.
    pub y1: u32,
}

impl Region {
    /// All of an image.
    pub const fn full(width: u32, height: u32) -> Self {
        Self {
            x0: 0,
            y0: 0,
            x1: width,
            y1: height,
        }
    }

    /// Columns; 0 where it is empty.
    pub const fn width(self) -> u32 {
        self.x1.saturating_sub(self.x0)
    }

    /// Rows; 0 where it is empty.
    pub const fn height(self) -> u32 {
        self.y1.saturating_sub(self.y0)
    }

    /// Number of pixels.
    pub const fn pixels(self) -> usize {
        self.width() as usize * self.height() as usize
    }

    /// Whether it has no pixels.
    pub const fn is_empty(self) -> bool {
        self.width() == 0 || self.height() == 0
    }

    /// Whether every pixel of `other` is in it.
    pub const fn contains(self, other: Self) -> bool {
        self.x0 <= other.x0 && self.y0 <= other.y0 && self.x1 >= other.x1 && self.y1 >= other.y1
    }

    /// Whether it holds this pixel.
    pub const fn has(self, x: u32, y: u32) -> bool {
        self.x0 <= x && x < self.x1 && self.y0 <= y && y < self.y1
    }

    /// The smallest region that holds both.
    pub fn bounding(self, other: Self) -> Self {
        Self {
            x0: self.x0.min(other.x0),
            y0: self.y0.min(other.y0),
            x1: self.x1.max(other.x1),
            y1: self.y1.max(other.y1),
        }
    }

    /// The coordinates of its pixels, row after row.
    pub fn coordinates(self) -> impl Iterator<Item = (u32, u32)> {
        (self.y0..self.y1).flat_map(move |y| (self.x0..self.x1).map(move |x| (x, y)))
    }
}

/// Width and height in pixels, from a text such as `640x480`.
///
/// # Errors
/// What to write instead. Whether an image may be that large is checked with the other settings.
pub fn parse_size(text: &str) -> std::result::Result<(u32, u32), String> {
    text.split_once(['x', 'X', '×'])
        .and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)))
        .ok_or_else(|| "write width and height in pixels, as in 640x480".to_owned())
}

impl std::fmt::Display for Region {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{},{},{},{}", self.x0, self.y0, self.x1, self.y1)
    }
}

impl std::str::FromStr for Region {
    type Err = Error;

    /// From `x0,y0,x1,y1`; [`Error::Usage`] where that is not four whole numbers with x0 < x1 and y0 < y1.
    fn from_str(text: &str) -> Result<Self> {
        let wrong = |why: &str| {
            Error::Usage(format!(
                "\"{text}\" is no region of pixels: {why}; write x0,y0,x1,y1 with x0 < x1 and y0 < y1"
            ))
        };
        let numbers: Vec<u32> = text
            .split(',')
            .map(|part| part.trim().parse().map_err(|_| wrong("not whole numbers")))
            .collect::<Result<_>>()?;
        let &[x0, y0, x1, y1] = &numbers[..] else {
            return Err(wrong("not four numbers"));
        };
        let region = Self { x0, y0, x1, y1 };
        if region.is_empty() {
            return Err(wrong("it is empty"));
        }
        Ok(region)
    }
}
