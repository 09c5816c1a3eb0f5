//! All that Eq. (8) needs, as plain arrays.

use super::{ContactDamping, Friction};

/// The most modes that a joint can have.
pub const MOST_MODES: usize = 128;

/// The discretised contact model at one tilt: `n` contact nodes, `m` modes, SI units, Cartesian
/// vectors from the ball's centre. Anyone can integrate it with another program.
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
    /// Natural circular frequencies, `m`, rad/s.
    pub omega: Vec<f64>,
    /// Modal damping ratios, `m`, or empty for none.
    pub damping: Vec<f64>,
    /// Velocity of steady sliding `Omega x x`, `n`, m/s.
    pub sliding_velocity: Vec<[f64; 3]>,
    /// The law of friction.
    pub friction: Friction,
    /// Whether nodes can lift off.
    pub unilateral: bool,
    /// Damping of the contact.
    pub contact_damping: ContactDamping,
    /// The rotation `Omega` (rad/s) by which the slip velocity has the part `Omega x u`; `None` leaves
    /// it out.
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
