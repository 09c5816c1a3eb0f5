//! The data of Eq. (8) as plain arrays.

use super::{ContactDamping, Friction};

/// Maximum number of modes of a joint.
pub const MAX_MODES: usize = 128;

/// The discretised contact model at one tilt: `n` contact nodes, `m` modes, SI units, Cartesian vectors
/// with the origin at the centre of the ball. The data are sufficient to integrate the model with another
/// program.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Positions of the nodes, `n`, m.
    pub positions: Vec<[f64; 3]>,
    /// Outward unit normals `e_r` of the ball, `n`.
    pub normals: Vec<[f64; 3]>,
    /// Areas `Delta A`, `n`, m^2.
    pub areas: Vec<f64>,
    /// Pre-stress `p_n`, `n`, Pa.
    pub pre_stress: Vec<f64>,
    /// Contact stiffness per area `k_c`, `n`, N/m^3.
    pub stiffness: Vec<f64>,
    /// Mode shapes at the nodes, `n x m` row-major, 1/sqrt(kg).
    pub shapes: Vec<[f64; 3]>,
    /// Natural angular frequencies, `m`, rad/s.
    pub omega: Vec<f64>,
    /// Modal damping ratios, `m`, or empty for none.
    pub damping: Vec<f64>,
    /// Velocity of steady sliding `Omega x x`, `n`, m/s.
    pub sliding_velocity: Vec<[f64; 3]>,
    /// Friction law.
    pub friction: Friction,
    /// Whether nodes can separate.
    pub unilateral: bool,
    /// Damping of the contact.
    pub contact_damping: ContactDamping,
    /// Angular velocity `Omega` (rad/s) for the term `Omega x u` of the slip velocity; `None` omits the term.
    pub convection: Option<[f64; 3]>,
    /// Row that gives Eq. (24) from the modal coordinates, `m`, 1/sqrt(kg).
    pub probe: Vec<f64>,
}

impl Model {
    /// Number of contact nodes.
    pub fn nodes(&self) -> usize {
        self.areas.len()
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.omega.len()
    }

    /// Mode shapes at node `k`.
    pub fn shapes_at(&self, k: usize) -> &[[f64; 3]] {
        &self.shapes[k * self.modes()..][..self.modes()]
    }
}
