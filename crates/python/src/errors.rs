//! Errors of the library as Python's exceptions.

use std::error::Error;
use std::io;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use umbrage::scene::BadInstance;

/// `OSError`, or its subclass for the system's error, where a file can't be read; else `ValueError`.
pub(crate) fn exception(error: impl Error + 'static) -> PyErr {
    let message = error.to_string();
    let mut cause: Option<&(dyn Error + 'static)> = Some(&error);
    while let Some(error) = cause {
        if let Some(system) = error.downcast_ref::<io::Error>() {
            return io::Error::new(system.kind(), message).into();
        }
        cause = error.source();
    }
    PyValueError::new_err(message)
}

/// The error for an argument other than the expected one.
pub(crate) fn expected(name: &str, expected: &str, found: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(format!("{name}: expected {expected}, found {found}"))
}

/// The error for a mesh that can't be added.
pub(crate) fn bad_instance(bad: BadInstance) -> PyErr {
    match bad {
        BadInstance::Index { index, vertices } => {
            expected("triangle_indices", &format!("indices below {vertices}, the number of vertices"), index)
        }
        BadInstance::TooMany => PyValueError::new_err("a scene has at most 4294967295 vertices and triangles"),
    }
}
