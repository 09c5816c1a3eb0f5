//! The lesson of a scene's mechanism: predictions of the linear theory, computed before the run, and measurements for
//! comparison.

use std::sync::Arc;

use super::frame::Kick;
use super::observation::{Exponents, TrajectoryDivergence};
use crate::analysis::{regime::Regime, tones::SpectralLine};
use crate::joint::NamedMode;
use crate::report::Measured;
use crate::scene::{Mechanism, Start};

/// Linear prediction for the scene's mechanism, and the measurements so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Lesson {
    /// Simulated time, s.
    pub time: f64,
    /// Prediction made before the run.
    pub computed: Arc<MechanismPrediction>,
    /// Measurements so far.
    pub measured: Measurements,
}

/// Measurements of a run that demonstrates a mechanism. Shares refer to the last 25 ms. All are computed from
/// samples at fixed instants of simulated time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measurements {
    /// Growth rate of the velocity level while the vibration is small, 1/s.
    pub growth: Option<Measured>,
    /// Whether the linear growth has ended: the vibration has become too large for the linear theory.
    pub growth_ended: bool,
    /// Mean frequency while the vibration is small, Hz.
    pub small_frequency: Option<Measured>,
    /// Peak speed: largest magnitude of the velocity in the last 25 ms, m/s.
    pub peak_speed: Option<f64>,
    /// First nonzero level, m/s.
    pub first_level: Option<f64>,
    /// Velocity level: RMS over the last half natural period, m/s.
    pub level: f64,
    /// Whether the vibration is at rest: the level is below [`Header::rest_speed`](super::Header::rest_speed).
    pub at_rest: bool,
    /// Type of motion by the last classification.
    pub regime: Option<Regime>,
    /// Kicks after the one at the start of the run: their number.
    pub kicks: usize,
    /// The last of these kicks.
    pub last_kick: Option<Kick>,
    /// Lines of the last spectrum, strongest first; empty before the first spectrum.
    pub lines: Vec<SpectralLine>,
    /// States of the contact nodes, for a joint with a patch rate.
    pub nodes: Option<NodeShares>,
    /// States of a small system.
    pub statuses: Option<StatusShares>,
    /// The leader at the end of the growth: the family of modes with the most energy.
    pub leader_at_end: Option<String>,
    /// Family of modes with the most energy.
    pub leader: Option<String>,
    /// Present tilt, rad.
    pub tilt: Option<f64>,
    /// Other numbers of the scene that commands have changed: name, present value and unit.
    pub changed: Vec<String>,
    /// Strongest spectral line while the tilt rises and falls, if hysteresis or articulation is the mechanism.
    pub tilts: Option<TiltLoop>,
    /// The squeak in each pass of a joint that turns to and fro, if articulation is the mechanism.
    pub passes: Vec<SqueakPass>,
    /// The second tone of a torus, if its birth is the mechanism.
    pub second_tone: Option<SecondToneLevel>,
    /// Distance of the perturbed trajectory: first and last value.
    pub separation: Option<[TrajectoryDivergence; 2]>,
    /// Last Lyapunov exponents.
    pub exponents: Option<Arc<Exponents>>,
}

impl Measurements {
    /// Whether the growth rate is above zero by its interval; `None` if it is not measured.
    pub fn grows(&self) -> Option<bool> {
        self.growth.map(|rate| rate.value > rate.half_width)
    }
}

/// The squeak while a joint turns in one direction, from one reversal to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SqueakPass {
    /// Direction in which the tilt changes.
    pub way: TiltDirection,
    /// Tilts at which the velocity level first and last exceeded a twentieth of the largest sliding speed, rad.
    pub squeak: Option<[f64; 2]>,
    /// Whether the level has been lower since then, for 5 ms.
    pub has_ended: bool,
}

/// Level of the second tone of a torus that is born.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SecondToneLevel {
    /// Amplitude of its two side lines relative to that of the first tone, root of the sum of squares, in the last window.
    pub ratio: f64,
    /// The last measured decay, at tilts at which the multipliers are inside the unit circle.
    pub decay: Option<ToneGrowth>,
    /// The last measured growth, at tilts at which they are outside.
    pub growth: Option<ToneGrowth>,
}

/// Growth of a small second tone over an interval of the tilt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToneGrowth {
    /// Tilts at the first and at the last window, rad.
    pub tilts: [f64; 2],
    /// Mean growth rate, 1/s.
    pub growth: Measured,
    /// Computed mean growth rate by the Floquet multipliers at these tilts, 1/s.
    pub computed_per_s: f64,
}

/// Shares of contact nodes that stick or have separated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeShares {
    /// Mean share of sticking nodes, 0 to 1.
    pub stuck: f64,
    /// The most stuck nodes: largest share that sticks simultaneously, 0 to 1.
    pub most_stuck: f64,
    /// Share of the time in which at least half of the nodes stick, 0 to 1.
    pub half_stuck: f64,
    /// Mean share of separated nodes, 0 to 1.
    pub separated: f64,
    /// The most separated nodes: largest share that is separated simultaneously, 0 to 1.
    pub most_separated: f64,
    /// Share of the time in which all nodes are separated, 0 to 1.
    pub all_separated: f64,
    /// Separations per node and second, 1/s.
    pub separations_per_s: f64,
}

