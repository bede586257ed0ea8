//! Stage 1: the sensor's rays.

use super::queues::PathRayX8;
use super::{Context, Wave};
use crate::lanes::{Queue, Rgbx8, WIDTH, f32x8, first_lanes, u32x8};

/// The first rays of a wave: pixel by pixel in rows, and for each pixel sample by sample, so that a batch is coherent.
#[inline(never)]
pub fn rays(ctx: &Context, wave: &Wave, rays: &mut Queue<PathRayX8>) {
    let paths = wave.paths();
    let mut next = Cursor {
        x: 0,
        y: 0,
        sample: 0,
    };
    for first in (0..paths).step_by(WIDTH) {
        let lanes: [Cursor; WIDTH] = std::array::from_fn(|_| next.step(wave));
        let column = u32x8::new(lanes.map(|lane| wave.x + lane.x));
        let row = u32x8::new(lanes.map(|lane| wave.y + lane.y));
        let sample = u32x8::new(lanes.map(|lane| wave.first_sample + lane.sample));

        // Rows and columns stay below 2^16.
        let path = ctx.sampler.path_key(row << 16 | column, sample);
        let (origin, direction) = ctx.sensor.rays(ctx.sampler, path, column, row);
        rays.push(
            first_lanes(paths - first),
            &PathRayX8 {
                origin,
                direction,
                throughput: Rgbx8::ONE,
                pdf: f32x8::splat(f32::INFINITY),
                path: u32x8::splat(first as u32) + u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]),
                key: path.key,
                index: path.index,
            },
        );
    }
}

/// The next path of a wave.
#[derive(Clone, Copy)]
struct Cursor {
    x: u32,
    y: u32,
    sample: u32,
}

impl Cursor {
    fn step(&mut self, wave: &Wave) -> Cursor {
        let this = *self;
        self.sample += 1;
        if self.sample == wave.samples {
            self.sample = 0;
            self.x += 1;
            if self.x == wave.width {
                self.x = 0;
                self.y += 1;
            }
        }
        this
    }
}
