//! Floor 6: many images from one file. A [job file](file::JobFile) is [expanded](plan::expand) to jobs; what is
//! [there already](standing::Standing) is left alone, and the rest is [rendered](run::run) and [recorded](record).

pub mod cluster;
pub mod file;
mod image;
mod outputs;
pub mod plan;
pub mod progress;
pub mod record;
pub mod run;
pub mod scenes;
mod scripts;
pub mod standing;
pub mod template;
