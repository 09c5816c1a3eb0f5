//! The parameters of a joint, in SI units and radians. Validated by `scene`; plain data here.

use super::Stribeck;
use crate::fem::{Elements, Families, Geometry, Material};

/// Everything that Eq. (1) to (8) need, apart from the tilt. Load and rotation may change with time as
/// well: these are the ones at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct JointSpec {
    /// The vibrating body.
    pub body: BodySpec,
    /// The socket.
    pub socket: Socket,
    /// Load pressing the ball into the socket, N.
    pub load: f64,
    /// Azimuth of the tilt, from +x towards +y, rad.
    pub azimuth: f64,
    /// Rotation vector of the ball, rad/s.
    pub rotation: [f64; 3],
    /// The contact.
    pub contact: Contact,
    /// The law of friction.
    pub friction: Friction,
    /// Modal damping ratios, one a mode; empty means none.
    pub damping: Vec<f64>,
}

/// Ball and beam.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySpec {
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
#[derive(Clone, Debug, PartialEq)]
pub enum Frequencies {
    /// Those of the finite-element model.
    FiniteElement,
    /// Those of Fig. 2 of the paper, imposed on the finite-element shapes.
    Published,
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
}

/// Quadrature of the patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quadrature {
    /// Rings of cells of equal area.
    Rings,
    /// Gauss rule in the Hertz weight along the radius, equal angles round it.
    Gauss,
}

/// Distribution of the contact stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StiffnessLaw {
    /// The same everywhere.
    Uniform,
    /// In proportion to the pre-stress, with the same total.
    LikePreStress,
}

/// The law of friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Friction {
    /// No friction.
    None,
    /// A Stribeck curve, smoothed at rest. With `mu_s = mu_d` it is Coulomb's constant coefficient,
    /// regularised.
    Stribeck {
        /// The curve.
        law: Stribeck,
        /// Whether the radial part `(V . e_r) Phi_r` of Eq. (8) is kept, or projected out.
        radial: bool,
    },
}
