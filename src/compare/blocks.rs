//! Sums over blocks of pixels, and their normal scores.
//!
//! Within a block the scatter of d = test − reference is all that is needed to judge its mean: no variance channel, no
//! sample count, and what stratified samples or equal seeds save is in it. Two images of equally many samples have a
//! symmetric d; and then Σd / √Σd² has tails that are at most normal *whatever* the distribution of d (Efron 1969,
//! "Student's t-test under symmetry conditions", JASA 64; Pinelis 1994, Annals of Probability 22). So fireflies make no
//! false alarms. Note Σd², not the scatter about the mean: a block of n pixels has no score above √n.
//!
//! With unequal sample counts, or of two estimators, d is skewed, and a block of the noisier image that missed its fireflies
//! has too small a scatter. Then a block has at least half the scatter of those around it, and where both images have
//! variances, what they announce for it, and half of what they announce around it. Of 200 pairs of 256 and 16 samples, five
//! scenes of caustics, many lights and sky, χ² had p below 6.7·10⁻⁵ in 11 of 600 channels without the neighbours and in none
//! with them. With equal counts χ² needs none: its mean p was 0.49.

use super::report::Blocks;
use rayon::prelude::*;

/// Where blocks are.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Pixels of a row of the image.
    width: usize,
    /// First pixel of each column of blocks, then the width.
    columns: Vec<usize>,
    /// First pixel of each row of blocks, then the height.
    rows: Vec<usize>,
}

impl Grid {
    /// Blocks of 16×16 pixels, of 8×8 where that would be fewer than 64; what is left over goes to the last.
    pub fn new(width: usize, height: usize) -> Self {
        let side = if width * height >= 64 * 16 * 16 {
            16
        } else {
            8
        };
        let cuts = |length: usize| {
            let count = (length / side).max(1);
            (0..count).map(|i| i * side).chain([length]).collect()
        };
        Self {
            width,
            columns: cuts(width),
            rows: cuts(height),
        }
    }

    /// How many blocks there are.
    pub fn count(&self) -> usize {
        (self.columns.len() - 1) * (self.rows.len() - 1)
    }

    /// x0, y0, x1, y1 of a block, within the data window.
    pub fn region(&self, block: usize) -> [usize; 4] {
        let across = self.columns.len() - 1;
        let (x, y) = (block % across, block / across);
        [
            self.columns[x],
            self.rows[y],
            self.columns[x + 1],
            self.rows[y + 1],
        ]
    }

    /// Sums of a plane over each block, in the order of its pixels.
    pub fn totals(&self, plane: &[f32]) -> Vec<f64> {
        let total = |block| {
            let [x0, y0, x1, y1] = self.region(block);
            let rows = (y0..y1).map(|y| &plane[y * self.width + x0..y * self.width + x1]);
            rows.flatten().map(|&x| f64::from(x)).sum()
        };
        (0..self.count()).into_par_iter().map(total).collect()
    }

    /// The scores of its blocks, for each channel.
    pub fn with_scores(&self, z: Vec<Vec<f64>>) -> Blocks {
        Blocks {
            columns: self.columns.clone(),
            rows: self.rows.clone(),
            z,
        }
    }

    /// The 3×3 blocks around one, those that exist.
    fn neighbours(&self, block: usize) -> impl Iterator<Item = usize> {
        let (across, down) = (self.columns.len() - 1, self.rows.len() - 1);
        let (x, y) = (block % across, block / across);
        let around = |i: usize, end: usize| i.saturating_sub(1)..(i + 2).min(end);
        around(y, down).flat_map(move |y| around(x, across).map(move |x| y * across + x))
    }
}

/// Sums over the pixels of a block.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    /// Pixels.
    pub pixels: f64,
    /// Σ reference.
    pub reference: f64,
    /// Σ test.
    pub test: f64,
    /// Σ |reference|.
    pub magnitude: f64,
    /// Σ d.
    pub difference: f64,
    /// Σ (d − its mean)².
    pub scatter: f64,
    /// What [`correlation`] is made of, for sub-blocks of 2×2 and of 4×4.
    groups: [Group; 2],
}

