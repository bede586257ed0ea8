//! The parameters of materials by name, for those who write, show or change them.

use super::Material;
use crate::lanes::Rgb;

/// The value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameter {
    /// A number.
    Number(f32),
    /// Linear RGB.
    Color(Rgb),
}

impl Material {
    /// Each parameter by its name in scene files.
    pub fn parameters(&self) -> Vec<(&'static str, Parameter)> {
        use Parameter::{Color, Number};
        match *self {
            Material::Lambert { albedo } => vec![("albedo", Color(albedo))],
            Material::Mirror { reflectance } => vec![("reflectance", Color(reflectance))],
            Material::Glass { ior } => vec![("ior", Number(ior))],
            Material::Phong {
                diffuse,
                specular,
                exponent,
            } => vec![
                ("diffuse", Color(diffuse)),
                ("specular", Color(specular)),
                ("exponent", Number(exponent)),
            ],
            Material::Conductor {
                roughness,
                reflectance,
            } => vec![
                ("roughness", Number(roughness)),
                ("reflectance", Color(reflectance)),
            ],
            Material::Principled {
                base_color,
                metallic,
                roughness,
                ior,
            } => vec![
                ("base_color", Color(base_color)),
                ("metallic", Number(metallic)),
                ("roughness", Number(roughness)),
                ("ior", Number(ior)),
            ],
        }
    }
}
