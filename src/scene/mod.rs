#![doc = include_str!("../guide/scenes.md")]

mod accuracy;
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
mod setting;
mod spec;
mod subject;
mod tables;

#[cfg(test)]
mod tests;

pub use accuracy::LONGEST_STEP;
pub use error::{Fault, Place, SceneError, SceneWarning};
pub use mechanism::Mechanism;
pub use parameter::Parameter;
pub use presets::{DEFAULT_SCENE, PRESETS, Preset, preset};
pub use schedule::{Schedule, Sine};
pub use setting::{SectionSurface, Setting, StateCoordinate};
pub use spec::Scene;
pub use subject::{Held, Loading, ScaledRotation, SmallSystem, SubjectSpec, TiltedJoint};
pub use tables::analysis::{
    AnalysisSpec, ButterflySpec, ChaosSpec, DelaySpec, EmbeddingSpec, ExponentsSpec, NearnessSpec,
    QuantificationSpec, RecurrenceSpec, RegimeSpec, SectionSpec, SlidingSpec, SpectrogramSpec,
    SpectrumSpec,
};
pub use tables::{Advised, Events, Integrator, RecordSpec, Start, key_reference};
