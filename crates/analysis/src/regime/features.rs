//! Features of a signal for the classification.
//!
//! Sections and neighbours need a signal between its samples: a harmonic with four samples per period is
//! interpolated first, so that the distance of two crossings is that of the motion and not of the sampling.

use std::f64::consts::LN_2;

use super::neighbourhood::{MIN_ERROR, Neighbourhood, PredictionError, REFERENCES};
use crate::filter::{upsampled, upsampling};
use crate::significant;
use crate::{
    AnalysisError,
    chaos::{ROUNDING, ZeroOneTest, zero_one},
    delay::{DelaySearch, LAGS_PER_PERIOD, LagReason, mutual_information},
    poincare::{Crossing, Direction, delay_section},
    stats::{deviation, mean, median, range, trend},
    tones::{
        Bases, Combination, FREQUENCY_UNCERTAINTY, Line, LineCriterion, SpectrumAnalyser, Window,
        identify_lines,
    },
};

/// Sections of the record whose levels and periods are compared.
pub(super) const SECTIONS: usize = 8;

/// Longest period considered in the section, crossings. Four multiples of it must fit into half of the
/// crossings.
const MAX_PERIOD: usize = 4;

/// Highest harmonic that is recognised where sampling folds it.
const HARMONICS: u32 = 24;

/// Side lines nearer to their carrier than this share of its frequency are a slow modulation.
const SLOW: f64 = 0.02;

/// Least depth of a slow change of the level that is named.
const MODULATION: f64 = 0.15;

/// An input of the model.
#[derive(Clone, Debug)]
pub(super) struct Feature {
    /// Its name, that of the criterion.
    pub criterion: &'static str,
    /// Its value. Powers and errors enter by their logarithm, within the range in which they distinguish types of motion.
    pub input: f64,
    /// A sentence with the value.
    pub description: String,
}

impl Feature {
    fn new(criterion: &'static str, input: f64, description: String) -> Self {
        Self {
            criterion,
            input,
            description,
        }
    }
}

/// Power of the spectral lines.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinePower {
    /// Base frequency of which most power are harmonics, Hz; `None` without lines.
    f1: Option<f64>,
    /// Share of the lines' power that is neither in harmonics of one base nor in its subharmonics.
    beside_one: f64,
    /// Share of the lines' power that is in no combination of two bases.
    beside_two: f64,
    /// Whether the strongest side line is that of a slow modulation, and weaker than the side lines of a tone modulated to
    /// the depth of 1.
    pub is_slow: bool,
    /// Whether the lines are those of a modulated tone.
    pub is_modulated: bool,
}

/// All features.
#[derive(Clone, Debug)]
pub(super) struct Features {
    /// Number of samples.
    pub samples: usize,
    /// Number of periods in the record: of four lags, or crossings, whichever is larger.
    pub periods: f64,
    /// Number of periods of the strongest line; infinite without lines.
    pub cycles: f64,
    pub lines: LinePower,
    /// Whether a tone is modulated slowly: by its side lines, or by the levels of sections.
    pub is_modulated: bool,
    /// The inputs of the model.
    pub inputs: Vec<Feature>,
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
        let power = power(&centred);

        let spectrum =
            SpectrumAnalyser::new(Window::BlackmanHarris, sample_rate).analyse(&centred)?;
        let lines = spectrum.lines(&LineCriterion::default());
        let tones = LinePower::of(&lines, sample_rate, FREQUENCY_UNCERTAINTY * spectrum.bin);
        let duration = n as f64 / sample_rate;
        let cycles = lines
            .first()
            .map_or(f64::INFINITY, |line| line.frequency * duration);
        let floor = spectrum.broadband_share();
        let white = floor * whiteness(&spectrum.floor());
        let levels = levels(&centred, power);
        let centred = match upsampling(&lines, sample_rate) {
            1 => centred,
            factor => upsampled(&centred, factor),
        };

