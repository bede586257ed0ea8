//! Stage 2: what rays meet. Closest hits go to the queue of their material's kind; on a path's last edge only light is
//! looked for; shadow rays ask whether anything is between. What has meshes is traced by [`meshes`].

pub mod meshes;

use super::queues::{EncounterX8, GROUP, PathRayX8, ShadowRayX8, VertexX8};
use crate::film::AovSample;
use crate::lanes::{Queue, Vec3x8, WIDTH, f32x8, u32x8};
use crate::material::Kind;
use crate::scene::{NONE, Scene};
use crate::shape::{NO_PRIMITIVE, Shapes};

/// Rounding error of a hit point, relative to the greatest coordinate and the distance travelled: 64 units in the last
/// place, which covers the plane's and the sphere's (bounds of 5 and some 20 by the analysis of pbrt-v4, section 6.8).
const POSITION_ERROR: f32 = 64.0 / 16_777_216.0;

/// Sends each hit that scatters to its kind's queue, and each ray that found light to the encounters. `enclosed` says that
/// all rays start where [`Scene::encloses`] them.
#[inline(never)]
pub fn closest(
    scene: &Scene,
    enclosed: bool,
    rays: &Queue<PathRayX8>,
    vertices: &mut [Queue<VertexX8>],
    encounters: &mut Queue<EncounterX8>,
) {
    encounters.clear();
    vertices.iter_mut().for_each(Queue::clear);
    for (live, rays) in rays.groups::<GROUP>() {
        let mut hits = [(f32x8::ZERO, u32x8::ZERO); GROUP];
        for (hit, ray) in hits.iter_mut().zip(rays) {
            *hit = if enclosed {
                scene.closest(ray.origin, ray.direction)
            } else {
                scene.shapes.closest(ray.origin, ray.direction)
            };
        }
        for ((&live, ray), &(distance, primitive)) in live.iter().zip(rays).zip(&hits) {
            let mut found = Found {
                vertices,
                encounters,
            };
            found.keep(scene, live, ray, (distance, primitive));
        }
    }
}

/// Where what is met goes.
struct Found<'a> {
    vertices: &'a mut [Queue<VertexX8>],
    encounters: &'a mut Queue<EncounterX8>,
}

impl Found<'_> {
    /// Keeps what rays met on shapes, or the sky.
    #[inline(always)]
    fn keep(
        &mut self,
        scene: &Scene,
        live: f32x8,
        ray: &PathRayX8,
        (distance, primitive): (f32x8, u32x8),
    ) {
        let hit = live & distance.simd_lt(f32x8::splat(f32::INFINITY));
        let position = ray.direction.mul_add(distance, ray.origin);
        let surface = scene.surface(primitive, position);

        let vertex = VertexX8 {
            position,
            wo: -ray.direction,
            normal: surface.normal,
            offset: (position.max_abs() + distance) * POSITION_ERROR,
            material: surface.material,
            throughput: ray.throughput,
            path: ray.path,
            key: ray.key,
            index: ray.index,
        };
        let is = |kind: Kind| {
            let of_kind = surface.kind.simd_eq(u32x8::splat(kind as u32));
            hit & f32x8::from_bits(of_kind)
        };
        // Of one kind, the vertex goes straight to its queue: for more it waits in memory meanwhile.
        if let [kind] = scene.kinds[..] {
            self.vertices[kind as usize].push(is(kind), &vertex);
        } else {
            for &kind in &scene.kinds {
                self.vertices[kind as usize].push(is(kind), &vertex);
            }
        }

        let on_light = hit & f32x8::from_bits(surface.light.simd_ne(u32x8::splat(NONE)));
        let met = (distance, primitive, on_light);
        meet(scene, live, ray, met, self.encounters);
    }
}

/// Finds the light that each ray heads for, were nothing else in the scene: the nearest source, or else the sky.
#[inline(never)]
pub fn lights(scene: &Scene, rays: &Queue<PathRayX8>, encounters: &mut Queue<EncounterX8>) {
    encounters.clear();
    for (live, ray) in rays.batches() {
        let (distance, primitive) = scene.emitters.closest(ray.origin, ray.direction);
        let on_light = live & distance.simd_lt(f32x8::splat(f32::INFINITY));
        meet(
            scene,
            live,
            ray,
            (distance, primitive, on_light),
            encounters,
        );
    }
}

