//! Steady sliding: where the body rests while the ball turns.

use super::Joint;
use super::lanes::LANES;
use super::traction::Query;
use crate::dynamics::System;

/// The steady-sliding equilibrium of Eq. (8): with `N = p_n` and `V = Omega x x` its right side is
/// constant, and `q_eq = force / omega^2`.
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibrium {
    /// Generalised force of contact and friction, `m`.
    pub force: Vec<f64>,
    /// Modal coordinates, `m`, sqrt(kg) m.
    pub q: Vec<f64>,
}

impl Equilibrium {
    /// Before it has been found: nothing is taken off the forces.
    pub(crate) fn unknown(modes: usize) -> Self {
        let (force, q) = (vec![0.0; modes], vec![0.0; modes]);
        Self { force, q }
    }

    /// Finds the equilibrium of a joint whose own is unknown yet, and leaves in the nodes their
    /// steady friction.
    pub(crate) fn of(joint: &mut Joint) -> Self {
        let omega = joint.omega().to_vec();
        let rest = vec![0.0; omega.len()];
        let mut force = rest.clone();
        // The very pass of the hot loop: what is subtracted there later is equal to the last bit.
        joint.traction(Query {
            contact: joint.lift_off(),
            record: None,
            audited: false,
            q: &rest,
            v: &rest,
            force: &mut force,
        });
        for block in &mut joint.nodes.blocks {
            if let Some(law) = joint.law.law() {
                for lane in 0..LANES {
                    let speed = block.speed.0[lane];
                    let normal = block.area.0[lane] * block.pre_stress.0[lane];
                    block.steady_friction.0[lane] = -normal * law.ratio(speed).value * speed;
                }
            }
        }
        let q = force.iter().zip(&omega).map(|(f, w)| f / (w * w)).collect();
        Self { force, q }
    }
}
