//! Energies of the perturbation from steady sliding, for the energy audit: the change of energy equals the
//! work in the same interval.

use super::Joint;
use super::nodes::radial;
use squeakscope_dynamics::System;

/// Energies at an instant, J. All are zero at the equilibrium and non-negative.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energy {
    /// `(q'^2 + omega^2 q^2) / 2` of each mode.
    pub modal: Vec<f64>,
    /// Energy of the contact springs relative to the pre-stressed state.
    pub contact: f64,
}

impl Energy {
    /// Total energy, J.
    pub fn total(&self) -> f64 {
        self.modal.iter().sum::<f64>() + self.contact
    }
}

impl Joint {
    /// Returns the energies at state `z`. The work component of the audit is not used.
    ///
    /// The potential of a closed node is `A k_c u_r^2 / 2`. The stress of a separated node is zero, and its
    /// potential continues linearly as `-p_n (u_r + p_n / 2 k_c)`.
    pub fn energy(&self, z: &[f64]) -> Energy {
        let m = self.omega().len();
        let (q, v) = (&z[..m], &z[m..2 * m]);
        let modal = (0..m)
            .map(|i| 0.5 * (v[i] * v[i] + (self.omega()[i] * q[i]).powi(2)))
            .collect();
        let mut contact = 0.0;
        for (block, rows) in self.nodes.iter() {
            for (lane, u_r) in radial(rows, q).into_iter().enumerate() {
                let (p, k) = (block.pre_stress.0[lane], block.stiffness.0[lane]);
                let stored = if self.unilateral && p + k * u_r < 0.0 {
                    -p * (u_r + 0.5 * p / k)
                } else {
                    0.5 * k * u_r * u_r
                };
                contact += block.area.0[lane] * stored;
            }
        }
        Energy { modal, contact }
    }

    /// Power of modal damping at modal velocities `v`, W; never positive.
    pub(crate) fn damping_power(&self, v: &[f64]) -> f64 {
        let modes = self.damping().iter().zip(self.omega()).zip(v);
        modes
            .map(|((zeta, omega), v)| -2.0 * zeta * omega * v * v)
            .sum()
    }
}
