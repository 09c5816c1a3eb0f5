//! What is measured of a signal to tell its kind.

use std::f64::consts::LN_2;

use super::neighbourhood::{DIMENSION, Foretold, LEAST_ERROR, Neighbourhood, TURN};
use crate::analysis::{
    AnalysisError, Bases, Combination, DelaySearch, DelayVectors, Direction, DivergenceSearch,
    Line, LineCriterion, Naming, ScalingRegion, SectionShape, SpectrumAnalyser, Window,
    ZeroOneTest, delay_section, divergence, mutual_information, name_lines, range, section_shape,
    zero_one,
};

/// Pieces of the record whose levels and periods are compared.
const PIECES: usize = 8;

/// The largest lag tried.
const LARGEST_LAG: usize = 200;

/// A signal with a larger error of prediction is not foretold; it is if the neighbour's is this
/// share of that of a linear map.
const UNFORETOLD: f64 = 0.4;
const LAWFUL: f64 = 0.7;

/// The longest period looked for in the section, in passages; four multiples of it must fit in
/// half of them.
const LONGEST_PERIOD: usize = 8;

/// The fewest passages of which a period is told.
const FEWEST_PASSAGES: usize = 24;

/// Samples of the 0-1 test, the last ones taken.
const DRIFT_SAMPLES: usize = 2000;

/// The most passages of the section, the last ones.
const PASSAGES: usize = 400;

/// States followed for the exponent.
const EXPONENT_REFERENCES: usize = 300;

/// A line stands out if it is this many times the floor: noise does that once in 10^12 bins.
const ABOVE_FLOOR: f64 = 6.5;

/// Standard uncertainty of a line's frequency, in bins, where it is given a name.
const LINE_UNCERTAINTY: f64 = 0.1;

/// The same where two bases are compared, which are strong lines: 1e-4 without noise.
const STEP_UNCERTAINTY: f64 = 0.02;

/// By how much the upper quarter of a white floor may lie below the rest by chance.
const WHITE_SCATTER: f64 = 1.3;

/// Two tones are in step if a multiple up to this of one is a multiple of the other.
const LONGEST_STEP: u32 = 8;

/// A change over the record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trend {
    /// From the first piece to the last, on the line of least squares.
    pub change: f64,
    /// The slope over its standard error.
    pub clarity: f64,
}

/// How the lines of the spectrum read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Tones {
    /// No line.
    None,
    /// Harmonics of one tone (Hz); the strongest line that is none, over the strongest of all.
    One { f1: f64, stray: f64 },
    /// Two tones (Hz) and their combinations; the strongest line that the second takes part in,
    /// over the strongest of all.
    Two { f1: f64, f2: f64, second: f64 },
    /// Two tones in step: `f2 / f1 = p / q`.
    InStep { f1: f64, p: u32, q: u32 },
    /// So many lines that fit neither one tone nor two.
    Many(usize),
}

/// All that is measured.
#[derive(Clone, Debug)]
pub(super) struct Signs {
    /// Turns in the record: of four lags, or passages, whichever are more.
    pub turns: f64,
    /// Of the natural logarithm of the root mean square.
    pub envelope: Trend,
    /// Natural logarithm of the root mean square of the loudest piece over that of the faintest.
    pub unevenness: f64,
    /// Of the natural logarithm of the time between passages of the section.
    pub tempo: Option<Trend>,
    /// Share of the power in the floor of the spectrum.
    pub floor: f64,
    /// The part of that which white noise does not explain: the floor is higher where the motion
    /// is than in the upper quarter of the frequencies.
    pub coloured: f64,
    pub tones: Tones,
    pub section: SectionShape,
    pub passages: usize,
    /// How well the signal is foretold.
    pub foretold: Foretold,
    /// How far neighbours have parted, natural logarithm, from a thirtieth of the record on to a
    /// quarter of it.
    pub parting: f64,
    /// How much farther away the nearest state is that is far in time, than the nearest at any
    /// time: natural logarithm. 0 for a motion that lasts.
    pub wandering: f64,
    /// States among which neighbours are looked for.
    pub states: usize,
    /// How far the passages are from those a period before, however many periods, over the
    /// deviation of the signal; and the period, in passages.
    pub periodic: Option<(f64, usize)>,
    /// 0-1 test, and the samples it had.
    pub drift: Option<(f64, usize)>,
    /// Rate at which neighbours part, and its error, for a turn.
    pub exponent: Option<[f64; 2]>,
}

