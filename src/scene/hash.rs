//! The hash that names a scene: that of all bytes it was read from.

use crate::film::hexadecimal;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Adds the bytes of a file.
pub(super) fn add_file(path: &Path, hasher: &mut Sha256) -> std::io::Result<()> {
    let mut file = File::open(path)?;
    let mut buffer = vec![0; 1 << 16];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(()),
            length => hasher.update(&buffer[..length]),
        }
    }
}

/// What was added, in hexadecimal.
pub(super) fn finish(hasher: Sha256) -> String {
    hexadecimal(&hasher.finalize())
}
