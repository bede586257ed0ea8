//! The directives, one after the other.

use super::assemble::{self, Placed, World};
use super::files::{Files, Next};
use super::lexer::{At, Kind, Token};
use super::lights::{self, AreaLight, Infinite, Made};
use super::materials::Definition;
use super::names::{did_you_mean, list, quoted};
use super::options::{self, View};
use super::parameters::{Parameters, Textured};
use super::shapes::Geometries;
use super::spectra::Spectrum;
use super::state::{Block, States, look_at, matrix};
use super::textures::Textures;
use super::warnings::Warnings;
use crate::error::Result;
use crate::scene::description::{Description, Filter, Punctual, RenderDefaults};
use glam::{DAffine3, DVec3};
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

/// A material by its number: what the file says, once it is known.
#[derive(Debug)]
pub(super) struct Slot {
    pub definition: Option<Definition>,
    /// The name and where it was first used, for materials that were not defined then.
    pub wanted: Option<(String, At)>,
}

/// What a shape's surface is: a material, and what cuts holes into it.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub material: usize,
    pub alpha: Option<(Textured, At)>,
}

/// Everything that was read.
pub(super) struct Reader {
    pub files: Files,
    pub warnings: Warnings,
    pub view: Option<View>,
    pub film: options::Film,
    pub filter: Filter,
    pub render: RenderDefaults,
    pub materials: Vec<Slot>,
    pub surfaces: Vec<Surface>,
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
    states: States,
    coordinate_systems: HashMap<String, DAffine3>,
    named_materials: HashMap<String, usize>,
    surface_numbers: HashMap<(usize, String), usize>,
    /// From the file's world to that of the description: the identity, or a reflection.
    world: DAffine3,
    /// The object that is being defined.
    object: Option<String>,
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
        // The first material is that of shapes before any `Material`.
        materials: vec![Slot {
            definition: None,
            wanted: None,
        }],
        surfaces: Vec::new(),
        textures: Textures::default(),
        geometries: Geometries::default(),
        area_lights: Vec::new(),
        punctual: Vec::new(),
        infinite: Vec::new(),
        placed: Vec::new(),
        objects: HashMap::new(),
        instances: Vec::new(),
        states: States::new(0),
        coordinate_systems: HashMap::new(),
        named_materials: HashMap::new(),
        surface_numbers: HashMap::new(),
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
                let [degrees, x, y, z] = self.files.numbers_after(token, "Rotate degrees x y z")?;
                let Some(axis) = DVec3::new(x, y, z).try_normalize() else {
                    return Err(
                        at.error("the axis of Rotate has no length; write Rotate degrees x y z")
                    );
                };
                self.concat(DAffine3::from_axis_angle(axis, degrees.to_radians()), token)
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
                let list = self.parameters(token, &target)?.into_list();
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

    /// The directives of the form `Directive "kind" parameters`.
    fn maker(&mut self, token: &Token) -> Result<()> {
        let at = token.at();
        let kind = self.name(token)?;
        match token.raw() {
            "Texture" => return self.texture(token, kind),
            "NamedMaterial" => {
                self.states.now.material = self.named_material(&kind, &at);
                return Ok(());
            }
            _ => {}
        }
        let mut parameters = self.parameters(token, &kind)?;
        match token.raw() {
            "Shape" => {
                parameters.inherit(self.states.now.defaults("shape"));
                self.shape(&parameters, &kind)?;
            }
            "Material" => {
                parameters.inherit(self.states.now.defaults("material"));
                let name = format!("{kind} {}", self.materials.len());
                self.states.now.material = self.materials.len();
                self.materials.push(Slot {
                    definition: Some(Definition {
                        name,
                        kind,
                        parameters,
                    }),
                    wanted: None,
                });
                // Told of when it is made.
                return Ok(());
            }
            "MakeNamedMaterial" => {
                parameters.inherit(self.states.now.defaults("material"));
                let Some(of_kind) = parameters.text("type")? else {
                    return Err(at.error(format!(
                        "the material {} has no type; add \"string type\" \"diffuse\"",
                        quoted(&kind)
                    )));
                };
                let definition = Definition {
                    name: kind.clone(),
                    kind: of_kind.to_owned(),
                    parameters,
                };
                let index = self.named_material(&kind, &at);
                if let Some(slot) = self.materials.get_mut(index) {
                    slot.definition = Some(definition);
                }
                return Ok(());
            }
            "AreaLightSource" => {
                parameters.inherit(self.states.now.defaults("light"));
                let light = lights::area(&parameters, &kind, &self.files, &mut self.warnings)?;
                self.states.now.area_light = Some(self.area_lights.len());
                self.area_lights.push(light);
            }
            "LightSource" => {
                parameters.inherit(self.states.now.defaults("light"));
                let to_world = self.world * self.states.now.ctm;
                match lights::light(
                    &parameters,
                    &kind,
                    to_world,
                    &self.files,
                    &mut self.warnings,
                )? {
                    Made::Nothing => return Ok(()),
                    _ if self.object.is_some() => {
                        self.warnings.tell(
                            &at,
                            "lights in objects are not supported; they are left out",
                        );
                    }
                    Made::Punctual(light) => self.punctual.push(light),
                    Made::Infinite(light) => self.infinite.push(light),
                }
            }
            "Camera" => return self.camera(parameters, &kind),
            "Film" => {
                self.film = options::film(&parameters, &mut self.warnings)?;
                return Ok(());
            }
            "Sampler" => {
                self.render.spp = options::samples(&parameters)?;
                return Ok(());
            }
            "Integrator" => {
                let length = options::path_length(&parameters, &kind, &mut self.warnings)?;
                self.render.path_length = Some(length);
                return Ok(());
            }
            "PixelFilter" => {
                self.filter = options::filter(&parameters, &kind, &mut self.warnings)?;
                return Ok(());
            }
            "MakeNamedMedium" => {
                self.warnings
                    .tell_once("medium".to_owned(), &at, || NO_MEDIA.to_owned());
                return Ok(());
            }
            // How fast, not what: the accelerator.
            _ => return Ok(()),
        }
        self.warnings.tell_unused(&parameters, &parameters.owner);
        Ok(())
    }

