//! Equilibria of a system: Newton iteration, linearisation with complex eigenvalues, modes that are followed over a
//! parameter, and the normal form of a Hopf bifurcation.
//!
//! All derivatives are exact products of the tangent flow ([`Differentiable::product`]) within the status of the
//! equilibrium, so that kinks next to it do not disturb them. Eigenvectors refer to the state in the scaled
//! coordinates `[omega q | dq/dt | w]`, whose first two parts have the same unit.

mod derivative;
mod multilinear;
mod normal_form;
mod tracks;

use faer::prelude::Solve;
use faer::{Mat, c64};

use super::system::{add_linear, energy_units};
use super::{Differentiable, System};

pub use derivative::derivative;
pub use normal_form::FirstLyapunov;
pub use tracks::{ModeTracks, TrackedMode};

/// Iterations of Newton's method.
const MAX_ITERATIONS: usize = 50;
/// Largest residual of an equilibrium relative to the sizes of the terms that cancel.
const RESIDUAL: f64 = 1e-12;
/// A rate that is zero: numbers of this size have no relative accuracy.
const TINY: f64 = 1e-280;
/// Relative distance from an eigenvalue at which inverse iteration factorises the matrix.
const SHIFT: f64 = 1e-9;

/// Error of the analysis of an equilibrium.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EquilibriumError {
    /// The law depends on time.
    #[error("a system driven in time has no equilibrium; set the amplitude of its drive to zero")]
    Driven,
    /// The system does not supply its derivative.
    #[error("the system does not supply the derivative of its force")]
    NoDerivative,
    /// Newton's method did not converge.
    #[error(
        "Newton's method found no equilibrium: the residual was {residual:e} after {MAX_ITERATIONS} iterations"
    )]
    NotConverged {
        /// Residual in scaled coordinates.
        residual: f64,
    },
    /// The eigenvalue iteration did not converge.
    #[error(
        "the eigenvalues of the linearised system did not converge; check the scene for extreme stiffness or friction \
         slopes"
    )]
    Eigenvalues,
    /// A mode without oscillation has no Hopf bifurcation.
    #[error("a mode without oscillation has no Hopf bifurcation")]
    NoOscillation,
}

/// A system linearised in a state, such as an equilibrium.
#[derive(Clone, Debug)]
pub struct Linearised {
    /// The state, without quadratures.
    pub state: Vec<f64>,
    /// Its status, if the system has any.
    pub(super) status: Option<Vec<u8>>,
    /// Factors from the state to the scaled coordinates.
    pub scale: Vec<f64>,
    /// The Jacobian in scaled coordinates, 1/s.
    pub matrix: Mat<f64>,
}

/// The Jacobian `dF/dz` of a system, with its workspace.
#[derive(Clone, Debug)]
pub struct Jacobian {
    record: Vec<f64>,
    force: Vec<f64>,
    identity: Vec<f64>,
    rows: Vec<f64>,
}

impl Jacobian {
    /// Workspace for a system.
    pub fn new(law: &dyn Differentiable) -> Self {
        let dim = law.tangent_dim();
        let mut identity = vec![0.0; dim * dim];
        identity.iter_mut().step_by(dim + 1).for_each(|x| *x = 1.0);
        Self {
            record: vec![0.0; law.record_len()],
            force: vec![0.0; law.dim() - law.modes()],
            identity,
            rows: vec![0.0; dim * dim],
        }
    }

    /// Evaluates the Jacobian of that system in a state `z` (length [`System::dim`]) at time `t` (s). Returns it row by row,
    /// of [`System::tangent_dim`] rows and columns.
    pub fn at(
        &mut self,
        law: &dyn Differentiable,
        status: Option<&[u8]>,
        t: f64,
        z: &[f64],
    ) -> &[f64] {
        let (m, dim) = (law.modes(), law.tangent_dim());
        law.force_recorded(status, t, z, &mut self.force, &mut self.record);
        let below = &mut self.rows[m * dim..];
        law.product(status, &mut self.record, &self.identity, dim, below);
        let (omega, damping) = (law.omega(), law.damping());
        add_linear(omega, damping, &self.identity, &mut self.rows, dim);
        &self.rows
    }
}

/// An eigenvalue with its right eigenvector.
#[derive(Clone, Debug, PartialEq)]
pub struct Eigenmode {
    /// The eigenvalue: growth rate (1/s) and angular frequency (rad/s).
    pub value: c64,
    /// Right eigenvector in scaled coordinates, of length 1.
    pub vector: Vec<c64>,
}

