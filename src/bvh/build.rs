//! Builds trees: top down, by the surface area heuristic on binned centroids (Wald 2007, "On fast Construction of SAH-based
//! Bounding Volume Hierarchies"), straight to eight children a node.

use super::node::{Bounds, Link, Node};
use crate::lanes::WIDTH;
use glam::Vec3;
use rayon::prelude::*;
use wide::f32x4;

/// Something to be put into a tree: its box and its number.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Item {
    /// The low corner; in the last place the number's bits.
    low: f32x4,
    high: f32x4,
}

impl Item {
    pub fn new(bounds: Bounds, number: u32) -> Self {
        let (low, high) = (bounds.low, bounds.high);
        Self {
            low: f32x4::new([low.x, low.y, low.z, f32::from_bits(number)]),
            high: f32x4::new([high.x, high.y, high.z, 0.0]),
        }
    }

    pub fn number(&self) -> u32 {
        self.low.to_array()[3].to_bits()
    }

    /// Twice the centre.
    #[inline(always)]
    fn center(&self) -> f32x4 {
        self.low + self.high
    }
}

/// A box that grows; the fourth place is unused.
#[derive(Clone, Copy, Debug)]
struct Hull {
    low: f32x4,
    high: f32x4,
}

impl Hull {
    fn empty() -> Self {
        Self {
            low: f32x4::splat(f32::INFINITY),
            high: f32x4::splat(f32::NEG_INFINITY),
        }
    }

    #[inline(always)]
    fn add(&mut self, low: f32x4, high: f32x4) {
        self.low = self.low.fast_min(low);
        self.high = self.high.fast_max(high);
    }

    #[inline(always)]
    fn union(mut self, other: Self) -> Self {
        self.add(other.low, other.high);
        self
    }

    /// Half the surface; 0 of nothing.
    #[inline(always)]
    fn area(&self) -> f32 {
        let [x, y, z, _] = (self.high - self.low).fast_max(f32x4::ZERO).to_array();
        x * y + y * z + z * x
    }

    fn bounds(&self) -> Bounds {
        let corner = |v: f32x4| Vec3::from_slice(&v.to_array()[..3]);
        Bounds {
            low: corner(self.low),
            high: corner(self.high),
        }
    }
}

/// What is known of a run of items: the box around them and the box around their centres (doubled).
#[derive(Clone, Copy, Debug)]
struct Extent {
    hull: Hull,
    centers: Hull,
}

impl Extent {
    fn empty() -> Self {
        Self {
            hull: Hull::empty(),
            centers: Hull::empty(),
        }
    }

    #[inline(always)]
    fn add(&mut self, item: &Item) {
        self.hull.add(item.low, item.high);
        let center = item.center();
        self.centers.add(center, center);
    }

    fn of(items: &[Item]) -> Self {
        let one = |items: &[Item]| {
            let mut all = Self::empty();
            items.iter().for_each(|item| all.add(item));
            all
        };
        if items.len() < PARALLEL {
            return one(items);
        }
        items
            .par_chunks(CHUNK)
            .map(one)
            .reduce(Self::empty, Self::union)
    }

    fn union(self, other: Self) -> Self {
        Self {
            hull: self.hull.union(other.hull),
            centers: self.centers.union(other.centers),
        }
    }
}

/// Bins along each axis, at most; where there are few items, half of them serve.
const BINS: usize = 16;
/// So few items.
const SPARSE: usize = 96;
/// From so many items on, several threads work on one run.
const PARALLEL: usize = 1 << 16;
/// Items that a thread takes at a time then.
const CHUNK: usize = 1 << 14;
/// Runs this long are trees of their own, built side by side.
const SUBTREE: usize = 1 << 13;

/// How deep a tree may be, so that a traversal's stack has a known size. Where the heuristic would go deeper, halves are
/// taken, which go down by a factor of eight a level.
pub(super) const MAX_DEPTH: usize = 24;

/// By how much boxes are wider than what is in them, relative to the tree's greatest coordinate: the rounding errors of
/// the box test, which grow with the origin's distance, up to three times that coordinate (and so four from the plane).
const MARGIN: f32 = 4.0 * f32::EPSILON;

/// A tree without its leaves' contents: runs of items, in the order of their links.
#[derive(Debug, Default)]
pub(super) struct Tree {
    pub nodes: Vec<Node>,
    /// First item and number of items.
    pub leaves: Vec<(u32, u32)>,
    pub root: Option<(Bounds, Link)>,
}

/// What a tree is built for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    /// The most items of a leaf.
    pub leaf: usize,
    /// The kind of link to a leaf.
    pub kind: u32,
    /// Added to all indices.
    pub first_node: usize,
    pub first_leaf: usize,
}

