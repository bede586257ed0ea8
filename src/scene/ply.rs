//! PLY meshes: ascii and binary of both endians (Turk 1994, "The PLY Polygon File Format").
//!
//! Elements are read one at a time, straight into the mesh: nothing is allocated by what a header announces.

use super::description::{Description, NamedMaterial, Object, Shape};
use super::lines::{LONGEST, Lines};
use super::mesh::{Mesh, without_area};
use super::{framing, hash};
use crate::error::{Error, Result};
use glam::{Affine3A, Vec2, Vec3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::sync::Arc;

/// A mesh as a file has it.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The mesh, checked.
    pub mesh: Mesh,
    /// Triangles without an area, which were left out.
    pub dropped: usize,
}

/// Reads a mesh. Polygons become fans of triangles: they are to be convex.
///
/// # Errors
/// [`Error::Read`], and [`Error::Format`] with the line or the element that cannot be rendered.
pub fn load(path: &Path) -> Result<Loaded> {
    let file = File::open(path).map_err(|source| Error::Read {
        path: path.to_owned(),
        source,
    })?;
    read(BufReader::with_capacity(1 << 20, file), path)
}

/// Reads a mesh as a scene: it is white, and there is no camera.
///
/// # Errors
/// As [`load`].
pub fn scene(path: &Path) -> Result<Description> {
    let Loaded { mesh, dropped } = load(path)?;
    let mut hasher = Sha256::new();
    hash::add_file(path, &mut hasher).map_err(|source| Error::Read {
        path: path.to_owned(),
        source,
    })?;
    let shape = Shape::Mesh {
        mesh: 0,
        transform: Affine3A::IDENTITY,
    };
    Ok(Description {
        hash: hash::finish(hasher),
        warnings: without_area(&mesh.name, dropped).into_iter().collect(),
        meshes: vec![Arc::new(mesh)],
        materials: vec![NamedMaterial::white()],
        objects: vec![Object { shape, material: 0 }],
        ..framing::nothing(&path.display().to_string())
    })
}

/// Reads a mesh from anything; errors call it by its `path`.
///
/// # Errors
/// As [`load`].
pub fn read(mut source: impl BufRead, path: &Path) -> Result<Loaded> {
    let mut head = Reader::new(source.by_ref().take(LONGEST));
    let header = Parser::<Vertex>::new()
        .read_header(&mut head)
        .map_err(|error| {
            let line = error.line().unwrap_or(1);
            let cause = in_a_line(&error);
            Error::format(
                path,
                format!("line {line}: this is not the header of a PLY file: {cause}"),
            )
        })?;
    // The reader already counts the line after the header.
    let line = head.line() - 1;
    let mut body = Body {
        lines: Lines::after(line, source),
        path,
        encoding: header.encoding,
    };
    let elements: Vec<&ElementDef> = header.elements.values().collect();
    let mesh = body.mesh(&elements)?;
    let (mesh, dropped) = mesh
        .checked()
        .map_err(|error| Error::format(path, error.to_string()))?;
    Ok(Loaded { mesh, dropped })
}

/// What follows the header.
struct Body<'a, R> {
    lines: Lines<R>,
    path: &'a Path,
    encoding: Encoding,
}

impl<R: BufRead> Body<'_, R> {
    fn mesh(&mut self, elements: &[&ElementDef]) -> Result<Mesh> {
        let find = |name| elements.iter().find(|element| element.name == name);
        let (Some(vertices), Some(faces)) = (find("vertex"), find("face")) else {
            return Err(Error::format(
                self.path,
                "it has no elements \"vertex\" and \"face\": points and triangle strips are not rendered; export faces",
            ));
        };
        let layout = Layout::of(vertices).map_err(|message| Error::format(self.path, message))?;
        corners_are_numbers(faces).map_err(|message| Error::format(self.path, message))?;
        let mut mesh = Mesh {
            name: self.path.display().to_string(),
            ..Mesh::default()
        };
        for element in elements {
            match element.name.as_str() {
                "vertex" => self.each(element, |vertex: Vertex| {
                    let [x, y, z, nx, ny, nz, u, v] = vertex.values;
                    mesh.positions.push(Vec3::new(x, y, z));
                    if layout.normals {
                        mesh.normals.push(Vec3::new(nx, ny, nz));
                    }
                    if layout.uvs {
                        mesh.uvs.push(Vec2::new(u, v));
                    }
                    Ok(())
                })?,
                "face" => self.each(element, |Face { corners }| {
                    let beyond = |corner: &&u32| **corner as usize >= vertices.count;
                    if let Some(corner) = corners.iter().find(beyond) {
                        return Err(no_vertex(*corner, vertices.count));
                    }
                    if let [first, rest @ ..] = &corners[..] {
                        let edges = rest.iter().zip(rest.iter().skip(1));
                        let fan = edges.map(|(&second, &third)| [*first, second, third]);
                        mesh.triangles.extend(fan);
                    }
                    Ok(())
                })?,
                _ => self.each(element, |_: Face| Ok(()))?,
            }
        }
        Ok(mesh)
    }

    /// Reads the elements of a kind, one after the other.
    fn each<E: PropertyAccess>(
        &mut self,
        element: &ElementDef,
        mut keep: impl FnMut(E) -> std::result::Result<(), String>,
    ) -> Result<()> {
        // They would take no bytes, and their number is anything.
        if element.properties.is_empty() {
            return Ok(());
        }
        let parser = Parser::<E>::new();
        for index in 0..element.count {
            let read = match self.encoding {
                Encoding::Ascii => self.lines.next().and_then(|text| {
                    let text = text.ok_or(TRUNCATED)?;
                    let read = parser.read_ascii_element(&text, element);
                    read.map_err(|error| in_a_line(&error))
                }),
                Encoding::BinaryLittleEndian => parser
                    .read_little_endian_element(self.lines.source(), element)
                    .map_err(|error| binary_cause(&error)),
                Encoding::BinaryBigEndian => parser
                    .read_big_endian_element(self.lines.source(), element)
                    .map_err(|error| binary_cause(&error)),
            };
            read.and_then(&mut keep).map_err(|cause| {
                let line = match self.encoding {
                    Encoding::Ascii => format!("line {}: ", self.lines.number),
                    _ => String::new(),
                };
                let (name, count) = (&element.name, element.count);
                Error::format(
                    self.path,
                    format!("{line}{name} {index} of {count} (counted from 0): {cause}"),
                )
            })?;
        }
        Ok(())
    }
}