        let lag = lag(&centred)?;
        let section = |level| delay_section(&centred, lag, 3, level, Direction::Rising);
        // Noise adds crossings where strong harmonics touch the level: a motion that passes the mean three times in a
        // period may pass a higher level once.
        let (crossings, above) = (section(0.0)?, section(power.sqrt())?);
        let repetitions = [&crossings, &above].map(|crossings| repetition(crossings));
        let repetition = repetitions.into_iter().flatten();
        let repetition = repetition
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(distance, crossings)| (distance / power.sqrt(), crossings));
        let instants: Vec<f64> = crossings.iter().map(|c| c.sample).collect();
        let periods =
            (centred.len() as f64 / (LAGS_PER_PERIOD * lag) as f64).max(crossings.len() as f64);

        let neighbourhood = Neighbourhood::new(&centred, lag, power)?;
        let mut error = neighbourhood.prediction_error();
        // Strong chaos is unpredictable over a quarter period, a map at any time but a sample ahead.
        let mut ahead = lag;
        while ahead > 1 && error.short > MIN_ERROR {
            ahead /= 2;
            let sooner = Neighbourhood::new(&centred, ahead, power)?.prediction_error();
            if sooner.over_linear() < error.over_linear() {
                error = sooner;
            }
        }
        let is_modulated = tones.is_slow || level_change(&levels) > 2.0 * MODULATION;
        let mut inputs = Vec::from(tones.features(!lines.is_empty()));
        inputs.extend(floor_features(floor, background / power, white, error));
        inputs.push(repetition_feature(
            repetition,
            error.short.min(floor.sqrt()),
        ));
        inputs.extend(predictability(error));
        inputs.extend([
            divergence_feature(neighbourhood.divergence()),
            zero_one_feature(&centred, lag),
        ]);
        inputs.extend(steadiness(
            neighbourhood.drift(),
            &levels,
            periods_of(&instants),
        ));
        Ok(Self {
            samples: n,
            periods,
            cycles,
            lines: tones,
            is_modulated,
            inputs,
        })
    }
}

impl LinePower {
    /// Reads the lines, strongest first. `uncertainty`: of a frequency, Hz.
    fn of(lines: &[Line], sample_rate: f64, uncertainty: f64) -> Self {
        let Some(carrier) = lines.first().map(|line| line.frequency) else {
            return Self {
                f1: None,
                beside_one: 1.0,
                beside_two: 1.0,
                is_slow: false,
                is_modulated: false,
            };
        };
        let naming = identify_lines(lines, uncertainty);
        let power = |belongs: &dyn Fn(&Line, Option<Combination>) -> bool| -> f64 {
            let named = lines.iter().zip(&naming.names);
            named
                .filter(|(line, name)| belongs(line, **name))
                .map(|(line, _)| line.amplitude.powi(2))
                .sum()
        };
        let of_first = |name: Option<Combination>| name.is_some_and(|c| c.m == 0);
        let of_second = |name: Option<Combination>| name.is_some_and(|c| c.n == 0);
        let total = power(&|_, _| true);
        let is_second = power(&|_, name| of_second(name)) > power(&|_, name| of_first(name));
        let bases = match naming.bases {
            Bases::None => None,
            Bases::One { f1 } => Some([f1, f1]),
            Bases::Modulated { f1, fm } => Some([f1, f1 - fm]),
            Bases::Two { f1, f2 } => Some([f1, f2]),
        };
        let f1 = bases.map(|bases| bases[usize::from(is_second)]);
        let is_folded = |line: &Line| {
            f1.is_some_and(|f1| is_folded_harmonic(line.frequency, f1, sample_rate, uncertainty))
        };
        let all = power(&|line, name| name.is_some() || is_folded(line));
        let one = match bases {
            Some(bases) if are_locked(bases, uncertainty) => all,
            _ if is_second => power(&|line, name| of_second(name) || is_folded(line)),
            _ => power(&|line, name| of_first(name) || is_folded(line)),
        };
        let beside = |part: f64| 1.0 - part / total;
        // The octave and its multiples are harmonics.
        let distance = |line: &Line| (line.frequency - carrier).abs() / carrier;
        let side = lines[1..].iter().find(|line| distance(line) < 0.45);
        Self {
            f1,
            beside_one: beside(one),
            beside_two: beside(all),
            is_slow: side.is_some_and(|side| {
                distance(side) < SLOW && side.amplitude < 0.6 * lines[0].amplitude
            }),
            is_modulated: matches!(naming.bases, Bases::Modulated { .. }),
        }
    }

    fn features(&self, has_lines: bool) -> [Feature; 2] {
        let none = "The spectrum has no lines.";
        let [one, two] = [self.beside_one, self.beside_two].map(percent);
        let one = match self.f1.map(|f1| significant(f1, 3)) {
            _ if !has_lines => none.to_owned(),
            None => "The lines are no harmonics of one tone.".to_owned(),
            Some(f1) => format!("{one} of the lines' power is in no harmonic of {f1} Hz."),
        };
        let two = if has_lines {
            format!("{two} of the lines' power is in no combination of two frequencies.")
        } else {
            none.to_owned()
        };
        [
            Feature::new("one tone", log(self.beside_one), one),
            Feature::new("two tones", log(self.beside_two), two),
        ]
    }
}

