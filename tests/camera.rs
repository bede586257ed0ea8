//! Camera rays against the projection matrices of double precision.

mod common;

use common::*;
use glam::{DMat4, DVec3, Vec3};
use ondine::lanes::{WIDTH, f32x8};
use ondine::scene::camera::Camera;
use ondine::scene::description::{self, Filter};

const WIDE: (u32, u32) = (640, 360);

fn described(vertical_fov: f32) -> description::Camera {
    description::Camera {
        position: Vec3::new(1.5, 2.0, -3.0),
        look_at: Vec3::new(-0.5, 0.25, 4.0),
        up: Vec3::new(0.2, 2.0, 0.1),
        vertical_fov,
        aperture_radius: 0.0,
        focus_distance: 1.0,
    }
}

/// From the world to pixels of the image: `look_at` and `perspective` of the graphics textbook, and the viewport.
struct Projection {
    matrix: DMat4,
    size: (u32, u32),
}

impl Projection {
    fn new(camera: &description::Camera, size: (u32, u32)) -> Self {
        let aspect = f64::from(size.0) / f64::from(size.1);
        let fov = f64::from(camera.vertical_fov).to_radians();
        let view = glam::dcamera::rh::view::look_at_mat4(
            camera.position.as_dvec3(),
            camera.look_at.as_dvec3(),
            camera.up.as_dvec3(),
        );
        Self {
            matrix: glam::dcamera::rh::proj::opengl::perspective(fov, aspect, 0.1, 100.0) * view,
            size,
        }
    }

    fn pixel(&self, point: DVec3) -> (f64, f64) {
        let ndc = self.matrix.project_point3(point);
        (
            0.5 * (ndc.x + 1.0) * f64::from(self.size.0),
            0.5 * (1.0 - ndc.y) * f64::from(self.size.1),
        )
    }

    fn direction(&self, eye: DVec3, (x, y): (f64, f64)) -> DVec3 {
        let ndc = DVec3::new(
            2.0 * x / f64::from(self.size.0) - 1.0,
            1.0 - 2.0 * y / f64::from(self.size.1),
            0.5,
        );
        (self.matrix.inverse().project_point3(ndc) - eye).normalize()
    }
}

fn splat(x: f64) -> f32x8 {
    f32x8::splat(x as f32)
}

/// One ray: origin, direction.
fn ray(
    camera: &Camera,
    (x, y): (f64, f64),
    filter: (f64, f64),
    lens: (f64, f64),
) -> (DVec3, DVec3) {
    let pair = |(a, b)| (splat(a), splat(b));
    let (o, d) = camera.rays(splat(x), splat(y), pair(filter), pair(lens));
    (o.lane(3).as_dvec3(), d.lane(3).as_dvec3())
}

const MIDDLE: (f64, f64) = (0.5, 0.5);

#[test]
fn pixel_centres_project_to_pixel_centres() {
    for fov in [0.5, 20.0, 50.0, 120.0, 170.0] {
        for size in [WIDE, (64, 64), (3, 200), (1, 1), (4096, 17)] {
            let described = described(fov);
            let camera = Camera::new(&described, size.0, size.1, Filter::Box);
            let projection = Projection::new(&described, size);
            let mut random = Random::new(300);
            for _ in 0..500 {
                let x = f64::from((random.one() * size.0 as f32).floor());
                let y = f64::from((random.one() * size.1 as f32).floor());
                let (o, d) = ray(&camera, (x, y), MIDDLE, MIDDLE);
                assert_eq!(o, described.position.as_dvec3());
                assert_close(d.length(), 1.0, 0.0, 1e-6, "length");
                let want = projection.direction(o, (x + 0.5, y + 0.5));
                assert!(
                    (d - want).length() < 4e-7,
                    "{fov} {size:?} {x},{y}: {d} is not {want}"
                );
            }
        }
    }
}

#[test]
fn image_right_is_view_direction_cross_up_and_row_0_is_at_the_top() {
    let described = described(40.0);
    let camera = Camera::new(&described, WIDE.0, WIDE.1, Filter::Box);
    let view = (described.look_at - described.position)
        .as_dvec3()
        .normalize();
    let up = described.up.as_dvec3();
    let (left, right) = (
        ray(&camera, (0.0, 179.5), MIDDLE, MIDDLE).1,
        ray(&camera, (639.0, 179.5), MIDDLE, MIDDLE).1,
    );
    let step = (right - left).normalize();
    assert!((step - view.cross(up).normalize()).length() < 1e-6);
    let (top, bottom) = (
        ray(&camera, (319.5, 0.0), MIDDLE, MIDDLE).1,
        ray(&camera, (319.5, 359.0), MIDDLE, MIDDLE).1,
    );
    assert!((top - bottom).dot(up) > 0.0);
    assert!((top - bottom).dot(step).abs() < 1e-6);
}

#[test]
fn the_field_of_view_is_the_angle_from_the_top_edge_to_the_bottom_edge() {
    for fov in [1.0, 35.0, 90.0, 150.0] {
        let camera = Camera::new(&described(fov), WIDE.0, WIDE.1, Filter::Box);
        let top = ray(&camera, (319.5, 0.0), (0.5, 0.0), MIDDLE).1;
        let bottom = ray(&camera, (319.5, 360.0), (0.5, 0.0), MIDDLE).1;
        let angle = libm::atan2(top.cross(bottom).length(), top.dot(bottom)).to_degrees();
        assert_close(angle, f64::from(fov), 1e-5, 0.0, "degrees");
    }
}

