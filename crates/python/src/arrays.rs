//! numpy arrays in and out: read where they are if they can be, handed over without a copy.

use std::fmt::Write as _;

use bytemuck::Pod;
use glam::{DAffine3, DMat4, DVec3, DVec4, Vec3};
use numpy::{Element, IntoPyArray, PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::errors::expected;

/// A type of numbers that arrays are read as.
pub(crate) trait Number: Element + Pod {
    /// numpy's name of it.
    const NAME: &'static str;
    /// The kinds of numbers that are converted to it, in numpy's letters.
    const KINDS: &'static str;
}

impl Number for f32 {
    const NAME: &'static str = "float32";
    const KINDS: &'static str = "fiu";
}

impl Number for f64 {
    const NAME: &'static str = "float64";
    const KINDS: &'static str = "fiu";
}

impl Number for u32 {
    const NAME: &'static str = "uint32";
    const KINDS: &'static str = "iu";
}

/// An argument: a contiguous array whose last dimension has N numbers.
pub(crate) struct Rows<'py, T: Element, const N: usize> {
    array: PyReadonlyArrayDyn<'py, T>,
}

impl<'py, T: Number, const N: usize> Rows<'py, T, N> {
    /// Takes any value that numpy makes an array of, or that has DLPack's protocol. It is copied only where it isn't
    /// contiguous, of another type, or not aligned.
    pub(crate) fn new(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        let wanted = format!("(..., {N})");
        let array = contiguous(name, &wanted, value)?;
        if array.shape().last() != Some(&N) {
            return Err(other_array::<T>(name, &wanted, value));
        }
        Ok(Self { array })
    }

    /// As [`Rows::new`], of two dimensions; `count` is the name of the first one.
    pub(crate) fn table(name: &str, count: &str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        let wanted = format!("({count}, {N})");
        let array = contiguous(name, &wanted, value)?;
        if array.ndim() != 2 || array.shape()[1] != N {
            return Err(other_array::<T>(name, &wanted, value));
        }
        Ok(Self { array })
    }

    /// The numbers, as rows of a type that is N numbers.
    pub(crate) fn of<R: Pod>(&self) -> &[R] {
        const { assert!(size_of::<R>() == size_of::<T>() * N) };
        bytemuck::cast_slice(self.array.as_slice().unwrap_or_default())
    }

    /// All dimensions but the last.
    pub(crate) fn shape(&self) -> &[usize] {
        let shape = self.array.shape();
        &shape[..shape.len() - 1]
    }
}

/// Numbers of any shape in one piece.
pub(crate) struct Numbers<'py, T: Element> {
    array: PyReadonlyArrayDyn<'py, T>,
}

impl<'py, T: Number> Numbers<'py, T> {
    /// As [`Rows::new`], of a shape.
    pub(crate) fn new(name: &str, value: &Bound<'py, PyAny>, shape: &[usize]) -> PyResult<Self> {
        Self::fitting(name, &shown(shape), value, |found| found == shape)
    }

    /// Of one dimension.
    pub(crate) fn list(name: &str, count: &str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        Self::fitting(name, &format!("({count},)"), value, |found| found.len() == 1)
    }

    fn fitting(
        name: &str,
        wanted: &str,
        value: &Bound<'py, PyAny>,
        fits: impl FnOnce(&[usize]) -> bool,
    ) -> PyResult<Self> {
        let array = contiguous(name, wanted, value)?;
        if fits(array.shape()) { Ok(Self { array }) } else { Err(other_array::<T>(name, wanted, value)) }
    }

    /// One number for all, or those of a shape.
    pub(crate) fn one_or_each(name: &str, value: &Bound<'py, PyAny>, shape: &[usize]) -> PyResult<Self> {
        let wanted = if shape.is_empty() { "()".to_owned() } else { format!("() or {}", shown(shape)) };
        Self::fitting(name, &wanted, value, |found| found.is_empty() || found == shape)
    }

    /// The number, where there is one alone.
    pub(crate) fn one(&self) -> Option<T> {
        (self.array.ndim() == 0).then(|| self.slice().first().copied()).flatten()
    }

    pub(crate) fn slice(&self) -> &[T] {
        self.array.as_slice().unwrap_or_default()
    }
}

/// Three numbers, as f64.
pub(crate) fn vector(name: &str, value: &Bound<'_, PyAny>) -> PyResult<DVec3> {
    let numbers = Numbers::<f64>::new(name, value, &[3])?;
    Ok(DVec3::from_slice(numbers.slice()))
}

