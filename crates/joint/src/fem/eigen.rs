//! The lowest elastic eigenpairs of `K x = lambda M x`.
//!
//! Shift and invert: with `sigma < 0` the matrix `K - sigma M` is positive definite even though a free
//! body has rigid-body motions, so a sparse Cholesky factorisation exists. The operator `A = (K - sigma
//! M)^-1 M` is self-adjoint in the inner product of `M`, and the wanted pairs have its largest
//! eigenvalues `theta = 1 / (lambda - sigma)`. The Lanczos process builds an `M`-orthonormal basis with
//! full reorthogonalisation (Parlett, The Symmetric Eigenvalue Problem, 1998, ch. 13). The known
//! rigid-body motions are the first vectors of the basis and are excluded from the process. The results
//! are therefore elastic modes, and no frequency needs to be classified as "nearly zero". Within one
//! family all elastic frequencies are simple (bending pairs are two copies of one solution), as the
//! single-vector process requires.

use faer::prelude::Solve;
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{ColMut, Mat, Side};

use super::assembly::Pencil;
use super::{FemError, Harmonic};

/// Eigenpairs in ascending order.
#[derive(Clone, Debug)]
pub(super) struct Eigenpairs {
    /// Eigenvalues `lambda = omega^2`, rad^2/s^2.
    pub(super) values: Vec<f64>,
    /// Eigenvectors, `M`-orthonormal.
    pub(super) vectors: Vec<Vec<f64>>,
}

/// Convergence criterion: the residual of a Ritz pair in the norm of `M`, relative to `theta`. The
/// relative error of the eigenvalue is of the order of its square.
const TOLERANCE: f64 = 1e-12;
/// Maximum relative difference of an eigenvalue from the Rayleigh quotient of its vector. Their rounding errors differ,
/// so that a larger difference shows that the eigenvalue is lost in them.
const ROUNDING: f64 = 1e-4;
/// Lanczos steps between convergence checks.
const CHECK_INTERVAL: usize = 4;

/// Computes the `wanted` lowest elastic eigenpairs of a family with the linearly independent rigid-body motions `rigid`, with
/// the shift `sigma` (negative, rad^2/s^2).
///
/// # Errors
/// [`FemError::Modes`].
pub(super) fn lowest(
    pencil: &Pencil,
    harmonic: Harmonic,
    rigid: &[Vec<f64>],
    wanted: usize,
    shift: f64,
) -> Result<Eigenpairs, FemError> {
    let available = pencil.len().saturating_sub(rigid.len());
    if wanted > available {
        return Err(FemError::Modes(format!(
            "{wanted} {harmonic} modes requested, but the mesh resolves only {available}: request fewer, or use smaller \
             elements or a higher order"
        )));
    }
    let factor = factorise(pencil, harmonic, shift)?;
    let mut basis = MassBasis::new(pencil);
    for motion in rigid {
        basis.extend(motion.clone());
    }
    basis.extend(start_vector(pencil.len()));

    let limit = available.min(30 + 10 * wanted);
    let mut lanczos = Tridiagonal::default();
    let mut converged = 0;
    while lanczos.diagonal.len() < limit {
        let mut next = basis.last_mass_vector().to_vec();
        factor.solve_in_place(ColMut::from_slice_mut(&mut next).as_mat_mut());
        let [along_last, remainder] = basis.extend(next);
        lanczos.diagonal.push(along_last);
        lanczos.coupling.push(remainder);

        let steps = lanczos.diagonal.len();
        if steps == limit || (steps >= wanted && steps % CHECK_INTERVAL == 0) {
            let ritz = lanczos.ritz(wanted.min(steps));
            // If the basis spans the whole space, the remainder consists of rounding errors.
            let done = |pair: &&RitzPair| steps == available || pair.residual <= TOLERANCE;
            converged = ritz.iter().take_while(done).count();
            if converged == wanted {
                let pairs = assemble_pairs(&ritz, &basis.vectors[rigid.len()..], shift, pencil);
                return pairs.map_err(|mode| {
                    FemError::Modes(format!(
                        "{harmonic}: the frequency of mode {mode} is lost in rounding errors: use less extreme \
                         proportions of the body, or larger elements"
                    ))
                });
            }
        }
    }
    Err(FemError::Modes(format!(
        "{harmonic}: {converged} of {wanted} modes converged in {limit} Lanczos steps: request fewer modes, or use less \
         extreme proportions of the body"
    )))
}

