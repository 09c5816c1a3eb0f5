//! Decomposition of the growth rates of steady sliding by the terms of the linearised Eq. (8).
//!
//! Eq. (8) linearised at steady sliding is `q'' + C q' + (W^2 + K) q = 0` with the perturbation `u = Phi q`.
//! The terms of each node are, with area `dA`, pre-stress `p`, contact stiffness `k`, slip velocity `V = V t`
//! and outward normal `e`:
//!
//! | term | expression | effect |
//! |---|---|---|
//! | slope | `C += p dmu/dV dA Phi^T t t^T Phi` | excites if friction decreases with speed |
//! | direction | `C += p (mu / V) dA Phi^T (1 - t t^T) Phi` | damps motion normal to the sliding direction |
//! | structure | `C += 2 zeta omega` | damps |
//! | contact | `K += k dA Phi^T e e^T Phi` | elastic, conservative |
//! | coupling | `K += k mu dA Phi^T t e^T Phi` | non-symmetric: the friction force follows the normal force; excites or damps |
//! | contact damping | `C += c dA Phi^T (e + mu t) e^T Phi` | damps; `c` is `k tau` or `p chi` |
//! | convection | `K += p dA Phi^T ((mu / V) (1 - t t^T) + dmu/dV t t^T) (Omega x Phi)` | if the slip velocity includes `Omega x u` |
//!
//! The growth rate is decomposed in two ways. The *share* of a term is the power that it supplies to the
//! mode divided by twice the energy of the mode. It follows from the imaginary part of `v* (lambda^2 +
//! lambda C + W^2 + K) v = 0` divided by `2 omega v*v`, which gives exactly `growth = sum of shares`; a
//! non-symmetric `C` contributes `growth Im(v* C v)` to its share. The growth rate *without* a term
//! accounts for the change of the mode shape; the mode is followed by continuation while the term decreases
//! to zero.

use faer::{Mat, Scale, c64};
use schemars::JsonSchema;
use serde::Serialize;
use strum::VariantArray;

use super::nodes::Rows;
use super::simd::LANES;
use super::{Joint, Model, is_unstable};
use squeakscope_dynamics::equilibrium::{Eigenmode, EquilibriumError, eigenmodes};
use squeakscope_dynamics::{Differentiable, System};

/// Terms that can excite or damp a mode.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, strum::VariantArray, strum::IntoStaticStr,
)]
#[serde(into = "&'static str")]
pub enum Cause {
    /// Slope of the friction law at the sliding speed, in the sliding direction.
    #[strum(serialize = "negative slope")]
    Slope,
    /// Dependence of the friction force on the normal force (mode coupling).
    #[strum(serialize = "mode coupling")]
    Coupling,
    /// Change of direction of the friction force with the slip velocity; damps motion normal to sliding.
    #[strum(serialize = "friction damping")]
    Direction,
    /// Modal damping of the body.
    #[strum(serialize = "structural damping")]
    Structure,
    /// Damping of the normal contact.
    #[strum(serialize = "contact damping")]
    ContactDamping,
    /// Convective term `Omega x u` of the slip velocity.
    #[strum(serialize = "Omega x u")]
    Convection,
}

impl Cause {
    /// All terms.
    pub const ALL: &[Self] = Self::VARIANTS;

    /// Name in reports and JSON.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Whether a model contains the term.
    fn is_in(self, model: &Model) -> bool {
        match self {
            Self::Slope | Self::Coupling | Self::Direction | Self::Structure => true,
            Self::ContactDamping => !model.contact_damping.is_none(),
            Self::Convection => model.convection.is_some(),
        }
    }

    /// Whether the term is part of the stiffness matrix, not of the damping matrix.
    fn is_stiffness(self) -> bool {
        matches!(self, Self::Coupling | Self::Convection)
    }
}

/// Effect of one term on the growth rate of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CauseOfGrowth {
    /// The term: `negative slope`, `mode coupling`, `friction damping`, `structural damping`, `contact damping` or
    /// `Omega x u`.
    #[schemars(with = "String")]
    pub cause: Cause,
    /// Share of the growth rate, 1/s. The shares of all terms sum to the growth rate.
    pub share_per_s: f64,
    /// Growth rate of the mode without the term, 1/s.
    pub without_per_s: f64,
}

