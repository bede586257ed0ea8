//! What is shaded: a sphere, or the meshes of a file.

use crate::bvh::{HitX8, Ray, RayX8, Stacks};
use crate::error::{Error, Result};
use crate::film::Raster;
use crate::lanes::{Queue, Rgb, Rgbx8, Vec3x8, WIDTH, f32x8, u32x8};
use crate::scene::camera::Camera;
use crate::scene::description::{Description, Filter, Maps};
use crate::scene::{NONE, Scene, builtin, toml};
use glam::Vec3;
use rayon::prelude::*;

/// A unit sphere seen from +z, with a margin of a tenth of its radius, white.
const SPHERE: &str = "\
version = 1
[camera]
position = [0.0, 0.0, 3.216]
look_at = [0.0, 0.0, 0.0]
up = [0.0, 1.0, 0.0]
vertical_fov = 40.0
[film]
width = 512
height = 512
[materials.white]
type = \"lambert\"
albedo = [1.0, 1.0, 1.0]
[[objects]]
sphere = { center = [0.0, 0.0, 0.0], radius = 1.0 }
material = \"white\"
[environment]
constant = [1.0, 1.0, 1.0]
";

/// Rays through a pixel, in each direction: edges are smooth, and the picture depends on no random number.
const GRID: usize = 4;

/// The scene of a shape: `sphere`, or what a file or built-in scene holds, seen by its first camera or one that frames it.
///
/// # Errors
/// Those of the loaders.
pub(super) fn open(shape: &str) -> Result<Description> {
    let mut object = match shape {
        "sphere" => toml::parse(SPHERE, shape, None)?,
        file => builtin::open(file)?,
    };
    // Its form counts alone: without maps, nothing is cut out, and every mesh is in the opaque layer.
    for named in &mut object.materials {
        named.maps = Maps::default();
    }
    Ok(object)
}

/// The picture of a scene whose every point sends out what `shade` gives for its normal, on the side that is seen, and the way
/// to the camera; black where there is nothing.
///
/// The threads are those of the current rayon pool; they change no bit.
///
/// # Errors
/// [`Error::Usage`] where the scene has no camera or the picture no pixels.
pub(super) fn picture(
    description: &Description,
    (width, height): (u32, u32),
    shade: impl Fn(Vec3x8, Vec3x8) -> Rgbx8 + Sync,
) -> Result<Raster> {
    let camera = description
        .cameras
        .first()
        .ok_or_else(|| Error::Usage(format!("{} has no camera; add one", description.name)))?;
    let camera = Camera::new(&camera.camera, width, height, Filter::Box);
    let scene = Scene::compile(description);
    let mut pixels = vec![Rgb::BLACK; width as usize * height as usize];
    pixels
        .par_chunks_mut(width.max(1) as usize)
        .zip(0..height)
        .for_each_init(Stacks::default, |stacks, (pixels, y)| {
            row(&scene, &camera, y, &shade, stacks, pixels);
        });
    Raster::new(width as usize, pixels)
}

/// Adds to the black pixels of row `y`.
fn row(
    scene: &Scene,
    camera: &Camera,
    y: u32,
    shade: &impl Fn(Vec3x8, Vec3x8) -> Rgbx8,
    stacks: &mut Stacks,
    pixels: &mut [Rgb],
) {
    let samples = GRID * GRID;
    let mut rays: Queue<RayX8> = Queue::with_capacity(pixels.len() * samples);
    let middle = |i: usize| f32x8::splat((i as f32 + 0.5) / GRID as f32);
    for x in 0..pixels.len() {
        for sample in 0..samples {
            let (x, y) = (f32x8::splat(x as f32), f32x8::splat(y as f32));
            let inside = (middle(sample % GRID), middle(sample / GRID));
            let centre = (f32x8::HALF, f32x8::HALF);
            let (origin, direction) = camera.rays(x, y, inside, centre);
            rays.push_one(Ray::new(origin.lane(0), direction.lane(0)));
        }
    }
    let mut hits: Vec<HitX8> = rays
        .batches()
        .map(|(_, ray)| {
            let (distance, primitive) = scene.shapes.closest(ray.origin, ray.direction);
            HitX8 {
                distance,
                triangle: primitive,
                instance: u32x8::splat(NONE),
            }
        })
        .collect();
    if let Some(meshes) = &scene.meshes {
        meshes.opaque.tree.closest(&rays, &mut hits, stacks);
    }
    for (batch, ((live, ray), hit)) in rays.batches().zip(&mut hits).enumerate() {
        let (there, normal) = normals(scene, live, ray, hit);
        let towards = -ray.direction;
        let seen = normal.dot(towards).simd_ge(f32x8::ZERO);
        let normal = Vec3x8::select(seen, normal, -normal);
        let radiance = shade(normal, towards).masked(there);
        for lane in 0..WIDTH {
            let Some(pixel) = pixels.get_mut((batch * WIDTH + lane) / samples) else {
                continue;
            };
            let Rgb { r, g, b } = radiance.lane(lane);
            let share = 1.0 / samples as f32;
            *pixel = Rgb::new(
                r.mul_add(share, pixel.r),
                g.mul_add(share, pixel.g),
                b.mul_add(share, pixel.b),
            );
        }
    }
}

/// Where rays meet something, and its shading normals there.
fn normals(scene: &Scene, live: f32x8, ray: &RayX8, hit: &mut HitX8) -> (f32x8, Vec3x8) {
    let there = live & hit.distance.simd_lt(f32x8::splat(f32::INFINITY));
    let position = ray.direction.mul_add(hit.distance, ray.origin);
    let on_mesh = there & f32x8::from_bits(hit.instance.simd_ne(u32x8::splat(NONE)));
    let on_shape = there & !on_mesh;
    let mut normal = Vec3x8::splat(Vec3::Z);
    if on_shape.any() {
        let surface = scene.surface(hit.triangle, position);
        normal = Vec3x8::select(on_shape, surface.normal, normal);
    }
    if let Some(meshes) = scene.meshes.as_ref().filter(|_| on_mesh.any()) {
        meshes.resolve(&meshes.opaque, on_mesh, hit);
        let surface = meshes.surface(on_mesh, hit, position, -ray.direction);
        normal = Vec3x8::select(on_mesh, surface.ns, normal);
    }
    (there, normal)
}
