//! The directives, one after the other.

use super::assemble::{Placed, World};
use super::files::{Files, Next};
use super::lexer::{At, Kind, Token};
use super::library::{self, Library};
use super::lights::{AreaLight, Infinite};
use super::names::{did_you_mean, list, quoted};
use super::options::{self, View};
use super::parameters::Parameters;
use super::shapes::Geometries;
use super::state::{Block, States, look_at, matrix, rotation};
use super::textures::Textures;
use super::warnings::Warnings;
use crate::error::Result;
use crate::scene::description::{Description, Filter, Punctual, RenderDefaults};
use glam::DAffine3;
use std::collections::HashMap;
use std::path::Path;

/// Every directive that is known.
const DIRECTIVES: [&str; 39] = [
    "Accelerator",
    "ActiveTransform",
    "AreaLightSource",
    "Attribute",
    "AttributeBegin",
    "AttributeEnd",
    "Camera",
    "ColorSpace",
    "ConcatTransform",
    "CoordSysTransform",
    "CoordinateSystem",
    "Film",
    "Identity",
    "Import",
    "Include",
    "Integrator",
    "LightSource",
    "LookAt",
    "MakeNamedMaterial",
    "MakeNamedMedium",
    "Material",
    "MediumInterface",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Option",
    "PixelFilter",
    "ReverseOrientation",
    "Rotate",
    "Sampler",
    "Scale",
    "Shape",
    "Texture",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "TransformTimes",
    "WorldBegin",
];

/// What `Attribute` may be for.
const TARGETS: [&str; 5] = ["shape", "light", "material", "medium", "texture"];

/// Everything that was read.
pub(super) struct Reader {
    pub files: Files,
    pub warnings: Warnings,
    pub view: Option<View>,
    pub film: options::Film,
    pub filter: Filter,
    pub render: RenderDefaults,
    pub library: Library,
    pub textures: Textures,
    pub geometries: Geometries,
    pub area_lights: Vec<AreaLight>,
    pub punctual: Vec<Punctual>,
    pub infinite: Vec<Infinite>,
    /// What stands in the world.
    pub placed: Vec<Placed>,
    /// The objects, by their names.
    pub objects: HashMap<String, Vec<Placed>>,
    /// Where objects stand, the mirrored world's.
    pub instances: Vec<(String, DAffine3, At)>,
    pub states: States,
    pub coordinate_systems: HashMap<String, DAffine3>,
    /// From the file's world to that of the description: the identity, or a reflection.
    pub world: DAffine3,
    /// The object that is being defined.
    pub object: Option<String>,
    /// Whether transformations are for the end of the shutter's time alone.
    at_end: bool,
}

/// Reads a scene.
pub(super) fn read(path: &Path) -> Result<Description> {
    let mut reader = Reader {
        files: Files::open(path)?,
        warnings: Warnings::default(),
        view: None,
        film: options::Film::default(),
        filter: Filter::Gaussian,
        render: RenderDefaults {
            // pbrt's own: five bounces.
            path_length: Some(6),
            ..RenderDefaults::default()
        },
        library: Library::new(),
        textures: Textures::default(),
        geometries: Geometries::default(),
        area_lights: Vec::new(),
        punctual: Vec::new(),
        infinite: Vec::new(),
        placed: Vec::new(),
        objects: HashMap::new(),
        instances: Vec::new(),
        states: States::new(library::DEFAULT),
        coordinate_systems: HashMap::new(),
        world: DAffine3::IDENTITY,
        object: None,
        at_end: false,
    };
    loop {
        match reader.files.next()? {
            Next::Token(token) => reader.directive(&token)?,
            Next::EndOfImport(at) => reader.states.end(Block::Import, &at)?,
            Next::End => break,
        }
    }
    reader.states.finish()?;
    let name = path.display().to_string();
    World::new(reader)?.describe(name)
}

