//! Features of a signal for the classification.

use std::f64::consts::LN_2;

use super::change::{Change, SECTIONS};
use super::neighbourhood::{DIMENSION, MIN_ERROR, Neighbourhood, PERIOD, PredictionError};
use crate::analysis::{
    AnalysisError, Bases, Combination, DelaySearch, DelayVectors, Direction, DivergenceSearch,
    Line, LineCriterion, LineIdentification, ScalingRegion, SectionShape, SpectrumAnalyser, Window,
    ZeroOneTest, delay_section, divergence_in, identify_lines, mean, mutual_information, range,
    section_shape, zero_one,
};

/// Minimum amplitude of a line that is not a harmonic, relative to the strongest, to count as a second
/// tone.
pub(super) const MIN_SECOND_TONE: f64 = 0.025;

/// Largest lag tried, samples.
const MAX_LAG: usize = 200;

/// Largest lag tried first, samples.
const FIRST_LAGS: usize = 32;

/// A signal with a larger prediction error is unpredictable a quarter period ahead. It is deterministic
/// if the nearest-neighbour error is at most this share of that of a linear map.
const UNPREDICTABLE: f64 = 0.4;
const DETERMINISTIC: f64 = 0.7;

/// Longest period considered in the section, crossings. Four multiples of it must fit into half of the
/// crossings.
const MAX_PERIOD: usize = 8;

/// Minimum number of crossings for a period.
const MIN_CROSSINGS: usize = 24;

/// Samples of the 0-1 test, taken from the end.
const ZERO_ONE_SAMPLES: usize = 2000;

/// Maximum number of crossings of the section, taken from the end.
const MAX_CROSSINGS: usize = 400;

/// Reference states for the exponent.
const EXPONENT_REFERENCES: usize = 300;

/// Minimum ratio of a line to the noise floor. In noise one of 10^12 bins exceeds it.
const MIN_LINE: f64 = 6.5;

/// Standard uncertainty of a line's frequency for its identification, bins.
const LINE_UNCERTAINTY: f64 = 0.1;

/// The same for the comparison of two bases, which are strong lines: 1e-4 without noise.
const LOCKING_UNCERTAINTY: f64 = 0.02;

/// Least ratio of the amplitudes of the side lines of a modulated tone.
const MIRRORED: f64 = 0.85;

/// Statistical scatter of the upper quarter of a white noise floor below the rest.
const WHITE_SCATTER: f64 = 1.3;

/// Two tones are phase-locked if a multiple of one up to this order is a multiple of the other.
const MAX_LOCKING_ORDER: u32 = 8;

/// Linear trend over the record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trend {
    /// Change from the first section to the last on the least-squares line.
    pub change: f64,
    /// Slope over its standard error.
    pub significance: f64,
}

/// Reading of the spectral lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Tones {
    /// No line.
    None,
    /// Harmonics of one tone (Hz). `unrelated` is the amplitude of the strongest other line over that of
    /// the strongest of all.
    One { f1: f64, unrelated: f64 },
    /// Two tones (Hz) and their combinations. `second` is the amplitude of the strongest line to which
    /// the second tone contributes, over that of the strongest of all.
    Two { f1: f64, f2: f64, second: f64 },
    /// Two phase-locked tones: `f2 / f1 = p / q`. `unrelated` is the amplitude of the strongest other line
    /// over that of the strongest of all.
    PhaseLocked {
        f1: f64,
        p: u32,
        q: u32,
        unrelated: f64,
    },
    /// This number of lines that fit neither one tone nor two.
    Many(usize),
}

