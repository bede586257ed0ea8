//! Spatial splits, made before the tree is: a triangle whose box is mostly empty is put in as several pieces with smaller
//! boxes (after Karras & Aila 2013, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies", section 4.2).

use super::Triangles;
use super::item::Item;
use super::node::Bounds;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A triangle is split where its box is so many times emptier than the mean; so pieces are at most 1 / EMPTIER as many as
/// triangles.
const EMPTIER: f64 = 4.0;
/// The most pieces of a triangle.
const PIECES: usize = 64;
/// Triangles that a thread takes at a time.
const CHUNK: usize = 1 << 12;

/// The triangles of a mesh, whole.
pub(super) fn whole(mesh: &Triangles) -> Vec<Item> {
    (0..mesh.corners.len())
        .into_par_iter()
        .map(|triangle| Item::new(around(&mesh.corners_of(triangle)), triangle as u32))
        .collect()
}

/// The triangles of a mesh, long ones in pieces.
pub(super) fn pieces(mesh: &Triangles) -> Vec<Item> {
    let count = mesh.corners.len();
    // Summed chunk by chunk, in order: a tree does not depend on the number of threads.
    let sums: Vec<f64> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let end = count.min((chunk + 1) * CHUNK);
            (chunk * CHUNK..end)
                .map(|triangle| emptiness(&mesh.corners_of(triangle)))
                .sum()
        })
        .collect();
    let unit = EMPTIER * sums.iter().sum::<f64>() / count as f64;
    (0..count)
        .into_par_iter()
        .flat_map_iter(|triangle| {
            let corners = mesh.corners_of(triangle);
            let wanted = (emptiness(&corners) / unit) as usize;
            let mut items = Vec::with_capacity(1);
            let polygon = corners.map(|corner| corner.as_dvec3());
            split(
                &polygon,
                around(&corners),
                wanted.clamp(1, PIECES),
                &mut |bounds| {
                    items.push(Item::new(bounds, triangle as u32));
                },
            );
            items
        })
        .collect()
}

fn around(corners: &[Vec3; 3]) -> Bounds {
    let [a, b, c] = *corners;
    Bounds {
        low: a.min(b).min(c),
        high: a.max(b).max(c),
    }
}

/// Half the surface of a triangle's box, less what the thinnest box around its pieces would have.
fn emptiness(corners: &[Vec3; 3]) -> f64 {
    let bounds = around(corners);
    let size = (bounds.high - bounds.low).as_dvec3();
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    let shadows = (b - a).cross(c - a).abs() / 2.0;
    let half = size.x * size.y + size.y * size.z + size.z * size.x;
    (half - shadows.element_sum()).max(0.0)
}

/// Halves a convex polygon and its box, along the box's longest side, until there are so many pieces.
fn split(polygon: &[DVec3], bounds: Bounds, pieces: usize, found: &mut impl FnMut(Bounds)) {
    if pieces <= 1 {
        return found(bounds);
    }
    let size = bounds.high - bounds.low;
    let axis = size.max_position();
    let middle = (bounds.low[axis] + bounds.high[axis]) / 2.0;
    for (side, count) in [(-1.0, pieces / 2), (1.0, pieces - pieces / 2)] {
        let part = clip(polygon, axis, f64::from(middle), side);
        let tight = part.iter().fold(Bounds::EMPTY, |all, point| {
            let point = point.as_vec3();
            all.union(Bounds {
                low: point,
                high: point,
            })
        });
        if part.len() >= 3 {
            // Rounding may not carry a piece out of the whole.
            let inside = Bounds {
                low: tight.low.max(bounds.low),
                high: tight.high.min(bounds.high),
            };
            split(&part, inside, count, found);
        }
    }
}

/// The part of a polygon on one side of a plane, which belongs to it (Sutherland & Hodgman 1974, "Reentrant Polygon
/// Clipping").
fn clip(polygon: &[DVec3], axis: usize, plane: f64, side: f64) -> Vec<DVec3> {
    let mut part = Vec::with_capacity(polygon.len() + 1);
    for (index, &a) in polygon.iter().enumerate() {
        let b = polygon[(index + 1) % polygon.len()];
        let (from, to) = (side * (a[axis] - plane), side * (b[axis] - plane));
        if from >= 0.0 {
            part.push(a);
        }
        if (from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0) {
            let mut crossing = a.lerp(b, from / (from - to));
            crossing[axis] = plane;
            part.push(crossing);
        }
    }
    part
}
