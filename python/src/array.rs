//! Arguments: arrays, numbers and words, each checked once, with errors that name the argument and the remedy.

use numpy::{PyReadonlyArray1, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::conversion::FromPyObjectOwned;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::input;

/// Numbers of an argument, contiguous; they are copied only if they have to be converted.
pub type Numbers<'py> = PyReadonlyArray1<'py, f64>;

/// An array of numbers of double precision, of any shape.
pub fn numeric<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyUntypedArray>> {
    let numpy = value.py().import("numpy")?;
    let wrong = || {
        let kind = value.get_type();
        let kind = kind
            .name()
            .map_or_else(|_| kind.to_string(), |name| name.to_string());
        input(format!("{name}: give an array of numbers, not {kind}"))
    };
    let array = numpy.call_method1("asarray", (value,));
    let array = array.map_err(|_| wrong())?;
    match array.getattr("dtype")?.getattr("kind")?.extract::<char>()? {
        'c' => Err(input(format!(
            "{name}: complex numbers are not possible; give their real part, imaginary part or magnitude"
        ))),
        'b' | 'i' | 'u' | 'f' | 'O' => {
            if value.is_instance(&numpy.getattr("ma")?.getattr("MaskedArray")?)? {
                return Err(input(format!(
                    "{name}: masked samples are not possible; replace them, as with filled(), or cut them off"
                )));
            }
            let float = numpy.getattr("float64")?;
            let array = numpy.call_method1("asarray", (&array, float, "C"));
            Ok(array.map_err(|_| wrong())?.cast_into()?)
        }
        _ => Err(wrong()),
    }
}

/// A signal or a state: finite numbers in one dimension.
pub fn vector<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Numbers<'py>> {
    let array = numeric(name, value)?;
    if value.is_none() || array.ndim() == 0 {
        return Err(input(format!(
            "{name}: give an array of shape (n,), not {value}"
        )));
    }
    if array.ndim() > 1 {
        return Err(input(format!(
            "{name}: the shape is {}; give one dimension, such as a column {name}[:, 0]",
            array.getattr("shape")?
        )));
    }
    let numbers: Numbers<'py> = array.extract()?;
    match numbers.as_slice()?.iter().position(|x| !x.is_finite()) {
        None => Ok(numbers),
        Some(at) => Err(input(format!(
            "{name}: sample {at} is {}; replace it by a number",
            numbers.as_slice()?[at]
        ))),
    }
}

/// A whole number of at least `least`.
pub fn whole(name: &str, value: i64, least: usize) -> PyResult<usize> {
    let number = usize::try_from(value)
        .ok()
        .filter(|number| *number >= least);
    number.ok_or_else(|| {
        input(format!(
            "{name}: give a whole number of at least {least}, not {value}"
        ))
    })
}

/// A whole number that may be omitted.
pub fn optional(name: &str, value: Option<i64>, least: usize) -> PyResult<Option<usize>> {
    value.map(|value| whole(name, value, least)).transpose()
}

/// A finite number above 0.
pub fn positive(name: &str, value: f64) -> PyResult<f64> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(input(format!(
            "{name}: give a finite number above 0, not {value}"
        )))
    }
}

/// Declares keyword arguments with their defaults, which several functions have.
macro_rules! options {
    ($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $kind:ty = $default:expr,)* }) => {
        $(#[$doc])*
        pub struct $name {
            $($(#[$field_doc])* pub $field: $kind,)*
        }

        impl $name {
            pub const NAMES: &[&str] = &[$(stringify!($field)),*];

            pub fn of(given: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
                Ok(Self {
                    $($field: $crate::array::option(given, stringify!($field), || $default)?,)*
                })
            }
        }
    };
}
pub(crate) use options;

/// Refuses keyword arguments with other names than these.
pub fn check_names(given: Option<&Bound<'_, PyDict>>, known: &[&[&str]]) -> PyResult<()> {
    let known: Vec<_> = known
        .iter()
        .flat_map(|names| names.iter().map(|name| (*name, ())))
        .collect();
    for (name, _) in given.into_iter().flatten() {
        choice("keyword arguments", &name.extract::<String>()?, &known)?;
    }
    Ok(())
}

/// A keyword argument, or its default.
pub fn option<'py, T: FromPyObjectOwned<'py>>(
    given: Option<&Bound<'py, PyDict>>,
    name: &str,
    default: impl FnOnce() -> T,
) -> PyResult<T> {
    match given
        .map(|given| given.get_item(name))
        .transpose()?
        .flatten()
    {
        None => Ok(default()),
        Some(value) => value.extract::<T>().map_err(|error| {
            let error: PyErr = error.into();
            input(format!("{name}: {}", error.value(value.py())))
        }),
    }
}

/// The choice that a word names.
pub fn choice<T: Clone>(name: &str, word: &str, all: &[(&str, T)]) -> PyResult<T> {
    let found = all.iter().find(|(known, _)| *known == word);
    found.map(|(_, value)| value.clone()).ok_or_else(|| {
        let known: Vec<&str> = all.iter().map(|(known, _)| *known).collect();
        let known = known.join(", ");
        input(format!(
            "{name}: `{word}` is not a choice; give one of {known}"
        ))
    })
}
