//! Lights without a mesh, and what area lights emit.

use super::files::Files;
use super::lexer::At;
use super::parameters::{Parameters, Textured};
use super::spectra::Spectrum;
use super::textures::Map;
use super::warnings::Warnings;
use crate::error::Result;
use crate::lanes::Rgb;
use crate::scene::description::Punctual;
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;
use std::path::PathBuf;

/// What an area light emits.
#[derive(Clone, Debug)]
pub(super) struct AreaLight {
    pub radiance: Rgb,
    pub two_sided: bool,
    pub map: Option<Map>,
}

/// What surrounds the scene.
pub(super) enum Infinite {
    Constant(Rgb),
    Image {
        path: PathBuf,
        factor: f32,
        /// To the world, which may be mirrored.
        to_world: DAffine3,
        at: At,
    },
}

/// What a light directive makes.
pub(super) enum Made {
    Punctual(Punctual),
    Infinite(Infinite),
    Nothing,
}

/// `AreaLightSource "diffuse"`.
pub(super) fn area(
    parameters: &Parameters,
    kind: &str,
    files: &Files,
    warnings: &mut Warnings,
) -> Result<AreaLight> {
    let at = &parameters.at;
    if kind != "diffuse" {
        warnings.tell_once(format!("area light {kind}"), at, || {
            format!("the area light {kind:?} is not supported; it is diffuse")
        });
    }
    if parameters.has("power") {
        warnings.tell(
            at,
            "the power of an area light is not supported; its L and scale are used",
        );
    }
    let map = parameters.text("filename")?;
    let map = map.map(|name| Map::of_file(files.path(name), true, at.clone()));
    Ok(AreaLight {
        radiance: scaled(emitted(parameters, "L", warnings)?, factor(parameters)?),
        two_sided: parameters.flag("twosided")?.unwrap_or(false),
        map,
    })
}

