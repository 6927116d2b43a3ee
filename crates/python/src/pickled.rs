//! Pickles: a class's private `_restore` makes an object again of the values that it was made of.

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use pyo3::{IntoPyObjectExt, PyTypeInfo};

/// The function that makes a class's objects again, and its arguments: as `__reduce__` returns them.
pub(crate) fn pickled<'py, T: PyTypeInfo>(
    py: Python<'py>,
    arguments: impl IntoPyObject<'py>,
) -> PyResult<Bound<'py, PyTuple>> {
    let restore = py.get_type::<T>().getattr("_restore")?;
    PyTuple::new(py, [restore, arguments.into_bound_py_any(py)?])
}
