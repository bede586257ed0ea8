//! Rays that keep together: eight at once, as one bundle against eight boxes, then each against one triangle after another.
//!
//! Intervals hold the bundle's origins and slopes (Boulos, Wald & Shirley 2006, "Geometric and Arithmetic Culling Methods
//! for Entire Ray Packets"), so that a node is met once for all eight. What it saves in the tree it loses to triangles that
//! no ray meets, the more the wider the bundle is: rays that do not keep together are not taken.

use super::build::MARGIN;
use super::node::{Block, Link, compress, unpack};
use super::ray::RaysX8;
use super::slot::{FAR, FARTHEST, WIDEN};
use super::triangle::{AXES, ShearX8, meet_triangle, meet_triangle_mixed};
use super::{Bvh, Root};
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

/// The least component of directions that all run the same way along an axis.
const STEEP: f32 = 1e-6;

/// An axis along which all rays of a bundle run the same way: their planes' distances are `plane · slope + offset`, for the
/// least slope and the greatest.
#[derive(Clone, Copy, Default)]
struct Slab {
    /// Places of the near and the far plane in a node.
    near: usize,
    far: usize,
    slopes: [f32; 2],
    near_offsets: [f32; 2],
    far_offsets: [f32; 2],
}

/// An axis along which some rays run one way, and some the other: where they are at most by a distance.
#[derive(Clone, Copy, Default)]
struct Fan {
    axis: usize,
    low: f32,
    low_speed: f32,
    high: f32,
    high_speed: f32,
}

/// Rays that keep together, one batch or several, as a bundle.
pub(super) struct Packet {
    slabs: [Slab; 3],
    slab_count: usize,
    fans: [Fan; 3],
    fan_count: usize,
    axes: [usize; 3],
    octant: usize,
}

/// What the rays of a packet have met.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    pub distance: f32x8,
    pub triangle: u32x8,
    /// Lanes that met anything.
    pub found: f32x8,
}

/// The least and the greatest of each.
#[inline(always)]
fn extremes(values: [f32x8; WIDTH]) -> ([f32; WIDTH], [f32; WIDTH]) {
    let [a, b, c, d, e, f, g, h] = f32x8::transpose(values);
    let of = |best: fn(f32x8, f32x8) -> f32x8| {
        let (ab, cd, ef, gh) = (best(a, b), best(c, d), best(e, f), best(g, h));
        best(best(ab, cd), best(ef, gh)).to_array()
    };
    (of(f32x8::fast_min), of(f32x8::fast_max))
}

impl Packet {
    /// The rays as a bundle, if they keep together: their slopes are at most `spread` apart. `reach` is the tree's.
    #[inline(always)]
    pub fn new<const N: usize>(
        rays: &[RaysX8; N],
        shears: &[ShearX8; N],
        reach: f32,
        spread: f32,
    ) -> Option<Self> {
        let axis = shears[0].common_axis()?;
        if shears[1..]
            .iter()
            .any(|shear| shear.common_axis() != Some(axis))
        {
            return None;
        }
        let (mut low, mut high) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        for (rays, shear) in rays.iter().zip(shears) {
            let (o, d) = (&rays.origin, &rays.direction);
            let [across, along] = [shear.slopes[0], shear.slopes[1]];
            let (least, greatest) = extremes([o.x, o.y, o.z, d.x, d.y, d.z, across, along]);
            for value in 0..WIDTH {
                low[value] = low[value].min(least[value]);
                high[value] = high[value].max(greatest[value]);
            }
        }
        let far = FAR * reach;
        let near = |axis: usize| low[axis] >= -far && high[axis] <= far;
        let close = |slope: usize| high[slope] - low[slope] <= spread;
        if !(near(0) && near(1) && near(2) && close(6) && close(7)) {
            return None;
        }
        let mut packet = Self {
            slabs: [Slab::default(); 3],
            slab_count: 0,
            fans: [Fan::default(); 3],
            fan_count: 0,
            axes: AXES[axis],
            octant: shears[0].octant.as_array()[0] as usize,
        };
        for axis in 0..3 {
            let speeds = [low[axis + 3], high[axis + 3]];
            let (low, high) = (low[axis], high[axis]);
            // Slopes that f32 can tell from those of parallel rays.
            if speeds[0] > STEEP || speeds[1] < -STEEP {
                let slopes = [1.0 / speeds[1], 1.0 / speeds[0]];
                let backwards = speeds[1] < 0.0;
                let (for_near, for_far) = if backwards { (low, high) } else { (high, low) };
                let (near, far) = if backwards {
                    (axis + 3, axis)
                } else {
                    (axis, axis + 3)
                };
                packet.slabs[packet.slab_count] = Slab {
                    near,
                    far,
                    slopes,
                    near_offsets: slopes.map(|slope| -(for_near * slope)),
                    far_offsets: slopes.map(|slope| -(for_far * slope)),
                };
                packet.slab_count += 1;
            } else {
                packet.fans[packet.fan_count] = Fan {
                    axis,
                    low,
                    low_speed: speeds[0].min(0.0),
                    high,
                    high_speed: speeds[1].max(0.0),
                };
                packet.fan_count += 1;
            }
        }
        // A fan needs a slab to end at.
        (packet.slab_count > 0).then_some(packet)
    }

