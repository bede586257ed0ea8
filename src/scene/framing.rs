//! A camera and a sky for files that have none.

use super::description::{Camera, Environment};
use crate::lanes::Rgb;
use glam::{DVec3, Vec3};

/// Degrees.
const VERTICAL_FOV: f32 = 40.0;
/// From the middle of what is seen towards the camera: from the front and the right, and from above.
const TOWARDS_CAMERA: DVec3 = DVec3::new(0.5, 0.45, 0.74);

/// A three-quarter view from above of all between two corners of a box, world space: its circumscribed sphere fits into a
/// square image.
pub fn frame(low: Vec3, high: Vec3) -> Camera {
    let (low, high) = (low.as_dvec3(), high.as_dvec3());
    let middle = 0.5 * (low + high);
    // Far enough from a single point to have a direction, in 32-bit floats too.
    let radius = (0.5 * (high - low).length())
        .max(1e-6 * middle.length())
        .max(1e-6);
    let distance = radius / f64::from(0.5 * VERTICAL_FOV).to_radians().sin();
    let position = middle + distance * TOWARDS_CAMERA.normalize();
    Camera {
        position: position.as_vec3(),
        look_at: middle.as_vec3(),
        up: Vec3::Y,
        vertical_fov: VERTICAL_FOV,
        aperture_radius: 0.0,
        focus_distance: distance as f32,
    }
}

/// A bright overcast sky over a darker ground.
pub fn soft_sky() -> Environment {
    Environment::Gradient {
        zenith: Rgb::new(1.1, 1.15, 1.25),
        horizon: Rgb::new(0.75, 0.75, 0.75),
        ground: Rgb::new(0.2, 0.19, 0.18),
    }
}
