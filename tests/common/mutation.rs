//! Damage to files: a few random edits, of bytes, of lines, of numbers.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

/// What readers stumble over, as text.
const WORDS: [&str; 22] = [
    "0",
    "-1",
    "1e39",
    "-1e-46",
    "nan",
    "inf",
    "4294967295",
    "4294967296",
    "2147483648",
    "18446744073709551616",
    "1e308",
    "0.5.5",
    "\"",
    "[",
    "]",
    "{",
    "}",
    "#",
    "\\",
    "/",
    "../",
    "\u{feff}",
];

/// And as 32 bits.
const BITS: [u32; 9] = [
    0,
    1,
    u32::MAX,
    i32::MAX as u32,
    1 << 31,
    0x7fc0_0000, // not a number
    0x7f80_0000, // infinity
    0x0000_0001, // the least float
    0xff7f_ffff, // the least finite float
];

const ALPHABET: &[u8] = b"[]{}=\"',.#\n -+_0123456789eE:nainftrux\xc3\xa9\xff\0";

/// One to five edits.
pub fn mutated(original: &[u8], random: &mut Pcg32) -> Vec<u8> {
    let mut bytes = original.to_vec();
    for _ in 0..=below(random, 5) {
        edit(&mut bytes, random);
        if bytes.is_empty() {
            bytes.push(b'=');
        }
    }
    bytes
}

fn below(random: &mut Pcg32, limit: usize) -> usize {
    random.next_u32() as usize % limit.max(1)
}

fn edit(bytes: &mut Vec<u8>, random: &mut Pcg32) {
    let at = below(random, bytes.len());
    let end = (at + 1 + below(random, 8)).min(bytes.len());
    match below(random, 9) {
        0 | 1 => bytes[at] ^= 1 << below(random, 8),
        2 => drop(bytes.drain(at..end)),
        3 => {
            let inserted: Vec<u8> = (at..end)
                .map(|_| ALPHABET[below(random, ALPHABET.len())])
                .collect();
            drop(bytes.splice(at..at, inserted));
        }
        4 => {
            let line = line_around(bytes, at);
            let copy = bytes[line.clone()].to_vec();
            drop(bytes.splice(line.start..line.start, copy));
        }
        5 => drop(bytes.drain(line_around(bytes, at))),
        6 => {
            // A number, or what else has no space in it, becomes another word.
            let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b".-+".contains(byte);
            let start = bytes[..at]
                .iter()
                .rposition(|byte| !is_word(byte))
                .map_or(0, |i| i + 1);
            let stop = bytes[at..]
                .iter()
                .position(|byte| !is_word(byte))
                .map_or(bytes.len(), |i| at + i);
            let word = WORDS[below(random, WORDS.len())].bytes();
            drop(bytes.splice(start..stop.max(start), word));
        }
        7 => {
            let word = BITS[below(random, BITS.len())];
            let word = if below(random, 2) == 0 {
                word.to_le_bytes()
            } else {
                word.to_be_bytes()
            };
            let end = (at + 4).min(bytes.len());
            bytes[at..end].copy_from_slice(&word[..end - at]);
        }
        _ => {
            // Cut short, mostly near the end.
            let most = 1 << below(random, 12);
            let from_end = below(random, most);
            bytes.truncate(bytes.len().saturating_sub(from_end));
        }
    }
}

/// The line that byte `at` is in, with its end.
fn line_around(bytes: &[u8], at: usize) -> std::ops::Range<usize> {
    let is_end = |&byte: &u8| byte == b'\n';
    let start = bytes[..at].iter().rposition(is_end).map_or(0, |i| i + 1);
    let stop = bytes[at..]
        .iter()
        .position(is_end)
        .map_or(bytes.len(), |i| at + i + 1);
    start..stop
}
