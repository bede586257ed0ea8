//! Closed meshes, and what is surely inside them.
#![allow(dead_code, reason = "each test file uses a part")]

use glam::DVec3;
use ondine::scene::mesh::Mesh;
use std::collections::HashMap;
use std::f64::consts::TAU;

/// A closed mesh around the origin, of a size near 1.
pub struct Solid {
    pub name: &'static str,
    pub mesh: Mesh,
    /// Whether a point is surely inside. It is told a little less than the whole inside, so that the rounding of vertices
    /// to multiples of 10⁻⁴ moves no face past such a point.
    pub inside: fn(DVec3) -> bool,
}

fn mesh(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        positions: positions.iter().map(|p| p.as_vec3()).collect(),
        triangles,
        ..Mesh::default()
    }
}

/// The unit icosahedron with each triangle split into four, `levels` times.
fn sphere(levels: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let mut points = Vec::new();
    for (a, b) in [
        (1.0, golden),
        (-1.0, golden),
        (1.0, -golden),
        (-1.0, -golden),
    ] {
        for p in [
            DVec3::new(0.0, a, b),
            DVec3::new(a, b, 0.0),
            DVec3::new(b, 0.0, a),
        ] {
            points.push(p.normalize());
        }
    }
    // Its faces are the triples of vertices that are all neighbours of one another.
    let near = |i: usize, j: usize| points[i].distance(points[j]) < 1.2;
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(i, k) {
                    let out = points[i].dot(points[j].cross(points[k])) > 0.0;
                    let [j, k] = if out { [j, k] } else { [k, j] };
                    triangles.push([i, j, k].map(|v| v as u32));
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    (points, triangles)
}

/// 20·4^levels triangles, from `levels` = 2 on.
pub fn icosphere(levels: u32) -> Solid {
    let (points, triangles) = sphere(levels);
    Solid {
        name: "icosphere",
        mesh: mesh(points, triangles),
        inside: |p| p.length() < 0.97,
    }
}

/// A ball with waves on it, seen whole from its centre.
pub fn ball(levels: u32) -> Solid {
    let (points, triangles) = sphere(levels);
    let wave = |p: DVec3| {
        1.0 + 0.2 * (5.0 * p.x).sin() * (7.0 * p.y + 1.0).sin() * (6.0 * p.z + 2.0).sin()
    };
    Solid {
        name: "ball",
        mesh: mesh(points.iter().map(|&p| p * wave(p)).collect(), triangles),
        // Waves reach down to 0.8, and faces of 0.3 sag by less than 0.03 below them.
        inside: |p| p.length() < 0.75,
    }
}

const TUBE: f64 = 0.4;

/// A ring of radius 1 around z, 2·`around`·`across` triangles: at least 24 by 12.
pub fn torus(around: u32, across: u32) -> Solid {
    let mut points = Vec::new();
    for i in 0..around {
        let (sin, cos) = (f64::from(i) / f64::from(around) * TAU).sin_cos();
        for j in 0..across {
            let (up, out) = (f64::from(j) / f64::from(across) * TAU).sin_cos();
            let r = 1.0 + TUBE * out;
            points.push(DVec3::new(r * cos, r * sin, TUBE * up));
        }
    }
    let at = |i: u32, j: u32| i % around * across + j % across;
    let triangles = (0..around).flat_map(|i| {
        (0..across).flat_map(move |j| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
    });
    Solid {
        name: "torus",
        mesh: mesh(points, triangles.collect()),
        // Chords of the ring sag by 1 − cos 7.5° and those of the tube by 0.4·(1 − cos 15°).
        inside: |p| (p.truncate().length() - 1.0).hypot(p.z) < TUBE - 0.04,
    }
}

/// The box [−1, 1]³, with `count` strips of uneven width, long and thin, along each of the four sides around x.
pub fn strips(count: u32) -> Solid {
    let widths: Vec<f64> = (0..count)
        .map(|i| 1.0 + 0.9 * (f64::from(i) * 2.4).sin())
        .collect();
    let whole: f64 = widths.iter().sum();
    let mut points = Vec::new();
    for i in 0..=count as usize {
        let x = 2.0 * widths[..i].iter().sum::<f64>() / whole - 1.0;
        let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        points.extend(square.map(|(y, z)| DVec3::new(x, y, z)));
    }
    let mut triangles = vec![[0, 3, 2], [0, 2, 1]];
    for i in 0..count {
        for side in 0..4 {
            let [a, b] = [4 * i + side, 4 * i + (side + 1) % 4];
            triangles.extend([[a, b, b + 4], [a, b + 4, a + 4]]);
        }
    }
    let end = 4 * count;
    triangles.extend([[end, end + 1, end + 2], [end, end + 2, end + 3]]);
    Solid {
        name: "strips",
        mesh: mesh(points, triangles),
        inside: |p| p.abs().max_element() < 0.999,
    }
}

/// Each edge is shared by two triangles that run along it in opposite directions,
/// all have an area, and the volume inside is positive.
pub fn assert_closed(mesh: &Mesh) {
    let mut open = HashMap::new();
    let mut volume = 0.0;
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize].as_dvec3());
        assert!(
            (b - a).cross(c - a).length() > 0.0,
            "{corners:?} has no area"
        );
        volume += a.dot(b.cross(c)) / 6.0;
        for k in 0..3 {
            let (from, to) = (corners[k], corners[(k + 1) % 3]);
            *open.entry((from.min(to), from.max(to))).or_insert(0) +=
                if from < to { 1 } else { 256 };
        }
    }
    assert!(open.values().all(|&sides| sides == 257));
    assert!(volume > 0.0, "{volume}");
}
