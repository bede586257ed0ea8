//! Which waves an image is traced in.

use crate::film::{BLOCK, Coverage, Passes, Region};
use crate::wavefront::Wave;

/// The waves of an image, numbered: block after block of samples, and in each the tiles row by row.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    region: Region,
    spp: u32,
    rectangles: Vec<Rectangle>,
}

/// A rectangle of pixels in one or several passes, cut into tiles.
#[derive(Clone, Debug)]
struct Rectangle {
    part: Passes,
    /// Number of its first wave.
    first: u64,
    /// Pixels across and down a tile.
    tile: (u32, u32),
    columns: u64,
    rows: u64,
}

impl Rectangle {
    fn waves(&self) -> u64 {
        self.columns * self.rows * (self.part.passes.end - self.part.passes.start)
    }
}

impl Plan {
    /// For these sample blocks of a region, each pixel of which shall have `spp` samples, in waves of at most `wave` paths.
    pub fn new(region: Region, spp: u32, todo: &Coverage, wave: u32) -> Self {
        let pixels = (wave / spp.min(BLOCK)).max(1);
        let mut first = 0;
        let rectangle = |part: Passes| {
            let height = part.tile.height().min(pixels.isqrt());
            // What is lower than a square tile is made of wider ones.
            let width = match part.tile.height() < pixels.isqrt() {
                true => pixels / height,
                false => pixels.isqrt(),
            };
            let rectangle = Rectangle {
                first,
                tile: (width, height),
                columns: part.tile.width().div_ceil(width).into(),
                rows: part.tile.height().div_ceil(height).into(),
                part,
            };
            first += rectangle.waves();
            rectangle
        };
        Self {
            region,
            spp,
            rectangles: todo.rectangles(region).into_iter().map(rectangle).collect(),
        }
    }

    /// Number of waves.
    pub fn waves(&self) -> u64 {
        self.rectangles
            .last()
            .map_or(0, |last| last.first + last.waves())
    }

    /// Paths of the largest.
    pub fn largest_wave(&self) -> usize {
        let pixels = self.rectangles.iter().map(|rectangle| {
            let (width, height) = rectangle.tile;
            let tile = rectangle.part.tile;
            width.min(tile.width()) as usize * height.min(tile.height()) as usize
        });
        pixels.max().unwrap_or(0) * self.spp.min(BLOCK) as usize
    }

    /// Wave `number`, or none past the last.
    pub fn wave(&self, number: u64) -> Option<Wave> {
        let after = self
            .rectangles
            .partition_point(|rectangle| rectangle.first <= number);
        let rectangle = self.rectangles.get(after.checked_sub(1)?)?;
        let within = number - rectangle.first;
        if within >= rectangle.waves() {
            return None;
        }
        let tiles = rectangle.columns * rectangle.rows;
        let pass = rectangle.part.passes.start + within / tiles;
        let first_sample = u32::try_from(pass * u64::from(BLOCK)).ok()?;
        let (row, column) = (
            within % tiles / rectangle.columns,
            within % tiles % rectangle.columns,
        );
        let (part, (width, height)) = (rectangle.part.tile, rectangle.tile);
        let x = part.x0 + column as u32 * width;
        let y = part.y0 + row as u32 * height;
        Some(Wave {
            x,
            y,
            width: width.min(part.x1 - x),
            height: height.min(part.y1 - y),
            first_sample,
            samples: self.spp.checked_sub(first_sample)?.min(BLOCK),
        })
    }

    /// The sample blocks of the first `number` waves.
    pub fn done(&self, number: u64) -> Coverage {
        let mut all = Vec::new();
        for rectangle in &self.rectangles {
            let waves = number
                .saturating_sub(rectangle.first)
                .min(rectangle.waves());
            let tiles = rectangle.columns * rectangle.rows;
            let Passes { tile, passes } = rectangle.part.clone();
            let pass = passes.start + waves / tiles;
            let mut add = |tile: Region, passes| {
                let part = Passes { tile, passes };
                all.extend_from_slice(Coverage::of_passes(self.region, &part).ranges());
            };
            add(tile, passes.start..pass);
            // Of a pass that is not at its end: whole rows of tiles, and the beginning of one.
            let (rows, columns) = (
                waves % tiles / rectangle.columns,
                waves % tiles % rectangle.columns,
            );
            let (width, height) = rectangle.tile;
            let bottom = |rows: u64| (tile.y0 + rows as u32 * height).min(tile.y1);
            let whole = Region {
                y1: bottom(rows),
                ..tile
            };
            let begun = Region {
                x1: (tile.x0 + columns as u32 * width).min(tile.x1),
                y0: bottom(rows),
                y1: bottom(rows + 1),
                ..tile
            };
            add(whole, pass..pass + 1);
            add(begun, pass..pass + 1);
        }
        Coverage::of(all)
    }
}
