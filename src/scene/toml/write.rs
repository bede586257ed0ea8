//! Parts of a scene as TOML, such that reading them gives the same bits.

use crate::lanes::Rgb;
use crate::material::Material;
use crate::scene::description::Camera;
use glam::Vec3;

/// A finite number in the fewest digits that are read as the same 32 bits, with a decimal point or an exponent:
/// `1.0`, `0.1`, `-0.0`, `1e-7`.
pub fn float(value: f32) -> String {
    // Decimals are read straight to 32 bits, which Rust's shortest ones are made for.
    format!("{value:?}")
}

/// A camera as the table of one, in one line: `{ position = [...], look_at = [...], ... }`; all of its keys are there.
pub fn camera(camera: &Camera) -> String {
    format!(
        "{{ position = {}, look_at = {}, up = {}, vertical_fov = {}, aperture_radius = {}, focus_distance = {} }}",
        point(camera.position),
        point(camera.look_at),
        point(camera.up),
        float(camera.vertical_fov),
        float(camera.aperture_radius),
        float(camera.focus_distance)
    )
}

/// A material without its textures as the table of one, in one line: `{ type = "lambert", albedo = [0.8, 0.8, 0.8] }`; all of
/// its keys are there.
pub fn material(material: &Material) -> String {
    let parameters = match *material {
        Material::Lambert { albedo } => format!("albedo = {}", color(albedo)),
        Material::Mirror { reflectance } => format!("reflectance = {}", color(reflectance)),
        Material::Glass { ior } => format!("ior = {}", float(ior)),
        Material::Phong {
            diffuse,
            specular,
            exponent,
        } => format!(
            "diffuse = {}, specular = {}, exponent = {}",
            color(diffuse),
            color(specular),
            float(exponent)
        ),
        Material::Conductor {
            roughness,
            reflectance,
        } => format!(
            "roughness = {}, reflectance = {}",
            float(roughness),
            color(reflectance)
        ),
        Material::Principled {
            base_color,
            metallic,
            roughness,
            ior,
        } => format!(
            "base_color = {}, metallic = {}, roughness = {}, ior = {}",
            color(base_color),
            float(metallic),
            float(roughness),
            float(ior)
        ),
    };
    format!("{{ type = \"{}\", {parameters} }}", material.kind().name())
}

fn point(point: Vec3) -> String {
    list(point.to_array())
}

fn color(color: Rgb) -> String {
    list(color.to_array())
}

fn list(values: [f32; 3]) -> String {
    format!("[{}]", values.map(float).join(", "))
}
