//! Floor 2: materials. One file per BSDF, eight lanes at a time; a kernel never branches on the kind.

mod conductor;
mod ggx;
mod glass;
mod lambert;
mod mirror;
mod parameters;
mod phong;
mod principled;

pub use conductor::Conductor;
pub use glass::Glass;
pub use lambert::Lambert;
pub use mirror::Mirror;
pub use parameters::Parameter;
pub use phong::Phong;
pub use principled::Principled;

use crate::lanes::{Rgb, Rgbx8, Row, Table, Vec3x8, f32x8, u32x8};

/// A material as a scene describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Material {
    /// Ideal diffuse reflection: `albedo / π`. Two-sided.
    Lambert {
        /// Hemispherical reflectance, each channel in [0, 1].
        albedo: Rgb,
    },
    /// Ideal specular reflection. Two-sided.
    Mirror {
        /// Fraction reflected at any angle, each channel in [0, 1].
        reflectance: Rgb,
    },
    /// A smooth dielectric: Fresnel reflection and refraction, total internal reflection.
    Glass {
        /// Index of refraction inside (behind the normal) over outside; above 0.
        ior: f32,
    },
    /// Normalised modified Phong: `diffuse / π + specular · (n + 2) / 2π · cosⁿα` (Lafortune & Willems 1994). Two-sided.
    Phong {
        /// Diffuse reflectance; with `specular` at most 1 per channel.
        diffuse: Rgb,
        /// Specular reflectance.
        specular: Rgb,
        /// The exponent n, at least 0.
        exponent: f32,
    },
    /// A rough conductor: GGX, Smith masking, constant Fresnel reflectance. Two-sided.
    Conductor {
        /// GGX alpha (not squared), in (0, 1].
        roughness: f32,
        /// Fresnel reflectance at any angle.
        reflectance: Rgb,
    },
    /// The metallic-roughness model of glTF 2.0 (appendix B): a diffuse base under a GGX coat, or a GGX metal. Two-sided.
    Principled {
        /// Albedo of the dielectric, reflectance of the metal.
        base_color: Rgb,
        /// 0 dielectric, 1 metal.
        metallic: f32,
        /// Perceptual, in [0, 1]; GGX alpha is its square, and at least 10⁻⁴.
        roughness: f32,
        /// Of the coat, at least 1; 1.5 is what glTF has unless it says otherwise.
        ior: f32,
    },
}

/// Which kernel shades a material: the index of its shading queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Kind {
    /// [`Material::Lambert`].
    Lambert,
    /// [`Material::Mirror`].
    Mirror,
    /// [`Material::Glass`].
    Glass,
    /// [`Material::Phong`].
    Phong,
    /// [`Material::Conductor`].
    Conductor,
    /// [`Material::Principled`].
    Principled,
}

impl Kind {
    /// Every kind, in the order of their queues.
    pub const ALL: [Kind; 6] = [
        Kind::Lambert,
        Kind::Mirror,
        Kind::Glass,
        Kind::Phong,
        Kind::Conductor,
        Kind::Principled,
    ];

    /// Its name, as in scene files.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Lambert => "lambert",
            Kind::Mirror => "mirror",
            Kind::Glass => "glass",
            Kind::Phong => "phong",
            Kind::Conductor => "conductor",
            Kind::Principled => "principled",
        }
    }

    /// [`Bsdf::TRANSMISSIVE`] of its BSDF.
    pub fn transmits(self) -> bool {
        match self {
            Kind::Lambert => Lambert::TRANSMISSIVE,
            Kind::Mirror => Mirror::TRANSMISSIVE,
            Kind::Glass => Glass::TRANSMISSIVE,
            Kind::Phong => Phong::TRANSMISSIVE,
            Kind::Conductor => Conductor::TRANSMISSIVE,
            Kind::Principled => Principled::TRANSMISSIVE,
        }
    }
}

impl Material {
    /// Which kernel shades it.
    pub fn kind(&self) -> Kind {
        match self {
            Material::Lambert { .. } => Kind::Lambert,
            Material::Mirror { .. } => Kind::Mirror,
            Material::Glass { .. } => Kind::Glass,
            Material::Phong { .. } => Kind::Phong,
            Material::Conductor { .. } => Kind::Conductor,
            Material::Principled { .. } => Kind::Principled,
        }
    }

