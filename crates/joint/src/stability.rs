//! Linear stability of steady sliding: complex eigenvalues of the Jacobian at the equilibrium.

use faer::{Mat, c64};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Joint;
use squeakscope_dynamics::equilibrium::{Eigenmode, eigenmodes};
use squeakscope_dynamics::{Differentiable, System};

/// Least growth rate of an unstable mode, 1/s.
///
/// A mode that grows more slowly changes by at most 10 % in one second, longer than any scene of a joint in the
/// program (0.9 s), and an angular velocity of 1 rad/s would have tilted the joint by 57 degrees by then: no run
/// can tell it from a mode of constant amplitude. A modal damping ratio of 1e-5 at 1.7 kHz, less than that of any
/// steel body and left out by default, outweighs it. The margin to the growth rates that the paper's count of
/// five unstable modes depends on (a torsion mode with 0.6 to 3 1/s) is a factor of six. In a run of 100 s, the
/// longest permitted, a slower mode would become visible, too.
pub const MIN_GROWTH: f64 = 0.1;

/// Rounding error of a growth rate relative to the angular frequency.
const ROUNDING: f64 = 1e-9;

/// Least angular frequency of a mode relative to its rate of decay with which it counts as oscillating, if friction has
/// states.
const OSCILLATING: f64 = 0.01;

/// Whether a growth rate (1/s) of a mode with angular frequency `omega` (rad/s) is at least [`MIN_GROWTH`], and
/// positive beyond rounding errors.
pub fn is_unstable(growth: f64, omega: f64) -> bool {
    growth >= MIN_GROWTH && growth > ROUNDING * omega
}

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
    /// An eigenvalue of a system with a number of modes; without any, the shares are those of the components of the state.
    pub fn new(mode: &Eigenmode, modes: usize) -> Self {
        let squares: Vec<f64> = mode.vector.iter().map(|x| x.norm_sqr()).collect();
        let mut shares = squares.clone();
        if modes > 0 {
            shares = (0..modes)
                .map(|i| squares[i] + squares[modes + i])
                .collect();
        }
        let total: f64 = shares.iter().sum();
        shares.iter_mut().for_each(|share| *share /= total);
        Self {
            frequency_hz: mode.frequency_hz(),
            growth: mode.value.re,
            shares,
        }
    }

    /// Whether the mode is unstable: its growth rate is at least [`MIN_GROWTH`], 0.1 1/s, and positive beyond
    /// rounding errors.
    pub fn unstable(&self) -> bool {
        is_unstable(self.growth, std::f64::consts::TAU * self.frequency_hz)
    }
}

/// A linear mode with the name of the dominant mode of the body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NamedMode {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Growth rate, 1/s; positive if the mode grows in steady sliding.
    #[serde(rename = "growth_per_s")]
    pub growth: f64,
    /// Dominant mode of the body, such as `2nd bending`.
    pub label: String,
    /// Whether the mode is unstable: its growth rate is at least 0.1 1/s, below which no run shows it.
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
    /// frequency of zero. The states of friction add stable relaxations, which are omitted if they do not oscillate.
    ///
    /// # Errors
    /// If the eigenvalue iteration does not converge.
    pub fn linear_modes(&self) -> Result<Vec<LinearMode>, StabilityError> {
        let (m, dim) = (self.omega().len(), self.tangent_dim());
        let mut jacobian = vec![0.0; dim * dim];
        let mut record = vec![0.0; self.record_len()];
        self.jacobian(&vec![0.0; self.dim()], &mut record, &mut jacobian);
        // The parts [omega q | dq/dt] have the units of a velocity, which balances the matrix.
        let omega = self.omega();
        let scale = |i: usize| if i < m { omega[i] } else { 1.0 };
        let matrix = Mat::from_fn(dim, dim, |i, j| jacobian[i * dim + j] * scale(i) / scale(j));
        let all = eigenmodes(&matrix).map_err(|_| StabilityError)?;
        // Equal relaxations of many nodes have small imaginary parts from rounding.
        let is_shown = |mode: &&Eigenmode| {
            let c64 { re, im } = mode.value;
            dim == 2 * m || im > OSCILLATING * re.abs() || re > 0.0
        };
        let shown = all.iter().filter(is_shown);
        let mut modes: Vec<_> = shown.map(|mode| LinearMode::new(mode, m)).collect();
        modes.sort_by(|a, b| {
            a.frequency_hz
                .total_cmp(&b.frequency_hz)
                .then(a.growth.total_cmp(&b.growth))
        });
        Ok(modes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The torsion mode of the paper's five (0.58 1/s in one set of parameters) counts; a growth that no run shows
    /// does not.
    #[test]
    fn a_mode_is_unstable_from_the_least_growth_rate_on() {
        let mode = |growth: f64, frequency_hz: f64| LinearMode {
            frequency_hz,
            growth,
            shares: vec![1.0],
        };
        for (growth, unstable) in [
            (785.0, true),
            (0.58, true),
            (MIN_GROWTH, true),
            (0.0999, false),
            (1e-4, false),
            (0.0, false),
            (-785.0, false),
        ] {
            assert_eq!(mode(growth, 4501.0).unstable(), unstable, "{growth}");
            assert_eq!(
                mode(growth, 4501.0).named(&["torsion".to_owned()]).unstable,
                unstable
            );
        }
        assert!(!mode(1.0, 1e9).unstable(), "rounding error");
        assert!(mode(1.0, 0.0).unstable(), "without oscillation");
    }
}
