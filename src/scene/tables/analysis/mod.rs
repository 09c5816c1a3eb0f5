//! What is made of the samples, and of the flow itself.

mod check;

use crate::analysis::{Direction, DivergenceMethod, Norm, Threshold};
use crate::scene::document::{FromTable, Table};
use crate::scene::error::{SceneError, ensure};
use crate::scene::schema::kind::Range::{Closed, HalfOpen, Open, Positive};
use crate::scene::schema::kind::{
    Coordinates, Count, List, Number, all_or, auto_or, choice, number,
};
use crate::scene::schema::unit::{KILOHERTZ, MICROMETRE, MICROSECOND, MILLISECOND, ONE};
use crate::scene::schema::{Key, Otherwise, Schema, keys};
use crate::scene::setting::{SectionSurface, Setting};

pub use check::read;

/// What the length of every sliding window must be.
const WINDOW: Number = number(MILLISECOND, Closed(0.1, 10_000.0));

/// What the time from one result to the next must be.
const EVERY: Number = number(MILLISECOND, Closed(0.01, 10_000.0));

/// What every delay must be.
const LAG: Number = number(MICROSECOND, Closed(0.5, 1e6));

/// What every embedding dimension must be.
const DIMENSION: Count = Count(1, 20);

/// What a Theiler window must be.
const THEILER: Number = number(MICROSECOND, Closed(0.0, 1e6));

/// What a time from the start must be.
const FROM_START: Number = number(MILLISECOND, Closed(0.0, 1e5));

/// The four thresholds of one table exclude one another.
const ONE_THRESHOLD: &str =
    "exactly one of `threshold_rate`, `threshold_um`, `threshold_spread` and `neighbours`";

keys! {
    /// Analyses; an absent one is not computed. SI units.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct AnalysisSpec {
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
        /// Kind of motion of the probe's displacement.
        ..regime: Option<RegimeSpec> => "analysis.regime";
        /// Lyapunov exponents from the tangent flow of the simulation itself.
        ..exponents: Option<ExponentsSpec> => "analysis.exponents";
        /// A second copy of the joint that starts almost in the same state.
        ..butterfly: Option<ButterflySpec> => "analysis.butterfly";
    }
}

/// A window that slides along the samples, and how often it is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlidingSpec {
    /// Length of the window, s.
    pub window: f64,
    /// Time from one look to the next, s.
    pub every: f64,
}

keys! {
    /// Amplitude spectrum.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct SpectrumSpec {
        /// The window, and the time between spectra.
        ..sliding: SlidingSpec {
            /// Length of the sliding window.
            window = "window_ms": WINDOW, default 20;
            /// Time between spectra.
            every = "every_ms": EVERY, default 5;
        };
    }

    /// Spectrogram.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct SpectrogramSpec {
        /// The window of a column, and the time between columns.
        ..sliding: SlidingSpec {
            /// Length of the window of one column.
            window = "window_ms": WINDOW, default 5;
            /// Time between columns.
            every = "every_ms": EVERY, default 0.5;
        };
        /// Highest frequency kept; at most half the sample rate.
        max_frequency: f64 = "max_frequency_khz": number(KILOHERTZ, Closed(0.1, 1000.0)), default 20;
    }

    /// Choice of delay and embedding dimension.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct DelaySpec {
        /// The window, and the time between choices.
        ..sliding: SlidingSpec {
            /// Length of the sliding window.
            window = "window_ms": WINDOW, default 20;
            /// Time between choices.
            every = "every_ms": EVERY, default 20;
        };
        /// Largest delay tried.
        largest_lag: f64 = "largest_lag_us": LAG, default 300;
        /// Largest embedding dimension tried.
        largest_dimension: usize = "largest_dimension": DIMENSION, default 8;
        /// Bins along an axis of the joint histogram behind the mutual information.
        bins: usize = "bins": Count(2, 256), default 32;
        /// Share of false neighbours that counts as none: the first dimension with no more is chosen.
        false_share: f64 = "false_share": number(ONE, HalfOpen(0.0, 1.0)), default 0.01;
    }

    /// Delay vectors, Eq. (25).
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct EmbeddingSpec {
        /// Delay tau of Eq. (25); a quarter of the leading period unfolds the orbit best.
        lag: Setting<f64> = "lag_us": auto_or(LAG), default 60;
        /// Embedding dimension m of Eq. (25).
        dimension: Setting<usize> = "dimension": auto_or(DIMENSION), default 5;
    }
}

/// Which states count as the same, Eq. (26).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearnessSpec {
    /// How distances are measured.
    pub norm: Norm,
    /// Threshold `epsilon`; a distance is in m.
    pub threshold: Threshold,
}