    /// The colour of the albedo layer: the reflectance, or white where all light goes on.
    pub fn albedo(&self) -> Rgb {
        match *self {
            Material::Lambert { albedo } => albedo,
            Material::Mirror { reflectance } | Material::Conductor { reflectance, .. } => {
                reflectance
            }
            Material::Principled { base_color, .. } => base_color,
            Material::Glass { .. } => Rgb::WHITE,
            Material::Phong {
                diffuse, specular, ..
            } => Rgb::new(
                diffuse.r + specular.r,
                diffuse.g + specular.g,
                diffuse.b + specular.b,
            ),
        }
    }

    /// Its parameters as the kernels read them; the meaning of each field is the BSDF's own.
    pub fn row(&self) -> Row {
        match *self {
            Material::Lambert { albedo } => Lambert::row(albedo),
            Material::Mirror { reflectance } => Mirror::row(reflectance),
            Material::Glass { ior } => Glass::row(ior),
            Material::Phong {
                diffuse,
                specular,
                exponent,
            } => Phong::row(diffuse, specular, exponent),
            Material::Conductor {
                roughness,
                reflectance,
            } => Conductor::row(roughness, reflectance),
            Material::Principled {
                base_color,
                metallic,
                roughness,
                ior,
            } => Principled::row(base_color, metallic, roughness, ior),
        }
    }
}

/// The value of a BSDF for a pair of directions.
#[derive(Clone, Copy, Debug)]
pub struct EvalX8 {
    /// BSDF × |cos θi|, per steradian.
    pub value: Rgbx8,
    /// Density with which [`Bsdf::sample`] draws this direction, per steradian.
    pub pdf: f32x8,
}

impl EvalX8 {
    /// No light in any lane: what a discrete lobe has for any two directions that are given.
    pub const NONE: Self = Self {
        value: Rgbx8::ZERO,
        pdf: f32x8::ZERO,
    };
}

/// A direction drawn from a BSDF.
#[derive(Clone, Copy, Debug)]
pub struct SampleX8 {
    /// The drawn direction, local frame, unit, away from the surface.
    pub wi: Vec3x8,
    /// BSDF × |cos θi| ÷ pdf; zero where no valid direction was found.
    pub weight: Rgbx8,
    /// Density per steradian, as [`Bsdf::eval`] gives it; +∞ for a discrete (specular) choice.
    pub pdf: f32x8,
}

/// What textures make of eight materials: factors of their parameters.
#[derive(Clone, Copy, Debug)]
pub struct ModulationX8 {
    color: Rgbx8,
    metallic: f32x8,
    roughness: f32x8,
}

impl ModulationX8 {
    /// From values of textures. They are cut off at 1: no material is made to reflect more than it says.
    #[inline]
    pub fn new(color: Rgbx8, metallic: f32x8, roughness: f32x8) -> Self {
        let cut = |factor: f32x8| factor.fast_min(f32x8::ONE);
        Self {
            color: Rgbx8::new(cut(color.r), cut(color.g), cut(color.b)),
            metallic: cut(metallic),
            roughness: cut(roughness),
        }
    }
}

/// A BSDF, eight lanes at a time.
///
/// Directions are unit vectors of the local shading frame (normal +z) and point away from the surface: `wo` towards where
/// the path came from, `wi` towards where it goes on. For opaque materials the frame is turned so that `wo.z ≥ 0`; a
/// [`TRANSMISSIVE`](Bsdf::TRANSMISSIVE) one keeps the outward normal and tells the side by the sign of `wo.z`.
pub trait Bsdf: Copy {
    /// Its shading queue.
    const KIND: Kind;
    /// Whether every direction is a discrete choice, so that no light sample can meet it.
    const SPECULAR: bool;
    /// Whether light passes through.
    const TRANSMISSIVE: bool;

    /// Reads the parameters of eight materials.
    fn load(table: &Table, ids: u32x8) -> Self;

    /// Multiplies the parameters that textures may vary: of each material its colour (of [`Phong`] the diffuse one, of
    /// [`Glass`] none), of [`Principled`] also metallic and roughness.
    fn modulate(self, by: &ModulationX8) -> Self;

    /// BSDF × |cos θi| and density; both zero for a specular BSDF and where `wi` or `wo` is below the surface.
    fn eval(&self, wo: Vec3x8, wi: Vec3x8) -> EvalX8;

    /// Draws `wi` by `direction` in [0, 1)², and by `lobe` in [0, 1) where there is more than one lobe.
    fn sample(&self, wo: Vec3x8, direction: (f32x8, f32x8), lobe: f32x8) -> SampleX8;
}