/// Three numbers that are finite in f32.
pub(crate) fn finite_vector(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec3> {
    world_point(name, value).map(DVec3::as_vec3)
}

/// As [`finite_vector`], as f64.
pub(crate) fn world_point(name: &str, value: &Bound<'_, PyAny>) -> PyResult<DVec3> {
    let point = vector(name, value)?;
    if point.as_vec3().is_finite() { Ok(point) } else { Err(expected(name, "finite numbers", point.as_vec3())) }
}

/// Whether f32 is too coarse for a point, given another one near it: the bound is that of scenes with an origin of their own.
pub(crate) fn is_far(point: DVec3, near: DVec3) -> bool {
    point.abs().max_element() > 512.0 * point.distance(near)
}

/// A transform of column vectors whose last row is 0, 0, 0, 1, or has been left out.
pub(crate) fn affine(name: &str, value: &Bound<'_, PyAny>) -> PyResult<DAffine3> {
    let rows = Rows::<f64, 4>::table(name, "3 or 4", value)?;
    let rows = rows.of::<DVec4>();
    if !(3..=4).contains(&rows.len()) {
        return Err(other_array::<f64>(name, "(3 or 4, 4)", value));
    }
    affine_of(name, rows)
}

/// As [`affine`], of any number of transforms.
pub(crate) fn affines(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<DAffine3>> {
    let rows = Rows::<f64, 4>::new(name, value)?;
    match *rows.shape() {
        [_, of_each @ (3 | 4)] => rows.of::<DVec4>().chunks(of_each).map(|rows| affine_of(name, rows)).collect(),
        _ => Err(other_array::<f64>(name, "(N, 3 or 4, 4)", value)),
    }
}

/// A transform of three or four rows.
fn affine_of(name: &str, rows: &[DVec4]) -> PyResult<DAffine3> {
    let last = rows.get(3).copied().unwrap_or(DVec4::W);
    let matrix = DMat4::from_cols(rows[0], rows[1], rows[2], last).transpose();
    let is_affine = matrix.is_finite() && last == DVec4::W;
    let error = || expected(name, "finite numbers and a last row of 0, 0, 0, 1", matrix.transpose());
    is_affine.then(|| DAffine3::from_mat4(matrix)).ok_or_else(error)
}

fn contiguous<'py, T: Number>(
    name: &str,
    wanted: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    if let Some(array) = as_it_is(value) {
        return Ok(array);
    }
    let not_numbers = || PyTypeError::new_err(mismatch::<T>(name, wanted, value));
    let array = as_array(value).map_err(|_| not_numbers())?;
    if let Some(array) = as_it_is(&array) {
        return Ok(array);
    }
    let dtype = array.getattr("dtype")?;
    let kind: String = dtype.getattr("kind")?.extract()?;
    let is_empty = array.getattr("size")?.extract::<usize>()? == 0;
    // An empty list is an array of floats to numpy.
    if !T::KINDS.contains(&kind) && !is_empty {
        return Err(not_numbers());
    }
    if T::KINDS == "iu" && !is_empty {
        let [least, most] = ["min", "max"].map(|method| array.call_method0(method).and_then(|of| of.extract::<i128>()));
        let (least, most) = (least?, most?);
        if least < 0 || most > i128::from(u32::MAX) {
            return Err(expected(name, "numbers from 0 to 4294967295", if least < 0 { least } else { most }));
        }
    }
    let converted = value.py().import("numpy")?.call_method1("require", (array, T::NAME, ("C", "A")))?;
    as_it_is(&converted).ok_or_else(not_numbers)
}

/// numpy's array of a value.
fn as_array<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let numpy = value.py().import("numpy")?;
    let has_protocol = !value.is_instance(&numpy.getattr("ndarray")?)? && value.hasattr("__dlpack__")?;
    numpy.call_method1(if has_protocol { "from_dlpack" } else { "asarray" }, (value,))
}

/// The array itself, where it can be read in place.
fn as_it_is<'py, T: Number>(value: &Bound<'py, PyAny>) -> Option<PyReadonlyArrayDyn<'py, T>> {
    let array = value.cast::<PyArrayDyn<T>>().ok()?.try_readonly().ok()?;
    // A slice may be had of columns too, as Fortran has them.
    (array.is_c_contiguous() && array.as_slice().is_ok()).then_some(array)
}

/// The error for an array of another shape than the wanted one, as Python writes it.
pub(crate) fn other_array<T: Number>(name: &str, wanted: &str, value: &Bound<'_, PyAny>) -> PyErr {
    PyValueError::new_err(mismatch::<T>(name, wanted, value))
}

/// Names an argument, and shape and type of numbers: those that were expected and those that were found.
fn mismatch<T: Number>(name: &str, wanted: &str, value: &Bound<'_, PyAny>) -> String {
    let found = as_array(value).and_then(|array| {
        let (shape, dtype) = (array.getattr("shape")?, array.getattr("dtype")?);
        Ok(format!("shape {shape} {dtype}"))
    });
    let found = found.unwrap_or_else(|why| {
        let kind = value.get_type().name().map_or_else(|_| "object".to_owned(), |name| name.to_string());
        format!("{kind}: {why}")
    });
    format!("{name}: expected shape {wanted} {}, found {found}", T::NAME)
}

/// A shape as Python writes it.
pub(crate) fn shown(shape: &[usize]) -> String {
    let mut text = String::from("(");
    for (index, size) in shape.iter().enumerate() {
        // Writing to a string can't fail.
        let _ = write!(text, "{}{size}", if index == 0 { "" } else { ", " });
    }
    text.push_str(if shape.len() == 1 { ",)" } else { ")" });
    text
}

/// A count, as text.
pub(crate) fn counted(count: usize, one: &str, several: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

/// The length of an array's first dimension.
pub(crate) fn rows(py: Python<'_>, array: &Py<PyAny>) -> usize {
    array.bind(py).len().unwrap_or_default()
}

/// Hands values over to numpy, without a copy, as an array of a shape.
pub(crate) fn hand_over<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let array: Bound<'py, PyArray1<T>> = values.into_pyarray(py);
    array.call_method1("reshape", (PyTuple::new(py, shape)?,))
}

/// Hands rows of N numbers over, as an array of a shape and N.
pub(crate) fn hand_over_rows<'py, T: Element, const N: usize>(
    py: Python<'py>,
    rows: Vec<[T; N]>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let shape: Vec<usize> = shape.iter().copied().chain([N]).collect();
    hand_over(py, rows.into_flattened(), &shape)
}
