//! What to mesh, with which elements, and which modes to find: parameters only.

use std::ops::RangeInclusive;

use super::element::MOST_ORDER;

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::VariantArray, strum::IntoStaticStr)]
pub enum LengthReading {
    /// The length runs from the free end to the circle where beam and sphere meet.
    #[strum(serialize = "sphere")]
    ToSphere,
    /// The length runs from the free end to the ball's centre.
    #[strum(serialize = "centre")]
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

/// The finite elements: Lagrange quadrilaterals of the meridian section.
///
/// A frequency of a smooth mode is too high by a relative error that falls like `size^(2 order)`
/// (Strang and Fix, An Analysis of the Finite Element Method, 1973, ch. 6). On the ball with its
/// beam that holds down to about 1e-5; below, the corner where the two meet decides, at which
/// stresses are singular: there the error falls about like the size, at any order.
///
/// Integration is full, so linear elements lock in bending: the shear strain that they cannot avoid
/// makes a beam too stiff until they are much smaller than it is thick. With elements as long as
/// the beam is thick the first bending frequency is 27 % too high at order 1, and 0.06 % at order 2.
///
/// The default is for a body of the paper's size: order 4, as large as the ball's radius. The
/// eleven frequencies up to 13 kHz are then converged to 5e-6, in less than a tenth of a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elements {
    /// Longest edge, m; positive, and not so small that there are more than [`Elements::limit`].
    pub size: f64,
    /// Polynomial order along an edge: 1 linear, 2 quadratic, 3 cubic, up to 8.
    pub order: usize,
}

/// The largest mesh that is made, in nodes before grading: some ten seconds, not hours.
const NODE_LIMIT: usize = 32_000;

impl Elements {
    /// The orders there are.
    pub const ORDERS: RangeInclusive<usize> = 1..=MOST_ORDER;

    /// How many elements of this order a mesh may have, before grading: as many as have 32,000
    /// nodes, which is 32,000 linear, 8,000 quadratic or 2,000 of order 4.
    pub fn limit(&self) -> usize {
        // An order of 0 is refused where a mesh is made.
        NODE_LIMIT / self.order.pow(2).max(1)
    }
}

impl Default for Elements {
    fn default() -> Self {
        Self {
            size: 16e-3,
            order: 4,
        }
    }
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
