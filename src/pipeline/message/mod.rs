//! Messages of a run: frames from the simulation, records to a sink.

mod classification;
mod frame;
mod header;
mod lesson;
mod observation;
mod record;

pub use crate::analysis::{poincare::SectionPoint, regime::Regime, tones::SpectralLine};
pub use crate::fem::{SurfaceMesh, vertex_normals};
pub(crate) use classification::listed;
pub use classification::{Classification, RunExponents, regime_on};
pub use frame::*;
pub use header::*;
pub use lesson::*;
pub use observation::*;
pub use record::*;
