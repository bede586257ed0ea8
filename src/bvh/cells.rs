//! Rays that begin near each other and do not keep together, sorted by where they go: those of one cell are a bundle again.
//!
//! It serves where triangles are few and boxes large. In a tree of many, rays of a cell part before they have met much.

use super::bundle::{Bundle, Extent};
use super::packet::PacketStack;
use super::triangle::ShearX8;
use super::{Bvh, Hit, RayX8, Root};
use crate::lanes::{Batch, WIDTH, u32x8};

/// Cells of directions: three greatest axes, eight octants.
const CELLS: usize = 3 * 8;

/// Rays by cell, each cell until it has eight.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells([Cell; CELLS]);

#[derive(Clone, Debug, Default)]
pub(super) struct Cell {
    rays: RayX8,
    /// Numbers of the rays among all.
    numbers: [u32; WIDTH],
    len: usize,
}

impl Cells {
    /// Adds eight rays, the first of this number, and gives `full` each cell that has eight.
    #[inline(always)]
    pub fn add(
        &mut self,
        rays: &RayX8,
        shear: &ShearX8,
        first: usize,
        mut full: impl FnMut(&mut Cell),
    ) {
        let cells: u32x8 = shear.axis << 3 | shear.octant;
        for (lane, cell) in cells.to_array().into_iter().enumerate() {
            let cell = &mut self.0[(cell as usize).min(CELLS - 1)];
            // A full cell has been emptied: the mask spares a check for each number of the ray.
            let place = cell.len & (WIDTH - 1);
            cell.rays.set_lane(place, rays.lane(lane));
            cell.numbers[place] = (first + lane) as u32;
            cell.len = place + 1;
            if cell.len == WIDTH {
                full(cell);
            }
        }
    }
    /// Gives `full` each cell that still has rays.
    pub fn flush(&mut self, full: impl FnMut(&mut Cell)) {
        self.0.iter_mut().filter(|cell| cell.len > 0).for_each(full);
    }
}

impl Cell {
    /// Traces the rays, gives `done` the number and hit of each, and is empty again.
    #[inline(never)]
    pub fn trace<const ANY: bool>(
        &mut self,
        bvh: &Bvh,
        root: &Root,
        stack: &mut PacketStack,
        mut done: impl FnMut(usize, Option<Hit>),
    ) {
        for lane in self.len..WIDTH {
            self.rays.set_lane(lane, self.rays.lane(0));
        }
        let rays = [self.rays];
        let shears = [ShearX8::new(&rays[0].origin, &rays[0].direction)];
        let bundle = shears[0].common_axis();
        let bundle =
            bundle.and_then(|_| Bundle::new(&Extent::of(&rays[0], &shears[0]), &shears[0]));
        let met = match bundle {
            Some(bundle) => bvh.trace_packet::<ANY, 1>(&bundle, &rays, &shears, root, stack)[0],
            None => bvh.trace_few::<ANY>(&rays[0], &shears[0]),
        };
        let hits = met.hits();
        for (&number, hit) in self.numbers.iter().zip(hits).take(self.len) {
            done(number as usize, hit);
        }
        self.len = 0;
    }
}