impl Signs {
    /// Of samples between -1 and 1 that are not all the same, at least
    /// [`super::RegimeSearch::FEWEST_SAMPLES`].
    pub(super) fn of(samples: &[f64], sample_rate: f64) -> Result<Self, AnalysisError> {
        let n = samples.len();
        let mean = samples.iter().sum::<f64>() / n as f64;
        let centred: Vec<f64> = samples.iter().map(|x| x - mean).collect();
        let power = centred.iter().map(|x| x * x).sum::<f64>() / n as f64;

        let spectrum =
            SpectrumAnalyser::new(Window::BlackmanHarris, sample_rate).analyse(&centred)?;
        let criterion = LineCriterion {
            above_floor: ABOVE_FLOOR,
            ..LineCriterion::default()
        };
        let lines = spectrum.lines(&criterion);
        let naming = name_lines(&lines, LINE_UNCERTAINTY * spectrum.bin);
        let tones = Tones::read(&lines, &naming, STEP_UNCERTAINTY * spectrum.bin);

        let lag = lag(&centred)?;
        let crossings = delay_section(&centred, lag, 3, 0.0, Direction::Rising)?;
        let instants: Vec<f64> = crossings.iter().map(|c| c.sample).collect();
        // The first and the last passage are located on fewer samples.
        let inner = crossings.get(1..crossings.len().max(2) - 1).unwrap_or(&[]);
        let last = &inner[inner.len().saturating_sub(PASSAGES)..];
        let points: Vec<&[f64]> = last.iter().map(|c| c.point.as_slice()).collect();
        let [low, high] = range(centred.iter().copied());

        let vectors = DelayVectors::new(&centred, lag, DIMENSION)?;
        let neighbourhood = Neighbourhood::new(vectors, lag, power);
        let mut foretold = neighbourhood.foretold();
        if lag > 1 && foretold.near > UNFORETOLD {
            // A map forgets too fast for a quarter turn; sample by sample it may still be lawful.
            let vectors = DelayVectors::new(&centred, 1, DIMENSION)?;
            let next = Neighbourhood::new(vectors, 1, power).foretold();
            if next.near < LAWFUL * next.linear {
                foretold = Foretold { map: true, ..next };
            }
        }
        let levels = levels(&centred, power);
        let [faintest, loudest] = range(levels);
        let stride = ZeroOneTest::stride_for(&centred).max(lag);
        let late = &centred[n.saturating_sub(DRIFT_SAMPLES * stride)..];
        let drift = zero_one(late, &ZeroOneTest::with_stride(stride));
        let turn = (TURN * lag) as f64;
        Ok(Self {
            turns: (n as f64 / turn).max(crossings.len() as f64),
            envelope: Trend::of(&levels),
            unevenness: loudest - faintest,
            tempo: periods(&instants).map(|periods| Trend::of(&periods)),
            floor: spectrum.floor_share(),
            coloured: spectrum.floor_share() * colour(&spectrum.floor()),
            tones,
            section: section_shape(&points, high - low),
            passages: crossings.len(),
            foretold,
            parting: neighbourhood.parting(),
            wandering: neighbourhood.wandering(),
            states: vectors.len(),
            periodic: repetition(&points).map(|(apart, period)| (apart / power.sqrt(), period)),
            drift: drift.ok().map(|result| (result.k, result.samples)),
            exponent: exponent(&centred, lag).map(|r| [r.slope * turn, r.error * turn]),
        })
    }

    /// The floor over what noise would have to make it, given how well the next lag is foretold.
    pub(super) fn lawful_floor(&self) -> f64 {
        self.floor / self.foretold.near.max(LEAST_ERROR).powi(2)
    }

    /// How far the passages are from those a period before over what noise explains.
    pub(super) fn unrepeated(&self) -> Option<f64> {
        let (apart, _) = self.periodic?;
        Some(apart / self.foretold.near.max(LEAST_ERROR))
    }

    /// How much the error of prediction grows from a lag to many turns.
    pub(super) fn growth(&self) -> f64 {
        self.foretold.far / self.foretold.near.max(LEAST_ERROR)
    }

    /// The neighbour's error of prediction over that of a linear map.
    pub(super) fn against_linear(&self) -> f64 {
        self.foretold.near / self.foretold.linear.max(1e-9)
    }
}

impl Tones {
    /// Lines, strongest first, whose frequencies differ from steps of each other by no more than
    /// `uncertainty` (Hz) if they are in step.
    fn read(lines: &[Line], naming: &Naming, uncertainty: f64) -> Self {
        // Of the lines with such a name, over the strongest of all.
        let strongest = |such: fn(&Option<Combination>) -> bool| {
            let mut named = lines.iter().zip(&naming.names);
            let line = named.find(|(_, name)| such(name));
            line.map_or(0.0, |(line, _)| line.amplitude / lines[0].amplitude)
        };
        match naming.bases {
            Bases::None if lines.is_empty() => Self::None,
            Bases::None => Self::Many(lines.len()),
            Bases::One { f1 } => Self::One {
                f1,
                stray: strongest(|name| name.is_none()),
            },
            Bases::Two { f1, f2 } => match in_step(f1, f2, uncertainty) {
                Some((p, q)) => Self::InStep { f1, p, q },
                None => Self::Two {
                    f1,
                    f2,
                    second: strongest(|name| name.is_some_and(|name| name.m != 0)),
                },
            },
        }
    }
}

