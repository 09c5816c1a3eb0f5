//! Analyses of the samples and of the flow.

mod check;

use strum::{EnumString, IntoStaticStr, VariantArray};

use crate::analysis::{
    chaos::DivergenceMethod,
    poincare::Direction,
    recurrence::{Norm, Threshold},
};
use crate::scene::document::{FromTable, Table};
use crate::scene::error::{SceneError, ensure};
use crate::scene::schema::kind::Range::{Closed, HalfOpen, Open, Positive};
use crate::scene::schema::kind::{Kind, all_or, auto_or, choice, coordinates, count, list, number};
use crate::scene::schema::unit::*;
use crate::scene::schema::{IfAbsent, Key, Schema, keys};

pub use check::read;

/// Range of the lengths of sliding windows.
const WINDOW: Kind<f64> = number(MILLISECOND, Closed(0.1, 10_000.0));

/// Range of the intervals between results.
const EVERY: Kind<f64> = number(MILLISECOND, Closed(0.01, 10_000.0));

/// Range of delays.
const LAG: Kind<f64> = number(MICROSECOND, Closed(0.5, 1e6));

/// Range of embedding dimensions.
const DIMENSION: Kind<usize> = count(1, 20);

/// Range of Theiler windows.
const THEILER: Kind<f64> = number(MICROSECOND, Closed(0.0, 1e6));

/// Range of times from the start of the run.
const FROM_START: Kind<f64> = number(MILLISECOND, Closed(0.0, 1e5));

/// The four thresholds of a table exclude each other.
const ONE_THRESHOLD: &str =
    "exactly one of `recurrence_rate`, `threshold_um`, `threshold_std` and `neighbours`";

/// The budget of an analysis: the windows that are computed if the analyses are slow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, VariantArray, IntoStaticStr, EnumString)]
#[strum(serialize_all = "kebab-case")]
pub enum AnalysisBudget {
    /// Every window that the scene requests.
    #[default]
    Complete,
    /// Every second, fourth, ... window of the displayed analyses while they are slower than real time.
    Realtime,
}

keys! {
    /// Analyses; an absent table is not computed. SI units.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct AnalysisSpec {
        /// Windows that are computed: all, or fewer of those that are only displayed while they take longer than the simulated time.
        budget: AnalysisBudget = "budget": choice::<AnalysisBudget>(), default "complete";
        /// Sliding amplitude spectrum of the probe's velocity.
        ..spectrum: Option<SpectrumSpec> => "analysis.spectrum";
        /// Spectrogram of the probe's velocity.
        ..spectrogram: Option<SpectrogramSpec> => "analysis.spectrogram";
        /// Choice of delay and embedding dimension from the probe's displacement.
        ..delay: Option<DelaySpec> => "analysis.delay";
        /// Recurrence plot of the probe's displacement.
        ..recurrence: Option<RecurrenceSpec> => "analysis.recurrence";
        /// Recurrence quantification of the probe's displacement.
        ..quantification: Option<QuantificationSpec> => "analysis.quantification";
        /// Poincare section.
        ..section: Option<SectionSpec> => "analysis.section";
        /// Largest Lyapunov exponent and 0-1 test of the probe's displacement.
        ..chaos: Option<ChaosSpec> => "analysis.chaos";
        /// Type of motion from the probe's displacement.
        ..regime: Option<RegimeSpec> => "analysis.regime";
        /// Lyapunov exponents from the tangent flow of the simulation.
        ..exponents: Option<LyapunovSpec> => "analysis.lyapunov";
        /// A perturbed trajectory of the system and its divergence.
        ..perturbed_trajectory: Option<PerturbedTrajectorySpec> => "analysis.perturbed_trajectory";
    }
}

impl AnalysisSpec {
    /// Names of the analyses that are computed, which are those of their records.
    pub fn names(&self) -> Vec<&'static str> {
        let all = [
            ("spectrum", self.spectrum.is_some()),
            ("spectrogram", self.spectrogram.is_some()),
            ("delay", self.delay.is_some()),
            ("recurrence", self.recurrence.is_some()),
            ("quantification", self.quantification.is_some()),
            ("section", self.section.is_some()),
            ("chaos", self.chaos.is_some()),
            ("regime", self.regime.is_some()),
            ("exponents", self.exponents.is_some()),
            ("perturbed", self.perturbed_trajectory.is_some()),
        ];
        let on = all.into_iter().filter(|(_, on)| *on);
        on.map(|(name, _)| name).collect()
    }
}

