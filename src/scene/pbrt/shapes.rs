//! Shapes to geometry in their own space.

use super::files::Files;
use super::names::quoted;
use super::parameters::Parameters;
use super::tessellate;
use super::warnings::Warnings;
use crate::error::{Error, Result};
use crate::scene::mesh::{Mesh, MeshError};
use crate::scene::ply;
use flate2::read::MultiGzDecoder;
use glam::{DAffine3, DVec3, Vec2, Vec3};
use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::Arc;

/// Most meshes that the program makes of shapes: each has thousands of triangles, and takes a line to ask for.
const MOST_GENERATED: usize = 1024;

/// What a shape is, in its own space.
#[derive(Clone, Debug)]
pub(super) enum Geometry {
    /// A whole sphere of radius 1 around the origin, and the mesh for where it cannot be one.
    Sphere(Arc<Mesh>),
    /// A mesh; where it is a parallelogram without normals, also its corner and edges.
    Mesh(Arc<Mesh>, Option<[Vec3; 3]>),
}

impl Geometry {
    /// Its mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        match self {
            Self::Sphere(mesh) | Self::Mesh(mesh, _) => mesh,
        }
    }
}

/// Every geometry of the scene; what several shapes have in common is there once.
#[derive(Debug, Default)]
pub(super) struct Geometries {
    pub list: Vec<Geometry>,
    by_name: HashMap<String, usize>,
    /// How many meshes the program made.
    generated: usize,
}

/// A geometry, and where it stands in the space of the directive.
type Found = Option<(usize, DAffine3)>;

impl Geometries {
    /// The geometry of a `Shape` directive; none, and told, where it is left out.
    pub fn shape(
        &mut self,
        parameters: &Parameters,
        kind: &str,
        files: &mut Files,
        warnings: &mut Warnings,
    ) -> Result<Found> {
        let of_mesh = |found: Option<usize>| found.map(|index| (index, DAffine3::IDENTITY));
        match kind {
            "trianglemesh" => {
                let mesh = triangle_mesh(parameters)?;
                Ok(of_mesh(self.mesh(mesh, parameters, warnings)?))
            }
            "loopsubdiv" => {
                let _ = (parameters.get("levels"), parameters.get("scheme"));
                warnings.tell(
                    &parameters.at,
                    "subdivision is not supported; the mesh it begins with stands in its place",
                );
                let mesh = triangle_mesh(parameters)?;
                Ok(of_mesh(self.mesh(mesh, parameters, warnings)?))
            }
            "bilinearmesh" => {
                let mesh = self.bilinear_mesh(parameters, warnings)?;
                Ok(of_mesh(self.mesh(mesh, parameters, warnings)?))
            }
            "plymesh" => Ok(of_mesh(self.ply(parameters, files, warnings)?)),
            "sphere" => self.sphere(parameters).map(Some),
            "disk" => {
                let radius = length(parameters, "radius", 1.0)?;
                let hole = parameters.float_in("innerradius", "at least 0", |r| r >= 0.0)?;
                let inner = f64::from(hole.unwrap_or(0.0)) / radius;
                let sweep = sweep(parameters)?;
                let height = coordinate(parameters, "height", 0.0)?;
                let name = format!("disk {inner} {sweep}");
                let index =
                    self.generated(&name, parameters, || tessellate::disk(inner, sweep), plain)?;
                let place = DAffine3::from_translation(DVec3::Z * height)
                    * DAffine3::from_scale(DVec3::splat(radius));
                Ok(Some((index, place)))
            }
            "cylinder" => {
                let radius = length(parameters, "radius", 1.0)?;
                let low = coordinate(parameters, "zmin", -1.0)?;
                let high = coordinate(parameters, "zmax", 1.0)?;
                let (low, high) = (low.min(high), low.max(high));
                let sweep = sweep(parameters)?;
                let name = format!("cylinder {sweep}");
                let index =
                    self.generated(&name, parameters, || tessellate::cylinder(sweep), plain)?;
                let place = DAffine3::from_translation(DVec3::Z * low)
                    * DAffine3::from_scale(DVec3::new(radius, radius, high - low));
                Ok(Some((index, place)))
            }
            _ => {
                parameters.ignore();
                warnings.tell_once(format!("shape {kind}"), &parameters.at, || {
                    format!(
                        "the shape {} is not supported; such shapes are left out",
                        quoted(kind)
                    )
                });
                Ok(None)
            }
        }
    }

