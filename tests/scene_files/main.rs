//! What the scene format refuses, where it says so, and what it tells the author to do.

mod builtins;
mod changes;
mod environments;
mod lights;
mod meshes;
mod syntax;
mod transforms;
mod values;
mod world;

use ondine::error::Error;
use ondine::lanes::Rgb;
use ondine::material::Material;
use ondine::scene::description::{Description, Environment, Filter, SamplerKind, Shape, Strategy};
use ondine::scene::{builtin, toml};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use std::path::Path;

/// A scene that is right, to be made wrong one line at a time: line numbers below count from its first.
const RIGHT: &str = r#"version = 1
[camera]
position = [0, 0, 3]
look_at = [0, 0, 0]
vertical_fov = 50
[materials.white]
type = "lambert"
albedo = [0.8, 0.8, 0.8]
[[objects]]
sphere = { center = [0, 0, 0], radius = 1 }
material = "white"
[[lights]]
quad = { corner = [-1, 3, -1], u = [2, 0, 0], v = [0, 0, 2] }
radiance = [5, 5, 5]
"#;

fn read(text: &str) -> Result<Description, Error> {
    toml::parse(text, "a.toml", None)
}

fn refusal(text: &str) -> String {
    match read(text) {
        Ok(_) => panic!("read without complaint:\n{text}"),
        Err(error) => error.to_string(),
    }
}

/// Replaces `from` in the right scene and asserts the place and the remedy of the refusal.
#[track_caller]
fn refuses(from: &str, to: &str, place: &str, words: &[&str]) {
    assert!(RIGHT.contains(from), "{from:?} is not in the scene");
    refuses_text(&RIGHT.replacen(from, to, 1), place, words);
}

#[track_caller]
fn refuses_text(text: &str, place: &str, words: &[&str]) {
    let message = refusal(text);
    let start = format!("a.toml:{place}: ");
    assert!(message.starts_with(&start), "{message}\nis not at {place}");
    for word in words {
        assert!(message.contains(word), "{message}\nlacks {word:?}");
    }
}

#[track_caller]
fn accepts(from: &str, to: &str) -> Description {
    assert!(RIGHT.contains(from), "{from:?} is not in the scene");
    read(&RIGHT.replacen(from, to, 1)).unwrap_or_else(|error| panic!("{error}"))
}

/// Appends to the right scene, whose next line is line 15.
#[track_caller]
fn refuses_appended(text: &str, place: &str, words: &[&str]) {
    refuses_text(&format!("{RIGHT}{text}"), place, words);
}

/// A copy with one to four random edits: flipped, deleted or inserted bytes, duplicated lines.
fn mutated(original: &[u8], random: &mut Pcg32) -> Vec<u8> {
    let mut below = |limit: usize| random.next_u32() as usize % limit.max(1);
    let mut bytes = original.to_vec();
    for _ in 0..=below(4) {
        let at = below(bytes.len());
        let end = (at + 1 + below(8)).min(bytes.len());
        match below(4) {
            0 => bytes[at] ^= 1 << below(8),
            1 => drop(bytes.drain(at..end)),
            2 => {
                const ALPHABET: &[u8] = b"[]{}=\"',.#\n -+_0123456789eE:nainftrux\xc3\xa9\xff\0";
                let inserted: Vec<u8> =
                    (at..end).map(|_| ALPHABET[below(ALPHABET.len())]).collect();
                drop(bytes.splice(at..at, inserted));
            }
            _ => {
                let start = bytes[..at]
                    .iter()
                    .rposition(|&byte| byte == b'\n')
                    .map_or(0, |newline| newline + 1);
                let stop = bytes[at..]
                    .iter()
                    .position(|&byte| byte == b'\n')
                    .map_or(bytes.len(), |length| at + length + 1);
                let line = bytes[start..stop].to_vec();
                drop(bytes.splice(start..start, line));
            }
        }
        if bytes.is_empty() {
            bytes.push(b'=');
        }
    }
    bytes
}
