//! Three-component vectors in eight lanes, and orthonormal frames.

use super::{f32x8, queue::Lane};
use glam::Vec3;
use std::ops::{Add, Mul, Neg, Sub};

/// Eight vectors (or points), one a lane.
#[derive(Clone, Copy, Default, Debug)]
#[repr(C)]
pub struct Vec3x8 {
    /// x of each lane.
    pub x: f32x8,
    /// y of each lane.
    pub y: f32x8,
    /// z of each lane.
    pub z: f32x8,
}

impl Vec3x8 {
    /// The null vector in every lane.
    pub const ZERO: Self = Self::new(f32x8::ZERO, f32x8::ZERO, f32x8::ZERO);
    /// +z in every lane: the normal of the local shading frame.
    pub const Z: Self = Self::new(f32x8::ZERO, f32x8::ZERO, f32x8::ONE);

    /// From components.
    #[inline]
    pub const fn new(x: f32x8, y: f32x8, z: f32x8) -> Self {
        Self { x, y, z }
    }

    /// The same vector in every lane.
    #[inline]
    pub fn splat(v: Vec3) -> Self {
        Self::new(f32x8::splat(v.x), f32x8::splat(v.y), f32x8::splat(v.z))
    }

    /// Dot product.
    #[inline]
    pub fn dot(self, b: Self) -> f32x8 {
        self.x.mul_add(b.x, self.y.mul_add(b.y, self.z * b.z))
    }

    /// Cross product.
    #[inline]
    pub fn cross(self, b: Self) -> Self {
        Self::new(
            self.y.mul_sub(b.z, self.z * b.y),
            self.z.mul_sub(b.x, self.x * b.z),
            self.x.mul_sub(b.y, self.y * b.x),
        )
    }

    /// `self * s + b`, fused.
    #[inline]
    pub fn mul_add(self, s: f32x8, b: Self) -> Self {
        Self::new(
            self.x.mul_add(s, b.x),
            self.y.mul_add(s, b.y),
            self.z.mul_add(s, b.z),
        )
    }

    /// Squared length.
    #[inline]
    pub fn length_squared(self) -> f32x8 {
        self.dot(self)
    }

    /// Unit vector of the same direction; not finite where the length is 0.
    #[inline]
    pub fn normalize(self) -> Self {
        self * (f32x8::ONE / self.length_squared().sqrt())
    }

    /// Unit vector of a vector that is nearly unit: one Newton step, which squares the error of the length.
    #[inline]
    pub fn renormalize(self) -> Self {
        self * self
            .length_squared()
            .mul_neg_add(f32x8::HALF, f32x8::splat(1.5))
    }

    /// The greatest absolute component.
    #[inline]
    pub fn max_abs(self) -> f32x8 {
        self.x.abs().fast_max(self.y.abs()).fast_max(self.z.abs())
    }

    /// `self` where the mask is on, `other` elsewhere.
    #[inline]
    pub fn select(mask: f32x8, on: Self, off: Self) -> Self {
        Self::new(
            mask.select(on.x, off.x),
            mask.select(on.y, off.y),
            mask.select(on.z, off.z),
        )
    }

    /// One lane.
    #[inline]
    pub fn lane(&self, lane: usize) -> Vec3 {
        Vec3::new(
            self.x.as_array()[lane],
            self.y.as_array()[lane],
            self.z.as_array()[lane],
        )
    }
}

impl Add for Vec3x8 {
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        Self::new(self.x + b.x, self.y + b.y, self.z + b.z)
    }
}

impl Sub for Vec3x8 {
    type Output = Self;
    #[inline]
    fn sub(self, b: Self) -> Self {
        Self::new(self.x - b.x, self.y - b.y, self.z - b.z)
    }
}

impl Mul<f32x8> for Vec3x8 {
    type Output = Self;
    #[inline]
    fn mul(self, s: f32x8) -> Self {
        Self::new(self.x * s, self.y * s, self.z * s)
    }
}

impl Neg for Vec3x8 {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl Lane for Vec3 {
    type Wide = Vec3x8;
    #[inline]
    fn get(wide: &Vec3x8, lane: usize) -> Self {
        wide.lane(lane)
    }
    #[inline]
    fn set(self, wide: &mut Vec3x8, lane: usize) {
        wide.x.as_mut_array()[lane] = self.x;
        wide.y.as_mut_array()[lane] = self.y;
        wide.z.as_mut_array()[lane] = self.z;
    }
}

/// A right-handed orthonormal basis around a unit normal; z of the local frame is the normal.
#[derive(Clone, Copy, Debug)]
pub struct FrameX8 {
    tangent: Vec3x8,
    bitangent: Vec3x8,
    normal: Vec3x8,
}

impl FrameX8 {
    /// From unit normals (Duff et al. 2017, "Building an Orthonormal Basis, Revisited", listing 3).
    #[inline]
    pub fn new(n: Vec3x8) -> Self {
        let sign = f32x8::ONE.copysign(n.z);
        let a = -f32x8::ONE / (sign + n.z);
        let b = n.x * n.y * a;
        Self {
            tangent: Vec3x8::new(
                (sign * n.x * n.x).mul_add(a, f32x8::ONE),
                sign * b,
                -(sign * n.x),
            ),
            bitangent: Vec3x8::new(b, (n.y * n.y).mul_add(a, sign), -n.y),
            normal: n,
        }
    }

    /// From the local frame to the world.
    #[inline]
    pub fn to_world(&self, v: Vec3x8) -> Vec3x8 {
        self.tangent
            .mul_add(v.x, self.bitangent.mul_add(v.y, self.normal * v.z))
    }

    /// From the world to the local frame.
    #[inline]
    pub fn to_local(&self, v: Vec3x8) -> Vec3x8 {
        Vec3x8::new(
            self.tangent.dot(v),
            self.bitangent.dot(v),
            self.normal.dot(v),
        )
    }
}
