//! How vectors are written: JSON with a case a line, each float in decimals and as its bits.

use std::fmt::{Display, Write};

/// The version of the files' form.
const SCHEMA: &str = "ondine-vectors/1";

/// A file.
pub(super) struct Topic {
    /// Of the file, without `.json`.
    pub name: &'static str,
    /// What is in it.
    pub about: &'static str,
    pub sections: Vec<Section>,
}

/// Cases of one function.
pub(super) struct Section {
    pub name: &'static str,
    /// What the fields mean, and their units.
    pub about: &'static str,
    /// The scene that the cases are of, as a scene file has it.
    pub scene: Option<String>,
    pub cases: Vec<Case>,
}

impl Section {
    pub fn new(name: &'static str, about: &'static str, cases: Vec<Case>) -> Self {
        Self {
            name,
            about,
            scene: None,
            cases,
        }
    }
}

/// Inputs and outputs, in their order.
#[derive(Default)]
pub(super) struct Case(String);

impl Case {
    pub fn new() -> Self {
        Self::default()
    }

    /// A float: `name` in the fewest decimals that name it (`null` where it is not finite), `name_bits` its bits.
    pub fn float(self, name: &str, x: f32) -> Self {
        self.field(name, decimal(x)).bits(name, x.to_bits())
    }

    /// Floats, likewise.
    pub fn floats(self, name: &str, x: &[f32]) -> Self {
        let bits = x.iter().map(|x| hex(x.to_bits()));
        self.field(name, list(x.iter().copied().map(decimal)))
            .field(&format!("{name}_bits"), list(bits))
    }

    /// A 32-bit word.
    pub fn word(self, name: &str, word: u32) -> Self {
        self.field(name, hex(word))
    }

    /// 32-bit words.
    pub fn words(self, name: &str, words: &[u32]) -> Self {
        self.field(name, list(words.iter().copied().map(hex)))
    }

    /// A word of another size, as hexadecimal text of that many digits.
    pub fn wide_word(self, name: &str, word: u128, digits: usize) -> Self {
        self.field(name, format!("\"0x{word:0digits$x}\""))
    }

    /// Words of another size.
    pub fn wide_words(self, name: &str, words: &[u128], digits: usize) -> Self {
        let words = words.iter().map(|word| format!("\"0x{word:0digits$x}\""));
        self.field(name, list(words))
    }

    /// A whole number.
    pub fn whole(self, name: &str, number: u32) -> Self {
        self.field(name, number)
    }

    /// An id, `null` for none.
    pub fn id(self, name: &str, id: u32) -> Self {
        if id == u32::MAX {
            self.field(name, "null")
        } else {
            self.whole(name, id)
        }
    }

    /// A yes or no.
    pub fn flag(self, name: &str, is: bool) -> Self {
        self.field(name, is)
    }

    /// A word of text.
    pub fn text(self, name: &str, text: &str) -> Self {
        self.field(name, quoted(text))
    }

    fn bits(self, name: &str, bits: u32) -> Self {
        self.field(&format!("{name}_bits"), hex(bits))
    }

    fn field(mut self, name: &str, value: impl Display) -> Self {
        let comma = if self.0.is_empty() { "" } else { ", " };
        let written = write!(self.0, "{comma}\"{name}\": {value}");
        debug_assert!(written.is_ok(), "text takes all that is written to it");
        self
    }
}

impl Topic {
    pub fn to_json(&self) -> String {
        let sections: Vec<String> = self.sections.iter().map(Section::to_json).collect();
        format!(
            "{{\n  \"schema\": {},\n  \"topic\": {},\n  \"about\": {},\n  \"sections\": {{\n{}\n  }}\n}}\n",
            quoted(SCHEMA),
            quoted(self.name),
            quoted(self.about),
            sections.join(",\n"),
        )
    }
}

impl Section {
    fn to_json(&self) -> String {
        let scene = self.scene.as_ref().map_or(String::new(), |scene| {
            format!("      \"scene\": {},\n", quoted(scene))
        });
        let cases: Vec<String> = self
            .cases
            .iter()
            .map(|case| format!("        {{{}}}", case.0))
            .collect();
        format!(
            "    {}: {{\n      \"about\": {},\n{scene}      \"cases\": [\n{}\n      ]\n    }}",
            quoted(self.name),
            quoted(self.about),
            cases.join(",\n"),
        )
    }
}

fn list(values: impl Iterator<Item = String>) -> String {
    format!("[{}]", values.collect::<Vec<_>>().join(", "))
}

fn hex(word: u32) -> String {
    format!("\"{word:#010x}\"")
}

/// JSON has no infinities.
fn decimal(x: f32) -> String {
    if x.is_finite() {
        format!("{x:?}")
    } else {
        "null".to_owned()
    }
}

/// A text as JSON has it.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