keys! {
    /// Amplitude spectrum.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct SpectrumSpec {
        /// Length of the sliding window.
        window: f64 = "window_ms": WINDOW, default 20;
        /// Interval between spectra.
        every: f64 = "every_ms": EVERY, default 5;
        /// Peak velocity below which the vibration is at rest, so that its lines are not named.
        rest: Option<f64> = "rest_mm_per_s": number(MILLIMETRE_PER_SECOND, Closed(0.0, 1000.0)), else "1e-6 of the sliding speed";
    }

    /// Spectrogram.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct SpectrogramSpec {
        /// Length of the window of one column.
        window: f64 = "window_ms": WINDOW, default 5;
        /// Interval between columns.
        every: f64 = "every_ms": EVERY, default 0.5;
        /// Maximum frequency shown; at most half the sampling rate.
        max_frequency: f64 = "max_frequency_khz": number(KILOHERTZ, Closed(0.1, 1000.0)), default 20;
    }

    /// Choice of delay and embedding dimension.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct DelaySpec {
        /// Length of the sliding window.
        window: f64 = "window_ms": WINDOW, default 20;
        /// Interval between choices.
        every: f64 = "every_ms": EVERY, default 20;
        /// Maximum delay tested.
        largest_lag: f64 = "max_lag_us": LAG, default 300;
        /// Maximum embedding dimension tested.
        largest_dimension: usize = "max_dimension": DIMENSION, default 8;
        /// Bins along each axis of the joint histogram for the mutual information.
        bins: usize = "bins": count(2, 256), default 32;
        /// Maximum share of false nearest neighbours: the smallest dimension that does not exceed it is chosen.
        false_share: f64 = "max_false_neighbour_share": number(ONE, HalfOpen(0.0, 1.0)), default 0.01;
    }

    /// Delay vectors, Eq. (25). What is `None` is the latest choice of [`AnalysisSpec::delay`], undefined before the first
    /// choice.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct EmbeddingSpec {
        /// Delay tau of Eq. (25); a quarter of the dominant period unfolds the orbit best.
        lag: Option<f64> = "lag_us": auto_or(LAG), default 60;
        /// Embedding dimension m of Eq. (25).
        dimension: Option<usize> = "dimension": auto_or(DIMENSION), default 5;
    }
}

/// Recurrence criterion, Eq. (26): which states count as recurrent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThresholdSpec {
    /// Norm of the distance between states.
    pub norm: Norm,
    /// Threshold `epsilon`; a distance is in m.
    pub threshold: Threshold,
}

keys! {
    ThresholdSpec |table| {
        /// Norm of the distance between states.
        norm = "norm": choice::<Norm>(), default "euclidean";
        /// Threshold of Eq. (26) by the share of recurrent pairs of states (recurrence rate).
        rate = "recurrence_rate": number(ONE, Open(0.0, 1.0)), else ONE_THRESHOLD;
        /// Threshold of Eq. (26) as a distance between delay vectors.
        distance = "threshold_um": number(MICROMETRE, Positive(1e6)), else ONE_THRESHOLD;
        /// Threshold of Eq. (26) as a multiple of the standard deviation of the displacement in the window.
        spread = "threshold_std": number(ONE, Positive(100.0)), else ONE_THRESHOLD;
        /// Number of nearest neighbours of each state, which gives each state an individual threshold.
        neighbours = "neighbours": count(1, 10_000), else ONE_THRESHOLD;
    } => {
        let threshold = only_one(table, [
            ("recurrence_rate", rate.map(Threshold::Rate)),
            ("threshold_um", distance.map(Threshold::Distance)),
            ("threshold_std", spread.map(Threshold::Spread)),
            ("neighbours", neighbours.map(Threshold::Neighbours)),
        ])?;
        ThresholdSpec { norm, threshold }
    };
}

/// Returns the threshold; exactly one must be given.
fn only_one(
    table: Table<'_>,
    thresholds: [(&str, Option<Threshold>); 4],
) -> Result<Threshold, SceneError> {
    let mut given = thresholds.into_iter().filter(|(_, one)| one.is_some());
    let first = given.next().and_then(|(_, one)| one);
    let others: Vec<&str> = given.map(|(name, _)| name).collect();
    ensure!(table, others.is_empty() => others[others.len() - 1], &thresholds.map(|(name, _)| name);
        "the scene gives more than one threshold";
        "keep one of recurrence_rate, threshold_um, threshold_std and neighbours");
    table.needed("recurrence_rate", first)
}

