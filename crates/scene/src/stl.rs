use std::path::Path;

use crate::{Error, still::Still};

pub(crate) fn read(path: &Path) -> Result<Still, Error> {
    Err(Error::unsupported(path, "this format", "wait"))
}
