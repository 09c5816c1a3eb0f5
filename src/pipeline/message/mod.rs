//! The messages of a run: frames from the simulation, records to a sink.

mod computed;
mod frame;
mod header;
mod lesson;
mod observation;
mod record;

pub use crate::analysis::{SectionPoint, SpectralLine};
pub use crate::fem::{SurfaceMesh, vertex_normals};
pub use computed::{Computed, ComputedPicture, Coupling, CurveSubject, FrictionReading};
pub use frame::{
    EnergySample, Exponents, Frame, NodeState, PatchGeometry, PatchSnapshot, Shown, TwinSamples,
};
pub use header::{
    AnalysisKind, Header, JointInfo, ModeInfo, SectionCoordinate, SignalInfo, SmallInfo,
    StatusInfo, StatusKind, Subject,
};
pub use lesson::{
    Course, Growth, Lesson, Measurements, NodeShares, StatusShares, TiltLoop, TiltedTone,
    ToneChange, Way,
};
pub use observation::{Appearance, Circumstances, Observation, Parting, PartingLine, Vibration};
pub use record::{Health, Record, Summary};
