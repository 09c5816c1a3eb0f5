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
use faer::{Col, ColRef, Mat, Scale, Side};

use super::assembly::{Pencil, symmetric_product};
use super::{FemError, Harmonic};

/// Convergence criterion: the residual of a Ritz pair in the norm of `M`, relative to `theta`. The
/// relative error of the eigenvalue is of the order of its square.
const TOLERANCE: f64 = 1e-12;
/// Maximum relative difference of an eigenvalue from the Rayleigh quotient of its vector. Their rounding errors differ,
/// so that a larger difference shows that the eigenvalue is lost in them.
const ROUNDING: f64 = 1e-4;
/// Lanczos steps between convergence checks.
const CHECK_INTERVAL: usize = 4;

/// Computes the `wanted` lowest elastic eigenpairs of a family with the linearly independent rigid-body motions `rigid`, with
/// the shift `sigma` (negative, rad^2/s^2): eigenvalues `omega^2` (rad^2/s^2) in ascending order with `M`-orthonormal
/// vectors.
///
/// # Errors
/// [`FemError::Modes`].
pub(super) fn lowest(
    pencil: &Pencil,
    harmonic: Harmonic,
    rigid: &[Col<f64>],
    wanted: usize,
    shift: f64,
) -> Result<Vec<(f64, Col<f64>)>, FemError> {
    let fault = |text: String| FemError::Modes(format!("{harmonic}: {text}"));
    let len = pencil.mass.nrows();
    let available = len.saturating_sub(rigid.len());
    if wanted > available {
        return Err(FemError::Modes(format!(
            "{wanted} {harmonic} modes requested, but the mesh resolves only {available}: request fewer, or use smaller \
             elements or a higher order"
        )));
    }
    let shifted = &pencil.stiffness - Scale(shift) * &pencil.mass;
    let factor = shifted.sp_cholesky(Side::Lower).map_err(|error| {
        fault(format!(
            "the factorisation of K - sigma M failed ({error}): use a larger element size or less extreme proportions \
             of the body"
        ))
    })?;
    let mut basis = MassBasis {
        vectors: Vec::new(),
        mass_vectors: Vec::new(),
    };
    for motion in rigid {
        basis.extend(pencil, motion.clone());
    }
    // A fixed starting vector without symmetry, so no mode is missed and every run is identical: the multiples of the
    // golden ratio modulo one.
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    basis.extend(
        pencil,
        Col::from_fn(len, |i| ((i + 1) as f64 * golden).fract() - 0.5),
    );

    // The operator projected onto the Lanczos vectors is tridiagonal. The last entry beside the diagonal couples to the
    // next vector, outside the projection, and measures the error.
    let (mut diagonal, mut coupling) = (Vec::new(), Vec::new());
    let limit = available.min(30 + 10 * wanted);
    let mut converged = 0;
    while diagonal.len() < limit {
        let next = factor.solve(&basis.mass_vectors[basis.mass_vectors.len() - 1]);
        let [along_last, remainder] = basis.extend(pencil, next);
        diagonal.push(along_last);
        coupling.push(remainder);

        let steps = diagonal.len();
        if steps < limit && (steps < wanted || steps % CHECK_INTERVAL != 0) {
            continue;
        }
        let projected = Mat::from_fn(steps, steps, |i, j| match i.checked_sub(j) {
            Some(0) => diagonal[i],
            Some(1) => coupling[j],
            _ => 0.0,
        });
        let Ok(ritz) = projected.self_adjoint_eigen(Side::Lower) else {
            break;
        };
        // The largest eigenvalues are the last.
        let pairs = || {
            let pairs = ritz.S().column_vector().iter().zip(ritz.U().col_iter());
            pairs.rev().take(wanted)
        };
        // If the basis spans the whole space, the remainder consists of rounding errors.
        let has_converged = |(theta, components): &(&f64, ColRef<'_, f64>)| {
            steps == available || (remainder * components[steps - 1] / *theta).abs() <= TOLERANCE
        };
        converged = pairs().take_while(has_converged).count();
        if converged < wanted {
            continue;
        }
        let lanczos = &basis.vectors[rigid.len()..][..steps];
        let modes = pairs().enumerate().map(|(k, (theta, components))| {
            let vector = combination(lanczos, components);
            let value = shift + theta.recip();
            let quotient = vector.transpose() * symmetric_product(&pencil.stiffness, &vector);
            if value > 0.0 && (quotient / value - 1.0).abs() <= ROUNDING {
                return Ok((value, vector));
            }
            Err(fault(format!(
                "the frequency of mode {} is lost in rounding errors: use less extreme proportions of the body, or larger \
                 elements",
                k + 1
            )))
        });
        return modes.collect();
    }
    Err(fault(format!(
        "{converged} of {wanted} modes converged in {limit} Lanczos steps: request fewer modes, or use less extreme \
         proportions of the body"
    )))
}

/// The sum of vectors, each with its component.
fn combination(vectors: &[Col<f64>], components: ColRef<'_, f64>) -> Col<f64> {
    let mut sum = Col::zeros(vectors[0].nrows());
    for (vector, component) in vectors.iter().zip(components.iter()) {
        sum += Scale(*component) * vector;
    }
    sum
}

/// A growing basis, orthonormal in the inner product of `M`.
struct MassBasis {
    vectors: Vec<Col<f64>>,
    /// `M` times each vector.
    mass_vectors: Vec<Col<f64>>,
}

impl MassBasis {
    /// Orthogonalises `x` against the basis, normalises it and appends it. Returns its component along the previously last
    /// vector and the norm of the orthogonal remainder.
    fn extend(&mut self, pencil: &Pencil, mut x: Col<f64>) -> [f64; 2] {
        let mut along_last = 0.0;
        // The second pass removes the rounding errors of the first.
        for _ in 0..2 {
            let mut last = 0.0;
            for (vector, mass_vector) in self.vectors.iter().zip(&self.mass_vectors) {
                last = mass_vector.transpose() * &x;
                x -= Scale(last) * vector;
            }
            along_last += last;
        }
        let mass_x = symmetric_product(&pencil.mass, &x);
        let remainder = (x.transpose() * &mass_x).sqrt();
        self.vectors.push(Scale(remainder.recip()) * x);
        self.mass_vectors.push(Scale(remainder.recip()) * mass_x);
        [along_last, remainder]
    }
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
            let rigid: Vec<_> = harmonic
                .rigid_motions(&section)
                .iter()
                .map(|motion| dofs.gather(motion))
                .collect();
            let root = pencil.mass.to_dense().llt(Side::Lower).unwrap();
            let lower = pencil.stiffness.to_dense();
            let mut reduced = Mat::from_fn(lower.nrows(), lower.ncols(), |i, j| {
                lower[(i.max(j), i.min(j))]
            });
            root.L().solve_lower_triangular_in_place(&mut reduced);
            let mut reduced = reduced.transpose().to_owned();
            root.L().solve_lower_triangular_in_place(&mut reduced);
            let all = reduced.self_adjoint_eigenvalues(Side::Lower).unwrap();

            let wanted = 12;
            let found = lowest(&pencil, harmonic, &rigid, wanted, -1e9).unwrap();
            for ((value, _), reference) in found.iter().zip(&all[rigid.len()..]) {
                let error = (value / reference - 1.0).abs();
                assert!(error < 1e-9, "{harmonic}: {value} against {reference}");
            }
            assert_eq!(found.len(), wanted);
        }
    }
}
