//! A tile of two images: both are looked at, and what is seen is compared.

use super::colour::{Hunt, Opponents, power};
use super::filters::{Filter, Filters, RADIUS};
use crate::lanes::{Rgbx8, WIDTH, f32x8, square};
use std::f32::consts::FRAC_1_SQRT_2;

/// Columns and rows of a tile: what one exposure of it needs stays in a megabyte of cache.
const COLUMNS: usize = 128;
const ROWS: usize = 64;

/// With what filters see around it.
const PADDED_COLUMNS: usize = COLUMNS + 2 * RADIUS;
const PADDED_ROWS: usize = ROWS + 2 * RADIUS;

/// Pixels that a filter gives at a time: one addition need not wait for the other.
const RUN: usize = 4 * WIDTH;

/// A tile's place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    x: usize,
    y: usize,
    columns: usize,
    rows: usize,
}

impl Tile {
    /// The tiles of an image, row after row.
    pub fn all(width: usize, height: usize) -> Vec<Self> {
        let rows = (0..height).step_by(ROWS);
        rows.flat_map(|y| {
            (0..width).step_by(COLUMNS).map(move |x| Self {
                x,
                y,
                columns: COLUMNS.min(width - x),
                rows: ROWS.min(height - y),
            })
        })
        .collect()
    }

    /// Puts a tile's pixels at their place in an image.
    pub fn paste(&self, pixels: &[f32], image: &mut [f32], width: usize) {
        for (y, row) in pixels.chunks_exact(self.columns).enumerate() {
            image[(self.y + y) * width + self.x..][..self.columns].copy_from_slice(row);
        }
    }
}

/// A plane of numbers, row after row.
type Plane = Vec<f32>;

/// The filters' results along rows, in the order of [`Workspace::filter_rows`].
const FILTERED: usize = 7;

/// What is seen of an image's tile, for each pixel.
struct Seen {
    l: Plane,
    a: Plane,
    b: Plane,
    edge: Plane,
    point: Plane,
}

/// What a worker needs for a tile. Where a tile is smaller, the rest of a plane is not read.
pub(super) struct Workspace {
    filters: Filters,
    /// R, G, B of both images, padded.
    sources: [[Plane; 3]; 2],
    /// [`Opponents`] of one, padded.
    opponents: [Plane; 3],
    /// Those filtered along rows, padded above and below.
    filtered: [Plane; FILTERED],
    /// What the filters make of both images.
    seen: [Seen; 2],
    /// The greatest error of each pixel until now.
    errors: Plane,
}

impl Workspace {
    pub fn new() -> Self {
        let plane = |columns: usize, rows: usize| vec![0.0; columns * rows];
        let padded = || std::array::from_fn(|_| plane(PADDED_COLUMNS, PADDED_ROWS));
        let tile = || plane(COLUMNS, ROWS);
        let seen = || Seen {
            l: tile(),
            a: tile(),
            b: tile(),
            edge: tile(),
            point: tile(),
        };
        Self {
            filters: Filters::new(),
            sources: [padded(), padded()],
            opponents: padded(),
            filtered: std::array::from_fn(|_| plane(COLUMNS, PADDED_ROWS)),
            seen: [seen(), seen()],
            errors: tile(),
        }
    }

    /// Takes a tile of both images, with what is around it, and forgets the errors of the last; whether the two differ.
    /// Beyond an image, its border goes on.
    pub fn load(&mut self, tile: &Tile, width: usize, images: [&[Vec<f32>; 3]; 2]) -> bool {
        self.errors.fill(0.0);
        for (sources, image) in self.sources.iter_mut().zip(images) {
            for (source, plane) in sources.iter_mut().zip(image) {
                let height = plane.len() / width;
                for (y, row) in source.chunks_exact_mut(PADDED_COLUMNS).enumerate() {
                    let y = (tile.y + y).saturating_sub(RADIUS).min(height - 1);
                    let from = &plane[y * width..][..width];
                    for (x, value) in row.iter_mut().enumerate() {
                        *value = from[(tile.x + x).saturating_sub(RADIUS).min(width - 1)];
                    }
                }
            }
        }
        self.sources[0] != self.sources[1]
    }

    /// Looks at both images; `show` takes a channel to the screen's linear [0, 1].
    pub fn look(&mut self, tile: &Tile, show: impl Fn(f32x8) -> f32x8) {
        for image in 0..2 {
            self.part_colours(image, &show);
            self.filter_rows(tile);
            self.filter_columns(tile, image);
        }
        self.compare();
    }

    /// The greatest error of each pixel since the tile was loaded, row after row.
    pub fn errors(&self, tile: &Tile) -> Vec<f32> {
        let rows = self.errors.chunks_exact(COLUMNS).take(tile.rows);
        rows.flat_map(|row| &row[..tile.columns]).copied().collect()
    }

    fn part_colours(&mut self, image: usize, show: impl Fn(f32x8) -> f32x8) {
        let [r, g, b] = self.sources[image].each_ref().map(lanes);
        let [y, x_less_y, y_less_z] = self.opponents.each_mut().map(lanes_mut);
        for i in 0..y.len() {
            let [r, g, b] = [r[i], g[i], b[i]].map(|channel| show(f32x8::new(channel)));
            let opponents = Opponents::of(Rgbx8::new(r, g, b));
            y[i] = opponents.y.to_array();
            x_less_y[i] = opponents.x_less_y.to_array();
            y_less_z[i] = opponents.y_less_z.to_array();
        }
    }