/// Shares of the states of a small system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatusShares {
    /// Share of the time in which it sticks, rests or touches, 0 to 1.
    pub held: f64,
    /// Number of releases per second, 1/s.
    pub releases_per_s: f64,
}

/// Loop over the tilt: the strongest spectral line over a tilt that rises and falls.
#[derive(Clone, Debug, PartialEq)]
pub struct TiltLoop {
    /// Tilt of the last line, rad; `None` before the tilt changes.
    pub tilt: Option<f64>,
    /// Whether the tilt has decreased at least once.
    pub has_decreased: bool,
    /// Lasting changes of the line while the tilt rises.
    pub up: Vec<ToneChange>,
    /// Lasting changes of the line while the tilt falls.
    pub down: Vec<ToneChange>,
    /// Smallest and largest tilt, rad, of the differing lines between rise and fall.
    pub differing: Option<[f64; 2]>,
    /// Tilt of the last change during the rise, rad.
    pub last_up: Option<f64>,
    /// Tilt of the change back during the fall, rad, if it is smaller.
    pub back: Option<f64>,
}

/// A change of the strongest spectral line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToneChange {
    /// Frequency before the change, Hz.
    pub from: f64,
    /// The new line at its first occurrence.
    pub to: TiltedTone,
}

/// Level and strongest spectral line at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelSample {
    /// Simulated time, s.
    pub time: f64,
    /// Measured level: RMS velocity of the probe over the half natural period that ends at `time`, m/s.
    pub level: f64,
    /// Predicted level: growth at the largest computed rate, m/s; `None` once the vibration is too large for
    /// the linear theory.
    pub predicted: Option<f64>,
    /// Strongest line at its tilt, if the tilt varies.
    pub tone: Option<TiltedTone>,
}

/// The strongest spectral line at a tilt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiltedTone {
    /// Tilt at the centre of the window of the spectrum, rad.
    pub tilt: f64,
    /// Direction in which the tilt changes.
    pub way: TiltDirection,
    /// Frequency of the line, Hz.
    pub frequency: f64,
}

/// Direction in which a tilt changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TiltDirection {
    /// Rising, or at the maximum.
    Up,
    /// Falling, or at the minimum after a fall.
    Down,
}

impl TiltDirection {
    /// The direction from one tilt to another.
    pub fn of(before: f64, after: f64) -> Self {
        if after < before { Self::Down } else { Self::Up }
    }
}

/// Predictions for a scene that demonstrates a mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct MechanismPrediction {
    /// The mechanism.
    pub mechanism: Mechanism,
    /// Modes linearised about steady sliding under the initial load, tilt and rotation, in ascending order of
    /// frequency.
    pub modes: Vec<NamedMode>,
    /// Lowest natural frequency without contact and friction, Hz.
    pub natural_hz: f64,
    /// Tilt of the prediction, rad; `None` for a subject without tilt.
    pub tilt: Option<f64>,
    /// Sliding speed in steady sliding, m/s.
    pub sliding_speed: f64,
    /// Initial conditions of the run.
    pub start: Start,
    /// Readings of the friction curve: as in the scene, and with its two slope factors exchanged.
    pub readings: Option<[FrictionReading; 2]>,
    /// Two modes that friction couples.
    pub coupling: Option<Coupling>,
    /// Friction with a state, for small oscillations.
    pub memory: Option<FrictionMemory>,
    /// A measured friction curve at the sliding speed.
    pub table: Option<TableReading>,
    /// Passes of a joint that turns to and fro, from one reversal to the next, in order of time.
    pub passes: Option<Vec<UnstablePass>>,
    /// A torus that is born while the tilt changes; `None` if no branch of periodic motions leads to one.
    pub torus: Option<TorusBirth>,
    /// Curves to draw.
    pub picture: Option<PredictedCurves>,
}

/// One reading (interpretation) of the friction curve, Eq. (5).
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionReading {
    /// Slope factor of the creep range, s/m.
    pub creep: f64,
    /// Slope factor of the sliding range, s/m.
    pub stribeck: f64,
    /// Coefficient of friction at the sliding speed.
    pub mu: f64,
    /// Slope of the friction curve at the sliding speed, s/m.
    pub slope: f64,
    /// Linearised modes under this curve.
    pub modes: Vec<NamedMode>,
}

/// A friction law with a state, for small oscillations about steady sliding; see
/// [`OscillatingFriction`](crate::joint::OscillatingFriction).
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionMemory {
    /// Slope of the coefficient in steady sliding, s/m.
    pub steady_slope: f64,
    /// Frequency at which an oscillation is as fast as the state follows the speed, Hz.
    pub follows_up_to_hz: f64,
    /// Frequency above which friction damps although it falls with the speed in steady sliding, Hz.
    pub damping_above_hz: Option<f64>,
    /// Slope that acts at the frequency of the mode with the largest growth rate, s/m.
    pub fastest_slope: Option<f64>,
    /// Linearised modes if friction depended on the speed alone, as in steady sliding.
    pub modes_of_speed_alone: Vec<NamedMode>,
}