/// Factorises `K - sigma M`.
fn factorise(pencil: &Pencil, harmonic: Harmonic, shift: f64) -> Result<Llt<usize, f64>, FemError> {
    let entries = pencil.stiffness.iter().zip(&pencil.mass);
    let shifted: Vec<f64> = entries.map(|(k, m)| k - shift * m).collect();
    let n = pencil.len();
    let pattern =
        SymbolicSparseColMatRef::new_checked(n, n, &pencil.column_start, None, &pencil.row);
    SparseColMatRef::new(pattern, &shifted)
        .sp_cholesky(Side::Lower)
        .map_err(|error| {
            FemError::Modes(format!(
                "{harmonic}: the factorisation of K - sigma M failed ({error}): use a larger element size or less extreme \
                 proportions of the body"
            ))
        })
}

/// A fixed starting vector without symmetry, so no mode is missed and every run is identical: the
/// multiples of the golden ratio modulo one.
fn start_vector(len: usize) -> Vec<f64> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    (1..=len)
        .map(|i| (i as f64 * golden).fract() - 0.5)
        .collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// `y += factor * x`.
fn add_scaled(y: &mut [f64], factor: f64, x: &[f64]) {
    for (a, b) in y.iter_mut().zip(x) {
        *a += factor * b;
    }
}

/// A growing basis, orthonormal in the inner product of `M`.
struct MassBasis<'a> {
    pencil: &'a Pencil,
    vectors: Vec<Vec<f64>>,
    /// `M` times each vector.
    mass_vectors: Vec<Vec<f64>>,
}

impl<'a> MassBasis<'a> {
    fn new(pencil: &'a Pencil) -> Self {
        Self {
            pencil,
            vectors: Vec::new(),
            mass_vectors: Vec::new(),
        }
    }

    fn last_mass_vector(&self) -> &[f64] {
        &self.mass_vectors[self.mass_vectors.len() - 1]
    }

    /// Orthogonalises `x` against the basis, normalises it and appends it. Returns its component along the previously last
    /// vector and the norm of the orthogonal remainder.
    fn extend(&mut self, mut x: Vec<f64>) -> [f64; 2] {
        let mut along_last = 0.0;
        // The second pass removes the rounding errors of the first.
        for _ in 0..2 {
            let mut last = 0.0;
            for (vector, mass_vector) in self.vectors.iter().zip(&self.mass_vectors) {
                let component = dot(mass_vector, &x);
                add_scaled(&mut x, -component, vector);
                last = component;
            }
            along_last += last;
        }
        let mut mass_x = self.pencil.mass_times(&x);
        let remainder = dot(&x, &mass_x).sqrt();
        for vector in [&mut x, &mut mass_x] {
            vector.iter_mut().for_each(|v| *v /= remainder);
        }
        self.vectors.push(x);
        self.mass_vectors.push(mass_x);
        [along_last, remainder]
    }
}

/// The operator projected onto the Lanczos basis.
#[derive(Default)]
struct Tridiagonal {
    diagonal: Vec<f64>,
    /// Entry `k` couples the vectors `k` and `k + 1`. The last entry couples to the next vector, outside
    /// the projection, and measures the error.
    coupling: Vec<f64>,
}

/// An approximate eigenpair of the operator.
struct RitzPair {
    theta: f64,
    /// Components along the Lanczos vectors.
    components: Vec<f64>,
    /// Norm of the residual, relative to `theta`.
    residual: f64,
}

impl Tridiagonal {
    /// The pairs with the largest `theta`, largest first; empty if the small eigenproblem fails, which
    /// the caller reports as missing convergence.
    fn ritz(&self, count: usize) -> Vec<RitzPair> {
        let n = self.diagonal.len();
        let matrix = Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 => self.diagonal[i],
            1 => self.coupling[i.min(j)],
            _ => 0.0,
        });
        let Ok(eigen) = matrix.self_adjoint_eigen(Side::Lower) else {
            return Vec::new();
        };
        (0..count)
            .map(|k| {
                let column = n - 1 - k;
                let theta = eigen.S()[column];
                let components: Vec<f64> = eigen.U().col(column).iter().copied().collect();
                RitzPair {
                    theta,
                    residual: (self.coupling[n - 1] * components[n - 1] / theta).abs(),
                    components,
                }
            })
            .collect()
    }
}

