//! Many rays at once, one ray against eight boxes or eight triangles at a time.
//!
//! A ray by itself leaves a processor idle: each step waits for the last, and whether a box was hit, or the next place is a
//! leaf, is anybody's guess. Here some dozens of rays are under way. All whose next place is a node take a step, then all
//! whose next place is a leaf; what is next goes to one list or another without a branch, and the memory of the next place
//! is asked for a whole round before it is read.

use super::node::{Block, Link, Node, compress, unpack};
use super::packet::PacketStack;
use super::triangle::{self, Shear, ShearX8};
use super::{Bvh, Hit, NO_TRIANGLE, Place, Rays, Root, prefetch};
use crate::lanes::{Vec3x8, WIDTH, f32x8, reduce, u32x8};
use glam::Vec3;

/// Rays under way; a power of two.
pub(super) const SLOTS: usize = 32;

/// Entries of a ray's stack: seven stay behind at each level, of the upper tree and of the lower.
const STACK: usize = BOTTOM + 2 * 8 * super::build::MAX_DEPTH + WIDTH;
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
    link: Link,
    top: u32,
    links: [u32; STACK],
    distances: [f32; STACK],
}

/// What the box test reads of a ray.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
struct Slabs {
    /// 1 / direction.
    inverse: [f32; 3],
    /// The distance of plane p is p · inverse + offset.
    offset: [f32; 3],
    nearest: f32,
    /// Distance of the best hit so far.
    best: f32,
}

/// What a ray is in the world, and who it is.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
struct Own {
    origin: [f32; 3],
    direction: [f32; 3],
    /// Triangle of instance 0 that is not met.
    ignored: u32,
    /// Number of the ray among all.
    number: u32,
}

/// One worker's memory while it traces. Nothing in it is shared.
#[derive(Clone, Debug)]
pub struct Stacks {
    pub(super) slots: Box<[Slot; SLOTS]>,
    pub(super) packet: PacketStack,
    /// Batches of rays that do not keep together.
    pub(super) loose: Vec<u32>,
}

impl Default for Stacks {
    fn default() -> Self {
        let slot = Slot {
            slabs: Slabs::default(),
            shear: Shear::default(),
            own: Own::default(),
            key: 0,
            instance: 0,
            link: Link::DONE,
            top: 0,
            links: [Link::DONE.0; STACK],
            distances: [f32::NEG_INFINITY; STACK],
        };
        let slots = vec![slot; SLOTS].into_boxed_slice();
        Self {
            slots: slots.try_into().expect("as many as were made"),
            packet: PacketStack::default(),
            loose: Vec::new(),
        }
    }
}

/// Eight rays to be traced.
#[derive(Clone, Copy, Debug)]
pub(super) struct RaysX8 {
    pub origin: Vec3x8,
    pub direction: Vec3x8,
    pub nearest: f32x8,
    pub farthest: f32x8,
    pub ignored: u32x8,
}

impl RaysX8 {
    #[inline(always)]
    pub fn new(rays: &impl Rays, farthest: f32x8, ignored: Option<u32x8>) -> Self {
        Self {
            origin: *rays.origin(),
            direction: *rays.direction(),
            // Not −0: its bits are below all others.
            nearest: rays.nearest() + f32x8::ZERO,
            farthest,
            ignored: ignored.unwrap_or(u32x8::splat(NO_TRIANGLE)),
        }
    }

    /// Whether no origin is far from a tree of this reach.
    #[inline(always)]
    pub fn begins_near(&self, reach: f32) -> bool {
        let near = self.origin.max_abs().simd_le(f32x8::splat(FAR * reach));
        near.all()
    }
}

/// What distances of far planes are raised by: Ize 2013, "Robust BVH Ray Traversal", JCGT 2.2, section 3.
pub(super) const WIDEN: f32 = 1.0 + 4.0 * f32::EPSILON;
/// The least component of a direction, relative to its greatest: below it the ray is parallel to the planes.
const PARALLEL: f32 = 1e-12;
/// Distances count up to here: what an empty lane gives is beyond.
pub(super) const FARTHEST: f32 = 1e37;

/// Eight rays, made ready.
struct Ready {
    slabs: [Slabs; WIDTH],
    shears: [Shear; WIDTH],
    own: [Own; WIDTH],
}