/// Builds a tree over items and puts these into the order of its leaves.
pub(super) fn build(items: &mut [Item], plan: Plan) -> Tree {
    if items.is_empty() {
        return Tree::default();
    }
    let extent = Extent::of(items);
    let run = Run {
        first: 0,
        extent,
        items,
        depth: 0,
    };
    let bounds = run.extent.hull.bounds();
    let mut tree = run.grow(plan.leaf);
    tree.root = Some((bounds, tree.root_link(plan)));
    let margin = bounds.reach() * MARGIN;
    for node in &mut tree.nodes {
        node.move_links(plan.kind, plan.first_node, plan.first_leaf);
        node.widen(margin);
    }
    tree
}

impl Tree {
    /// The link of the whole: the first node, or the only leaf.
    fn root_link(&self, plan: Plan) -> Link {
        if self.nodes.is_empty() {
            Link::new(plan.kind, plan.first_leaf)
        } else {
            Link::new(Link::NODE, plan.first_node)
        }
    }
}

impl Node {
    /// Links to leaves of `kind`, and everything so many places on.
    fn move_links(&mut self, kind: u32, nodes: usize, leaves: usize) {
        for link in self.children.as_mut_array() {
            let old = Link(*link);
            *link = match old.kind() {
                Link::NODE => Link::new(Link::NODE, old.index() + nodes),
                Link::BLOCK => Link::new(kind, old.index() + leaves),
                _ => old,
            }
            .0;
        }
    }
}

/// Items that will be a subtree.
struct Run<'a> {
    items: &'a mut [Item],
    /// Place of the first of them among all.
    first: usize,
    extent: Extent,
    depth: usize,
}

/// How the children of a node came about: which lie on the near side of which.
#[derive(Clone, Copy)]
enum Family {
    Child(usize),
    Split {
        axis: usize,
        low: usize,
        high: usize,
    },
}

impl<'a> Run<'a> {
    fn is_leaf(&self, leaf: usize) -> bool {
        self.items.len() <= leaf
    }

    /// The subtree; its leaves' links are of [`Link::BLOCK`].
    fn grow(self, leaf: usize) -> Tree {
        let mut tree = Tree::default();
        if self.is_leaf(leaf) {
            tree.leaves
                .push((self.first as u32, self.items.len() as u32));
            return tree;
        }
        self.node(leaf, &mut tree);
        tree
    }

    /// Adds the node and what is below to a tree.
    fn node(self, leaf: usize, tree: &mut Tree) {
        let large = self.items.len() > SUBTREE;
        let index = tree.nodes.len();
        tree.nodes.push(Node::empty());
        let (children, order) = self.children(leaf);
        tree.nodes[index].order = order;
        if large {
            let places: Vec<Bounds> = children.iter().map(|c| c.extent.hull.bounds()).collect();
            let subtrees: Vec<Tree> = children
                .into_par_iter()
                .map(|child| child.grow(leaf))
                .collect();
            for (lane, (bounds, mut subtree)) in places.into_iter().zip(subtrees).enumerate() {
                let (nodes, leaves) = (tree.nodes.len(), tree.leaves.len());
                let link = match subtree.nodes.is_empty() {
                    true => Link::new(Link::BLOCK, leaves),
                    false => Link::new(Link::NODE, nodes),
                };
                for node in &mut subtree.nodes {
                    node.move_links(Link::BLOCK, nodes, leaves);
                }
                tree.nodes.append(&mut subtree.nodes);
                tree.leaves.append(&mut subtree.leaves);
                tree.nodes[index].set(lane, bounds, link);
            }
            return;
        }
        for (lane, child) in children.into_iter().enumerate() {
            let bounds = child.extent.hull.bounds();
            let link = if child.is_leaf(leaf) {
                tree.leaves
                    .push((child.first as u32, child.items.len() as u32));
                Link::new(Link::BLOCK, tree.leaves.len() - 1)
            } else {
                Link::new(Link::NODE, tree.nodes.len())
            };
            tree.nodes[index].set(lane, bounds, link);
            if link.kind() == Link::NODE {
                child.node(leaf, tree);
            }
        }
    }

