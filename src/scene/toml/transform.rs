//! Where a shape is put.

use super::reader::{Table, Value};
use crate::error::Result;
use crate::scene::description::{Punctual, Shape};
use crate::scene::mesh::Mesh;
use glam::{Affine3A, DMat3, DVec3, Vec3};

/// Smallest factor: below it squares leave the range of 32-bit floats.
const SMALLEST: f32 = 1e-9;

/// `transform = { translate, rotate_degrees, scale }` of an object or light: scaled first, then turned, then moved.
pub(super) struct Transform<'a> {
    value: Value<'a>,
    pub affine: Affine3A,
    /// The factor, where it is the same along every axis.
    uniform: Option<f32>,
}

impl<'a> Transform<'a> {
    /// That of a table, where it has one.
    pub fn of(table: &Table<'a>) -> Result<Option<Self>> {
        let Some(value) = table.get("transform") else {
            return Ok(None);
        };
        let table = value.table("transform = { translate = [x, y, z] }")?;
        table.keys("a transform", &["translate", "rotate_degrees", "scale"])?;
        let vector = |key, or| table.get(key).map_or(Ok(or), |value| value.point());
        let translation = vector("translate", Vec3::ZERO)?;
        let angles = vector("rotate_degrees", Vec3::ZERO)?;
        let scale = table.get("scale").map_or(Ok(Vec3::ONE), |value| {
            let scale = match value.is_list() {
                true => value.point()?,
                false => Vec3::splat(value.number()?),
            };
            let factors = scale.to_array();
            match factors
                .iter()
                .all(|factor| (SMALLEST..=1e9).contains(&factor.abs()))
            {
                true => Ok(scale),
                false => Err(value.error(
                    "a scale of that size flattens the shape; write a factor from 1e-9 to 1e9",
                )),
            }
        })?;
        let linear = rotation(angles.as_dvec3()) * DMat3::from_diagonal(scale.as_dvec3());
        let [x, y, z] = scale.to_array();
        Ok(Some(Self {
            value,
            affine: Affine3A::from_mat3_translation(linear.as_mat3(), translation),
            uniform: (x == y && y == z).then_some(x.abs()),
        }))
    }

    /// A sphere or quad where it is put.
    pub fn apply(&self, shape: Shape) -> Result<Shape> {
        let point = |at| {
            let moved = self.affine.transform_point3(at);
            self.near(moved)?;
            Ok(moved)
        };
        let edge = |along| self.affine.transform_vector3(along);
        match shape {
            Shape::Sphere { center, radius } => match self.uniform {
                Some(factor) => Ok(Shape::Sphere {
                    center: point(center)?,
                    radius: radius * factor,
                }),
                None => Err(self.value.error(
                    "a sphere stays one only where its scale is one number; write scale = s",
                )),
            },
            // Mirrored, the edges change places, so that the normal stays on its side.
            Shape::Quad { corner, u, v } => {
                let (u, v) = match self.affine.matrix3.determinant() < 0.0 {
                    true => (v, u),
                    false => (u, v),
                };
                Ok(Shape::Quad {
                    corner: point(corner)?,
                    u: edge(u),
                    v: edge(v),
                })
            }
            mesh @ Shape::Mesh { .. } => Ok(mesh),
        }
    }

    /// Refuses what would put a mesh beyond all coordinates.
    pub fn check(&self, mesh: &Mesh, affine: &Affine3A) -> Result<()> {
        let (low, high) = mesh.bounds();
        for corner in 0..8 {
            let pick = |axis: usize| {
                if corner >> axis & 1 == 0 {
                    low[axis]
                } else {
                    high[axis]
                }
            };
            self.near(affine.transform_point3(Vec3::new(pick(0), pick(1), pick(2))))?;
        }
        Ok(())
    }

    fn near(&self, point: Vec3) -> Result<()> {
        // Also where it is not a number.
        match point.abs().max_element() <= 1e9 && point.is_finite() {
            true => Ok(()),
            false => Err(self.value.error(
                "it puts the shape beyond coordinates of ±1e9; move it less or scale it less",
            )),
        }
    }
}

/// A light of a mesh file where the file is put.
pub(super) fn moved(light: Punctual, affine: &Affine3A) -> Punctual {
    let at = |position| affine.transform_point3(position);
    let along = |direction| affine.transform_vector3(direction).normalize_or(direction);
    match light {
        Punctual::Point {
            position,
            intensity,
        } => Punctual::Point {
            position: at(position),
            intensity,
        },
        Punctual::Spot {
            position,
            direction,
            intensity,
            cos_inner,
            cos_outer,
        } => Punctual::Spot {
            position: at(position),
            direction: along(direction),
            intensity,
            cos_inner,
            cos_outer,
        },
        Punctual::Distant {
            direction,
            irradiance,
        } => Punctual::Distant {
            direction: along(direction),
            irradiance,
        },
    }
}

/// What `rotate_degrees` means: turns about x, then y, then z, axes that stay where they are; counter-clockwise as seen from
/// the axis' tip.
pub fn rotation(degrees: DVec3) -> DMat3 {
    let [(sx, cx), (sy, cy), (sz, cz)] = degrees.to_array().map(sin_cos);
    let about_x = DMat3::from_cols(DVec3::X, DVec3::new(0.0, cx, sx), DVec3::new(0.0, -sx, cx));
    let about_y = DMat3::from_cols(DVec3::new(cy, 0.0, -sy), DVec3::Y, DVec3::new(sy, 0.0, cy));
    let about_z = DMat3::from_cols(DVec3::new(cz, sz, 0.0), DVec3::new(-sz, cz, 0.0), DVec3::Z);
    about_z * about_y * about_x
}

/// Exact at multiples of 90 degrees.
fn sin_cos(degrees: f64) -> (f64, f64) {
    let quarters = (degrees / 90.0).round();
    let (sin, cos) = libm::sincos((degrees - 90.0 * quarters).to_radians());
    match quarters.rem_euclid(4.0) as u8 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}
