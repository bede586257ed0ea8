//! A camera and a sky for files without.
use super::description::{Camera, Environment};
use crate::lanes::Rgb;
use glam::Vec3;

/// A camera that sees the whole box.
pub fn frame(low: Vec3, high: Vec3) -> Camera {
    let center = (low + high) / 2.0;
    Camera {
        position: center + Vec3::new(0.0, 0.0, 2.0 * (high - low).length()),
        look_at: center,
        up: Vec3::Y,
        vertical_fov: 40.0,
        aperture_radius: 0.0,
        focus_distance: 1.0,
    }
}

/// A sky.
pub fn soft_sky() -> Environment {
    Environment::Constant(Rgb::WHITE)
}