impl Ready {
    fn new(rays: &RaysX8, first: usize, reach: f32) -> Self {
        let Vec3x8 { x, y, z } = rays.direction;
        let greatest = rays.direction.max_abs();
        let least = greatest * f32x8::splat(PARALLEL);
        let inverse = [x, y, z].map(|d| f32x8::ONE / d.abs().fast_max(least).copysign(d));
        let Vec3x8 { x, y, z } = rays.origin;
        let mut offset = std::array::from_fn(|axis| -([x, y, z][axis] * inverse[axis]));
        let beyond = rays.origin.max_abs().simd_gt(f32x8::splat(FAR * reach));
        if beyond.any() {
            let skip = (rays.origin.max_abs() - f32x8::splat(reach)) / greatest;
            let origin = rays.direction.mul_add(skip, rays.origin);
            let Vec3x8 { x, y, z } = origin;
            for axis in 0..3 {
                let near = [x, y, z][axis].mul_neg_add(inverse[axis], skip);
                offset[axis] = beyond.select(near, offset[axis]);
            }
        }
        let [a, b, c] = inverse;
        let [d, e, f] = offset;
        let best = rays.farthest.fast_min(f32x8::splat(FARTHEST));
        let slabs = f32x8::transpose([a, b, c, d, e, f, rays.nearest, best]).map(|row| {
            let [a, b, c, d, e, f, nearest, best] = row.to_array();
            Slabs {
                inverse: [a, b, c],
                offset: [d, e, f],
                nearest,
                best,
            }
        });
        let (o, d) = (&rays.origin, &rays.direction);
        let number = u32x8::splat(first as u32) + u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
        let bits = |word: u32x8| f32x8::from_bits(word);
        let own = [
            o.x,
            o.y,
            o.z,
            d.x,
            d.y,
            d.z,
            bits(rays.ignored),
            bits(number),
        ];
        let own = f32x8::transpose(own).map(|row| {
            let [a, b, c, d, e, f, ignored, number] = row.to_array();
            Own {
                origin: [a, b, c],
                direction: [d, e, f],
                ignored: ignored.to_bits(),
                number: number.to_bits(),
            }
        });
        Self {
            slabs,
            shears: ShearX8::new(o, d).lanes(),
            own,
        }
    }
}

/// Origins farther than so many times the tree's reach are moved along their ray for the box test, or its rounding errors
/// would be those of the origin: of nearer ones the [`Node`]s' margin and [`WIDEN`] together cover the errors.
pub(super) const FAR: f32 = 3.0;

impl Slot {
    /// Turns to another space.
    fn aim(&mut self, origin: Vec3, direction: Vec3, reach: f32) {
        let rays = RaysX8 {
            origin: Vec3x8::splat(origin),
            direction: Vec3x8::splat(direction),
            nearest: f32x8::splat(self.slabs.nearest),
            farthest: f32x8::splat(self.slabs.best),
            ignored: u32x8::splat(self.own.ignored),
        };
        let ready = Ready::new(&rays, 0, reach);
        self.slabs = ready.slabs[0];
        self.shear = ready.shears[0];
    }

    fn hit(&self) -> Option<Hit> {
        let key = self.key.checked_sub(1)?;
        Some(Hit {
            distance: self.slabs.best,
            triangle: key as u32,
            instance: (key >> 32) as u32,
        })
    }

    /// Goes into an instance's space, and to the root of its mesh.
    fn enter_instance(&mut self, place: &Place) {
        let origin = place.to_object.transform_point3(self.own.origin.into());
        let direction = place.to_object.transform_vector3(self.own.direction.into());
        self.aim(origin, direction, place.reach);
        self.instance = place.instance;
        self.push(Link::LEAVE, f32::NEG_INFINITY);
        self.link = place.root;
    }

