//! Test functions, whose zeros along a branch are bifurcations.

use super::bifurcation::critical_multiplier;
use super::point::Point;
use super::shape::GuardDistances;
use super::shooting::parameter_of;
use super::{BifurcationKind, Multiplier, PeriodicOrbit};

/// Largest distance `|ln|multiplier||` of a pair from the unit circle at a Neimark-Sacker point. A larger one shows that
/// the test function vanishes because two real multipliers have the product 1, which is no bifurcation.
const MAX_PAIR_ERROR: f64 = 1e-3;

/// Test functions: smooth along the branch, with a simple zero at a bifurcation.
impl BifurcationKind {
    /// Value of the test function at a point.
    pub(super) fn test(self, point: &Point) -> f64 {
        let orbit = &point.orbit;
        match self {
            Self::Fold => parameter_of(&point.tangent) / point.scale.parameter,
            // Zero at folds, too.
            Self::BranchPoint => product(orbit, |m| 1.0 - m.re()),
            Self::PeriodDoubling => product(orbit, |m| 1.0 + m.re()),
            Self::NeimarkSacker => pairs(orbit),
            // The lowest minimum of a guard of a continuous system.
            Self::Grazing => lowest_guard(point).map_or(1.0, |(_, least)| least),
        }
    }

    /// Whether the test function changes its sign between two points.
    fn changes(self, from: &Point, to: &Point) -> bool {
        let [a, b] = [from, to].map(|point| self.test(point));
        // The pairs of a conservative system stay on the circle to rounding.
        let width = from.orbit.circle_width().max(to.orbit.circle_width());
        let is_noise = self == Self::NeimarkSacker && a.abs().max(b.abs()) < width;
        (a < 0.0) != (b < 0.0) && !is_noise
    }

    /// Whether a located zero of the test function is a bifurcation.
    pub(super) fn is_at(self, orbit: &PeriodicOrbit) -> bool {
        self != Self::NeimarkSacker
            || critical_multiplier(self, orbit)
                .is_some_and(|pair| pair.ln_magnitude.abs() <= MAX_PAIR_ERROR)
    }
}

/// A product over real multipliers and conjugate pairs, each factor divided by `1 + |multiplier|`. It is real. `real` is the
/// real part of a factor, whose imaginary part is that of the multiplier.
fn product(orbit: &PeriodicOrbit, real: fn(Multiplier) -> f64) -> f64 {
    let mut product = 1.0;
    for multiplier in orbit.nontrivial_multipliers() {
        let scale = 1.0 + multiplier.magnitude().min(1e150);
        let re = real(multiplier);
        product *= match (multiplier.is_real(), multiplier.angle > 0.0) {
            (true, _) => (re / scale).clamp(-1.0, 1.0),
            // The product of both of a pair.
            (false, true) => (re.hypot(multiplier.im()) / scale).powi(2),
            (false, false) => 1.0,
        };
    }
    product
}

/// The sign of the product of `multiplier_i multiplier_j - 1` over all pairs, times the smallest magnitude of
/// `ln(multiplier_i multiplier_j) / 2` of its real factors. For a conjugate pair that is its distance from the unit circle.
/// Factors that are not real come in conjugate pairs, whose products are positive.
fn pairs(orbit: &PeriodicOrbit) -> f64 {
    let all: Vec<_> = orbit.nontrivial_multipliers().collect();
    let (mut sign, mut least) = (1.0, f64::INFINITY);
    for (i, a) in all.iter().enumerate() {
        for b in &all[i + 1..] {
            let is_conjugate = !a.is_real() && a.angle == -b.angle;
            if !(is_conjugate || a.is_real() && b.is_real()) {
                continue;
            }
            let is_negative = !is_conjugate && a.angle != b.angle;
            let half = 0.5 * (a.ln_magnitude + b.ln_magnitude);
            if is_negative {
                sign = -sign;
            } else {
                sign *= half.signum();
                least = f64::min(least, half.abs());
            }
        }
    }
    if least.is_finite() {
        sign * least
    } else {
        sign
    }
}

/// The guard of a continuous system with the lowest minimum over the orbit.
pub(super) fn lowest_guard(point: &Point) -> Option<(usize, f64)> {
    match &point.guards {
        GuardDistances::Minima(minima) => minima
            .iter()
            .copied()
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1)),
        GuardDistances::ClosestDip(_) => None,
    }
}

/// The bifurcations whose test functions change their sign between two successive points. A branch point is a change of its
/// function without a fold.
pub(super) fn changed(from: &Point, to: &Point) -> Vec<BifurcationKind> {
    use BifurcationKind::{BranchPoint, Fold, Grazing, NeimarkSacker, PeriodDoubling};
    let turns = Fold.changes(from, to);
    [Fold, BranchPoint, PeriodDoubling, NeimarkSacker, Grazing]
        .into_iter()
        .filter(|kind| kind.changes(from, to) && !(*kind == BranchPoint && turns))
        .collect()
}

/// Whether bifurcations between two points explain the change of the number of multipliers outside the unit circle.
pub(super) fn explains(kinds: &[BifurcationKind], from: &Point, to: &Point) -> bool {
    use BifurcationKind::{Grazing, NeimarkSacker};
    let change = to.orbit.unstable_multipliers as i64 - from.orbit.unstable_multipliers as i64;
    let count = |is_counted: fn(&BifurcationKind) -> bool| {
        kinds.iter().filter(|kind| is_counted(kind)).count() as i64
    };
    let single = count(|kind| !matches!(kind, NeimarkSacker | Grazing));
    let double = 2 * count(|kind| *kind == NeimarkSacker);
    change.abs() <= single + double && (change - single) % 2 == 0
}