/// A measured friction curve at the sliding speed.
#[derive(Clone, Debug, PartialEq)]
pub struct TableReading {
    /// Number of points.
    pub points: usize,
    /// Speeds of the first and the last point, m/s.
    pub speeds: [f64; 2],
    /// Coefficient of friction at the sliding speed.
    pub mu: f64,
    /// Slope of the curve at the sliding speed, s/m.
    pub slope: f64,
    /// Slopes of the straight lines through neighbouring points, s/m: the smallest and the largest of the interval with
    /// the sliding speed and of those beside it. `None` outside the points.
    pub secants: Option<[f64; 2]>,
}

/// Growth of small vibrations while a joint turns from one reversal to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnstablePass {
    /// Direction in which the tilt changes.
    pub way: TiltDirection,
    /// Tilts between which a mode grows, in order of time, rad: where the largest growth rate exceeds zero first, and
    /// where it falls below zero last.
    pub unstable: Option<[f64; 2]>,
    /// Largest growth rate of the pass, 1/s.
    pub largest_growth_per_s: f64,
}

/// Birth of a torus at a Neimark-Sacker point of a periodic motion over the tilt, by Floquet multipliers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TorusBirth {
    /// Tilt of the Neimark-Sacker point, rad.
    pub tilt: f64,
    /// The periodic motion along its branch, in ascending order of the tilt.
    pub course: Vec<SecondToneGrowth>,
}

/// A periodic motion, and the second tone that belongs to a pair of its Floquet multipliers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondToneGrowth {
    /// Tilt, rad.
    pub tilt: f64,
    /// Frequency of the periodic motion, Hz.
    pub frequency_hz: f64,
    /// Distance of the side lines of the second tone from this frequency, Hz: the rotation number over the period.
    pub second_hz: f64,
    /// Growth rate of the second tone while it is small, `ln|multiplier|` over the period, 1/s.
    pub growth_per_s: f64,
}

impl TorusBirth {
    /// The second tone at a tilt (rad), linearly between the orbits; `None` beyond them.
    pub fn at(&self, tilt: f64) -> Option<SecondToneGrowth> {
        let after = self.course.partition_point(|point| point.tilt < tilt);
        let b = self.course.get(after)?;
        if b.tilt == tilt {
            return Some(*b);
        }
        let a = self.course.get(after.checked_sub(1)?)?;
        let share = (tilt - a.tilt) / (b.tilt - a.tilt);
        let between = |a: f64, b: f64| a + share * (b - a);
        Some(SecondToneGrowth {
            tilt,
            frequency_hz: between(a.frequency_hz, b.frequency_hz),
            second_hz: between(a.second_hz, b.second_hz),
            growth_per_s: between(a.growth_per_s, b.growth_per_s),
        })
    }

    /// The second tone at the Neimark-Sacker point.
    pub fn birth(&self) -> Option<SecondToneGrowth> {
        self.at(self.tilt)
    }
}

/// Coefficient of friction of two coupled modes, and the critical value for flutter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// Coefficient of friction of the run.
    pub mu: f64,
    /// Critical coefficient from the stiffness matrix of the run; `None` if there is none.
    pub critical: Option<f64>,
}

/// Predicted curves and the operating point of the run.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictedCurves {
    /// What the curves and the marks are.
    pub title: &'static str,
    /// Quantities and units of both axes.
    pub axes: [&'static str; 2],
    /// Name of each curve.
    pub names: &'static [&'static str],
    /// Points of each curve.
    pub curves: Vec<Vec<[f64; 2]>>,
    /// Operating points of the run.
    pub marks: Vec<[f64; 2]>,
}

impl MechanismPrediction {
    /// See [`unstable`].
    pub fn unstable(&self) -> Vec<&NamedMode> {
        unstable(&self.modes)
    }

    /// See [`fastest`].
    pub fn fastest(&self) -> Option<f64> {
        fastest(&self.modes)
    }

    /// The unstable mode within 5 % of a frequency (Hz): a large vibration shifts the frequency slightly.
    pub fn unstable_near(&self, frequency: f64) -> Option<&NamedMode> {
        let off = |mode: &NamedMode| (mode.frequency_hz / frequency - 1.0).abs();
        let unstable = self.modes.iter().filter(|mode| mode.unstable);
        let nearest = unstable.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        (off(nearest) < 0.05).then_some(nearest)
    }
}

/// Unstable modes, in descending order of growth rate.
pub fn unstable(modes: &[NamedMode]) -> Vec<&NamedMode> {
    let mut unstable: Vec<_> = modes.iter().filter(|mode| mode.unstable).collect();
    unstable.sort_by(|a, b| b.growth.total_cmp(&a.growth));
    unstable
}

/// Largest growth rate of a mode, 1/s; `None` if there is no mode.
pub fn fastest(modes: &[NamedMode]) -> Option<f64> {
    modes.iter().map(|mode| mode.growth).max_by(f64::total_cmp)
}