/// A mode whose growth rate is explained by its causes.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ExplainedMode {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Growth rate, 1/s.
    pub growth_per_s: f64,
    /// Causes of growth: the contribution of each term of the model, in the order of [`Cause::ALL`].
    pub causes: Vec<CauseOfGrowth>,
}

impl ExplainedMode {
    /// As [`LinearMode::unstable`](super::LinearMode::unstable).
    pub fn unstable(&self) -> bool {
        is_unstable(self.growth_per_s, std::f64::consts::TAU * self.frequency_hz)
    }
}

/// Number of continuation steps in which a term decreases to zero.
const CONTINUATION_STEPS: usize = 8;

/// The matrices of the linearised equation, by term.
struct Terms {
    modes: usize,
    /// `W^2` plus contact stiffness.
    stiffness: Mat<f64>,
    /// In the order of [`Cause::ALL`].
    terms: [Mat<f64>; Cause::ALL.len()],
}

impl Model {
    /// Returns the oscillating modes of steady sliding with the decomposition of their growth rates, in
    /// ascending order of frequency. Overdamped modes are omitted. Empty for a friction law with states, whose part
    /// in the growth is not one of the causes.
    ///
    /// # Errors
    /// If an eigenvalue iteration does not converge.
    pub fn explained_modes(&self) -> Result<Vec<ExplainedMode>, EquilibriumError> {
        if self.friction.states() > 0 {
            return Ok(Vec::new());
        }
        let terms = Terms::of(self);
        let mut all = terms.roots(None)?;
        all.sort_by(|a, b| {
            let by_frequency = a.value.im.total_cmp(&b.value.im);
            by_frequency.then(a.value.re.total_cmp(&b.value.re))
        });
        let modes = all.into_iter().map(|root| {
            let in_model = Cause::ALL.iter().enumerate();
            let in_model = in_model.filter(|(_, cause)| cause.is_in(self));
            let causes = in_model.map(|(k, cause)| {
                Ok(CauseOfGrowth {
                    cause: *cause,
                    share_per_s: terms.share(k, &root),
                    without_per_s: terms.without(k, &root)?,
                })
            });
            Ok(ExplainedMode {
                frequency_hz: root.value.im / std::f64::consts::TAU,
                growth_per_s: root.value.re,
                causes: causes.collect::<Result<_, _>>()?,
            })
        });
        modes.collect()
    }
}

impl Terms {
    fn of(model: &Model) -> Self {
        let m = model.modes();
        let mut stiffness = Mat::zeros(m, m);
        let mut terms: [Mat<f64>; Cause::ALL.len()] = std::array::from_fn(|_| Mat::zeros(m, m));
        for i in 0..m {
            stiffness[(i, i)] = model.omega[i].powi(2);
            if let Some(ratio) = model.damping.get(i) {
                terms[3][(i, i)] = 2.0 * ratio * model.omega[i];
            }
        }
        let mut all = Self {
            modes: m,
            stiffness,
            terms,
        };
        let joint = Joint::new(model);
        let mut record = vec![0.0; joint.record_len()];
        let mut force = vec![0.0; joint.dim() - m];
        joint.force_recorded(None, 0.0, &vec![0.0; joint.dim()], &mut force, &mut record);
        for node in 0..joint.contact_nodes() {
            all.add_node(&joint, node, |axis, input| {
                joint.node_slope(&record, node, axis, input)
            });
        }
        all
    }

    /// Adds the contribution of a node, whose negative force along the axes of its sliding frame has these derivatives: with
    /// respect to radial displacement, approach velocity and slip velocity.
    fn add_node(&mut self, joint: &Joint, node: usize, slope: impl Fn(usize, usize) -> f64) {
        const OUTWARD: usize = 2;
        let (nodes, block, lane) = (&joint.nodes, node / LANES, node % LANES);
        let component = |rows: &[Rows], axis: usize| -> Vec<f64> {
            let of_axis = |row: &Rows| [&row.s, &row.t, &row.r][axis].0[lane];
            rows.iter().map(of_axis).collect()
        };
        let rows = &nodes.rows[block * self.modes..][..self.modes];
        let shapes = [0, 1, 2].map(|axis| component(rows, axis));
        let convected = nodes.convected_rows(block);
        let [slopes, coupling, direction, _, damping, convection] = &mut self.terms;
        let [along, _, outward] = &shapes;
        add(&mut self.stiffness, slope(OUTWARD, 0), outward, outward);
        add(damping, slope(OUTWARD, 1), outward, outward);
        if joint.friction_inputs() == 0 {
            return;
        }
        // Steady friction acts along the first axis.
        add(coupling, slope(0, 0), along, outward);
        add(damping, slope(0, 1), along, outward);
        for (axis, shape) in shapes.iter().enumerate() {
            let by_slip = slope(axis, 2 + axis);
            let term = if axis == 0 {
                &mut *slopes
            } else {
                &mut *direction
            };
            add(term, by_slip, shape, shape);
            if !convected.is_empty() {
                add(convection, by_slip, shape, &component(convected, axis));
            }
        }
    }

