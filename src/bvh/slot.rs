//! A ray of the stream: what its tests read, its stack, and the steps that it takes.

use super::node::{Block, Link, Node, compress, unpack};
use super::ready::{PARTINGS, Ready, SlabsX8};
use super::triangle::{self, Shear, ShearX8};
use super::{Hit, NO_TRIANGLE, Place, RayX8};
use crate::lanes::{Vec3x8, WIDTH, f32x8, reduce, u32x8};
use glam::Vec3;

/// Entries of a ray's stack: seven stay behind at each level, of the upper tree and of the lower.
const STACK: usize = BOTTOM + PARTINGS + 2 * 8 * super::build::MAX_DEPTH + WIDTH;
/// Entries below the first, so that eight can be read from any top.
const BOTTOM: usize = WIDTH;

/// A ray under way.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Slot {
    slabs: Slabs,
    shear: Shear,
    own: Own,
    /// One more than instance and triangle of the best hit, in this order; 0 where there is none yet.
    key: u64,
    /// Which instance the ray is in.
    instance: u32,
    /// The next place.
    pub link: Link,
    top: u32,
    links: [u32; STACK],
    distances: [f32; STACK],
}

/// What the box test reads of a ray.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(super) struct Slabs {
    /// 1 / direction.
    pub inverse: [f32; 3],
    /// The distance of plane p is p · inverse + offset.
    pub offset: [f32; 3],
    pub nearest: f32,
    /// Distance of the best hit so far.
    pub best: f32,
}

/// What a ray is in the world, and who it is.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(super) struct Own {
    pub origin: [f32; 3],
    pub direction: [f32; 3],
    /// Triangle of instance 0 that is not met.
    pub ignored: u32,
    /// Number of the ray among all.
    pub number: u32,
}

/// What distances of far planes are raised by: Ize 2013, "Robust BVH Ray Traversal", JCGT 2.2, section 3.
pub(super) const WIDEN: f32 = 1.0 + 4.0 * f32::EPSILON;
/// Distances count up to here: what an empty lane gives is beyond.
pub(super) const FARTHEST: f32 = 1e37;

impl Slot {
    /// One without a ray.
    pub fn idle() -> Self {
        Self {
            slabs: Slabs::default(),
            shear: Shear::default(),
            own: Own::default(),
            key: 0,
            instance: 0,
            link: Link::DONE,
            top: 0,
            links: [Link::DONE.0; STACK],
            distances: [f32::NEG_INFINITY; STACK],
        }
    }

    /// Takes one of eight rays to where they part.
    #[inline(always)]
    pub fn start<const ANY: bool>(&mut self, ready: &Ready, lane: usize) {
        self.slabs = ready.slabs[lane];
        self.shear = ready.shears[lane];
        self.own = ready.own[lane];
        self.key = 0;
        self.instance = 0;
        self.links[BOTTOM - 1] = Link::DONE.0;
        self.distances[BOTTOM - 1] = f32::NEG_INFINITY;
        let mut top = BOTTOM;
        let best = f32x8::splat(self.slabs.best);
        for (links, distances) in ready.links.iter().zip(&ready.distances).take(ready.groups) {
            let distances = distances[lane];
            let mask = distances.simd_le(best).to_bitmask();
            let order = compress(mask);
            let links = links.shuffle_wrapping(order).to_array();
            self.links[top..top + WIDTH].copy_from_slice(&links);
            if !ANY {
                let distances = distances.shuffle_wrapping(order).to_array();
                self.distances[top..top + WIDTH].copy_from_slice(&distances);
            }
            top += mask.count_ones() as usize;
        }
        self.top = top as u32;
        self.pop::<ANY>();
    }

    /// Turns to another space.
    fn aim(&mut self, origin: Vec3, direction: Vec3, reach: f32) {
        let (origin, direction) = (Vec3x8::splat(origin), Vec3x8::splat(direction));
        let rays = RayX8 {
            origin,
            direction,
            nearest: f32x8::splat(self.slabs.nearest),
            farthest: f32x8::splat(self.slabs.best),
            ignored: u32x8::splat(self.own.ignored),
        };
        [self.slabs, ..] = SlabsX8::new(&rays, reach).lanes();
        [self.shear, ..] = ShearX8::new(&origin, &direction).lanes();
    }

    /// The number of the ray among all.
    pub fn number(&self) -> usize {
        self.own.number as usize
    }

    /// What it has met.
    pub fn hit(&self) -> Option<Hit> {
        let key = self.key.checked_sub(1)?;
        Some(Hit {
            distance: self.slabs.best,
            triangle: key as u32,
            instance: (key >> 32) as u32,
        })
    }

    /// Goes into an instance's space, and to the root of its mesh.
    pub fn enter_instance(&mut self, place: &Place) {
        let origin = place.to_object.transform_point3(self.own.origin.into());
        let direction = place.to_object.transform_vector3(self.own.direction.into());
        self.aim(origin, direction, place.reach);
        self.instance = place.instance;
        self.push(Link::LEAVE, f32::NEG_INFINITY);
        self.link = place.root;
    }

