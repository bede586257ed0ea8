//! Rays through a scene with meshes: shapes first, whose hits are limits for the tree of triangles, and its hits for the
//! tree of triangles with holes.

use super::super::Context;
use super::super::queues::{
    CutoutRayX8, EncounterX8, MeshEncounterX8, MeshVertexX8, PathRayX8, ShadowRayX8, Tracing,
    VertexX8, Workspace,
};
use super::{Found, first_hit, lanes, towards};
use crate::bvh::{Hit, HitX8, NO_TRIANGLE, ShadowRays};
use crate::film::AovSample;
use crate::lanes::{Batch, Queue, Vec3x8, WIDTH, f32x8, u32x8};
use crate::scene::meshes::Meshes;
use crate::scene::surface::MeshSurfaceX8;
use crate::scene::{NONE, Scene};

/// As [`closest`](super::closest), with hits on meshes in queues of their own. Of the last edge only light is kept.
#[inline(never)]
pub fn closest(ctx: &Context, meshes: &Meshes, last: bool, ws: &mut Workspace) {
    trace(ctx, meshes, &ws.rays, &mut ws.tracing);
    ws.encounters.clear();
    ws.mesh_encounters.clear();
    ws.vertices.iter_mut().for_each(Queue::clear);
    ws.mesh_vertices.iter_mut().for_each(Queue::clear);
    for ((live, ray), hit) in ws.rays.batches().zip(&ws.tracing.hits) {
        let on_mesh = live & is_on_mesh(hit);
        let elsewhere = live & !on_mesh;
        if elsewhere.any() {
            let mut found = Found {
                vertices: &mut ws.vertices,
                encounters: &mut ws.encounters,
            };
            let met = (hit.distance, hit.triangle);
            found.keep(ctx.scene, elsewhere, ray, met);
        }
        if !on_mesh.any() {
            continue;
        }
        let surface = surface(meshes, on_mesh, ray, hit);
        if !last {
            let vertex = vertex(ray, &surface);
            for &kind in &meshes.kinds {
                let of_kind = surface.kind.simd_eq(u32x8::splat(kind as u32));
                let mask = on_mesh & f32x8::from_bits(of_kind);
                ws.mesh_vertices[kind as usize].push(mask, &vertex);
            }
        }
        let on_light = f32x8::from_bits(surface.light.simd_ne(u32x8::splat(NONE)));
        let found = on_mesh & on_light;
        if found.any() {
            ws.mesh_encounters.push(
                found,
                &MeshEncounterX8 {
                    encounter: EncounterX8 {
                        origin: ray.origin,
                        direction: ray.direction,
                        distance: hit.distance,
                        light: surface.light,
                        primitive: u32x8::splat(NONE),
                        throughput: ray.throughput,
                        pdf: ray.pdf,
                        path: ray.path,
                    },
                    ng: surface.ng,
                    u: surface.uv.0,
                    v: surface.uv.1,
                },
            );
        }
    }
}

/// Takes from the visible those shadow rays that meet a mesh.
#[inline(never)]
pub fn visible(
    meshes: &Meshes,
    shadow_rays: &Queue<ShadowRayX8>,
    visible: &mut [u8],
    tracing: &mut Tracing,
) {
    let occluded = &mut tracing.occluded;
    occluded.clear();
    occluded.extend(visible.iter().map(|bits| !bits));
    meshes
        .opaque
        .tree
        .occluded(shadow_rays, occluded, &mut tracing.stacks);
    for (visible, occluded) in visible.iter_mut().zip(&tracing.occluded) {
        *visible &= !occluded;
    }
    if meshes.masked.tree.is_empty() {
        return;
    }
    tracing.cutouts[0].clear();
    for (batch, ((_, ray), &visible)) in shadow_rays.batches().zip(&*visible).enumerate() {
        tracing.cutouts[0].push(
            mask(visible),
            &CutoutRayX8 {
                origin: ray.origin,
                direction: ray.direction,
                nearest: f32x8::ZERO,
                farthest: ray.farthest(),
                ignored: ray.target,
                place: places(batch),
            },
        );
    }
    through_holes(meshes, tracing, |_, place, _| {
        visible[place / WIDTH] &= !(1 << (place % WIDTH));
    });
}

/// What each camera ray meets, at the place of its path.
pub fn first_hits(ctx: &Context, meshes: &Meshes, ws: &mut Workspace) {
    trace(ctx, meshes, &ws.rays, &mut ws.tracing);
    for ((live, ray), hit) in ws.rays.batches().zip(&ws.tracing.hits) {
        let on_mesh = live & is_on_mesh(hit);
        let met = (hit.distance, hit.triangle);
        first_hit(ctx.scene, live & !on_mesh, ray, met, &mut ws.first_hits);
        if !on_mesh.any() {
            continue;
        }
        let surface = surface(meshes, on_mesh, ray, hit);
        for lane in lanes(on_mesh) {
            let albedo = ctx.scene.albedo(surface.material.as_array()[lane]);
            let map = surface.maps.color.lane(lane);
            ws.first_hits[ray.path.as_array()[lane] as usize] = AovSample {
                albedo: [albedo.r * map.r, albedo.g * map.g, albedo.b * map.b],
                normal: towards(&surface.ns, &ray.direction, lane),
                depth: hit.distance.as_array()[lane],
            };
        }
    }
}

