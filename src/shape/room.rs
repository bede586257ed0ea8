//! Rooms: six quads that close a box around the rest of the scene.

use crate::lanes::{Vec3x8, f32x8, u32x8};
use glam::{DVec3, Vec3};

/// A parallelepiped seen from inside: three pairs of parallel walls.
///
/// A ray that starts inside leaves through one wall of each pair, the one it heads for, and the nearest of the three is the
/// one it meets: a third of the divisions of six quads, and no test of edges.
#[derive(Clone, Debug)]
pub struct Room {
    slabs: [Slab; 3],
}

/// A pair of parallel walls, each number in all eight lanes.
#[derive(Clone, Debug)]
struct Slab {
    /// Unit, from the first wall to the second.
    normal: Vec3x8,
    /// `normal · p` on the first wall and on the second.
    planes: [f32x8; 2],
    ids: [u32x8; 2],
}

/// A quad by its corner and edges.
pub type QuadEdges = (Vec3, Vec3, Vec3);

impl Room {
    /// The room that six quads make, if they do; `ids` are theirs.
    ///
    /// Each must be a face of the same parallelepiped: its plane parallel to one other's, and its corners four of the
    /// eight, to a millionth of the room's size.
    pub fn new(quads: &[QuadEdges], ids: &[u32]) -> Option<Self> {
        if quads.len() != 6 || ids.len() != 6 {
            return None;
        }
        let corner = quads[0].0.as_dvec3();
        let (u, v) = (quads[0].1.as_dvec3(), quads[0].2.as_dvec3());
        // The wall opposite the first is the first moved by w.
        quads[1..].iter().find_map(|other| {
            let opposite = faces(*other);
            let first = faces(quads[0]);
            let w = center(&opposite) - center(&first);
            let tolerance = 1e-6 * (u.length() + v.length() + w.length());
            if u.cross(v).dot(w).abs() <= tolerance * u.cross(v).length() {
                return None;
            }
            let expected = [
                [corner, u, v],
                [corner + w, u, v],
                [corner, v, w],
                [corner + u, v, w],
                [corner, w, u],
                [corner + v, w, u],
            ];
            let mut places = [None; 6];
            for (quad, &id) in quads.iter().zip(ids) {
                let corners = faces(*quad);
                let place = expected.iter().position(|&[c, a, b]| {
                    same(&corners, &[c, c + a, c + b, c + a + b], tolerance)
                })?;
                places[place] = Some(id);
            }
            let slab = |place: usize, across: DVec3| {
                let [c, a, b] = expected[place];
                let n = a.cross(b).normalize();
                let n = n * n.dot(across).signum();
                let first = n.dot(c);
                Some(Slab {
                    normal: Vec3x8::splat(n.as_vec3()),
                    planes: [first, first + n.dot(across)].map(|d| f32x8::splat(d as f32)),
                    ids: [
                        u32x8::splat(places[place]?),
                        u32x8::splat(places[place + 1]?),
                    ],
                })
            };
            Some(Self {
                slabs: [slab(0, w)?, slab(2, u)?, slab(4, v)?],
            })
        })
    }

    /// Whether a point is inside.
    pub fn contains(&self, point: Vec3) -> bool {
        self.slabs.iter().all(|slab| {
            let height = slab.normal.lane(0).dot(point);
            let [low, high] = slab.planes.map(|plane| plane.to_array()[0]);
            low <= height && height <= high
        })
    }

    /// Distance and id of the wall that each ray meets, if it is nearer than `nearest`. Origins are inside.
    #[inline]
    pub fn leave(
        &self,
        origin: Vec3x8,
        direction: Vec3x8,
        nearest: (f32x8, u32x8),
    ) -> (f32x8, u32x8) {
        let (mut nearest, mut nearest_id) = nearest;
        for slab in &self.slabs {
            let speed = slab.normal.dot(direction);
            let back = speed.simd_lt(f32x8::ZERO);
            let plane = back.select(slab.planes[0], slab.planes[1]);
            // Along the walls: ±∞, or NaN for a point of the wall, and neither is nearer.
            let t = (plane - slab.normal.dot(origin)) / speed;
            let hit = t.simd_lt(nearest);
            nearest = hit.select(t, nearest);
            nearest_id = hit.select(back.select(slab.ids[0], slab.ids[1]), nearest_id);
        }
        (nearest, nearest_id)
    }
}

fn faces((corner, u, v): QuadEdges) -> [DVec3; 4] {
    let (corner, u, v) = (corner.as_dvec3(), u.as_dvec3(), v.as_dvec3());
    [corner, corner + u, corner + v, corner + u + v]
}

fn center(corners: &[DVec3; 4]) -> DVec3 {
    corners.iter().sum::<DVec3>() / 4.0
}

/// Whether each of these corners is one of those.
fn same(these: &[DVec3; 4], those: &[DVec3; 4], tolerance: f64) -> bool {
    those
        .iter()
        .all(|b| these.iter().any(|a| a.distance(*b) <= tolerance))
}
