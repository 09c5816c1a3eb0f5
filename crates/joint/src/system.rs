//! The joint at one tilt as a dynamical system for the integrators.

use std::sync::Arc;

use pulp::Arch;

use super::contact_force::{ContactForceKernel, NodeLaw};
use super::friction::{ContactLaw, FrictionLaw, WithLaw};
use super::nodes::Nodes;
use super::normal::Separation;
use super::simd::LANES;
use super::vector::{add_scaled, dot, scale};
use super::{ContactDamping, Friction, MAX_MODES, Model};
use squeakscope_dynamics::{Differentiable, Switching, System};

/// The steady-sliding equilibrium of Eq. (8): with `N = p_n` and `V = Omega x x` the right side is
/// constant, and `q_eq = force / omega^2`.
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibrium {
    /// Generalised force of contact and friction, `m`.
    pub force: Vec<f64>,
    /// Modal coordinates, `m`, sqrt(kg) m.
    pub q: Vec<f64>,
}

/// Eq. (8) at one tilt for the perturbation from steady sliding: the state `z = 0` is exactly the
/// equilibrium.
///
/// State: `[q | dq/dt | s | w]`, with the states `s` of the friction law relative to those of steady sliding, node by
/// node, if the law has any ([`DynamicFriction`](super::DynamicFriction)), and the work `w` (J) of the
/// non-conservative forces on the vibration if the energy audit is enabled.
#[derive(Clone, Debug)]
pub struct Joint {
    pub(crate) nodes: Nodes,
    pub(crate) law: Friction,
    /// States of friction in steady sliding, node by node, and their computed rates (1/s), which vanish within rounding;
    /// empty for a law of the slip velocity alone.
    steady_states: Vec<f64>,
    steady_rates: Vec<f64>,
    pub(crate) unilateral: bool,
    pub(crate) contact_damping: ContactDamping,
    omega: Vec<f64>,
    damping: Vec<f64>,
    probe: Vec<f64>,
    equilibrium: Equilibrium,
    audit: bool,
    pub(crate) arch: Arch,
}

impl Joint {
    /// Builds the joint of a model.
    ///
    /// # Panics
    /// If the model has more than 128 modes, or arrays whose lengths disagree.
    pub fn new(model: &Model) -> Self {
        let (m, law) = (model.modes(), model.friction.clone());
        assert!(m <= MAX_MODES, "at most {MAX_MODES} modes, not {m}");
        assert_eq!(
            model.shapes.len(),
            model.nodes() * m,
            "shapes are nodes x modes"
        );
        let nodes = Nodes::new(model);
        let mut steady_states = Vec::new();
        if let Some(evolving) = law.evolving() {
            for node in 0..nodes.count {
                let speed = nodes.blocks[node / LANES].speed.0[node % LANES];
                let state = evolving.law.steady_state(speed);
                steady_states.extend_from_slice(&state[..evolving.states()]);
            }
        }
        let mut joint = Self {
            law,
            steady_rates: vec![0.0; steady_states.len()],
            steady_states,
            nodes,
            unilateral: model.unilateral,
            contact_damping: model.contact_damping,
            omega: model.omega.clone(),
            damping: model.damping.clone(),
            probe: model.probe.clone(),
            // No steady force is subtracted until the equilibrium is known.
            equilibrium: Equilibrium {
                force: vec![0.0; m],
                q: vec![0.0; m],
            },
            audit: false,
            arch: Arch::new(),
        };
        joint.find_equilibrium();
        joint
    }

    /// Builds the joint of a model with a custom friction law; `radial` includes the radial slip velocity,
    /// as in Eq. (8).
    ///
    /// # Panics
    /// As [`Joint::new`].
    pub fn with_friction(model: &Model, law: Arc<dyn FrictionLaw>, radial: bool) -> Self {
        let friction = Friction::Custom { law, radial };
        Self::new(&Model {
            friction,
            ..model.clone()
        })
    }

