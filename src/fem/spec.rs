//! What to mesh and which modes to find: parameters only.

/// Linear elastic, isotropic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus, Pa.
    pub young: f64,
    /// Poisson's ratio, in (-1, 0.5).
    pub poisson: f64,
    /// Density, kg/m^3.
    pub density: f64,
}

/// Which reading of the beam's length is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LengthReading {
    /// The length runs from the free end to the circle where beam and sphere meet.
    ToSphere,
    /// The length runs from the free end to the ball's centre.
    ToCentre,
}

/// A solid ball on a solid round beam. The ball's centre is the origin; the beam's axis is the
/// z axis, and the beam lies on its negative side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Diameter of the ball, m.
    pub ball_diameter: f64,
    /// Diameter of the beam, m.
    pub beam_diameter: f64,
    /// Length of the beam, m.
    pub beam_length: f64,
    /// How the length is read.
    pub reading: LengthReading,
}

/// How many modes of each family, counted from the lowest elastic one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Families {
    /// Bending pairs (each gives two modes).
    pub bending_pairs: usize,
    /// Torsion modes.
    pub torsion: usize,
    /// Axial modes.
    pub axial: usize,
}

impl Families {
    /// The number of modes, pairs counted twice.
    pub fn count(&self) -> usize {
        2 * self.bending_pairs + self.torsion + self.axial
    }
}

/// Family and orientation of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ModeKind {
    /// Bending in the x-z plane (harmonic 1, cosine copy).
    BendingX,
    /// Bending in the y-z plane (harmonic 1, sine copy).
    BendingY,
    /// Torsion (harmonic 0, circumferential displacement).
    Torsion,
    /// Axial and radial motion (harmonic 0).
    Axial,
}
