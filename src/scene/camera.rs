//! The camera, eight rays at a time.

use super::description;
use crate::lanes::{Vec3x8, f32x8};
use crate::sampling::warp::{self, Pair};

/// A perspective camera with a thin lens, for one image size.
#[derive(Clone, Debug)]
pub struct Camera {
    position: Vec3x8,
    forward: Vec3x8,
    /// The image plane's half width and half height at distance 1, as vectors of the world.
    half_right: Vec3x8,
    half_up: Vec3x8,
    /// From pixels to [−1, 1].
    scale_x: f32x8,
    scale_y: f32x8,
    lens: Option<Lens>,
    filter: description::Filter,
}

#[derive(Clone, Debug)]
struct Lens {
    right: Vec3x8,
    up: Vec3x8,
    focus_distance: f32x8,
}

impl Camera {
    /// For an image of `width` × `height` square pixels.
    pub fn new(
        camera: &description::Camera,
        width: u32,
        height: u32,
        filter: description::Filter,
    ) -> Self {
        let position = camera.position.as_dvec3();
        let forward = (camera.look_at.as_dvec3() - position).normalize();
        let right = forward.cross(camera.up.as_dvec3()).normalize();
        let up = right.cross(forward);
        let tan = libm::tan(f64::from(camera.vertical_fov).to_radians() / 2.0);
        let aspect = f64::from(width) / f64::from(height);
        let wide = |v: glam::DVec3| Vec3x8::splat(v.as_vec3());
        let radius = f64::from(camera.aperture_radius);
        Self {
            position: wide(position),
            forward: wide(forward),
            half_right: wide(right * (tan * aspect)),
            half_up: wide(up * tan),
            scale_x: f32x8::splat((2.0 / f64::from(width)) as f32),
            scale_y: f32x8::splat((2.0 / f64::from(height)) as f32),
            lens: (radius > 0.0).then(|| Lens {
                right: wide(right * radius),
                up: wide(up * radius),
                focus_distance: f32x8::splat(camera.focus_distance),
            }),
            filter,
        }
    }

    /// Whether [`Camera::rays`] looks at its lens numbers.
    pub fn has_lens(&self) -> bool {
        self.lens.is_some()
    }

    /// Points, world space, whose convex hull holds the origin of every ray.
    pub fn origins(&self) -> Vec<glam::Vec3> {
        let position = self.position.lane(0);
        match &self.lens {
            None => vec![position],
            Some(lens) => {
                let (right, up) = (lens.right.lane(0), lens.up.lane(0));
                [right + up, right - up, up - right, -right - up]
                    .map(|offset| position + offset)
                    .to_vec()
            }
        }
    }

    /// Origins and unit directions, world space, through pixels (x, y); row 0 is at the top.
    #[inline]
    pub fn rays(&self, x: f32x8, y: f32x8, in_filter: Pair, on_lens: Pair) -> (Vec3x8, Vec3x8) {
        let (dx, dy) = match self.filter {
            description::Filter::Box => in_filter,
            description::Filter::Tent => (
                warp::tent(in_filter.0) + f32x8::HALF,
                warp::tent(in_filter.1) + f32x8::HALF,
            ),
            description::Filter::Gaussian => {
                let (gx, gy) = warp::gaussian_truncated(in_filter);
                (gx + f32x8::HALF, gy + f32x8::HALF)
            }
        };
        let across = (x + dx).mul_sub(self.scale_x, f32x8::ONE);
        let upward = (y + dy).mul_neg_add(self.scale_y, f32x8::ONE);
        let through = self
            .half_right
            .mul_add(across, self.half_up.mul_add(upward, self.forward));
        match &self.lens {
            None => (self.position, through.normalize()),
            Some(lens) => {
                let ((lx, ly), _) = warp::uniform_disk(on_lens);
                let offset = lens.right.mul_add(lx, lens.up * ly);
                let focus = through * lens.focus_distance;
                (self.position + offset, (focus - offset).normalize())
            }
        }
    }
}
