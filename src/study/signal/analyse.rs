//! All analyses of one signal, one after another.

use std::borrow::Cow;

use super::sound::MeasuredSound;
use super::stretch::{background_power, select};
use super::{
    AnalysedStretch, CalibratedLevels, DelayEmbedding, MAX_NONLINEAR_SAMPLES, MAX_SPECTRUM_SAMPLES,
    MIN_SAMPLES, MeasuresAt, NamedLine, Outcome, PoincareSection, RecurrenceAnalysis,
    SignalAnalysis, SignalError, SignalOptions, SignalStatistics, SkipReason, SpectralLines,
};
use crate::analysis::{
    AnalysisError, MAX_SAMPLE, MIN_RANGE,
    chaos::{
        Divergence, DivergenceMethod, DivergenceSearch, ZeroOne, ZeroOneTest, divergence, zero_one,
    },
    delay::{
        DelayChoice, DelaySearch, DelayVectors, FalseNeighbourSearch, choose_delay,
        false_neighbours,
    },
    events::{TonalEvent, TonalEvents},
    filter::upsampling,
    levels::{Calibration, LevelReference},
    poincare::{Crossing, Direction, SectionPoint, delay_section, section_shape},
    recurrence::{
        Measures, Norm, RateBase, RecurrenceCriterion, RecurrenceImage, RecurrencePeriods,
        Recurrences, Threshold,
    },
    regime::{Regime, RegimeSearch, Verdict, classify},
    stats::{deviation, mean, range},
    tones::{
        Column, FREQUENCY_UNCERTAINTY, Line, LineCriterion, Spectrum, SpectrumAnalyser, Stft,
        Window, identify_lines,
    },
};
use crate::import::Signal;
use crate::memory;
use crate::study::OnProgress;
use crate::study::response::{recurrence_periods, thinned};

/// Approximate number of columns of a spectrogram.
const COLUMNS: usize = 400;

/// Periods per spectrogram window, if the signal is long enough.
const SPECTROGRAM_PERIODS: f64 = 48.0;

/// Default recurrence rate: share of the pairs of states that are recurrent.
const RECURRENCE_RATE: f64 = 0.05;

/// Minimum number of states per delay, if the sampling is fine enough.
const STATES_PER_LAG: usize = 12;

/// Maximum number of states of the quantified recurrence plot.
const MAX_STATES: usize = 10_000;

/// States per window along the signal, and maximum number of windows.
const WINDOW_STATES: usize = 1000;
const WINDOWS: usize = 120;

/// Minimum line length, states.
const MIN_LINE: usize = 2;

/// Maximum number of samples of a signal that is interpolated.
const MAX_INTERPOLATED: usize = 1 << 20;

/// Side of the picture, pixels, and the number of periods it shows.
const PICTURE: usize = 560;
const PICTURE_PERIODS: f64 = 28.0;

/// Maximum number of section points whose shape is classified.
const MAX_CROSSINGS: usize = 2000;

/// Dimension of the delay vectors of a section, as in Fig. 10.
const SECTION_DIMENSION: usize = 3;

/// Radius of Kantz's method in standard deviations, for few samples and for many.
const KANTZ_RADII: [f64; 2] = [0.05, 0.02];
const MANY_SAMPLES: usize = 50_000;

/// Peak-to-peak amplitude of the dither of a constant sound that is silent, over full scale: two steps of 8 bits.
const MAX_DITHER: f64 = 1.0 / 64.0;

