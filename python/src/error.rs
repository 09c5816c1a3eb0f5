//! Errors of the library as Python exceptions.

use std::error::Error;

use pyo3::prelude::*;
use pyo3::types::PyType;
use squeakscope::analysis::AnalysisError;
use squeakscope::chain_of_causes;
use squeakscope::pipeline::PipelineError;
use squeakscope::scene::SceneError;
use squeakscope::study::branch::BranchError;
use squeakscope::study::cost::CostError;
use squeakscope::study::signal::SignalError;

use crate::recording::FileError;

/// Module of the exceptions.
const MODULE: &str = "squeakscope._errors";

/// An error with its causes: an `InputError` if an input is the cause, else an `Error`.
pub fn raise(py: Python<'_>, error: &(dyn Error + 'static)) -> PyErr {
    let causes = || std::iter::successors(Some(error), |&error| error.source());
    let is_input = |cause: &(dyn Error + 'static)| {
        cause.is::<SceneError>()
            || cause.is::<AnalysisError>()
            || cause.is::<SignalError>()
            || cause.is::<FileError>()
            // A transparent error hides its source.
            || matches!(cause.downcast_ref(), Some(PipelineError::Scene(_)))
            || matches!(
                cause.downcast_ref(),
                Some(
                    BranchError::Scene(_)
                        | BranchError::Start(_)
                        | BranchError::Pipeline(PipelineError::Scene(_))
                )
            )
            || matches!(cause.downcast_ref(), Some(CostError::Scene(_)))
    };
    let text = chain_of_causes(error);
    match causes().any(is_input) {
        true => input(py, &text),
        false => exception(py, "Error", &text),
    }
}

/// An error of an argument.
pub fn input(py: Python<'_>, message: &str) -> PyErr {
    exception(py, "InputError", message)
}

fn exception(py: Python<'_>, name: &str, message: &str) -> PyErr {
    let class = py.import(MODULE).and_then(|module| module.getattr(name));
    match class.and_then(|class| Ok(class.cast_into::<PyType>()?)) {
        Ok(class) => PyErr::from_type(class, message.to_owned()),
        Err(error) => error,
    }
}
