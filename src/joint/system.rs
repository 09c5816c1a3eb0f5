//! The joint at one tilt, as a system that an integrator can run.

use std::marker::PhantomData;
use std::sync::Arc;

use pulp::Arch;

use super::friction::{Constant, FrictionLaw, Stribeck};
use super::lanes::LANES;
use super::law::{Custom, Frictionless, Level, Smoothed};
use super::lift_off::LiftOff;
use super::nodes::Nodes;
use super::traction::{Audit, Extras, Force, OpenNodes, Passed, Query, Record, Traction};
use super::{ContactDamping, Friction, MOST_MODES, Model};
use crate::dynamics::{Differentiable, Switching, System};

/// The law of friction in force.
#[derive(Clone, Debug)]
pub(crate) enum ActiveLaw {
    None,
    Constant {
        law: Constant,
        radial: bool,
    },
    Stribeck {
        law: Stribeck,
        radial: bool,
    },
    Custom {
        law: Arc<dyn FrictionLaw>,
        radial: bool,
    },
}

impl ActiveLaw {
    /// The law as seen by the passes that need slopes, one node at a time.
    pub fn law(&self) -> Option<&dyn FrictionLaw> {
        match self {
            Self::None => None,
            Self::Constant { law, .. } => Some(law),
            Self::Stribeck { law, .. } => Some(law),
            Self::Custom { law, .. } => Some(law.as_ref()),
        }
    }

    /// Whether the radial velocity takes part.
    pub fn radial(&self) -> bool {
        match self {
            Self::None => false,
            Self::Constant { radial, .. }
            | Self::Stribeck { radial, .. }
            | Self::Custom { radial, .. } => *radial,
        }
    }
}

impl From<Friction> for ActiveLaw {
    fn from(friction: Friction) -> Self {
        match friction {
            Friction::None => Self::None,
            Friction::Constant { law, radial } => Self::Constant { law, radial },
            Friction::Stribeck { law, radial } => Self::Stribeck { law, radial },
        }
    }
}

/// The steady-sliding equilibrium of Eq. (8): with `N = p_n` and `V = Omega x x` its right side is
/// constant, and `q_eq = force / omega^2`.
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibrium {
    /// Generalised force of contact and friction, `m`.
    pub force: Vec<f64>,
    /// Modal coordinates, `m`, sqrt(kg) m.
    pub q: Vec<f64>,
}

/// Eq. (8) at one tilt, in the perturbation from steady sliding: the state `z = 0` is the
/// equilibrium, to the last bit.
///
/// State: `[q | dq/dt | w]`, with the work `w` (J) of the non-conservative forces on the vibration
/// where the energy audit is on.
#[derive(Clone, Debug)]
pub struct Joint {
    pub(crate) nodes: Nodes,
    pub(crate) law: ActiveLaw,
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
    /// The joint of a model.
    ///
    /// # Panics
    /// If the model has more than 128 modes, or arrays whose lengths disagree.
    pub fn new(model: &Model) -> Self {
        Self::build(model, ActiveLaw::from(model.friction))
    }

    /// The same model with one's own law of friction; `radial` keeps the radial velocity in it, as
    /// Eq. (8) does.
    ///
    /// # Panics
    /// As [`Joint::new`].
    pub fn with_friction(model: &Model, law: Arc<dyn FrictionLaw>, radial: bool) -> Self {
        Self::build(model, ActiveLaw::Custom { law, radial })
    }

