//! Materials as JSON has them.

use crate::error::{Error, Result};
use crate::lanes::Rgb;
use crate::material::{self, Kind, Material};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A material by the name and the parameters of its type, as scene files have them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MaterialValues {
    /// Name of the type.
    #[serde(rename = "type")]
    pub kind: String,
    /// Each parameter by name.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, Parameter>,
}

/// A parameter of a material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Parameter {
    /// A number.
    Number(f32),
    /// Linear RGB.
    Color([f32; 3]),
}

impl From<material::Parameter> for Parameter {
    fn from(parameter: material::Parameter) -> Self {
        match parameter {
            material::Parameter::Number(number) => Self::Number(number),
            material::Parameter::Color(color) => Self::Color(color.to_array()),
        }
    }
}

impl MaterialValues {
    /// The material; whether its parameters are in their ranges is for the scene's reader to say.
    ///
    /// # Errors
    /// [`Error::Usage`] where there is no such type, or its parameters are others.
    pub fn material(&self) -> Result<Material> {
        let kind = Kind::ALL.into_iter().find(|kind| kind.name() == self.kind);
        let kind = kind
            .ok_or_else(|| Error::Usage(format!("there is no material of type {:?}", self.kind)))?;
        let number = |name: &str| match self.parameters.get(name) {
            Some(&Parameter::Number(number)) => Ok(number),
            _ => Err(self.lacks(name, "a number")),
        };
        let color = |name: &str| match self.parameters.get(name) {
            Some(&Parameter::Color([r, g, b])) => Ok(Rgb::new(r, g, b)),
            _ => Err(self.lacks(name, "a colour")),
        };
        let material = match kind {
            Kind::Lambert => Material::Lambert {
                albedo: color("albedo")?,
            },
            Kind::Mirror => Material::Mirror {
                reflectance: color("reflectance")?,
            },
            Kind::Glass => Material::Glass {
                ior: number("ior")?,
            },
            Kind::Phong => Material::Phong {
                diffuse: color("diffuse")?,
                specular: color("specular")?,
                exponent: number("exponent")?,
            },
            Kind::Conductor => Material::Conductor {
                roughness: number("roughness")?,
                reflectance: color("reflectance")?,
            },
            Kind::Principled => Material::Principled {
                base_color: color("base_color")?,
                metallic: number("metallic")?,
                roughness: number("roughness")?,
                ior: number("ior")?,
            },
        };
        let known = material.parameters();
        let is_known = |name: &String| known.iter().any(|(known, _)| known == name);
        match self.parameters.keys().find(|name| !is_known(name)) {
            Some(other) => Err(Error::Usage(format!(
                "a material of type {:?} has no {other:?}",
                self.kind
            ))),
            None => Ok(material),
        }
    }

    fn lacks(&self, name: &str, what: &str) -> Error {
        Error::Usage(format!(
            "a material of type {:?} has {what} for {name:?}",
            self.kind
        ))
    }
}

impl From<&Material> for MaterialValues {
    fn from(material: &Material) -> Self {
        let parameters = material.parameters().into_iter();
        Self {
            kind: material.kind().name().to_owned(),
            parameters: parameters
                .map(|(name, value)| (name.to_owned(), value.into()))
                .collect(),
        }
    }
}