/// The closest hits, on shapes and on meshes, those on meshes resolved.
fn trace(ctx: &Context, meshes: &Meshes, rays: &Queue<PathRayX8>, tracing: &mut Tracing) {
    let scene: &Scene = ctx.scene;
    let hits = &mut tracing.hits;
    hits.clear();
    hits.extend(rays.batches().map(|(_, ray)| {
        let (distance, primitive) = if ctx.enclosed {
            scene.closest(ray.origin, ray.direction)
        } else {
            scene.shapes.closest(ray.origin, ray.direction)
        };
        HitX8 {
            distance,
            triangle: primitive,
            instance: u32x8::splat(NONE),
        }
    }));
    meshes.opaque.tree.closest(rays, hits, &mut tracing.stacks);
    for ((live, _), hit) in rays.batches().zip(hits) {
        meshes.resolve(&meshes.opaque, live & is_on_mesh(hit), hit);
    }
    if meshes.masked.tree.is_empty() {
        return;
    }
    tracing.cutouts[0].clear();
    for (batch, ((live, ray), hit)) in rays.batches().zip(&tracing.hits).enumerate() {
        tracing.cutouts[0].push(
            live,
            &CutoutRayX8 {
                origin: ray.origin,
                direction: ray.direction,
                nearest: f32x8::ZERO,
                farthest: hit.distance,
                ignored: u32x8::splat(NONE),
                place: places(batch),
            },
        );
    }
    through_holes(meshes, tracing, |hits, place, hit| {
        hits[place / WIDTH].set_lane(place % WIDTH, hit);
    });
}

/// Traces the rays of the first queue of holes through the tree that has them, round by round: a ray that meets a hole goes
/// on behind it. `found` is told what each ray met at last, if anything, and at which place the ray is.
fn through_holes(
    meshes: &Meshes,
    tracing: &mut Tracing,
    mut found: impl FnMut(&mut [HitX8], usize, Hit),
) {
    let [rays, next] = &mut tracing.cutouts;
    let hits = &mut tracing.cutout_hits;
    while !rays.is_empty() {
        hits.clear();
        hits.extend(rays.batches().map(|(_, ray)| HitX8 {
            distance: ray.farthest,
            triangle: u32x8::splat(NO_TRIANGLE),
            instance: u32x8::splat(NONE),
        }));
        meshes.masked.tree.closest(rays, hits, &mut tracing.stacks);
        next.clear();
        for ((live, ray), hit) in rays.batches().zip(hits.iter_mut()) {
            let met = live & is_on_mesh(hit);
            if !met.any() {
                continue;
            }
            meshes.resolve(&meshes.masked, met, hit);
            let near = ray.direction.mul_add(hit.distance, ray.origin);
            let own = f32x8::from_bits(meshes.primitive(hit).simd_eq(ray.ignored));
            let there = meshes.is_there(met, hit, near) & !(own & is_id(ray.ignored));
            for lane in lanes(there) {
                let place = ray.place.as_array()[lane] as usize;
                found(&mut tracing.hits, place, hit.lane(lane));
            }
            let goes_on = CutoutRayX8 {
                nearest: hit.distance,
                ..*ray
            };
            next.push(met & !there, &goes_on);
        }
        std::mem::swap(rays, next);
    }
}

/// Mask of the lanes whose hit is on a mesh.
fn is_on_mesh(hit: &HitX8) -> f32x8 {
    is_id(hit.instance)
}

/// Mask of the ids that are not [`NONE`].
fn is_id(id: u32x8) -> f32x8 {
    f32x8::from_bits(id.simd_ne(u32x8::splat(NONE)))
}

/// The lanes of a batch by their bits.
fn mask(bits: u8) -> f32x8 {
    let lanes = u32x8::new([1, 2, 4, 8, 16, 32, 64, 128]);
    f32x8::from_bits((u32x8::splat(u32::from(bits)) & lanes).simd_ne(u32x8::ZERO))
}

/// The places of a batch's lanes in its queue.
fn places(batch: usize) -> u32x8 {
    u32x8::splat((batch * WIDTH) as u32) + u32x8::new([0, 1, 2, 3, 4, 5, 6, 7])
}

fn surface(meshes: &Meshes, on_mesh: f32x8, ray: &PathRayX8, hit: &HitX8) -> MeshSurfaceX8 {
    let near: Vec3x8 = ray.direction.mul_add(hit.distance, ray.origin);
    meshes.surface(on_mesh, hit, near, -ray.direction)
}

fn vertex(ray: &PathRayX8, surface: &MeshSurfaceX8) -> MeshVertexX8 {
    MeshVertexX8 {
        vertex: VertexX8 {
            position: surface.position,
            wo: -ray.direction,
            normal: surface.ns,
            offset: surface.offset,
            material: surface.material,
            throughput: ray.throughput,
            path: ray.path,
            key: ray.key,
            index: ray.index,
        },
        ng: surface.ng,
        color: surface.maps.color,
        roughness: surface.maps.roughness,
        metallic: surface.maps.metallic,
    }
}
