//! Settings as arguments of `ondine render`.

use super::Settings;
use crate::film::{AovSet, Region};

impl Settings {
    /// The arguments that say what decides the bits of an image, but for scene, camera and part: all of them, so that a default
    /// that changes later changes no image.
    pub fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        let mut add = |option: &str, value: String| words.push(format!("--{option}={value}"));
        add("size", format!("{}x{}", self.width, self.height));
        if self.region != Region::full(self.width, self.height) {
            add("crop", self.region.to_string());
        }
        add("spp", self.spp.to_string());
        add("seed", self.seed.to_string());
        add("path-length", self.path_length.to_string());
        add("strategy", self.strategy.to_string());
        add("sampler", self.sampler.to_string());
        if let Some(edge) = self.roulette {
            add("roulette", edge.to_string());
        }
        if self.aovs != AovSet::default() {
            add("aov", self.aovs.to_string());
        }
        words
    }
}

/// Words as the line of a shell.
pub fn shell_line(words: &[String]) -> String {
    let words: Vec<String> = words.iter().map(|word| shell_quoted(word)).collect();
    words.join(" ")
}

/// A word as a shell takes it.
pub fn shell_quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-+=./,:@%".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::shell_quoted;

    #[test]
    fn a_word_stays_one_word() {
        assert_eq!(shell_quoted("--spp=4"), "--spp=4");
        assert_eq!(shell_quoted(""), "''");
        assert_eq!(shell_quoted("a b"), "'a b'");
        assert_eq!(shell_quoted("it's $x"), r"'it'\''s $x'");
    }
}
