//! What a film can hold beside radiance: arbitrary output variables of the first surface that a path meets, and the
//! radiance of each path length by itself.

use crate::error::{Error, Result};

/// Which AOVs a film holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct AovSet {
    /// Reflectance, three channels.
    pub albedo: bool,
    /// Shading normal, world space, three channels.
    pub normal: bool,
    /// Distance from the camera, scene units, one channel.
    pub depth: bool,
    /// How many path lengths are kept apart, from 1 edge up: radiance and its variance, six channels each.
    /// [`EVERY_LENGTH`](Self::EVERY_LENGTH) where it is not known yet how many there are.
    pub lengths: u32,
}

/// The AOVs of one sample. What a path did not meet is 0; so counts a value that is not finite, or 2³² and more.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AovSample {
    /// Reflectance.
    pub albedo: [f32; 3],
    /// Shading normal, world space.
    pub normal: [f32; 3],
    /// Distance from the camera, scene units.
    pub depth: f32,
}

/// One number of an [`AovSample`]: the name of its EXR channel, its index in the sample, and whether a set holds it.
pub(super) struct Component {
    pub channel: &'static str,
    pub index: usize,
}

/// The names of all components, in the order of [`AovSample::to_array`].
const CHANNELS: [&str; 7] = [
    "albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z", "depth.Z",
];

impl AovSample {
    /// Albedo, normal, depth.
    pub(super) fn to_array(self) -> [f32; 7] {
        let ([r, g, b], [x, y, z]) = (self.albedo, self.normal);
        [r, g, b, x, y, z, self.depth]
    }
}

impl AovSet {
    const NAMES: &str = "albedo, normal, depth, bounces";

    /// As many path lengths as paths can have: what `bounces` in a list means.
    pub const EVERY_LENGTH: u32 = u32::MAX;

    /// The most path lengths that a film keeps apart: each takes 96 bytes a pixel.
    pub const MAX_LENGTHS: u32 = 64;

    /// The same, where paths have at most so many edges.
    pub fn up_to(self, path_length: u32) -> Self {
        Self {
            lengths: self.lengths.min(path_length),
            ..self
        }
    }

    /// # Errors
    /// [`Error::Usage`] for more than [`MAX_LENGTHS`](Self::MAX_LENGTHS) path lengths.
    pub fn check(self) -> Result<()> {
        if self.lengths > Self::MAX_LENGTHS {
            return Err(Error::Usage(format!(
                "the layer \"bounces\" keeps at most {} path lengths apart; choose a path length of {0} or less",
                Self::MAX_LENGTHS
            )));
        }
        Ok(())
    }

    /// Whether it names something of the first surface.
    pub fn has_first_hits(self) -> bool {
        self.albedo || self.normal || self.depth
    }

    /// Numbers per pixel of the first surface.
    pub fn components(self) -> usize {
        self.present().count()
    }

    /// The components that it holds, in order.
    pub(super) fn present(self) -> impl Iterator<Item = Component> {
        let groups = [self.albedo, self.normal, self.depth];
        CHANNELS
            .iter()
            .enumerate()
            .filter(move |&(index, _)| groups[index / 3])
            .map(|(index, &channel)| Component { channel, index })
    }
}

impl std::fmt::Display for AovSet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let names = [
            (self.albedo, "albedo"),
            (self.normal, "normal"),
            (self.depth, "depth"),
            (self.lengths > 0, "bounces"),
        ];
        let names: Vec<_> = names.iter().filter(|n| n.0).map(|n| n.1).collect();
        f.write_str(&names.join(","))
    }
}

impl std::str::FromStr for AovSet {
    type Err = Error;

    /// From a comma-separated list; an empty text is the empty set. [`Error::Usage`] at an unknown name.
    fn from_str(list: &str) -> Result<Self> {
        let mut set = Self::default();
        for name in list.split(',').map(str::trim).filter(|n| !n.is_empty()) {
            match name {
                "albedo" => set.albedo = true,
                "normal" => set.normal = true,
                "depth" => set.depth = true,
                "bounces" => set.lengths = Self::EVERY_LENGTH,
                _ => {
                    let near = Self::NAMES
                        .split(", ")
                        .find(|known| strsim::damerau_levenshtein(known, name) <= 2)
                        .map_or(String::new(), |known| {
                            format!("; did you mean \"{known}\"?")
                        });
                    return Err(Error::Usage(format!(
                        "unknown AOV \"{name}\"{near} (there are {})",
                        Self::NAMES
                    )));
                }
            }
        }
        Ok(set)
    }
}
