#![doc = include_str!("../guide/scenes.md")]

mod accuracy;
mod error;
mod file;
mod keys;
mod kind;
mod mechanism;
mod overrides;
mod parameter;
mod presets;
mod schedule;
mod spec;
mod subject;
mod units;
mod validate;

#[cfg(test)]
mod schedule_tests;
#[cfg(test)]
mod small_tests;
#[cfg(test)]
mod tests;

#[cfg(test)]
mod effects_tests;

pub use accuracy::{Advised, LONGEST_STEP};
pub use error::{Fault, Place, SceneError, SceneWarning};
pub use keys::key_reference;
pub use mechanism::Mechanism;
pub use parameter::Parameter;
pub use presets::{DEFAULT_SCENE, PRESETS, Preset, preset};
pub use schedule::{Schedule, Sine};
pub use spec::{
    Amount, AnalysisSpec, ButterflySpec, ChaosSpec, DelaySpec, EmbeddingSpec, Events,
    ExponentsSpec, Integrator, Method, NearnessSpec, QuantificationSpec, RecordSpec,
    RecurrenceSpec, RegimeSpec, Scene, SectionSpec, SectionSurface, Setting, SlidingSpec,
    SpectrogramSpec, Start, StateCoordinate,
};
pub use subject::{Held, Loading, ScaledRotation, SmallSystem, SubjectSpec, TiltedJoint};
