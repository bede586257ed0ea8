//! No ray slips through a closed mesh: not at an edge, not at a vertex, not far from the origin, not through an instance.
//!
//! From inside, every ray must meet something whatever its direction. From outside, a ray that is aimed at a point around
//! which all triangles face it must meet the surface there, or something nearer.

mod common;
#[path = "common/rays.rs"]
mod rays;
#[path = "common/solids.rs"]
mod solids;

use common::Random;
use glam::{Affine3A, DAffine3, DVec3, Quat, Vec3};
use ondine::bvh::{Bvh, Instance, Quality};
use rayon::prelude::*;
use rays::{Ray, closest, occluded, tree};
use solids::{Solid, assert_closed, ball, icosphere, strips, torus};

/// Rays that are traced together.
const CHUNK: usize = 4096;

/// Largest relative error of one operation.
const ROUNDING: f64 = f32::EPSILON as f64 / 2.0;

/// Least cosine between a ray and the triangles around the point it is aimed at for the point itself to be met.
const FACING: f64 = 0.1;

/// A solid at its place in the world.
struct Placed {
    name: String,
    bvh: Bvh,
    /// Vertices, world space.
    points: Vec<DVec3>,
    edges: Vec<[u32; 2]>,
    /// Outwards, unit, of the triangles around each vertex.
    normals: Vec<Vec<DVec3>>,
    /// From the world to the space in which `inside` knows the solid.
    to_solid: DAffine3,
    inside: fn(DVec3) -> bool,
    center: DVec3,
    radius: f64,
    /// Least height of a triangle.
    height: f64,
    /// By how much rounding grows on the way through the instance: 1 without one.
    condition: f64,
}

impl Placed {
    /// `baked` moves the vertices themselves, which are then rounded; `instance` is left to the tree.
    fn new(
        name: &str,
        solid: Solid,
        baked: DAffine3,
        instance: Affine3A,
        quality: Quality,
    ) -> Self {
        let mut mesh = solid.mesh;
        for p in &mut mesh.positions {
            *p = baked.transform_point3(p.as_dvec3()).as_vec3();
        }
        assert_closed(&mesh);
        let to_world = instance.as_daffine3();
        let world = |&p: &Vec3| to_world.transform_point3(p.as_dvec3());
        let points: Vec<DVec3> = mesh.positions.iter().map(world).collect();
        let mirrored = to_world.matrix3.determinant() < 0.0;
        let mut normals = vec![Vec::new(); points.len()];
        let mut edges = Vec::new();
        let mut height = f64::INFINITY;
        for corners in &mesh.triangles {
            let [a, b, c] = corners.map(|corner| points[corner as usize]);
            let normal = (b - a).cross(c - a) * if mirrored { -1.0 } else { 1.0 };
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            height = height.min(normal.length() / longest);
            for k in 0..3 {
                let (from, to) = (corners[k], corners[(k + 1) % 3]);
                normals[from as usize].push(normal.normalize());
                if from < to {
                    edges.push([from, to]);
                }
            }
        }
        let center = (to_world * baked).transform_point3(DVec3::ZERO);
        let radius = points
            .iter()
            .map(|p| p.distance(center))
            .fold(0.0, f64::max);
        let linear = to_world.matrix3;
        let size = |m: glam::DMat3| m.to_cols_array().iter().map(|c| c * c).sum::<f64>().sqrt();
        let is_instance = instance != Affine3A::IDENTITY;
        Self {
            name: format!("{name} {}", solid.name),
            bvh: tree(
                &[mesh],
                &[Instance {
                    mesh: 0,
                    to_world: instance,
                }],
                quality,
            ),
            points,
            edges,
            normals,
            to_solid: (to_world * baked).inverse(),
            inside: solid.inside,
            center,
            radius,
            height,
            condition: if is_instance {
                size(linear) * size(linear.inverse())
            } else {
                1.0
            },
        }
    }

    fn contains(&self, p: Vec3) -> bool {
        (self.inside)(self.to_solid.transform_point3(p.as_dvec3()))
    }
}

/// A ray and what it has to do.
struct Aimed {
    ray: Ray,
    /// Whether it starts inside, so that it must meet something.
    inside: bool,
    /// Greatest distance at which it must meet something, in units of its direction, where that is known.
    limit: Option<f64>,
}

