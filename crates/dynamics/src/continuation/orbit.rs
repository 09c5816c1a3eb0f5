//! A periodic orbit and its Floquet multipliers.

use std::cmp::Ordering;
use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::Serialize;

/// A Floquet multiplier, in polar form: the real and imaginary parts would lose magnitudes below 1e-308.
///
/// It is serialised as the pair `[re, im]`, rounded to ten digits of the magnitude.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(into = "[f64; 2]")]
pub struct Multiplier {
    /// Natural logarithm of the magnitude; minus infinity for zero.
    pub ln_magnitude: f64,
    /// Angle, rad, in (-pi, pi]; zero if the multiplier is zero.
    pub angle: f64,
}

impl Multiplier {
    /// The multiplier zero: a direction that collapses, for example by sticking.
    pub const ZERO: Self = Self {
        ln_magnitude: f64::NEG_INFINITY,
        angle: 0.0,
    };

    /// Magnitude.
    pub fn magnitude(self) -> f64 {
        self.ln_magnitude.exp()
    }

    /// Real part.
    pub fn re(self) -> f64 {
        self.magnitude() * self.angle.cos()
    }

    /// Imaginary part; exactly zero for a real multiplier.
    pub fn im(self) -> f64 {
        if self.is_real() {
            0.0
        } else {
            self.magnitude() * self.angle.sin()
        }
    }

    /// Whether it is real.
    pub fn is_real(self) -> bool {
        self.angle == 0.0 || self.angle == std::f64::consts::PI
    }

    /// Distance from a real number.
    pub fn distance_from(self, real: f64) -> f64 {
        (self.re() - real).hypot(self.im())
    }

    /// Turns of the direction per period, 0 to 1/2: the rotation number of the torus that a pair of these
    /// multipliers makes when it leaves the unit circle.
    pub fn rotation_number(self) -> f64 {
        self.angle.abs() / TAU
    }

    /// Growth rate over a period (s), 1/s: the real part of the Floquet exponent.
    pub fn growth_per_s(self, period: f64) -> f64 {
        self.ln_magnitude / period
    }

    /// The order in a list: the largest magnitude first, of a pair the positive angle first.
    pub(super) fn order(&self, other: &Self) -> Ordering {
        other
            .ln_magnitude
            .total_cmp(&self.ln_magnitude)
            .then(other.angle.total_cmp(&self.angle))
    }
}

impl From<Multiplier> for [f64; 2] {
    fn from(multiplier: Multiplier) -> Self {
        let decimals = 10.0 - multiplier.magnitude().log10().floor();
        // As decimal text, whose value does not depend on how it is rounded.
        let rounded = |part: f64| {
            let text = format!("{part:.0$}", decimals.clamp(0.0, 330.0) as usize);
            text.parse().unwrap_or(part)
        };
        [multiplier.re(), multiplier.im()].map(rounded)
    }
}

/// The start of a segment of an orbit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct OrbitSegment {
    /// Phase, 0 to 1: the time divided by the period.
    pub phase: f64,
    /// The state without quadratures, of length [`System::tangent_dim`](crate::System::tangent_dim).
    pub state: Vec<f64>,
}

