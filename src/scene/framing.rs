//! A camera and a sky for files that have none.

use super::description::{
    Camera, Description, Environment, FilmDescription, Filter, NamedCamera, RenderDefaults, Shape,
};
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

/// An overcast sky over a dark ground: what is white stands out against both.
pub fn soft_sky() -> Environment {
    Environment::Gradient {
        zenith: Rgb::new(1.1, 1.15, 1.25),
        horizon: Rgb::new(0.3, 0.32, 0.35),
        ground: Rgb::new(0.05, 0.048, 0.045),
    }
}

/// A description of nothing, to be filled by a loader.
pub(super) fn nothing(name: &str) -> Description {
    Description {
        name: name.to_owned(),
        hash: String::new(),
        written: None,
        cameras: Vec::new(),
        film: FilmDescription {
            width: 256,
            height: 256,
            filter: Filter::default(),
        },
        render: RenderDefaults::default(),
        materials: Vec::new(),
        objects: Vec::new(),
        lights: Vec::new(),
        punctual: Vec::new(),
        environment: None,
        meshes: Vec::new(),
        textures: Vec::new(),
        warnings: Vec::new(),
    }
}

/// Adds a camera and a sky where there is no camera and no light.
pub(super) fn complete(mut scene: Description) -> Description {
    if scene.cameras.is_empty() {
        let (low, high) = bounds(&scene);
        scene.cameras.push(NamedCamera {
            name: "camera".to_owned(),
            camera: frame(low, high),
        });
    }
    if scene.lights.is_empty() && scene.punctual.is_empty() && scene.environment.is_none() {
        scene.environment = Some(soft_sky());
    }
    scene
}

/// The lowest and the highest corner of the box around everything that has a surface, world space; infinities where nothing
/// has.
pub fn bounds(scene: &Description) -> (Vec3, Vec3) {
    let objects = scene.objects.iter().map(|object| &object.shape);
    let shapes = objects.chain(scene.lights.iter().map(|light| &light.shape));
    let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let mut widen = |low: Vec3, high: Vec3| {
        bounds = (bounds.0.min(low), bounds.1.max(high));
    };
    for shape in shapes {
        match *shape {
            Shape::Sphere { center, radius } => widen(center - radius, center + radius),
            Shape::Quad { corner, u, v } => {
                for point in [corner, corner + u, corner + v, corner + u + v] {
                    widen(point, point);
                }
            }
            Shape::Mesh { mesh, transform } => {
                for &point in &scene.meshes[mesh].positions {
                    let point = transform.transform_point3(point);
                    widen(point, point);
                }
            }
        }
    }
    bounds
}