    /// Eigenvalues with `omega > 0`; `faded` scales one term by a factor.
    fn roots(&self, faded: Option<(usize, f64)>) -> Result<Vec<Eigenmode>, EquilibriumError> {
        let m = self.modes;
        let (mut stiffness, mut damping) = (self.stiffness.clone(), Mat::zeros(m, m));
        for (term, (cause, matrix)) in Cause::ALL.iter().zip(&self.terms).enumerate() {
            let weight = faded.map_or(
                1.0,
                |(which, share)| if which == term { share } else { 1.0 },
            );
            let sum = if cause.is_stiffness() {
                &mut stiffness
            } else {
                &mut damping
            };
            *sum += Scale(weight) * matrix;
        }
        // The state [omega q | dq/dt] has components of similar size.
        let scale: Vec<f64> = (0..m).map(|i| self.stiffness[(i, i)].sqrt()).collect();
        let matrix = Mat::from_fn(2 * m, 2 * m, |i, j| {
            match (i.checked_sub(m), j.checked_sub(m)) {
                (None, None) => 0.0,
                (None, Some(j)) => f64::from(u8::from(i == j)) * scale[i],
                (Some(i), None) => -stiffness[(i, j)] / scale[j],
                (Some(i), Some(j)) => -damping[(i, j)],
            }
        });
        let modes = eigenmodes(&matrix)?;
        Ok(modes.into_iter().filter(Eigenmode::oscillates).collect())
    }

    /// The shape of a mode in modal coordinates.
    fn shape(&self, root: &Eigenmode) -> Vec<c64> {
        let shape = root.vector[..self.modes].iter().enumerate();
        shape
            .map(|(i, x)| x / self.stiffness[(i, i)].sqrt())
            .collect()
    }

    /// Power that a term supplies to a mode, divided by twice its energy, 1/s.
    fn share(&self, term: usize, root: &Eigenmode) -> f64 {
        let shape = self.shape(root);
        let matrix = &self.terms[term];
        let mut product = c64::new(0.0, 0.0);
        for i in 0..self.modes {
            for j in 0..self.modes {
                product += shape[i].conj() * shape[j] * matrix[(i, j)];
            }
        }
        let size: f64 = shape.iter().map(|v| v.norm_sqr()).sum();
        let turned = product.im / root.value.im;
        if Cause::ALL[term].is_stiffness() {
            -turned / (2.0 * size)
        } else {
            -(product.re + root.value.re * turned) / (2.0 * size)
        }
    }

    /// Growth rate of a mode after a term has decreased to zero.
    fn without(&self, term: usize, root: &Eigenmode) -> Result<f64, EquilibriumError> {
        let mut last = root.clone();
        for step in 1..=CONTINUATION_STEPS {
            let share = 1.0 - step as f64 / CONTINUATION_STEPS as f64;
            let roots = self.roots(Some((term, share)))?.into_iter();
            let alike = |other: &Eigenmode| other.correlation(&last);
            let Some(next) = roots.max_by(|a, b| alike(a).total_cmp(&alike(b))) else {
                break;
            };
            last = next;
        }
        Ok(last.value.re)
    }
}