#[test]
fn all_rays_of_a_pixel_sample_meet_in_the_plane_of_focus_and_start_on_the_lens() {
    let mut random = Random::new(301);
    for (radius, focus) in [(0.1, 2.5), (1.0, 0.7), (1e-3, 50.0)] {
        let pinhole = described(45.0);
        let described = description::Camera {
            aperture_radius: radius,
            focus_distance: focus,
            ..pinhole
        };
        let through_lens = Camera::new(&described, WIDE.0, WIDE.1, Filter::Box);
        let through_hole = Camera::new(&pinhole, WIDE.0, WIDE.1, Filter::Box);
        assert!(through_lens.has_lens() && !through_hole.has_lens());
        let view = (described.look_at - described.position)
            .as_dvec3()
            .normalize();
        let eye = described.position.as_dvec3();
        let (radius, focus) = (f64::from(radius), f64::from(focus));
        for _ in 0..100 {
            let mut number = || f64::from(random.one());
            let (pixel, sample) = ((number() * 600.0, number() * 300.0), (number(), number()));
            let (_, d) = ray(&through_hole, pixel, sample, MIDDLE);
            let sharp = eye + d * (focus / d.dot(view));
            let mut radii = Vec::new();
            for _ in 0..50 {
                let (o, d) = ray(&through_lens, pixel, sample, (number(), number()));
                assert!((o - eye).dot(view).abs() < 2e-6, "off the lens plane");
                radii.push((o - eye).length() / radius);
                let there = o + d * ((sharp - o).dot(view) / d.dot(view));
                assert!(
                    (there - sharp).length() < 3e-6 * (focus + 5.0),
                    "{there} {sharp}"
                );
            }
            assert!(radii.iter().all(|r| *r < 1.0 + 4e-4), "outside the lens");
            assert!(radii.iter().any(|r| *r > 0.8) && radii.iter().any(|r| *r < 0.5));
        }
    }
}

#[test]
fn points_of_the_lens_are_uniform_over_it() {
    let described = description::Camera {
        aperture_radius: 1.0,
        ..described(45.0)
    };
    let camera = Camera::new(&described, 8, 8, Filter::Box);
    let mut random = Random::new(302);
    let mut observed = [0u64; 64];
    for _ in 0..SAMPLES / 4 / WIDTH {
        let (o, _) = camera.rays(
            splat(2.0),
            splat(5.0),
            (splat(0.5), splat(0.5)),
            random.pair(),
        );
        for i in 0..WIDTH {
            let offset = o.lane(i).as_dvec3() - described.position.as_dvec3();
            let side = DVec3::new(1.0, 0.3, -0.2)
                .cross(offset.cross(DVec3::X))
                .dot(offset);
            let ring = (offset.length_squared() * 32.0) as usize;
            observed[ring.min(31) * 2 + usize::from(side > 0.0)] += 1;
        }
    }
    let rings: Vec<u64> = observed.chunks(2).map(|pair| pair[0] + pair[1]).collect();
    let expected = vec![SAMPLES as f64 / 4.0 / 32.0; 32];
    let p = chi_square(&rings, &expected);
    assert!(p > SIGNIFICANCE, "p = {p}");
}

/// Variance along an axis of the Gaussian (σ = 1/2) cut off at a radius of 3/2: half of that of r².
fn gaussian_variance() -> f64 {
    let (sigma2, exponent) = (0.25, 1.5 * 1.5 / (2.0 * 0.25));
    let tail = libm::exp(-exponent);
    sigma2 * (1.0 - exponent * tail / (1.0 - tail))
}

#[test]
fn filters_are_centred_on_their_pixel_and_have_their_width() {
    for (filter, reach, variance) in [
        (Filter::Box, 0.5, 1.0 / 12.0),
        (Filter::Tent, 1.0, 1.0 / 6.0),
        (Filter::Gaussian, 1.5, gaussian_variance()),
    ] {
        let described = described(30.0);
        let size = (16, 16);
        let camera = Camera::new(&described, size.0, size.1, filter);
        let projection = Projection::new(&described, size);
        let mut random = Random::new(303);
        let (mut sums, mut squares, mut widest) = ([0.0; 2], [0.0; 2], [0.0f64; 2]);
        let count = 200_000;
        for _ in 0..count / WIDTH {
            let (o, d) = camera.rays(splat(3.0), splat(11.0), random.pair(), random.pair());
            for i in 0..WIDTH {
                let (x, y) = projection.pixel(o.lane(i).as_dvec3() + d.lane(i).as_dvec3());
                for (axis, offset) in [x - 3.5, y - 11.5].into_iter().enumerate() {
                    sums[axis] += offset;
                    squares[axis] += offset * offset;
                    widest[axis] = widest[axis].max(offset.abs());
                }
            }
        }
        for axis in 0..2 {
            let n = count as f64;
            let error = (variance / n).sqrt();
            assert_close(sums[axis] / n, 0.0, 0.0, 4.0 * error, "mean offset");
            assert_close(squares[axis] / n, variance, 0.02, 0.0, "variance");
            assert!(widest[axis] <= reach + 1e-4, "{filter}: {}", widest[axis]);
            assert!(widest[axis] > 0.95 * reach, "{filter}: {}", widest[axis]);
        }
    }
}
