//! What is measured of a signal to tell its kind.

use nalgebra::{SMatrix, SVector};

use crate::analysis::{
    AnalysisError, Bases, DelayVectors, Direction, DivergenceSearch, LineCriterion, NeighbourTree,
    Norm, ScalingRegion, SectionShape, SpectrumAnalyser, Window, ZeroOneTest, delay_section,
    divergence, mutual_information, name_lines, section_shape, zero_one,
};

/// Pieces of the record whose levels and periods are compared.
const PIECES: usize = 8;

/// Embedding dimension: that of the paper; enough for a torus of two tones, whatever its shape.
const DIMENSION: usize = 5;

/// Lags in a turn: the lag is about a quarter of it.
const TURN: usize = 4;

/// The largest lag tried.
const LARGEST_LAG: usize = 200;

/// Turns over which states and their neighbours are followed.
const FAR: usize = 10;

/// States whose neighbours are followed.
const REFERENCES: usize = 800;

/// Rows of the linear fit.
const ROWS: usize = 2000;

/// The most passages of the section, the last ones.
const PASSAGES: usize = 400;

/// States followed for the exponent.
const EXPONENT_REFERENCES: usize = 300;

/// Standard uncertainty of a line's frequency, in bins.
const LINE_UNCERTAINTY: f64 = 0.1;

/// A line stands out if it is this many times the floor: noise does that once in 10^12 bins.
const ABOVE_FLOOR: f64 = 6.5;

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
    /// Two tones and their combinations.
    Two { f1: f64, f2: f64 },
    /// Two tones in step: `f2 / f1 = p / q`.
    InStep { f1: f64, p: u32, q: u32 },
    /// So many lines that fit neither one tone nor two.
    Many(usize),
}

/// All that is measured.
#[derive(Clone, Debug)]
pub(super) struct Signs {
    /// Turns in the record.
    pub turns: f64,
    /// Of the natural logarithm of the root mean square.
    pub envelope: Trend,
    /// Of the natural logarithm of the time between passages of the section.
    pub tempo: Option<Trend>,
    /// Share of the power in the floor of the spectrum.
    pub floor: f64,
    pub tones: Tones,
    pub section: SectionShape,
    pub passages: usize,
    /// Error of prediction a lag ahead, by the neighbour and by a linear map, and many turns ahead
    /// by the neighbour; over the deviation of the signal.
    pub near: f64,
    pub linear: f64,
    pub far: f64,
    /// 0-1 test.
    pub drift: Option<f64>,
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
        let uncertainty = LINE_UNCERTAINTY * spectrum.bin;
        let naming = name_lines(&lines, uncertainty);
        let tones = match naming.bases {
            Bases::None if lines.is_empty() => Tones::None,
            Bases::None => Tones::Many(lines.len()),
            Bases::One { f1 } => {
                let mut unnamed = lines.iter().zip(&naming.names);
                let stray = unnamed.find(|(_, name)| name.is_none());
                Tones::One {
                    f1,
                    stray: stray.map_or(0.0, |(line, _)| line.amplitude / lines[0].amplitude),
                }
            }
            Bases::Two { f1, f2 } => match in_step(f1, f2, uncertainty) {
                Some((p, q)) => Tones::InStep { f1, p, q },
                None => Tones::Two { f1, f2 },
            },
        };

        let lag = lag(&centred)?;
        let crossings = delay_section(&centred, lag, 3, 0.0, Direction::Rising)?;
        let instants: Vec<f64> = crossings.iter().map(|c| c.sample).collect();
        // The first and the last passage are located on fewer samples.
        let inner = crossings.get(1..crossings.len().max(2) - 1).unwrap_or(&[]);
        let last = &inner[inner.len().saturating_sub(PASSAGES)..];
        let points: Vec<&[f64]> = last.iter().map(|c| c.point.as_slice()).collect();
        let (low, high) = extent(&centred);