/// Records the rays that are on a light, and those that leave the scene where there is a sky.
#[inline(always)]
fn meet(
    scene: &Scene,
    live: f32x8,
    ray: &PathRayX8,
    (distance, primitive, on_light): (f32x8, u32x8, f32x8),
    encounters: &mut Queue<EncounterX8>,
) {
    let mut found = on_light;
    if scene.sky.is_some() {
        found |= live & distance.simd_eq(f32x8::splat(f32::INFINITY));
    }
    if found.any() {
        encounter(
            scene,
            found,
            ray,
            (distance, primitive, on_light),
            encounters,
        );
    }
}

/// Records the rays that found light.
#[inline(never)]
fn encounter(
    scene: &Scene,
    found: f32x8,
    ray: &PathRayX8,
    (distance, primitive, on_light): (f32x8, u32x8, f32x8),
    encounters: &mut Queue<EncounterX8>,
) {
    let surface = scene.surface(primitive, Vec3x8::ZERO);
    encounters.push(
        found,
        &EncounterX8 {
            origin: ray.origin,
            direction: ray.direction,
            distance,
            light: on_light.select(surface.light, u32x8::splat(NONE)),
            primitive: on_light.select(primitive, u32x8::splat(NO_PRIMITIVE)),
            throughput: ray.throughput,
            pdf: ray.pdf,
            path: ray.path,
        },
    );
}

/// For each batch of shadow rays, a bit for each lane with nothing between it and its light.
#[inline(never)]
pub fn visible(scene: &Scene, shadow_rays: &Queue<ShadowRayX8>, visible: &mut Vec<u8>) {
    visible.clear();
    for (live, ray) in shadow_rays.batches() {
        let among =
            |shapes: &Shapes| shapes.occluded(ray.origin, ray.direction, ray.distance, ray.target);
        let mut occluded = among(&scene.blockers);
        // A ray to the sky leaves the scene, and then the hull is between too. For that lane alone: what a lane meets must
        // not depend on its neighbours, which are others in other waves.
        let leaves = live & ray.distance.simd_eq(f32x8::splat(f32::INFINITY));
        if leaves.any() {
            occluded |= leaves & among(&scene.hull);
        }
        visible.push((live & !occluded).to_bitmask() as u8);
    }
}

/// What each camera ray meets, at the place of its path.
pub fn first_hits(scene: &Scene, rays: &Queue<PathRayX8>, first_hits: &mut [AovSample]) {
    for (live, ray) in rays.batches() {
        let met = scene.shapes.closest(ray.origin, ray.direction);
        first_hit(scene, live, ray, met, first_hits);
    }
}

/// The layers of hits on shapes.
fn first_hit(
    scene: &Scene,
    live: f32x8,
    ray: &PathRayX8,
    (distance, primitive): (f32x8, u32x8),
    first_hits: &mut [AovSample],
) {
    let hit = live & distance.simd_lt(f32x8::splat(f32::INFINITY));
    let position = ray.direction.mul_add(distance, ray.origin);
    let surface = scene.surface(primitive, position);
    for lane in lanes(hit) {
        let albedo = scene.albedo(surface.material.as_array()[lane]);
        first_hits[ray.path.as_array()[lane] as usize] = AovSample {
            albedo: albedo.to_array(),
            normal: towards(&surface.normal, &ray.direction, lane),
            depth: distance.as_array()[lane],
        };
    }
}

/// A normal turned against the ray.
fn towards(normal: &Vec3x8, direction: &Vec3x8, lane: usize) -> [f32; 3] {
    let (normal, direction) = (normal.lane(lane), direction.lane(lane));
    let away = normal.dot(direction) > 0.0;
    (if away { -normal } else { normal }).to_array()
}

/// The lanes that are on.
fn lanes(mask: f32x8) -> impl Iterator<Item = usize> {
    let bits = mask.to_bitmask();
    (0..WIDTH).filter(move |lane| bits >> lane & 1 == 1)
}
