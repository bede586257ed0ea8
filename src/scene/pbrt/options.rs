//! What is said before the world: camera, film, sampler, integrator and pixel filter.

use super::parameters::Parameters;
use super::warnings::Warnings;
use crate::error::Result;
use crate::film::MAX_SAMPLES;
use crate::scene::description::{Camera, Filter, MAX_EDGES, MAX_SIDE};
use glam::{DAffine3, DVec3};

/// The camera as the file has it, until the size of the film is known.
pub(super) struct View {
    parameters: Parameters,
    kind: String,
    /// From the camera's space to the world.
    to_world: DAffine3,
}

/// Size of the film.
#[derive(Clone, Copy)]
pub(super) struct Film {
    pub width: u32,
    pub height: u32,
}

impl Default for Film {
    /// pbrt-v4's, `RGBFilm::Create`.
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
        }
    }
}

/// The reflection that makes a left-handed world right-handed.
pub(super) const MIRROR: DAffine3 = DAffine3 {
    matrix3: glam::DMat3::from_cols(DVec3::NEG_X, DVec3::Y, DVec3::Z),
    translation: DVec3::ZERO,
};

impl View {
    /// At a `Camera` directive: `world_to_camera` is the current transformation.
    pub fn new(parameters: Parameters, kind: &str, world_to_camera: DAffine3) -> Result<Self> {
        let to_world = world_to_camera.inverse();
        if !to_world.is_finite() {
            return Err(parameters.at.error(
                "the camera's transformation has no inverse; remove the scale of 0 before it",
            ));
        }
        Ok(Self {
            parameters,
            kind: kind.to_owned(),
            to_world,
        })
    }

    /// Camera space has +x right, +y up, +z forward: it is left-handed. So is the world then, unless the transformation
    /// mirrors, and it is mirrored as a whole to show in a right-handed one what pbrt shows.
    pub fn world(&self) -> DAffine3 {
        if self.to_world.matrix3.determinant() > 0.0 {
            MIRROR
        } else {
            DAffine3::IDENTITY
        }
    }

    /// The camera, in the mirrored world.
    pub fn camera(&self, film: Film, warnings: &mut Warnings) -> Result<Camera> {
        let parameters = &self.parameters;
        let at = &parameters.at;
        if self.kind != "perspective" {
            warnings.tell(
                at,
                format!(
                    "the camera {:?} is not supported; a perspective one stands in its place",
                    self.kind
                ),
            );
        }
        let to_world = self.world() * self.to_world;
        let axis = |v: DVec3| to_world.transform_vector3(v);
        let (right, up, forward) = (axis(DVec3::X), axis(DVec3::Y), axis(DVec3::Z));
        let lengths = [right, up, forward].map(DVec3::length);
        if !lengths.iter().all(|&length| (1e-9..=1e9).contains(&length))
            || right.cross(up).length() < 1e-4 * lengths[0] * lengths[1]
        {
            return Err(at.error(
                "the camera's transformation is too flat or its scale is not from 1e-9 to 1e9; correct it",
            ));
        }
        let skew = (right.dot(up) / (lengths[0] * lengths[1])).abs()
            + (forward.dot(up) / (lengths[2] * lengths[1])).abs()
            + (right.dot(forward) / (lengths[0] * lengths[2])).abs();
        if skew > 1e-3 || (lengths[0] / lengths[1] - 1.0).abs() > 1e-3 {
            warnings.tell(
                at,
                "the camera's transformation skews or stretches the image; only its axes are kept",
            );
        }
        let fov = parameters
            .float_in("fov", "above 0 and below 180 degrees", |fov| {
                fov > 0.0 && fov < 180.0
            })?
            .unwrap_or(90.0);
        let half_height = self.half_height(film, warnings)?;
        // The field of view is that of the half-width 1 of the screen.
        let tan =
            libm::tan(f64::from(fov).to_radians() / 2.0) * half_height * lengths[1] / lengths[2];
        let vertical_fov = (2.0 * libm::atan(tan)).to_degrees() as f32;
        if !(vertical_fov > 0.0 && vertical_fov < 180.0) {
            return Err(at.error(format!(
                "the vertical field of view comes to {vertical_fov} degrees; correct fov or screenwindow"
            )));
        }
        let not_negative = |value: f32| (0.0..=1e9).contains(&value);
        let radius = parameters
            .float_in("lensradius", "from 0 to 1e9", not_negative)?
            .unwrap_or(0.0);
        let focus = parameters
            .float_in("focaldistance", "above 0", |distance| distance > 0.0)?
            .unwrap_or(1e6);
        let position = to_world.translation;
        if position.abs().max_element() > 1e9 {
            return Err(at.error("the camera is farther than 1e9 from the origin; move it"));
        }
        // Far enough that 32-bit coordinates keep the direction, wherever the camera stands.
        let distance = position.length().max(1.0);
        Ok(Camera {
            position: position.as_vec3(),
            look_at: (position + forward.normalize() * distance).as_vec3(),
            up: up.normalize().as_vec3(),
            vertical_fov,
            aperture_radius: (f64::from(radius) * lengths[0]).min(1e9) as f32,
            focus_distance: (f64::from(focus) * lengths[2]).clamp(1e-9, 1e9) as f32,
        })
    }