/// All features.
#[derive(Clone, Debug)]
pub(super) struct Features {
    /// Number of periods in the record: of four lags, or crossings, whichever is larger.
    pub periods_seen: f64,
    /// Trend of the natural logarithm of the root mean square.
    pub envelope: Trend,
    /// Natural logarithm of the ratio of the largest to the smallest root mean square of a section.
    pub level_range: f64,
    /// Trend of the natural logarithm of the time between crossings of the section.
    pub period_drift: Option<Trend>,
    /// The most significant lasting change from one level to another.
    pub change: Option<Change>,
    /// Delay of the states, samples.
    pub lag: usize,
    /// Share of the power in the noise floor of the spectrum.
    pub floor: f64,
    /// The part of it that is not white: the noise floor is higher at the frequencies of the motion than
    /// in the upper quarter of the frequencies.
    pub coloured: f64,
    pub tones: Tones,
    /// Distance of the strongest side lines if they are those of a modulated tone, Hz.
    pub modulation: Option<f64>,
    pub section: SectionShape,
    pub crossings: usize,
    /// Prediction errors.
    pub prediction_error: PredictionError,
    /// Growth of the distance of neighbours from 1/30 to 1/4 of the record length, natural logarithm.
    pub divergence: f64,
    /// Distance to the nearest state that is distant in time over that to the nearest state at any time,
    /// natural logarithm. 0 for a stationary motion.
    pub drift: f64,
    /// Number of states among which neighbours are searched.
    pub states: usize,
    /// Distance of crossings any number of periods apart over the standard deviation of the signal; and
    /// the period in crossings.
    pub repetition: Option<(f64, usize)>,
    /// 0-1 test: `K` and the number of samples.
    pub zero_one: Option<(f64, usize)>,
    /// Rate of divergence of neighbours and its error, per period.
    pub exponent: Option<[f64; 2]>,
}

impl Features {
    /// Features of samples between -1 and 1 that are not all equal, at least
    /// [`super::RegimeSearch::MIN_SAMPLES`].
    pub(super) fn of(samples: &[f64], sample_rate: f64) -> Result<Self, AnalysisError> {
        let n = samples.len();
        let mean = mean(samples);
        let centred: Vec<f64> = samples.iter().map(|x| x - mean).collect();
        let power = centred.iter().map(|x| x * x).sum::<f64>() / n as f64;

        let spectrum =
            SpectrumAnalyser::new(Window::BlackmanHarris, sample_rate).analyse(&centred)?;
        let criterion = LineCriterion {
            ratio_to_floor: MIN_LINE,
            ..LineCriterion::default()
        };
        let lines = spectrum.lines(&criterion);
        let naming = identify_lines(&lines, LINE_UNCERTAINTY * spectrum.bin);
        let tones = Tones::read(&lines, &naming, LOCKING_UNCERTAINTY * spectrum.bin);

        let lag = lag(&centred)?;
        let crossings = delay_section(&centred, lag, 3, 0.0, Direction::Rising)?;
        let instants: Vec<f64> = crossings.iter().map(|c| c.sample).collect();
        // The first and the last crossing are interpolated from fewer samples.
        let inner = crossings.get(1..crossings.len().max(2) - 1).unwrap_or(&[]);
        let last = &inner[inner.len().saturating_sub(MAX_CROSSINGS)..];
        let points: Vec<&[f64]> = last.iter().map(|c| c.point.as_slice()).collect();
        let [low, high] = range(centred.iter().copied());

        let vectors = DelayVectors::new(&centred, lag, DIMENSION)?;
        let neighbourhood = Neighbourhood::new(vectors, lag, power);
        let mut prediction_error = neighbourhood.prediction_error();
        // Strong chaos is unpredictable over a quarter period, a map at any time but a sample ahead: then the
        // time counts over which neighbours are furthest ahead of a linear map.
        let mut ahead = match prediction_error.short > UNPREDICTABLE {
            true => lag,
            false => 1,
        };
        let mut best = DETERMINISTIC;
        while ahead > 1 {
            ahead /= 2;
            let vectors = DelayVectors::new(&centred, ahead, DIMENSION)?;
            let sooner = Neighbourhood::new(vectors, ahead, power).prediction_error();
            if sooner.short < best * sooner.linear {
                best = sooner.short / sooner.linear;
                prediction_error = sooner;
            }
        }
        let repetition = repetition(&points);
        let differences = repetition.and_then(|(_, crossings)| {
            let time = instants[instants.len() - 1] - instants[0];
            let period = crossings as f64 * time / (instants.len() - 1) as f64;
            let least = prediction_error.short.max(MIN_ERROR) * power.sqrt();
            differences(&centred, period, least)
        });
        let levels = levels(&centred, power);
        let [smallest, largest] = range(levels);
        let stride = ZeroOneTest::recommended_stride(&centred).max(lag);
        let late = &centred[n.saturating_sub(ZERO_ONE_SAMPLES * stride)..];
        let zero_one = zero_one(late, &ZeroOneTest::with_stride(stride));
        let period = (PERIOD * lag) as f64;
        Ok(Self {
            periods_seen: (n as f64 / period).max(crossings.len() as f64),
            envelope: Trend::of(&levels),
            level_range: largest - smallest,
            change: Change::most_significant(&levels, differences.as_ref()),
            lag,
            period_drift: periods(&instants).map(|periods| Trend::of(&periods)),
            floor: spectrum.broadband_share(),
            coloured: spectrum.broadband_share() * colour(&spectrum.floor()),
            tones,
            modulation: modulation(&lines, 2.0 * LINE_UNCERTAINTY * spectrum.bin),
            section: section_shape(&points, high - low),
            crossings: crossings.len(),
            prediction_error,
            divergence: neighbourhood.divergence(),
            drift: neighbourhood.drift(),
            states: vectors.len(),
            repetition: repetition.map(|(distance, period)| (distance / power.sqrt(), period)),
            zero_one: zero_one.ok().map(|result| (result.k, result.samples)),
            exponent: exponent(&neighbourhood).map(|r| [r.slope * period, r.error * period]),
        })
    }

