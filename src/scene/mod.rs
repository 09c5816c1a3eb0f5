#![doc = include_str!("../guide/scenes.md")]

mod accuracy;
mod document;
mod error;
mod mechanism;
mod overrides;
mod parameter;
mod presets;
mod schedule;
mod schema;
mod spec;
mod subject;
mod tables;

#[cfg(test)]
mod tests;

pub use accuracy::{Advised, LONGEST_STEP};
pub use error::{Fault, Place, SceneError, SceneWarning};
pub use mechanism::Mechanism;
pub use parameter::Parameter;
pub use presets::{DEFAULT_SCENE, PRESETS, Preset, preset};
pub use schedule::{Schedule, Sine};
pub use schema::key_reference;
pub use spec::{Scene, SectionSurface, Setting, StateCoordinate};
pub use subject::{Held, Loading, ScaledRotation, SmallSystem, SubjectSpec, TiltedJoint};
pub use tables::analysis::{
    AnalysisSpec, ButterflySpec, ChaosSpec, DelaySpec, EmbeddingSpec, ExponentsSpec, NearnessSpec,
    QuantificationSpec, RecurrenceSpec, RegimeSpec, SectionSpec, SlidingSpec, SpectrogramSpec,
    SpectrumSpec,
};
pub use tables::{Events, Integrator, RecordSpec, Start};
