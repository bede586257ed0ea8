//! Points of meshes that emit: where, and with what density.

use crate::common::*;
use crate::{add_light, ball, empty};
use glam::{Affine3A, Quat, Vec3};
use ondine::lanes::{Rgb, Vec3x8, WIDTH};
use ondine::scene::Scene;
use ondine::scene::mesh::Mesh;
use ondine::scene::meshes::TRIANGLE;

const CAMERA: &str = "position = [0.0, 0.0, 5.0]\nlook_at = [0.0, 0.0, 0.0]\nvertical_fov = 30.0";

const COUNT: usize = 1 << 18;

fn lamp(mesh: &std::sync::Arc<Mesh>, place: Affine3A) -> Scene {
    let mut description = empty(CAMERA);
    description.environment = None;
    add_light(&mut description, mesh, place, Rgb::WHITE);
    description.lights[0].two_sided = true;
    Scene::compile(&description)
}

fn place() -> Affine3A {
    Affine3A::from_scale_rotation_translation(
        Vec3::new(0.5, 1.0, -2.0),
        Quat::from_rotation_x(0.4),
        Vec3::new(0.0, 0.0, -6.0),
    )
}

#[test]
fn triangles_are_chosen_by_their_area_and_points_lie_on_them_uniformly() {
    let mesh = ball(1, false);
    let scene = lamp(&mesh, place());
    let corners: Vec<[V; 3]> = mesh
        .triangles
        .iter()
        .map(|t| {
            t.map(|i| {
                let p = place().transform_point3(mesh.positions[i as usize]);
                p.to_array().map(f64::from)
            })
        })
        .collect();
    let minus = |a: V, b: V| -> V { std::array::from_fn(|c| a[c] - b[c]) };
    let cross = |a: V, b: V| -> V {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    // Four equal parts of each triangle, by the halves of its edges.
    let mut observed = vec![0u64; 4 * corners.len()];
    let mut areas = Vec::new();
    for &[a, b, c] in &corners {
        let n = cross(minus(b, a), minus(c, a));
        areas.push(0.5 * dot(n, n).sqrt());
    }
    let total: f64 = areas.iter().sum();
    let mut random = Random::new(510);
    for _ in 0..COUNT / WIDTH {
        let choice = random.pair();
        let s = scene
            .lights
            .sample(None, Vec3x8::ZERO, || choice, random.pair());
        for i in 0..WIDTH {
            let id = s.primitive.as_array()[i];
            assert!(id & TRIANGLE != 0);
            let triangle = (id & !TRIANGLE) as usize;
            let [a, b, c] = corners[triangle];
            let t = f64::from(s.distance.as_array()[i]);
            let p = minus(lane(&s.direction, i).map(|d| d * t), a);
            let n = cross(minus(b, a), minus(c, a));
            let squared = dot(n, n);
            let height = dot(p, n) / squared.sqrt();
            assert!(height.abs() < 1e-5, "{height} off the triangle");
            let u = dot(cross(p, minus(c, a)), n) / squared;
            let v = dot(cross(minus(b, a), p), n) / squared;
            assert!(u > -1e-5 && v > -1e-5 && u + v < 1.0 + 1e-5, "({u}, {v})");
            let part = match (u > 0.5, v > 0.5, u + v > 0.5) {
                (true, _, _) => 0,
                (_, true, _) => 1,
                (_, _, false) => 2,
                _ => 3,
            };
            observed[4 * triangle + part] += 1;
            // Density per steradian: squared distance ÷ (area × cosine).
            let cosine = dot(lane(&s.direction, i), n).abs() / squared.sqrt();
            let want = t * t / (total * cosine);
            assert_close(
                f64::from(s.pdf().as_array()[i]),
                want,
                1e-4 / cosine,
                0.0,
                "pdf",
            );
        }
    }
    let expected: Vec<f64> = areas
        .iter()
        .flat_map(|area| [area / total * COUNT as f64 / 4.0; 4])
        .collect();
    let p = chi_square(&observed, &expected);
    assert!(p > SIGNIFICANCE, "p = {p}");
}

#[test]
fn of_millions_of_triangles_each_is_found() {
    // More than 23 bits can tell apart evenly: 2^23 numbers for 8 · 4^9 triangles are 4 each, and no whole number of them
    // gives the areas.
    let mesh = ball(9, false);
    let scene = lamp(&mesh, Affine3A::from_translation(Vec3::Z * -6.0));
    let mut random = Random::new(511);
    // By eighths of the ball, and by the parity of their number.
    let mut observed = vec![0u64; 16];
    let mut areas = [0.0; 16];
    for (i, t) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize].as_dvec3());
        let bin = 2 * (i >> 18) + (i & 1);
        areas[bin] += (b - a).cross(c - a).length();
    }
    for _ in 0..COUNT / WIDTH {
        let choice = random.pair();
        let s = scene
            .lights
            .sample(None, Vec3x8::ZERO, || choice, random.pair());
        for id in s.primitive.to_array() {
            let id = (id & !TRIANGLE) as usize;
            observed[2 * (id >> 18) + (id & 1)] += 1;
        }
    }
    let total: f64 = areas.iter().sum();
    let expected: Vec<f64> = areas.iter().map(|a| a / total * COUNT as f64).collect();
    let p = chi_square(&observed, &expected);
    assert!(p > SIGNIFICANCE, "p = {p}");
}