    /// Splits into up to eight, always the child with the largest surface that is no leaf; and the order in which rays
    /// of each octant should meet them.
    fn children(self, leaf: usize) -> (Vec<Run<'a>>, [u32; 8]) {
        let depth = self.depth + 1;
        let levels = (self.items.len() as f32).log2() / 3.0;
        let by_halves = self.depth as f32 + levels + 2.0 > MAX_DEPTH as f32;
        let mut children = vec![self];
        let mut family = vec![Family::Child(0)];
        // The place of each child in the family.
        let mut places = vec![0];
        while children.len() < WIDTH {
            let open = |run: &Run| !run.is_leaf(leaf);
            let weight = |run: &Run| match by_halves {
                true => run.items.len() as f32,
                false => run.extent.hull.area(),
            };
            let widest = children
                .iter()
                .enumerate()
                .filter(|(_, run)| open(run))
                .max_by(|(_, a), (_, b)| weight(a).total_cmp(&weight(b)));
            let Some((index, _)) = widest else { break };
            let run = children.swap_remove(index);
            let place = places.swap_remove(index);
            let (axis, low, high) = run.split(by_halves, leaf);
            family[place] = Family::Split {
                axis,
                low: family.len(),
                high: family.len() + 1,
            };
            for run in [low, high] {
                places.push(family.len());
                family.push(Family::Child(0));
                children.push(run);
            }
        }
        // Lanes in the order of the items, so that subtrees lie in memory as their items do.
        let mut lanes: Vec<(Run, usize)> = children.into_iter().zip(places).collect();
        lanes.sort_by_key(|(run, _)| run.first);
        for (lane, (_, place)) in lanes.iter().enumerate() {
            family[*place] = Family::Child(lane);
        }
        let order = std::array::from_fn(|octant| far_to_near(&family, octant));
        let children = lanes.into_iter().map(|(mut run, _)| {
            run.depth = depth;
            run
        });
        (children.collect(), order)
    }

    /// Two parts of a run and the axis along which they lie.
    fn split(self, by_halves: bool, leaf: usize) -> (usize, Run<'a>, Run<'a>) {
        let best = match by_halves {
            true => None,
            false => Bins::fill(self.items, &self.extent).best(leaf),
        };
        let Some(best) = best else {
            return self.halves();
        };
        let (first, depth, items) = (self.first, self.depth, self.items);
        let (middle, low_centers, high_centers) = partition(items, &best);
        let extent = |hull, centers| Extent { hull, centers };
        let low = extent(best.low, low_centers);
        let high = extent(best.high, high_centers);
        let (a, b) = items.split_at_mut(middle);
        (
            best.axis,
            Run {
                items: a,
                first,
                extent: low,
                depth,
            },
            Run {
                items: b,
                first: first + middle,
                extent: high,
                depth,
            },
        )
    }

    /// Halves by number along the widest axis.
    fn halves(self) -> (usize, Run<'a>, Run<'a>) {
        let [x, y, z, _] = (self.extent.centers.high - self.extent.centers.low).to_array();
        let axis = if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        };
        let middle = self.items.len() / 2;
        let key = |item: &Item| item.center().to_array()[axis];
        self.items.select_nth_unstable_by(middle, |a, b| {
            key(a).total_cmp(&key(b)).then(a.number().cmp(&b.number()))
        });
        let (a, b) = self.items.split_at_mut(middle);
        let (low, high) = (Extent::of(a), Extent::of(b));
        (
            axis,
            Run {
                items: a,
                first: self.first,
                extent: low,
                depth: self.depth,
            },
            Run {
                items: b,
                first: self.first + middle,
                extent: high,
                depth: self.depth,
            },
        )
    }
}

/// Lanes from the farthest to the nearest, three bits each.
fn far_to_near(family: &[Family], octant: usize) -> u32 {
    let mut order = 0;
    let mut count = 0;
    let mut used = 0u32;
    let mut waiting = vec![0];
    while let Some(place) = waiting.pop() {
        match family[place] {
            Family::Child(lane) => {
                order |= (lane as u32) << (3 * count);
                used |= 1 << lane;
                count += 1;
            }
            Family::Split { axis, low, high } => {
                // A ray that runs towards +axis meets the low side first: it is the last here.
                let backwards = octant >> axis & 1 == 1;
                let (near, far) = if backwards { (high, low) } else { (low, high) };
                waiting.push(near);
                waiting.push(far);
            }
        }
    }
    // Which places hold children.
    let live = (1u32 << count) - 1;
    for lane in (0..WIDTH as u32).filter(|lane| used >> lane & 1 == 0) {
        order |= lane << (3 * count);
        count += 1;
    }
    order | live << 24
}

/// Which bins a centre falls into.
#[derive(Clone, Copy)]
struct BinOf {
    origin: f32x4,
    scale: f32x4,
    bins: usize,
}

