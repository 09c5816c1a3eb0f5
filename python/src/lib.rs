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
mod _squeakscope {
    #[pymodule_export]
    use crate::integrate::{System, exponents, integrate};
    #[pymodule_export]
    use crate::main;
    #[pymodule_export]
    use crate::model::model;
    #[pymodule_export]
    use crate::recording::{analyse, read_signal_file};
    #[pymodule_export]
    use crate::recurrence::{recurrence_plot, rqa, rqa_windowed};
    #[pymodule_export]
    use crate::run::{Run, run};
    #[pymodule_export]
    use crate::samples::{Contact, Samples};
    #[pymodule_export]
    use crate::scene::{Scene, scenes};
    #[pymodule_export]
    use crate::schema::schemas;
    #[pymodule_export]
    use crate::signal::{
        choose_delay, embed, false_neighbours, largest_exponent, mutual_information,
        poincare_section, regime, zero_one_test,
    };
    #[pymodule_export]
    use crate::simulation::Simulation;
    #[pymodule_export]
    use crate::spectra::{spectrogram, spectrum, tonal_events};
    #[pymodule_export]
    use crate::study::{branch, cost, lyapunov, sensitivities, stability};
    #[pymodule_export]
    use crate::sweep::{basins, sweep};

    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "the name is that of Python")]
    const __version__: &str = squeakscope::VERSION;
}
