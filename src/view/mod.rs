//! Floor 6: the live page. A scene is rendered while people look at it in browsers, change things, and compare.
//!
//! Three threads beside the workers: the `studio` gives them rounds of waves and starts anew when the view changes; the
//! `painter` turns the films into pictures, when somebody waits for one; the `server` has the page's files, and a
//! `reader` for each page that is open. All pages show the same view. Each draws a picture before it gets the next,
//! so nothing piles up for those who are slow; tone curves are the page's own business.
//!
//! The view is what `ondine render` can be told: the image that is saved has the bits of the command line that is given with it.

mod exhibit;
mod guard;
mod hello;
mod look;
mod painter;
mod picture;
mod reader;
mod server;
mod session;
mod side;
mod sides;
mod studio;
mod values;
mod wish;

pub use server::{Options, serve};
pub use sides::Source;