/// Analyses a signal, with its sound levels if it is calibrated or in Pa.
///
/// # Errors
/// [`SignalError::Stopped`]; [`SignalError::NoEvent`] and [`SignalError::NotSound`] for a requested event that does not exist;
/// [`AnalysisError::TooShort`] below [`MIN_SAMPLES`],
/// [`AnalysisError::SampleRange`] for samples whose squares overflow or underflow, [`AnalysisError::Memory`] if the
/// spectrum does not fit into memory, and errors for an unsuitable delay, dimension or threshold, or of
/// [`sound_levels`](crate::analysis::levels::sound_levels).
pub fn analyse_signal(
    mut signal: Signal,
    search: &SignalOptions,
    progress: OnProgress<'_>,
) -> Result<SignalAnalysis, SignalError> {
    let sound_levels = sound_levels(&mut signal, search.calibration)?;
    check(&signal.samples)?;
    progress(0.0, "tonal events")?;
    let silent_below = silence(&signal);
    let silence = silent_below.map(|_| SkipReason::Silent);
    let mut sound = MeasuredSound::of(&signal, search.faint)?;
    if let Some(sound) = sound.as_mut().filter(|_| silence.is_some()) {
        sound.tonal = TonalEvents::default();
    }
    let (stretch, part, obstacle) = select(&signal, sound.as_ref(), search.event)?;
    let studied = part.as_ref().unwrap_or(&signal);
    let (samples, rate) = (&studied.samples[..], studied.rate);
    let newest = newest(samples, 1);
    progress(0.1, "spectrum")?;
    let spectrum = SpectrumAnalyser::new(Window::BlackmanHarris, rate)
        .analyse_welch(samples, MAX_SPECTRUM_SAMPLES)?;
    let lines = spectrum.lines(&LineCriterion::default());
    let tones = SpectralLines::of(&spectrum, &lines);
    progress(0.15, "delay and dimension")?;
    let embedding = Outcome::unless(obstacle.or(silence), || delay(newest, search, rate))?;
    let lag = embedding.get().ok().map(|embedding| embedding.choice.lag);
    let events = sound.as_ref().map_or(&[][..], |sound| &sound.tonal.events);
    let event_hz = stretch.event.map(|number| events[number - 1].frequency_hz);
    let period = period_of(event_hz, &tones.lines, lag, rate);
    progress(0.3, "spectrogram")?;
    let spectrogram = spectrogram(&signal, period)?;
    progress(0.4, "recurrence")?;
    let (dense, factor) = interpolated(studied, &lines);
    let recurrence = embedding.try_map(|embedding| {
        let mut recurrence = RecurrenceAnalysis::planned(&embedding.choice, search, &dense, factor);
        recurrence.quantify(&dense, factor as f64 * period)?;
        progress(0.55, "recurrence along the signal")?;
        recurrence.windows = recurrence.along(&dense)?;
        Ok::<_, SignalError>(recurrence)
    })?;
    progress(0.65, "section")?;
    let section = embedding.try_map(|found| section(&dense, factor, found.choice.lag))?;
    progress(0.68, "type of motion")?;
    let verdict = Outcome::unless(obstacle, || {
        let criterion = RegimeSearch {
            sample_rate: rate,
            silence: silent_below.unwrap_or(0.0),
            background: background_power(&signal, events, &stretch).unwrap_or(0.0),
        };
        classify(samples, &criterion)
    })?;
    let verdict = unless_hidden(verdict, events);
    let steady = match silence.or_else(|| unsteady(&verdict, &stretch)) {
        Some(skipped) => Outcome::Skipped { skipped },
        None => embedding.clone(),
    };
    progress(0.75, "divergence (Rosenstein)")?;
    let divergence =
        |method| steady.try_map(|found| divergence_by(newest, &found.choice, method, rate));
    let rosenstein = divergence(DivergenceMethod::Rosenstein)?;
    progress(0.82, "divergence (Kantz)")?;
    let kantz = divergence(kantz(newest.len()))?;
    progress(0.92, "0-1 test")?;
    let zero_one = steady.try_map(|found| test_zero_one(newest, found.choice.lag))?;
    Ok(SignalAnalysis {
        file: None,
        facts: SignalStatistics::of(&signal),
        stretch,
        verdict,
        spectrum,
        tones,
        spectrogram,
        nonlinear_samples: newest.len(),
        embedding,
        recurrence,
        section,
        rosenstein,
        kantz,
        zero_one,
        sound_levels,
        truth: None,
        sound,
        part,
        signal,
    })
}

