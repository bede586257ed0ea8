//! `ondine dump --vectors`: test vectors of the specification.

use crate::error::{Error, Result};
use std::path::Path;

pub(super) fn write(dir: &Path) -> Result<()> {
    let dir = dir.display();
    Err(Error::Usage(format!("{dir}: no test vectors are made yet")))
}