/// Adds `factor a b^T` to a matrix.
fn add(matrix: &mut Mat<f64>, factor: f64, a: &[f64], b: &[f64]) {
    for (i, a) in a.iter().enumerate() {
        for (j, b) in b.iter().enumerate() {
            matrix[(i, j)] += factor * a * b;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::scattered;
    use crate::{ContactDamping, Friction};

    const STRIBECK: crate::Stribeck = crate::Stribeck {
        mu_s: 0.55,
        mu_d: 0.25,
        creep: 1000.0,
        stribeck: 10.0,
    };

    fn friction(radial: bool) -> Friction {
        Friction::Stribeck {
            law: STRIBECK,
            radial,
        }
    }

    #[test]
    fn the_terms_make_the_jacobian_and_the_shares_the_growth() {
        for (k, friction) in [friction(true), friction(false), Friction::None]
            .into_iter()
            .cycle()
            .take(9)
            .enumerate()
        {
            let mut model = scattered(40, 6, friction);
            model.contact_damping = [
                ContactDamping::None,
                ContactDamping::KelvinVoigt { time: 2e-7 },
                ContactDamping::HuntCrossley { dissipation: 0.5 },
            ][k / 3];
            // Much larger than for a real joint, so that the effect is measurable.
            model.convection = (k > 2).then_some([700.0, -300.0, 200.0]);
            let all = Joint::new(&model).linear_modes().unwrap();
            let oscillating = all.iter().filter(|mode| mode.frequency_hz > 0.0);
            let explained = model.explained_modes().unwrap();
            assert_eq!(oscillating.clone().count(), explained.len());
            for (mode, explained) in oscillating.zip(explained) {
                let size = std::f64::consts::TAU * mode.frequency_hz;
                let scale = size + mode.growth.abs();
                assert!((mode.frequency_hz / explained.frequency_hz - 1.0).abs() < 1e-9);
                assert!(
                    (mode.growth - explained.growth_per_s).abs() < 1e-9 * scale,
                    "{explained:?}"
                );
                let shares: f64 = explained.causes.iter().map(|cause| cause.share_per_s).sum();
                assert!(
                    (shares - mode.growth).abs() < 1e-9 * scale,
                    "{shares} {explained:?}"
                );
            }
        }
    }

    #[test]
    fn damping_of_one_ratio_is_all_that_a_free_body_has() {
        let mut model = scattered(3, 4, Friction::None);
        model.damping = vec![0.01; 4];
        model.stiffness.fill(0.0);
        for mode in model.explained_modes().unwrap() {
            let omega_0 = std::f64::consts::TAU * mode.frequency_hz / (1.0 - 1e-4_f64).sqrt();
            assert!((mode.growth_per_s / (-0.01 * omega_0) - 1.0).abs() < 1e-9);
            assert!((mode.causes[3].share_per_s / mode.growth_per_s - 1.0).abs() < 1e-9);
            assert!(mode.causes[3].without_per_s.abs() < 1e-9 * omega_0);
            assert!(
                mode.causes[..3]
                    .iter()
                    .all(|cause| cause.share_per_s == 0.0)
            );
        }
    }

    #[test]
    fn coupling_alone_is_flutter() {
        // Two modes and one node with constant friction, without damping.
        let mut model = scattered(1, 2, friction(true));
        model.normals = vec![[0.0, 0.0, 1.0]];
        model.sliding_velocity = vec![[0.02, 0.0, 0.0]];
        model.shapes = vec![[1.0, 0.0, 0.3], [-3.0, 0.0, 1.0]];
        model.areas = vec![1e-6];
        model.stiffness = vec![1e13];
        model.pre_stress = vec![1e-9];
        model.damping = Vec::new();
        let (k, mu) = (1e7, STRIBECK.coefficient(0.02));
        let mut seen = [false; 2];
        for omega in [[3000.0, 4074.0], [3000.0, 6000.0]] {
            model.omega = omega.to_vec();
            let modes = model.explained_modes().unwrap();
            let growing: Vec<_> = modes
                .iter()
                .filter(|mode| mode.growth_per_s > 1.0)
                .collect();
            // The discriminant of the characteristic polynomial is negative for flutter.
            let a = omega[0].powi(2) + k * 0.3 * (0.3 + mu);
            let b = omega[1].powi(2) + k * (1.0 - 3.0 * mu);
            let product = k * (0.3 + mu) * k * 0.3 * (1.0 - 3.0 * mu);
            let flutters = (a - b).powi(2) + 4.0 * product < 0.0;
            assert_eq!(flutters, !growing.is_empty(), "{omega:?}");
            seen[usize::from(flutters)] = true;
            for mode in growing {
                let coupling = mode.causes[1];
                assert!(
                    (coupling.share_per_s / mode.growth_per_s - 1.0).abs() < 1e-6,
                    "{mode:?}"
                );
                assert!(coupling.without_per_s.abs() < 1e-3 * mode.growth_per_s);
            }
        }
        assert_eq!(seen, [true, true]);
    }
}