/// A periodic orbit at one value of the parameter.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct PeriodicOrbit {
    /// Value of the parameter.
    pub parameter: f64,
    /// Period, s.
    pub period_s: f64,
    /// Number of periods of the drive in the period; `None` for an autonomous system.
    pub drive_periods: Option<u32>,
    /// State at phase zero, without quadratures. A forced system is there at time zero.
    pub state: Vec<f64>,
    /// Floquet multipliers, the largest first, including the one at 1 of an autonomous orbit.
    pub multipliers: Vec<Multiplier>,
    /// Whether no multiplier, except the trivial one of an autonomous orbit, is outside the unit circle.
    pub stable: bool,
    /// Number of multipliers outside the unit circle by more than their error, and by more than 1e-7, without the trivial
    /// one.
    pub unstable_multipliers: usize,
    /// Distance from 1 of the multiplier that is 1 for an autonomous orbit, the estimate of the error of the
    /// multipliers; `None` for a forced orbit.
    pub trivial_multiplier_error: Option<f64>,
    /// Half the range of the observable ([`FamilyMember::observable`](super::FamilyMember::observable)) over the period.
    pub amplitude: f64,
    /// The observable and its rate at equal times over the period, the first ones again at the end.
    #[serde(skip)]
    pub portrait: Vec<[f64; 2]>,
    /// Half the range of each component of the state over the period.
    pub component_amplitudes: Vec<f64>,
    /// Standard deviation of each component of the state over the period. Unlike the range of samples it does not depend on
    /// their phases.
    #[serde(skip)]
    pub component_deviations: Vec<f64>,
    /// Largest distance between the end of a segment and the start of the next one, relative to the size of the orbit.
    pub residual: f64,
    /// Last Newton correction, relative to the size of the orbit.
    pub correction: f64,
    /// Newton iterations.
    pub iterations: u32,
    /// Guards crossed during a period, if events are located.
    pub events: u64,
    /// Guards of a continuous system that change their sign, for example of nodes that separate and close again.
    pub open_guards: usize,
    /// The starts of the segments, the first at phase zero.
    pub segments: Vec<OrbitSegment>,
}

impl PeriodicOrbit {
    /// Frequency, Hz.
    pub fn frequency_hz(&self) -> f64 {
        1.0 / self.period_s
    }

    /// Whether the orbit has a free phase and thus a trivial multiplier.
    pub fn is_autonomous(&self) -> bool {
        self.drive_periods.is_none()
    }

    /// Index of the multiplier closest to 1 for an autonomous orbit.
    pub fn trivial_multiplier(&self) -> Option<usize> {
        let distance = |k: &usize| self.multipliers[*k].distance_from(1.0);
        self.is_autonomous().then(|| {
            (0..self.multipliers.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
        })?
    }

    /// The multipliers without the trivial one.
    pub fn nontrivial_multipliers(&self) -> impl Iterator<Item = Multiplier> {
        let trivial = self.trivial_multiplier();
        let all = self.multipliers.iter().copied().enumerate();
        all.filter(move |(k, _)| Some(*k) != trivial)
            .map(|(_, multiplier)| multiplier)
    }

    /// Distance `|ln|multiplier||` within which a multiplier counts as on the unit circle: the error of the multipliers
    /// of an autonomous orbit, and at least 1e-7, which a conservative system reaches.
    pub(super) fn circle_width(&self) -> f64 {
        self.trivial_multiplier_error.unwrap_or(0.0).max(1e-7)
    }

    /// With the stability by its multipliers.
    pub(super) fn with_stability(mut self) -> Self {
        let distance = |k: usize| self.multipliers[k].distance_from(1.0);
        self.trivial_multiplier_error = self.trivial_multiplier().map(distance);
        let width = self.circle_width();
        let outside = |multiplier: &Multiplier| multiplier.ln_magnitude > width;
        self.unstable_multipliers = self.nontrivial_multipliers().filter(outside).count();
        self.stable = self.unstable_multipliers == 0;
        self
    }

    /// The two base frequencies (Hz) of the torus around this orbit, `1 / T` and `rotation number / T`, from the
    /// largest pair of complex multipliers outside the unit circle; `None` without such a pair. They are exact at the
    /// Neimark-Sacker point and to first order in the distance from it.
    pub fn torus_frequencies_hz(&self) -> Option<[f64; 2]> {
        let leading = self
            .multipliers
            .iter()
            .find(|multiplier| multiplier.ln_magnitude > 0.0 && !multiplier.is_real())?;
        Some([
            self.frequency_hz(),
            leading.rotation_number() / self.period_s,
        ])
    }
}
