//! `ondine rays`: how fast given rays meet a mesh, and what they meet.

use super::Outcome;
use super::args::{RayKind, RaysArgs};
use super::progress::metric;
use super::report::counted;
use crate::bvh::{Bvh, HitX8, Instance, NO_TRIANGLE, Ray, RayX8, Stacks, Triangles};
use crate::error::{Error, Result};
use crate::film::write_whole;
use crate::lanes::{Batch, Queue, WIDTH, u32x8};
use crate::render::{all_processors, workers};
use crate::scene::ply;
use glam::{Affine3A, Vec3};
use serde::Serialize;
use std::io::{Read, Write};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Rays that a worker takes at a time: as many as a wave has, and more.
const CHUNK: usize = 4096;
/// Bytes of a ray in its file: eight 32-bit floats.
const RAY_BYTES: usize = 32;

/// A queue, and room for what its rays meet.
struct Chunk {
    rays: Queue<RayX8>,
    hits: Vec<HitX8>,
    occluded: Vec<u8>,
}

/// What it took.
#[derive(Debug, Serialize)]
struct RaysReport {
    mesh: String,
    kind: String,
    bvh: String,
    threads: usize,
    repeat: usize,
    triangles: usize,
    rays: usize,
    hits: usize,
    mrays_per_s: f64,
    mrays_per_s_best: f64,
    mrays_per_s_worst: f64,
    load_s: f64,
    build_s: f64,
    node_bytes: usize,
    triangle_bytes: usize,
}

pub(super) fn run(args: &RaysArgs) -> Result<Outcome> {
    let begin = Instant::now();
    let loaded = ply::load(&args.mesh)?;
    if loaded.dropped > 0 {
        super::say(format_args!(
            "warning: {}: {} triangles without an area are left out; indices count the others",
            args.mesh.display(),
            loaded.dropped
        ));
    }
    let mut chunks = read(&args.rays)?;
    let load = begin.elapsed();

    let threads = args.threads.unwrap_or_else(all_processors);
    let pool = workers(threads)?;
    let begin = Instant::now();
    let bvh = pool.install(|| {
        let mesh = Triangles {
            positions: &loaded.mesh.positions,
            corners: &loaded.mesh.triangles,
        };
        let place = Instance {
            mesh: 0,
            to_world: Affine3A::IDENTITY,
        };
        Bvh::build(&[mesh], &[place], args.bvh)
    });
    let build = begin.elapsed();

    let mut times = Vec::with_capacity(args.repeat);
    for _ in 0..=args.repeat {
        let next = AtomicUsize::new(0);
        let work: Vec<Mutex<&mut Chunk>> = chunks.iter_mut().map(Mutex::new).collect();
        let begin = Instant::now();
        pool.broadcast(|_| {
            let mut stacks = Stacks::default();
            while let Some(chunk) = work.get(next.fetch_add(1, Ordering::Relaxed)) {
                let mut chunk = chunk
                    .lock()
                    .unwrap_or_else(|poisoned| poisoned.into_inner());
                chunk.trace(&bvh, args.kind, &mut stacks);
            }
        });
        times.push(begin.elapsed().as_secs_f64());
    }
    // The first was to warm up.
    times.remove(0);
    times.sort_by(f64::total_cmp);

    let rays = chunks.iter().map(|chunk| chunk.rays.len()).sum();
    let rate = |seconds: f64| rays as f64 / seconds * 1e-6;
    let (node_bytes, triangle_bytes) = bvh.bytes();
    let report = RaysReport {
        mesh: args.mesh.display().to_string(),
        kind: args.kind.to_string(),
        bvh: args.bvh.to_string(),
        threads,
        repeat: args.repeat,
        triangles: loaded.mesh.triangles.len(),
        rays,
        hits: chunks
            .iter()
            .map(|chunk| chunk.results(args.kind).filter(is_hit).count())
            .sum(),
        mrays_per_s: rate(times[times.len() / 2]),
        mrays_per_s_best: rate(times[0]),
        mrays_per_s_worst: rate(times[times.len() - 1]),
        load_s: load.as_secs_f64(),
        build_s: build.as_secs_f64(),
        node_bytes,
        triangle_bytes,
    };
    if let Some(path) = &args.hits {
        write_whole(path, |file| {
            for chunk in &chunks {
                for (distance, triangle) in chunk.results(args.kind) {
                    file.write_all(&distance.to_le_bytes())?;
                    file.write_all(&triangle.to_le_bytes())?;
                }
            }
            Ok(())
        })?;
    }
    match args.json {
        true => super::print_json(&report)?,
        false => super::print(&report.text())?,
    }
    Ok(Outcome::Done)
}

/// Whether a ray met anything.
fn is_hit((_, triangle): &(f32, u32)) -> bool {
    *triangle != NO_TRIANGLE
}