    /// Broadband share over the value that noise of the size of the prediction error would have.
    pub(super) fn floor_ratio(&self) -> f64 {
        self.floor / self.prediction_error.short.max(MIN_ERROR).powi(2)
    }

    /// Distance of crossings one period apart over the part explained by noise, or by a second tone too weak
    /// to count: of relative amplitude `a` it moves the crossings by up to `2 a` standard deviations, and three
    /// times the explained part is no repetition.
    pub(super) fn repetition_ratio(&self) -> Option<f64> {
        let (distance, _) = self.repetition?;
        // The error of a prediction is that of noise or, between sparse states, larger.
        let noise = self.prediction_error.short.min(self.floor.sqrt());
        let weak = 2.0 * MIN_SECOND_TONE / 3.0;
        Some(distance / noise.max(MIN_ERROR).max(weak))
    }

    /// Ratio of the long-term to the short-term prediction error.
    pub(super) fn error_growth(&self) -> f64 {
        self.prediction_error.long / self.prediction_error.short.max(MIN_ERROR)
    }

    /// Ratio of the nearest-neighbour prediction error to that of a linear map.
    pub(super) fn relative_to_linear(&self) -> f64 {
        self.prediction_error.short / self.prediction_error.linear.max(1e-9)
    }
}

impl Tones {
    /// Reads the lines, strongest first. Frequencies are phase-locked if they deviate from a rational
    /// ratio by at most `uncertainty` (Hz).
    fn read(lines: &[Line], naming: &LineIdentification, uncertainty: f64) -> Self {
        // Amplitude of the strongest line with a name that satisfies a condition, over that of the
        // strongest of all.
        let strongest = |condition: fn(&Option<Combination>) -> bool| {
            let mut named = lines.iter().zip(&naming.names);
            let line = named.find(|(_, name)| condition(name));
            line.map_or(0.0, |(line, _)| line.amplitude / lines[0].amplitude)
        };
        let bases = match naming.bases {
            Bases::Modulated { f1, fm } => Bases::Two { f1, f2: f1 - fm },
            bases => bases,
        };
        let unrelated = strongest(|name| name.is_none());
        match bases {
            Bases::None if lines.is_empty() => Self::None,
            Bases::None => Self::Many(lines.len()),
            Bases::One { f1 } => Self::One { f1, unrelated },
            Bases::Two { f1, f2 } => match locking_ratio(f1, f2, uncertainty) {
                Some((p, q)) => Self::PhaseLocked {
                    f1,
                    p,
                    q,
                    unrelated,
                },
                None => Self::Two {
                    f1,
                    f2,
                    second: strongest(|name| name.is_some_and(|name| name.m != 0)),
                },
            },
            Bases::Modulated { .. } => Self::Many(lines.len()),
        }
    }
}