/// Squares of sums over sub-blocks against sums of squares.
#[derive(Clone, Copy, Debug, Default)]
struct Group {
    /// Σ over sub-blocks of (Σe)².
    of_sums: f64,
    /// Σ over sub-blocks of Σe².
    of_pixels: f64,
    /// Σ over sub-blocks of (Σe²)² − Σe⁴: half the variance of `of_sums` where signs are independent.
    spread: f64,
}

/// The sums of every block of the reference and the test image, pixels row after row.
pub fn sums(grid: &Grid, pair: [&[f32]; 2]) -> Vec<Sums> {
    (0..grid.count())
        .into_par_iter()
        .with_min_len(8)
        .map(|block| sums_of(grid, grid.region(block), pair))
        .collect()
}

fn sums_of(grid: &Grid, [x0, y0, x1, y1]: [usize; 4], pair: [&[f32]; 2]) -> Sums {
    let mut sums = Sums::default();
    let mut differences = Vec::with_capacity((x1 - x0) * (y1 - y0));
    for y in y0..y1 {
        let row = y * grid.width + x0..y * grid.width + x1;
        let [reference, test] = pair.map(|pixels| &pixels[row.clone()]);
        for (&a, &b) in reference.iter().zip(test) {
            let (a, b) = (f64::from(a), f64::from(b));
            sums.reference += a;
            sums.test += b;
            sums.magnitude += a.abs();
            differences.push(b - a);
        }
    }
    let width = x1 - x0;
    sums.pixels = differences.len() as f64;
    sums.difference = differences.iter().sum();
    let mean = sums.difference / sums.pixels;
    for d in &mut differences {
        *d -= mean;
        sums.scatter += *d * *d;
    }
    sums.groups = [2, 4].map(|side| group(&differences, width, side));
    sums
}

fn group(centred: &[f64], width: usize, side: usize) -> Group {
    let height = centred.len() / width;
    let mut group = Group::default();
    // A sub-block that is most of its block has no mean of its own.
    let n = centred.len() as f64;
    let own = (side * side) as f64;
    if own * 4.0 > n {
        return group;
    }
    // Both are about the block's mean: make each what it is about the true one.
    let (of_sums, of_pixels) = (1.0 / (1.0 - own / n), 1.0 / (1.0 - 1.0 / n));
    for y in (0..height - height % side).step_by(side) {
        for x in (0..width - width % side).step_by(side) {
            let (mut sum, mut squares, mut fourths) = (0.0, 0.0, 0.0);
            for row in y..y + side {
                for e in &centred[row * width + x..][..side] {
                    sum += e;
                    squares += e * e;
                    fourths += e * e * e * e;
                }
            }
            group.of_sums += of_sums * sum * sum;
            group.of_pixels += of_pixels * squares;
            group.spread += squares * squares - fourths;
        }
    }
    group
}

/// By how much neighbouring pixels that share their noise raise the variance of a block's mean; 1 where they do not.
/// Renderers that splat a sample into every pixel its filter reaches make such images.
///
/// A kernel separable in x and y raises that of the mean of m×m pixels by (a − b/m)² once m exceeds its width; a² is what
/// blocks see, from m = 2 and 4. A bias with edges, as of a lamp that is too dark, looks like that too, but in few blocks:
/// every block counts the same, and of the means of nine sets of blocks the median is taken.
///
/// A bias that is smooth all over looks like it as well. But then d is greater than its variances announce, where there are
/// any (`expected`), or blocks that are too far apart to share a filter go together, and nothing is raised. No filter raises
/// variances more than that of a Gaussian one pixel wide.
pub fn correlation(grid: &Grid, sums: &[Sums], expected: Option<&[f64]>) -> f64 {
    let scatter: f64 = sums.iter().map(|block| block.scatter).sum();
    let announced = expected.map(|blocks| blocks.iter().sum::<f64>());
    if announced.is_some_and(|announced| scatter > 2.0 * announced) || goes_on(grid, sums) {
        return 1.0;
    }
    shared(sums).min(WIDEST)
}

