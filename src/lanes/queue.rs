//! Records, batches and queues.
//!
//! A *record* is declared once with [`record!`](crate::record) and exists in two shapes: one lane and eight. A
//! [`Queue`] is a list of batches and a length; what a kernel keeps of a batch is pushed under a mask and closes up with
//! what is there already, so every batch but the last is full.

use super::{Rgbx8, Vec3x8, WIDTH, f32x8, first_lanes, u32x8};

/// A field's one-lane type, and how it sits in its eight-lane type.
pub trait Lane: Copy {
    /// Eight of them.
    type Wide: Shuffle;
    /// Reads a lane.
    fn get(wide: &Self::Wide, lane: usize) -> Self;
    /// Writes a lane.
    fn set(self, wide: &mut Self::Wide, lane: usize);
}

/// What a queue needs of an eight-lane type.
pub trait Shuffle: Copy + Default {
    /// Lane `i` of the result is lane `order[i]` of `self`; each index is below 8.
    fn shuffle(&self, order: u32x8) -> Self;
    /// `on` where the mask is on, `off` elsewhere.
    fn select(mask: f32x8, on: &Self, off: &Self) -> Self;
}

impl Shuffle for f32x8 {
    #[inline]
    fn shuffle(&self, order: u32x8) -> Self {
        (*self).shuffle(order)
    }
    #[inline]
    fn select(mask: f32x8, on: &Self, off: &Self) -> Self {
        mask.select(*on, *off)
    }
}

impl Shuffle for u32x8 {
    #[inline]
    fn shuffle(&self, order: u32x8) -> Self {
        (*self).shuffle(order)
    }
    #[inline]
    fn select(mask: f32x8, on: &Self, off: &Self) -> Self {
        mask.select(*on, *off)
    }
}

macro_rules! shuffle_by_fields {
    ($type:ident { $($field:ident),+ }) => {
        impl Shuffle for $type {
            #[inline]
            fn shuffle(&self, order: u32x8) -> Self {
                Self { $($field: Shuffle::shuffle(&self.$field, order)),+ }
            }
            #[inline]
            fn select(mask: f32x8, on: &Self, off: &Self) -> Self {
                Self { $($field: Shuffle::select(mask, &on.$field, &off.$field)),+ }
            }
        }
    };
}
shuffle_by_fields!(Vec3x8 { x, y, z });
shuffle_by_fields!(Rgbx8 { r, g, b });

impl Lane for f32 {
    type Wide = f32x8;
    #[inline]
    fn get(wide: &f32x8, lane: usize) -> f32 {
        wide.as_array()[lane]
    }
    #[inline]
    fn set(self, wide: &mut f32x8, lane: usize) {
        wide.as_mut_array()[lane] = self;
    }
}

impl Lane for u32 {
    type Wide = u32x8;
    #[inline]
    fn get(wide: &u32x8, lane: usize) -> u32 {
        wide.as_array()[lane]
    }
    #[inline]
    fn set(self, wide: &mut u32x8, lane: usize) {
        wide.as_mut_array()[lane] = self;
    }
}

/// A batch: eight records, field by field.
pub trait Batch: Shuffle {
    /// One lane of it.
    type Record: Copy;
    /// Reads a lane.
    fn lane(&self, lane: usize) -> Self::Record;
    /// Writes a lane.
    fn set_lane(&mut self, lane: usize, record: Self::Record);
}

