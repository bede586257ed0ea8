//! Rays that keep together: as one bundle against eight boxes, then each against one triangle after another.

use super::build::MARGIN;
use super::bundle::Bundle;
use super::node::{Block, Link, compress, unpack};
use super::slot::FARTHEST;
use super::triangle::{ShearX8, meet_triangle, meet_triangle_mixed};
use super::{Bvh, Hit, RayX8, Root};
use crate::lanes::{WIDTH, f32x8, reduce, u32x8};

/// Entries of a bundle's stack.
const STACK: usize = 8 * super::build::MAX_DEPTH + 2 * WIDTH;

/// The memory of one worker.
#[derive(Clone, Debug)]
pub(super) struct PacketStack {
    links: [u32; STACK],
    distances: [f32; STACK],
}

impl Default for PacketStack {
    fn default() -> Self {
        Self {
            links: [0; STACK],
            distances: [0.0; STACK],
        }
    }
}

/// What the rays of a packet have met.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    pub distance: f32x8,
    pub triangle: u32x8,
    /// Lanes that met anything.
    pub found: f32x8,
}

impl Met {
    pub fn nothing(farthest: f32x8) -> Self {
        Self {
            distance: farthest,
            triangle: u32x8::ZERO,
            found: f32x8::ZERO,
        }
    }

    /// What each ray has met.
    #[inline(always)]
    pub fn hits(&self) -> [Option<Hit>; WIDTH] {
        let found = self.found.to_bitmask();
        let (distances, triangles) = (self.distance.to_array(), self.triangle.to_array());
        std::array::from_fn(|lane| {
            (found >> lane & 1 == 1).then_some(Hit {
                distance: distances[lane],
                triangle: triangles[lane],
                instance: 0,
            })
        })
    }

    /// Takes note of a triangle that rays may have met.
    #[inline(always)]
    fn add<const ANY: bool>(&mut self, triangle: u32x8, t: f32x8, inside: f32x8, rays: &RayX8) {
        let mut hit = inside & t.simd_gt(rays.nearest);
        if ANY {
            let ignored = f32x8::from_bits(triangle.simd_eq(rays.ignored));
            hit &= t.simd_lt(rays.farthest) & !ignored;
        } else {
            let lower = f32x8::from_bits(triangle.simd_lt(self.triangle));
            hit &= t.simd_lt(self.distance) | (t.simd_eq(self.distance) & lower);
            self.distance = hit.select(t, self.distance);
            self.triangle = hit.select(triangle, self.triangle);
        }
        self.found |= hit;
    }
}

/// Tests the triangles in some lanes of a block, for rays whose greatest axis is `AXIS`.
///
/// Whether a triangle was met by any ray is not asked: nobody could predict the answer.
#[inline(always)]
fn test<const ANY: bool, const N: usize, const AXIS: usize>(
    block: &Block,
    mut lanes: u32,
    rays: &[RayX8; N],
    shears: &[ShearX8; N],
    met: &mut [Met; N],
) {
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize & 7;
        lanes &= lanes - 1;
        let triangle = u32x8::splat(block.triangles.as_array()[lane]);
        for ((shear, rays), met) in shears.iter().zip(rays).zip(met.iter_mut()) {
            let (t, inside) = meet_triangle::<AXIS>(block, lane, shear);
            met.add::<ANY>(triangle, t, inside, rays);
        }
    }
}

impl Bvh {
    /// Traces a packet from the root of a mesh; the bundle holds all its rays.
    #[inline(always)]
    pub(super) fn trace_packet<const ANY: bool, const N: usize>(
        &self,
        bundle: &Bundle,
        rays: &[RayX8; N],
        shears: &[ShearX8; N],
        root: &Root,
        stack: &mut PacketStack,
    ) -> [Met; N] {
        let mut met = rays.each_ref().map(|rays| Met::nothing(rays.farthest));
        let least = |a: f32x8, rays: &RayX8| a.fast_min(rays.nearest);
        let nearest = rays[1..].iter().fold(rays[0].nearest, least);
        let nearest = reduce(nearest, f32x8::fast_min);
        let most = |a: f32x8, rays: &RayX8| a.fast_max(rays.farthest);
        let farthest = rays[1..].iter().fold(rays[0].farthest, most);
        let mut best = reduce(farthest, f32x8::fast_max).to_array()[0].min(FARTHEST);
        let wider = f32x8::splat(root.reach * MARGIN);
        let mut link = root.link;
        let mut top = 0;
        loop {
            match link.kind() {
                Link::NODE => {
                    let node = &self.nodes[link.index()];
                    let (hit, enter) = bundle.enter(&node.planes, nearest, f32x8::splat(best));
                    let packed = node.order[bundle.octant()];
                    let order = unpack(packed);
                    let mask = hit.shuffle_wrapping(order).to_bitmask() & packed >> 24;
                    let order = order.shuffle_wrapping(compress(mask));
                    let links = node.children.shuffle_wrapping(order).to_array();
                    let distances = enter.shuffle_wrapping(order).to_array();
                    stack.links[top..top + WIDTH].copy_from_slice(&links);
                    stack.distances[top..top + WIDTH].copy_from_slice(&distances);
                    top += mask.count_ones() as usize;
                }
                _ => {
                    let block = &self.blocks[link.index()];
                    let (touched, _) =
                        bundle.enter(&block.planes(wider), nearest, f32x8::splat(best));
                    let lanes = touched.to_bitmask() & block.live();
                    match bundle.axis() {
                        0 => test::<ANY, N, 0>(block, lanes, rays, shears, &mut met),
                        1 => test::<ANY, N, 1>(block, lanes, rays, shears, &mut met),
                        _ => test::<ANY, N, 2>(block, lanes, rays, shears, &mut met),
                    }
                    if !ANY {
                        let all = met[1..].iter().map(|met| met.distance);
                        let all = all.fold(met[0].distance, f32x8::fast_max);
                        best = reduce(all, f32x8::fast_max).to_array()[0].min(FARTHEST);
                    } else if met.iter().all(|met| met.found.all()) {
                        return met;
                    }
                }
            }
            loop {
                if top == 0 {
                    return met;
                }
                top -= 1;
                if stack.distances[top] <= best {
                    break;
                }
            }
            link = Link(stack.links[top]);
        }
    }

    /// Tests every triangle: where there are few, and rays keep together in no way, no tree is quicker.
    #[inline(never)]
    pub(super) fn trace_few<const ANY: bool>(&self, rays: &RayX8, shear: &ShearX8) -> Met {
        let mut met = Met::nothing(rays.farthest);
        for block in &self.blocks {
            for lane in 0..block.len() {
                let (t, inside) = meet_triangle_mixed(block, lane, shear);
                let triangle = u32x8::splat(block.triangles.as_array()[lane]);
                met.add::<ANY>(triangle, t, inside, rays);
            }
        }
        met
    }
}