/// A Gaussian of a standard deviation of 1 pixel: 4π.
const WIDEST: f64 = 12.6;

/// Whether the means of blocks two apart in a row go together: no filter reaches so far.
fn goes_on(grid: &Grid, sums: &[Sums]) -> bool {
    let across = grid.columns.len() - 1;
    let (mut sum, mut squares) = (0.0, 0.0);
    for row in sums.chunks_exact(across) {
        for (a, b) in row.iter().zip(row.iter().skip(2)) {
            let product = a.difference * b.difference;
            sum += product;
            squares += product * product;
        }
    }
    sum > 3.5 * squares.sqrt()
}

/// The estimate from sub-blocks.
fn shared(sums: &[Sums]) -> f64 {
    const SETS: usize = 9;
    let median = |k: usize| {
        let mut sets = [Mean::default(); SETS];
        for (i, block) in sums.iter().enumerate() {
            sets[i % SETS].add(&block.groups[k]);
        }
        sets.sort_by(|a, b| a.value().total_cmp(&b.value()));
        sets[SETS / 2]
    };
    let (two, four) = (median(0), median(1));
    // Four standard deviations, those of a median: noise of this ratio itself is no reason to weaken the tests.
    let deviation = 1.25 * four.deviation() / (SETS as f64).sqrt();
    if four.value() <= 1.0 + 4.0 * deviation {
        return 1.0;
    }
    let limit = 2.0 * four.value().sqrt() - two.value().sqrt();
    (limit * limit).max(1.0)
}

/// The mean over blocks of how sums over sub-blocks compare with those of independent pixels.
#[derive(Clone, Copy, Default)]
struct Mean {
    blocks: f64,
    ratios: f64,
    variances: f64,
}

impl Mean {
    fn add(&mut self, group: &Group) {
        if group.of_pixels > 0.0 {
            self.blocks += 1.0;
            self.ratios += group.of_sums / group.of_pixels;
            self.variances += 2.0 * group.spread / (group.of_pixels * group.of_pixels);
        }
    }

    fn value(&self) -> f64 {
        match self.blocks > 0.0 {
            true => self.ratios / self.blocks,
            false => 1.0,
        }
    }

    fn deviation(&self) -> f64 {
        self.variances.sqrt() / self.blocks.max(1.0)
    }
}

/// The scatter by which each block is judged: its own where d is symmetric. Where it may be skewed, not less than half of
/// those around it, nor than what variances announce (`expected`), nor half of what they announce around it.
pub fn scatters(grid: &Grid, sums: &[Sums], expected: Option<&[f64]>, symmetric: bool) -> Vec<f64> {
    let own = |block: usize| sums[block].scatter;
    if symmetric {
        return (0..sums.len()).map(own).collect();
    }
    let announced = |block: usize| expected.map_or(0.0, |expected| expected[block]);
    (0..sums.len())
        .map(|block| {
            let around = |of: &dyn Fn(usize) -> f64| {
                let all = |of: &dyn Fn(usize) -> f64| grid.neighbours(block).map(of).sum::<f64>();
                sums[block].pixels * all(of) / all(&|i| sums[i].pixels)
            };
            let least = 0.5 * around(&own).max(around(&announced));
            own(block).max(announced(block)).max(least)
        })
        .collect()
}

/// Σd over √Σd²: a normal score where d is as often positive as negative.
///
/// `sum` is Σd, `scatter` Σ(d − its mean)², `pixels` their number, `correlation` by how much the variance of a mean is raised.
pub fn self_normalised(sum: f64, scatter: f64, pixels: f64, correlation: f64) -> f64 {
    if sum == 0.0 {
        return 0.0;
    }
    sum / (correlation * (scatter + sum * sum / pixels)).sqrt()
}

/// `sum` moved towards 0 by what is tolerated.
pub fn beyond(sum: f64, tolerated: f64) -> f64 {
    (sum.abs() - tolerated).max(0.0).copysign(sum)
}