/// The features of the noise floor. `floor`, `background`, `white`: their shares of the power.
fn floor_features(floor: f64, background: f64, white: f64, error: PredictionError) -> [Feature; 3] {
    let over_error = floor / error.short.max(MIN_ERROR).powi(2);
    [
        Feature::new(
            "broadband floor",
            log(floor - 2.0 * background),
            format!("{} of the power lies between the lines.", percent(floor)),
        ),
        Feature::new(
            "white floor",
            log(white),
            // A filter leaves less than the model distinguishes.
            format!(
                "White noise of the level of the upper quarter of the frequencies has at most {} of the power.",
                percent(white.max(1e-6))
            ),
        ),
        Feature::new(
            "noise",
            over_error.clamp(0.3, 30.0).ln(),
            format!(
                "The power between the lines is {} times that of noise of the size of the prediction error.",
                significant(over_error, 3)
            ),
        ),
    ]
}

/// The feature of a distance of crossings (over the standard deviation) a number of them apart. `noise`: its standard
/// deviation.
fn repetition_feature(repetition: Option<(f64, usize)>, noise: f64) -> Feature {
    let Some((distance, crossings)) = repetition else {
        let none = "Too few crossings for a repetition.";
        return Feature::new("repetition", 0.0, none.to_owned());
    };
    // The error of a prediction is that of noise or, between sparse states, larger.
    let ratio = distance / noise.max(MIN_ERROR);
    Feature::new(
        "repetition",
        ratio.clamp(0.5, 30.0).ln(),
        format!(
            "Crossings {crossings} apart differ by {} of the standard deviation, {} times as much as noise explains.",
            percent(distance),
            significant(ratio, 3)
        ),
    )
}

fn predictability(error: PredictionError) -> [Feature; 2] {
    let PredictionError { short, linear } = error;
    [
        Feature::new(
            "predictability",
            short.clamp(MIN_ERROR, 1.2).log10(),
            format!(
                "Neighbours predict the motion with an error of {}.",
                percent(short)
            ),
        ),
        Feature::new(
            "determinism",
            error.over_linear().min(1.2),
            format!(
                "A linear map predicts the motion with an error of {}, neighbours with {} times as much.",
                percent(linear),
                significant(error.over_linear(), 3)
            ),
        ),
    ]
}

fn divergence_feature(divergence: f64) -> Feature {
    let factor = significant(divergence.exp(), 3);
    Feature::new(
        "divergence",
        divergence.clamp(0.0, 2.0),
        format!("The distance of neighbours grows by a factor of {factor} along the record."),
    )
}

fn zero_one_feature(samples: &[f64], lag: usize) -> Feature {
    let test = ZeroOneTest::with_stride(lag);
    let Ok(result) = zero_one(samples, &test) else {
        let short = "The record is too short for the 0-1 test.";
        return Feature::new("0-1 test", 0.5, short.to_owned());
    };
    let k = result.k;
    // Adding zero removes the sign of a rounded zero.
    let shown = (1e2 * k).round() / 1e2 + 0.0;
    let description = format!("The 0-1 test gives {shown:.2} (0: regular, 1: chaos or noise).");
    Feature::new("0-1 test", k, description)
}

/// The features of a steady motion, from the logarithms of the levels and periods of the sections.
fn steadiness(
    drift: f64,
    levels: &[f64; SECTIONS],
    periods: Option<[f64; SECTIONS]>,
) -> [Feature; 4] {
    let [quietest, _] = range(*levels);
    let level = level_change(levels);
    let few = "Too few crossings for a trend of the period.";
    let (period_trend, period) = periods.map_or((0.0, few.to_owned()), |periods| {
        let [change, trend] = change(&periods);
        let [size, errors] = [percent(change.exp_m1().abs()), significant(trend, 3)];
        let sentence = format!("The period changes by {size}, {errors} times the standard error.");
        (trend, sentence)
    });
    let factor = |logarithm: f64| significant(logarithm.exp(), 3);
    let [apart, level_factor] = [drift, level].map(factor);
    [
        Feature::new(
            "drift",
            drift.clamp(0.0, 3.0),
            format!(
                "The nearest state at least half a record apart is {apart} times as far away as that at any other time."
            ),
        ),
        Feature::new(
            "level",
            // Changes below 1 % do not count.
            level.max(0.01).ln(),
            format!("The level changes by a factor of {level_factor}, without its two extremes."),
        ),
        Feature::new(
            "lull",
            -quietest,
            format!(
                "The level of the quietest eighth of the record is {} of that of the whole.",
                percent(quietest.exp())
            ),
        ),
        Feature::new("trend of the period", period_trend.min(20.0), period),
    ]
}

/// The largest of the levels of sections less the smallest, without these two extremes.
fn level_change(levels: &[f64; SECTIONS]) -> f64 {
    let mut sorted = *levels;
    sorted.sort_by(f64::total_cmp);
    sorted[SECTIONS - 2] - sorted[1]
}

/// Decimal logarithm of a share of power. Smaller shares do not count: a millionth of the power is that of
/// rounding to ten bits.
fn log(share: f64) -> f64 {
    share.max(1e-6).log10()
}

fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 3))
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

/// Whether a line is a harmonic of `f1` that sampling folds below half of the sample rate: clipping after the anti-aliasing
/// filter makes such harmonics. A harmonic of order k is known to k times the uncertainty of the strong line at `f1`.
fn is_folded_harmonic(line: f64, f1: f64, sample_rate: f64, uncertainty: f64) -> bool {
    (2..=HARMONICS).map(f64::from).any(|k| {
        let turns = k * f1 / sample_rate;
        let folded = (turns - turns.round()).abs() * sample_rate;
        (line - folded).abs() <= uncertainty * (1.0 + 0.2 * k)
    })
}

/// Change of equally spaced values from the first to the last on the least-squares line, and its size over its standard
/// error.
fn change(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let [slope, rest] = trend(values);
    let spread = n * (n * n - 1.0) / 12.0;
    let error = (rest / (n - 2.0) / spread).sqrt();
    [slope * (n - 1.0), slope.abs() / error.max(1e-12)]
}

/// Mean square.
fn power(values: &[f64]) -> f64 {
    values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64
}

/// Natural logarithm of the root mean square of each section relative to the whole.
fn levels(centred: &[f64], whole: f64) -> [f64; SECTIONS] {
    std::array::from_fn(|p| {
        let n = centred.len();
        let section = &centred[p * n / SECTIONS..(p + 1) * n / SECTIONS];
        let variance = deviation(section).powi(2);
        0.5 * (variance / whole).max(ROUNDING).ln()
    })
}

/// Natural logarithm of the mean time between instants in each of the sections with equally many
/// instants; `None` with fewer than three per section.
fn periods_of(instants: &[f64]) -> Option<[f64; SECTIONS]> {
    let count = instants.len().checked_sub(1)?;
    let edge = |p: usize| p * count / SECTIONS;
    let period = |p| {
        let (from, to) = (edge(p), edge(p + 1));
        ((instants[to] - instants[from]) / (to - from) as f64).ln()
    };
    (count >= 3 * SECTIONS).then(|| std::array::from_fn(period))
}

/// Power of a noise floor in the upper quarter of the frequencies over that at all; 1 without noise.
fn whiteness(floor: &[f64]) -> f64 {
    let [all, upper] = [power(floor), power(&floor[floor.len() * 3 / 4..])];
    if all > 0.0 { upper / all } else { 1.0 }
}

/// Lag of the delay vectors, samples.
pub(super) fn lag(samples: &[f64]) -> Result<usize, AnalysisError> {
    let search = DelaySearch::for_samples(samples.len());
    // A minimum at a short lag is known without the long ones.
    let mut tried = 1;
    loop {
        tried = search.largest_lag.min(2 * tried);
        let (lag, reason) = mutual_information(samples, tried, search.bins)?.lag();
        if reason == LagReason::FirstMinimum || tried == search.largest_lag {
            return Ok(lag.max(1));
        }
    }
}

/// Distance (per coordinate, as for noise) between crossings that are a period or a multiple of it
/// apart, up to half of the compared crossings, for the period with the smallest distance. `None` with too few crossings
/// for any period.
///
/// Uses medians because noise adds a few crossings in wrong places.
fn repetition(crossings: &[Crossing]) -> Option<(f64, usize)> {
    // The first and the last crossing are interpolated from fewer samples.
    let inner = crossings.get(1..crossings.len().max(2) - 1).unwrap_or(&[]);
    // The later half shows what the motion settles to, if it is not too short. The time grows with the square of their
    // number: as many are compared as states are.
    let compared = (inner.len() / 2).clamp(64, REFERENCES);
    let last = &inner[inner.len().saturating_sub(compared)..];
    let points: Vec<&[f64]> = last.iter().map(|c| c.point.as_slice()).collect();
    let (half, longest) = (points.len() / 2, MAX_PERIOD.min(points.len() / 8));
    if longest == 0 {
        return None;
    }
    let square = |(a, b): (&&[f64], &&[f64])| {
        let differences = a.iter().zip(*b).map(|(a, b)| a - b);
        differences.map(|d| d * d).sum::<f64>()
    };
    let distance = |crossings: usize| {
        let squares = points.iter().zip(&points[crossings..]).map(square);
        // Two coordinates (the third is the level) with the noise of both crossings; the median of an
        // exponential variable is ln 2.
        median(squares) / (4.0 * LN_2)
    };
    let distance: Vec<f64> = (0..=half).map(distance).collect();
    let of_period = |period: usize| {
        let multiples = distance[period..].iter().step_by(period);
        let count = multiples.len() as f64;
        ((multiples.sum::<f64>() / count).sqrt(), period)
    };
    (1..=longest)
        .map(of_period)
        .min_by(|a, b| a.0.total_cmp(&b.0))
}
