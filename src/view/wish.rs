//! What is asked of the studio between rounds, and what it answers.

use crate::error::Result;
use crate::film::tonemap::Tonemap;
use serde::Serialize;
use std::fs::File;
use tokio::sync::oneshot;

/// An answer that is waited for elsewhere.
pub type Reply<T> = oneshot::Sender<Result<T>>;

/// What the studio is asked for between rounds.
pub enum Wish {
    /// A file of a side.
    Save(usize, Format, Reply<Saved>),
    /// What renders a side, and makes such a picture of it.
    CommandLine(usize, Option<Tonemap>, Reply<String>),
    /// What is at a pixel.
    Pick(u32, u32, Reply<Option<Picked>>),
}

impl Wish {
    /// Whether nobody waits for the answer any more.
    pub fn is_in_vain(&self) -> bool {
        match self {
            Wish::Save(_, _, reply) => reply.is_closed(),
            Wish::CommandLine(_, _, reply) => reply.is_closed(),
            Wish::Pick(_, _, reply) => reply.is_closed(),
        }
    }
}

/// What is at a pixel.
#[derive(Clone, Debug, Serialize)]
pub struct Picked {
    /// World space.
    pub position: [f32; 3],
    /// Along the camera's axis: what a focus distance means.
    pub depth: f32,
    /// From the camera.
    pub distance: f32,
    /// Name of the material; none of what only emits.
    pub material: Option<String>,
}

/// A file that is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Format {
    /// The exact film.
    Exr,
    /// A picture of it.
    Png(Tonemap),
}

/// A file that was written.
#[derive(Debug)]
pub struct Saved {
    /// To be read from its beginning.
    pub file: File,
    /// The folder that it is in, if that is still there; it goes when this is dropped.
    pub folder: Option<tempfile::TempDir>,
    /// What a user would call it.
    pub name: String,
    /// What renders the same.
    pub command_line: String,
}
