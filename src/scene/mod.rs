//! What to run: a scene, parsed and validated once; nothing downstream checks again.

mod schedule;
mod spec;

pub use schedule::Schedule;
pub use spec::{
    AnalysisSpec, Integrator, Method, RecordSpec, RecurrenceSpec, RecurrenceThreshold, Scene,
    SpectrogramSpec, SpectrumSpec, Start,
};