        let [near, linear, far] = predictability(&centred, lag, power)?;
        let stride = ZeroOneTest::stride_for(&centred).max(lag);
        let drift = zero_one(&centred, &ZeroOneTest::with_stride(stride));
        let turn = (TURN * lag) as f64;
        Ok(Self {
            turns: n as f64 / turn,
            envelope: Trend::of(&levels(&centred, power)),
            tempo: periods(&instants).map(|periods| Trend::of(&periods)),
            floor: spectrum.floor_share(),
            tones,
            section: section_shape(&points, high - low),
            passages: crossings.len(),
            near,
            linear,
            far,
            drift: drift.ok().map(|result| result.k),
            exponent: exponent(&centred, lag).map(|r| [r.slope * turn, r.error * turn]),
        })
    }

    /// The floor over what noise would have to make it, given how well the next lag is foretold.
    pub(super) fn lawful_floor(&self) -> f64 {
        self.floor / self.near.powi(2).max(1e-6)
    }

    /// How much the error of prediction grows from a lag to many turns.
    pub(super) fn growth(&self) -> f64 {
        self.far / self.near.max(3e-3)
    }

    /// The neighbour's error of prediction over that of a linear map.
    pub(super) fn against_linear(&self) -> f64 {
        self.near / self.linear.max(1e-9)
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
        Self {
            change: slope * (n - 1.0),
            clarity: slope.abs() / error.max(1e-12),
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

/// First clear minimum of the mutual information, or where it falls below 1/e.
fn lag(samples: &[f64]) -> Result<usize, AnalysisError> {
    let n = samples.len();
    let largest = (n / 25).clamp(1, LARGEST_LAG);
    let mutual = mutual_information(
        samples,
        largest,
        crate::analysis::DelaySearch::for_samples(n).bins,
    )?;
    let minimum = mutual.first_clear_minimum();
    let lag = minimum.or_else(|| mutual.first_below((-1.0_f64).exp()));
    Ok(lag.unwrap_or(largest).max(1))
}

fn extent(samples: &[f64]) -> (f64, f64) {
    let (low, high) = (f64::INFINITY, f64::NEG_INFINITY);
    let wider = |(low, high): (f64, f64), &x: &f64| (low.min(x), high.max(x));
    samples.iter().fold((low, high), wider)
}

/// The errors of prediction `near`, `linear` and `far` of [`Signs`].
fn predictability(centred: &[f64], lag: usize, power: f64) -> Result<[f64; 3], AnalysisError> {
    let vectors = DelayVectors::new(centred, lag, DIMENSION)?;
    let turn = TURN * lag;
    let ahead = (FAR * turn).min(vectors.len() / 3).max(lag);
    let limit = vectors.len().saturating_sub(ahead).max(1);
    let newest = vectors.coordinate(DIMENSION - 1);
    let tree = NeighbourTree::new(vectors, Norm::Euclidean);
    // Over the last turn, so that the phase does not matter.
    let late = (0..TURN).map(|quarter| ahead.saturating_sub(quarter * lag));
    let (mut near, mut far, mut pairs) = (0.0, 0.0, 0.0);
    let references = REFERENCES.min(limit);
    for i in (0..references).map(|r| r * limit / references) {
        let Some(other) = tree.nearest(i, turn, limit) else {
            continue;
        };
        let apart = |after: usize| (newest[i + after] - newest[other.index + after]).powi(2);
        near += apart(lag);
        far += late.clone().map(apart).sum::<f64>() / TURN as f64;
        pairs += 1.0;
    }
    // Two values without relation differ by twice the power.
    let relative = |sum: f64| {
        if pairs > 0.0 {
            (sum / pairs / (2.0 * power)).sqrt()
        } else {
            1.0
        }
    };

    let rows = ROWS.min(limit);
    let row = |r: usize| {
        let i = r * limit / rows;
        let state = SVector::<f64, DIMENSION>::from_fn(|c, _| vectors.coordinate(c)[i]);
        (state, newest[i + lag])
    };
    let mut products = SMatrix::<f64, DIMENSION, DIMENSION>::zeros();
    let mut target = SVector::<f64, DIMENSION>::zeros();
    for (state, next) in (0..rows).map(row) {
        products += state * state.transpose();
        target += state * next;
    }
    // A sine has only two directions: the ridge keeps the others quiet.
    let ridge = 1e-10 * products.trace();
    products += SMatrix::identity() * ridge;
    let map = products.cholesky().map(|factors| factors.solve(&target));
    let map = map.unwrap_or_default();
    let missed = (0..rows)
        .map(row)
        .map(|(state, next)| (next - state.dot(&map)).powi(2));
    let linear = (missed.sum::<f64>() / rows as f64 / power).sqrt();
    Ok([relative(near), linear, relative(far)])
}

/// The straight part of the curve of parting neighbours.
fn exponent(centred: &[f64], lag: usize) -> Option<ScalingRegion> {
    let mut search = DivergenceSearch::for_delay(lag, DIMENSION, TURN * lag, centred.len());
    search.most_references = EXPONENT_REFERENCES;
    divergence(centred, &search).ok()?.region
}
