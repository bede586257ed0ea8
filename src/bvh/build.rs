//! Builds trees: top down, straight to eight children a node.

use super::bins::{best_split, partition};
use super::item::{Extent, Hull, Item};
use super::node::{Bounds, Link, Node};
use crate::lanes::{WIDTH, u32x8};
use rayon::prelude::*;

/// Runs this long are trees of their own, built side by side.
const SUBTREE: usize = 1 << 13;

/// How deep a tree may be, so that a traversal's stack has a known size. Where the heuristic would go deeper, halves are
/// taken, which go down by a factor of eight a level.
pub(super) const MAX_DEPTH: usize = 24;

/// By how much boxes are wider than what is in them, relative to the tree's greatest coordinate: the rounding errors of
/// the box test, which grow with the origin's distance, up to three times that coordinate (and so four from the plane).
pub(super) const MARGIN: f32 = 4.0 * f32::EPSILON;

/// A tree's root and its leaves, runs of items, in the order of their links.
#[derive(Debug, Default)]
pub(super) struct Tree {
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
    /// Leaves that there are already.
    pub first_leaf: usize,
}

/// Builds a tree over items and puts these into the order of its leaves; its nodes follow those that there are.
pub(super) fn build(items: &mut [Item], plan: Plan, nodes: &mut Vec<Node>) -> Tree {
    if items.is_empty() {
        return Tree::default();
    }
    let run = Run {
        first: 0,
        count: items.len(),
        extent: Extent::of(items),
    };
    let bounds = run.extent.hull.bounds();
    let builder = Builder {
        leaf: plan.leaf,
        margin: bounds.reach() * MARGIN,
    };
    let part = builder.grow(items, &run, 0);
    let (own_nodes, own_leaves) = part.counts();
    let mut parts = Vec::new();
    let mut leaves = Vec::with_capacity(own_leaves);
    let first_node = nodes.len();
    let mut placed = (first_node, plan.first_leaf);
    let link = part.place(plan.kind, &mut placed, &mut parts, &mut leaves);
    // All threads share the cost of touching new memory.
    nodes.par_extend((0..own_nodes).into_par_iter().map(|_| Node::empty()));
    let mut rest = &mut nodes[first_node..];
    let mut work = Vec::with_capacity(parts.len());
    for part in parts {
        let (room, after) = rest.split_at_mut(part.nodes.len());
        work.push((part, room));
        rest = after;
    }
    work.into_par_iter().for_each(|(part, room)| {
        for (place, mut node) in room.iter_mut().zip(part.nodes) {
            node.move_links(plan.kind, part.first_node, part.first_leaf);
            *place = node;
        }
    });
    Tree {
        leaves,
        root: Some((bounds, link)),
    }
}

/// A tree that has not got its place yet: nodes, first the root, and leaves, linked by numbers of their own; or a root whose
/// children are parts.
#[derive(Default)]
struct Part {
    nodes: Vec<Node>,
    leaves: Vec<(u32, u32)>,
    below: Vec<Part>,
}

/// A part's nodes, and how far its links have to be moved.
struct Placed {
    nodes: Vec<Node>,
    first_node: usize,
    first_leaf: usize,
}

impl Part {
    /// Nodes and leaves of it and of what is below.
    fn counts(&self) -> (usize, usize) {
        let own = (self.nodes.len(), self.leaves.len());
        self.below.iter().fold(own, |(nodes, leaves), part| {
            let below = part.counts();
            (nodes + below.0, leaves + below.1)
        })
    }

