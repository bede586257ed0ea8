//! The surface of a mesh at eight hits.

use super::meshes::Meshes;
use crate::bvh::HitX8;
use crate::lanes::{Rgbx8, Vec3x8, WIDTH, f32x8, u32x8};

/// Rounding error of a point of a triangle, relative to the greatest coordinate of its corners: 16 units in the last place.
///
/// From barycentric coordinates the point is off its plane by at most 7 (Pharr, Jakob & Humphreys, PBR 4th ed., sec. 6.8.5),
/// however far the ray came; the rest is for the next ray's own test.
const POSITION_ERROR: f32 = 16.0 / 16_777_216.0;

/// What rays met on meshes.
#[derive(Clone, Copy, Debug)]
pub struct MeshSurfaceX8 {
    /// World space, on the triangle.
    pub position: Vec3x8,
    /// Geometric normal: unit, world space, outwards.
    pub ng: Vec3x8,
    /// Shading normal: interpolated and bent by the normal map; unit, on the side of `ng`, and seen from the same side.
    pub ns: Vec3x8,
    /// A bound of the position's rounding error along `ng`, scene units.
    pub offset: f32x8,
    /// Texture coordinates.
    pub uv: (f32x8, f32x8),
    /// Material id, or [`NONE`](super::NONE).
    pub material: u32x8,
    /// Light id, or [`NONE`](super::NONE).
    pub light: u32x8,
    /// The material's [`Kind`](crate::material::Kind) as a number, or [`NONE`](super::NONE).
    pub kind: u32x8,
    /// What the material's maps say.
    pub maps: MappedX8,
}

/// What textures multiply a material's parameters by.
#[derive(Clone, Copy, Debug)]
pub struct MappedX8 {
    /// Albedo, reflectance, diffuse or base colour.
    pub color: Rgbx8,
    /// Roughness.
    pub roughness: f32x8,
    /// Metallic.
    pub metallic: f32x8,
}

impl MappedX8 {
    /// Nothing is changed.
    pub const NONE: Self = Self {
        color: Rgbx8::ONE,
        roughness: f32x8::ONE,
        metallic: f32x8::ONE,
    };
}

/// Triangles under eight points, world space.
pub(super) struct TriangleX8 {
    corner: Vec3x8,
    edges: [Vec3x8; 2],
    /// Not unit; +z where the triangle has no area in single precision.
    pub normal: Vec3x8,
    /// The greatest coordinate of its corners.
    size: f32x8,
}

impl TriangleX8 {
    /// From corners; `outwards` is −1 where a mirrored place has turned them about.
    #[inline]
    pub fn new([a, b, c]: [Vec3x8; 3], outwards: f32x8) -> Self {
        let edges = [b - a, c - a];
        // Of edges about 1 long: the squares of small ones have no bits left.
        let scale = f32x8::ONE / edges[0].max_abs().fast_max(edges[1].max_abs());
        let normal = (edges[0] * scale).cross(edges[1] * (scale * outwards));
        let flat = normal.length_squared().simd_gt(f32x8::ZERO);
        Self {
            corner: a,
            edges,
            normal: Vec3x8::select(flat, normal, Vec3x8::Z),
            size: a.max_abs().fast_max(b.max_abs()).fast_max(c.max_abs()),
        }
    }

    /// The point at the barycentric coordinates of the second and third corner.
    #[inline]
    pub fn at(&self, b: f32x8, c: f32x8) -> Vec3x8 {
        self.edges[0].mul_add(b, self.edges[1].mul_add(c, self.corner))
    }

