//! One of several parts of an image.

use crate::error::{Error, Result};

/// Part `number` of `of`: from 1, and at most 2³¹.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    number: u32,
    of: u32,
}

impl Shard {
    /// Which part it is, from 1.
    pub fn number(self) -> u32 {
        self.number
    }

    /// How many parts there are.
    pub fn of(self) -> u32 {
        self.of
    }

    /// Every part, in order.
    pub fn all(of: u32) -> impl Iterator<Item = Self> {
        (1..=of).map(move |number| Self { number, of })
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl std::str::FromStr for Shard {
    type Err = Error;

    /// From `K/N`; [`Error::Usage`] where that is not 1 ≤ K ≤ N.
    fn from_str(text: &str) -> Result<Self> {
        text.split_once('/')
            .and_then(|(number, of)| {
                Some(Self {
                    number: number.trim().parse().ok()?,
                    of: of.trim().parse().ok()?,
                })
            })
            .filter(|shard| (1..=shard.of).contains(&shard.number) && shard.of <= 1 << 31)
            .ok_or_else(|| {
                Error::Usage(format!(
                    "\"{text}\" is no shard; write K/N, the K-th of N parts, as in 3/16: K from 1 to N"
                ))
            })
    }
}

impl serde::Serialize for Shard {
    fn serialize<S: serde::Serializer>(
        &self,
        serializer: S,
    ) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