    /// Comes back to the world, whose tree has this reach.
    pub fn leave_instance(&mut self, reach: f32) {
        let own = self.own;
        self.aim(own.origin.into(), own.direction.into(), reach);
    }

    /// Takes the next place from the stack; [`Link::STALE`] where that is out of reach.
    #[inline(always)]
    pub fn pop<const ANY: bool>(&mut self) {
        let top = (self.top - 1) as usize;
        self.top = top as u32;
        if ANY {
            // All bits on is the end.
            self.link = Link(self.links[top] | (self.key as u32).wrapping_neg());
            return;
        }
        // Floats that are not negative are in the order of their bits, and so is −∞ below them. Written as a comparison this
        // becomes a branch that nobody can predict.
        let beyond = self.slabs.best.to_bits() as i32 - self.distances[top].to_bits() as i32;
        self.link = Link(self.links[top] | ((beyond >> 31) as u32 & Link::STALE.0));
    }

    /// The same, but the next that is within reach, looked for eight at a time.
    #[inline(always)]
    pub fn pop_within(&mut self) {
        let mut top = self.top as usize;
        loop {
            let below = top - BOTTOM;
            let distances = f32x8::new(self.distances[below..top].try_into().expect("eight"));
            let within = distances
                .simd_le(f32x8::splat(self.slabs.best))
                .to_bitmask();
            if within != 0 {
                top = below + (31 - within.leading_zeros() as usize);
                self.top = top as u32;
                self.link = Link(self.links[top]);
                return;
            }
            top = below;
        }
    }

    #[inline(always)]
    fn push(&mut self, link: Link, distance: f32) {
        self.links[self.top as usize] = link.0;
        self.distances[self.top as usize] = distance;
        self.top += 1;
    }

    /// Meets the children of a node: those that are hit go onto the stack, the nearest last.
    #[inline(always)]
    pub fn enter<const ANY: bool>(&mut self, node: &Node) {
        let slabs = &self.slabs;
        let splat = f32x8::splat;
        let slab = |axis: usize| {
            let (inverse, offset) = (splat(slabs.inverse[axis]), splat(slabs.offset[axis]));
            let low = node.planes[axis].mul_add(inverse, offset);
            let high = node.planes[axis + 3].mul_add(inverse, offset);
            (low.fast_min(high), low.fast_max(high))
        };
        let (x, y, z) = (slab(0), slab(1), slab(2));
        let enter =
            x.0.fast_max(y.0)
                .fast_max(z.0.fast_max(splat(slabs.nearest)));
        let leave = x.1.fast_min(y.1).fast_min(z.1.fast_min(splat(slabs.best)));
        let hit = enter.simd_le(leave * splat(WIDEN));
        let packed = node.order[(self.shear.octant & 7) as usize];
        // The upper eight bits say which places hold children.
        let live = packed >> 24;
        let top = self.top as usize;
        if ANY {
            // Whichever is met first will do. Children fill the lower lanes.
            let mask = hit.to_bitmask() & live;
            let links = node.children.shuffle_wrapping(compress(mask)).to_array();
            self.links[top..top + WIDTH].copy_from_slice(&links);
            self.top = top as u32 + mask.count_ones();
            return;
        }
        let order = unpack(packed);
        let mask = hit.shuffle_wrapping(order).to_bitmask() & live;
        let order = order.shuffle_wrapping(compress(mask));
        let links = node.children.shuffle_wrapping(order).to_array();
        let distances = enter.shuffle_wrapping(order).to_array();
        self.links[top..top + WIDTH].copy_from_slice(&links);
        self.distances[top..top + WIDTH].copy_from_slice(&distances);
        self.top = top as u32 + mask.count_ones();
    }

    /// Meets the triangles of a block.
    #[inline(always)]
    pub fn test<const ANY: bool>(&mut self, block: &Block) {
        let splat = f32x8::splat;
        let (t, mut met) = triangle::meet_block(block, &self.shear);
        let best = splat(self.slabs.best);
        met &= t.simd_gt(splat(self.slabs.nearest));
        if ANY {
            let ignored = if self.instance == 0 {
                self.own.ignored
            } else {
                NO_TRIANGLE
            };
            let ignored = block.triangles.simd_eq(u32x8::splat(ignored));
            met &= t.simd_lt(best) & !f32x8::from_bits(ignored);
            self.key |= u64::from(met.any());
            return;
        }
        met &= t.simd_le(best);
        let t = met.select(t, splat(f32::INFINITY));
        let m = reduce(t, f32x8::fast_min);
        let nearest = m.to_array()[0];
        // Triangles of a block ascend: of several at one distance the first counts.
        let lane = t.simd_eq(m).to_bitmask().trailing_zeros() as usize & 7;
        let triangle = block.triangles.as_array()[lane];
        let key = (u64::from(self.instance) << 32 | u64::from(triangle)) + 1;
        // Distances are positive, and so in the order of their bits.
        let rank = |t: f32, key: u64| u128::from(t.to_bits()) << 64 | u128::from(key);
        let first = rank(nearest, key).min(rank(self.slabs.best, self.key));
        self.slabs.best = f32::from_bits((first >> 64) as u32);
        self.key = first as u64;
    }
}