/// Declares a record in its two shapes from one list of fields. A record may be a field of another.
///
/// ```
/// use glam::Vec3;
/// ondine::record! {
///     /// A ray.
///     pub struct Ray, RayX8 {
///         /// World space.
///         origin: Vec3,
///         /// Greatest distance, scene units.
///         t_max: f32,
///     }
/// }
/// let mut queue = ondine::lanes::Queue::<RayX8>::with_capacity(100);
/// queue.push_one(Ray { origin: Vec3::ZERO, t_max: 1.0 });
/// assert_eq!(queue.len(), 1);
/// assert_eq!(queue.get(0).t_max, 1.0);
/// ```
#[macro_export]
macro_rules! record {
    (
        $(#[$doc:meta])*
        pub struct $one:ident, $eight:ident {
            $( $(#[doc = $field_doc:literal])* $field:ident : $type:ty ),+ $(,)?
        }
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default)]
        pub struct $one { $( $(#[doc = $field_doc])* pub $field: $type ),+ }

        $(#[$doc])*
        ///
        /// Eight of them.
        #[derive(Clone, Copy, Debug, Default)]
        #[repr(C)]
        pub struct $eight {
            $( $(#[doc = $field_doc])* pub $field: <$type as $crate::lanes::Lane>::Wide ),+
        }

        impl $crate::lanes::Shuffle for $eight {
            #[inline]
            fn shuffle(&self, order: $crate::lanes::u32x8) -> Self {
                Self { $( $field: $crate::lanes::Shuffle::shuffle(&self.$field, order) ),+ }
            }
            #[inline]
            fn select(mask: $crate::lanes::f32x8, on: &Self, off: &Self) -> Self {
                Self { $( $field: $crate::lanes::Shuffle::select(mask, &on.$field, &off.$field) ),+ }
            }
        }

        impl $crate::lanes::Lane for $one {
            type Wide = $eight;
            #[inline]
            fn get(wide: &$eight, lane: usize) -> Self {
                $crate::lanes::Batch::lane(wide, lane)
            }
            #[inline]
            fn set(self, wide: &mut $eight, lane: usize) {
                $crate::lanes::Batch::set_lane(wide, lane, self);
            }
        }

        impl $crate::lanes::Fields for $one {
            fn fields(_: &'static str, _: &'static str, all: &mut Vec<$crate::lanes::Field>) {
                $( <$type as $crate::lanes::Fields>::fields(
                    stringify!($field),
                    concat!($($field_doc),*),
                    all,
                ); )+
            }
            fn words(&self, all: &mut Vec<u32>) {
                $( $crate::lanes::Fields::words(&self.$field, all); )+
            }
        }

        impl $crate::lanes::Batch for $eight {
            type Record = $one;
            #[inline]
            fn lane(&self, lane: usize) -> $one {
                $one { $( $field: <$type as $crate::lanes::Lane>::get(&self.$field, lane) ),+ }
            }
            #[inline]
            fn set_lane(&mut self, lane: usize, record: $one) {
                $( $crate::lanes::Lane::set(record.$field, &mut self.$field, lane); )+
            }
        }
    };
}

/// A list of records in batches of eight, all full but the last. Capacity is fixed when it is made.
///
/// A batch that is pushed whole is stored as it is; what is kept of others closes up in the last batch. So records keep
/// their order only within what was pushed whole, and no kernel may depend on it.
#[derive(Clone, Debug)]
pub struct Queue<B> {
    batches: Vec<B>,
    full: usize,
    last: B,
    in_last: usize,
}

impl<B: Batch> Queue<B> {
    /// Room for `capacity` records.
    pub fn with_capacity(capacity: usize) -> Self {
        Self {
            batches: vec![B::default(); capacity / WIDTH],
            full: 0,
            last: B::default(),
            in_last: 0,
        }
    }

    /// Records in it.
    #[inline]
    pub fn len(&self) -> usize {
        self.full * WIDTH + self.in_last
    }

    /// Whether it holds none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Empties it and keeps its room.
    #[inline]
    pub fn clear(&mut self) {
        (self.full, self.in_last) = (0, 0);
    }

    /// Appends the lanes of `batch` that `mask` has on.
    ///
    /// # Panics
    /// When the queue is full: a stage was given a wave larger than its workspace.
    #[inline]
    pub fn push(&mut self, mask: f32x8, batch: &B) {
        let mask = mask.to_bitmask() as usize;
        if mask == 0xff {
            self.batches[self.full] = *batch;
            self.full += 1;
        } else if mask != 0 {
            self.push_part(mask, batch);
        }
    }

    /// Closes up the lanes of `mask` behind those of the last batch.
    #[inline]
    fn push_part(&mut self, mask: usize, batch: &B) {
        // Kept lanes first, then turned right: one shuffle serves the last batch and the one behind it.
        let order = COMPRESS[mask].shuffle(ROTATE[self.in_last]);
        let shuffled = batch.shuffle(order);
        let filled = B::select(first_lanes(self.in_last), &self.last, &shuffled);
        self.in_last += mask.count_ones() as usize;
        if self.in_last < WIDTH {
            self.last = filled;
        } else {
            self.batches[self.full] = filled;
            self.full += 1;
            self.last = shuffled;
            self.in_last -= WIDTH;
        }
    }

    /// Appends one record.
    ///
    /// # Panics
    /// When the queue is full.
    pub fn push_one(&mut self, record: B::Record) {
        let mut batch = B::default();
        batch.set_lane(0, record);
        self.push_part(1, &batch);
    }

    /// Record `index`.
    ///
    /// # Panics
    /// When there is no such record.
    pub fn get(&self, index: usize) -> B::Record {
        assert!(index < self.len(), "record {index} of {}", self.len());
        if index < self.full * WIDTH {
            self.batches[index / WIDTH].lane(index % WIDTH)
        } else {
            self.last.lane(index % WIDTH)
        }
    }

    /// Batch `index`; dead lanes of the last hold arbitrary bits.
    ///
    /// # Panics
    /// When there is no such batch.
    #[inline]
    pub fn batch(&self, index: usize) -> &B {
        if index < self.full {
            &self.batches[index]
        } else {
            assert!(
                index * WIDTH < self.len(),
                "batch {index} of a shorter queue"
            );
            &self.last
        }
    }

    /// Up to `N` batches at a time, with the masks of their live lanes. Dead lanes hold arbitrary bits.
    ///
    /// For kernels whose steps wait for one another: each step done for `N` batches in turn keeps the processor busy.
    #[inline]
    pub fn groups<const N: usize>(&self) -> impl Iterator<Item = ([f32x8; N], &[B])> {
        let all = [first_lanes(WIDTH); N];
        let mut some = all;
        some[0] = first_lanes(self.in_last);
        let last = (self.in_last > 0).then(|| (some, std::slice::from_ref(&self.last)));
        self.batches[..self.full]
            .chunks(N)
            .map(move |batches| (all, batches))
            .chain(last)
    }

    /// Each batch with the mask of its live lanes. Dead lanes hold arbitrary bits.
    #[inline]
    pub fn batches(&self) -> impl Iterator<Item = (f32x8, &B)> {
        let live = |count| first_lanes(count);
        let last = (self.in_last > 0).then(|| (live(self.in_last), &self.last));
        self.batches[..self.full]
            .iter()
            .map(move |batch| (live(WIDTH), batch))
            .chain(last)
    }
}

/// For each mask, the lanes that are on, ascending, then the lanes that are off.
static COMPRESS: [u32x8; 256] = {
    let mut table = [u32x8::new([0; 8]); 256];
    let mut mask = 0;
    while mask < 256 {
        let mut order = [0; 8];
        let mut filled = 0;
        let mut wanted = 1;
        loop {
            let mut lane = 0;
            while lane < 8 {
                if (mask >> lane) & 1 == wanted {
                    order[filled] = lane as u32;
                    filled += 1;
                }
                lane += 1;
            }
            if wanted == 0 {
                break;
            }
            wanted = 0;
        }
        table[mask] = u32x8::new(order);
        mask += 1;
    }
    table
};

/// Turns right by 0 to 7 lanes.
static ROTATE: [u32x8; 8] = {
    let mut table = [u32x8::new([0; 8]); 8];
    let mut by = 0;
    while by < 8 {
        let mut order = [0; 8];
        let mut lane = 0;
        while lane < 8 {
            order[lane] = ((lane + 8 - by) % 8) as u32;
            lane += 1;
        }
        table[by] = u32x8::new(order);
        by += 1;
    }
    table
};