    /// Barycentric coordinates of the second and third corner, of the point of the triangle nearest in its plane.
    #[inline]
    fn barycentric(&self, point: Vec3x8) -> (f32x8, f32x8) {
        let [e1, e2] = self.edges;
        let s = point - self.corner;
        let n = e1.cross(e2);
        let scale = f32x8::ONE / n.max_abs();
        let n = n * scale;
        let per = scale / n.length_squared();
        let inside = |x: f32x8| (x & x.simd_gt(f32x8::ZERO)).fast_min(f32x8::ONE);
        let b = inside(s.cross(e2).dot(n) * per);
        let c = inside(e1.cross(s).dot(n) * per);
        // What rounding puts beyond the third edge goes back to it.
        let over = f32x8::ONE / (b + c).fast_max(f32x8::ONE);
        (b * over, c * over)
    }
}

/// Corners of triangles, as meshes have them.
struct CornersX8 {
    positions: [Vec3x8; 3],
    normals: [Vec3x8; 3],
    uvs: [(f32x8, f32x8); 3],
    /// Columns of the matrix to the world.
    axes: [Vec3x8; 3],
    translation: Vec3x8,
    material: u32x8,
    light: u32x8,
    kind: u32x8,
}

impl CornersX8 {
    /// Reads them in the lanes of `met`; the others hold arbitrary bits.
    #[inline]
    fn read(meshes: &Meshes, met: f32x8, hit: &HitX8) -> Self {
        let [xx, xy, xz, yx, yy, yz, zx, zy] = meshes.axes.gather(hit.instance);
        let [zz, tx, ty, tz, mesh, material, light, kind] = meshes.origins.gather(hit.instance);
        let mut positions = [[[0.0; WIDTH]; 3]; 3];
        let mut normals = positions;
        let mut uvs = [[[0.0; WIDTH]; 2]; 3];
        let (met, mesh) = (met.to_bitmask(), mesh.to_bits().to_array());
        for lane in (0..WIDTH).filter(|lane| met >> lane & 1 == 1) {
            let mesh = &*meshes.sources[mesh[lane] as usize];
            let triangle = mesh.triangles[hit.triangle.as_array()[lane] as usize];
            for (corner, vertex) in triangle.into_iter().enumerate() {
                let vertex = vertex as usize;
                let put = |to: &mut [[f32; WIDTH]; 3], v: glam::Vec3| {
                    [to[0][lane], to[1][lane], to[2][lane]] = v.to_array();
                };
                put(&mut positions[corner], mesh.positions[vertex]);
                if let Some(&normal) = mesh.normals.get(vertex) {
                    put(&mut normals[corner], normal);
                }
                if let Some(&uv) = mesh.uvs.get(vertex) {
                    [uvs[corner][0][lane], uvs[corner][1][lane]] = uv.to_array();
                }
            }
        }
        let wide = |v: [[f32; WIDTH]; 3]| {
            let [x, y, z] = v.map(f32x8::new);
            Vec3x8::new(x, y, z)
        };
        Self {
            positions: positions.map(wide),
            normals: normals.map(wide),
            uvs: uvs.map(|[u, v]| (f32x8::new(u), f32x8::new(v))),
            axes: [
                Vec3x8::new(xx, xy, xz),
                Vec3x8::new(yx, yy, yz),
                Vec3x8::new(zx, zy, zz),
            ],
            translation: Vec3x8::new(tx, ty, tz),
            material: material.to_bits(),
            light: light.to_bits(),
            kind: kind.to_bits(),
        }
    }

    /// Columns of the matrix that takes normals to the world, times the determinant, and −1 where that is negative.
    #[inline]
    fn cofactors(&self) -> ([Vec3x8; 3], f32x8) {
        let [x, y, z] = self.axes;
        let columns = [y.cross(z), z.cross(x), x.cross(y)];
        (columns, f32x8::ONE.copysign(x.dot(columns[0])))
    }

    /// In the world, by the same operations as glam's, so that these are the very triangles of the tree.
    #[inline]
    fn triangle(&self, outwards: f32x8) -> TriangleX8 {
        let [x, y, z] = self.axes;
        let place = |p: Vec3x8| ((x * p.x + y * p.y) + z * p.z) + self.translation;
        TriangleX8::new(self.positions.map(place), outwards)
    }