    /// The boxes that any of the rays may meet, as a mask, and how far they are at least.
    #[inline(always)]
    fn enter(&self, planes: &[f32x8; 6], nearest: f32x8, best: f32x8) -> (f32x8, f32x8) {
        let mut enter = nearest;
        let mut leave = best;
        let splat = f32x8::splat;
        for slab in &self.slabs[..self.slab_count] {
            let (near, far) = (planes[slab.near], planes[slab.far]);
            let [least, greatest] = slab.slopes.map(splat);
            let a = near.mul_add(least, splat(slab.near_offsets[0]));
            let b = near.mul_add(greatest, splat(slab.near_offsets[1]));
            enter = enter.fast_max(a.fast_min(b));
            let a = far.mul_add(least, splat(slab.far_offsets[0]));
            let b = far.mul_add(greatest, splat(slab.far_offsets[1]));
            leave = leave.fast_min(a.fast_max(b));
        }
        let leave = leave * splat(WIDEN);
        let mut hit = enter.simd_le(leave);
        for fan in &self.fans[..self.fan_count] {
            let low = splat(fan.low_speed).mul_add(leave, splat(fan.low));
            let high = splat(fan.high_speed).mul_add(leave, splat(fan.high));
            hit &= low.simd_le(planes[fan.axis + 3]) & high.simd_ge(planes[fan.axis]);
        }
        (hit, enter)
    }
}

impl Met {
    pub fn nothing(farthest: f32x8) -> Self {
        Self {
            distance: farthest,
            triangle: u32x8::ZERO,
            found: f32x8::ZERO,
        }
    }

    /// Takes note of a triangle that rays may have met.
    #[inline(always)]
    fn add<const ANY: bool>(&mut self, triangle: u32x8, t: f32x8, inside: f32x8, rays: &RaysX8) {
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

impl Bvh {
    /// Traces a packet from the root of a mesh.
    #[inline(always)]
    pub(super) fn trace_packet<const ANY: bool, const N: usize>(
        &self,
        packet: &Packet,
        rays: &[RaysX8; N],
        shears: &[ShearX8; N],
        root: &Root,
        stack: &mut PacketStack,
    ) -> [Met; N] {
        let mut met = rays.each_ref().map(|rays| Met::nothing(rays.farthest));
        let of = |get: fn(&RaysX8) -> f32x8, best: fn(f32x8, f32x8) -> f32x8| {
            reduce(rays[1..].iter().map(get).fold(get(&rays[0]), best), best).to_array()[0]
        };
        let nearest = f32x8::splat(of(|rays| rays.nearest, f32x8::fast_min));
        let mut best = of(|rays| rays.farthest, f32x8::fast_max).min(FARTHEST);
        let wider = f32x8::splat(root.reach * MARGIN);
        let mut link = root.link;
        let mut top = 0;
        loop {
            match link.kind() {
                Link::NODE => {
                    let node = &self.nodes[link.index()];
                    let (hit, enter) = packet.enter(&node.planes, nearest, f32x8::splat(best));
                    let packed = node.order[packet.octant & 7];
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
                        packet.enter(&block.planes(wider), nearest, f32x8::splat(best));
                    let mut lanes = touched.to_bitmask() & block.live();
                    while lanes != 0 {
                        let lane = lanes.trailing_zeros() as usize & 7;
                        lanes &= lanes - 1;
                        let triangle = u32x8::splat(block.triangles.as_array()[lane]);
                        for ((shear, rays), met) in shears.iter().zip(rays).zip(&mut met) {
                            let (t, inside) = meet_triangle(block, lane, shear, packet.axes);
                            if inside.any() {
                                met.add::<ANY>(triangle, t, inside, rays);
                            }
                        }
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

    /// Tests every triangle: where there are few, no tree is quicker.
    #[inline(always)]
    pub(super) fn trace_few<const ANY: bool>(&self, rays: &RaysX8, shear: &ShearX8) -> Met {
        let mut met = Met::nothing(rays.farthest);
        match shear.common_axis() {
            Some(axis) => {
                let axes = AXES[axis];
                self.each::<ANY>(rays, &mut met, |block, lane| {
                    meet_triangle(block, lane, shear, axes)
                });
            }
            None => self.each::<ANY>(rays, &mut met, |block, lane| {
                meet_triangle_mixed(block, lane, shear)
            }),
        }
        met
    }

    #[inline(always)]
    fn each<const ANY: bool>(
        &self,
        rays: &RaysX8,
        met: &mut Met,
        meet: impl Fn(&Block, usize) -> (f32x8, f32x8),
    ) {
        for block in &self.blocks {
            for lane in 0..block.len() {
                let (t, inside) = meet(block, lane);
                let triangle = u32x8::splat(block.triangles.as_array()[lane]);
                met.add::<ANY>(triangle, t, inside, rays);
            }
        }
    }
}