fn pick<'a, T>(random: &mut Random, from: &'a [T]) -> &'a T {
    &from[(f64::from(random.one()) * from.len() as f64) as usize]
}

/// In [−1, 1]³.
fn cube(random: &mut Random) -> DVec3 {
    DVec3::from_array([0; 3].map(|_| f64::from(random.one()) * 2.0 - 1.0))
}

fn unit(random: &mut Random) -> DVec3 {
    loop {
        let p = cube(random);
        if (0.01..1.0).contains(&p.length_squared()) {
            return p.normalize();
        }
    }
}

impl Placed {
    /// A random point, mostly inside.
    fn start(&self, random: &mut Random) -> Vec3 {
        if random.one() < 0.2 {
            let far = 10f64.powf(0.2 + 1.3 * f64::from(random.one()));
            return (self.center + unit(random) * self.radius * far).as_vec3();
        }
        let to_world = self.to_solid.inverse();
        loop {
            let near = to_world.transform_point3(1.5 * cube(random)).as_vec3();
            if self.contains(near) {
                return near;
            }
        }
    }

    fn aim(&self, random: &mut Random) -> Aimed {
        let edge = pick(random, &self.edges);
        let [a, b] = edge.map(|vertex| self.points[vertex as usize]);
        let anywhere = f64::from(random.one());
        let along = *pick(random, &[0.0, 0.5, anywhere]);
        let target = a.lerp(b, along).as_vec3();
        let mut origin = self.start(random);
        let mut direction = target - origin;
        let mut is_aimed = true;
        match (random.one() * 8.0) as u32 {
            0 => direction = direction.normalize(),
            1 => direction *= 1000.0 * random.one() + 0.001,
            2 | 3 => {
                // Along an axis, and exactly through the target.
                let axis = (random.one() * 3.0) as usize;
                let length = direction[axis];
                direction = Vec3::splat(*pick(random, &[0.0, -0.0]));
                direction[axis] = length;
                origin = Vec3::from_array(std::array::from_fn(|c| {
                    if c == axis { origin[c] } else { target[c] }
                }));
            }
            4 => {
                direction = unit(random).as_vec3();
                is_aimed = false;
            }
            _ => {}
        }
        if direction == Vec3::ZERO {
            direction = Vec3::X;
            is_aimed = false;
        }
        let inside = self.contains(origin);
        let limit = self.limit(edge, target, origin, direction, inside);
        Aimed {
            ray: Ray::new(origin, direction),
            inside,
            limit: limit.filter(|_| is_aimed),
        }
    }

    /// The distance by which a ray to a point of an edge has met it, if all triangles around face the ray.
    ///
    /// It passes the point by a little: the point was rounded, and so was the direction; the kernel rounds vertices
    /// relative to the origin and shears them (Woop et al. 2013), some ten roundings of the size of what is left, and an
    /// instance takes the origin to another space. Triangles that face it are met within that over their cosine.
    fn limit(&self, edge: &[u32; 2], target: Vec3, o: Vec3, d: Vec3, inside: bool) -> Option<f64> {
        let (target, o, d) = (target.as_dvec3(), o.as_dvec3(), d.as_dvec3());
        let distance = target.distance(o);
        let placing = if self.condition > 1.0 {
            16.0 * self.condition * (o.length() + self.center.length())
        } else {
            0.0
        };
        let off = ROUNDING * (target.length() + 16.0 * (distance + self.radius) + placing);
        let out = if inside { 1.0 } else { -1.0 };
        let faces = |normal: &DVec3| normal.dot(d) * out > FACING * d.length();
        let around = |&vertex: &u32| self.normals[vertex as usize].iter().all(faces);
        // Triangles of that size, and an origin that is surely before them.
        let slack = off / FACING;
        let is_met = slack < distance.min(0.25 * self.height) && edge.iter().all(around);
        is_met.then(|| (distance + slack) / d.length())
    }

