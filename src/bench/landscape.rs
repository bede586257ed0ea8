//! Meshes and a sky out of a seed: the same on every machine, for nothing but exactly rounded operations is used.

use crate::lanes::Rgb;
use crate::scene::description::LatLong;
use crate::scene::mesh::Mesh;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Half the side of a landscape, scene units.
const REACH: f32 = 1.5;
/// Each octave of noise has twice the frequency of the one before.
const OCTAVES: u32 = 9;

/// A number of 32 bits that depends on all bits of two others (the finaliser of MurmurHash3, twice).
pub fn hash(seed: u32, index: u32) -> u32 {
    let mix = |mut x: u32| {
        x = (x ^ x >> 16).wrapping_mul(0x85eb_ca6b);
        x = (x ^ x >> 13).wrapping_mul(0xc2b2_ae35);
        x ^ x >> 16
    };
    mix(mix(seed.wrapping_add(0x9e37_79b9)) ^ index)
}

/// A number from 0 to 1, 1 excluded.
pub fn unit(seed: u32, index: u32) -> f32 {
    (hash(seed, index) >> 8) as f32 / (1 << 24) as f32
}

/// Value noise, 0 to 1: numbers at the points of a lattice, and smooth in between.
fn noise(seed: u32, p: Vec2) -> f32 {
    let corner = p.floor();
    let t = p - corner;
    let t = t * t * (Vec2::splat(3.0) - 2.0 * t);
    let [x, y] = corner.to_array().map(|c| c as i32 as u32);
    let at = |dx: u32, dy: u32| {
        let row = hash(seed, y.wrapping_add(dy));
        unit(row, x.wrapping_add(dx))
    };
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    mix(
        mix(at(0, 0), at(1, 0), t.x),
        mix(at(0, 1), at(1, 1), t.x),
        t.y,
    )
}

/// Mountains: ridges of noise, octave over octave, each where the ones before are high.
fn height(seed: u32, x: f32, z: f32) -> f32 {
    let (mut sum, mut size, mut weight) = (0.0, 0.32, 1.0);
    let mut p = Vec2::new(x, z) * 1.7;
    for octave in 0..OCTAVES {
        let ridge = 1.0 - (2.0 * noise(seed.wrapping_add(octave), p) - 1.0).abs();
        let ridge = ridge * ridge * weight;
        sum += ridge * size;
        weight = (ridge * 1.6).clamp(0.0, 1.0);
        size *= 0.5;
        p = Vec2::new(p.x * 1.6 - p.y * 1.2, p.x * 1.2 + p.y * 1.6);
    }
    sum
}

/// Mountains of about so many triangles: a grid of squares, two triangles each, over [−1.5, 1.5]² of the x-z plane.
pub fn landscape(seed: u32, triangles: usize) -> Mesh {
    let squares = ((triangles as f64 / 2.0).sqrt().round() as u32).max(1);
    let side = squares + 1;
    let place = |i: u32| REACH * (2.0 * i as f32 / squares as f32 - 1.0);
    let positions = (0..side * side)
        .into_par_iter()
        .map(|i| {
            let (x, z) = (place(i % side), place(i / side));
            Vec3::new(x, height(seed, x, z), z)
        })
        .collect();
    let triangles = (0..squares * squares)
        .into_par_iter()
        .flat_map_iter(|i| {
            let a = i / squares * side + i % squares;
            [[a, a + side, a + 1], [a + 1, a + side, a + side + 1]]
        })
        .collect();
    Mesh {
        name: format!("landscape of {} triangles", 2 * squares * squares),
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// A sky with clouds and a sun that is brighter than all the rest: 512 × 256 pixels.
pub fn sky(seed: u32) -> LatLong {
    const WIDTH: usize = 512;
    const HEIGHT: usize = 256;
    let pixel = |i: usize| {
        let (x, y) = (i % WIDTH, i / WIDTH);
        let up = 1.0 - 2.0 * (y as f32 + 0.5) / HEIGHT as f32;
        let sun = Vec2::new(x as f32 - 372.0, y as f32 - 76.0).length_squared();
        if sun < 20.0 {
            return Rgb::new(1300.0, 1130.0, 900.0);
        }
        if up < 0.0 {
            return Rgb::new(0.16, 0.14, 0.12);
        }
        // The last column meets the first.
        let across = (x as f32 / WIDTH as f32 * 2.0 - 1.0).abs();
        let at = Vec2::new(across * 6.0, up * 9.0);
        let cloud = 0.6 * noise(seed, at) + 0.4 * noise(seed ^ 1, at * 2.7);
        let cloud = (cloud * 2.4 - 1.0).clamp(0.0, 1.0) * (1.0 - up * 0.6);
        let haze = (1.0 - up) * (1.0 - up);
        let blend = |clear: f32, white: f32| clear + (white - clear) * cloud;
        Rgb::new(
            blend(0.10 + 0.55 * haze, 1.1),
            blend(0.22 + 0.46 * haze, 1.1),
            blend(0.60 + 0.20 * haze, 1.15),
        )
    };
    LatLong {
        file: "sky".to_owned(),
        width: WIDTH,
        height: HEIGHT,
        pixels: (0..WIDTH * HEIGHT).map(pixel).collect(),
    }
}