keys! {
    /// Recurrence plot in a sliding window.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct RecurrenceSpec {
        /// Length of the sliding window.
        window: f64 = "window_ms": WINDOW, default 5;
        /// Interval between plots.
        every: f64 = "every_ms": EVERY, default 2.5;
        /// Number of points along each side of the plot.
        size: usize = "size": count(16, 2048), default 400;
        /// Delay vectors.
        ..embedding: EmbeddingSpec;
        /// Recurrence criterion.
        ..criterion: ThresholdSpec;
    }

    /// Recurrence quantification in a sliding window.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct QuantificationSpec {
        /// Length of the sliding window.
        window: f64 = "window_ms": WINDOW, default 20;
        /// Interval between measures.
        every: f64 = "every_ms": EVERY, default 5;
        /// Spacing of the states, at least one sample; the delay is rounded to a multiple of it.
        step: f64 = "step_us": number(MICROSECOND, Closed(0.5, 1e6)), default 10;
        /// Delay vectors.
        ..embedding: EmbeddingSpec;
        /// Recurrence criterion.
        ..criterion: ThresholdSpec;
        /// Theiler window: states closer in time are not compared; at least one step, so that no state is compared with itself.
        theiler: f64 = "theiler_us": THEILER, default 60;
        /// Minimum length of diagonal lines, in states; about one period distinguishes recurrence from smoothness.
        least_diagonal: usize = "min_diagonal_length": count(2, 10_000), default 24;
        /// Minimum length of vertical lines, in states.
        least_vertical: usize = "min_vertical_length": count(2, 10_000), default 2;
    }

    /// Poincare section.
    #[derive(Clone, Debug, PartialEq)]
    pub struct SectionSpec {
        /// Interval between reports of the crossings.
        every: f64 = "every_ms": EVERY, default 1;
        /// Direction of the crossings.
        direction: Direction = "direction": choice::<Direction>(), default "rising";
        /// The surface.
        ..surface: SectionSurface;
    }

    SectionSurface |table| {
        /// Delay tau of the surface y(t + tau) = level (Fig. 10); the coordinates are y(t) and y(t + 2 tau).
        lag = "lag_us": auto_or(LAG), default 60;
        /// Level of that surface.
        level = "level_um": number(MICROMETRE, Closed(-1e6, 1e6)), default 0;
        /// A plane in the modal state space as an alternative surface: components of its normal along the modal coordinates, one for each mode in order of frequency.
        normal_q = "plane_q": list(number(ONE, Closed(-1e6, 1e6))), else "none; or `plane_qdot_ms`";
        /// Components of the normal along the modal velocities, in ms (a velocity in sqrt(kg) mm/s times ms is in sqrt(kg) um).
        normal_qdot = "plane_qdot_ms": list(number(MILLISECOND, Closed(-1e6, 1e6))), else "none; or `plane_q`";
        /// Offset of the plane, in sqrt(kg) um: the scalar product of normal and state on the plane.
        offset = "offset_um": number(MICROMETRE, Closed(-1e6, 1e6)), else "0, with a plane";
        /// The two coordinates of the section plot, such as `["q1", "qdot1"]`; modes are counted from 1 in order of frequency.
        shown = "coordinates": coordinates(), else "required with a plane";
    } => if normal_q.is_none() && normal_qdot.is_none() {
        let problem = "this key applies to a plane in the modal state space, and the scene gives none";
        table.reject(&["offset_um", "coordinates"], &[], problem, "add plane_q or plane_qdot_ms, or remove this key")?;
        SectionSurface::Delay { lag, level }
    } else {
        let problem = "the scene gives two surfaces, one in delay coordinates and one in the modal state space";
        table.reject(&["lag_us", "level_um"], &[], problem, "remove one of them")?;
        SectionSurface::State {
            normal_q: normal_q.unwrap_or_default(),
            normal_qdot: normal_qdot.unwrap_or_default(),
            offset: offset.unwrap_or(0.0),
            shown: table.needed("coordinates", shown)?,
        }
    };

    /// Chaos indicators from data in a sliding window: divergence of nearby trajectories, and the 0-1 test.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ChaosSpec {
        /// Length of the sliding window.
        window: f64 = "window_ms": WINDOW, default 90;
        /// Interval between results.
        every: f64 = "every_ms": EVERY, default 20;
        /// Delay vectors.
        ..embedding: EmbeddingSpec;
        /// Theiler window: states closer in time are not neighbours; at least the dominant period.
        theiler: f64 = "theiler_us": THEILER, default 500;
        /// Time for which the divergence is computed.
        horizon: f64 = "horizon_ms": number(MILLISECOND, Closed(0.01, 10_000.0)), default 30;
        /// Definition of the neighbours.
        ..method: DivergenceMethod;
    }
}