impl Linearised {
    /// Finds the equilibrium next to `guess` (length [`System::dim`]) and linearises the system there.
    ///
    /// # Errors
    /// If the system is driven in time or has no derivative, or Newton's method does not converge.
    pub fn new(system: &dyn System, guess: &[f64]) -> Result<Self, EquilibriumError> {
        if !system.is_autonomous() {
            return Err(EquilibriumError::Driven);
        }
        let law = system
            .differentiable()
            .ok_or(EquilibriumError::NoDerivative)?;
        let (m, dim) = (system.modes(), system.tangent_dim());
        let mut z = guess.to_vec();
        let mut rate = vec![0.0; system.dim()];
        let mut residual = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            system.rhs(0.0, &z, &mut rate);
            let found = Self::at(law, status_at(system, &z), 0.0, &z);
            let (matrix, scale) = (&found.matrix, &found.scale);
            // Each component relative to the sum of the terms that cancel in it, as far as they are known.
            let size = |i: usize| -> f64 {
                let terms = (0..dim).map(|j| (matrix[(i, j)] * scale[j] * z[j]).abs());
                terms.sum::<f64>().max(f64::MIN_POSITIVE)
            };
            let ratios = (0..dim).map(|i| (rate[i] * scale[i]).abs() / size(i));
            residual = ratios.fold(0.0, f64::max);
            let is_zero = rate[..dim].iter().all(|rate| rate.abs() < TINY);
            if is_zero || residual < RESIDUAL {
                return Ok(found);
            }
            let right = Mat::from_fn(dim, 1, |i, _| -rate[i] * scale[i]);
            let step = matrix.partial_piv_lu().solve(&right);
            for i in 0..dim {
                z[i] += step[(i, 0)] / scale[i];
            }
            // An equilibrium of oscillators is at rest, exactly.
            z[m..2 * m].fill(0.0);
            if z.iter().any(|x| !x.is_finite()) {
                break;
            }
        }
        Err(EquilibriumError::NotConverged { residual })
    }

    /// Linearises a system in a state `z` (length [`System::dim`]) at time `t` (s), which need not be an equilibrium.
    pub fn at(law: &dyn Differentiable, status: Option<Vec<u8>>, t: f64, z: &[f64]) -> Self {
        let scale = energy_units(law);
        let dim = scale.len();
        let mut jacobian = Jacobian::new(law);
        let rows = jacobian.at(law, status.as_deref(), t, z);
        Self {
            state: z[..dim].to_vec(),
            status,
            matrix: Mat::from_fn(dim, dim, |i, j| rows[i * dim + j] * scale[i] / scale[j]),
            scale,
        }
    }

    /// Number of coordinates.
    pub fn dim(&self) -> usize {
        self.scale.len()
    }

    /// The modes of the linearised system: [`eigenmodes`].
    ///
    /// # Errors
    /// [`EquilibriumError::Eigenvalues`].
    pub fn modes(&self) -> Result<Vec<Eigenmode>, EquilibriumError> {
        eigenmodes(&self.matrix)
    }

    /// The left eigenvector `y` of a mode with the right eigenvector `x`: `y* A = lambda y*`, `y* x = 1`, by inverse
    /// iteration.
    pub fn left(&self, mode: &Eigenmode) -> Vec<c64> {
        let dim = self.dim();
        let size = mode.value.norm().max(1e-300);
        let shifted = mode.value + c64::new(SHIFT * size, SHIFT * size);
        let adjoint = Mat::from_fn(dim, dim, |i, j| {
            let entry = c64::new(self.matrix[(j, i)], 0.0);
            if i == j {
                entry - shifted.conj()
            } else {
                entry
            }
        });
        let factors = adjoint.partial_piv_lu();
        let mut left = mode.vector.clone();
        for _ in 0..4 {
            let right = Mat::from_fn(dim, 1, |i, _| left[i]);
            let next = factors.solve(&right);
            left = unit((0..dim).map(|i| next[(i, 0)]).collect());
        }
        let product = inner(&left, &mode.vector).conj();
        left.iter().map(|y| *y / product).collect()
    }
}

/// All eigenvalues of a real matrix with non-negative imaginary part and their eigenvectors, in descending order of the
/// growth rate.
///
/// # Errors
/// [`EquilibriumError::Eigenvalues`].
pub fn eigenmodes(matrix: &Mat<f64>) -> Result<Vec<Eigenmode>, EquilibriumError> {
    let eigen = matrix.eigen().map_err(|_| EquilibriumError::Eigenvalues)?;
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    let shown = (0..matrix.nrows()).filter(|&k| values[k].im >= 0.0);
    let mut modes: Vec<Eigenmode> = shown
        .map(|k| Eigenmode {
            value: values[k],
            vector: unit(vectors.col(k).iter().copied().collect()),
        })
        .collect();
    modes.sort_by(|a, b| b.value.re.total_cmp(&a.value.re));
    Ok(modes)
}

/// Derivative of an eigenvalue with a parameter, `y* (dA/dp) x`, from its left and right eigenvectors and the
/// derivative of the scaled matrix.
pub fn eigenvalue_derivative(left: &[c64], slope: &Mat<f64>, right: &[c64]) -> c64 {
    let rows = left.iter().enumerate().map(|(i, y)| {
        let row = right.iter().enumerate().map(|(j, x)| *x * slope[(i, j)]);
        y.conj() * row.sum::<c64>()
    });
    rows.sum()
}

/// Status of a state, if the system has any.
fn status_at(system: &dyn System, z: &[f64]) -> Option<Vec<u8>> {
    let switching = system.switching()?;
    let mut status = vec![0; switching.status_len()];
    switching.status_of(0.0, z, &mut status);
    Some(status)
}

/// `a* b`.
fn inner(a: &[c64], b: &[c64]) -> c64 {
    a.iter().zip(b).map(|(a, b)| a.conj() * *b).sum()
}

/// A vector of length 1.
fn unit(vector: Vec<c64>) -> Vec<c64> {
    let size = inner(&vector, &vector).re.sqrt();
    vector.into_iter().map(|x| x / size).collect()
}

impl Eigenmode {
    /// Correlation of the shapes of two modes, 0 to 1 (modal assurance criterion).
    pub fn correlation(&self, other: &Self) -> f64 {
        inner(&self.vector, &other.vector).norm_sqr()
    }

    /// Frequency, Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.value.im / std::f64::consts::TAU
    }

    /// Whether the mode oscillates.
    pub fn oscillates(&self) -> bool {
        self.value.im > 0.0
    }
}
