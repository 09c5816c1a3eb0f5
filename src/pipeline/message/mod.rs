//! Messages of a run: frames from the simulation, records to a sink.

mod computed;
mod frame;
mod header;
mod lesson;
mod observation;
mod record;
mod segment;

pub use crate::analysis::{poincare::SectionPoint, regime::Regime, tones::SpectralLine};
pub use crate::fem::{SurfaceMesh, vertex_normals};
pub use computed::{
    Coupling, FrictionMemory, FrictionReading, MechanismPrediction, PredictedCurves,
    SecondToneGrowth, TableReading, TiltDirection, TorusBirth, UnstablePass, fastest, unstable,
};
pub use frame::{
    ContactSample, DisplayRates, EnergySample, Exponents, Frame, Kick, NodeState, PatchGeometry,
    PatchSnapshot, PerturbedSamples,
};
pub use header::{
    AnalysisKind, Header, JointInfo, ModeInfo, SILENCE_RATIO, SignalInfo, SmallInfo, StatusInfo,
    StatusKind, Subject,
};
pub use lesson::{
    Growth, Lesson, LevelSample, Measurements, NodeShares, SecondToneLevel, SmallFrequency,
    SqueakPass, StatusShares, TiltLoop, TiltedTone, ToneChange, ToneGrowth,
};
pub use observation::{
    Appearance, DivergenceFit, Observation, OperatingPoint, TrajectoryDivergence, Vibration,
};
pub use record::{Health, Record, Summary};
pub use segment::MotionSegment;