    fn build(model: &Model, law: ActiveLaw) -> Self {
        let m = model.modes();
        assert!(m <= MOST_MODES, "at most {MOST_MODES} modes, not {m}");
        assert_eq!(
            model.shapes.len(),
            model.nodes() * m,
            "shapes are nodes x modes"
        );
        let mut joint = Self {
            nodes: Nodes::new(model),
            law,
            unilateral: model.unilateral,
            contact_damping: model.contact_damping,
            omega: model.omega.clone(),
            damping: model.damping.clone(),
            probe: model.probe.clone(),
            // Until it is found nothing is taken off the forces.
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

    /// Finds the equilibrium while it is unknown yet, and leaves in the nodes their steady friction.
    fn find_equilibrium(&mut self) {
        let omega = self.omega().to_vec();
        let rest = vec![0.0; omega.len()];
        let mut force = rest.clone();
        // The very pass of the hot loop: what is subtracted there later is equal to the last bit.
        self.traction(Query {
            contact: self.lift_off(),
            record: None,
            audited: false,
            q: &rest,
            v: &rest,
            force: &mut force,
        });
        for block in &mut self.nodes.blocks {
            if let Some(law) = self.law.law() {
                for lane in 0..LANES {
                    let speed = block.speed.0[lane];
                    let normal = block.area.0[lane] * block.pre_stress.0[lane];
                    block.steady_friction.0[lane] = -normal * law.ratio(speed).value * speed;
                }
            }
        }
        let q = force.iter().zip(&omega).map(|(f, w)| f / (w * w)).collect();
        self.equilibrium = Equilibrium { force, q };
    }

    /// Switches the energy audit on: one more component of the state, the work `w`.
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

    /// Row that gives Eq. (24) from the modal coordinates, 1/sqrt(kg).
    pub fn probe(&self) -> &[f64] {
        &self.probe
    }

    /// Eq. (24): the displacement (m) of the central contact point in the sliding direction for
    /// modal coordinates `q`, or its velocity (m/s) for modal velocities.
    pub fn probe_value(&self, q: &[f64]) -> f64 {
        self.probe.iter().zip(q).map(|(a, b)| a * b).sum()
    }

    /// Whether the nodes do more than Eq. (2) and friction: damping of the contact, `Omega x u`.
    pub(crate) fn has_extras(&self) -> bool {
        !self.contact_damping.is_none() || !self.nodes.convected.is_empty()
    }

    /// Which nodes press, where no status is held.
    pub(crate) fn lift_off(&self) -> LiftOff<'static> {
        if self.unilateral {
            LiftOff::ByGap
        } else {
            LiftOff::Never
        }
    }

    /// The right side of Eq. (8), less that of steady sliding.
    pub(crate) fn traction(&self, mut query: Query<'_>) -> Passed {
        macro_rules! pass {
            ($law:expr) => {
                match (self.has_extras(), query.audited, query.record.is_some()) {
                    (true, _, _) => pass!($law, Extras),
                    (_, true, _) => pass!($law, Audit),
                    (_, _, true) => pass!($law, Record),
                    (_, _, _) => pass!($law, Force),
                }
            };
            ($law:expr, $task:ty) => {
                self.arch.dispatch(Traction {
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
            ActiveLaw::None => pass!(Frictionless),
            ActiveLaw::Constant { law, radial: true } => pass!(Level::<true>(*law)),
            ActiveLaw::Constant { law, radial: false } => pass!(Level::<false>(*law)),
            ActiveLaw::Stribeck { law, radial: true } => pass!(Smoothed::<true>(*law)),
            ActiveLaw::Stribeck { law, radial: false } => pass!(Smoothed::<false>(*law)),
            ActiveLaw::Custom { law, radial: true } => pass!(Custom::<true>(law.as_ref())),
            ActiveLaw::Custom { law, radial: false } => pass!(Custom::<false>(law.as_ref())),
        }
    }

    /// [`System::force`] with one's own rule of which nodes press, and with a record if wanted.
    pub(crate) fn force_by(
        &self,
        contact: LiftOff<'_>,
        record: Option<&mut [[f64; LANES]]>,
        z: &[f64],
        out: &mut [f64],
    ) {
        let m = self.omega.len();
        let (q, v) = (&z[..m], &z[m..2 * m]);
        let passed = self.traction(Query {
            contact,
            record,
            audited: self.audit,
            q,
            v,
            force: &mut out[..m],
        });
        if self.audit {
            out[m] = passed.power + self.damping_power(v);
        }
    }

    /// Which nodes are open at modal coordinates `q`: one bit a node, eight nodes a byte.
    pub fn open_nodes(&self, q: &[f64], open: &mut [u8]) {
        self.arch.dispatch(OpenNodes {
            nodes: &self.nodes,
            q,
            open,
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
        usize::from(self.audit)
    }

    /// The audit's work.
    fn quadratures(&self) -> usize {
        self.first_order()
    }

    fn force(&self, _t: f64, z: &[f64], out: &mut [f64]) {
        self.force_by(self.lift_off(), None, z, out);
    }

    fn part_at_fault(&self, _t: f64, z: &[f64]) -> Option<String> {
        let (q, v) = z[..2 * self.modes()].split_at(self.modes());
        let node = (0..self.nodes.count).find(|&node| {
            let action = self.node_action(node, q, v);
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
}
