//! The textbook: each triangle in turn, in double precision, and how far a kernel in single precision may be off.
//!
//! What is surely met must be found, or something nearer; what is found must be possible. In between lies what rounding
//! decides. The bounds follow from first-order error analysis of a kernel like that of Woop et al. (2013, Watertight
//! Ray/Triangle Intersection). With u the rounding of one operation, d the direction and M the distance from the ray's
//! origin to the farthest corner:
//!
//! - a corner relative to the origin, sheared, has at most 16 roundings of the size of M: that is how far it moves
//!   sideways. An edge function is a cross product of two corners, at most h off the ray: with both moved by s it changes
//!   by less than 4hs + 4s²;
//! - the distance is the mean of the corners' distances weighted by edge functions. Those are measured in any direction
//!   within 55° of the ray (the axis nearest to it), which changes a corner's by √2h: the mean is off by three edge
//!   functions' errors times the corners' extent, over the sum of the edge functions, and by 16uM for the rest. Where that
//!   sum is no more than rounding, it is anywhere between the corners' distances.
//!
//! So a triangle of less than some 64uM across may be met by a ray that passes it far away. No kernel that shears corners
//! can do better; boxes around it can.
//!
//! None of this holds where cubes of lengths underflow, below 10⁻¹².
//!
//! An instance takes the ray to its mesh's space. The inverse of a matrix of condition κ has a relative error of 16uκ²
//! (adjugate over determinant); origin and direction inherit it, the direction κ times where it ends up shorter.

use crate::rays::Ray;
use glam::{DAffine3, DMat3, DVec3};
use ondine::bvh::{Hit, Instance, NO_TRIANGLE};
use ondine::scene::mesh::Mesh;
use std::ops::RangeInclusive;

/// Relative error of one operation.
const U: f64 = f32::EPSILON as f64 / 2.0;

/// An instance, and what is lost on the way to its space.
struct Space {
    to_object: DAffine3,
    /// Longest that it makes what is 1 long.
    stretch: f64,
    translation: f64,
    /// Error of its matrix, in units of `stretch`.
    error: f64,
    condition: f64,
}

impl Space {
    fn of(instance: &Instance) -> Self {
        let to_world = instance.to_world.as_daffine3();
        let norm = |m: DMat3| m.to_cols_array().iter().map(|c| c * c).sum::<f64>().sqrt();
        let stretch = norm(to_world.matrix3.inverse());
        let condition = norm(to_world.matrix3) * stretch;
        let is_identity = to_world == DAffine3::IDENTITY;
        Self {
            to_object: to_world.inverse(),
            stretch,
            translation: to_world.translation.length(),
            error: if is_identity {
                0.0
            } else {
                16.0 * U * condition * condition
            },
            condition,
        }
    }
}

/// A ray and the plane of a triangle.
struct Meeting {
    /// Edge functions; all of one sign inside.
    edges: [f64; 3],
    /// By how much each may be off.
    error: f64,
    /// Where the distance may be.
    distance: RangeInclusive<f64>,
}

impl Meeting {
    fn new(ray: &Ray, space: &Space, corners: [DVec3; 3]) -> Self {
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let origin = space.to_object.transform_point3(o);
        let direction = space.to_object.transform_vector3(d);
        let length = direction.length();
        let lost_origin = space.error * space.stretch * (o.length() + space.translation);
        let lost_direction = space.error * space.condition;

        let [a, b, c] = corners.map(|corner| corner - origin);
        let axis = direction / length;
        let edges = [b.cross(c), c.cross(a), a.cross(b)].map(|moment| axis.dot(moment));
        let farthest = a.length().max(b.length()).max(c.length());
        let aside = [a, b, c].map(|corner| corner.cross(axis).length());
        let aside = aside.into_iter().fold(0.0, f64::max);
        let moved = 16.0 * U * farthest + lost_origin + farthest * lost_direction;
        let error = 4.0 * moved * (aside + moved);

        let along = [a, b, c].map(|corner| axis.dot(corner));
        let tilted = 2f64.sqrt() * (aside + moved);
        let low = along.into_iter().fold(f64::INFINITY, f64::min) - tilted;
        let high = along.into_iter().fold(f64::NEG_INFINITY, f64::max) + tilted;
        let mut distance = low - moved..=high + moved;
        let sum: f64 = edges.iter().sum();
        if sum.abs() > 6.0 * error {
            let at = (0..3).map(|k| edges[k] * along[k]).sum::<f64>() / sum;
            // Twice the first order: the sum itself is off by less than half.
            let off = 2.0 * 3.0 * error * (high - low) / sum.abs() + moved;
            distance = distance.start().max(at - off)..=distance.end().min(at + off);
        }
        Self {
            edges,
            error,
            distance: distance.start() / length..=distance.end() / length,
        }
    }

