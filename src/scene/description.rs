//! A scene as its author wrote it: plain values, checked, before it is compiled into tables for the kernels.

pub use crate::texture::{Image, Pixels, Texture, Wrap};

use super::mesh::Mesh;
use super::toml::names;
use crate::bvh::Quality;
use crate::error::Error;
use crate::lanes::Rgb;
use crate::material::Material;
use crate::sh::Probe;
use glam::{Affine3A, Vec3};
use std::sync::Arc;

/// A whole scene file.
#[derive(Clone, Debug)]
pub struct Description {
    /// Where it came from: a path as the user named it, or the name of a built-in scene.
    pub name: String,
    /// SHA-256, in hexadecimal, of the scene's text and of the files it names, and of what was changed in it.
    pub hash: String,
    /// What its own text says, where it is a .toml scene.
    pub written: Option<Written>,
    /// The cameras, in file order; the first renders unless another is asked for by name. At least one.
    pub cameras: Vec<NamedCamera>,
    /// Size and pixel filter.
    pub film: FilmDescription,
    /// What the scene would like to be rendered with.
    pub render: RenderDefaults,
    /// The materials, by index from objects and lights.
    pub materials: Vec<NamedMaterial>,
    /// What scatters.
    pub objects: Vec<Object>,
    /// What emits.
    pub lights: Vec<Light>,
    /// Lights without a surface.
    pub punctual: Vec<Punctual>,
    /// What surrounds everything.
    pub environment: Option<Environment>,
    /// Triangle meshes, by index from [`Shape::Mesh`].
    pub meshes: Vec<Arc<Mesh>>,
    /// Textures, by index from [`Maps`] and [`Light`].
    pub textures: Vec<Texture>,
    /// What was left out or replaced while reading, a line each, with its place: told on stderr.
    pub warnings: Vec<String>,
}

impl Description {
    /// The files that its sky and its textures are read from, with what they are: what no image may be written over. What
    /// is part of another file has a name that is no path.
    pub fn pictures(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let sky = match &self.environment {
            Some(Environment::Image { image, .. }) => Some(image.file.as_str()),
            Some(Environment::Harmonics(harmonics)) => Some(harmonics.source.as_str()),
            _ => None,
        };
        let textures = self.textures.iter();
        let textures = textures.map(|texture| ("texture", texture.image.file.as_str()));
        sky.map(|file| ("environment", file))
            .into_iter()
            .chain(textures)
    }
}

/// What a .toml scene says itself, beside the files it names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// Whether it has `[camera]`, rather than `[cameras.NAME]`.
    pub lone_camera: bool,
    /// How many of the materials, from the first, are its own.
    pub materials: usize,
}

/// A camera and its name; `camera` where the file has but `[camera]`.
#[derive(Clone, Debug)]
pub struct NamedCamera {
    /// The name for `--camera`.
    pub name: String,
    /// The camera.
    pub camera: Camera,
}

/// A perspective camera with a thin lens.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Centre of the lens, world space.
    pub position: Vec3,
    /// A point on the optical axis.
    pub look_at: Vec3,
    /// Not parallel to the axis; need not be unit.
    pub up: Vec3,
    /// Degrees, in (0, 180).
    pub vertical_fov: f32,
    /// Scene units; 0 is a pinhole.
    pub aperture_radius: f32,
    /// Distance along the axis at which all is sharp; above 0.
    pub focus_distance: f32,
}

/// Size and pixel filter.
#[derive(Clone, Copy, Debug)]
pub struct FilmDescription {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// The pixel filter.
    pub filter: Filter,
}

/// A pixel filter, importance-sampled so that a sample belongs to one pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Filter {
    /// One pixel wide.
    #[default]
    Box,
    /// Two pixels wide.
    Tent,
    /// Standard deviation half a pixel, cut off at a radius of 1.5 pixels.
    Gaussian,
}

/// The most pixels on a side of an image: coordinates have 16 bits.
pub const MAX_SIDE: u32 = 65_535;

/// The most objects and lights of a scene.
pub const MOST_OBJECTS: usize = 1 << 24;

/// The most edges of a path.
pub const MAX_EDGES: u32 = 10_000;

/// What a scene would like to be rendered with; the command line overrides it. `None` is the program's default.
#[derive(Clone, Copy, Debug, Default)]
pub struct RenderDefaults {
    /// Samples per pixel.
    pub spp: Option<u32>,
    /// Greatest number of edges of a path.
    pub path_length: Option<u32>,
    /// Estimator.
    pub strategy: Option<Strategy>,
    /// Source of random numbers.
    pub sampler: Option<SamplerKind>,
    /// Seed.
    pub seed: Option<u64>,
    /// First path edge at which Russian roulette may end a path; none without it.
    pub roulette: Option<u32>,
}