fn no_vertex(corner: u32, vertices: usize) -> String {
    let corner = match corner {
        u32::MAX => "a corner below 0".to_owned(),
        corner => format!("corner {corner}"),
    };
    format!(
        "it has {corner}, and there are {vertices} vertices (counted from 0); export the file again"
    )
}

/// What to say of a file that ends before its elements do.
const TRUNCATED: &str = "the file ends here; it is truncated, copy or export it again";

fn binary_cause(error: &ParseError) -> String {
    match error.kind() {
        std::io::ErrorKind::UnexpectedEof => TRUNCATED.to_owned(),
        _ => in_a_line(error),
    }
}

/// The parser's words without its line breaks, and cut where they are too long to read.
fn in_a_line(error: &ParseError) -> String {
    const MOST: usize = 200;
    let words: Vec<String> = error
        .to_string()
        .split_whitespace()
        .map(|word| word.escape_debug().to_string())
        .collect();
    let text = words.join(" ");
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// What the vertices of a file have besides a position.
struct Layout {
    normals: bool,
    uvs: bool,
}

impl Layout {
    fn of(vertices: &ElementDef) -> std::result::Result<Self, String> {
        if vertices.count >= u32::MAX as usize {
            return Err(format!(
                "it announces {} vertices; at most 2^32 - 2 can be told apart: split the mesh",
                vertices.count
            ));
        }
        let mut has = [false; SLOTS];
        for property in vertices.properties.values() {
            if let (Some(slot), PropertyType::Scalar(_)) =
                (slot(&property.name), &property.data_type)
            {
                has[slot] = true;
            }
        }
        let [x, y, z, nx, ny, nz, u, v] = has;
        if !(x && y && z) {
            return Err("its vertices have no properties x, y and z; export positions".to_owned());
        }
        Ok(Self {
            normals: nx && ny && nz,
            uvs: u && v,
        })
    }
}

fn corners_are_numbers(faces: &ElementDef) -> std::result::Result<(), String> {
    let corners = faces
        .properties
        .values()
        .find(|property| is_corners(&property.name));
    match corners.map(|property| &property.data_type) {
        Some(PropertyType::List(_, ScalarType::Float | ScalarType::Double)) => {
            Err("the corners of its faces are not whole numbers; export them as int".to_owned())
        }
        Some(PropertyType::List(..)) => Ok(()),
        _ => Err("its faces have no list vertex_indices; export their corners".to_owned()),
    }
}

fn is_corners(name: &str) -> bool {
    matches!(name, "vertex_indices" | "vertex_index")
}

/// Numbers that are read of a vertex: position, normal, texture coordinates.
const SLOTS: usize = 8;

/// Where a property of a vertex is kept.
fn slot(name: &str) -> Option<usize> {
    Some(match name {
        "x" => 0,
        "y" => 1,
        "z" => 2,
        "nx" => 3,
        "ny" => 4,
        "nz" => 5,
        "u" | "s" | "texture_u" | "texture_s" => 6,
        "v" | "t" | "texture_v" | "texture_t" => 7,
        _ => return None,
    })
}

#[derive(Default)]
struct Vertex {
    values: [f32; SLOTS],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if let (Some(slot), Some(value)) = (slot(name), value.to_f32_lossy()) {
            self.values[slot] = value;
        }
        PropertyAccessResult::Set
    }
}

/// A face; of elements that are not rendered, nothing.
#[derive(Default)]
struct Face {
    /// [`u32::MAX`] for what is no index.
    corners: Vec<u32>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if is_corners(name) {
            self.corners = match value {
                Property::ListChar(list) => indices(list),
                Property::ListUChar(list) => indices(list),
                Property::ListShort(list) => indices(list),
                Property::ListUShort(list) => indices(list),
                Property::ListInt(list) => indices(list),
                Property::ListUInt(list) => list,
                _ => return PropertyAccessResult::UnsupportedType,
            };
        }
        PropertyAccessResult::Set
    }
}

/// In place where the type has 32 bits.
fn indices<T: TryInto<u32>>(list: Vec<T>) -> Vec<u32> {
    let index = |corner: T| corner.try_into().unwrap_or(u32::MAX);
    list.into_iter().map(index).collect()
}