    #[inline]
    fn uv(&self, (b, c): (f32x8, f32x8)) -> (f32x8, f32x8) {
        let [p, q, r] = self.uvs;
        let along = |p: f32x8, q: f32x8, r: f32x8| (q - p).mul_add(b, (r - p).mul_add(c, p));
        (along(p.0, q.0, r.0), along(p.1, q.1, r.1))
    }
}

impl Meshes {
    /// The surface at hits that are [resolved](Meshes::resolve), in the lanes of `met`: `near` is the hit by the ray's
    /// distance, `wo` the way back along the ray.
    #[inline]
    pub fn surface(&self, met: f32x8, hit: &HitX8, near: Vec3x8, wo: Vec3x8) -> MeshSurfaceX8 {
        let corners = CornersX8::read(self, met, hit);
        let (cofactors, outwards) = corners.cofactors();
        let triangle = corners.triangle(outwards);
        let (b, c) = triangle.barycentric(near);
        let ng = triangle.normal.normalize();

        let [p, q, r] = corners.normals;
        let n = (q - p).mul_add(b, (r - p).mul_add(c, p));
        let [x, y, z] = cofactors;
        let smooth = x.mul_add(n.x, y.mul_add(n.y, z * n.z));
        let smooth = smooth * (f32x8::ONE / smooth.max_abs());
        let smooth = smooth.normalize();
        let smooth = smooth * f32x8::ONE.copysign(smooth.dot(ng));
        let has_normals = smooth.length_squared().simd_gt(f32x8::ZERO);
        let mut ns = Vec3x8::select(has_normals, smooth, ng);

        let uv = corners.uv((b, c));
        let mut maps = MappedX8::NONE;
        if let Some(table) = &self.maps {
            maps = table.look_up(corners.material, uv);
            ns = table.bend(corners.material, uv, ns, || {
                tangents(&triangle, &corners.uvs)
            });
        }
        // Rays meet an instance in its own space, from where rounding comes as far as its coordinates are from the world's.
        let placed = f32x8::from_bits(hit.instance.simd_ge(u32x8::splat(self.parts_in_world())));
        let away = corners.translation.max_abs() & placed;
        // Seen from behind, where the interpolated normal shows its front, the triangle's own serves.
        let same_side =
            (ns.dot(wo) * ng.dot(wo)).simd_gt(f32x8::ZERO) & ns.dot(ng).simd_gt(f32x8::ZERO);
        MeshSurfaceX8 {
            position: triangle.at(b, c),
            ng,
            ns: Vec3x8::select(same_side, ns, ng),
            offset: triangle.size.fast_max(away) * POSITION_ERROR,
            uv,
            material: corners.material,
            light: corners.light,
            kind: corners.kind,
            maps,
        }
    }

    /// Mask of the hits of the layer with holes that are not in a hole, in the lanes of `met`.
    #[inline]
    pub fn is_there(&self, met: f32x8, hit: &HitX8, near: Vec3x8) -> f32x8 {
        let Some(table) = &self.maps else {
            return met;
        };
        let corners = CornersX8::read(self, met, hit);
        let triangle = corners.triangle(f32x8::ONE);
        let uv = corners.uv(triangle.barycentric(near));
        met & table.is_there(corners.material, uv)
    }
}

/// dp/du and dp/dv of triangles by their texture coordinates; null vectors where those are all the same.
fn tangents(triangle: &TriangleX8, [p, q, r]: &[(f32x8, f32x8); 3]) -> [Vec3x8; 2] {
    let [e1, e2] = triangle.edges;
    let (u1, v1, u2, v2) = (q.0 - p.0, q.1 - p.1, r.0 - p.0, r.1 - p.1);
    let sign = f32x8::ONE.copysign(u1.mul_sub(v2, u2 * v1));
    // Times the absolute determinant, which does not matter to directions.
    [(e1 * v2 - e2 * v1) * sign, (e2 * u1 - e1 * u2) * sign]
}
