//! Features of a signal for the classification.
//!
//! Sections and neighbours need a signal between its samples: a harmonic with four samples per period is
//! interpolated first, so that the distance of two crossings is that of the motion and not of the sampling.

use std::f64::consts::LN_2;

use super::change::{Change, SECTIONS};
use super::model::INPUTS;
use super::neighbourhood::{DIMENSION, MIN_ERROR, Neighbourhood, PERIOD, PredictionError, ROWS};
use crate::filter::upsampled;
use crate::significant;
use crate::{
    AnalysisError,
    chaos::{ZeroOneTest, zero_one},
    delay::{DelaySearch, DelayVectors, mutual_information},
    poincare::{Direction, SectionShape, delay_section, section_shape},
    stats::{mean, range, trend},
    tones::{Bases, Combination, Line, LineCriterion, SpectrumAnalyser, Window, identify_lines},
};

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

/// Maximum number of crossings of the section, taken from the end.
const MAX_CROSSINGS: usize = 400;

/// Largest number of interpolated samples.
const MAX_DENSE: usize = 16_000;

/// Distance of crossings over the standard deviation that a second tone too weak to count explains.
const WEAK: f64 = 0.017;

/// Minimum ratio of a line to the noise floor. In noise one of 10^12 bins exceeds it.
const MIN_LINE: f64 = 6.5;

/// Standard uncertainty of a line's frequency for its identification, bins.
const LINE_UNCERTAINTY: f64 = 0.1;

/// Samples per period of the highest line of at least a hundredth of the strongest one, for sections and neighbours.
const DENSE: f64 = 16.0;

/// Largest broadband share of a signal that is interpolated: noise and maps have no band to interpolate in.
const TONAL: f64 = 0.1;

/// Statistical scatter of the upper quarter of a white noise floor below the rest.
const WHITE_SCATTER: f64 = 1.3;

/// Linear trend over the record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trend {
    /// Change from the first section to the last on the least-squares line.
    pub change: f64,
    /// Slope over its standard error.
    pub significance: f64,
}

/// Power of the spectral lines.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinePower {
    /// Base frequency of which most power are harmonics, Hz; `None` without lines.
    pub f1: Option<f64>,
    /// Share of the lines' power that is neither in harmonics of one base nor in its subharmonics.
    pub beside_one: f64,
    /// Share of the lines' power that is in no combination of two bases.
    pub beside_two: f64,
    /// Distance of the strongest side line from the strongest line over its frequency, if there is one within 0.45 that
    /// is weaker than the side lines of a tone modulated to the depth of 1.
    pub side: Option<f64>,
    /// Whether the lines are those of a modulated tone.
    pub is_modulated: bool,
}

/// All features.
#[derive(Clone, Debug)]
pub(super) struct Features {
    /// Number of samples.
    pub samples: usize,
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
    /// Share of the power in the noise floor of the spectrum.
    pub floor: f64,
    /// The part of it that is not white: the noise floor is higher at the frequencies of the motion than
    /// in the upper quarter of the frequencies.
    pub coloured: f64,
    /// Share of the power in the background of the recording; 0 if unknown.
    pub background: f64,
    pub lines: LinePower,
    pub section: SectionShape,
    pub crossings: usize,
    /// Prediction errors.
    pub prediction_error: PredictionError,
    /// Growth of the distance of neighbours from 1/30 to 1/4 of the record length, natural logarithm.
    pub divergence: f64,
    /// Distance to the nearest state that is distant in time over that to the nearest state at any time,
    /// natural logarithm. 0 for a stationary motion.
    pub drift: f64,
    /// Distance of crossings any number of periods apart over the standard deviation of the signal; and
    /// the period in crossings.
    pub repetition: Option<(f64, usize)>,
    /// 0-1 test: `K`.
    pub zero_one: Option<f64>,
}

