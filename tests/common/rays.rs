//! Rays of which everything can be said, and a tree asked about a list of them.
#![allow(dead_code, reason = "each test file uses a part")]

pub use ondine::bvh::Ray;
use ondine::bvh::{Bvh, Hit, HitX8, Instance, NO_TRIANGLE, Quality, RayX8, Stacks, Triangles};
use ondine::lanes::{Queue, WIDTH};
use ondine::scene::mesh::Mesh;

/// A tree that has been walked and found to be one.
#[track_caller]
pub fn tree(meshes: &[Mesh], instances: &[Instance], quality: Quality) -> Bvh {
    let meshes: Vec<Triangles> = meshes
        .iter()
        .map(|mesh| Triangles {
            positions: &mesh.positions,
            corners: &mesh.triangles,
        })
        .collect();
    let bvh = Bvh::build(&meshes, instances, quality);
    if let Err(wrong) = bvh.validate(quality) {
        panic!("{wrong}");
    }
    bvh
}

fn queue(rays: &[Ray]) -> Queue<RayX8> {
    let mut queue = Queue::with_capacity(rays.len());
    for &ray in rays {
        queue.push_one(ray);
    }
    queue
}

/// The nearest hit of each ray; where there is none, `farthest` and no triangle.
pub fn closest(bvh: &Bvh, rays: &[Ray]) -> Vec<Hit> {
    let mut hits = vec![HitX8::default(); rays.len().div_ceil(WIDTH)];
    for (i, ray) in rays.iter().enumerate() {
        let nothing = Hit {
            distance: ray.farthest,
            triangle: NO_TRIANGLE,
            instance: NO_TRIANGLE,
        };
        ondine::lanes::Batch::set_lane(&mut hits[i / WIDTH], i % WIDTH, nothing);
    }
    bvh.closest(&queue(rays), &mut hits, &mut Stacks::default());
    (0..rays.len())
        .map(|i| ondine::lanes::Batch::lane(&hits[i / WIDTH], i % WIDTH))
        .collect()
}

/// Whether each ray meets anything.
pub fn occluded(bvh: &Bvh, rays: &[Ray]) -> Vec<bool> {
    let mut bits = vec![0; rays.len().div_ceil(WIDTH)];
    bvh.occluded(&queue(rays), &mut bits, &mut Stacks::default());
    (0..rays.len())
        .map(|i| bits[i / WIDTH] >> (i % WIDTH) & 1 == 1)
        .collect()
}