keys! {
    NearnessSpec |table| {
        /// How distances between states are measured.
        norm = "norm": choice::<Norm>(), default "euclidean";
        /// Threshold of Eq. (26): the share of pairs of states that shall be recurrent.
        rate = "threshold_rate": number(ONE, Open(0.0, 1.0)), else ONE_THRESHOLD;
        /// Threshold of Eq. (26) as a distance between delay vectors instead.
        distance = "threshold_um": number(MICROMETRE, Positive(1e6)), else ONE_THRESHOLD;
        /// Threshold of Eq. (26) as a multiple of the displacement's standard deviation in the window instead.
        spread = "threshold_spread": number(ONE, Positive(100.0)), else ONE_THRESHOLD;
        /// Neighbours that each state shall have instead: a threshold of its own for each.
        neighbours = "neighbours": Count(1, 10_000), else ONE_THRESHOLD;
    } => {
        let threshold = only_one(table, [
            ("threshold_rate", rate.map(Threshold::Rate)),
            ("threshold_um", distance.map(Threshold::Distance)),
            ("threshold_spread", spread.map(Threshold::Spread)),
            ("neighbours", neighbours.map(Threshold::Neighbours)),
        ])?;
        NearnessSpec { norm, threshold }
    };
}

/// The threshold of which exactly one must be given.
fn only_one(
    table: Table<'_>,
    thresholds: [(&str, Option<Threshold>); 4],
) -> Result<Threshold, SceneError> {
    let mut given = thresholds.into_iter().filter(|(_, one)| one.is_some());
    let first = given.next().and_then(|(_, one)| one);
    let others: Vec<&str> = given.map(|(name, _)| name).collect();
    ensure!(table, others.is_empty() => others[others.len() - 1], &thresholds.map(|(name, _)| name);
        "the threshold is given more than once";
        "keep one of threshold_rate, threshold_um, threshold_spread and neighbours");
    table.needed("threshold_rate", first)
}

keys! {
    /// Evolving recurrence plot in a sliding window.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct RecurrenceSpec {
        /// The window, and the time between plots.
        ..sliding: SlidingSpec {
            /// Length of the sliding window.
            window = "window_ms": WINDOW, default 5;
            /// Time between plots.
            every = "every_ms": EVERY, default 2.5;
        };
        /// Points along a side of the plot.
        size: usize = "size": Count(16, 2048), default 400;
        /// The states.
        ..embedding: EmbeddingSpec;
        /// Which of them count as the same.
        ..nearness: NearnessSpec;
    }

    /// Recurrence quantification in a sliding window.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct QuantificationSpec {
        /// The window, and the time between its measures.
        ..sliding: SlidingSpec {
            /// Length of the sliding window.
            window = "window_ms": WINDOW, default 20;
            /// Time between measures.
            every = "every_ms": EVERY, default 5;
        };
        /// Spacing of the states, at least one sample; the delay is rounded to whole steps.
        step: f64 = "step_us": number(MICROSECOND, Closed(0.5, 1e6)), default 10;
        /// The states.
        ..embedding: EmbeddingSpec;
        /// Which of them count as the same.
        ..nearness: NearnessSpec;
        /// Theiler window: states nearer in time are not compared; at least one step, so that no state is compared with itself.
        theiler: f64 = "theiler_us": THEILER, default 60;
        /// Shortest diagonal line, in states; about a period tells repetition from mere smoothness.
        least_diagonal: usize = "least_diagonal": Count(2, 10_000), default 24;
        /// Shortest vertical line, in states.
        least_vertical: usize = "least_vertical": Count(2, 10_000), default 2;
    }

    /// Poincare section.
    #[derive(Clone, Debug, PartialEq)]
    pub struct SectionSpec {
        /// Time between reports of the passages.
        every: f64 = "every_ms": EVERY, default 1;
        /// Which way through the surface counts.
        direction: Direction = "direction": choice::<Direction>(), default "rising";
        /// The surface.
        ..surface: SectionSurface;
    }

    SectionSurface |table| {
        /// Delay tau of the surface y(t + tau) = level (Fig. 10); shown are y(t) and y(t + 2 tau).
        lag = "lag_us": auto_or(LAG), default 60;
        /// Level of that surface.
        level = "level_um": number(MICROMETRE, Closed(-1e6, 1e6)), default 0;
        /// A plane of the modal state as the surface instead: its normal along the modal coordinates, a number for each mode, by frequency.
        normal_q = "plane_q": List(number(ONE, Closed(-1e6, 1e6))), else "none; or `plane_qdot_ms`";
        /// The normal along the modal velocities: in ms, which makes sqrt(kg) um of sqrt(kg) mm/s.
        normal_qdot = "plane_qdot_ms": List(number(MILLISECOND, Closed(-1e6, 1e6))), else "none; or `plane_q`";
        /// Offset of the plane, in sqrt(kg) um: normal times state is this on it.
        offset = "offset_um": number(MICROMETRE, Closed(-1e6, 1e6)), else "0, with a plane";
        /// The two coordinates of the modal state that are shown, such as `["q1", "qdot1"]`: modes counted from 1, by frequency.
        shown = "shown": Coordinates, else "required with a plane";
    } => if normal_q.is_none() && normal_qdot.is_none() {
        let problem = "it belongs to a plane of the modal state, and none is given";
        table.refuse(&["offset_um", "shown"], &[], problem, "add plane_q or plane_qdot_ms, or leave it out")?;
        SectionSurface::Delay { lag, level }
    } else {
        let problem = "the section is given twice, in delay coordinates and as a plane of the modal state";
        table.refuse(&["lag_us", "level_um"], &[], problem, "keep one of them")?;
        SectionSurface::State {
            normal_q: normal_q.unwrap_or_default(),
            normal_qdot: normal_qdot.unwrap_or_default(),
            offset: offset.unwrap_or(0.0),
            shown: table.needed("shown", shown)?,
        }
    };

    /// Chaos from data alone, in a sliding window: how neighbours part, and the 0-1 test.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ChaosSpec {
        /// The window, and the time between results.
        ..sliding: SlidingSpec {
            /// Length of the sliding window.
            window = "window_ms": WINDOW, default 90;
            /// Time between results.
            every = "every_ms": EVERY, default 20;
        };
        /// The states.
        ..embedding: EmbeddingSpec;
        /// Theiler window: states nearer in time are no neighbours; the leading period or more.
        theiler: f64 = "theiler_us": THEILER, default 500;
        /// How long neighbours are followed.
        horizon: f64 = "horizon_ms": number(MILLISECOND, Closed(0.01, 10_000.0)), default 30;
        /// Whose distance is followed.
        ..method: DivergenceMethod;
    }
}

