//! The analytic Jacobian of the right-hand side: for stability, stiff steps and the tangent flow.

use super::Joint;
use super::lanes::LANES;
use crate::dynamics::System;

impl Joint {
    /// `dF/dz` of the state `[q | dq/dt]` (without the audit's work) at `z`, row-major
    /// `2m x 2m`, into `jacobian`. Units follow the state: `[[s^-1 ...]]` mixed, as usual.
    ///
    /// At a node that is just closing or opening the derivative jumps; the value on the open side
    /// is taken where the gap is exactly zero.
    pub fn jacobian(&self, z: &[f64], jacobian: &mut [f64]) {
        let m = self.omega().len();
        let dim = 2 * m;
        let (q, v) = (&z[..m], &z[m..dim]);
        jacobian[..dim * dim].fill(0.0);
        for i in 0..m {
            jacobian[i * dim + m + i] = 1.0;
            let omega = self.omega()[i];
            jacobian[(m + i) * dim + i] = -omega * omega;
            if let Some(zeta) = self.damping().get(i) {
                jacobian[(m + i) * dim + m + i] = -2.0 * zeta * omega;
            }
        }
        for k in 0..self.nodes.count {
            let slopes = self.node_slopes(k, q, v);
            let (block, lane) = (k / LANES, k % LANES);
            let rows = &self.nodes.rows[block * m..][..m];
            let row = |i: usize| [rows[i].s.0[lane], rows[i].t.0[lane], rows[i].r.0[lane]];
            for j in 0..m {
                let shape = row(j);
                // How the node's force changes with q_j and with dq_j/dt.
                let by_q = slopes.by_gap.map(|slope| slope * shape[2]);
                let mut by_v = [0.0; 3];
                for (axis, change) in by_v.iter_mut().enumerate() {
                    *change = (0..3)
                        .map(|other| slopes.by_slip[axis][other] * shape[other])
                        .sum();
                }
                for i in 0..m {
                    let shape = row(i);
                    let line = &mut jacobian[(m + i) * dim..][..dim];
                    line[j] += super::vector::dot(shape, by_q);
                    line[m + j] += super::vector::dot(shape, by_v);
                }
            }
        }
    }

    /// How the force on node `k`, in its own frame, changes.
    fn node_slopes(&self, k: usize, q: &[f64], v: &[f64]) -> NodeSlopes {
        let action = self.node_action(k, q, v);
        let (block, lane) = (&self.nodes.blocks[k / LANES], k % LANES);
        let mut slopes = NodeSlopes {
            by_gap: [0.0; 3],
            by_slip: [[0.0; 3]; 3],
        };
        if self.unilateral && action.gap <= 0.0 {
            return slopes;
        }
        let stiffness = block.area.0[lane] * block.stiffness.0[lane];
        slopes.by_gap[2] = -stiffness;
        let Some(law) = self.law.law() else {
            return slopes;
        };
        let ratio = law.ratio(action.speed);
        let axes = if self.law.radial() { 3 } else { 2 };
        for axis in 0..axes {
            slopes.by_gap[axis] -= stiffness * ratio.value * action.slip[axis];
            slopes.by_slip[axis][axis] -= action.normal * ratio.value;
            if action.speed > 0.0 {
                for other in 0..axes {
                    slopes.by_slip[axis][other] -=
                        action.normal * ratio.slope * action.slip[axis] * action.slip[other]
                            / action.speed;
                }
            }
        }
        slopes
    }
}

/// Derivatives of the force on a node in its frame `(e_s, e_t, e_r)`.
struct NodeSlopes {
    /// By the radial displacement, N/m.
    by_gap: [f64; 3],
    /// By the slip velocity, N s/m.
    by_slip: [[f64; 3]; 3],
}
