//! The tree of triangles alone: building it, and tracing rays that keep together, rays that do not, and shadow rays.
//!
//! Landscapes of eight thousand and of half a million triangles; elements are triangles or rays. `ondine rays` measures
//! given rays on a given mesh.

use crate::common::case::{Case, Face, Pace};
use crate::common::landscape::Landscape;
use glam::{Affine3A, Vec3};
use ondine::bvh::{Bvh, HitX8, Instance, NO_TRIANGLE, Quality, Ray, RayX8, Stacks, Triangles};
use ondine::lanes::{Queue, WIDTH, f32x8, u32x8};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use std::hint::black_box;
use std::sync::LazyLock;

/// Rays on a side of the image.
const IMAGE: u32 = 64;
const PLAIN: Instance = Instance {
    mesh: 0,
    to_world: Affine3A::IDENTITY,
};

static LARGE: LazyLock<Landscape> = LazyLock::new(Landscape::large);
static LARGE_TREE: LazyLock<Bvh> = LazyLock::new(|| build(&LARGE, Quality::Fast));
static SMALL: LazyLock<Landscape> = LazyLock::new(Landscape::small);
static SMALL_TREE: LazyLock<Bvh> = LazyLock::new(|| build(&SMALL, Quality::Fast));

pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (quality, name) in [(Quality::Fast, "fast"), (Quality::Best, "best")] {
        let small = move |face: Face| building(&SMALL, quality, face);
        let large = move |face: Face| building(&LARGE, quality, face);
        cases.push(Case::new(format!("small/build/{name}"), Pace::Slow, small));
        cases.push(Case::timed(
            format!("large/build/{name}"),
            Pace::Slow,
            large,
        ));
    }
    for (name, tracing) in [
        ("closest/camera", closest_camera as fn(&Bvh, Face)),
        ("closest/bounced", closest_bounced),
        ("any/bounced", any_bounced),
    ] {
        let small = move |face: Face| tracing(&SMALL_TREE, face);
        let large = move |face: Face| tracing(&LARGE_TREE, face);
        cases.push(Case::new(format!("small/{name}"), Pace::Quick, small));
        cases.push(Case::timed(format!("large/{name}"), Pace::Quick, large));
    }
    cases
}

fn build(landscape: &Landscape, quality: Quality) -> Bvh {
    let mesh = Triangles {
        positions: &landscape.positions,
        corners: &landscape.corners,
    };
    Bvh::build(&[mesh], &[PLAIN], quality)
}

fn building(landscape: &Landscape, quality: Quality, face: Face) {
    face(landscape.corners.len(), &mut || {
        black_box(build(landscape, quality));
    });
}

fn closest_camera(bvh: &Bvh, face: Face) {
    closest(bvh, &camera_rays(), face);
}

fn closest_bounced(bvh: &Bvh, face: Face) {
    closest(bvh, &bounced(bvh), face);
}

fn closest(bvh: &Bvh, rays: &Queue<RayX8>, face: Face) {
    let mut stacks = Stacks::default();
    face(rays.len(), &mut || {
        black_box(trace(bvh, black_box(rays), &mut stacks));
    });
}

fn any_bounced(bvh: &Bvh, face: Face) {
    let rays = bounced(bvh);
    let mut stacks = Stacks::default();
    let mut occluded = vec![0; rays.len().div_ceil(WIDTH)];
    face(rays.len(), &mut || {
        // What is on already is not traced.
        occluded.fill(0);
        bvh.occluded(black_box(&rays), &mut occluded, &mut stacks);
    });
}

fn queue(rays: impl Iterator<Item = Ray>) -> Queue<RayX8> {
    let rays: Vec<Ray> = rays.collect();
    let mut queue = Queue::with_capacity(rays.len());
    rays.into_iter().for_each(|ray| queue.push_one(ray));
    queue
}

/// Camera rays over the landscape, in tiles of 8 × 8.
fn camera_rays() -> Queue<RayX8> {
    queue((0..IMAGE * IMAGE).map(|i| {
        let (tile, pixel) = (i / 64, i % 64);
        let x = (tile % (IMAGE / 8) * 8 + pixel % 8) as f32 / IMAGE as f32 - 0.5;
        let y = (tile / (IMAGE / 8) * 8 + pixel / 8) as f32 / IMAGE as f32 - 0.5;
        let direction = Vec3::new(x, -0.55 - 0.6 * y, 1.0).normalize();
        Ray::new(Landscape::VIEWPOINT, direction)
    }))
}

/// From what camera rays met, upwards at random.
fn bounced(bvh: &Bvh) -> Queue<RayX8> {
    let camera_rays = camera_rays();
    let hits = trace(bvh, &camera_rays, &mut Stacks::default());
    let mut random = Pcg32::new(1, 2);
    let mut unit = move || random.next_u32() as f32 / u32::MAX as f32 * 2.0 - 1.0;
    let rays = queue((0..camera_rays.len()).filter_map(move |i| {
        let (ray, lane) = (camera_rays.get(i), i % WIDTH);
        let distance = hits[i / WIDTH].distance.to_array()[lane];
        let met = hits[i / WIDTH].triangle.to_array()[lane] != NO_TRIANGLE;
        let direction = Vec3::new(unit(), unit().abs() + 0.05, unit()).normalize();
        let origin = ray.origin + ray.direction * distance + Vec3::Y * 1e-4;
        met.then_some(Ray::new(origin, direction))
    }));
    let met = rays.len();
    assert!(met > 1000, "{met} rays meet the landscape");
    rays
}

fn trace(bvh: &Bvh, rays: &Queue<RayX8>, stacks: &mut Stacks) -> Vec<HitX8> {
    let nothing = HitX8 {
        distance: f32x8::splat(f32::INFINITY),
        triangle: u32x8::splat(NO_TRIANGLE),
        instance: u32x8::splat(NO_TRIANGLE),
    };
    let mut hits = vec![nothing; rays.len().div_ceil(WIDTH)];
    bvh.closest(rays, &mut hits, stacks);
    hits
}