impl Chunk {
    fn trace(&mut self, bvh: &Bvh, kind: RayKind, stacks: &mut Stacks) {
        match kind {
            RayKind::Closest => {
                for (hit, (_, rays)) in self.hits.iter_mut().zip(self.rays.batches()) {
                    hit.distance = rays.farthest;
                    hit.triangle = u32x8::splat(NO_TRIANGLE);
                }
                bvh.closest(&self.rays, &mut self.hits, stacks);
            }
            RayKind::Any => {
                self.occluded.fill(0);
                bvh.occluded(&self.rays, &mut self.occluded, stacks);
            }
        }
    }

    /// Distance and triangle of each ray: +∞ and all ones for a miss, 0 and 0 for whatever `any` met.
    fn results(&self, kind: RayKind) -> impl Iterator<Item = (f32, u32)> {
        (0..self.rays.len()).map(move |ray| {
            let (batch, lane) = (ray / WIDTH, ray % WIDTH);
            let (distance, triangle) = match kind {
                RayKind::Closest => {
                    let hit = self.hits[batch].lane(lane);
                    (hit.distance, hit.triangle)
                }
                RayKind::Any if self.occluded[batch] >> lane & 1 == 1 => (0.0, 0),
                RayKind::Any => (f32::INFINITY, NO_TRIANGLE),
            };
            match triangle {
                NO_TRIANGLE => (f32::INFINITY, triangle),
                _ => (distance, triangle),
            }
        })
    }
}

/// The rays of a file, in queues.
fn read(path: &Path) -> Result<Vec<Chunk>> {
    let cannot_read = |source| Error::Read {
        path: path.to_owned(),
        source,
    };
    let mut file = std::fs::File::open(path).map_err(cannot_read)?;
    let mut chunks = Vec::new();
    let mut bytes = Vec::with_capacity(CHUNK * RAY_BYTES);
    loop {
        bytes.clear();
        let limit = (CHUNK * RAY_BYTES) as u64;
        (&mut file)
            .take(limit)
            .read_to_end(&mut bytes)
            .map_err(cannot_read)?;
        if bytes.is_empty() {
            break;
        }
        let (rays, rest) = bytes.as_chunks::<RAY_BYTES>();
        if !rest.is_empty() {
            return Err(Error::format(
                path,
                format!(
                    "ends within ray {}; a ray is eight 32-bit floats: ox oy oz tmin dx dy dz tmax",
                    chunks.len() * CHUNK + rays.len()
                ),
            ));
        }
        let mut queue = Queue::with_capacity(CHUNK);
        for (index, ray) in rays.iter().enumerate() {
            let number = chunks.len() * CHUNK + index;
            queue.push_one(ray_of(ray).map_err(|wrong| {
                Error::format(path, format!("ray {number} (counted from 0) {wrong}"))
            })?);
        }
        let batches = queue.len().div_ceil(WIDTH);
        chunks.push(Chunk {
            rays: queue,
            hits: vec![HitX8::default(); batches],
            occluded: vec![0; batches],
        });
    }
    if chunks.is_empty() {
        return Err(Error::format(path, "holds no rays"));
    }
    Ok(chunks)
}

/// A ray by its bytes, or what is wrong with it.
fn ray_of(bytes: &[u8; RAY_BYTES]) -> std::result::Result<Ray, String> {
    let (words, _) = bytes.as_chunks::<4>();
    let word = |index: usize| f32::from_le_bytes(words[index]);
    let ray = Ray {
        nearest: word(3),
        farthest: word(7),
        ..Ray::new(
            Vec3::new(word(0), word(1), word(2)),
            Vec3::new(word(4), word(5), word(6)),
        )
    };
    let length = ray.direction.abs().max_element();
    if !ray.origin.is_finite() || !ray.direction.is_finite() {
        return Err("has an origin or a direction that is not finite".to_owned());
    }
    if !(1e-15..=1e15).contains(&length) {
        return Err(
            "has a direction whose greatest component is not within 1e-15 to 1e15".to_owned(),
        );
    }
    if !(ray.nearest >= 0.0 && ray.farthest >= ray.nearest) {
        return Err(format!(
            "runs from {} to {}; give 0 <= tmin <= tmax",
            ray.nearest, ray.farthest
        ));
    }
    Ok(ray)
}

impl RaysReport {
    /// For people.
    fn text(&self) -> String {
        let per_triangle = (self.node_bytes + self.triangle_bytes) as f64 / self.triangles as f64;
        format!(
            "{} ({}), {}: {}rays/s with {} (median of {}; {:.2} to {:.2} M)\n\
             {}: read in {:.3} s, tree ({}) built in {:.3} s, {:.1} bytes a triangle\n",
            counted(self.rays, "ray"),
            self.kind,
            counted(self.hits, "hit"),
            metric(self.mrays_per_s * 1e6),
            counted(self.threads, "thread"),
            self.repeat,
            self.mrays_per_s_worst,
            self.mrays_per_s_best,
            counted(self.triangles, "triangle"),
            self.load_s,
            self.bvh,
            self.build_s,
            per_triangle,
        )
    }
}
