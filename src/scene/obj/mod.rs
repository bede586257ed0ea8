//! OBJ meshes with MTL materials (Wavefront, "Object Files (.obj)", version 3.0).
//!
//! The lines of geometry are read here, those of materials by `tobj`: that names no line of what is wrong, renders poly-lines
//! as faces, overflows at indices beyond 2⁶², and takes 207 MB for a million triangles where this takes 64.

mod mtl;

use super::description::{Description, Light, NamedMaterial, Object, Shape};
use super::framing;
use super::hash;
use super::lines::Lines;
use super::mesh::{Mesh, MeshError, without_area};
use super::toml::names::quoted;
use crate::error::{Error, Result};
use crate::lanes::Rgb;
use glam::{Affine3A, Vec2, Vec3};
use mtl::Library;
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::sync::Arc;

/// Reads a file and the materials it names: a mesh for each material. There is no camera.
///
/// # Errors
/// [`Error::Read`], [`Error::Scene`] with the line of what cannot be rendered, and [`Error::Format`].
pub fn load(path: &Path) -> Result<Description> {
    let file = File::open(path).map_err(|source| Error::Read {
        path: path.to_owned(),
        source,
    })?;
    read(BufReader::with_capacity(1 << 20, file), path)
}

/// Reads a file from anything. Errors call it by its `path`, and its materials are looked for beside that.
///
/// # Errors
/// As [`load`].
pub fn read(source: impl BufRead, path: &Path) -> Result<Description> {
    let mut file = Reader {
        path,
        library: Library::default(),
        positions: Vec::new(),
        uvs: Vec::new(),
        normals: Vec::new(),
        parts: Vec::new(),
        by_name: HashMap::new(),
        part: None,
        hasher: Sha256::new(),
    };
    file.lines(Lines::after(0, source))?;
    file.description()
}

/// The triangles of a material.
#[derive(Default)]
struct Part {
    /// The name in `usemtl`, and the line; none before the first.
    material: Option<(String, usize)>,
    mesh: Mesh,
    /// Vertices by their indices of position, texture coordinates and normal.
    vertices: HashMap<[u32; 3], u32>,
    has_uvs: bool,
    has_normals: bool,
}

/// The index of an attribute that a corner does not have.
const NONE: u32 = u32::MAX;

/// A file while it is read.
struct Reader<'a> {
    path: &'a Path,
    library: Library,
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    parts: Vec<Part>,
    by_name: HashMap<String, usize>,
    /// The part that faces are added to.
    part: Option<usize>,
    hasher: Sha256,
}