/// The method of Kantz for a number of samples.
fn kantz(samples: usize) -> DivergenceMethod {
    let radius = KANTZ_RADII[usize::from(samples >= MANY_SAMPLES)];
    DivergenceMethod::Kantz { radius }
}

/// Sound levels of a signal that is calibrated or in Pa.
fn sound_levels(
    signal: &mut Signal,
    calibration: Option<Calibration>,
) -> Result<Option<CalibratedLevels>, SignalError> {
    Ok(match calibration {
        Some(calibration) => Some(CalibratedLevels::of(signal, calibration)?),
        // What is in Pa need not be a sound.
        None if signal.unit == LevelReference::PASCAL => {
            CalibratedLevels::of(signal, Calibration::PASCAL).ok()
        }
        None => None,
    })
}

/// The verdict on a stretch with these tonal events, where *noise* only means that the noise hides the motion.
fn unless_hidden(verdict: Outcome<Verdict>, events: &[TonalEvent]) -> Outcome<Verdict> {
    match verdict.get() {
        Ok(found) if found.regime == Regime::Noise && !events.is_empty() => Outcome::Skipped {
            skipped: SkipReason::Noise,
        },
        _ => verdict,
    }
}

/// Checks that the samples can be analysed.
fn check(samples: &[f64]) -> Result<(), AnalysisError> {
    if samples.len() < MIN_SAMPLES {
        return Err(AnalysisError::TooShort {
            what: "signal analysis",
            have: samples.len(),
            need: MIN_SAMPLES,
        });
    }
    let [low, high] = range(samples.iter().copied());
    let can_be_squared = samples.iter().all(|x| x.abs() <= MAX_SAMPLE);
    if !can_be_squared || (low < high && high - low < MIN_RANGE) {
        return Err(AnalysisError::SampleRange);
    }
    let buffers = SpectrumAnalyser::bytes(samples.len().min(MAX_SPECTRUM_SAMPLES));
    memory::check(buffers).map_err(|shortage| AnalysisError::Memory {
        samples: samples.len(),
        shortage,
    })
}

/// The amplitude (half the range) up to which a constant signal, or a constant sound with dither of one step of its
/// resolution on either side, is silent; `None` for any other signal.
fn silence(signal: &Signal) -> Option<f64> {
    let samples = &signal.samples;
    let [low, high] = range(samples.iter().copied());
    let steps = samples.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let step = steps.filter(|step| *step > 0.0).fold(high - low, f64::min);
    let is_dither = signal.unit == "FS" && high - low <= (2.5 * step).min(MAX_DITHER);
    (low == high || is_dither).then_some(2.0 * step)
}

/// Why averages over the divergence of trajectories are meaningless; `None` if they are not.
fn unsteady(verdict: &Outcome<Verdict>, stretch: &AnalysedStretch) -> Option<SkipReason> {
    match verdict.get() {
        Err(reason) => Some(reason),
        Ok(_) if stretch.clipped => Some(SkipReason::Clipped),
        Ok(verdict) if verdict.regime == Regime::Transient => Some(SkipReason::Transient),
        Ok(_) => None,
    }
}

fn test_zero_one(samples: &[f64], lag: usize) -> Result<ZeroOne, AnalysisError> {
    let most = (samples.len() / ZeroOneTest::MIN_SAMPLES).max(1);
    let stride = ZeroOneTest::recommended_stride(samples).max(lag).min(most);
    zero_one(samples, &ZeroOneTest::with_stride(stride))
}

impl SignalStatistics {
    /// The properties of a signal's samples.
    pub fn of(signal: &Signal) -> Self {
        let samples = &signal.samples;
        let [minimum, maximum] = range(samples.iter().copied());
        Self {
            name: signal.name.clone(),
            unit: signal.unit.clone(),
            sample_count: samples.len(),
            sample_rate_hz: signal.rate,
            start_s: signal.start,
            duration_s: signal.duration(),
            minimum,
            maximum,
            mean: mean(samples),
            standard_deviation: deviation(samples),
        }
    }
}