/// Distance of the strongest side line from the strongest line (Hz), if it has a mirror image of equal strength
/// and no line of its own frequency: the lines of a modulated tone. `lines`: strongest first.
fn modulation(lines: &[Line], uncertainty: f64) -> Option<f64> {
    let carrier = lines.first()?.frequency;
    let at = |frequency: f64| {
        let near = |line: &&Line| (line.frequency - frequency).abs() <= uncertainty;
        lines.iter().find(near).map_or(0.0, |line| line.amplitude)
    };
    // The octave and its multiples are harmonics.
    let beside = |line: &&Line| (line.frequency - carrier).abs() < 0.45 * carrier;
    let side = lines[1..].iter().find(beside)?;
    let distance = (side.frequency - carrier).abs();
    let mirrored = at(2.0 * carrier - side.frequency) > MIRRORED * side.amplitude;
    let own = at(distance) > (1.0 - MIRRORED) * side.amplitude;
    (mirrored && !own).then_some(distance)
}

impl Trend {
    /// Trend of equally spaced values.
    fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = mean(values);
        let position = |i: usize| i as f64 - 0.5 * (n - 1.0);
        let both = || {
            values
                .iter()
                .enumerate()
                .map(|(i, y)| (position(i), y - mean))
        };
        let spread: f64 = both().map(|(t, _)| t * t).sum();
        let slope = both().map(|(t, y)| t * y).sum::<f64>() / spread;
        let rest: f64 = both().map(|(t, y)| (y - slope * t).powi(2)).sum();
        let error = (rest / (n - 2.0) / spread).sqrt();
        // Eight random values increase monotonically once in 40,000 times. A trend need not be linear.
        let rising = values.is_sorted_by(|a, b| a < b);
        let falling = values.is_sorted_by(|a, b| a > b);
        Self {
            change: slope * (n - 1.0),
            significance: match rising || falling {
                true => f64::INFINITY,
                false => slope.abs() / error.max(1e-12),
            },
        }
    }
}

/// Natural logarithm of the root mean square of each section, at least -8 (-69 dB) relative to the
/// whole.
fn levels(centred: &[f64], power: f64) -> [f64; SECTIONS] {
    std::array::from_fn(|p| {
        let n = centred.len();
        let section = &centred[p * n / SECTIONS..(p + 1) * n / SECTIONS];
        let mean = mean(section);
        let variance =
            section.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / section.len() as f64;
        0.5 * (variance / power).max((-16.0_f64).exp()).ln()
    })
}

/// Natural logarithm of the mean time between instants in each of the sections with equally many
/// instants; `None` with fewer than three per section.
fn periods(instants: &[f64]) -> Option<[f64; SECTIONS]> {
    let count = instants.len().checked_sub(1)?;
    let edge = |p: usize| p * count / SECTIONS;
    let period = |p| {
        let (from, to) = (edge(p), edge(p + 1));
        ((instants[to] - instants[from]) / (to - from) as f64).ln()
    };
    (count >= 3 * SECTIONS).then(|| std::array::from_fn(period))
}

/// Natural logarithm of the root-mean-square difference of samples `period` (samples) apart in each section, not
/// below `least`; `None` if the period does not fit four times into a section.
fn differences(centred: &[f64], period: f64, least: f64) -> Option<[f64; SECTIONS]> {
    let (whole, part) = (period as usize, period.fract());
    let edge = |p: usize| p * (centred.len() - whole - 1) / SECTIONS;
    let difference = |i: usize| {
        let [left, right] = [centred[i + whole], centred[i + whole + 1]];
        left + part * (right - left) - centred[i]
    };
    let of = |p: usize| {
        let (from, to) = (edge(p), edge(p + 1));
        let squares = (from..to).map(|i| difference(i).powi(2)).sum::<f64>();
        0.5 * (squares / (to - from) as f64 + least * least).ln()
    };
    (4.0 * period * SECTIONS as f64 <= centred.len() as f64).then(|| std::array::from_fn(of))
}

