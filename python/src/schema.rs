//! Names and fields of the results, from the types that are serialised.

use pyo3::prelude::*;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use squeakscope::analysis::{
    chaos::{Divergence, ZeroOne},
    delay::{DelayChoice, FalseNeighbours, MutualInformation},
    events::TonalEvents,
    recurrence::Measures,
    regime::Verdict,
};
use squeakscope::dynamics::SolverStats;
use squeakscope::pipeline::RunResult;
use squeakscope::pipeline::message::RunExponents;
use squeakscope::study::StabilityResult;
use squeakscope::study::basins::Basins;
use squeakscope::study::branch::{Branch, ModeSensitivities};
use squeakscope::study::cost::Cost;
use squeakscope::study::lyapunov::{LyapunovResult, LyapunovStudy};
use squeakscope::study::signal::{MeasuresAt, SignalAnalysis, SpectralLines};
use squeakscope::study::sweep::SweepResult;

/// Declares results that have arrays beside serialised fields.
macro_rules! results {
    ($($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $kind:ty,)* })*) => {$(
        $(#[$doc])*
        #[derive(JsonSchema)]
        #[expect(dead_code, reason = "only the schema is used")]
        pub struct $name {
            $($(#[$field_doc])* $field: $kind,)*
        }
    )*};
}

results! {
    /// Amplitude spectrum of a signal.
    Spectrum {
        #[serde(flatten)]
        lines: SpectralLines,
        /// Frequencies, Hz.
        frequency_hz: Vec<f64>,
        /// One-sided amplitudes, in the unit of the signal.
        amplitude: Vec<f64>,
    }
    /// Spectrogram of a signal.
    Spectrogram {
        /// Centres of the windows, s.
        time_s: Vec<f64>,
        /// Frequencies, Hz.
        frequency_hz: Vec<f64>,
        /// Amplitudes, times x frequencies, in the unit of the signal.
        amplitude: Vec<Vec<f64>>,
    }
    /// Poincare section of a delay trajectory.
    Section {
        /// Times of the crossings, s.
        time_s: Vec<f64>,
        /// Points, crossings x coordinates, in the unit of the signal.
        points: Vec<Vec<f64>>,
        /// Level of the section, in the unit of the signal.
        level: f64,
    }
    /// Recurrence plot.
    Plot {
        /// Whether two states are recurrent.
        recurrent: Vec<Vec<bool>>,
        /// Distance of the threshold; None for one that each state has.
        threshold: Option<f64>,
        /// Recurrence rate, 0 to 1.
        rate: f64,
    }
    /// Recurrence quantification.
    Quantified {
        #[serde(flatten)]
        measures: Measures,
        /// Distance of the threshold; None for one that each state has.
        threshold: Option<f64>,
        /// Number of states.
        states: u64,
    }
    /// Signal of a file.
    SignalOfFile {
        /// Name of the column or channel.
        name: String,
        /// Unit of the samples.
        unit: String,
        /// Sampling rate, Hz.
        rate_hz: f64,
        /// Time of the first sample, s.
        start_s: f64,
        /// Samples, in the unit.
        samples: Vec<f64>,
    }
    /// Motion of an own system.
    Integration {
        /// Times of the samples.
        t: Vec<f64>,
        /// States, times x components.
        z: Vec<Vec<f64>>,
        /// Times of the events.
        event_t: Vec<f64>,
        /// Guard of each event.
        event_index: Vec<i64>,
        /// State after each event and its reset.
        event_z: Vec<Vec<f64>>,
        /// Statistics of the solver.
        stats: SolverStats,
        /// Number of calls of the functions.
        calls: u64,
    }
    /// Lyapunov exponents of an own system.
    OwnExponents {
        #[serde(flatten)]
        study: LyapunovStudy,
        /// Number of calls of the functions.
        calls: u64,
    }
    /// Lyapunov exponents of a scene.
    SceneExponents {
        #[serde(flatten)]
        study: LyapunovResult,
    }
}

/// JSON schemas of all results, by their names.
#[pyfunction]
pub fn schemas(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    let mut generator = SchemaSettings::draft2020_12()
        .for_serialize()
        .into_generator();
    macro_rules! add {
        ($($kind:ty),* $(,)?) => { $(generator.subschema_for::<$kind>();)* };
    }
    add!(
        Basins,
        Branch,
        Cost,
        DelayChoice,
        Divergence,
        FalseNeighbours,
        MeasuresAt,
        ModeSensitivities,
        Integration,
        MutualInformation,
        OwnExponents,
        Plot,
        Quantified,
        RunExponents<'_>,
        RunResult<'_>,
        SceneExponents,
        Section,
        SignalAnalysis,
        SignalOfFile,
        Spectrogram,
        Spectrum,
        StabilityResult,
        SweepResult,
        TonalEvents,
        Verdict,
        ZeroOne,
    );
    Ok(pythonize::pythonize(py, &generator.take_definitions(true))?)
}
