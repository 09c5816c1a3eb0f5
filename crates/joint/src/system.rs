//! The joint at one tilt as a dynamical system for the integrators.

use std::marker::PhantomData;
use std::sync::Arc;

use pulp::Arch;

use super::contact_force::{
    AsRequired, ContactForceKernel, Force, KernelInput, KernelOutput, Record, SeparatedNodes,
};
use super::dynamic_friction::DynamicFriction;
use super::evolving::{Evolving, EvolvingKernel, SteadyStates};
use super::friction::FrictionLaw;
use super::friction_kernel::{Curve, Custom, Frictionless};
use super::nodes::Nodes;
use super::separation::Separation;
use super::simd::LANES;
use super::{ContactDamping, Friction, MAX_MODES, Model};
use squeakscope_dynamics::{Differentiable, Switching, System};

/// The friction law of a joint.
#[derive(Clone, Debug)]
pub(crate) enum ActiveLaw {
    /// A law of a model.
    Known(Friction),
    /// A law implemented by the user.
    Custom {
        law: Arc<dyn FrictionLaw>,
        radial: bool,
    },
}

impl ActiveLaw {
    /// The law of the slip velocity alone as a trait object, for kernels that evaluate one node at a time.
    pub fn law(&self) -> Option<&dyn FrictionLaw> {
        match self {
            Self::Known(friction) => friction.law(),
            Self::Custom { law, .. } => Some(law.as_ref()),
        }
    }