    /// Takes the next place from the stack; [`Link::STALE`] where that is out of reach.
    #[inline(always)]
    fn pop<const ANY: bool>(&mut self) {
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
    fn pop_within(&mut self) {
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
    fn enter<const ANY: bool>(&mut self, node: &Node) {
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
    fn test<const ANY: bool>(&mut self, block: &Block) {
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

/// The rays whose next place is of one kind. Its length is kept in a register, where a memory of lengths by kind would
/// make each step wait for the one before.
struct List {
    slots: [u32; SLOTS],
    len: usize,
}

impl List {
    const EMPTY: Self = Self {
        slots: [0; SLOTS],
        len: 0,
    };

    /// Adds a slot, if it is one of them, without a branch.
    #[inline(always)]
    fn push_if(&mut self, condition: bool, slot: u32) {
        self.slots[self.len & (SLOTS - 1)] = slot;
        self.len += usize::from(condition);
    }
}

impl Bvh {
    /// Traces batches of rays, of `count` in all, and gives `done` the number and hit of each, in any order.
    ///
    /// With `ANY` a ray ends at the first hit, whichever that is.
    #[inline(always)]
    pub(super) fn stream<const ANY: bool>(
        &self,
        root: &Root,
        count: usize,
        batches: &[u32],
        slots: &mut [Slot; SLOTS],
        rays: impl Fn(usize) -> RaysX8,
        mut done: impl FnMut(usize, Option<Hit>),
    ) {
        let mut free: [u32; SLOTS] = std::array::from_fn(|slot| slot as u32);
        let mut free_len = SLOTS;
        let (mut nodes, mut blocks, mut others) = (List::EMPTY, List::EMPTY, List::EMPTY);
        // Sends a ray to the list of its next place.
        macro_rules! sort {
            ($index:expr, $slot:expr) => {{
                let kind = $slot.link.kind();
                nodes.push_if(kind == Link::NODE, $index);
                blocks.push_if(kind == Link::BLOCK, $index);
                others.push_if(kind > Link::BLOCK, $index);
            }};
        }
        let mut ready = Ready {
            slabs: Default::default(),
            shears: Default::default(),
            own: Default::default(),
        };
        let mut next = 0;
        // The last batch of all may have lanes without a ray.
        let is_last = |&batch: &u32| batch as usize == count / WIDTH;
        let dead = batches.last().filter(|batch| is_last(batch));
        let last = batches.len() * WIDTH - dead.map_or(0, |_| WIDTH - count % WIDTH);
        loop {
            while next < last && free_len > 0 {
                if next % WIDTH == 0 {
                    let batch = batches[next / WIDTH] as usize;
                    ready = Ready::new(&rays(batch), batch * WIDTH, root.reach);
                }
                free_len -= 1;
                let index = free[free_len & (SLOTS - 1)];
                let slot = &mut slots[index as usize & (SLOTS - 1)];
                let lane = next % WIDTH;
                slot.slabs = ready.slabs[lane];
                slot.shear = ready.shears[lane];
                slot.own = ready.own[lane];
                slot.key = 0;
                slot.instance = 0;
                slot.top = BOTTOM as u32;
                slot.links[BOTTOM - 1] = Link::DONE.0;
                slot.distances[BOTTOM - 1] = f32::NEG_INFINITY;
                slot.link = root.link;
                sort!(index, slot);
                next += 1;
            }
            if free_len == SLOTS {
                return;
            }
            // What this round adds waits for the next, when its memory has come.
            let (node_count, block_count, other_count) = (nodes.len, blocks.len, others.len);
            let (old_blocks, old_others) = (blocks.slots, others.slots);
            (nodes.len, blocks.len, others.len) = (0, 0, 0);
            for entry in 0..node_count {
                // The list is written behind where it is read.
                let index = nodes.slots[entry & (SLOTS - 1)];
                let slot = &mut slots[index as usize & (SLOTS - 1)];
                slot.enter::<ANY>(&self.nodes[slot.link.index()]);
                slot.pop::<ANY>();
                sort!(index, slot);
            }
            for &index in &old_blocks[..block_count] {
                let slot = &mut slots[index as usize & (SLOTS - 1)];
                slot.test::<ANY>(&self.blocks[slot.link.index()]);
                slot.pop::<ANY>();
                sort!(index, slot);
            }
            for &index in &old_others[..other_count] {
                let slot = &mut slots[index as usize & (SLOTS - 1)];
                if slot.link.kind() == Link::INSTANCE {
                    slot.enter_instance(&self.places[slot.link.index()]);
                    sort!(index, slot);
                    continue;
                }
                if slot.link == Link::LEAVE {
                    let own = slot.own;
                    slot.aim(own.origin.into(), own.direction.into(), root.reach);
                }
                match slot.link {
                    Link::DONE => {}
                    _ if ANY => slot.pop::<ANY>(),
                    _ => slot.pop_within(),
                }
                if slot.link == Link::DONE {
                    done(slot.own.number as usize, slot.hit());
                    free[free_len & (SLOTS - 1)] = index;
                    free_len += 1;
                } else {
                    sort!(index, slot);
                }
            }
            if self.is_large {
                for &index in &nodes.slots[..nodes.len] {
                    let link = slots[index as usize & (SLOTS - 1)].link;
                    prefetch::prefetch(&self.nodes, link.index());
                }
                for &index in &blocks.slots[..blocks.len] {
                    let link = slots[index as usize & (SLOTS - 1)].link;
                    prefetch::prefetch(&self.blocks, link.index());
                }
            }
        }
    }
}
