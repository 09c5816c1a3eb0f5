//! Test functions, whose zeros along a branch are bifurcations.

use super::bifurcation::critical_multiplier;
use super::point::Point;
use super::shape::GuardDistances;
use super::{BifurcationKind, Multiplier, PeriodicOrbit};

/// Largest distance `|ln|multiplier||` of a pair from the unit circle at a Neimark-Sacker point. A larger one shows that
/// the test function vanishes because two real multipliers have the product 1, which is no bifurcation.
const MAX_PAIR_ERROR: f64 = 1e-3;

/// Values of the test function of pairs that are rounding errors.
const PAIR_NOISE: f64 = 1e-7;

/// A test function: smooth along the branch, with a simple zero at a bifurcation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Test {
    /// The parameter's component of the tangent: zero at a fold.
    Turn,
    /// A product of `1 - multiplier`: zero at folds and branch points.
    One,
    /// A product of `1 + multiplier`: zero at a period doubling.
    MinusOne,
    /// Like a product of `multiplier_i multiplier_j - 1`: zero if a pair is on the unit circle.
    Pair,
    /// The lowest minimum of a guard of a continuous system.
    Guard,
}

impl Test {
    /// Value at a point.
    pub fn value(self, point: &Point) -> f64 {
        let orbit = &point.orbit;
        match self {
            Self::Turn => point.tangent.parameter / point.scale.parameter,
            Self::One => product(orbit, |m| 1.0 - m.re()),
            Self::MinusOne => product(orbit, |m| 1.0 + m.re()),
            Self::Pair => pairs(orbit),
            Self::Guard => lowest_guard(point).map_or(1.0, |(_, least)| least),
        }
    }

    /// Whether it changes its sign between two points.
    pub fn changes(self, from: &Point, to: &Point) -> bool {
        let [a, b] = [from, to].map(|point| self.value(point));
        // The pairs of a conservative system stay on the circle to rounding.
        let is_noise = self == Self::Pair && a.abs().max(b.abs()) < PAIR_NOISE;
        (a < 0.0) != (b < 0.0) && !is_noise
    }

    /// The type of the bifurcation at a located zero; `None` if it is no bifurcation.
    pub fn kind(self, orbit: &PeriodicOrbit) -> Option<BifurcationKind> {
        match self {
            Self::Turn => Some(BifurcationKind::Fold),
            Self::One => Some(BifurcationKind::BranchPoint),
            Self::MinusOne => Some(BifurcationKind::PeriodDoubling),
            Self::Pair => critical_multiplier(BifurcationKind::NeimarkSacker, orbit)
                .filter(|pair| pair.ln_magnitude.abs() <= MAX_PAIR_ERROR)
                .map(|_| BifurcationKind::NeimarkSacker),
            Self::Guard => Some(BifurcationKind::Grazing),
        }
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
    match &point.shape.guards {
        GuardDistances::Minima(minima) => minima
            .iter()
            .copied()
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1)),
        GuardDistances::ClosestDip(_) => None,
    }
}

/// The tests that change their sign between two successive points. A branch point is a change of [`Test::One`] without a
/// fold.
pub(super) fn changed(from: &Point, to: &Point) -> Vec<Test> {
    let turns = Test::Turn.changes(from, to);
    [
        Test::Turn,
        Test::One,
        Test::MinusOne,
        Test::Pair,
        Test::Guard,
    ]
    .into_iter()
    .filter(|test| test.changes(from, to) && !(*test == Test::One && turns))
    .collect()
}

/// Whether bifurcations between two points explain the change of the number of multipliers outside the unit circle.
pub(super) fn explains(tests: &[Test], from: &Point, to: &Point) -> bool {
    let change = to.orbit.unstable_multipliers as i64 - from.orbit.unstable_multipliers as i64;
    let real = [Test::Turn, Test::One, Test::MinusOne];
    let single = tests.iter().filter(|test| real.contains(test)).count() as i64;
    let double = 2 * tests.iter().filter(|test| **test == Test::Pair).count() as i64;
    change.abs() <= single + double && (change - single) % 2 == 0
}
