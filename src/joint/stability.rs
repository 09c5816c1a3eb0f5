//! Linear stability of steady sliding: complex eigenvalues of the Jacobian at the equilibrium.

use faer::Mat;
use serde::Serialize;

use super::Joint;
use crate::dynamics::{Differentiable, System};

/// One vibration mode of the linearised joint.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearMode {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Growth rate (real part of the eigenvalue), 1/s; positive means unstable.
    pub growth: f64,
    /// Share of each mode of the body in the vibration energy; sums to 1.
    pub shares: Vec<f64>,
}

impl LinearMode {
    /// Whether the vibration grows: by more than rounding can feign.
    pub fn unstable(&self) -> bool {
        self.growth > 1e-9 * std::f64::consts::TAU * self.frequency_hz.max(1.0)
    }
}

/// A linear mode by the name of the body's mode that it comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NamedMode {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Growth rate, 1/s; positive means that steady sliding is unstable.
    #[serde(rename = "growth_per_s")]
    pub growth: f64,
    /// Which mode of the body it is, such as `2nd bending`.
    pub label: String,
    /// Whether it grows by more than rounding errors explain.
    pub unstable: bool,
}

impl LinearMode {
    /// The same by the family of modes with the largest share; `families` names that of each mode of
    /// the body ([`BallJoint::family_labels`](super::BallJoint::family_labels)). The two members of a
    /// bending pair may mix in any proportion: their shares count together.
    pub fn named(&self, families: &[String]) -> NamedMode {
        let share = |label: &String| -> f64 {
            let shares = families.iter().zip(&self.shares);
            let of_family = shares.filter(|(of, _)| *of == label);
            of_family.map(|(_, share)| share).sum()
        };
        let largest = families.iter().max_by(|a, b| share(a).total_cmp(&share(b)));
        NamedMode {
            frequency_hz: self.frequency_hz,
            growth: self.growth,
            label: largest.cloned().unwrap_or_default(),
            unstable: self.unstable(),
        }
    }
}

/// The eigenvalue problem could not be solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the eigenvalues of the linearised joint did not converge; check the scene for extreme \
     stiffness or friction slopes"
)]
pub struct StabilityError;

impl Joint {
    /// All modes of the joint linearised at steady sliding, by ascending frequency. A conjugate
    /// pair is one mode; a pair of real eigenvalues (overdamped) is two modes of frequency zero.
    ///
    /// # Errors
    /// If the eigenvalue iteration does not converge.
    pub fn linear_modes(&self) -> Result<Vec<LinearMode>, StabilityError> {
        let m = self.omega().len();
        let dim = 2 * m;
        let mut jacobian = vec![0.0; dim * dim];
        let mut record = vec![0.0; self.record_len()];
        self.jacobian(&vec![0.0; self.dim()], &mut record, &mut jacobian);
        // Scaled to [omega q | dq/dt]: both halves in the unit of a velocity, well balanced.
        let omega = self.omega();
        let scale = |i: usize| if i < m { omega[i] } else { 1.0 };
        let matrix = Mat::from_fn(dim, dim, |i, j| jacobian[i * dim + j] * scale(i) / scale(j));
        let eigen = matrix.eigen().map_err(|_| StabilityError)?;
        let values = eigen.S().column_vector();
        let vectors = eigen.U();
        let mut modes: Vec<_> = (0..dim)
            .filter(|&k| values[k].im >= 0.0)
            .map(|k| {
                let mut shares: Vec<f64> = (0..m)
                    .map(|i| vectors[(i, k)].norm_sqr() + vectors[(m + i, k)].norm_sqr())
                    .collect();
                let total: f64 = shares.iter().sum();
                shares.iter_mut().for_each(|share| *share /= total);
                LinearMode {
                    frequency_hz: values[k].im / std::f64::consts::TAU,
                    growth: values[k].re,
                    shares,
                }
            })
            .collect();
        modes.sort_by(|a, b| {
            a.frequency_hz
                .total_cmp(&b.frequency_hz)
                .then(a.growth.total_cmp(&b.growth))
        });
        Ok(modes)
    }
}