/// Names of the methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq, VariantArray, IntoStaticStr, EnumString)]
#[strum(serialize_all = "kebab-case")]
enum Divergence {
    /// The nearest neighbour of each state.
    Rosenstein,
    /// All neighbours within a radius.
    Kantz,
}

keys! {
    DivergenceMethod |table| {
        /// Neighbours whose divergence is computed: the nearest neighbour of each state, or all within a radius.
        method = "method": choice::<Divergence>(), default "rosenstein";
        /// Radius of the neighbourhood, divided by the standard deviation of the displacement in the window.
        radius = "radius": number(ONE, Positive(10.0)), with ["kantz"];
    } => {
        table.reject_unused("method", method.into())?;
        match method {
            Divergence::Rosenstein => DivergenceMethod::Rosenstein,
            Divergence::Kantz => DivergenceMethod::Kantz { radius: table.needed("radius", radius)? },
        }
    };

    /// Classification of the type of motion in a sliding window.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct RegimeSpec {
        /// Length of the sliding window; in a long window the latest 10,000 samples are classified, or as many averages of a few samples.
        window: f64 = "window_ms": WINDOW, default 40;
        /// Interval between results.
        every: f64 = "every_ms": EVERY, default 10;
        /// Amplitude of the displacement below which the joint is silent.
        silence: f64 = "silence_um": number(MICROMETRE, Closed(0.0, 1e6)), default 0.0003;
    }

    /// Lyapunov exponents, Eq. (23), from tangent vectors integrated with the state.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct LyapunovSpec {
        /// Number of Lyapunov exponents, from the largest; there are twice as many as modes.
        count: usize = "count": all_or(count(1, 1000)), default 3;
        /// Discarded transient: growth before this time does not contribute, so that the motion can reach its attractor.
        settle: f64 = "transient_ms": FROM_START, default 50;
        /// Interval between results.
        every: f64 = "every_ms": EVERY, default 1;
    }

    /// A perturbed trajectory that starts near the state of the simulation.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct PerturbedTrajectorySpec {
        /// Start time of the perturbed trajectory.
        start: f64 = "start_ms": FROM_START, default 50;
        /// Initial distance in the energy norm, relative to the norm of the motion up to that time.
        distance: f64 = "initial_distance": number(ONE, Closed(1e-12, 0.01)), default 1e-9;
        /// Interval between results.
        every: f64 = "every_ms": EVERY, default 1;
    }
}

/// Surface of a Poincare section, and the coordinates shown of each crossing.
#[derive(Clone, Debug, PartialEq)]
pub enum SectionSurface {
    /// `y(t + lag) = level` of the delay trajectory (Fig. 10); the coordinates are `(y(t), y(t + 2 lag))`.
    Delay {
        /// Delay, s; `None` as in [`EmbeddingSpec`].
        lag: Option<f64>,
        /// Displacement at the surface, m.
        level: f64,
    },
    /// The plane `normal_q . q + normal_qdot . dq/dt = offset` of the modal state. Missing components of a
    /// normal are zero. Not available for a signal without modes.
    State {
        /// Components of the normal along the modal coordinates.
        normal_q: Vec<f64>,
        /// Components of the normal along the modal velocities, s.
        normal_qdot: Vec<f64>,
        /// Offset, sqrt(kg) m.
        offset: f64,
        /// The two coordinates of the section plot, sqrt(kg) m or sqrt(kg) m/s.
        shown: [StateCoordinate; 2],
    },
}

/// A coordinate of the modal state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateCoordinate {
    /// Modal coordinate of the mode with this index, from 0.
    Q(usize),
    /// Modal velocity of the mode with this index, from 0.
    Qdot(usize),
}
