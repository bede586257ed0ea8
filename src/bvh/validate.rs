//! Whether a tree is one.

use super::node::{Bounds, Link};
use super::{Bvh, NO_TRIANGLE, Quality, build};
use crate::lanes::WIDTH;
use std::collections::BTreeSet;

/// What a tree holds.
#[derive(Clone, Debug, Default)]
pub struct Census {
    /// Nodes of eight children.
    pub nodes: usize,
    /// Blocks of eight triangles.
    pub blocks: usize,
    /// Nodes on the longest way down.
    pub depth: usize,
    /// The triangles of each mesh, ascending, each once.
    pub meshes: Vec<Vec<u32>>,
}

impl Bvh {
    /// Walks the tree and counts; for tests.
    ///
    /// # Errors
    /// What is wrong: a place that is not there or is met twice, a box that does not hold what is below it (of a
    /// triangle in pieces, that does not touch it), a tree deeper than a stack, an order that is none.
    pub fn validate(&self, quality: Quality) -> Result<Census, String> {
        let mut census = Census::default();
        let Some(root) = &self.root else {
            return Ok(census);
        };
        let mut seen = BTreeSet::new();
        let mut roots = Vec::new();
        self.walk(root.link, quality, &mut census, &mut seen, &mut roots)?;
        if root.link.kind() != Link::INSTANCE && self.places.is_empty() {
            return Ok(census);
        }
        census.meshes.clear();
        roots.sort_unstable_by_key(|root| root.0);
        roots.dedup();
        for root in roots {
            self.walk(root, quality, &mut census, &mut seen, &mut Vec::new())?;
        }
        Ok(census)
    }

    /// Everything below a place; instances' roots are put down for later.
    fn walk(
        &self,
        root: Link,
        quality: Quality,
        census: &mut Census,
        seen: &mut BTreeSet<u32>,
        roots: &mut Vec<Link>,
    ) -> Result<(), String> {
        let everywhere = Bounds {
            low: glam::Vec3::NEG_INFINITY,
            high: glam::Vec3::INFINITY,
        };
        let mut triangles = BTreeSet::new();
        let mut waiting = vec![(root, everywhere, 0)];
        while let Some((link, bounds, depth)) = waiting.pop() {
            let index = link.index();
            if !seen.insert(link.0) {
                return Err(format!("{link:?} is met twice"));
            }
            match link.kind() {
                Link::NODE => {
                    let node = self.nodes.get(index).ok_or(format!("no node {index}"))?;
                    census.nodes += 1;
                    census.depth = census.depth.max(depth + 1);
                    if depth >= build::MAX_DEPTH {
                        return Err(format!("node {index} is on level {depth}"));
                    }
                    let children: Vec<_> = (0..WIDTH).filter_map(|lane| node.child(lane)).collect();
                    let live = (1u32 << children.len()) - 1;
                    for order in node.order {
                        let lanes: BTreeSet<u32> =
                            (0..WIDTH).map(|place| order >> (3 * place) & 7).collect();
                        if order >> 24 != live || lanes.len() != WIDTH {
                            return Err(format!("node {index} has the order {order:o}"));
                        }
                    }
                    for (inner, child) in children {
                        if !bounds.contains(&inner) {
                            return Err(format!("{child:?} sticks out of node {index}"));
                        }
                        waiting.push((child, inner, depth + 1));
                    }
                }
                Link::BLOCK => {
                    let block = self.blocks.get(index).ok_or(format!("no block {index}"))?;
                    census.blocks += 1;
                    for lane in 0..block.len() {
                        let corners = block.corners_of(lane).map(|corner| Bounds {
                            low: corner,
                            high: corner,
                        });
                        let around = corners.into_iter().fold(Bounds::EMPTY, Bounds::union);
                        let right = match quality {
                            Quality::Fast => bounds.contains(&around),
                            Quality::Best => bounds.touches(&around),
                        };
                        let triangle = block.triangles.as_array()[lane];
                        let twice = !triangles.insert(triangle) && quality == Quality::Fast;
                        if !right || twice || triangle == NO_TRIANGLE {
                            return Err(format!("triangle {triangle} is wrong in block {index}"));
                        }
                    }
                }
                Link::INSTANCE => {
                    let place = self.places.get(index).ok_or(format!("no place {index}"))?;
                    roots.push(place.root);
                }
                _ => return Err(format!("{link:?} in a tree")),
            }
        }
        census.meshes.push(triangles.into_iter().collect());
        Ok(())
    }
}
