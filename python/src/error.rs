//! Errors of the library as Python exceptions.

use std::error::Error;
use std::fmt::Display;

use exceptions::InputError;
use pyo3::prelude::*;
use squeakscope::analysis::AnalysisError;
use squeakscope::chain_of_causes;
use squeakscope::scene::SceneError;
use squeakscope::study::signal::SignalError;

use crate::recording::FileError;

mod exceptions {
    pyo3::import_exception!(squeakscope._errors, Error);
    pyo3::import_exception!(squeakscope._errors, InputError);
}

/// An error with its causes: an `InputError` if an input is the cause, else an `Error`.
pub fn raise(error: &(dyn Error + 'static)) -> PyErr {
    let causes = || std::iter::successors(Some(error), |&error| error.source());
    let is_input = |cause: &(dyn Error + 'static)| {
        cause.is::<SceneError>()
            || cause.is::<AnalysisError>()
            || cause.is::<SignalError>()
            || cause.is::<FileError>()
    };
    let text = chain_of_causes(error);
    if causes().any(is_input) {
        input(text)
    } else {
        failure(text)
    }
}

/// A computation that failed.
pub fn failure(message: impl Display) -> PyErr {
    exceptions::Error::new_err(message.to_string())
}

/// An error of an argument, which the message names together with the remedy.
pub fn input(message: impl Display) -> PyErr {
    InputError::new_err(message.to_string())
}