    /// Gives it and what is below its place, after the nodes and leaves that have theirs; the link of its root.
    fn place(
        mut self,
        kind: u32,
        placed: &mut (usize, usize),
        parts: &mut Vec<Placed>,
        all: &mut Vec<(u32, u32)>,
    ) -> Link {
        let (first_node, first_leaf) = *placed;
        placed.0 += self.nodes.len();
        placed.1 += self.leaves.len();
        all.append(&mut self.leaves);
        let link = match self.nodes.is_empty() {
            true => Link::new(kind, first_leaf),
            false => Link::new(Link::NODE, first_node),
        };
        let place = parts.len();
        let is_split = !self.below.is_empty();
        parts.push(Placed {
            nodes: self.nodes,
            // The links to parts below are in place already.
            first_node: if is_split { 0 } else { first_node },
            first_leaf: if is_split { 0 } else { first_leaf },
        });
        for (lane, part) in self.below.into_iter().enumerate() {
            let link = part.place(kind, placed, parts, all);
            parts[place].nodes[0].children.as_mut_array()[lane] = link.0;
        }
        link
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
#[derive(Clone, Copy)]
struct Run {
    /// Place of the first of them among all.
    first: usize,
    count: usize,
    extent: Extent,
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

/// The children of a node, in the order of their items.
struct Children {
    runs: [Run; WIDTH],
    count: usize,
    /// As nodes have it.
    order: [u32; 8],
}

/// What is the same for all nodes.
struct Builder {
    /// The most items of a leaf.
    leaf: usize,
    /// By how much boxes are wider than what is in them.
    margin: f32,
}

impl Builder {
    fn is_leaf(&self, run: &Run) -> bool {
        run.count <= self.leaf
    }

    /// The subtree of a run, whose items these are; its leaves' links are of [`Link::BLOCK`].
    fn grow(&self, items: &mut [Item], run: &Run, depth: usize) -> Part {
        let mut part = Part::default();
        if self.is_leaf(run) {
            part.leaves.push((run.first as u32, run.count as u32));
        } else if run.count > SUBTREE {
            self.parts(items, run, depth, &mut part);
        } else {
            self.node(items, run, depth, &mut part);
        }
        part
    }

    /// Adds a root and a part for each child.
    fn parts(&self, items: &mut [Item], run: &Run, depth: usize, part: &mut Part) {
        let children = self.children(items, run, depth);
        let mut node = Node::empty();
        node.order = children.order;
        let mut rest = items;
        let mut work = Vec::with_capacity(WIDTH);
        for (lane, child) in children.runs[..children.count].iter().enumerate() {
            node.set(lane, self.bounds(child), Link::DONE);
            let (own, after) = std::mem::take(&mut rest).split_at_mut(child.count);
            work.push((own, child));
            rest = after;
        }
        part.nodes.push(node);
        part.below = work
            .into_par_iter()
            .map(|(items, child)| self.grow(items, child, depth + 1))
            .collect();
    }

    /// Adds the node and what is below.
    fn node(&self, items: &mut [Item], run: &Run, depth: usize, part: &mut Part) {
        let index = part.nodes.len();
        let children = self.children(items, run, depth);
        let mut node = Node::empty();
        node.order = children.order;
        part.nodes.push(node);
        let mut rest = items;
        for (lane, child) in children.runs[..children.count].iter().enumerate() {
            let (own, after) = std::mem::take(&mut rest).split_at_mut(child.count);
            rest = after;
            let link = if self.is_leaf(child) {
                part.leaves.push((child.first as u32, child.count as u32));
                Link::new(Link::BLOCK, part.leaves.len() - 1)
            } else {
                Link::new(Link::NODE, part.nodes.len())
            };
            part.nodes[index].set(lane, self.bounds(child), link);
            if link.kind() == Link::NODE {
                self.node(own, child, depth + 1, part);
            }
        }
    }

    /// The box that a node has of a child.
    fn bounds(&self, run: &Run) -> Bounds {
        let Bounds { low, high } = run.extent.hull.bounds();
        Bounds {
            low: low - self.margin,
            high: high + self.margin,
        }
    }

    /// Splits into up to eight, always the child with the largest surface that is no leaf; and the order in which rays
    /// of each octant should meet them.
    fn children(&self, items: &mut [Item], run: &Run, depth: usize) -> Children {
        let levels = (run.count as f32).log2() / 3.0;
        let by_halves = depth as f32 + levels + 2.0 > MAX_DEPTH as f32;
        let weight = |run: &Run| match by_halves {
            _ if self.is_leaf(run) => f32::NEG_INFINITY,
            true => run.count as f32,
            false => run.extent.hull.area(),
        };
        let mut runs = [*run; WIDTH];
        let mut weights = [f32::NEG_INFINITY; WIDTH];
        weights[0] = weight(run);
        let mut family = [Family::Child(0); 2 * WIDTH - 1];
        // The place of each child in the family.
        let mut places = [0; WIDTH];
        let mut count = 1;
        while count < WIDTH {
            let mut widest = 0;
            for child in 1..count {
                if weights[child] >= weights[widest] {
                    widest = child;
                }
            }
            if weights[widest] == f32::NEG_INFINITY {
                break;
            }
            let old = runs[widest];
            let begin = old.first - run.first;
            let own = &mut items[begin..begin + old.count];
            let (axis, low, high) = self.split(own, &old, by_halves);
            let member = 2 * count - 1;
            family[places[widest]] = Family::Split {
                axis,
                low: member,
                high: member + 1,
            };
            for (child, place, run) in [(widest, member, low), (count, member + 1, high)] {
                (runs[child], weights[child], places[child]) = (run, weight(&run), place);
            }
            count += 1;
        }
        // Lanes in the order of the items, so that subtrees lie in memory as their items do.
        let mut lanes: [usize; WIDTH] = std::array::from_fn(|lane| lane);
        let lanes = &mut lanes[..count];
        lanes.sort_unstable_by_key(|&child| runs[child].first);
        let mut sorted = runs;
        for (lane, &child) in lanes.iter().enumerate() {
            sorted[lane] = runs[child];
            family[places[child]] = Family::Child(lane);
        }
        Children {
            runs: sorted,
            count,
            order: far_to_near(&family[..2 * count - 1], count),
        }
    }

    /// Two parts of a run and the axis along which they lie.
    fn split(&self, items: &mut [Item], run: &Run, by_halves: bool) -> (usize, Run, Run) {
        let best = match by_halves {
            true => None,
            false => best_split(items, &run.extent, self.leaf),
        };
        let (axis, middle, low, high) = match best {
            Some(best) => {
                let (middle, low, high) = partition(items, &best);
                let extent = |hull, centers| Extent { hull, centers };
                let (low, high) = (extent(best.low, low), extent(best.high, high));
                (best.axis, middle, low, high)
            }
            None => halves(items, &run.extent),
        };
        let low = Run {
            first: run.first,
            count: middle,
            extent: low,
        };
        let high = Run {
            first: run.first + middle,
            count: run.count - middle,
            extent: high,
        };
        (axis, low, high)
    }
}

/// Halves by number along the widest axis: the axis, how many are low, and both parts' boxes.
fn halves(items: &mut [Item], extent: &Extent) -> (usize, usize, Extent, Extent) {
    let [x, y, z, ..] = extent.centers.size().to_array();
    let axis = if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    };
    let middle = items.len() / 2;
    let key = |item: &Item| item.center().corners().to_array()[Hull::HIGH + axis];
    items.select_nth_unstable_by(middle, |a, b| {
        key(a).total_cmp(&key(b)).then(a.number().cmp(&b.number()))
    });
    let (a, b) = items.split_at(middle);
    (axis, middle, Extent::of(a), Extent::of(b))
}

/// For each octant, `count` lanes from the farthest to the nearest, three bits each: as [`Node::order`] has them.
///
/// Members follow what they were split from, so what is below a member is known before it when they are gone through from
/// the last to the first; all octants at once.
fn far_to_near(family: &[Family], count: usize) -> [u32; 8] {
    let octants = u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
    // Of each member, its lanes, and three times their number.
    let mut below = [(u32x8::ZERO, 0u32); 2 * WIDTH - 1];
    for (place, member) in family.iter().enumerate().rev() {
        below[place] = match *member {
            Family::Child(lane) => (u32x8::splat(lane as u32), 3),
            Family::Split { axis, low, high } => {
                let ((low, low_bits), (high, high_bits)) = (below[low], below[high]);
                // A ray that runs towards +axis meets the low side first: it is the last here.
                let forwards = (octants & u32x8::splat(1 << axis)).simd_eq(u32x8::ZERO);
                let low_first = low | high << low_bits;
                let high_first = high | low << high_bits;
                let order = (high_first & forwards) | (low_first & !forwards);
                (order, low_bits + high_bits)
            }
        };
    }
    // Which places hold children, and the lanes that hold none.
    let live = (1u32 << count) - 1;
    let empty = (count..WIDTH).fold(0, |order, lane| order | (lane as u32) << (3 * lane));
    (below[0].0 | u32x8::splat(empty | live << 24)).to_array()
}
