//! Arrays as rows; the package's Python files have checked them.
use crate::fault::Fault;
use numpy::{Element, PyArray1, PyArrayMethods as _, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::{Bound, PyAny, PyResult, Python};

/// Rows of N numbers.
pub(crate) fn rows<'a, T: Element, const N: usize>(
    array: &'a PyReadonlyArray2<'_, T>,
    name: &str,
) -> Result<&'a [[T; N]], Fault> {
    if array.as_array().ncols() != N {
        let shape = array.as_array().dim();
        return Err(Fault::input(
            format!("the shape of {name} is {shape:?}"),
            format!("give it {N} columns"),
        ));
    }
    let values = array.as_slice().map_err(|_| Fault::not_contiguous(name))?;
    Ok(values.as_chunks().0)
}

/// A number for each row.
pub(crate) fn column<'a, T: Element>(
    array: &'a PyReadonlyArray1<'_, T>,
    name: &str,
) -> Result<&'a [T], Fault> {
    array.as_slice().map_err(|_| Fault::not_contiguous(name))
}

/// An array that takes over these values.
pub(crate) fn array<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let flat = PyArray1::from_vec(py, values);
    Ok(flat.reshape(shape.to_vec())?.into_any())
}

/// The columns of a matrix as a numpy matrix, for `matrix @ [x, y, z, 1]`.
pub(crate) fn matrix<'py>(py: Python<'py>, columns: [f64; 16]) -> PyResult<Bound<'py, PyAny>> {
    let rows: Vec<f64> = (0..16).map(|i| columns[i % 4 * 4 + i / 4]).collect();
    array(py, rows, &[4, 4])
}
