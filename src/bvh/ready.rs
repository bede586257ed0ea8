//! Eight rays on their way into the stream: made ready for its tests, and taken together as far as they share their way.

use super::bundle::{Bundle, Extent};
use super::node::{Link, Node, unpack};
use super::slot::{FARTHEST, Own, Slabs, WIDEN};
use super::triangle::{Shear, ShearX8};
use super::{RayX8, Root};
use crate::lanes::{Vec3x8, WIDTH, f32x8, reduce, u32x8};

/// Origins farther than so many times the tree's reach are moved along their ray for the box test, or its rounding errors
/// would be those of the origin: of nearer ones the [`Node`]s' margin and [`WIDEN`] together cover the errors.
pub(super) const FAR: f32 = 3.0;
/// The least component of a direction, relative to its greatest: below it the ray is parallel to the planes.
const PARALLEL: f32 = 1e-12;
/// The most places at which eight rays part; a power of two.
pub(super) const PARTINGS: usize = 64;
/// So many of eight rays go on together, where any hit will do.
const TOGETHER: u32 = 5;
/// The distance of a place that a ray does not go to.
const NOWHERE: f32x8 = f32x8::splat(f32::INFINITY);

/// Eight rays, made ready.
pub(super) struct Ready {
    pub slabs: [Slabs; WIDTH],
    pub shears: [Shear; WIDTH],
    pub own: [Own; WIDTH],
    /// Where the rays part, eight places at a time, the nearer later.
    pub links: [u32x8; PARTINGS / WIDTH],
    /// For eight places, how far they are for each ray; infinitely where it does not go.
    pub distances: [[f32x8; WIDTH]; PARTINGS / WIDTH],
    /// Eights of places.
    pub groups: usize,
}

/// What the box tests of eight rays read, as [`Slabs`] has it of one.
pub(super) struct SlabsX8 {
    inverse: [f32x8; 3],
    offset: [f32x8; 3],
    nearest: f32x8,
    best: f32x8,
}

impl Default for Ready {
    fn default() -> Self {
        Self {
            slabs: Default::default(),
            shears: Default::default(),
            own: Default::default(),
            links: [u32x8::ZERO; PARTINGS / WIDTH],
            distances: [[f32x8::ZERO; WIDTH]; PARTINGS / WIDTH],
            groups: 0,
        }
    }
}

impl Ready {
    /// Takes eight rays, the first of this number among all, from the root to where they part.
    #[inline(always)]
    pub fn prepare<const ANY: bool>(
        &mut self,
        rays: &RayX8,
        first: usize,
        nodes: &[Node],
        root: &Root,
    ) {
        let shear = ShearX8::new(&rays.origin, &rays.direction);
        let slabs = SlabsX8::new(rays, root.reach);
        self.slabs = slabs.lanes();
        self.shears = shear.lanes();
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
        self.own = f32x8::transpose(own).map(|row| {
            let [a, b, c, d, e, f, ignored, number] = row.to_array();
            Own {
                origin: [a, b, c],
                direction: [d, e, f],
                ignored: ignored.to_bits(),
                number: number.to_bits(),
            }
        });
        // The nearest hit is not known yet, so only places that hold the origins are sure to be needed by all. Where any hit
        // will do, most rays go all their way; and what none of them meets, their bundle does not meet either.
        let near = ANY && rays.begins_near(root.reach);
        let bundle = near.then(|| Bundle::new(&Extent::of(rays, &shear), &shear));
        self.descend::<ANY>(&slabs, bundle.flatten().as_ref(), nodes, root.link);
    }