    /// Computes the equilibrium and the steady friction of the nodes.
    fn find_equilibrium(&mut self) {
        let omega = self.omega().to_vec();
        let m = omega.len();
        let rest = vec![0.0; 2 * m + self.friction_states()];
        let mut force = vec![0.0; m + self.friction_states()];
        // With the kernel of the hot loop, so that the subtraction is exact there.
        self.contact_force(self.lift_off(), None, &rest, &mut force);
        let rates = force.split_off(m);
        let [q, v, states] = self.parts(&rest);
        for node in 0..self.nodes.count {
            let friction = self.node_action(node, q, v, states).friction[0];
            let lane = node % LANES;
            let block = &mut self.nodes.blocks[node / LANES];
            block.steady_friction.0[lane] = friction;
            // A contact at rest ages: there is no steady state.
            if block.speed.0[lane] > 0.0 {
                let count = self.law.states();
                let own = node * count..(node + 1) * count;
                self.steady_rates[own.clone()].copy_from_slice(&rates[own]);
            }
        }
        let q = force.iter().zip(&omega).map(|(f, w)| f / (w * w)).collect();
        self.equilibrium = Equilibrium { force, q };
    }

    /// Enables the energy audit, which adds the work `w` to the state.
    pub fn with_audit(mut self) -> Self {
        self.audit = true;
        self
    }

    /// The steady-sliding equilibrium.
    pub fn equilibrium(&self) -> &Equilibrium {
        &self.equilibrium
    }

    /// Number of contact nodes.
    pub fn contact_nodes(&self) -> usize {
        self.nodes.count
    }

    /// Number of inputs of the friction law: none, the components of the slip velocity, or those of slip velocity and state.
    pub(super) fn friction_inputs(&self) -> usize {
        match &self.law {
            Friction::None => 0,
            Friction::Dynamic { .. } => 6,
            _ => 3,
        }
    }

    /// Number of states of the friction law at all nodes; zero for a law of the slip velocity alone.
    pub fn friction_states(&self) -> usize {
        self.steady_states.len()
    }

    /// The state of friction of a node in the axes of its sliding frame, from the states relative to steady sliding.
    pub(crate) fn state_of(&self, node: usize, states: &[f64]) -> [f64; 3] {
        let mut state = [0.0; 3];
        let first = node * self.law.states();
        for (i, total) in state[..self.law.states()].iter_mut().enumerate() {
            *total = self.steady_states[first + i] + states[first + i];
        }
        state
    }

    /// Divides a state `z` into modal coordinates, modal velocities and the states of friction.
    pub fn parts<'z>(&self, z: &'z [f64]) -> [&'z [f64]; 3] {
        let m = self.omega.len();
        let (q, rest) = z.split_at(m);
        let (v, rest) = rest.split_at(m);
        [q, v, &rest[..self.friction_states()]]
    }

    /// Rewrites the states of friction of a state `z` of this joint for the joint `other` with the same nodes under
    /// another loading: bristles and the age of the contact do not jump.
    pub fn carry_friction(&self, other: &Self, z: &mut [f64]) {
        let Some(evolving) = self.law.evolving() else {
            return;
        };
        let count = evolving.states();
        let states = &mut z[2 * self.omega.len()..][..self.friction_states()];
        for node in 0..self.nodes.count {
            let mut state = self.state_of(node, states);
            if evolving.law.has_vector_state() {
                let axes = self.nodes.frames[node];
                let mut cartesian = scale(axes[0], state[0]);
                cartesian = add_scaled(cartesian, state[1], axes[1]);
                cartesian = add_scaled(cartesian, state[2], axes[2]);
                state = other.nodes.frames[node].map(|axis| dot(axis, cartesian));
            }
            for (i, total) in state[..count].iter().enumerate() {
                states[node * count + i] = total - other.steady_states[node * count + i];
            }
        }
    }

    /// Row that gives Eq. (24) from the modal coordinates, 1/sqrt(kg).
    pub fn probe(&self) -> &[f64] {
        &self.probe
    }

    /// Eq. (24): the displacement (m) of the central contact point in the sliding direction for modal
    /// coordinates `q`, or its velocity (m/s) for modal velocities.
    pub fn probe_value(&self, q: &[f64]) -> f64 {
        self.probe.iter().zip(q).map(|(a, b)| a * b).sum()
    }

    /// Whether the model has contact damping, the term `Omega x u` or the energy audit.
    fn has_extras(&self) -> bool {
        self.audit || !self.contact_damping.is_none() || !self.nodes.convected.is_empty()
    }

    /// The separation rule without a fixed status.
    pub(crate) fn lift_off(&self) -> Separation<'static> {
        if self.unilateral {
            Separation::ByGap
        } else {
            Separation::Never
        }
    }

    /// The laws of the contact at the nodes for a state, with all terms or without the extras.
    pub(super) fn node_law<'a, L: ContactLaw, const EXTRAS: bool>(
        &'a self,
        law: L,
        contact: Separation<'a>,
        parts: [&'a [f64]; 3],
    ) -> NodeLaw<'a, L, EXTRAS> {
        NodeLaw {
            nodes: &self.nodes,
            law,
            damping: self.contact_damping,
            contact,
            parts,
            steady_states: &self.steady_states,
        }
    }

    /// The right side of Eq. (8) minus that of steady sliding. Returns the power (W) of the deviation of friction from
    /// steady sliding and of contact damping with the energy audit, else zero.
    fn contact_force(
        &self,
        contact: Separation<'_>,
        record: Option<&mut [[f64; LANES]]>,
        z: &[f64],
        rates: &mut [f64],
    ) -> f64 {
        self.law.dispatch(ForceOfLaw {
            joint: self,
            contact,
            parts: self.parts(z),
            rates,
            record,
        })
    }

    /// [`System::force`] with a given separation rule and an optional record.
    pub(crate) fn force_by(
        &self,
        contact: Separation<'_>,
        record: Option<&mut [[f64; LANES]]>,
        z: &[f64],
        out: &mut [f64],
    ) {
        let m = self.omega.len();
        let power = self.contact_force(contact, record, z, out);
        if self.audit {
            out[m + self.friction_states()] = power + self.damping_power(&z[m..2 * m]);
        }
    }
}

