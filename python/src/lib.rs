//! The extension of the Python package: arguments in, one call of the library, its result out.
//!
//! Types are described in `squeakscope/_squeakscope.pyi`, which is checked against this module.

#![allow(
    clippy::too_many_arguments,
    reason = "keyword arguments of Python are arguments of the function"
)]

mod array;
mod call;
mod error;
mod filippov;
mod integrate;
mod model;
mod own;
mod recording;
mod recurrence;
mod result;
mod run;
mod samples;
mod scene;
mod schema;
mod signal;
mod simulation;
mod spectra;
mod study;
mod sweep;
mod system;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Run the program with arguments, of which the first is its path, and return its exit code.
#[pyfunction]
fn main(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| squeakscope::main(words))
}

#[pymodule]
fn _squeakscope(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", squeakscope::VERSION)?;
    module.add_class::<integrate::System>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<run::Run>()?;
    module.add_class::<samples::Samples>()?;
    module.add_class::<samples::Contact>()?;
    module.add_class::<simulation::Simulation>()?;
    for function in [
        wrap_pyfunction!(main, module)?,
        wrap_pyfunction!(run::run, module)?,
        wrap_pyfunction!(scene::scenes, module)?,
        wrap_pyfunction!(recording::analyse, module)?,
        wrap_pyfunction!(signal::choose_delay, module)?,
        wrap_pyfunction!(signal::embed, module)?,
        wrap_pyfunction!(signal::false_neighbours, module)?,
        wrap_pyfunction!(signal::largest_exponent, module)?,
        wrap_pyfunction!(signal::mutual_information, module)?,
        wrap_pyfunction!(signal::poincare_section, module)?,
        wrap_pyfunction!(recording::read_signal_file, module)?,
        wrap_pyfunction!(signal::regime, module)?,
        wrap_pyfunction!(spectra::spectrogram, module)?,
        wrap_pyfunction!(spectra::spectrum, module)?,
        wrap_pyfunction!(spectra::tonal_events, module)?,
        wrap_pyfunction!(signal::zero_one_test, module)?,
        wrap_pyfunction!(recurrence::recurrence_plot, module)?,
        wrap_pyfunction!(recurrence::rqa, module)?,
        wrap_pyfunction!(recurrence::rqa_windowed, module)?,
        wrap_pyfunction!(sweep::basins, module)?,
        wrap_pyfunction!(study::branch, module)?,
        wrap_pyfunction!(study::cost, module)?,
        wrap_pyfunction!(study::lyapunov, module)?,
        wrap_pyfunction!(model::model, module)?,
        wrap_pyfunction!(schema::schemas, module)?,
        wrap_pyfunction!(study::sensitivities, module)?,
        wrap_pyfunction!(study::stability, module)?,
        wrap_pyfunction!(sweep::sweep, module)?,
        wrap_pyfunction!(integrate::exponents, module)?,
        wrap_pyfunction!(integrate::integrate, module)?,
    ] {
        module.add_function(function)?;
    }
    Ok(())
}
