//! The graphics state: the current transformation, material and light, and the stack that attributes save them on.

use super::lexer::{At, Token};
use super::parameters::Parameter;
use crate::error::Result;
use glam::{DAffine3, DMat3, DMat4, DVec3};
use std::sync::Arc;

/// Deepest nesting of attributes.
const DEEPEST: usize = 10_000;

/// What `Attribute` set, by the directive it is for.
type Defaults = Vec<(String, Vec<Parameter>)>;

/// What directives apply to.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// The current transformation: from here to the world, or, before `WorldBegin`, from the world to the camera.
    pub ctm: DAffine3,
    /// Whether normals are turned round.
    pub reverse: bool,
    /// Index into the definitions of materials.
    pub material: usize,
    /// Index into the area lights: shapes emit.
    pub area_light: Option<usize>,
    defaults: Arc<Defaults>,
}

impl State {
    /// At the start of a file: nothing transformed, the default material.
    pub fn new(material: usize) -> Self {
        Self {
            ctm: DAffine3::IDENTITY,
            reverse: false,
            material,
            area_light: None,
            defaults: Arc::default(),
        }
    }

    /// What `Attribute` said of a target.
    pub fn defaults(&self, target: &str) -> &[Parameter] {
        let found = self.defaults.iter().find(|(known, _)| known == target);
        found.map_or(&[], |(_, list)| list)
    }

    /// Adds defaults of a target; what was said before yields to them.
    pub fn set_defaults(&mut self, target: &str, mut list: Vec<Parameter>) {
        let defaults = Arc::make_mut(&mut self.defaults);
        match defaults.iter_mut().find(|(known, _)| known == target) {
            Some((_, old)) => {
                old.retain(|old| !list.iter().any(|new| new.name == old.name));
                old.append(&mut list);
            }
            None => defaults.push((target.to_owned(), list)),
        }
    }
}

/// What stands on the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Block {
    /// `AttributeBegin`.
    Attribute,
    /// `TransformBegin`.
    Transform,
    /// `ObjectBegin`.
    Object,
    /// `Import`.
    Import,
}

impl Block {
    fn begin(self) -> &'static str {
        match self {
            Self::Attribute => "AttributeBegin",
            Self::Transform => "TransformBegin",
            Self::Object => "ObjectBegin",
            Self::Import => "Import",
        }
    }

    fn end(self) -> &'static str {
        match self {
            Self::Attribute => "AttributeEnd",
            Self::Transform => "TransformEnd",
            Self::Object => "ObjectEnd",
            Self::Import => "the end of the imported file",
        }
    }
}

/// The state and those to come back to.
#[derive(Debug)]
pub(super) struct States {
    /// The one that holds.
    pub now: State,
    stack: Vec<(Block, State, At)>,
}

impl States {
    /// Nothing saved.
    pub fn new(material: usize) -> Self {
        Self {
            now: State::new(material),
            stack: Vec::new(),
        }
    }

    /// Saves the state.
    pub fn begin(&mut self, block: Block, at: At) -> Result<()> {
        if self.stack.len() >= DEEPEST {
            return Err(at.error(format!(
                "{} is nested more than {DEEPEST} deep; end some before",
                block.begin()
            )));
        }
        self.stack.push((block, self.now.clone(), at));
        Ok(())
    }

    /// Comes back to what `begin` saved.
    pub fn end(&mut self, block: Block, at: &At) -> Result<()> {
        match self.stack.pop() {
            Some((begun, saved, _)) if begun == block => {
                if block == Block::Transform {
                    self.now.ctm = saved.ctm;
                } else {
                    self.now = saved;
                }
                Ok(())
            }
            Some((begun, _, begin)) => Err(at.error(format!(
                "{} meets the {} of {}; add {} before",
                block.end(),
                begun.begin(),
                begin.place(),
                begun.end()
            ))),
            None => Err(at.error(format!(
                "{} has no {} before it; add that, or remove this",
                block.end(),
                block.begin()
            ))),
        }
    }

    /// Whether everything that began has ended.
    pub fn finish(&self) -> Result<()> {
        match self.stack.last() {
            None => Ok(()),
            Some((begun, _, at)) => Err(at.error(format!(
                "this {} has no {}; add it",
                begun.begin(),
                begun.end()
            ))),
        }
    }

    /// Multiplies the current transformation from the right, as all directives do.
    pub fn concat(&mut self, by: DAffine3, token: &Token) -> Result<()> {
        self.set(self.now.ctm * by, token)
    }

    /// Replaces the current transformation.
    pub fn set(&mut self, ctm: DAffine3, token: &Token) -> Result<()> {
        if !ctm.is_finite() {
            return Err(token
                .error("the transformation grows beyond 64-bit numbers here; use smaller ones"));
        }
        self.now.ctm = ctm;
        Ok(())
    }
}

/// pbrt's `LookAt`: from the world to a camera at `eye` that looks along +z, with +y up and +x right.
pub(super) fn look_at(
    [ex, ey, ez, lx, ly, lz, ux, uy, uz]: [f64; 9],
    token: &Token,
) -> Result<DAffine3> {
    let eye = DVec3::new(ex, ey, ez);
    let Some(forward) = (DVec3::new(lx, ly, lz) - eye).try_normalize() else {
        return Err(token.error("the camera stands where it looks at; move either point"));
    };
    let up = DVec3::new(ux, uy, uz).normalize_or_zero();
    let Some(right) = up.cross(forward).try_normalize().filter(|_| {
        // Parallel but for rounding.
        up.cross(forward).length() > 1e-9
    }) else {
        return Err(token.error(
            "the up vector is parallel to the view direction, or has no length; choose another",
        ));
    };
    let to_world = DMat3::from_cols(right, forward.cross(right), forward);
    Ok(DAffine3::from_mat3_translation(to_world, eye).inverse())
}

/// A turn around an axis (Rodrigues).
pub(super) fn rotation([degrees, x, y, z]: [f64; 4], token: &Token) -> Result<DAffine3> {
    let Some(axis) = DVec3::new(x, y, z).try_normalize() else {
        let message = "the axis of Rotate has no length; write Rotate degrees x y z";
        return Err(token.error(message));
    };
    // Not glam's: its sine is the platform's, and the same file is to give the same bits everywhere.
    let (sin, cos) = libm::sincos(degrees.to_radians());
    let turned = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
    let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(turned);
    Ok(DAffine3::from_cols(
        columns[0],
        columns[1],
        columns[2],
        DVec3::ZERO,
    ))
}

/// The 16 numbers of `Transform`, column by column, as an affine map.
pub(super) fn matrix(numbers: [f64; 16], token: &Token) -> Result<DAffine3> {
    let matrix = DMat4::from_cols_array(&numbers);
    let last = matrix.row(3);
    let scale = last.w;
    if last.truncate() != DVec3::ZERO || scale == 0.0 {
        return Err(token.error(
            "this matrix is a projection; its numbers 4, 8 and 12 must be 0 and its last one 1",
        ));
    }
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis];
    let [x, y, z, w] = columns.map(|column| column.truncate() / scale);
    Ok(DAffine3::from_cols(x, y, z, w))
}