    fn sphere(&mut self, parameters: &Parameters) -> Result<(usize, DAffine3)> {
        let radius = length(parameters, "radius", 1.0)?;
        let end = |name, default: f64| {
            Ok::<f64, Error>(coordinate(parameters, name, default)?.clamp(-radius, radius) / radius)
        };
        let (a, b) = (end("zmin", -radius)?, end("zmax", radius)?);
        let (low, high) = (a.min(b), a.max(b));
        let sweep = sweep(parameters)?;
        let name = format!("sphere {low} {high} {sweep}");
        let make = || tessellate::sphere(low, high, sweep);
        let index = if (low, high, sweep) == (-1.0, 1.0, 1.0) {
            self.generated(&name, parameters, make, Geometry::Sphere)?
        } else {
            self.generated(&name, parameters, make, plain)?
        };
        Ok((index, DAffine3::from_scale(DVec3::splat(radius))))
    }

    /// A mesh that the program makes; `name` tells all that are different.
    fn generated(
        &mut self,
        name: &str,
        parameters: &Parameters,
        make: impl FnOnce() -> Mesh,
        geometry: impl FnOnce(Arc<Mesh>) -> Geometry,
    ) -> Result<usize> {
        if let Some(&index) = self.by_name.get(name) {
            return Ok(index);
        }
        if self.generated >= MOST_GENERATED {
            return Err(parameters.at.error(format!(
                "the scene has more than {MOST_GENERATED} different parts of spheres, disks and cylinders; write some as meshes"
            )));
        }
        self.generated += 1;
        // Poles leave triangles without an area.
        let checked = make().checked();
        let (mesh, _) = checked.map_err(|error| explained(parameters, &error))?;
        Ok(self.named(name, geometry(Arc::new(mesh))))
    }

    fn named(&mut self, name: &str, geometry: Geometry) -> usize {
        self.by_name.insert(name.to_owned(), self.list.len());
        self.list.push(geometry);
        self.list.len() - 1
    }

    fn ply(
        &mut self,
        parameters: &Parameters,
        files: &mut Files,
        warnings: &mut Warnings,
    ) -> Result<Option<usize>> {
        let at = &parameters.at;
        let Some(name) = parameters.text("filename")? else {
            return Err(at.error("a plymesh needs \"string filename\" \"mesh.ply\""));
        };
        let path = files.path(name);
        let key = format!("ply {}", path.display());
        if let Some(&index) = self.by_name.get(&key) {
            return Ok(Some(index));
        }
        let loaded = read_ply(&path)
            .and_then(|loaded| {
                let hashed = files.hash(&path);
                hashed.map_err(|source| Error::Read {
                    path: path.clone(),
                    source,
                })?;
                Ok(loaded)
            })
            .map_err(|error| at.error(error.to_string()))?;
        tell_dropped(loaded.dropped, parameters, warnings);
        let mesh = facing_normals(loaded.mesh);
        Ok(Some(self.named(&key, geometry(mesh))))
    }