    /// The text after a directive.
    fn name(&mut self, directive: &Token) -> Result<String> {
        let example = format!("{} \"name\"", directive.raw());
        Ok(self.files.text_after(directive, &example)?.unescaped())
    }

    fn parameters(&mut self, token: &Token, kind: &str) -> Result<Parameters> {
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

    fn camera(&mut self, parameters: Parameters, kind: &str) -> Result<()> {
        let at = parameters.at.clone();
        if !(self.placed.is_empty()
            && self.objects.is_empty()
            && self.punctual.is_empty()
            && self.infinite.is_empty())
        {
            return Err(
                at.error("the camera must come before the world; move it before WorldBegin")
            );
        }
        let world_to_camera = self.states.now.ctm;
        let view = View::new(parameters, kind, world_to_camera)?;
        self.world = view.world();
        self.view = Some(view);
        self.coordinate_systems
            .insert("camera".to_owned(), world_to_camera.inverse());
        Ok(())
    }

    fn texture(&mut self, token: &Token, name: String) -> Result<()> {
        const EXAMPLE: &str = "Texture \"name\" \"spectrum\" \"imagemap\"";
        let class = self.files.text_after(token, EXAMPLE)?.unescaped();
        let kind = self.files.text_after(token, EXAMPLE)?.unescaped();
        let mut parameters = self.parameters(token, &kind)?;
        parameters.inherit(self.states.now.defaults("texture"));
        if !matches!(class.as_str(), "float" | "spectrum") {
            return Err(token.error(format!(
                "a texture is of the class \"spectrum\" or \"float\", not {}; write {EXAMPLE}",
                quoted(&class)
            )));
        }
        let named = (name, class.as_str(), kind.as_str());
        self.textures
            .define(named, &parameters, &self.files, &mut self.warnings)?;
        self.warnings.tell_unused(&parameters, &parameters.owner);
        Ok(())
    }

    /// The number of a named material, which may be defined later.
    fn named_material(&mut self, name: &str, at: &At) -> usize {
        if let Some(&index) = self.named_materials.get(name) {
            return index;
        }
        let index = self.materials.len();
        self.materials.push(Slot {
            definition: None,
            wanted: Some((name.to_owned(), at.clone())),
        });
        self.named_materials.insert(name.to_owned(), index);
        index
    }

    fn object_begin(&mut self, token: &Token) -> Result<()> {
        let at = token.at();
        let name = self.name(token)?;
        if self.object.is_some() {
            return Err(at.error("objects are not defined within objects; add ObjectEnd before"));
        }
        if self.objects.insert(name.clone(), Vec::new()).is_some() {
            return Err(at.error(format!(
                "the object {} is defined twice; rename one",
                quoted(&name)
            )));
        }
        self.states.begin(Block::Object, at)?;
        self.object = Some(name);
        Ok(())
    }

    fn object_instance(&mut self, token: &Token) -> Result<()> {
        let at = token.at();
        let name = self.name(token)?;
        if self.object.is_some() {
            return Err(
                at.error("an object has no instances of others in it; place them in the world")
            );
        }
        let to_world = self.world * self.states.now.ctm;
        self.instances.push((name, to_world, at));
        Ok(())
    }

    fn shape(&mut self, parameters: &Parameters, kind: &str) -> Result<()> {
        let at = parameters.at.clone();
        let alpha = parameters.textured("alpha")?;
        let geometries = &mut self.geometries;
        let found = geometries.shape(parameters, kind, &mut self.files, &mut self.warnings)?;
        let Some((geometry, local)) = found else {
            return Ok(());
        };
        let mut light = self.states.now.area_light;
        if light.is_some() && self.object.is_some() {
            self.warnings.tell(
                &at,
                "area lights in objects are not supported; the shape does not emit",
            );
            light = None;
        }
        let surface = match alpha {
            Some(Textured::Constant(Spectrum::Constant(alpha))) if alpha >= 1.0 => {
                self.surface(None)
            }
            Some(Textured::Constant(Spectrum::Constant(alpha))) if alpha <= 0.0 => {
                if light.is_some() {
                    self.warnings.tell(
                        &at,
                        "a light that is not there (alpha 0) is not supported; it can be seen",
                    );
                    self.surface(None)
                } else {
                    return Ok(());
                }
            }
            alpha => self.surface(alpha.map(|alpha| (alpha, at.clone()))),
        };
        let within = match self.object {
            // An instance brings the world's reflection.
            Some(_) => self.states.now.ctm,
            None => self.world * self.states.now.ctm,
        };
        let placed = Placed {
            geometry,
            to_world: within * local,
            reverse: self.states.now.reverse,
            surface,
            light,
            at,
        };
        match self
            .object
            .as_ref()
            .and_then(|name| self.objects.get_mut(name))
        {
            Some(object) => object.push(placed),
            None => self.placed.push(placed),
        }
        if self.placed.len() > assemble::MOST {
            return Err(assemble::too_many(&parameters.at));
        }
        Ok(())
    }

    /// The number of a surface of the material that holds.
    fn surface(&mut self, alpha: Option<(Textured, At)>) -> usize {
        let material = self.states.now.material;
        let key = match &alpha {
            None => String::new(),
            Some((Textured::Texture(name, _), _)) => format!("texture {name}"),
            Some((Textured::Constant(spectrum), _)) => format!("{spectrum:?}"),
        };
        let surfaces = &mut self.surfaces;
        *self
            .surface_numbers
            .entry((material, key))
            .or_insert_with(|| {
                surfaces.push(Surface { material, alpha });
                surfaces.len() - 1
            })
    }

    /// The material that a mix of two is replaced by: the one with more weight, told.
    pub fn unmixed(&mut self, mut material: usize) -> Result<usize> {
        // A mix of mixes ends, or goes round.
        for _ in 0..=self.materials.len() {
            let slot = self.materials.get(material);
            let definition = slot.and_then(|slot| slot.definition.as_ref());
            let Some(Definition { parameters, .. }) = definition.filter(|it| it.kind == "mix")
            else {
                return Ok(material);
            };
            let at = &parameters.at;
            let pick = match parameters.textured("amount")? {
                Some(Textured::Constant(Spectrum::Constant(amount))) if amount > 0.5 => 1,
                _ => 0,
            };
            let Some([first, second]) = parameters.texts("materials")? else {
                return Err(at.error("a mix needs \"string materials\" of two names; add them"));
            };
            let name = [first, second][pick];
            let Some(&index) = self.named_materials.get(name) else {
                return Err(at.error(format!(
                    "material {} is not defined{}",
                    quoted(name),
                    match did_you_mean(name, self.named_materials.keys().map(String::as_str)) {
                        hint if hint.is_empty() => "; add MakeNamedMaterial".to_owned(),
                        hint => hint,
                    }
                )));
            };
            self.warnings.tell_once("mix".to_owned(), at, || {
                "a mix of materials is not supported; the one with more weight stands alone"
                    .to_owned()
            });
            material = index;
        }
        let slot = self.materials.get(material);
        let wanted = slot.and_then(|slot| slot.definition.as_ref());
        wanted.map_or(Ok(material), |definition| {
            Err(definition
                .parameters
                .at
                .error("this mix is a mix of itself; name other materials"))
        })
    }

    /// What is wrong with the materials that were named and not defined.
    pub fn undefined_material(&self) -> Option<crate::error::Error> {
        let missing = |slot: &&Slot| slot.definition.is_none();
        let slot = self
            .materials
            .iter()
            .find(|slot| missing(slot) && slot.wanted.is_some())?;
        let (name, at) = slot.wanted.as_ref()?;
        let defined = self.materials.iter().filter(|slot| !missing(slot));
        let known = defined.filter_map(|slot| Some(slot.wanted.as_ref()?.0.as_str()));
        Some(at.error(format!(
            "material {} is not defined{}",
            quoted(name),
            match did_you_mean(name, known) {
                hint if hint.is_empty() => "; add MakeNamedMaterial".to_owned(),
                hint => hint,
            }
        )))
    }
}

const NO_MEDIA: &str = "participating media are not supported; everything stands in a vacuum";