    /// Whether friction includes the radial slip velocity.
    pub fn radial(&self) -> bool {
        match self {
            Self::Known(friction) => friction.radial(),
            Self::Custom { radial, .. } => *radial,
        }
    }
}

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
    pub(crate) law: ActiveLaw,
    /// States of friction in steady sliding, one per node; empty for a law of the slip velocity alone.
    steady_states: SteadyStates,
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
        Self::build(model, ActiveLaw::Known(model.friction.clone()))
    }

    /// Builds the joint of a model with a custom friction law; `radial` includes the radial slip velocity,
    /// as in Eq. (8).
    ///
    /// # Panics
    /// As [`Joint::new`].
    pub fn with_friction(model: &Model, law: Arc<dyn FrictionLaw>, radial: bool) -> Self {
        Self::build(model, ActiveLaw::Custom { law, radial })
    }

    fn build(model: &Model, law: ActiveLaw) -> Self {
        let m = model.modes();
        assert!(m <= MAX_MODES, "at most {MAX_MODES} modes, not {m}");
        assert_eq!(
            model.shapes.len(),
            model.nodes() * m,
            "shapes are nodes x modes"
        );
        let nodes = Nodes::new(model);
        let steady_states = match &law {
            ActiveLaw::Known(Friction::Dynamic { law, .. }) => SteadyStates::new(law, &nodes),
            _ => SteadyStates::default(),
        };
        let mut joint = Self {
            law,
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

    /// Computes the equilibrium and the steady friction of the nodes.
    fn find_equilibrium(&mut self) {
        let omega = self.omega().to_vec();
        let rest = vec![0.0; 2 * omega.len() + self.friction_states()];
        let mut out = vec![0.0; omega.len() + self.friction_states()];
        // With the kernel of the hot loop, so that the subtraction is exact there.
        let input = KernelInput {
            contact: self.lift_off(),
            record: None,
            audited: false,
            z: &rest,
            out: &mut out,
        };
        self.contact_force(input);
        for node in 0..self.nodes.count {
            let (block, lane) = (&self.nodes.blocks[node / LANES], node % LANES);
            let speed = block.speed.0[lane];
            let normal = block.area.0[lane] * block.pre_stress.0[lane];
            let friction = match self.evolving() {
                Some(evolving) => -normal * evolving.steady_coefficient(node, speed),
                None => {
                    let law = self.law.law();
                    law.map_or(0.0, |law| -normal * law.ratio(speed).value * speed)
                }
            };
            self.nodes.blocks[node / LANES].steady_friction.0[lane] = friction;
        }
        out.truncate(omega.len());
        let q = out.iter().zip(&omega).map(|(f, w)| f / (w * w)).collect();
        self.equilibrium = Equilibrium { force: out, q };
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

    /// The friction law with states at the nodes, if the law has states.
    pub(super) fn evolving(&self) -> Option<Evolving<'_>> {
        match &self.law {
            ActiveLaw::Known(Friction::Dynamic { law, radial }) => {
                Some(Evolving::new(law, *radial, &self.steady_states))
            }
            _ => None,
        }
    }

    /// Number of states of the friction law at all nodes; zero for a law of the slip velocity alone.
    pub fn friction_states(&self) -> usize {
        self.evolving().map_or(0, Evolving::len)
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
        if let (Some(from), Some(to)) = (self.evolving(), other.evolving()) {
            let states = &mut z[2 * self.omega.len()..][..from.len()];
            from.carried(to, [&self.nodes.frames, &other.nodes.frames], states);
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

    /// Whether the model has contact damping or the term `Omega x u`.
    pub(crate) fn has_optional_terms(&self) -> bool {
        !self.contact_damping.is_none() || !self.nodes.convected.is_empty()
    }

    /// The separation rule without a fixed status.
    pub(crate) fn lift_off(&self) -> Separation<'static> {
        if self.unilateral {
            Separation::ByGap
        } else {
            Separation::Never
        }
    }

    /// The right side of Eq. (8) minus that of steady sliding.
    pub(crate) fn contact_force(&self, mut query: KernelInput<'_>) -> KernelOutput {
        macro_rules! pass {
            (any $law:expr) => {
                match self.has_optional_terms() {
                    false => pass!($law, AsRequired<false>),
                    true => pass!($law, AsRequired<true>),
                }
            };
            ($law:expr) => {
                match (
                    self.has_optional_terms(),
                    query.audited,
                    query.record.is_some(),
                ) {
                    (false, false, false) => pass!($law, Force),
                    (false, false, true) => pass!($law, Record),
                    _ => pass!(any $law),
                }
            };
            ($law:expr, $task:ty) => {
                self.arch.dispatch(ContactForceKernel {
                    nodes: &self.nodes,
                    law: $law,
                    task: PhantomData::<$task>,
                    damping: self.contact_damping,
                    steady: &self.equilibrium.force,
                    query: &mut query,
                })
            };
        }
        match &self.law {
            ActiveLaw::Known(Friction::None) => pass!(Frictionless),
            ActiveLaw::Known(Friction::Constant { law, radial: true }) => {
                pass!(Curve::<_, true>(*law))
            }
            ActiveLaw::Known(Friction::Constant { law, radial: false }) => {
                pass!(Curve::<_, false>(*law))
            }
            ActiveLaw::Known(Friction::Stribeck { law, radial: true }) => {
                pass!(Curve::<_, true>(*law))
            }
            ActiveLaw::Known(Friction::Stribeck { law, radial: false }) => {
                pass!(Curve::<_, false>(*law))
            }
            ActiveLaw::Known(Friction::Table { law, radial: true }) => {
                pass!(any Curve::<_, true>(law.as_ref()))
            }
            ActiveLaw::Known(Friction::Table { law, radial: false }) => {
                pass!(any Curve::<_, false>(law.as_ref()))
            }
            ActiveLaw::Known(Friction::Dynamic { law, radial }) => {
                self.force_with_states(law, *radial, query)
            }
            ActiveLaw::Custom { law, radial } => pass!(any Custom {
                law: law.as_ref(),
                radial: *radial,
            }),
        }
    }

    /// [`Joint::contact_force`] with a law that has states; apart, so that it takes no registers from the others.
    #[inline(never)]
    fn force_with_states(
        &self,
        law: &DynamicFriction,
        radial: bool,
        query: KernelInput<'_>,
    ) -> KernelOutput {
        self.arch.dispatch(EvolvingKernel {
            nodes: &self.nodes,
            evolving: Evolving::new(law, radial, &self.steady_states),
            damping: self.contact_damping,
            steady: &self.equilibrium.force,
            query,
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
        let passed = self.contact_force(KernelInput {
            contact,
            record,
            audited: self.audit,
            z,
            out,
        });
        if self.audit {
            out[m + self.friction_states()] = passed.power + self.damping_power(&z[m..2 * m]);
        }
    }

    /// Writes the status at modal coordinates `q`: one bit per node, set for separated nodes, eight nodes
    /// per byte.
    pub fn separated_nodes(&self, q: &[f64], status: &mut [u8]) {
        self.arch.dispatch(SeparatedNodes {
            nodes: &self.nodes,
            q,
            status,
        });
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