/// `p / q` in lowest terms if it equals `f2 / f1` within the uncertainty, `q` up to
/// [`MAX_LOCKING_ORDER`].
fn locking_ratio(f1: f64, f2: f64, uncertainty: f64) -> Option<(u32, u32)> {
    let ratio = f2 / f1;
    (1..=MAX_LOCKING_ORDER).find_map(|q| {
        let p = (f64::from(q) * ratio).round();
        let deviation = (f64::from(q) * f2 - p * f1).abs();
        let close = deviation <= uncertainty * (f64::from(q).powi(2) + p * p).sqrt();
        (close && p >= 1.0).then_some((p as u32, q))
    })
}

/// Share of the power of a noise floor that is not white.
fn colour(floor: &[f64]) -> f64 {
    let power = |part: &[f64]| part.iter().map(|a| a * a).sum::<f64>() / part.len() as f64;
    let (all, white) = (power(floor), power(&floor[floor.len() * 3 / 4..]));
    if all > 0.0 {
        (1.0 - WHITE_SCATTER * white / all).max(0.0)
    } else {
        0.0
    }
}

/// First clear minimum of the mutual information, else the lag at which it falls below 1/e.
pub(super) fn lag(samples: &[f64]) -> Result<usize, AnalysisError> {
    let n = samples.len();
    let (largest, bins) = ((n / 25).clamp(1, MAX_LAG), DelaySearch::for_samples(n).bins);
    // A minimum at a short lag is known without the long ones.
    let mut tried = largest.min(FIRST_LAGS);
    loop {
        let mutual = mutual_information(samples, tried, bins)?;
        if let Some(lag) = mutual.first_clear_minimum() {
            return Ok(lag);
        }
        if tried == largest {
            return Ok(mutual
                .first_below((-1.0_f64).exp())
                .unwrap_or(largest)
                .max(1));
        }
        tried = largest.min(2 * tried);
    }
}

/// Distance (per coordinate, as for noise) between crossings that are a period or a multiple of it
/// apart, up to half of the crossings, for the period with the smallest distance. `None` for fewer than
/// [`MIN_CROSSINGS`].
///
/// Uses medians because noise adds a few crossings in wrong places.
fn repetition(points: &[&[f64]]) -> Option<(f64, usize)> {
    let half = points.len() / 2;
    if points.len() < MIN_CROSSINGS {
        return None;
    }
    let square = |(a, b): (&&[f64], &&[f64])| {
        let differences = a.iter().zip(*b).map(|(a, b)| a - b);
        differences.map(|d| d * d).sum::<f64>()
    };
    let mut squares = Vec::with_capacity(points.len());
    let mut distance = |crossings: usize| {
        squares.clear();
        squares.extend(points.iter().zip(&points[crossings..]).map(square));
        let middle = squares.len() / 2;
        // Two coordinates (the third is the level) with the noise of both crossings; the median of an
        // exponential variable is ln 2.
        *squares.select_nth_unstable_by(middle, f64::total_cmp).1 / (4.0 * LN_2)
    };
    let distance: Vec<f64> = (0..=half).map(&mut distance).collect();
    let of_period = |period: usize| {
        let multiples = distance[period..].iter().step_by(period);
        let count = multiples.len() as f64;
        ((multiples.sum::<f64>() / count).sqrt(), period)
    };
    (1..=MAX_PERIOD.min(points.len() / 8))
        .map(of_period)
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Scaling region of the divergence of nearest neighbours.
fn exponent(neighbourhood: &Neighbourhood<'_>) -> Option<ScalingRegion> {
    let tree = neighbourhood.tree();
    let (samples, lag) = (tree.vectors().samples(), tree.vectors().lag());
    let mut search = DivergenceSearch::for_delay(lag, DIMENSION, PERIOD * lag, samples.len());
    search.max_references = EXPONENT_REFERENCES;
    divergence_in(tree, &search).ok()?.region
}
