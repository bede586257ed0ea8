//! What a record is made of, for whoever writes it down: no second list of its fields is needed.

use super::Rgb;
use glam::Vec3;

/// A field of a record, down to numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its name. The fields of a record within a record are as if they were its own.
    pub name: &'static str,
    /// Its documentation: space, unit.
    pub doc: &'static str,
    /// What its numbers are.
    pub number: Number,
    /// How many: 3 for a vector and a colour.
    pub width: usize,
}

/// What the 32 bits of a number are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Number {
    /// An `f32`.
    Float,
    /// A `u32`.
    Integer,
}

/// What is made of numbers of 32 bits.
pub trait Fields {
    /// Adds its fields; `name` and `doc` are of it where it is a field itself.
    fn fields(name: &'static str, doc: &'static str, all: &mut Vec<Field>);
    /// Adds the bits of its numbers, in the order of its fields.
    fn words(&self, all: &mut Vec<u32>);
}

macro_rules! leaf {
    ($type:ty, $number:ident, $width:literal, $words:expr) => {
        impl Fields for $type {
            fn fields(name: &'static str, doc: &'static str, all: &mut Vec<Field>) {
                all.push(Field {
                    name,
                    doc,
                    number: Number::$number,
                    width: $width,
                });
            }
            fn words(&self, all: &mut Vec<u32>) {
                all.extend($words(*self));
            }
        }
    };
}
leaf!(u32, Integer, 1, |number: u32| [number]);
leaf!(f32, Float, 1, |number: f32| [number.to_bits()]);
leaf!(Vec3, Float, 3, |v: Vec3| v.to_array().map(f32::to_bits));
leaf!(Rgb, Float, 3, |c: Rgb| c.to_array().map(f32::to_bits));
