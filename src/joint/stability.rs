//! Linear stability of steady sliding: complex eigenvalues of the Jacobian at the equilibrium.

use faer::Mat;
use serde::{Deserialize, Serialize};

use super::Joint;
use crate::dynamics::{Differentiable, System};

/// A mode of the linearised joint.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearMode {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Growth rate (real part of the eigenvalue), 1/s; positive for an unstable mode.
    pub growth: f64,
    /// Shares of the body's modes in the vibration energy; they sum to 1.
    pub shares: Vec<f64>,
}

impl LinearMode {
    /// Whether the growth rate is positive beyond rounding errors.
    pub fn unstable(&self) -> bool {
        self.growth > 1e-9 * std::f64::consts::TAU * self.frequency_hz.max(1.0)
    }
}

/// A linear mode with the name of the dominant mode of the body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedMode {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Growth rate, 1/s; positive if steady sliding is unstable.
    #[serde(rename = "growth_per_s")]
    pub growth: f64,
    /// Dominant mode of the body, such as `2nd bending`.
    pub label: String,
    /// Whether the growth rate is positive beyond rounding errors.
    pub unstable: bool,
}

impl LinearMode {
    /// Returns the mode with the name of the family with the largest energy share. `families` contains the
    /// name of each mode of the body ([`BallJoint::family_labels`](super::BallJoint::family_labels)). The
    /// shares of the two modes of a bending pair, which can combine in any proportion, are added.
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

/// Error of the stability analysis: the eigenvalue iteration did not converge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the eigenvalues of the linearised joint did not converge; check the scene for extreme \
     stiffness or friction slopes"
)]
pub struct StabilityError;

impl Joint {
    /// Returns all modes of the joint linearised at steady sliding, in ascending order of frequency. A
    /// complex conjugate pair is one mode; a pair of real eigenvalues (overdamped) is two modes with a
    /// frequency of zero.
    ///
    /// # Errors
    /// If the eigenvalue iteration does not converge.
    pub fn linear_modes(&self) -> Result<Vec<LinearMode>, StabilityError> {
        let m = self.omega().len();
        let dim = 2 * m;
        let mut jacobian = vec![0.0; dim * dim];
        let mut record = vec![0.0; self.record_len()];
        self.jacobian(&vec![0.0; self.dim()], &mut record, &mut jacobian);
        // The state [omega q | dq/dt] has the units of a velocity, which balances the matrix.
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