    fn filter_rows(&mut self, tile: &Tile) {
        let filters = &self.filters;
        let [y, x_less_y, y_less_z] = &self.opponents;
        let passes: [(&Plane, &Filter); FILTERED] = [
            (y, &filters.luminance),
            (x_less_y, &filters.red_green),
            (y_less_z, &filters.yellow_blue[0]),
            (y_less_z, &filters.yellow_blue[1]),
            (y, &filters.smooth),
            (y, &filters.edge),
            (y, &filters.point),
        ];
        for row in 0..tile.rows + 2 * RADIUS {
            for x in (0..tile.columns).step_by(RUN) {
                for ((plane, filter), to) in passes.iter().zip(&mut self.filtered) {
                    let run = convolve(plane, row * PADDED_COLUMNS + x, 1, filter);
                    store(to, row * COLUMNS + x, run);
                }
            }
        }
    }

    fn filter_columns(&mut self, tile: &Tile, image: usize) {
        let filters = &self.filters;
        let [
            luminance,
            red_green,
            yellow_blue,
            yellow_blue_2,
            smooth,
            edge,
            point,
        ] = &self.filtered;
        let seen = &mut self.seen[image];
        for row in 0..tile.rows {
            for x in (0..tile.columns).step_by(RUN) {
                let at = row * COLUMNS + x;
                let column = |plane, filter| convolve(plane, at, COLUMNS, filter);
                let y = column(luminance, &filters.luminance);
                let x_less_y = column(red_green, &filters.red_green);
                let wide = column(yellow_blue, &filters.yellow_blue[0]);
                let narrow = column(yellow_blue_2, &filters.yellow_blue[1]);
                let colours: [Hunt; RUN / WIDTH] = std::array::from_fn(|i| {
                    let blurred = Opponents {
                        y: y[i],
                        x_less_y: x_less_y[i],
                        y_less_z: wide[i] + narrow[i],
                    };
                    Hunt::of(blurred.to_rgb())
                });
                store(&mut seen.l, at, colours.map(|colour| colour.l));
                store(&mut seen.a, at, colours.map(|colour| colour.a));
                store(&mut seen.b, at, colours.map(|colour| colour.b));
                let strength = |across: Run, down: Run| {
                    std::array::from_fn(|i| (square(across[i]) + square(down[i])).sqrt())
                };
                let edges = strength(column(edge, &filters.smooth), column(smooth, &filters.edge));
                store(&mut seen.edge, at, edges);
                let points = strength(
                    column(point, &filters.smooth),
                    column(smooth, &filters.point),
                );
                store(&mut seen.point, at, points);
            }
        }
    }

    /// Andersson et al. 2020, "Final Difference": where features differ, colours count for more.
    fn compare(&mut self) {
        let [reference, test] = self.seen.each_ref().map(|seen| {
            let Seen {
                l,
                a,
                b,
                edge,
                point,
            } = seen;
            [l, a, b, edge, point].map(lanes)
        });
        for (i, error) in lanes_mut(&mut self.errors).iter_mut().enumerate() {
            let [(colour, edge, point), (colour_2, edge_2, point_2)] =
                [reference, test].map(|seen| {
                    let [l, a, b, edge, point] = seen.map(|plane| f32x8::new(plane[i]));
                    (Hunt { l, a, b }, edge, point)
                });
            let feature = (edge - edge_2).abs().fast_max((point - point_2).abs());
            let feature = (feature * FRAC_1_SQRT_2).sqrt().fast_min(f32x8::ONE);
            let seen = power(colour.error(colour_2), f32x8::ONE - feature);
            *error = f32x8::new(*error).fast_max(seen).to_array();
        }
    }
}

/// Neighbours in a row, which a filter gives at a time.
type Run = [f32x8; RUN / WIDTH];

/// The filter at [`RUN`] neighbours: of each, `RADIUS · step` numbers lie before what it is centred on, and `first` is where
/// the first of them begins.
#[inline]
fn convolve(plane: &[f32], first: usize, step: usize, filter: &Filter) -> Run {
    let first = first + (RADIUS - filter.radius()) * step;
    let mut sum = [f32x8::ZERO; RUN / WIDTH];
    for (k, &weight) in filter.weights().iter().enumerate() {
        let (from, _) = plane[first + k * step..][..RUN].as_chunks();
        for (sum, &values) in sum.iter_mut().zip(from) {
            *sum = f32x8::new(values).mul_add(f32x8::splat(weight), *sum);
        }
    }
    sum
}

#[inline]
fn store(plane: &mut [f32], at: usize, run: Run) {
    let (to, _) = plane[at..][..RUN].as_chunks_mut();
    for (to, values) in to.iter_mut().zip(run) {
        *to = values.to_array();
    }
}

/// A plane, eight numbers at a time. Its length is a multiple of eight.
#[inline]
fn lanes(plane: &Plane) -> &[[f32; WIDTH]] {
    plane.as_chunks().0
}

#[inline]
fn lanes_mut(plane: &mut Plane) -> &mut [[f32; WIDTH]] {
    plane.as_chunks_mut().0
}
