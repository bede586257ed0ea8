//! The surface at a hit, lane by lane, against the textbook in double precision.

use crate::common::*;
use crate::{add, ball, empty};
use glam::{Affine3A, DAffine3, DVec3, Quat, Vec3};
use ondine::bvh::HitX8;
use ondine::lanes::{Vec3x8, WIDTH, f32x8, first_lanes, u32x8};
use ondine::scene::Scene;

const CAMERA: &str = "position = [0.0, 0.0, 5.0]\nlook_at = [0.0, 0.0, 0.0]\nvertical_fov = 30.0";

fn places() -> [Affine3A; 4] {
    let turned = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(-0.3);
    [
        Affine3A::IDENTITY,
        Affine3A::from_scale_rotation_translation(Vec3::new(2.0, 0.1, 0.7), turned, Vec3::ONE),
        Affine3A::from_scale_rotation_translation(
            Vec3::new(-1.0, 1.0, 3.0),
            turned,
            Vec3::new(300.0, -20.0, 5.0),
        ),
        Affine3A::from_scale(Vec3::splat(1e-4)),
    ]
}

/// What the surface is to be at the point with these barycentric coordinates.
struct Oracle {
    position: DVec3,
    ng: DVec3,
    ns: DVec3,
    uv: [f64; 2],
}

fn oracle(
    mesh: &ondine::scene::mesh::Mesh,
    place: Affine3A,
    triangle: usize,
    b: f64,
    c: f64,
) -> Oracle {
    let to_world: DAffine3 = place.into_d();
    let corners = mesh.triangles[triangle].map(|i| i as usize);
    let blend = |of: &dyn Fn(usize) -> DVec3| {
        let [p, q, r] = corners.map(of);
        p * (1.0 - b - c) + q * b + r * c
    };
    let [p, q, r] = corners.map(|i| mesh.positions[i].as_dvec3());
    let inverse_transpose = to_world.matrix3.inverse().transpose();
    let normal = blend(&|i| mesh.normals[i].as_dvec3());
    let uv = blend(&|i| mesh.uvs[i].as_dvec2().extend(0.0));
    Oracle {
        position: to_world.transform_point3(blend(&|i| mesh.positions[i].as_dvec3())),
        ng: (inverse_transpose * (q - p).cross(r - p)).normalize(),
        ns: (inverse_transpose * normal).normalize(),
        uv: [uv.x, uv.y],
    }
}

trait IntoDouble {
    fn into_d(self) -> DAffine3;
}

impl IntoDouble for Affine3A {
    fn into_d(self) -> DAffine3 {
        DAffine3::from_cols_array(&self.to_cols_array().map(f64::from))
    }
}

#[test]
fn surfaces_are_those_of_the_textbook_in_the_world_and_of_instances_mirrored_or_not() {
    let mesh = ball(2, true);
    let mut description = empty(CAMERA);
    for place in places() {
        add(&mut description, &mesh, place, 0);
    }
    let scene = Scene::compile(&description);
    let meshes = scene.meshes.as_ref().expect("meshes");
    let mut random = Random::new(500);
    for (instance, place) in places().into_iter().enumerate() {
        let matrix = place.matrix3;
        let axes =
            [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| f64::from(axis.length()));
        let scale = axes.into_iter().fold(0.0, f64::max);
        let least = axes.into_iter().fold(f64::INFINITY, f64::min);
        for _ in 0..200 {
            let count = mesh.triangles.len() as f32;
            let triangles: [u32; WIDTH] = std::array::from_fn(|_| (random.one() * count) as u32);
            let weights: [(f64, f64); WIDTH] = std::array::from_fn(|_| {
                let (b, c) = (f64::from(random.one()), f64::from(random.one()));
                if b + c < 1.0 {
                    (b, c)
                } else {
                    (1.0 - b, 1.0 - c)
                }
            });
            let want: [Oracle; WIDTH] = std::array::from_fn(|i| {
                let (b, c) = weights[i];
                oracle(&mesh, place, triangles[i] as usize, b, c)
            });
            let wide = |v: &dyn Fn(&Oracle) -> DVec3| -> Vec3x8 {
                pack(std::array::from_fn(|i| v(&want[i]).to_array()))
            };
            let hit = HitX8 {
                distance: f32x8::ONE,
                triangle: u32x8::new(triangles),
                instance: u32x8::splat(instance as u32),
            };
            let got = meshes.surface(
                first_lanes(WIDTH),
                &hit,
                wide(&|o| o.position),
                wide(&|o| o.ng),
            );
            for (i, want) in want.iter().enumerate() {
                let near = |got: &Vec3x8, want: DVec3, most: f64, what: &str| {
                    let off = got.lane(i).as_dvec3().distance(want);
                    assert!(off <= most, "{what} of {instance}: {off}");
                };
                // Corners of the world are rounded; edges are a third of the least axis long, at least.
                let rounded = 4.0 * 6e-8 * want.position.length() / (0.3 * least);
                near(&got.ng, want.ng, 1e-6 + rounded, "ng");
                near(&got.ns, want.ns, 1e-6 + rounded, "ns");
                near(
                    &got.position,
                    want.position,
                    1e-6 * (scale + want.position.length()),
                    "position",
                );
                let offset = f64::from(got.offset.as_array()[i]);
                let height = want.ng.dot(got.position.lane(i).as_dvec3() - want.position);
                assert!(height.abs() < offset, "{height} beyond {offset}");
                let far = 1e-6 * want.position.length() / scale;
                assert_close(
                    f64::from(got.uv.0.as_array()[i]),
                    want.uv[0],
                    0.0,
                    3e-6 + 8.0 * far,
                    "u",
                );
                assert_close(
                    f64::from(got.uv.1.as_array()[i]),
                    want.uv[1],
                    0.0,
                    3e-6 + 80.0 * far,
                    "v",
                );
            }
        }
    }
}

#[test]
fn seen_from_behind_a_smooth_edge_the_shading_normal_is_the_geometric_one() {
    let mesh = ball(0, true);
    let mut description = empty(CAMERA);
    add(&mut description, &mesh, Affine3A::IDENTITY, 0);
    let scene = Scene::compile(&description);
    let meshes = scene.meshes.as_ref().expect("meshes");
    let hit = HitX8 {
        distance: f32x8::ONE,
        triangle: u32x8::ZERO,
        instance: u32x8::ZERO,
    };
    // Near a corner, whose normal is the corner itself, along the face and a little above it.
    let [a, b, c] = mesh.triangles[0].map(|i| mesh.positions[i as usize]);
    let point = a * 0.98 + b * 0.01 + c * 0.01;
    let ng = (b - a).cross(c - a).normalize();
    let wo = (((b + c) * 0.5 - a).normalize() + ng * 0.01).normalize();
    let got = meshes.surface(
        first_lanes(WIDTH),
        &hit,
        Vec3x8::splat(point),
        Vec3x8::splat(wo),
    );
    for i in 0..WIDTH {
        assert!(got.ns.lane(i).dot(wo) > 0.0);
        assert!(got.ns.lane(i).distance(ng) < 1e-6);
    }
}