    /// Whether it is inside by more than rounding, at a distance that is surely between the ray's limits.
    fn is_sure(&self, ray: &Ray) -> bool {
        let is_inside = self.edges.iter().all(|&edge| edge > self.error)
            || self.edges.iter().all(|&edge| edge < -self.error);
        is_inside
            && *self.distance.start() > f64::from(ray.nearest)
            && *self.distance.end() < f64::from(ray.farthest)
    }

    /// Whether rounding can make it a hit.
    fn is_possible(&self, ray: &Ray) -> bool {
        let is_inside = self.edges.iter().all(|&edge| edge >= -self.error)
            || self.edges.iter().all(|&edge| edge <= self.error);
        is_inside
            && *self.distance.end() > f64::from(ray.nearest)
            && *self.distance.start() < f64::from(ray.farthest)
    }
}

/// All triangles of a scene, in order.
pub struct Oracle<'a> {
    meshes: &'a [Mesh],
    instances: &'a [Instance],
    spaces: Vec<Space>,
}

impl<'a> Oracle<'a> {
    pub fn new(meshes: &'a [Mesh], instances: &'a [Instance]) -> Self {
        Self {
            meshes,
            instances,
            spaces: instances.iter().map(Space::of).collect(),
        }
    }

    fn meetings(&self, ray: &Ray) -> impl Iterator<Item = (u32, u32, Meeting)> {
        let instances = self.instances.iter().zip(&self.spaces).enumerate();
        instances.flat_map(move |(id, (instance, space))| {
            let mesh = &self.meshes[instance.mesh];
            let triangles = mesh.triangles.iter().enumerate();
            triangles.map(move |(index, corners)| {
                let corners = corners.map(|corner| mesh.positions[corner as usize].as_dvec3());
                (id as u32, index as u32, Meeting::new(ray, space, corners))
            })
        })
    }

    /// Panics unless `hit` can be the nearest; returns whether anything is surely met.
    #[track_caller]
    pub fn assert_nearest(&self, ray: &Ray, hit: &Hit) -> bool {
        let distance = f64::from(hit.distance);
        let mut is_found = hit.triangle == NO_TRIANGLE
            && hit.instance == NO_TRIANGLE
            && hit.distance.to_bits() == ray.farthest.to_bits();
        let mut is_sure = false;
        for (instance, triangle, meeting) in self.meetings(ray) {
            if (instance, triangle) == (hit.instance, hit.triangle) {
                assert!(
                    meeting.is_possible(ray) && meeting.distance.contains(&distance),
                    "{ray:?} cannot meet {hit:?}: edges {:?} +- {}, distance {:?}",
                    meeting.edges,
                    meeting.error,
                    meeting.distance,
                );
                assert!(
                    hit.distance > ray.nearest && hit.distance < ray.farthest,
                    "{ray:?}: {hit:?}"
                );
                is_found = true;
            }
            if meeting.is_sure(ray) {
                is_sure = true;
                assert!(
                    distance <= *meeting.distance.end(),
                    "{ray:?} meets triangle {triangle} of instance {instance} at {:?}, nearer than {hit:?}",
                    meeting.distance,
                );
            }
        }
        assert!(is_found, "{ray:?}: {hit:?} is no triangle");
        is_sure
    }

    /// Panics unless `met` can be the answer to whether anything is between.
    #[track_caller]
    pub fn assert_any(&self, ray: &Ray, met: bool) {
        let (mut is_sure, mut is_possible) = (false, false);
        for (instance, triangle, meeting) in self.meetings(ray) {
            if (instance, triangle) != (0, ray.ignored) {
                is_sure |= meeting.is_sure(ray);
                is_possible |= meeting.is_possible(ray);
            }
        }
        let is_right = if met { is_possible } else { !is_sure };
        assert!(
            is_right,
            "{ray:?}: met {met}, possible {is_possible}, sure {is_sure}"
        );
    }
}