    fn bilinear_mesh(&mut self, parameters: &Parameters, warnings: &mut Warnings) -> Result<Mesh> {
        let (mut mesh, indices) = vertices(parameters, 4)?;
        if parameters.get("emissionfilename").is_some() {
            warnings.tell(
                &parameters.at,
                "emissionfilename is not supported; the patch emits the same everywhere",
            );
        }
        let patches = indices.as_chunks::<4>().0;
        let corner = |index: u32| mesh.positions.get(index as usize).map(|p| p.as_dvec3());
        let bent = |patch: &[u32; 4]| {
            let [Some(a), Some(b), Some(c), Some(d)] = patch.map(corner) else {
                return None;
            };
            let normal = (b - a).cross(c - a);
            let off = normal.dot(d - a).abs();
            let is_bent = off > 1e-4 * normal.length() * (d - a).length();
            is_bent.then_some([a, b, c, d])
        };
        if let Some(corners) = patches.iter().find_map(bent) {
            let is_bare = mesh.normals.is_empty() && mesh.uvs.is_empty();
            if patches.len() == 1 && is_bare && self.generated < MOST_GENERATED {
                self.generated += 1;
                return Ok(tessellate::patch(corners));
            }
            warnings.tell(
                &parameters.at,
                "bilinear patches that are not flat become two triangles each",
            );
        }
        if mesh.uvs.is_empty() && indices.iter().all(|&index| corner(index).is_some()) {
            return Ok(with_own_uvs(&mesh, patches));
        }
        for &[a, b, c, d] in patches {
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
        Ok(mesh)
    }

    /// Checks a mesh of the scene file; one without any area is left out.
    fn mesh(
        &mut self,
        mesh: Mesh,
        parameters: &Parameters,
        warnings: &mut Warnings,
    ) -> Result<Option<usize>> {
        match mesh.checked() {
            Ok((mesh, dropped)) => {
                tell_dropped(dropped, parameters, warnings);
                self.list.push(geometry(facing_normals(mesh)));
                Ok(Some(self.list.len() - 1))
            }
            Err(MeshError::Empty) => {
                warnings.tell(
                    &parameters.at,
                    "this mesh has no triangle with an area; such meshes are left out",
                );
                Ok(None)
            }
            Err(error) => Err(explained(parameters, &error)),
        }
    }
}

fn explained(parameters: &Parameters, error: &MeshError) -> Error {
    parameters
        .at
        .error(format!("{}: {error}", parameters.owner))
}

fn tell_dropped(dropped: usize, parameters: &Parameters, warnings: &mut Warnings) {
    if dropped > 0 {
        warnings.tell_once("dropped".to_owned(), &parameters.at, || {
            format!("{dropped} triangles of this mesh have no area; such triangles are left out")
        });
    }
}

/// A mesh that is no parallelogram.
fn plain(mesh: Arc<Mesh>) -> Geometry {
    Geometry::Mesh(mesh, None)
}

fn geometry(mesh: Mesh) -> Geometry {
    let parallelogram = parallelogram(&mesh);
    Geometry::Mesh(Arc::new(mesh), parallelogram)
}

fn read_ply(path: &Path) -> Result<ply::Loaded> {
    if path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("gz"))
    {
        let file = File::open(path).map_err(|source| Error::Read {
            path: path.to_owned(),
            source,
        })?;
        return ply::read(BufReader::new(MultiGzDecoder::new(file)), path);
    }
    ply::load(path)
}

fn length(parameters: &Parameters, name: &str, default: f64) -> Result<f64> {
    let length = parameters.float_in(name, "from 1e-9 to 1e9", |length| {
        (1e-9..=1e9).contains(&length)
    })?;
    Ok(length.map_or(default, f64::from))
}

fn coordinate(parameters: &Parameters, name: &str, default: f64) -> Result<f64> {
    let value = parameters.float_in(name, "within ±1e9", |value| value.abs() <= 1e9)?;
    Ok(value.map_or(default, f64::from))
}

/// Turns.
fn sweep(parameters: &Parameters) -> Result<f64> {
    let degrees = parameters.float("phimax")?.unwrap_or(360.0);
    Ok(f64::from(degrees.clamp(0.0, 360.0)) / 360.0)
}

fn triangle_mesh(parameters: &Parameters) -> Result<Mesh> {
    let (mut mesh, indices) = vertices(parameters, 3)?;
    let _ = (parameters.get("S"), parameters.get("faceIndices"));
    mesh.triangles = indices.as_chunks().0.to_vec();
    Ok(mesh)
}