/// How light is looked for. All converge to the same image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Hash)]
pub enum Strategy {
    /// Directions uniform over the hemisphere; light is found by hitting it.
    Uniform,
    /// Directions drawn from the BSDF; light is found by hitting it.
    Cosine,
    /// Light sources are sampled at every vertex; the BSDF only continues the path.
    Light,
    /// Both, combined by the power heuristic.
    #[default]
    Mis,
}

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Hash)]
pub enum SamplerKind {
    /// Independent numbers.
    Pcg,
    /// Owen-scrambled Sobol' pairs.
    #[default]
    Sobol,
}

/// A material and its name.
#[derive(Clone, Debug)]
pub struct NamedMaterial {
    /// The name objects call it by.
    pub name: String,
    /// The material.
    pub material: Material,
    /// What varies over the surface.
    pub maps: Maps,
}

impl NamedMaterial {
    /// What a mesh without a material is made of.
    pub fn white() -> Self {
        Self {
            name: "white".to_owned(),
            material: Material::Lambert {
                albedo: Rgb::new(0.8, 0.8, 0.8),
            },
            maps: Maps::default(),
        }
    }
}

/// The textures of a material, by index into [`Description::textures`]; each multiplies what the material says.
///
/// A quad has texture coordinates from 0 to 1 along `u` and `v`; a sphere has none, and is as if it had no maps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Maps {
    /// Albedo, reflectance, diffuse or base colour.
    pub color: Option<usize>,
    /// Roughness (green) and metallic (blue), as glTF packs them.
    pub metallic_roughness: Option<usize>,
    /// Tangent-space normals, and the factor of their x and y.
    pub normal: Option<(usize, f32)>,
    /// Cut-out: the surface is there where alpha is at least the cut-off.
    pub alpha: Option<Alpha>,
}

impl Maps {
    /// All textures that it names, by index.
    pub fn textures(&self) -> impl Iterator<Item = usize> {
        let normal = self.normal.map(|(texture, _)| texture);
        let alpha = self.alpha.and_then(|alpha| alpha.texture);
        [self.color, self.metallic_roughness, normal, alpha]
            .into_iter()
            .flatten()
    }
}

/// An alpha cut-out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alpha {
    /// The texture whose alpha channel counts; 1 everywhere without it.
    pub texture: Option<usize>,
    /// Multiplies it.
    pub factor: f32,
    /// Least alpha of what is there.
    pub cutoff: f32,
}

/// A shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A sphere; its normal points outwards.
    Sphere {
        /// World space.
        center: Vec3,
        /// Above 0.
        radius: f32,
    },
    /// A parallelogram `corner + a·u + b·v`, a and b in [0, 1]; its normal is `cross(u, v)`.
    Quad {
        /// World space.
        corner: Vec3,
        /// First edge.
        u: Vec3,
        /// Second edge.
        v: Vec3,
    },
    /// A triangle mesh; its normals are those of its corners in counter-clockwise order.
    Mesh {
        /// Index into [`Description::meshes`].
        mesh: usize,
        /// From the mesh's space to the world; invertible.
        transform: Affine3A,
    },
}

/// Something that scatters.
#[derive(Clone, Copy, Debug)]
pub struct Object {
    /// Its shape.
    pub shape: Shape,
    /// Index into the materials.
    pub material: usize,
}

/// A shape that emits.
#[derive(Clone, Copy, Debug)]
pub struct Light {
    /// Its shape.
    pub shape: Shape,
    /// W·sr⁻¹·m⁻², the same in every direction; not negative.
    pub radiance: Rgb,
    /// Whether it also emits on the inside of a sphere, the back of a quad.
    pub two_sided: bool,
    /// Index into the materials, where it also scatters.
    pub material: Option<usize>,
    /// Multiplies the radiance of a mesh: index into [`Description::textures`].
    pub texture: Option<usize>,
}

