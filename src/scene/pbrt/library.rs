//! The materials of a file, by number: they may be named before they are defined.

use super::lexer::At;
use super::materials::Definition;
use super::names::undefined;
use super::parameters::{Parameters, Textured};
use super::spectra::Spectrum;
use super::warnings::Warnings;
use crate::error::Result;
use std::collections::HashMap;

/// What a shape's surface is: a material, and what cuts holes into it.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub material: usize,
    pub alpha: Option<(Textured, At)>,
}

/// The number of the material of shapes before any `Material`.
pub(super) const DEFAULT: usize = 0;

/// Materials, and the surfaces that use them.
#[derive(Debug)]
pub(super) struct Library {
    definitions: Vec<Option<Definition>>,
    /// Numbers, and where the name came first.
    named: HashMap<String, (usize, At)>,
    /// What shapes refer to.
    pub surfaces: Vec<Surface>,
    by_key: HashMap<(usize, String), usize>,
}

impl Library {
    /// With the default material alone.
    pub fn new() -> Self {
        Self {
            definitions: vec![None],
            named: HashMap::new(),
            surfaces: Vec::new(),
            by_key: HashMap::new(),
        }
    }

    /// The number of a new material without a name.
    pub fn add(&mut self, kind: String, parameters: Parameters) -> usize {
        let number = self.definitions.len();
        self.definitions.push(Some(Definition {
            name: format!("{kind} {number}"),
            kind,
            parameters,
        }));
        number
    }

    /// The number of a named material, defined or not.
    pub fn named(&mut self, name: &str, at: &At) -> usize {
        if let Some(&(number, _)) = self.named.get(name) {
            return number;
        }
        let number = self.definitions.len();
        self.definitions.push(None);
        self.named.insert(name.to_owned(), (number, at.clone()));
        number
    }

    /// Defines a named material.
    pub fn define(&mut self, definition: Definition) {
        let number = self.named(&definition.name, &definition.parameters.at);
        if let Some(slot) = self.definitions.get_mut(number) {
            *slot = Some(definition);
        }
    }

    /// The number of a surface.
    pub fn surface(&mut self, material: usize, alpha: Option<(Textured, At)>) -> usize {
        let key = match &alpha {
            None => String::new(),
            Some((Textured::Texture(name, _), _)) => format!("texture {name}"),
            Some((Textured::Constant(spectrum), _)) => format!("{spectrum:?}"),
        };
        let surfaces = &mut self.surfaces;
        *self.by_key.entry((material, key)).or_insert_with(|| {
            surfaces.push(Surface { material, alpha });
            surfaces.len() - 1
        })
    }

    fn get(&self, number: usize) -> Option<&Definition> {
        self.definitions.get(number)?.as_ref()
    }

    /// What a number stands for; of a mix the part with more weight, told; none for the default.
    pub fn find(&self, mut number: usize, warnings: &mut Warnings) -> Result<Option<&Definition>> {
        // A mix of mixes ends, or goes round.
        for _ in 0..=self.definitions.len() {
            let Some(definition) = self.get(number).filter(|it| it.kind == "mix") else {
                return Ok(self.get(number));
            };
            let parameters = &definition.parameters;
            let at = &parameters.at;
            let Some([first, second]) = parameters.texts("materials")? else {
                return Err(at.error("a mix needs \"string materials\" of two names; add them"));
            };
            let more_of_second = match parameters.textured("amount")? {
                Some(Textured::Constant(Spectrum::Constant(amount))) => amount > 0.5,
                _ => false,
            };
            warnings.tell_once("mix".to_owned(), at, || {
                "a mix of materials is not supported; the one with more weight stands alone"
                    .to_owned()
            });
            let name = if more_of_second { second } else { first };
            number = match self.named.get(name) {
                Some(&(number, _)) => number,
                None => return Err(self.undefined(name, at)),
            };
        }
        match self.get(number) {
            Some(mix) => {
                let message = "this mix is a mix of itself; name other materials";
                Err(mix.parameters.at.error(message))
            }
            None => Ok(None),
        }
    }

    fn undefined(&self, name: &str, at: &At) -> crate::error::Error {
        let defined = self
            .named
            .iter()
            .filter(|(_, (number, _))| self.get(*number).is_some());
        let known = defined.map(|(name, _)| name.as_str());
        at.error(undefined("material", name, known, "add MakeNamedMaterial"))
    }

    /// Whether everything that was named is defined.
    pub fn finish(&self) -> Result<()> {
        let missing = self
            .named
            .iter()
            .filter(|(_, (number, _))| self.get(*number).is_none());
        // The first of the file.
        match missing.min_by_key(|(_, (number, _))| *number) {
            Some((name, (_, at))) => Err(self.undefined(name, at)),
            None => Ok(()),
        }
    }
}
