//! Parameters of a joint, in SI units and radians. `scene` validates them.

use std::sync::Arc;

use super::{ContactDamping, Friction, ImportedModes, PressureTable};
use crate::fem::{Elements, Families, Geometry, Material};

/// The parameters of Eq. (1) to (8), except the tilt. Load and rotation are initial values if they change
/// with time.
#[derive(Clone, Debug, PartialEq)]
pub struct JointSpec {
    /// The vibrating body.
    pub body: BodySpec,
    /// The socket. Not used with an imported contact patch.
    pub socket: Socket,
    /// Load that presses the ball into the socket, N.
    pub load: f64,
    /// Azimuth of the tilt, from +x towards +y, rad.
    pub azimuth: f64,
    /// Angular velocity vector of the ball, rad/s.
    pub rotation: [f64; 3],
    /// Whether the slip velocity includes the term `Omega x u`.
    pub convection: bool,
    /// The contact.
    pub contact: Contact,
    /// Pressure over the radius of the patch of ball and beam; `None` for that of Hertz.
    pub pressure: Option<Arc<PressureTable>>,
    /// Friction law.
    pub friction: Friction,
    /// Modal damping ratios, one per mode; empty for an undamped body.
    pub damping: Vec<f64>,
}

/// Source of the modes.
#[derive(Clone, Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "a joint has one body: its size does not matter"
)]
pub enum BodySpec {
    /// Finite-element model of a ball on a beam.
    BallOnBeam(BallOnBeam),
    /// Modes and contact patch from a file. Of [`Contact`] only three fields apply: the number of nodes,
    /// equal to that of the file, the factor on the stiffness of the file, and whether nodes can separate.
    Imported(Arc<ImportedModes>),
}

impl BodySpec {
    /// Number of modes.
    pub fn modes(&self) -> usize {
        match self {
            Self::BallOnBeam(body) => body.families.count(),
            Self::Imported(modes) => modes.modes(),
        }
    }
}

/// Ball and beam.
#[derive(Clone, Debug, PartialEq)]
pub struct BallOnBeam {
    /// Dimensions.
    pub geometry: Geometry,
    /// Material of ball and beam.
    pub material: Material,
    /// Size and order of the finite elements.
    pub elements: Elements,
    /// Numbers of modes.
    pub families: Families,
    /// Source of the natural frequencies.
    pub frequencies: Frequencies,
}

/// Source of the natural frequencies.
#[derive(Clone, Debug, PartialEq, strum::VariantArray, strum::IntoStaticStr, strum::EnumString)]
pub enum Frequencies {
    /// Frequencies of Fig. 2 of the paper with the mode shapes of the finite-element model.
    #[strum(serialize = "published")]
    Published,
    /// Published frequencies, each times the ratio of the finite-element frequencies of this body and of the
    /// published one.
    #[strum(serialize = "scaled")]
    Scaled,
    /// Frequencies of the finite-element model.
    #[strum(serialize = "fe")]
    FiniteElement,
}

/// The socket.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Socket {
    /// Diameter of the socket, m; larger than the ball's.
    pub diameter: f64,
    /// Young's modulus, Pa.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
}

/// Discretisation and stiffness of the contact patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Number of contact nodes, 1 to 10,000.
    pub nodes: usize,
    /// Layout and weights of the nodes.
    pub quadrature: Quadrature,
    /// Factor on the Hertz stiffness `2 E* a / (pi a^2)`.
    pub stiffness_factor: f64,
    /// Distribution of the stiffness over the patch.
    pub stiffness: StiffnessLaw,
    /// Factor on the Hertz radius of the patch; load and total stiffness are unchanged.
    pub radius_factor: f64,
    /// Whether nodes can separate.
    pub unilateral: bool,
    /// Damping of the normal contact.
    pub damping: ContactDamping,
}

/// Quadrature of the patch.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, strum::VariantArray, strum::IntoStaticStr, strum::EnumString,
)]
#[strum(serialize_all = "kebab-case")]
pub enum Quadrature {
    /// Rings of cells of equal area.
    Rings,
    /// Gauss rule along the radius, exact for the Hertz pressure and for a uniform stiffness; equal angles in
    /// each ring.
    Gauss,
}

/// Distribution of the contact stiffness.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, strum::VariantArray, strum::IntoStaticStr, strum::EnumString,
)]
#[strum(serialize_all = "kebab-case")]
pub enum StiffnessLaw {
    /// Uniform stiffness.
    Uniform,
    /// Stiffness proportional to the pre-stress, with the same total.
    #[strum(serialize = "pre-stress")]
    LikePreStress,
}
