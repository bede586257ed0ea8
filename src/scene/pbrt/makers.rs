//! The directives that make something: shapes, materials, lights, textures, objects, the camera.

use super::assemble::{self, Placed};
use super::lexer::Token;
use super::lights::{self, Made};
use super::materials::Definition;
use super::names::quoted;
use super::options::{self, View};
use super::parameters::{Parameters, Textured};
use super::reader::{NO_MEDIA, Reader};
use super::spectra::Spectrum;
use super::state::Block;
use crate::error::Result;
use crate::scene::description::MOST_OBJECTS;

impl Reader {
    /// The directives of the form `Directive "kind" parameters`.
    pub fn maker(&mut self, token: &Token) -> Result<()> {
        let at = token.at();
        let kind = self.name(token)?;
        match token.raw() {
            "Texture" => return self.texture(token, kind),
            "NamedMaterial" => {
                self.states.now.material = self.library.named(&kind, &at);
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
                self.states.now.material = self.library.add(kind, parameters);
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
                let of_kind = of_kind.to_owned();
                self.library.define(Definition {
                    name: kind,
                    kind: of_kind,
                    parameters,
                });
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

    pub fn object_begin(&mut self, token: &Token) -> Result<()> {
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

    pub fn object_instance(&mut self, token: &Token) -> Result<()> {
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
        let alpha = match alpha {
            Some(Textured::Constant(Spectrum::Constant(alpha))) if alpha >= 1.0 => None,
            Some(Textured::Constant(Spectrum::Constant(alpha))) if alpha <= 0.0 => {
                if light.is_some() {
                    self.warnings.tell(
                        &at,
                        "a light that is not there (alpha 0) is not supported; it can be seen",
                    );
                    None
                } else {
                    return Ok(());
                }
            }
            alpha => alpha.map(|alpha| (alpha, at.clone())),
        };
        let surface = self.library.surface(self.states.now.material, alpha);
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
        if self.placed.len() > MOST_OBJECTS {
            return Err(assemble::too_many(&parameters.at));
        }
        Ok(())
    }
}
