//! Builds trees: top down, straight to eight children a node.

use super::bins::{best_split, partition};
use super::item::{Extent, Hull, Item};
use super::node::{Bounds, Link, Node};
use crate::lanes::WIDTH;
use rayon::prelude::*;

/// Runs this long are trees of their own, built side by side.
const SUBTREE: usize = 1 << 13;

/// How deep a tree may be, so that a traversal's stack has a known size. Where the heuristic would go deeper, halves are
/// taken, which go down by a factor of eight a level.
pub(super) const MAX_DEPTH: usize = 24;

/// By how much boxes are wider than what is in them, relative to the tree's greatest coordinate: the rounding errors of
/// the box test, which grow with the origin's distance, up to three times that coordinate (and so four from the plane).
pub(super) const MARGIN: f32 = 4.0 * f32::EPSILON;

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
            false => best_split(self.items, &self.extent, leaf),
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
        let [x, y, z, ..] = self.extent.centers.size().to_array();
        let axis = if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        };
        let middle = self.items.len() / 2;
        let key = |item: &Item| item.center().corners().to_array()[Hull::HIGH + axis];
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