/// `LightSource`.
pub(super) fn light(
    parameters: &Parameters,
    kind: &str,
    to_world: DAffine3,
    files: &Files,
    warnings: &mut Warnings,
) -> Result<Made> {
    let at = &parameters.at;
    let power = |of_one: f64| -> Result<f64> {
        let wanted = parameters.float_in("power", "above 0", |power| power > 0.0)?;
        // pbrt-v4 divides by the power of a light whose radiance has luminance 1.
        Ok(wanted.map_or(1.0, |wanted| f64::from(wanted) / of_one))
    };
    let point = |name: &str, default: DVec3| -> Result<DVec3> {
        Ok(parameters.point(name)?.unwrap_or(default))
    };
    let place = |point: DVec3| {
        let point = to_world.transform_point3(point);
        if point.abs().max_element() <= 1e9 {
            return Ok(point.as_vec3());
        }
        Err(at.error("this light is farther than 1e9 from the origin; move it"))
    };
    let direction = |from: DVec3, to: DVec3| {
        to_world
            .transform_vector3(to - from)
            .try_normalize()
            .map(DVec3::as_vec3)
            .ok_or_else(|| {
                at.error("this light shines nowhere: from and to are the same point; move either")
            })
    };
    let scale = factor(parameters)?;
    match kind {
        "point" | "goniometric" => {
            if kind == "goniometric" {
                let _ = parameters.text("filename")?;
                warnings.tell(
                    at,
                    "a goniometric light is not supported; it shines alike in all directions",
                );
            }
            Ok(Made::Punctual(Punctual::Point {
                position: place(point("from", DVec3::ZERO)?)?,
                intensity: scaled(
                    emitted(parameters, "I", warnings)?,
                    scale * power(4.0 * PI)?,
                ),
            }))
        }
        "spot" => {
            let (from, to) = (point("from", DVec3::ZERO)?, point("to", DVec3::Z)?);
            let is_angle = |angle: f32| (0.0..=180.0).contains(&angle);
            let outer = parameters.float_in("coneangle", "from 0 to 180 degrees", is_angle)?;
            let delta = parameters.float_in("conedeltaangle", "from 0 to 180 degrees", is_angle)?;
            let outer = f64::from(outer.unwrap_or(30.0).max(0.1));
            let inner = (outer - f64::from(delta.unwrap_or(5.0))).max(0.0);
            // An edge has some width.
            let cosine = |degrees: f64| libm::cos(degrees.to_radians());
            let (cos_inner, cos_outer) = (cosine(inner.min(outer - 0.05)), cosine(outer));
            let of_one = 2.0 * PI * ((1.0 - cos_inner) + (cos_inner - cos_outer) / 2.0);
            Ok(Made::Punctual(Punctual::Spot {
                position: place(from)?,
                direction: direction(from, to)?,
                intensity: scaled(emitted(parameters, "I", warnings)?, scale * power(of_one)?),
                cos_inner: cos_inner as f32,
                cos_outer: cos_outer as f32,
            }))
        }
        "distant" => {
            let (from, to) = (point("from", DVec3::ZERO)?, point("to", DVec3::Z)?);
            let illuminance = parameters.float_in("illuminance", "above 0", |lux| lux > 0.0)?;
            Ok(Made::Punctual(Punctual::Distant {
                direction: direction(from, to)?,
                irradiance: scaled(
                    emitted(parameters, "L", warnings)?,
                    scale * illuminance.map_or(1.0, f64::from),
                ),
            }))
        }
        "infinite" => {
            if parameters.has("portal") {
                warnings.tell(
                    at,
                    "the portal of an infinite light is not used; the image stays the same",
                );
            }
            let illuminance = parameters.float_in("illuminance", "above 0", |lux| lux > 0.0)?;
            if let Some(name) = parameters.text("filename")? {
                if illuminance.is_some() {
                    warnings.tell(
                        at,
                        "the illuminance of an image is not supported; its scale alone is used",
                    );
                }
                return Ok(Made::Infinite(Infinite::Image {
                    path: files.path(name),
                    factor: scale as f32,
                    to_world,
                    at: at.clone(),
                }));
            }
            // The irradiance below a sky of radiance 1 is π.
            let scale = scale * illuminance.map_or(1.0, |lux| f64::from(lux) / PI);
            let radiance = scaled(emitted(parameters, "L", warnings)?, scale);
            Ok(Made::Infinite(Infinite::Constant(radiance)))
        }
        _ => {
            warnings.tell_once(format!("light {kind}"), at, || {
                format!("the light {kind:?} is not supported; it is left out")
            });
            Ok(Made::Nothing)
        }
    }
}

fn factor(parameters: &Parameters) -> Result<f64> {
    let scale = parameters.float_in("scale", "at least 0", |scale| scale >= 0.0)?;
    Ok(scale.map_or(1.0, f64::from))
}

/// The colour of a light: white where nothing is said.
fn emitted(parameters: &Parameters, name: &str, warnings: &mut Warnings) -> Result<Rgb> {
    let spectrum = match parameters.textured(name)? {
        None => return Ok(Rgb::WHITE),
        Some(Textured::Constant(spectrum)) => spectrum,
        Some(Textured::Texture(_, at)) => {
            return Err(at.error(format!(
                "{name} of a light is a colour, not a texture; write \"rgb {name}\" [r g b]"
            )));
        }
    };
    Ok(spectrum.emitted().unwrap_or_else(|| {
        let named = match spectrum {
            Spectrum::Named(name) => format!("the spectrum {name:?}"),
            _ => "this spectrum".to_owned(),
        };
        warnings.tell_once("emitted".to_owned(), &parameters.at, || {
            format!("{named} is not known; the light is white")
        });
        Rgb::WHITE
    }))
}

/// Finite whatever the factors.
fn scaled(color: Rgb, factor: f64) -> Rgb {
    let scale = |channel: f32| (f64::from(channel) * factor).min(f64::from(f32::MAX)) as f32;
    Rgb::new(scale(color.r), scale(color.g), scale(color.b))
}