/// The ways to follow neighbours by name; the radius is a key of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::VariantArray, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
enum Divergence {
    /// Nearest neighbours.
    Rosenstein,
    /// All within a radius.
    Kantz,
}

keys! {
    DivergenceMethod |table| {
        /// Whose distance is followed: the nearest neighbour's of each state, or that of all within a radius.
        method = "method": choice::<Divergence>(), default "rosenstein";
        /// That radius, over the displacement's standard deviation in the window.
        radius = "radius": number(ONE, Positive(10.0)), else "required with `kantz`";
    } => match method {
        Divergence::Rosenstein => {
            let remedy = "leave it out, or take method = \"kantz\"";
            table.refuse(&["radius"], &[], "nearest neighbours have no radius", remedy)?;
            DivergenceMethod::Rosenstein
        }
        Divergence::Kantz => DivergenceMethod::Kantz { radius: table.needed("radius", radius)? },
    };

    /// Verdict on the kind of motion in a sliding window.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct RegimeSpec {
        /// The window, and the time between verdicts.
        ..sliding: SlidingSpec {
            /// Length of the sliding window; of a long one the newest 10,000 samples are judged, or as many means of a few each.
            window = "window_ms": WINDOW, default 40;
            /// Time between verdicts.
            every = "every_ms": EVERY, default 10;
        };
        /// Amplitude of the displacement below which the joint is silent.
        silence: f64 = "silence_um": number(MICROMETRE, Closed(0.0, 1e6)), default 0.0003;
    }

    /// Lyapunov exponents, Eq. (23), from tangent vectors that go along with the state.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ExponentsSpec {
        /// How many Lyapunov exponents, the largest first; all are twice as many as there are modes.
        count: usize = "count": all_or(Count(1, 1000)), default 3;
        /// Time from the start whose growth is forgotten: until the motion has found its attractor.
        settle: f64 = "settle_ms": FROM_START, default 50;
        /// Time between results.
        every: f64 = "every_ms": EVERY, default 1;
    }

    /// The butterfly: a second copy of the joint from almost the same state.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ButterflySpec {
        /// When the second copy of the joint starts, almost in the state of the first.
        start: f64 = "start_ms": FROM_START, default 50;
        /// How far apart the two start, in the norm of the vibration's energy: a share of the size that the motion has had by then.
        distance: f64 = "distance": number(ONE, Closed(1e-12, 0.01)), default 1e-9;
        /// Time between results.
        every: f64 = "every_ms": EVERY, default 1;
    }
}
