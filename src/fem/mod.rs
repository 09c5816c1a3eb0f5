//! Finite elements of a solid of revolution: a mesh of its meridian section, Fourier harmonics
//! round the axis. Knows no joint.

mod spec;

pub use spec::{Families, Geometry, LengthReading, Material, ModeKind};