impl SpectralLines {
    /// Names the lines of a spectrum.
    pub fn of(spectrum: &Spectrum, lines: &[Line]) -> Self {
        let naming = identify_lines(lines, FREQUENCY_UNCERTAINTY * spectrum.bin);
        let labelled = naming.label(lines).into_iter().enumerate();
        let named = labelled.map(|(i, line)| NamedLine {
            line,
            misfit_hz: naming.misfit(i, lines[i]),
        });
        Self {
            bin_width_hz: spectrum.bin,
            broadband_share: spectrum.broadband_share(),
            beat_hz: naming.bases.beat(),
            lines: named.collect(),
            naming,
        }
    }
}

/// Spectrogram window of a signal of `count` samples with a dominant period (samples). It balances time and
/// frequency resolution, but separates sidebands at a twelfth of the tone's frequency.
pub(super) fn spectrogram_window(count: usize, period: f64) -> usize {
    let balanced = 2.0 * (count as f64).sqrt();
    let resolving = (SPECTROGRAM_PERIODS * period).min(count as f64 / 8.0);
    let length = balanced.max(resolving) as usize;
    length.next_power_of_two().clamp(64, 8192).min(count)
}

fn spectrogram(signal: &Signal, period: f64) -> Result<Vec<Column>, AnalysisError> {
    let count = signal.samples.len();
    let length = spectrogram_window(count, period);
    let hop = ((count - length) as f64 / COLUMNS as f64).max(length as f64 / 8.0);
    let mut columns = Vec::new();
    Stft::new(Window::Hann, length, hop, signal.rate).push(&signal.samples, |column| {
        columns.push(column);
        Ok::<(), AnalysisError>(())
    })?;
    Ok(columns)
}

/// Delay and dimension, each chosen or given.
fn delay(
    samples: &[f64],
    search: &SignalOptions,
    rate: f64,
) -> Result<DelayEmbedding, AnalysisError> {
    let rules = DelaySearch::for_samples(samples.len());
    let mut choice = choose_delay(samples, &rules)?;
    if let Some(lag) = search.lag {
        choice.lag = lag;
        choice.theiler = choice.theiler.max(lag);
        let again = FalseNeighbourSearch::new(lag, rules.largest_dimension, choice.theiler);
        choice.neighbours = false_neighbours(samples, &again)?;
        if let Some(dimension) = choice.neighbours.dimension(rules.false_share) {
            choice.dimension = dimension;
        }
    }
    if let Some(dimension) = search.dimension {
        choice.dimension = dimension;
    }
    let shares = &choice.neighbours.share;
    let share = shares.get(choice.dimension.wrapping_sub(1));
    choice.unfolded = share.is_some_and(|share| *share <= rules.false_share);
    Ok(DelayEmbedding {
        lag_s: choice.lag as f64 / rate,
        theiler_s: choice.theiler as f64 / rate,
        choice,
    })
}

/// Period that sets the span of pictures, samples: that of the analysed event, of the strongest line, or four
/// delays, because the mutual information has its first minimum near a quarter period.
pub(super) fn period_of(
    event_hz: Option<f64>,
    lines: &[NamedLine],
    lag: Option<usize>,
    rate: f64,
) -> f64 {
    let frequency = event_hz.or_else(|| Some(lines.first()?.line.frequency));
    frequency.map_or(4.0 * lag.unwrap_or(1) as f64, |frequency| rate / frequency)
}