    /// Goes down the tree with all eight, as far as they go together.
    #[inline(always)]
    fn descend<const ANY: bool>(
        &mut self,
        slabs: &SlabsX8,
        bundle: Option<&Bundle>,
        nodes: &[Node],
        root: Link,
    ) {
        let nearest = reduce(slabs.nearest, f32x8::fast_min);
        let best = reduce(slabs.best, f32x8::fast_max);
        let octant = self.shears[0].octant as usize & 7;
        let mut partings = 0;
        let mut links = [0; PARTINGS];
        let mut distances = [f32x8::ZERO; PARTINGS];
        // Nodes to go on to.
        let mut common = [root.0; PARTINGS];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let link = Link(common[top]);
            // Each node may add eight.
            if link.kind() != Link::NODE || partings + top + WIDTH > PARTINGS {
                links[partings] = link.0;
                distances[partings] = slabs.nearest;
                partings += 1;
                continue;
            }
            let node = &nodes[link.index()];
            let order = node.order[octant];
            let mut children = order >> 24;
            if let Some(bundle) = bundle {
                let (hit, _) = bundle.enter(&node.planes, nearest, best);
                children &= hit.shuffle_wrapping(unpack(order)).to_bitmask();
            }
            while children != 0 {
                let child = (order >> (3 * children.trailing_zeros())) as usize & 7;
                children &= children - 1;
                let link = node.children.as_array()[child];
                let (hit, enter) = slabs.enter(node, child);
                let together = if ANY {
                    hit.to_bitmask().count_ones() >= TOGETHER
                } else {
                    (hit & enter.simd_eq(slabs.nearest)).all()
                };
                // Nobody could predict which: both are written, and one is counted.
                let together = together & (Link(link).kind() == Link::NODE);
                common[top & (PARTINGS - 1)] = link;
                top += usize::from(together);
                links[partings & (PARTINGS - 1)] = link;
                distances[partings & (PARTINGS - 1)] = hit.select(enter, NOWHERE);
                partings += usize::from(hit.any() & !together);
            }
        }
        self.groups = partings.div_ceil(WIDTH);
        distances[partings..self.groups * WIDTH].fill(NOWHERE);
        let groups = links.as_chunks().0.iter().zip(distances.as_chunks().0);
        let places = self.links.iter_mut().zip(&mut self.distances);
        for ((links, distances), place) in groups.zip(places).take(self.groups) {
            *place.0 = u32x8::new(*links);
            *place.1 = f32x8::transpose(*distances);
        }
    }
}

impl SlabsX8 {
    /// Those of a tree of this reach.
    #[inline(always)]
    pub fn new(rays: &RayX8, reach: f32) -> Self {
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
        Self {
            inverse,
            offset,
            nearest: rays.nearest,
            best: rays.farthest.fast_min(f32x8::splat(FARTHEST)),
        }
    }

    /// The rays that meet the box of one child of a node, and how far it is.
    #[inline(always)]
    fn enter(&self, node: &Node, child: usize) -> (f32x8, f32x8) {
        let slab = |axis: usize| {
            let at = |plane: usize| {
                let plane = f32x8::splat(node.planes[plane].as_array()[child]);
                plane.mul_add(self.inverse[axis], self.offset[axis])
            };
            let (low, high) = (at(axis), at(axis + 3));
            (low.fast_min(high), low.fast_max(high))
        };
        let (x, y, z) = (slab(0), slab(1), slab(2));
        let enter = x.0.fast_max(y.0).fast_max(z.0.fast_max(self.nearest));
        let leave = x.1.fast_min(y.1).fast_min(z.1.fast_min(self.best));
        (enter.simd_le(leave * f32x8::splat(WIDEN)), enter)
    }

    /// Each by itself.
    #[inline(always)]
    pub fn lanes(&self) -> [Slabs; WIDTH] {
        let ([a, b, c], [d, e, f]) = (self.inverse, self.offset);
        f32x8::transpose([a, b, c, d, e, f, self.nearest, self.best]).map(|row| {
            let [a, b, c, d, e, f, nearest, best] = row.to_array();
            Slabs {
                inverse: [a, b, c],
                offset: [d, e, f],
                nearest,
                best,
            }
        })
    }
}