    /// Half the height of the screen window, whose shorter side is from −1 to 1 where nothing else is said.
    fn half_height(&self, film: Film, warnings: &mut Warnings) -> Result<f64> {
        let parameters = &self.parameters;
        let own = f64::from(film.width) / f64::from(film.height);
        let aspect = parameters
            .float_in("frameaspectratio", "from 1e-4 to 1e4", |ratio| {
                (1e-4..=1e4).contains(&ratio)
            })?
            .map_or(own, f64::from);
        let (width, height) = match parameters.floats("screenwindow", 1)? {
            None if aspect > 1.0 => (aspect, 1.0),
            None => (1.0, 1.0 / aspect),
            Some(&[left, right, bottom, top]) if right > left && top > bottom => {
                let [left, right, bottom, top] = [left, right, bottom, top].map(f64::from);
                if (left + right).abs() > 1e-4 * (right - left)
                    || (bottom + top).abs() > 1e-4 * (top - bottom)
                {
                    warnings.tell(
                        &parameters.at,
                        "a screenwindow off the axis is not supported; it is moved to the middle",
                    );
                }
                ((right - left) / 2.0, (top - bottom) / 2.0)
            }
            Some(_) => {
                return Err(parameters.at.error(
                    "screenwindow needs left < right and bottom < top; write \"float screenwindow\" [-1 1 -1 1]",
                ));
            }
        };
        if (width / height / own - 1.0).abs() > 1e-2 {
            warnings.tell(
                &parameters.at,
                "the frame's sides are not in the film's proportion; pixels are square here, and the height is kept",
            );
        }
        Ok(height)
    }
}

/// `Film`.
pub(super) fn film(parameters: &Parameters, warnings: &mut Warnings) -> Result<Film> {
    let default = Film::default();
    let side = |name, default: u32| {
        let side = parameters.integer(name, 1..=MAX_SIDE as i32)?;
        Ok(side.map_or(default, i32::unsigned_abs))
    };
    let sensor = [
        "sensor",
        "iso",
        "exposuretime",
        "imagingratio",
        "whitebalance",
    ];
    let given: Vec<&str> = sensor
        .into_iter()
        .filter(|name| parameters.has(name))
        .collect();
    if !given.is_empty() {
        warnings.tell(
            &parameters.at,
            format!(
                "the film's {} is not used: pixels are radiance, and the PNG has --exposure",
                given.join(", ")
            ),
        );
    }
    if parameters.has("cropwindow") || parameters.has("pixelbounds") {
        warnings.tell(
            &parameters.at,
            "the film's crop is not used; --crop x0,y0,x1,y1 does it",
        );
    }
    Ok(Film {
        width: side("xresolution", default.width)?,
        height: side("yresolution", default.height)?,
    })
}

/// `Sampler`: samples per pixel, if it says.
pub(super) fn samples(parameters: &Parameters) -> Result<Option<u32>> {
    let most = i32::try_from(MAX_SAMPLES).unwrap_or(i32::MAX);
    let count = |name| parameters.integer(name, 1..=most);
    let samples = match (count("xsamples")?, count("ysamples")?) {
        (None, None) => count("pixelsamples")?,
        (x, y) => Some(x.unwrap_or(4).saturating_mul(y.unwrap_or(4)).min(most)),
    };
    Ok(samples.map(i32::unsigned_abs))
}

/// `Integrator`: the path length. pbrt counts bounces, the path its edges; its default is 5.
pub(super) fn path_length(
    parameters: &Parameters,
    kind: &str,
    warnings: &mut Warnings,
) -> Result<u32> {
    let same_image = [
        "path",
        "volpath",
        "simplepath",
        "simplevolpath",
        "randomwalk",
        "bdpt",
        "mlt",
        "sppm",
        "lightpath",
    ];
    if !same_image.contains(&kind) {
        warnings.tell(
            &parameters.at,
            format!("the integrator {kind:?} is not supported; the scene is path traced"),
        );
    }
    let depth = parameters.integer("maxdepth", 0..=i32::MAX)?.unwrap_or(5);
    Ok(depth.unsigned_abs().saturating_add(1).min(MAX_EDGES))
}

/// `PixelFilter`: the closest there is.
pub(super) fn filter(
    parameters: &Parameters,
    kind: &str,
    warnings: &mut Warnings,
) -> Result<Filter> {
    let float = |name, default: f32| Ok(parameters.float(name)?.unwrap_or(default));
    // Radius, and sigma for the Gaussian: pbrt's defaults, and ours.
    let (filter, is_ours) = match kind {
        "box" => (
            Filter::Box,
            float("xradius", 0.5)? == 0.5 && float("yradius", 0.5)? == 0.5,
        ),
        "triangle" => (
            Filter::Tent,
            float("xradius", 2.0)? == 1.0 && float("yradius", 2.0)? == 1.0,
        ),
        "gaussian" => (
            Filter::Gaussian,
            float("xradius", 1.5)? == 1.5
                && float("yradius", 1.5)? == 1.5
                && float("sigma", 0.5)? == 0.5,
        ),
        _ => (Filter::Gaussian, false),
    };
    if !is_ours {
        warnings.tell(
            &parameters.at,
            format!("the pixel filter {kind:?} of this size is not supported; the image is filtered by {filter}"),
        );
    }
    Ok(filter)
}
