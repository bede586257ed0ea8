//! Many rays at once, one ray against eight boxes or eight triangles at a time.
//!
//! A ray by itself leaves a processor idle: each step waits for the last, and whether a box was hit, or the next place is a
//! leaf, is anybody's guess. Here some dozens of rays are under way. All whose next place is a node take a step, then all
//! whose next place is a leaf; what is next goes to one list or another without a branch, and the memory of the next place
//! is asked for a whole round before it is read.

use super::cells::Cells;
use super::node::Link;
use super::packet::PacketStack;
use super::ready::Ready;
use super::slot::Slot;
use super::{Bvh, Hit, RayX8, Root, prefetch};
use crate::lanes::WIDTH;

/// Rays under way; a power of two.
const SLOTS: usize = 32;

/// One worker's memory while it traces. Nothing in it is shared.
#[derive(Clone, Debug)]
pub struct Stacks {
    pub(super) slots: Box<[Slot; SLOTS]>,
    pub(super) packet: PacketStack,
    /// Rays sorted by direction.
    pub(super) cells: Cells,
    /// Batches of rays that do not keep together.
    pub(super) loose: Vec<u32>,
}

impl Default for Stacks {
    fn default() -> Self {
        let slots = vec![Slot::idle(); SLOTS].into_boxed_slice();
        Self {
            slots: slots.try_into().expect("as many as were made"),
            packet: PacketStack::default(),
            cells: Cells::default(),
            loose: Vec::new(),
        }
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
        rays: impl Fn(usize) -> RayX8,
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
        let mut ready = Ready::default();
        let mut next = 0;
        // The last batch of all may have lanes without a ray.
        let is_last = |&batch: &u32| batch as usize == count / WIDTH;
        let dead = batches.last().filter(|batch| is_last(batch));
        let last = batches.len() * WIDTH - dead.map_or(0, |_| WIDTH - count % WIDTH);
        loop {
            while next < last && free_len > 0 {
                if next % WIDTH == 0 {
                    let batch = batches[next / WIDTH] as usize;
                    ready.prepare::<ANY>(&rays(batch), batch * WIDTH, &self.nodes, root);
                }
                free_len -= 1;
                let index = free[free_len & (SLOTS - 1)];
                let slot = &mut slots[index as usize & (SLOTS - 1)];
                slot.start::<ANY>(&ready, next % WIDTH);
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
                    slot.leave_instance(root.reach);
                }
                match slot.link {
                    Link::DONE => {}
                    _ if ANY => slot.pop::<ANY>(),
                    _ => slot.pop_within(),
                }
                if slot.link == Link::DONE {
                    done(slot.number(), slot.hit());
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