impl Trend {
    /// On the line of least squares through these values.
    fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let place = |i: usize| i as f64 - 0.5 * (n - 1.0);
        let both = || values.iter().enumerate().map(|(i, y)| (place(i), y - mean));
        let spread: f64 = both().map(|(t, _)| t * t).sum();
        let slope = both().map(|(t, y)| t * y).sum::<f64>() / spread;
        let rest: f64 = both().map(|(t, y)| (y - slope * t).powi(2)).sum();
        let error = (rest / (n - 2.0) / spread).sqrt();
        // By chance all of eight values rise once in 40,000 times; a trend need not be straight.
        let rising = values.is_sorted_by(|a, b| a < b);
        let falling = values.is_sorted_by(|a, b| a > b);
        Self {
            change: slope * (n - 1.0),
            clarity: match rising || falling {
                true => f64::INFINITY,
                false => slope.abs() / error.max(1e-12),
            },
        }
    }
}

/// Natural logarithm of the root mean square of each piece; a silent one has -69 dB to the whole
/// (`exp -8`).
fn levels(centred: &[f64], power: f64) -> [f64; PIECES] {
    std::array::from_fn(|p| {
        let n = centred.len();
        let piece = &centred[p * n / PIECES..(p + 1) * n / PIECES];
        let mean = piece.iter().sum::<f64>() / piece.len() as f64;
        let own = piece.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / piece.len() as f64;
        0.5 * (own / power).max((-16.0_f64).exp()).ln()
    })
}

/// Natural logarithm of the mean time between instants in each of as many pieces with equally many
/// of them; `None` if there are not three to each.
fn periods(instants: &[f64]) -> Option<[f64; PIECES]> {
    let count = instants.len().checked_sub(1)?;
    let edge = |p: usize| p * count / PIECES;
    let period = |p| {
        let (from, to) = (edge(p), edge(p + 1));
        ((instants[to] - instants[from]) / (to - from) as f64).ln()
    };
    (count >= 3 * PIECES).then(|| std::array::from_fn(period))
}

/// `p / q` in lowest terms if that is `f2 / f1` within the uncertainty, `q` up to
/// [`LONGEST_STEP`].
fn in_step(f1: f64, f2: f64, uncertainty: f64) -> Option<(u32, u32)> {
    let ratio = f2 / f1;
    (1..=LONGEST_STEP).find_map(|q| {
        let p = (f64::from(q) * ratio).round();
        let miss = (f64::from(q) * f2 - p * f1).abs();
        let close = miss <= uncertainty * (f64::from(q).powi(2) + p * p).sqrt();
        (close && p >= 1.0).then_some((p as u32, q))
    })
}

/// The share of the power of a floor that is not white.
fn colour(floor: &[f64]) -> f64 {
    let power = |part: &[f64]| part.iter().map(|a| a * a).sum::<f64>() / part.len() as f64;
    let (all, white) = (power(floor), power(&floor[floor.len() * 3 / 4..]));
    if all > 0.0 {
        (1.0 - WHITE_SCATTER * white / all).max(0.0)
    } else {
        0.0
    }
}

/// First clear minimum of the mutual information, or where it falls below 1/e.
pub(super) fn lag(samples: &[f64]) -> Result<usize, AnalysisError> {
    let n = samples.len();
    let largest = (n / 25).clamp(1, LARGEST_LAG);
    let mutual = mutual_information(samples, largest, DelaySearch::for_samples(n).bins)?;
    let minimum = mutual.first_clear_minimum();
    let lag = minimum.or_else(|| mutual.first_below((-1.0_f64).exp()));
    Ok(lag.unwrap_or(largest).max(1))
}

/// How far passages are apart (in a coordinate, as noise would have it) that are a period or a
/// multiple of it apart, up to half of the passages, for the period at which that is smallest;
/// `None` for fewer than [`FEWEST_PASSAGES`].
///
/// Medians: noise makes a few passages too many, in wrong places.
fn repetition(points: &[&[f64]]) -> Option<(f64, usize)> {
    let half = points.len() / 2;
    if points.len() < FEWEST_PASSAGES {
        return None;
    }
    let square = |(a, b): (&&[f64], &&[f64])| {
        let differences = a.iter().zip(*b).map(|(a, b)| a - b);
        differences.map(|d| d * d).sum::<f64>()
    };
    let mut squares = Vec::with_capacity(points.len());
    let mut apart = |passages: usize| {
        squares.clear();
        squares.extend(points.iter().zip(&points[passages..]).map(square));
        let middle = squares.len() / 2;
        // Of two coordinates (the third is the level) with the noise of both passages; the median
        // of an exponential variable is ln 2.
        *squares.select_nth_unstable_by(middle, f64::total_cmp).1 / (4.0 * LN_2)
    };
    let apart: Vec<f64> = (0..=half).map(&mut apart).collect();
    let of_period = |period: usize| {
        let multiples = apart[period..].iter().step_by(period);
        let count = multiples.len() as f64;
        ((multiples.sum::<f64>() / count).sqrt(), period)
    };
    (1..=LONGEST_PERIOD.min(points.len() / 8))
        .map(of_period)
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The straight part of the curve of parting neighbours.
fn exponent(centred: &[f64], lag: usize) -> Option<ScalingRegion> {
    let mut search = DivergenceSearch::for_delay(lag, DIMENSION, TURN * lag, centred.len());
    search.most_references = EXPONENT_REFERENCES;
    divergence(centred, &search).ok()?.region
}