/// What meshes of all kinds have, and their corners, `group` to a face.
fn vertices(parameters: &Parameters, group: usize) -> Result<(Mesh, Vec<u32>)> {
    let at = &parameters.at;
    let owner = &parameters.owner;
    let Some(positions) = parameters.points("P")? else {
        return Err(at.error(format!(
            "{owner} has no vertices; add \"point3 P\" [x y z ...]"
        )));
    };
    let indices = match parameters.integers("indices")? {
        Some(indices) => indices
            .iter()
            .map(|&index| u32::try_from(index))
            .collect::<std::result::Result<Vec<u32>, _>>()
            .map_err(|_| {
                at.error(format!(
                    "{owner} has a negative index; indices count from 0"
                ))
            })?,
        None if positions.len() == group => (0..group as u32).collect(),
        None => {
            return Err(at.error(format!(
                "{owner} has no faces; add \"integer indices\", {group} to a face"
            )));
        }
    };
    if indices.len() % group != 0 {
        return Err(at.error(format!(
            "{owner} has {} indices, and a face has {group}; add or remove some",
            indices.len()
        )));
    }
    let uvs = match parameters.pairs("uv")? {
        Some(uvs) => uvs,
        None => parameters.pairs("st")?.unwrap_or_default(),
    };
    let mesh = Mesh {
        name: owner.clone(),
        positions,
        triangles: Vec::new(),
        normals: parameters.points("N")?.unwrap_or_default(),
        uvs,
    };
    Ok((mesh, indices))
}

/// Patches whose UV is the unit square: they share no vertices.
fn with_own_uvs(mesh: &Mesh, patches: &[[u32; 4]]) -> Mesh {
    const SQUARE: [Vec2; 4] = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];
    let mut own = Mesh {
        name: mesh.name.clone(),
        ..Mesh::default()
    };
    for (patch, corners) in patches.iter().enumerate() {
        for (&corner, uv) in corners.iter().zip(SQUARE) {
            own.positions.extend(mesh.positions.get(corner as usize));
            own.normals.extend(mesh.normals.get(corner as usize));
            own.uvs.push(uv);
        }
        let [a, b, c, d] = [0, 1, 2, 3].map(|corner| 4 * patch as u32 + corner);
        own.triangles.extend([[a, b, d], [a, d, c]]);
    }
    own
}

/// Triangles turned to the side of their vertices' normals, as pbrt has it (`Triangle::InteractionFromIntersection`).
fn facing_normals(mut mesh: Mesh) -> Mesh {
    if !mesh.normals.is_empty() {
        for corners in &mut mesh.triangles {
            let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize].as_dvec3());
            let normal = (b - a).cross(c - a);
            let shading: DVec3 = corners
                .iter()
                .map(|&corner| mesh.normals[corner as usize].as_dvec3())
                .sum();
            if normal.dot(shading) < 0.0 {
                corners.swap(1, 2);
            }
        }
    }
    mesh
}

/// Corner and edges, where two triangles make a parallelogram: the corner is the mesh's first.
fn parallelogram(mesh: &Mesh) -> Option<[Vec3; 3]> {
    let [first, second] = mesh.triangles.as_slice() else {
        return None;
    };
    if !mesh.normals.is_empty() {
        return None;
    }
    // Around the four corners: a, b, c of the first triangle, with the second's own corner where they meet.
    let own = first.iter().position(|corner| !second.contains(corner))?;
    let [from, to] = [first[(own + 1) % 3], first[(own + 2) % 3]];
    let back = (0..3).find(|&k| second[k] == to && second[(k + 1) % 3] == from)?;
    let opposite = second[(back + 2) % 3];
    let mut around = [first[own], from, opposite, to];
    let start = around.iter().position(|&corner| corner == first[0])?;
    around.rotate_left(start);
    let [a, b, c, d] = around.map(|corner| mesh.positions[corner as usize].as_dvec3());
    let (u, v) = (b - a, d - a);
    let gap = (a + u + v - c).length();
    (gap <= 1e-6 * (u.length() + v.length())).then(|| [a, u, v].map(|p| p.as_vec3()))
}