impl Reader {
    fn directive(&mut self, token: &Token) -> Result<()> {
        let at = token.at();
        if token.kind != Kind::Word {
            return Err(at.error(format!(
                "{} stands where a directive should, such as Shape or Translate; remove it",
                quoted(token.raw())
            )));
        }
        match token.raw() {
            "Identity" => self.set(DAffine3::IDENTITY, token),
            "Translate" => {
                let by = self.files.numbers_after(token, "Translate x y z")?;
                self.concat(DAffine3::from_translation(by.into()), token)
            }
            "Scale" => {
                let by = self.files.numbers_after(token, "Scale x y z")?;
                self.concat(DAffine3::from_scale(by.into()), token)
            }
            "Rotate" => {
                let numbers = self.files.numbers_after(token, "Rotate degrees x y z")?;
                self.concat(rotation(numbers, token)?, token)
            }
            "LookAt" => {
                let numbers = self.files.numbers_after(
                    token,
                    "LookAt eye.x eye.y eye.z at.x at.y at.z up.x up.y up.z",
                )?;
                self.concat(look_at(numbers, token)?, token)
            }
            "Transform" => {
                let numbers = self
                    .files
                    .numbers_after(token, "Transform [m00 m10 ... m33]")?;
                self.set(matrix(numbers, token)?, token)
            }
            "ConcatTransform" => {
                let numbers = self
                    .files
                    .numbers_after(token, "ConcatTransform [m00 m10 ... m33]")?;
                self.concat(matrix(numbers, token)?, token)
            }
            "CoordinateSystem" => {
                let name = self.name(token)?;
                self.coordinate_systems.insert(name, self.states.now.ctm);
                Ok(())
            }
            "CoordSysTransform" => {
                let name = self.name(token)?;
                match self.coordinate_systems.get(&name) {
                    Some(&system) => self.set(system, token),
                    None => {
                        self.warnings.tell_once("coordinate system".to_owned(), &at, || {
                            format!("the coordinate system {} is not known; the transformation stays", quoted(&name))
                        });
                        Ok(())
                    }
                }
            }
            "ActiveTransform" => self.active_transform(token),
            "TransformTimes" => {
                let _: [f64; 2] = self
                    .files
                    .numbers_after(token, "TransformTimes start end")?;
                Ok(())
            }
            "ReverseOrientation" => {
                self.states.now.reverse ^= true;
                Ok(())
            }
            "AttributeBegin" => self.states.begin(Block::Attribute, at),
            "AttributeEnd" => self.states.end(Block::Attribute, &at),
            "TransformBegin" => self.states.begin(Block::Transform, at),
            "TransformEnd" => self.states.end(Block::Transform, &at),
            "ObjectBegin" => self.object_begin(token),
            "ObjectEnd" => {
                self.states.end(Block::Object, &at)?;
                self.object = None;
                Ok(())
            }
            "ObjectInstance" => self.object_instance(token),
            "WorldBegin" => {
                let identity = DAffine3::IDENTITY;
                self.coordinate_systems.insert("world".to_owned(), identity);
                self.set(identity, token)
            }
            "Attribute" => {
                let target = self.name(token)?;
                if !TARGETS.contains(&target.as_str()) {
                    let targets = list(TARGETS);
                    return Err(at.error(format!(
                        "Attribute is for one of {targets}, not for {}; write one of them",
                        quoted(&target)
                    )));
                }
                let list = self.parameters(token, &target)?.into_defaults()?;
                self.states.now.set_defaults(&target, list);
                Ok(())
            }
            "Include" | "Import" => {
                let name = self.name(token)?;
                let import = token.raw() == "Import";
                if import {
                    self.states.begin(Block::Import, at.clone())?;
                }
                self.files.include(&name, &at, import)
            }
            "ColorSpace" => {
                let name = self.name(token)?;
                if name != "srgb" {
                    self.warnings.tell(
                        &at,
                        format!(
                            "the colour space {} is not supported; colours are read as linear sRGB",
                            quoted(&name)
                        ),
                    );
                }
                Ok(())
            }
            "Option" => self.parameters(token, "").map(drop),
            "MediumInterface" => {
                self.name(token)?;
                let _ = self.files.next_if(|token| token.kind == Kind::Text)?;
                self.warnings
                    .tell_once("medium".to_owned(), &at, || NO_MEDIA.to_owned());
                Ok(())
            }
            name if DIRECTIVES.contains(&name) => self.maker(token),
            name => Err(at.error(format!(
                "unknown directive {}{} Directives are {}",
                quoted(name),
                match did_you_mean(name, DIRECTIVES) {
                    hint if hint.is_empty() => ".".to_owned(),
                    hint => hint,
                },
                list(DIRECTIVES)
            ))),
        }
    }

    /// The text after a directive.
    pub fn name(&mut self, directive: &Token) -> Result<String> {
        let example = format!("{} \"name\"", directive.raw());
        Ok(self.files.text_after(directive, &example)?.unescaped())
    }

    pub fn parameters(&mut self, token: &Token, kind: &str) -> Result<Parameters> {
        let owner = format!("{} {}", token.raw(), quoted(kind));
        Parameters::read(&mut self.files, token.at(), owner)
    }

    fn concat(&mut self, by: DAffine3, token: &Token) -> Result<()> {
        if self.at_end {
            return Ok(());
        }
        self.states.concat(by, token)
    }

    fn set(&mut self, ctm: DAffine3, token: &Token) -> Result<()> {
        if self.at_end {
            return Ok(());
        }
        self.states.set(ctm, token)
    }

    fn active_transform(&mut self, token: &Token) -> Result<()> {
        let which = self.files.next_if(|token| token.kind == Kind::Word)?;
        match which.as_ref().map(Token::raw) {
            Some("All" | "StartTime") => self.at_end = false,
            Some("EndTime") => {
                self.at_end = true;
                self.warnings.tell(
                    &token.at(),
                    "motion is not supported; everything stands as at the start",
                );
            }
            _ => {
                return Err(token.error("ActiveTransform needs All, StartTime or EndTime; add one"));
            }
        }
        Ok(())
    }
}

/// Told of media.
pub(super) const NO_MEDIA: &str =
    "participating media are not supported; everything stands in a vacuum";