impl BinOf {
    fn new(centers: &Hull, items: usize) -> Self {
        let size = centers.high - centers.low;
        let bins = if items < SPARSE { BINS / 2 } else { BINS };
        // A hair less than the number of bins, so that the last centre is in the last one; 0 where there is no extent.
        let scale = f32x4::splat(bins as f32 * (1.0 - 1e-5)) / size;
        let some = size.simd_gt(f32x4::splat(f32::MIN_POSITIVE)) & scale.is_finite();
        Self {
            origin: centers.low,
            scale: scale & some,
            bins,
        }
    }

    /// Places among the bins, whole numbers from 0 on when cut off.
    #[inline(always)]
    fn places(&self, center: f32x4) -> f32x4 {
        (center - self.origin) * self.scale
    }
}

/// Boxes and numbers of items, by axis and bin.
struct Bins {
    hulls: [[Hull; BINS]; 3],
    counts: [[u32; BINS]; 3],
    bin_of: BinOf,
}

/// Where to split: items whose bin on `axis` is below `bin` from the others.
struct Best {
    axis: usize,
    bin: i32,
    low: Hull,
    high: Hull,
    bin_of: BinOf,
}

impl Bins {
    fn fill(items: &[Item], extent: &Extent) -> Self {
        let bin_of = BinOf::new(&extent.centers, items.len());
        let empty = || Self {
            hulls: [[Hull::empty(); BINS]; 3],
            counts: [[0; BINS]; 3],
            bin_of,
        };
        let one = |items: &[Item]| {
            let mut bins = empty();
            for item in items {
                let places = bin_of.places(item.center()).fast_trunc_int().to_array();
                for axis in 0..3 {
                    let bin = places[axis] as usize & (BINS - 1);
                    bins.hulls[axis][bin].add(item.low, item.high);
                    bins.counts[axis][bin] += 1;
                }
            }
            bins
        };
        if items.len() < PARALLEL {
            return one(items);
        }
        items.par_chunks(CHUNK).map(one).reduce(empty, Self::union)
    }

    fn union(mut self, other: Self) -> Self {
        for axis in 0..3 {
            for bin in 0..BINS {
                self.hulls[axis][bin] = self.hulls[axis][bin].union(other.hulls[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }

    /// The cheapest split by the surface area heuristic, where any parts the items.
    fn best(&self, leaf: usize) -> Option<Best> {
        // A leaf is met as a whole: it costs the same however full it is.
        let cost = |hull: &Hull, count: u32| hull.area() * count.div_ceil(leaf as u32) as f32;
        let bins = self.bin_of.bins;
        let mut cheapest = f32::INFINITY;
        let mut best = None;
        for axis in 0..3 {
            let (hulls, counts) = (&self.hulls[axis], &self.counts[axis]);
            let mut above = [(f32::INFINITY, Hull::empty()); BINS];
            let (mut hull, mut count) = (Hull::empty(), 0);
            for bin in (1..bins).rev() {
                hull = hull.union(hulls[bin]);
                count += counts[bin];
                if count > 0 {
                    above[bin] = (cost(&hull, count), hull);
                }
            }
            let (mut hull, mut count) = (Hull::empty(), 0);
            for bin in 1..bins {
                hull = hull.union(hulls[bin - 1]);
                count += counts[bin - 1];
                let (above, high) = above[bin];
                let sum = cost(&hull, count) + above;
                if count > 0 && sum < cheapest {
                    cheapest = sum;
                    best = Some(Best {
                        axis,
                        bin: bin as i32,
                        low: hull,
                        high,
                        bin_of: self.bin_of,
                    });
                }
            }
        }
        best
    }
}

/// Items that are `low` first; how many those are, and the boxes around both parts' centres.
///
/// Every item goes to both boxes' sums, masked, and is swapped whatever it is: which part it belongs to is anybody's guess,
/// and a branch on it would cost more.
fn partition(items: &mut [Item], best: &Best) -> (usize, Hull, Hull) {
    let (axis, bin) = (best.axis & 3, f32x4::splat(best.bin as f32));
    let (mut left, mut right) = (Hull::empty(), Hull::empty());
    let mut middle = 0;
    for place in 0..items.len() {
        let item = items[place];
        let center = item.center();
        let below = best.bin_of.places(center).simd_lt(bin).to_bitmask() >> axis & 1;
        let mask = f32x4::splat(f32::from_bits(below.wrapping_neg()));
        let none = Hull::empty();
        left.add(
            mask.select(center, none.low),
            mask.select(center, none.high),
        );
        right.add(
            mask.select(none.low, center),
            mask.select(none.high, center),
        );
        items[place] = items[middle];
        items[middle] = item;
        middle += below as usize;
    }
    (middle, left, right)
}