impl RecurrenceAnalysis {
    /// The settings for a delay and a signal with `interpolation` samples per sample; nothing is measured yet.
    fn planned(
        delay: &DelayChoice,
        search: &SignalOptions,
        signal: &Signal,
        interpolation: usize,
    ) -> Self {
        // A short signal keeps all its samples.
        let samples = newest(&signal.samples, interpolation).len();
        let affordable = (samples / WINDOW_STATES).max(1);
        let lag = interpolation * delay.lag;
        let stride = (lag / STATES_PER_LAG).clamp(1, affordable);
        let lag = (lag as f64 / stride as f64).round() as usize;
        let theiler = search.theiler.map(|samples| interpolation * samples);
        let given = theiler.map(|samples| samples.div_ceil(stride));
        let theiler = given.unwrap_or(lag);
        Self {
            rule: RecurrenceCriterion {
                norm: search.norm,
                threshold: search.threshold.unwrap_or(Threshold::Rate(RECURRENCE_RATE)),
                theiler,
            },
            epsilon: None,
            min_diagonal_states: search.min_diagonal.unwrap_or(MIN_LINE),
            min_vertical_states: search.min_vertical.unwrap_or(MIN_LINE),
            line_of_identity: theiler == 0,
            interpolation,
            stride_samples: stride,
            lag_states: lag,
            dimension: delay.dimension,
            states: 0,
            theiler_s: theiler as f64 * (stride as f64 / signal.rate),
            recurrence_periods: RecurrencePeriods::default(),
            measures: Measures::default(),
            windows: Vec::new(),
            picture: RecurrenceImage::default(),
        }
    }

    /// Number of samples for `states` states.
    fn samples_for(&self, states: usize) -> usize {
        DelayVectors::samples_for(states, self.lag_states, self.dimension)
    }

    /// Quantifies and draws the newest states.
    fn quantify(&mut self, signal: &Signal, period: f64) -> Result<(), AnalysisError> {
        let newest = newest(&signal.samples, self.interpolation);
        let taken = thinned(newest, self.stride_samples);
        let taken = &taken[taken.len().saturating_sub(self.samples_for(MAX_STATES))..];
        let (measures, epsilon, states) = self.measured(taken)?;
        (self.epsilon, self.states) = (epsilon, states);
        let threshold = match (self.rule.threshold, self.epsilon) {
            (Threshold::Distance(_) | Threshold::Spread(_), Some(distance)) => {
                Threshold::Distance(distance)
            }
            (Threshold::Rate(rate), _) => Threshold::Rate(rate),
            _ => Threshold::Rate(measures.recurrence_rate),
        };
        self.measures = measures.in_seconds(self.stride_samples as f64 / signal.rate);
        let (lag, norm) = (self.lag_states * self.stride_samples, self.rule.norm);
        let periods = recurrence_periods(newest, lag, self.dimension, norm)?;
        self.recurrence_periods = periods.in_seconds(1.0 / signal.rate);
        let vectors = DelayVectors::new(newest, lag, self.dimension)?;
        self.picture = picture(&vectors, signal.rate, period, norm, threshold)?;
        Ok(())
    }

    /// Measures in windows along the whole signal. A constant window has none.
    fn along(&self, signal: &Signal) -> Result<Vec<MeasuresAt>, AnalysisError> {
        // Thin each window separately: a thinned copy of the signal could need as much memory as the signal.
        let stride = self.stride_samples;
        let ahead = (signal.samples.len() - 1) % stride;
        let count = (signal.samples.len() - 1) / stride + 1;
        let length = self.samples_for(WINDOW_STATES).min(count / 3);
        if length < self.samples_for(2) {
            return Ok(Vec::new());
        }
        let free = count - length;
        let windows = WINDOWS.min(free + 1);
        let mut along = Vec::with_capacity(windows);
        for k in 0..windows {
            let first = free * k / (windows - 1).max(1);
            let begin = ahead + first * stride;
            let window = &signal.samples[begin..=begin + (length - 1) * stride];
            let taken = thinned(window, stride);
            if taken.iter().all(|x| *x == taken[0]) {
                continue;
            }
            let centre = (first as f64 + 0.5 * length as f64) * stride as f64;
            let (measures, ..) = self.measured(&taken)?;
            along.push(MeasuresAt {
                time_s: signal.time(centre),
                measures: measures.in_seconds(stride as f64 / signal.rate),
            });
        }
        Ok(along)
    }

