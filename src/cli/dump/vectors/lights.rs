//! Lights: points drawn of them, and with which density a ray that meets one would have been drawn.

use super::page::{Case, Section, Topic};
use super::{one, pair, vector, wide};
use crate::error::Result;
use crate::lanes::{Rgbx8, Vec3x8, u32x8};
use crate::scene::{Scene, toml};
use glam::Vec3;

/// The camera that a scene needs, and no light sees.
const CAMERA: &str = "version = 1\n[camera]\nposition = [0.0, 0.0, 4.0]\nlook_at = [0.0, 0.0, 0.0]\nvertical_fov = 45.0\n";

const SPHERE: &str =
    "[[lights]]\nsphere = { center = [0.0, 2.0, 0.0], radius = 0.5 }\nradiance = [4.0, 3.0, 2.0]\n";
const QUAD: &str = "[[lights]]\nquad = { corner = [-1.0, 2.0, -1.0], u = [2.0, 0.0, 0.0], v = [0.0, 0.0, 2.0] }\nradiance = [1.0, 2.0, 4.0]\n";
const DIM: &str = "[[lights]]\nsphere = { center = [1.0, 0.0, 0.0], radius = 0.25 }\nradiance = [1e-6, 1e-6, 1e-6]\n";
const PUNCTUAL: &str = "[[lights]]\npoint = { position = [0.0, 2.0, 0.0], intensity = [1.0, 2.0, 3.0] }\n\
                        [[lights]]\nspot = { position = [1.0, 2.0, 0.0], direction = [0.0, -1.0, 0.0], intensity = [8.0, 8.0, 8.0], \
                        outer_degrees = 60.0, inner_degrees = 30.0 }\n\
                        [[lights]]\ndistant = { direction = [0.0, -1.0, 0.0], irradiance = [0.5, 0.5, 0.5] }\n";
const CONSTANT: &str = "[environment]\nconstant = [1.0, 0.5, 0.25]\n";
const GRADIENT: &str = "[environment]\ngradient = { zenith = [0.5, 1.0, 2.0], horizon = [1.0, 1.0, 1.0], ground = [0.25, 0.125, 0.0] }\n";

/// Points of the scene that lights are seen from: below them, far away, inside the sphere, above the quad.
const FROM: [Vec3; 4] = [
    Vec3::new(0.25, 0.0, -0.5),
    Vec3::new(40.0, -30.0, 20.0),
    Vec3::new(0.0, 1.75, 0.125),
    Vec3::new(0.0, 3.0, 0.25),
];

/// Random numbers: of the choice, of the point (2).
const DRAWS: [[f32; 3]; 4] = [
    [0.0625, 0.5, 0.5],
    [0.375, 0.125, 0.75],
    [0.6875, 0.875, 0.25],
    [0.984375, 0.3125, 0.0625],
];

/// Directions and distances of rays that meet light.
const MET: [(Vec3, f32); 3] = [
    (Vec3::Y, 2.0),
    (Vec3::new(0.28, 0.96, 0.0), 2.25),
    (Vec3::new(0.0, -0.6, 0.8), 1.0),
];

pub(super) fn topic() -> Result<Topic> {
    Ok(Topic {
        name: "lights",
        about: "Lights as seen from a point: specification, section 9. sample: a light by choice, a point of it by u; direction is \
                unit, distance in scene units (null: infinite), radiance what arrives, inverse_pdf in steradians, the choice included, \
                0 where nothing arrives; of a light without a surface (punctual) only the choice is in it, and radiance is \
                irradiance on a surface that faces it. met: what a ray of that direction and distance sees of light number light, \
                and the density with which sample would have drawn it. sky: the same of a ray that leaves the scene.",
        sections: vec![
            section("sphere", "One light.", SPHERE)?,
            section("quad", "One light; its front is down.", QUAD)?,
            section(
                "two",
                "Sphere and quad, chosen by power.",
                &[SPHERE, QUAD].concat(),
            )?,
            section(
                "dim",
                "A dim sphere beside a quad: chosen a thousandth as often as if both were alike.",
                &[DIM, QUAD].concat(),
            )?,
            section("punctual", "A point, a spot and a distant light.", PUNCTUAL)?,
            section("constant", "A sky alone.", CONSTANT)?,
            section("gradient", "A sky alone.", GRADIENT)?,
            section(
                "all",
                "All of them, and the gradient.",
                &[SPHERE, QUAD, PUNCTUAL, GRADIENT].concat(),
            )?,
        ],
    })
}

fn section(name: &'static str, about: &'static str, lights: &str) -> Result<Section> {
    let scene = scene(lights)?;
    let mut cases = Vec::new();
    for from in FROM {
        for draw in DRAWS {
            cases.push(sample(&scene, from, draw));
        }
    }
    let count = lights.matches("sphere").count() + lights.matches("quad").count();
    for light in 0..count as u32 {
        cases.extend(MET.map(|(direction, distance)| met(&scene, light, direction, distance)));
    }
    if scene.sky.is_some() {
        cases.extend(MET.map(|(direction, _)| sky(&scene, direction)));
    }
    Ok(Section {
        scene: Some(lights.to_owned()),
        ..Section::new(name, about, cases)
    })
}

/// The light of a scene file without the rest of it.
fn scene(lights: &str) -> Result<Scene> {
    let description = toml::parse(&(CAMERA.to_owned() + lights), "vectors", None)?;
    Ok(Scene::compile(&description))
}

fn sample(scene: &Scene, from: Vec3, [choice, u, v]: [f32; 3]) -> Case {
    let sample = scene.lights.sample(
        scene.sky.as_ref(),
        Vec3x8::splat(from),
        || pair([choice, 0.0]),
        pair([u, v]),
    );
    Case::new()
        .text("call", "sample")
        .floats("from", &from.to_array())
        .float("choice", choice)
        .floats("u", &[u, v])
        .floats("direction", &vector(sample.direction))
        .float("distance", one(sample.distance))
        .floats("radiance", &rgb(sample.radiance))
        .float("inverse_pdf", one(sample.inverse_pdf))
        .id("primitive", sample.primitive.to_array()[0])
        .flag("punctual", sample.is_punctual.all())
}

fn met(scene: &Scene, light: u32, direction: Vec3, distance: f32) -> Case {
    let origin = Vec3::new(0.25, 0.0, -0.5);
    let (radiance, pdf) = scene.lights.emitted(
        u32x8::splat(light),
        Vec3x8::splat(origin),
        Vec3x8::splat(direction),
        wide(distance),
    );
    Case::new()
        .text("call", "met")
        .whole("light", light)
        .floats("origin", &origin.to_array())
        .floats("direction", &direction.to_array())
        .float("distance", distance)
        .floats("radiance", &rgb(radiance))
        .float("pdf", one(pdf))
}

fn sky(scene: &Scene, direction: Vec3) -> Case {
    let (radiance, pdf) = match &scene.sky {
        Some(sky) => scene.lights.sky(sky, Vec3x8::splat(direction)),
        None => (Rgbx8::ZERO, wide(0.0)),
    };
    Case::new()
        .text("call", "sky")
        .floats("direction", &direction.to_array())
        .floats("radiance", &rgb(radiance))
        .float("pdf", one(pdf))
}

fn rgb(color: Rgbx8) -> [f32; 3] {
    color.lane(0).to_array()
}
