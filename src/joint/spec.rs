//! The parameters of a joint, in SI units and radians. Validated by `scene`; plain data here.

use std::sync::Arc;

use super::{ContactDamping, Friction, OwnModes};
use crate::fem::{Elements, Families, Geometry, Material};

/// Everything that Eq. (1) to (8) need, apart from the tilt. Load and rotation may change with time as
/// well: these are the ones at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct JointSpec {
    /// The vibrating body.
    pub body: BodySpec,
    /// The socket. Not asked where the body brings its contact patch with it.
    pub socket: Socket,
    /// Load pressing the ball into the socket, N.
    pub load: f64,
    /// Azimuth of the tilt, from +x towards +y, rad.
    pub azimuth: f64,
    /// Rotation vector of the ball, rad/s.
    pub rotation: [f64; 3],
    /// Whether the slip velocity has the part `Omega x u` of the vibration's displacement.
    pub convection: bool,
    /// The contact.
    pub contact: Contact,
    /// The law of friction.
    pub friction: Friction,
    /// Modal damping ratios, one a mode; empty means none.
    pub damping: Vec<f64>,
}

/// Where the modes come from.
#[derive(Clone, Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "a joint has one body: its size does not matter"
)]
pub enum BodySpec {
    /// From finite elements of a ball on a beam.
    BallOnBeam(BallOnBeam),
    /// From a file, with the contact patch. Of [`Contact`] only the number of nodes, which is that of
    /// the file, the factor on the stiffness, which is then one on that of the file, and whether
    /// nodes lift off are asked.
    Own(Arc<OwnModes>),
}

impl BodySpec {
    /// The number of modes.
    pub fn modes(&self) -> usize {
        match self {
            Self::BallOnBeam(body) => body.families.count(),
            Self::Own(modes) => modes.modes(),
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
    /// Which modes take part.
    pub families: Families,
    /// Where the natural frequencies come from.
    pub frequencies: Frequencies,
}

/// Source of the natural frequencies.
#[derive(Clone, Debug, PartialEq, strum::VariantArray, strum::IntoStaticStr)]
pub enum Frequencies {
    /// Those of Fig. 2 of the paper, imposed on the finite-element shapes.
    #[strum(serialize = "published")]
    Published,
    /// Those of the finite-element model.
    #[strum(serialize = "fe")]
    FiniteElement,
}

/// The socket that holds the ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Socket {
    /// Diameter of the socket, m; larger than the ball's.
    pub diameter: f64,
    /// Young's modulus, Pa.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
}

/// How the contact patch is discretised and how stiff it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Number of contact nodes, 1 to 10,000.
    pub nodes: usize,
    /// Where the nodes are and what they weigh.
    pub quadrature: Quadrature,
    /// Factor on the Hertz stiffness `2 E* a / (pi a^2)`.
    pub stiffness_factor: f64,
    /// How the stiffness is spread over the patch.
    pub stiffness: StiffnessLaw,
    /// Factor on the Hertz radius of the patch (load and total stiffness are kept).
    pub radius_factor: f64,
    /// Whether nodes can lift off.
    pub unilateral: bool,
    /// What resists the speed at which the gap closes.
    pub damping: ContactDamping,
}

/// Quadrature of the patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::VariantArray, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum Quadrature {
    /// Rings of cells of equal area.
    Rings,
    /// Gauss rule in the Hertz weight along the radius, equal angles round it.
    Gauss,
}

/// Distribution of the contact stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::VariantArray, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum StiffnessLaw {
    /// The same everywhere.
    Uniform,
    /// In proportion to the pre-stress, with the same total.
    #[strum(serialize = "pre-stress")]
    LikePreStress,
}