/// A light without a surface: no ray can meet it, so every strategy samples it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Punctual {
    /// Shines alike in all directions.
    Point {
        /// World space.
        position: Vec3,
        /// W·sr⁻¹ in each channel.
        intensity: Rgb,
    },
    /// A point light with a cone.
    Spot {
        /// World space.
        position: Vec3,
        /// Unit, the axis along which it shines.
        direction: Vec3,
        /// W·sr⁻¹ in each channel, on the axis.
        intensity: Rgb,
        /// Cosine of the angle to which it shines in full; above `cos_outer`.
        cos_inner: f32,
        /// Cosine of the angle beyond which it is dark.
        cos_outer: f32,
    },
    /// Parallel rays, as from the sun.
    Distant {
        /// Unit, the way its light travels.
        direction: Vec3,
        /// W·m⁻² in each channel on a surface that faces it.
        irradiance: Rgb,
    },
}

impl Punctual {
    /// Where it is, world space; a distant light is nowhere.
    pub fn position(&self) -> Option<Vec3> {
        match *self {
            Punctual::Point { position, .. } | Punctual::Spot { position, .. } => Some(position),
            Punctual::Distant { .. } => None,
        }
    }
}

/// What surrounds everything.
#[derive(Clone, Debug)]
pub enum Environment {
    /// The same radiance from everywhere.
    Constant(Rgb),
    /// `L = horizon + (zenith|ground − horizon)·|d.y|`.
    Gradient {
        /// Radiance from +y.
        zenith: Rgb,
        /// Radiance from the horizon.
        horizon: Rgb,
        /// Radiance from −y.
        ground: Rgb,
    },
    /// A lat-long image, +y up.
    Image {
        /// Its pixels.
        image: std::sync::Arc<LatLong>,
        /// Turn around +y, degrees, counter-clockwise seen from above.
        rotate_degrees: f32,
    },
    /// Spherical harmonics.
    Harmonics(Harmonics),
}

/// Radiance by its spherical harmonics, in the axes of the world.
#[derive(Clone, Debug)]
pub struct Harmonics {
    /// Where they came from: a file, or the name of a light that is part of the program.
    pub source: String,
    /// Radiance, convolved with no lobe.
    pub probe: Probe,
    /// Turn around +y, degrees, counter-clockwise seen from above.
    pub rotate_degrees: f32,
    /// Whether radiance below 0 is cut off; what is band-limited rings below 0 around what is bright.
    pub clamp: bool,
}

/// A lat-long image of radiance: row 0 is at +y; each pixel is constant over its solid angle.
///
/// Column `x` covers the azimuths `φ = 2π·[x, x + 1) / width`, with the direction
/// `(sin θ · sin φ, cos θ, −sin θ · cos φ)`: the middle of the image looks along +z, its left edge along −z.
#[derive(Clone, Debug)]
pub struct LatLong {
    /// Where it came from.
    pub file: String,
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// Row-major; finite, not negative.
    pub pixels: Vec<Rgb>,
}

/// Writes `NAMES`, `Display` and `FromStr` of a choice from the one list of its names.
macro_rules! choices {
    ($type:ident, $what:literal: $($name:literal = $variant:ident),+) => {
        impl $type {
            /// Each choice and its name in scene files and on the command line.
            pub const NAMES: &[(&str, Self)] = &[$(($name, Self::$variant)),+];
        }

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(match self { $(Self::$variant => $name),+ })
            }
        }

        impl std::str::FromStr for $type {
            type Err = $crate::error::Error;

            fn from_str(name: &str) -> std::result::Result<Self, $crate::error::Error> {
                $crate::scene::description::choose($what, name, Self::NAMES)
            }
        }
    };
}

pub(crate) use choices;
choices!(Strategy, "strategy": "uniform" = Uniform, "cosine" = Cosine, "light" = Light, "mis" = Mis);
choices!(SamplerKind, "sampler": "pcg" = Pcg, "sobol" = Sobol);
choices!(Quality, "tree": "fast" = Fast, "best" = Best);
choices!(Wrap, "wrap": "repeat" = Repeat, "mirror" = Mirror, "clamp" = Clamp);
choices!(Filter, "filter": "box" = Box, "tent" = Tent, "gaussian" = Gaussian);

/// The choice of that name, or an error that lists all.
pub(crate) fn choose<T: Copy>(what: &str, name: &str, choices: &[(&str, T)]) -> Result<T, Error> {
    if let Some(&(_, choice)) = choices.iter().find(|(known, _)| *known == name) {
        return Ok(choice);
    }
    let known = || choices.iter().map(|&(known, _)| known);
    let hint = match names::did_you_mean(name, known()) {
        hint if hint.is_empty() => ".".to_owned(),
        hint => hint,
    };
    let name = names::quoted(name);
    let list = names::list(known());
    Err(Error::Usage(format!(
        "unknown {what} {name}{hint} Known: {list}"
    )))
}
