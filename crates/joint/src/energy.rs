//! Energies of the perturbation from steady sliding, for the energy audit: the change of energy equals the
//! work in the same interval.

use super::Joint;
use super::nodes::radial;
use super::simd::LANES;
use super::vector::{add_scaled, dot};
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

/// Powers at an instant, W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Power {
    /// Power of the deviation of friction from steady sliding. (The steady friction force is constant and
    /// part of the equilibrium.)
    pub friction: f64,
    /// Power of the contact springs on the modes: the decrease of [`Energy::contact`].
    pub contact: f64,
    /// Power of contact damping, including the end of the force while the spring is still compressed; never
    /// positive for contacts that can separate.
    pub contact_damping: f64,
    /// Power of modal damping; never positive.
    pub damping: f64,
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

    /// Returns the powers at state `z`.
    pub fn power(&self, z: &[f64]) -> Power {
        let [q, v, states] = self.parts(z);
        let mut power = Power {
            damping: self.damping_power(v),
            ..Power::default()
        };
        for k in 0..self.nodes.count {
            let action = self.node_action(k, q, v, states);
            let (block, lane) = (&self.nodes.blocks[k / LANES], k % LANES);
            let rows = &self.nodes.rows[k / LANES * self.nodes.modes..][..self.nodes.modes];
            let mut vibration = [0.0; 3];
            for (row, v) in rows.iter().zip(v) {
                vibration = add_scaled(vibration, *v, [&row.s, &row.t, &row.r].map(|x| x.0[lane]));
            }
            let steady = block.pre_stress.0[lane] * block.area.0[lane];
            let [along, across, outward] = action.friction;
            let friction = [along - block.steady_friction.0[lane], across, outward];
            power.friction += dot(friction, vibration);
            power.contact -= (action.normal - action.dashpot - steady) * vibration[2];
            power.contact_damping -= action.dashpot * vibration[2];
        }
        power
    }

    /// Power of modal damping at modal velocities `v`, W; never positive.
    pub(crate) fn damping_power(&self, v: &[f64]) -> f64 {
        let modes = self.damping().iter().zip(self.omega()).zip(v);
        modes
            .map(|((zeta, omega), v)| -2.0 * zeta * omega * v * v)
            .sum()
    }
}