impl Reader<'_> {
    fn lines(&mut self, mut lines: Lines<impl BufRead>) -> Result<()> {
        let path = self.path;
        let mut corners = Vec::new();
        // A line that ends in a backslash goes on in the next.
        let mut joined = String::new();
        loop {
            let at = |number, message| Error::format(path, format!("line {number}: {message}"));
            let number = lines.number + 1;
            let Some(line) = lines.next().map_err(|message| at(number, message))? else {
                let read = self.line(&joined, lines.number, &mut corners);
                return read.map_err(|message| at(lines.number, message));
            };
            self.hasher.update(line.as_bytes());
            // A comment goes no further than its line.
            let text = line.split_once('#').map_or(&*line, |(before, _)| before);
            let text = text.trim_end();
            if let Some(begin) = text.strip_suffix('\\') {
                joined.push_str(begin);
                joined.push(' ');
                if joined.len() as u64 > super::lines::LONGEST {
                    return Err(at(number, "the line goes on beyond 1 MiB".to_owned()));
                }
                continue;
            }
            let whole = if joined.is_empty() {
                text
            } else {
                joined.push_str(text);
                &joined
            };
            let read = self.line(whole, number, &mut corners);
            read.map_err(|message| at(number, message))?;
            joined.clear();
        }
    }

    fn line(
        &mut self,
        line: &str,
        number: usize,
        corners: &mut Vec<[u32; 3]>,
    ) -> std::result::Result<(), String> {
        let line = line.trim();
        let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        match key {
            "v" => self.positions.push(Vec3::from(floats(key, rest)?)),
            "vn" => self.normals.push(Vec3::from(floats(key, rest)?)),
            "vt" => {
                let mut words = rest.split_whitespace();
                let u = float(key, words.next())?;
                let v = words
                    .next()
                    .map_or(Ok(0.0), |word| float(key, Some(word)))?;
                self.uvs.push(Vec2::new(u, v));
            }
            "f" => {
                corners.clear();
                for word in rest.split_whitespace() {
                    corners.push(self.corner(word)?);
                }
                if corners.len() < 3 {
                    return Err(format!(
                        "a face has at least 3 corners, and this has {}; remove it",
                        corners.len()
                    ));
                }
                self.face(corners);
            }
            "usemtl" => self.select(rest.trim(), number),
            "mtllib" => self
                .library
                .read(self.path, rest.trim(), number, &mut self.hasher)?,
            _ => {}
        }
        Ok(())
    }

    /// A corner `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&self, word: &str) -> std::result::Result<[u32; 3], String> {
        let mut corner = [NONE; 3];
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let what = ["vertices", "texture coordinates", "normals"];
        for (place, index) in word.split('/').enumerate() {
            if place > 0 && index.is_empty() {
                continue;
            }
            let (Some(slot), Ok(index)) = (corner.get_mut(place), index.parse::<i64>()) else {
                return Err(format!(
                    "{} is no corner; write v, v/vt, v//vn or v/vt/vn, whole numbers from 1",
                    quoted(word)
                ));
            };
            let count = counts[place];
            // Negative ones count from the last.
            let from_zero = match index {
                1.. => index - 1,
                _ => index.saturating_add(count as i64),
            };
            *slot = match u32::try_from(from_zero) {
                Ok(found) if index != 0 && (found as usize) < count => found,
                _ => {
                    return Err(format!(
                        "there is no number {index} of the {count} {} before this line (counted from 1); export the file again",
                        what[place]
                    ));
                }
            };
        }
        Ok(corner)
    }

    /// A convex polygon becomes a fan.
    fn face(&mut self, corners: &[[u32; 3]]) {
        let part = match self.part {
            Some(part) => part,
            None => {
                self.parts.push(Part::default());
                self.parts.len() - 1
            }
        };
        self.part = Some(part);
        let mut vertices = Vec::with_capacity(corners.len());
        vertices.extend(corners.iter().map(|corner| self.vertex(part, *corner)));
        if let [first, rest @ ..] = &vertices[..] {
            let edges = rest.iter().zip(rest.iter().skip(1));
            let fan = edges.map(|(&second, &third)| [*first, second, third]);
            self.parts[part].mesh.triangles.extend(fan);
        }
    }

    /// The vertex of a part that has these indices.
    fn vertex(&mut self, part: usize, corner: [u32; 3]) -> u32 {
        let part = &mut self.parts[part];
        *part.vertices.entry(corner).or_insert_with(|| {
            let [position, uv, normal] = corner;
            let mesh = &mut part.mesh;
            let uv = self.uvs.get(uv as usize);
            let normal = self.normals.get(normal as usize);
            part.has_uvs |= uv.is_some();
            part.has_normals |= normal.is_some();
            mesh.positions.push(self.positions[position as usize]);
            mesh.uvs.push(uv.copied().unwrap_or_default());
            // Without a normal it gets that of a face.
            mesh.normals.push(normal.copied().unwrap_or_default());
            mesh.positions.len() as u32 - 1
        })
    }

    fn select(&mut self, name: &str, line: usize) {
        let parts = &mut self.parts;
        let part = *self.by_name.entry(name.to_owned()).or_insert_with(|| {
            parts.push(Part {
                material: Some((name.to_owned(), line)),
                ..Part::default()
            });
            parts.len() - 1
        });
        self.part = Some(part);
    }

    fn description(self) -> Result<Description> {
        let path = self.path;
        let name = path.display().to_string();
        let mut scene = Description {
            hash: hash::finish(self.hasher),
            textures: self.library.textures,
            warnings: self.library.warnings,
            ..framing::nothing(&name)
        };
        let mut dropped = 0;
        for mut part in self.parts {
            if part.mesh.triangles.is_empty() {
                continue;
            }
            part.mesh.name = match &part.material {
                Some((material, _)) => format!("{name} ({material})"),
                None => name.clone(),
            };
            if !part.has_uvs {
                part.mesh.uvs = Vec::new();
            }
            if !part.has_normals {
                part.mesh.normals = Vec::new();
            }
            let triangles = part.mesh.triangles.len();
            let mesh = match part.mesh.checked() {
                Ok((mesh, without_area)) => {
                    dropped += without_area;
                    mesh
                }
                Err(MeshError::Empty) => {
                    dropped += triangles;
                    continue;
                }
                Err(error) => return Err(Error::format(path, error.to_string())),
            };
            let (material, emission) = match &part.material {
                Some((wanted, line)) => match self.library.materials.get(wanted) {
                    Some(found) => (found.named.clone(), found.emission),
                    None => {
                        scene.warnings.push(format!(
                            "{name}:{line}: material {} is in no MTL file; it is white",
                            quoted(wanted)
                        ));
                        (NamedMaterial::white(), Rgb::BLACK)
                    }
                },
                None => (NamedMaterial::white(), Rgb::BLACK),
            };
            let shape = Shape::Mesh {
                mesh: scene.meshes.len(),
                transform: Affine3A::IDENTITY,
            };
            let index = scene.materials.len();
            scene.meshes.push(Arc::new(mesh));
            scene.materials.push(material);
            if emission == Rgb::BLACK {
                scene.objects.push(Object {
                    shape,
                    material: index,
                });
            } else {
                scene.lights.push(Light {
                    shape,
                    radiance: emission,
                    two_sided: false,
                    material: Some(index),
                    texture: None,
                });
            }
        }
        if scene.meshes.is_empty() {
            return Err(Error::format(
                path,
                "it has no faces with an area; a mesh needs lines such as f 1 2 3",
            ));
        }
        scene.warnings.extend(without_area(&name, dropped));
        Ok(scene)
    }
}

/// Three finite numbers.
fn floats(key: &str, rest: &str) -> std::result::Result<[f32; 3], String> {
    let mut words = rest.split_whitespace();
    let mut next = || float(key, words.next());
    Ok([next()?, next()?, next()?])
}

fn float(key: &str, word: Option<&str>) -> std::result::Result<f32, String> {
    let number = word.and_then(|word| word.parse().ok());
    number
        .filter(|number: &f32| number.is_finite())
        .ok_or_else(|| {
            let count = if key == "vt" { "two" } else { "three" };
            let found = word.map_or("the line ends".to_owned(), quoted);
            format!("{key} must be {count} finite numbers, and this is not: {found}")
        })
}