    /// Measures of some samples, the threshold distance unless each state has its own, and the number of states.
    fn measured(&self, taken: &[f64]) -> Result<(Measures, Option<f64>, usize), AnalysisError> {
        let vectors = DelayVectors::new(taken, self.lag_states, self.dimension)?;
        let recurrences = Recurrences::of(&vectors, &self.rule)?;
        let counts = recurrences.counts();
        let [diagonal, vertical] = [self.min_diagonal_states, self.min_vertical_states];
        let measures = counts.measures(diagonal, vertical, RateBase::Counted);
        Ok((measures, recurrences.distance(), counts.columns))
    }
}

/// The recurrence picture of the newest periods of delay vectors.
fn picture(
    vectors: &DelayVectors<'_>,
    rate: f64,
    period: f64,
    norm: Norm,
    threshold: Threshold,
) -> Result<RecurrenceImage, AnalysisError> {
    let span = (PICTURE_PERIODS * period) as usize;
    let hop = (span / PICTURE).clamp(1, (vectors.len() / PICTURE).max(1));
    let size = PICTURE.min(vectors.len());
    let first = vectors.len() - 1 - (size - 1) * hop;
    let picks: Vec<usize> = (0..size).map(|k| first + k * hop).collect();
    let criterion = RecurrenceCriterion {
        norm,
        threshold,
        theiler: 1,
    };
    let window = ((size - 1) * hop) as f64 / rate;
    RecurrenceImage::new(vectors, &picks, &criterion, window, 1.0 / rate)
}

/// The newest samples, for the nonlinear methods, of a signal with `interpolation` samples per sample.
fn newest(samples: &[f64], interpolation: usize) -> &[f64] {
    &samples[samples
        .len()
        .saturating_sub(interpolation * MAX_NONLINEAR_SAMPLES)..]
}

/// The signal with samples so dense that section and recurrences are those of the motion and not of the sampling, and the
/// number of its samples per sample. A long signal stays as it is.
fn interpolated<'a>(signal: &'a Signal, lines: &[Line]) -> (Cow<'a, Signal>, usize) {
    let factor = upsampling(lines, signal.rate);
    if factor == 1 || signal.samples.len() > MAX_INTERPOLATED {
        (Cow::Borrowed(signal), 1)
    } else {
        (Cow::Owned(signal.interpolated(factor)), factor)
    }
}

/// The newest crossings of the mean level.
fn section(
    signal: &Signal,
    interpolation: usize,
    lag: usize,
) -> Result<PoincareSection, AnalysisError> {
    let newest = newest(&signal.samples, interpolation);
    let (level, lag) = (mean(newest), interpolation * lag);
    let mut found = delay_section(newest, lag, SECTION_DIMENSION, level, Direction::Rising)?;
    found.drain(..found.len().saturating_sub(MAX_CROSSINGS));
    let ahead = (signal.samples.len() - newest.len()) as f64;
    let point = |crossing: &Crossing| SectionPoint {
        time_s: signal.time(ahead + crossing.sample),
        at: [crossing.point[0], crossing.point[2]],
    };
    let crossings: Vec<SectionPoint> = found.iter().map(point).collect();
    let points: Vec<&[f64]> = crossings.iter().map(|crossing| &crossing.at[..]).collect();
    let [low, high] = range(newest.iter().copied());
    Ok(PoincareSection {
        level,
        shape: section_shape(&points, high - low),
        mean_return_time_s: (crossings.len() > 1).then(|| {
            let span = crossings[crossings.len() - 1].time_s - crossings[0].time_s;
            span / (crossings.len() - 1) as f64
        }),
        crossings,
    })
}

fn divergence_by(
    samples: &[f64],
    delay: &DelayChoice,
    method: DivergenceMethod,
    rate: f64,
) -> Result<Divergence, AnalysisError> {
    let rules =
        DivergenceSearch::for_delay(delay.lag, delay.dimension, delay.theiler, samples.len());
    let divergence = divergence(samples, &DivergenceSearch { method, ..rules })?;
    Ok(divergence.in_seconds(rate))
}

#[cfg(test)]
#[path = "analyse_tests.rs"]
mod tests;
