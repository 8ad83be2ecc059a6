//! Numbers between numpy and Rust.

use numpy::ndarray::{ArrayView, IxDyn};
use numpy::{
    AllowTypeChange, Element, PyArray, PyArrayDyn, PyArrayLikeDyn, PyArrayMethods, PyUntypedArrayMethods, ToPyArray,
};
use pyo3::prelude::*;
use serde::Serialize;

use crate::error::{Error, Raise};

/// Anything that `numpy.asarray` converts to this type of number.
pub type Numbers<'py, T> = PyArrayLikeDyn<'py, T, AllowTypeChange>;

/// An array of double precision.
pub type Doubles<'py> = Bound<'py, PyArrayDyn<f64>>;

/// An array of single precision.
pub type Floats<'py> = Bound<'py, PyArrayDyn<f32>>;

/// Returns a copy of the numbers of an array of this shape.
///
/// # Errors
/// [`Error`] for another shape.
pub fn numbers<T: Element + Copy>(name: &str, array: &Numbers<'_, T>, shape: &[usize]) -> PyResult<Vec<T>> {
    if array.shape() != shape {
        return Err(Error::new_err(format!("{name}: expected shape {shape:?}, got {:?}", array.shape())));
    }
    Ok(array.as_array().iter().copied().collect())
}

/// As [`numbers`], of a vector of this constant length.
pub fn vector<const N: usize>(name: &str, array: &Numbers<'_, f32>) -> PyResult<[f32; N]> {
    numbers(name, array, &[N])?.try_into().map_err(|_| Error::new_err(format!("{name}: expected {N} numbers")))
}

/// Returns a new array of this shape.
pub fn array<'py, T: Element + Clone>(
    py: Python<'py>,
    values: &[T],
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    Ok(ArrayView::from_shape(IxDyn(shape), values).or_raise()?.to_pyarray(py))
}

/// Returns a read-only array of this shape over memory that a Python object owns. The array keeps the owner alive.
///
/// # Safety
/// As long as `owner` lives, `values` must stay where it is and keep its length.
pub unsafe fn view<'py, T: Element>(
    owner: Bound<'py, PyAny>,
    values: &[T],
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let values = ArrayView::from_shape(IxDyn(shape), values).or_raise()?;
    // SAFETY: the caller keeps the memory in place, and numpy keeps the owner alive.
    let array = unsafe { PyArray::borrow_from_array(&values, owner) };
    array.readwrite().make_nonwriteable();
    Ok(array)
}

/// Returns a value as dictionaries, lists and numbers; NaN is `None`, as in the command's JSON.
pub fn plain<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (serde_json::to_string(value).or_raise()?,))
}