/// The hot loop, compiled for the friction law.
struct ForceOfLaw<'a> {
    joint: &'a Joint,
    contact: Separation<'a>,
    parts: [&'a [f64]; 3],
    rates: &'a mut [f64],
    record: Option<&'a mut [[f64; LANES]]>,
}

impl WithLaw for ForceOfLaw<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_law<L: ContactLaw, const N: usize>(self, law: L) -> f64 {
        let joint = self.joint;
        macro_rules! pass {
            ($recorded:literal, $inputs:expr, $extras:literal) => {
                joint
                    .arch
                    .dispatch(ContactForceKernel::<L, $recorded, { $inputs }, $extras> {
                        node_law: joint.node_law(law, self.contact, self.parts),
                        steady: [&joint.equilibrium.force, &joint.steady_rates],
                        audited: joint.audit,
                        rates: self.rates,
                        record: self.record,
                    })
            };
        }
        let recorded = self.record.is_some();
        if const { L::IS_COMMON } && !joint.has_extras() {
            if recorded {
                pass!(true, N, false)
            } else {
                pass!(false, 0, false)
            }
        } else if recorded {
            pass!(true, N, true)
        } else {
            pass!(false, 0, true)
        }
    }
}

impl System for Joint {
    fn omega(&self) -> &[f64] {
        &self.omega
    }

    fn damping(&self) -> &[f64] {
        &self.damping
    }

    fn first_order(&self) -> usize {
        self.friction_states() + self.quadratures()
    }

    /// The work of the audit.
    fn quadratures(&self) -> usize {
        usize::from(self.audit)
    }

    fn force(&self, _t: f64, z: &[f64], out: &mut [f64]) {
        self.force_by(self.lift_off(), None, z, out);
    }

    fn non_finite_part(&self, _t: f64, z: &[f64]) -> Option<String> {
        let [q, v, states] = self.parts(z);
        let node = (0..self.nodes.count).find(|&node| {
            let action = self.node_action(node, q, v, states);
            let force = action.friction.iter().sum::<f64>() + action.normal;
            !force.is_finite()
        })?;
        Some(format!("contact node {node}"))
    }

    fn switching(&self) -> Option<&dyn Switching> {
        Some(self)
    }

    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }

    fn is_autonomous(&self) -> bool {
        true
    }
}