/// Converts Ritz pairs of the operator to eigenpairs of the pencil. The error is the number of a mode whose eigenvalue
/// differs from the Rayleigh quotient of its vector.
fn assemble_pairs(
    ritz: &[RitzPair],
    basis: &[Vec<f64>],
    shift: f64,
    pencil: &Pencil,
) -> Result<Eigenpairs, usize> {
    let (mut values, mut vectors) = (Vec::new(), Vec::new());
    for pair in ritz {
        let mut vector = vec![0.0; pencil.len()];
        for (&component, base) in pair.components.iter().zip(basis) {
            add_scaled(&mut vector, component, base);
        }
        let value = shift + pair.theta.recip();
        let quotient = dot(&vector, &pencil.stiffness_times(&vector));
        let is_resolved = value > 0.0 && (quotient / value - 1.0).abs() <= ROUNDING;
        values.push(value);
        vectors.push(vector);
        if !is_resolved {
            return Err(values.len());
        }
    }
    Ok(Eigenpairs { values, vectors })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::harmonic::DofMap;
    use crate::fem::tests::elements;
    use crate::fem::{Material, Section};

    #[test]
    fn frequencies_lost_in_rounding_errors_are_an_error() {
        let material = Material {
            young: 207e9,
            poisson: 0.3,
            density: 7800.0,
        };
        let mut lost = 0;
        for length in (2..40).map(|tenths| 0.1 * f64::from(tenths)) {
            let diameter = 0.0005;
            let section = Section::rod(diameter, length, &elements(0.05, 3)).unwrap();
            // Bernoulli's beam with free ends.
            let slender = 4.730_040_745_f64.powi(2) / std::f64::consts::TAU * diameter / 4.0;
            let exact = slender * (material.young / material.density).sqrt() / (length * length);
            match section.modes(&material, Harmonic::Bending, 2) {
                Ok(modes) => {
                    let found = modes[0].frequency_hz;
                    assert!(
                        (found / exact - 1.0).abs() < 1e-2,
                        "{length}: {found} {exact}"
                    );
                }
                Err(error) => {
                    let message = error.to_string();
                    lost += usize::from(message.contains("rounding"));
                    assert!(matches!(error, FemError::Modes(_)), "{message}");
                }
            }
        }
        assert!(lost > 0);
    }

    #[test]
    fn all_lowest_modes_agree_with_a_dense_eigenvalue_solver() {
        // Reference: all eigenvalues of the same dense matrices, M = L L^T, L^-1 K L^-T.
        let material = Material {
            young: 207e9,
            poisson: 0.3,
            density: 7800.0,
        };
        let section = Section::rod(0.02, 0.06, &elements(0.02, 4)).unwrap();
        for harmonic in [Harmonic::Torsion, Harmonic::Axial, Harmonic::Bending] {
            let dofs = DofMap::new(&section, harmonic);
            let pencil = Pencil::assemble(&section, &material, harmonic, &dofs);
            let rigid: Vec<Vec<f64>> = harmonic
                .rigid_motions(&section)
                .iter()
                .map(|motion| dofs.gather(motion))
                .collect();
            let dense = |lower: &[f64]| {
                let mut full = Mat::zeros(pencil.len(), pencil.len());
                for j in 0..pencil.len() {
                    let column = pencil.column_start[j]..pencil.column_start[j + 1];
                    for (&i, &value) in pencil.row[column.clone()].iter().zip(&lower[column]) {
                        full[(i, j)] = value;
                        full[(j, i)] = value;
                    }
                }
                full
            };
            let root = dense(&pencil.mass).llt(Side::Lower).unwrap();
            let mut reduced = dense(&pencil.stiffness);
            root.L().solve_lower_triangular_in_place(&mut reduced);
            let mut reduced = reduced.transpose().to_owned();
            root.L().solve_lower_triangular_in_place(&mut reduced);
            let all = reduced.self_adjoint_eigenvalues(Side::Lower).unwrap();

            let wanted = 12;
            let found = lowest(&pencil, harmonic, &rigid, wanted, -1e9).unwrap();
            for (value, reference) in found.values.iter().zip(&all[rigid.len()..]) {
                let error = (value / reference - 1.0).abs();
                assert!(error < 1e-9, "{harmonic}: {value} against {reference}");
            }
            assert_eq!(found.values.len(), wanted);
        }
    }
}
