#![doc = include_str!("../guide/reference/scenes.md")]

mod accuracy;
mod compare;
mod controls;
mod document;
mod edit;
mod error;
mod mechanism;
mod overrides;
mod parameter;
mod parse;
mod presets;
mod schedule;
mod schema;
mod spec;
mod subject;
mod tables;

#[cfg(test)]
mod tests;

pub use accuracy::GAUSS_NODES;
pub use compare::{KeyDifference, SceneComparison};
pub use controls::Control;
pub use error::SceneError;
pub use mechanism::{Evidence, Mechanism};
pub use parameter::Parameter;
pub use presets::{DEFAULT_SCENE, PRESETS, Preset, preset};
pub use schedule::{Schedule, Sine};
pub use spec::Scene;
pub use subject::{Carry, FixedAt, LoadedJoint, SmallSystem, SystemSpec};
pub use tables::analysis::{
    AnalysisBudget, AnalysisSpec, ChaosSpec, DelaySpec, EmbeddingSpec, LyapunovSpec,
    PerturbedTrajectorySpec, QuantificationSpec, RecurrenceSpec, RegimeSpec, SectionSpec,
    SectionSurface, SpectrogramSpec, SpectrumSpec, StateCoordinate, ThresholdSpec,
};
pub use tables::{Events, Integrator, RecordSpec, Start, key_reference};