impl Features {
    /// Features of samples between -1 and 1 that are not all equal, at least
    /// [`super::RegimeSearch::MIN_SAMPLES`]. `background`: its power, 0 if unknown.
    pub(super) fn of(
        samples: &[f64],
        sample_rate: f64,
        background: f64,
    ) -> Result<Self, AnalysisError> {
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
        let levels = levels(&centred, power);
        let [smallest, largest] = range(levels);
        let floor = spectrum.broadband_share();
        let centred = match samples_per_step(&lines, floor, sample_rate) {
            1 => centred,
            factor => {
                let first = n.saturating_sub(MAX_DENSE / factor);
                upsampled(&centred[first..], factor)
            }
        };
        let n = centred.len();

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
        let mut ahead = if prediction_error.short > UNPREDICTABLE {
            lag
        } else {
            1
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
        let stride = ZeroOneTest::recommended_stride(&centred).max(lag);
        let late = &centred[n.saturating_sub(ROWS * stride)..];
        let zero_one = zero_one(late, &ZeroOneTest::with_stride(stride));
        let period = (PERIOD * lag) as f64;
        Ok(Self {
            samples: samples.len(),
            periods_seen: (n as f64 / period).max(crossings.len() as f64),
            envelope: Trend::of(&levels),
            level_range: largest - smallest,
            change: Change::most_significant(&levels, differences.as_ref()),
            period_drift: periods(&instants).map(|periods| Trend::of(&periods)),
            floor,
            coloured: floor * colour(&spectrum.floor()),
            background: background / power,
            lines: LinePower::of(&lines, LINE_UNCERTAINTY * spectrum.bin),
            section: section_shape(&points, high - low),
            crossings: crossings.len(),
            prediction_error,
            divergence: neighbourhood.divergence(),
            drift: neighbourhood.drift(),
            repetition: repetition.map(|(distance, period)| (distance / power.sqrt(), period)),
            zero_one: zero_one.ok().map(|result| result.k),
        })
    }

    /// Distance of crossings one period apart over the part explained by noise, or by a second tone too weak
    /// to count; 1 with too few crossings.
    pub(super) fn repetition_ratio(&self) -> f64 {
        // The error of a prediction is that of noise or, between sparse states, larger.
        let noise = self.prediction_error.short.min(self.floor.sqrt());
        self.repetition
            .map_or(1.0, |(distance, _)| distance / noise.max(WEAK))
    }

    /// Ratio of the nearest-neighbour prediction error to that of a linear map.
    pub(super) fn relative_to_linear(&self) -> f64 {
        self.prediction_error.short / self.prediction_error.linear.max(1e-9)
    }

    /// The inputs of the model, in the order of [`super::model::INPUTS`]. Powers and errors enter by their
    /// logarithm, within the range in which they distinguish types of motion.
    pub(super) fn inputs(&self) -> [f64; INPUTS.len()] {
        let share = |x: f64, least: f64| x.max(least).log10();
        let part = |x: f64, [zero, one]: [f64; 2]| ((x - zero) / (one - zero)).clamp(0.0, 1.0);
        let PredictionError { short, long, .. } = self.prediction_error;
        let excess = |power: f64| power - 2.0 * self.background;
        // Neighbours that predict no better than a linear map are those of noise.
        let nonlinear = part(self.relative_to_linear(), [0.9, 0.2]);
        let level = (self.envelope.change.abs() * part(self.envelope.significance, [2.0, 6.0]))
            .max(self.level_range * part(self.level_range, [0.5, 1.5]));
        let change = self.change.map_or(0.0, |change| {
            change.significance.min(20.0) * part(change.size.abs(), [0.03, 0.3])
        });
        let drift = self.period_drift.map_or(0.0, |drift| {
            drift.change.abs() * part(drift.significance, [3.0, 8.0])
        });
        [
            share(self.lines.beside_one, 1e-5),
            share(self.lines.beside_two, 1e-5),
            share(self.floor, 1e-7),
            share(excess(self.floor), 1e-7),
            share(excess(self.coloured), 1e-6),
            (self.floor / short.max(MIN_ERROR).powi(2))
                .clamp(0.3, 300.0)
                .ln(),
            f64::from(u8::from(self.section == SectionShape::Loop)),
            f64::from(u8::from(matches!(self.section, SectionShape::Points(_)))),
            self.repetition_ratio().clamp(0.5, 30.0).ln(),
            long.clamp(MIN_ERROR, 1.2).log10(),
            self.relative_to_linear().min(1.2),
            self.divergence.clamp(-0.2, 2.0) * nonlinear,
            self.drift.clamp(0.0, 3.0),
            self.zero_one.map_or(0.5, |k| k.clamp(-0.2, 1.0)),
            level.max(0.02).ln(),
            change,
            share(drift.min(1.0), 1e-4),
            self.periods_seen.clamp(3.0, 1000.0).log10(),
        ]
    }
}

/// The sentences of the evidence.
impl Features {
    /// A sentence with the values of the features of a criterion.
    pub(super) fn description(&self, criterion: &str) -> String {
        let percent = |share: f64| format!("{} %", significant(100.0 * share, 3));
        let PredictionError { short, long, .. } = self.prediction_error;
        match criterion {
            "one tone" => match self.lines.f1 {
                Some(f1) => format!(
                    "{} of the lines' power is in no harmonic of {} Hz.",
                    percent(self.lines.beside_one),
                    significant(f1, 3)
                ),
                None => "The lines are no harmonics of one tone.".into(),
            },
            "two tones" => format!(
                "{} of the lines' power is in no combination of two frequencies.",
                percent(self.lines.beside_two)
            ),
            "broadband floor" => format!(
                "{} of the power lies between the lines, {} times that of noise of the size of the prediction \
                 error.",
                percent(self.floor),
                significant(self.floor / short.max(MIN_ERROR).powi(2), 3)
            ),
            "Poincare section" => format!(
                "{} crossings of the section form {}.",
                self.crossings,
                match self.section {
                    SectionShape::TooFew => "no shape: they are too few".into(),
                    SectionShape::Points(1) => "one point".into(),
                    SectionShape::Points(count) => format!("{count} points"),
                    SectionShape::Loop => "a closed curve".into(),
                    SectionShape::Arc => "an open curve".into(),
                    SectionShape::Cloud => "a cloud".to_owned(),
                }
            ),
            "repetition" => self.repetition.map_or_else(
                || "Too few crossings for a repetition.".into(),
                |(distance, period)| {
                    format!(
                        "Crossings {period} apart differ by {} of the standard deviation, {} times as much as noise \
                         explains.",
                        percent(distance),
                        significant(self.repetition_ratio(), 3)
                    )
                },
            ),
            "predictability" => format!(
                "Neighbours predict the motion with an error of {} at first and {} after ten periods; a linear map \
                 predicts it with {}.",
                percent(short),
                percent(long),
                percent(self.prediction_error.linear)
            ),
            "divergence" => format!(
                "The distance of neighbours grows by a factor of {} along the record.",
                significant(self.divergence.exp(), 3)
            ),
            "0-1 test" => self.zero_one.map_or_else(
                || "The record is too short for the 0-1 test.".into(),
                |k| format!("The 0-1 test gives {k:.2} (0: regular, 1: chaos or noise)."),
            ),
            "steadiness" => format!(
                "The level changes by a factor of {}, the period by {}.",
                significant(self.level_range.exp(), 3),
                percent(self.period_drift.map_or(0.0, |drift| drift.change.exp_m1().abs()))
            ),
            _ => format!("The record has {:.0} periods.", self.periods_seen),
        }
    }
}

impl LinePower {
    /// Reads the lines, strongest first. `uncertainty`: of a frequency, Hz.
    fn of(lines: &[Line], uncertainty: f64) -> Self {
        let Some(carrier) = lines.first().map(|line| line.frequency) else {
            return Self {
                f1: None,
                beside_one: 1.0,
                beside_two: 1.0,
                side: None,
                is_modulated: false,
            };
        };
        let naming = identify_lines(lines, uncertainty);
        let power = |belongs: &dyn Fn(Combination) -> bool| -> f64 {
            let named = lines.iter().zip(&naming.names);
            named
                .filter(|(_, name)| name.is_some_and(belongs))
                .map(|(line, _)| line.amplitude.powi(2))
                .sum()
        };
        let total: f64 = lines.iter().map(|line| line.amplitude.powi(2)).sum();
        let beside = |part: f64| 1.0 - part / total;
        let [first, second, all] = [power(&|c| c.m == 0), power(&|c| c.n == 0), power(&|_| true)];
        let bases = match naming.bases {
            Bases::None => None,
            Bases::One { f1 } => Some([f1, f1]),
            Bases::Modulated { f1, fm } => Some([f1, f1 - fm]),
            Bases::Two { f1, f2 } => Some([f1, f2]),
        };
        // The octave and its multiples are harmonics.
        let beside_carrier = |line: &&Line| (line.frequency - carrier).abs() < 0.45 * carrier;
        let side = lines[1..].iter().find(beside_carrier);
        let one = match bases {
            Some(bases) if are_locked(bases, uncertainty) => all,
            _ => first.max(second),
        };
        Self {
            f1: bases.map(|bases| bases[usize::from(second > first)]),
            beside_one: beside(one),
            beside_two: beside(all),
            side: side
                .filter(|side| side.amplitude < 0.6 * lines[0].amplitude)
                .map(|side| (side.frequency - carrier).abs() / carrier),
            is_modulated: matches!(naming.bases, Bases::Modulated { .. }),
        }
    }
}

/// Whether two frequencies (Hz) are phase-locked: multiples of both up to the order 8 are equal. Strong lines are known
/// to a fifth of the given uncertainty.
fn are_locked([f1, f2]: [f64; 2], uncertainty: f64) -> bool {
    let ratio = f2 / f1;
    (1..=8).map(f64::from).any(|q| {
        let p = (q * ratio).round();
        let deviation = (q * f2 - p * f1).abs();
        p >= 1.0 && deviation <= 0.2 * uncertainty * (q * q + p * p).sqrt()
    })
}

/// Number of samples to interpolate per sample.
fn samples_per_step(lines: &[Line], floor: f64, sample_rate: f64) -> usize {
    if floor > TONAL {
        return 1;
    }
    let strong = lines
        .iter()
        .filter(|line| line.amplitude > 0.01 * lines[0].amplitude);
    let highest = strong.map(|line| line.frequency).fold(0.0, f64::max);
    ((DENSE * highest / sample_rate).ceil() as usize).max(1)
}

impl Trend {
    /// Trend of equally spaced values.
    fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let [slope, rest] = trend(values);
        let spread = n * (n * n - 1.0) / 12.0;
        let error = (rest / (n - 2.0) / spread).sqrt();
        Self {
            change: slope * (n - 1.0),
            significance: slope.abs() / error.max(1e-12),
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