    /// Traces `count` rays and panics at the first that leaks; how many had to meet something, and how many had a limit.
    fn assert_tight(&self, count: usize) -> [usize; 2] {
        let chunk = |index: usize| {
            let mut random = Random::new(index as u64);
            let aimed: Vec<Aimed> = (0..CHUNK).map(|_| self.aim(&mut random)).collect();
            let rays: Vec<Ray> = aimed.iter().map(|aimed| aimed.ray).collect();
            let hits = closest(&self.bvh, &rays);
            let met = occluded(&self.bvh, &rays);
            for ((aimed, hit), met) in aimed.iter().zip(hits).zip(met) {
                let limit = aimed.limit.unwrap_or(f64::INFINITY);
                let is_met = hit.distance < f32::INFINITY;
                assert!(
                    is_met == met && (is_met || !aimed.inside) && f64::from(hit.distance) <= limit,
                    "{}: {:?} from {}: {hit:?}, limit {limit}, any hit {met}",
                    self.name,
                    aimed.ray,
                    if aimed.inside { "inside" } else { "outside" },
                );
            }
            let count = |of: fn(&Aimed) -> bool| aimed.iter().filter(|aimed| of(aimed)).count();
            [
                count(|aimed| aimed.inside),
                count(|aimed| aimed.limit.is_some()),
            ]
        };
        (0..count.div_ceil(CHUNK))
            .into_par_iter()
            .map(chunk)
            .reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]])
    }
}

/// Each solid where it is, far away, and through instances.
fn places(solid: impl Fn() -> Solid, quality: Quality) -> Vec<Placed> {
    // 10⁵ units away floats are multiples of 1/128.
    let far = DAffine3::from_scale_rotation_translation(
        DVec3::splat(100.0),
        glam::DQuat::IDENTITY,
        DVec3::new(1e5, -1e5, 1e5),
    );
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.4, 1.1, -2.0);
    let turned = Affine3A::from_scale_rotation_translation(
        Vec3::splat(3.0),
        turn,
        Vec3::new(2.0, -1.0, 5.0),
    );
    let squeezed = Affine3A::from_rotation_translation(turn, Vec3::new(0.1, 0.2, 0.3))
        * Affine3A::from_scale(Vec3::new(0.5, -2.0, 1.0))
        * Affine3A::from_quat(turn);
    let moved = Affine3A::from_translation(Vec3::new(1e5, 1e5, -1e5))
        * Affine3A::from_scale(Vec3::splat(100.0));
    [
        ("plain", DAffine3::IDENTITY, Affine3A::IDENTITY),
        ("far", far, Affine3A::IDENTITY),
        ("turned", DAffine3::IDENTITY, turned),
        ("mirrored and squeezed", DAffine3::IDENTITY, squeezed),
        ("moved", DAffine3::IDENTITY, moved),
    ]
    .map(|(name, baked, instance)| Placed::new(name, solid(), baked, instance, quality))
    .into()
}

/// Rays at each solid in each place; all of them together make `count`.
fn assert_tight(solids: &[fn() -> Solid], quality: Quality, count: usize) {
    let mut limits = 0;
    for solid in solids {
        for placed in places(solid, quality) {
            let rays = count / solids.len() / 5;
            let [inside, limited] = placed.assert_tight(rays);
            println!(
                "{}: {inside} of {rays} rays from inside, {limited} with a limit",
                placed.name
            );
            assert!(2 * inside > rays, "{}: {inside} of {rays}", placed.name);
            limits += limited;
        }
    }
    assert!(3 * limits > count, "{limits} of {count} had a limit");
}

const SOLIDS: [fn() -> Solid; 4] = [|| icosphere(2), || ball(2), || torus(24, 12), || strips(64)];

#[test]
fn no_ray_leaks_at_edges_and_vertices() {
    assert_tight(&SOLIDS, Quality::Fast, 1_000_000);
}

#[test]
fn no_ray_leaks_from_a_tree_with_spatial_splits() {
    assert_tight(&SOLIDS, Quality::Best, 250_000);
}

/// `cargo test --release --test leaks -- --ignored --nocapture`
#[test]
#[ignore = "10^8 rays"]
fn no_ray_of_a_hundred_million_leaks() {
    let solids: [fn() -> Solid; 4] = [
        || icosphere(5),
        || ball(6),
        || torus(240, 120),
        || strips(2000),
    ];
    assert_tight(&solids, Quality::Fast, 100_000_000);
}
