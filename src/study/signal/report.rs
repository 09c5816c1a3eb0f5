//! The report of an analysed signal: what sounds when, then one paragraph per analysis.

use super::{
    AnalysedStretch, CalibratedLevels, DelayEmbedding, MeasuredSound, Outcome, PoincareSection,
    RecurrenceAnalysis, Score, SignalAnalysis, SignalStatistics, SkipReason, SpectralLines,
    TotalScore,
};
use crate::analysis::{
    chaos::Divergence,
    condition::RecordingCondition,
    delay::LagReason,
    events::{Hum, Span, TonalEvent},
    levels::{LevelReference, SoundLevels},
    poincare::SectionShape,
    recurrence::{Measures, RecurrencePeriods, Threshold},
    regime::{Regime, Verdict},
    tones::Bases,
};
use crate::escape;
use crate::number::{counted, fixed, quantity, significant, with_error};
use crate::report::{Block, Report, Table};

/// Number of significant digits.
const DIGITS: usize = 4;

/// Remark on a stretch with clipped samples.
const CLIPPED: &str =
    "samples are clipped: harmonics may be artefacts of the recording, not of the motion";

/// Formats a value in the unit of the signal.
type Amount<'a> = &'a dyn Fn(f64) -> String;

impl Report for SignalAnalysis {
    fn blocks(&self, _name: &str) -> Vec<Block> {
        let unit = escape::line(&self.facts.unit);
        let amount = |value: f64| {
            let text = format!("{} {unit}", significant(value, DIGITS));
            text.trim_end().to_owned()
        };
        let mut blocks = Vec::new();
        blocks.extend(self.truth.iter().flat_map(Score::blocks));
        blocks.extend(self.sound_levels.iter().flat_map(levels));
        if let Some(sound) = &self.sound {
            blocks.extend(self::sound(sound, self.facts.duration_s, &amount));
        }
        let file = self.file.as_ref().map(|file| file.to_string_lossy());
        blocks.extend(facts(&file.unwrap_or_default(), &self.facts, &amount));
        blocks.extend(stretch(&self.stretch, self.event()));
        blocks.extend(verdict(&self.verdict));
        blocks.extend(spectrum(&self.tones, &amount));
        blocks.extend(found("delay embedding", &self.embedding, |states| {
            embedding(states, self.nonlinear_samples)
        }));
        blocks.extend(found("recurrence", &self.recurrence, |states| {
            recurrence(states, &amount)
        }));
        blocks.extend(found("Poincare section", &self.section, |points| {
            let verdict = self.verdict.get();
            let is_periodic = verdict.is_ok_and(|found| found.regime == Regime::Periodic);
            section(points, is_periodic, &amount)
        }));
        blocks.extend(chaos(self));
        blocks
    }
}

/// The blocks of an analysis, or why it was skipped.
fn found<T>(name: &str, outcome: &Outcome<T>, blocks: impl FnOnce(&T) -> Vec<Block>) -> Vec<Block> {
    match outcome.get() {
        Ok(found) => blocks(found),
        Err(reason) => vec![skipped(name, reason)],
    }
}

/// An analysis that was skipped.
fn skipped(name: &str, reason: SkipReason) -> Block {
    Block::heading(name, format!(" skipped: {reason}"))
}

impl TotalScore {
    /// Events compared with labels.
    pub fn block(&self) -> Block {
        let (found, missed, labels) = (self.found, self.missed, self.found + self.missed);
        let surplus = counted(self.false_events, "false event");
        Block::heading(
            "labels",
            format!(" {found} of {labels} labels found, {missed} missed; {surplus}"),
        )
    }
}

impl Score {
    /// Events compared with labels: the counts, and what is missed.
    pub fn blocks(&self) -> Vec<Block> {
        let total = TotalScore::of([self]).map(|total| total.block());
        total.into_iter().chain(self.missed_labels()).collect()
    }

    /// The labels without an event.
    pub fn missed_labels(&self) -> impl Iterator<Item = Block> {
        self.missed.iter().map(|label| {
            let (Span { start_s, end_s }, name) = (label.span, escape::line(&label.text));
            let line = format!("missed: {start_s:.3} to {end_s:.3} s {name}");
            Block::text(line.trim_end())
        })
    }
}

/// The sound levels of a calibrated signal.
fn levels(found: &CalibratedLevels) -> Vec<Block> {
    let SoundLevels {
        equivalent_level_db,
        a_weighted_level_db,
        fast_maximum_db,
        peak_level_db,
        third_octaves,
    } = &found.levels;
    let sensitivity = significant(found.calibration.sensitivity_pa, 4);
    let calibration = match found.calibration.calibrator {
        None => format!("calibration: 1 unit is {sensitivity} Pa, as given"),
        Some(tone) => format!(
            "calibration: 1 unit is {sensitivity} Pa, by a tone of {:.1} Hz at {} dB that varies by {:.2} dB; the \
             uncertainty of the calibrator (class 1: up to 0.4 dB) and of the microphone adds to it",
            tone.tone_hz, tone.stated_level_db, tone.level_deviation_db
        ),
    };
    let table = Table::of(third_octaves)
        .right("third octave, Hz", |band| band.centre_hz.to_string())
        .right("dB", |band| fixed(band.band_level_db, 1))
        .right("±", |band| fixed(band.standard_deviation_db, 1));
    vec![
        Block::heading("sound levels", ", dB re 20 uPa"),
        Block::text(format!(
            "A-weighted: equivalent {a_weighted_level_db:.1}, maximum (fast) {fast_maximum_db:.1}; unweighted: \
             equivalent {equivalent_level_db:.1}, peak {peak_level_db:.1}"
        )),
        Block::text(calibration),
        table.into(),
        Block::text("±: standard deviation for random noise; less for tones"),
    ]
}

/// The analysed stretch.
fn stretch(stretch: &AnalysedStretch, event: Option<&TonalEvent>) -> Vec<Block> {
    let span = format!(" {:.3} to {:.3} s", stretch.start_s, stretch.end_s);
    let clipped = stretch.clipped.then(|| Block::text(CLIPPED));
    let Some((number, event)) = stretch.event.zip(event) else {
        let whole = Block::heading("analysed", format!("{span}, the whole signal"));
        return std::iter::once(whole).chain(clipped).collect();
    };
    let mut rest = format!("{span}, in event {number}");
    if stretch.demodulated {
        let frequency = significant(event.frequency_hz, 6);
        rest += &format!(", demodulated along its ridge to {frequency} Hz");
    }
    if let Some([low, high]) = stretch.band_hz {
        let [low, high] = [low, high].map(|hz| significant(hz, DIGITS));
        rest += &format!(", filtered to {low} to {high} Hz");
    }
    let mut blocks = vec![Block::heading("analysed", rest)];
    blocks.extend(clipped);
    blocks.extend(event.modulation.map(|modulation| {
        Block::text(format!(
            "the amplitude is modulated at {} Hz: sidebands at this distance are no second frequency of the motion by themselves",
            significant(modulation.modulation_hz, 3)
        ))
    }));
    blocks
}

/// Samples, rate, duration and range of the signal.
fn facts(file: &str, facts: &SignalStatistics, amount: Amount<'_>) -> [Block; 3] {
    [
        Block::heading(&facts.name, format!(" {file}")),
        Block::text(format!(
            "{} samples at {} Hz: {}, starting at {:.6} s",
            facts.sample_count,
            facts.sample_rate_hz,
            duration(facts.duration_s),
            facts.start_s,
        )),
        Block::text(format!(
            "range {} to {}, mean {}, standard deviation {}",
            amount(facts.minimum),
            amount(facts.maximum),
            amount(facts.mean),
            amount(facts.standard_deviation)
        )),
    ]
}

/// The type of motion with its evidence.
fn verdict(verdict: &Outcome<Verdict>) -> Vec<Block> {
    found("type of motion", verdict, |verdict| {
        let summary = verdict.summary();
        let (regime, rest) = summary.split_at(verdict.regime.to_string().len());
        let mut blocks = vec![Block::heading(regime, rest)];
        let limitation = verdict.limitation;
        blocks.extend(limitation.map(|it| Block::text(it.to_string())));
        if let [first, .., _] = &verdict.intervals[..] {
            let (count, length) = (verdict.intervals.len(), duration(first.length_s()));
            blocks.push(Block::text(format!(
                "mean of {count} intervals of {length}, spread over the stretch; the evidence is that of a typical one"
            )));
        }
        let evidence = verdict.evidence.iter().filter(|piece| piece.matters());
        blocks.extend(evidence.map(|piece| {
            let (factor, supports) = (significant(piece.factor(), 2), piece.supports);
            let description = &piece.description;
            Block::text(format!("{factor:>5} x {supports}: {description}"))
        }));
        blocks
    })
}

/// The spectral lines with their names.
fn spectrum(tones: &SpectralLines, amount: Amount<'_>) -> Vec<Block> {
    // Frequencies are accurate to a small fraction of a bin.
    let decimals = (3.0 - tones.bin_width_hz.log10().floor()).clamp(3.0, 15.0) as usize;
    let table = Table::of(&tones.lines)
        .right("", |it| format!("{:.decimals$} Hz", it.line.frequency))
        .right("", |it| amount(it.line.amplitude))
        .left("", |it| it.line.label.clone())
        .left("", |it| {
            // The misfit of a fundamental is zero by definition.
            let is_fundamental = ["f1", "f2"].contains(&&*it.line.label);
            let misfit = it.misfit_hz.filter(|_| !is_fundamental);
            misfit.map(|hz| format!("misfit {hz:+.decimals$} Hz"))
        });
    let width = significant(tones.bin_width_hz, DIGITS);
    let share = percent(tones.broadband_share);
    let rest = format!(" (bin width {width} Hz, broadband share {share} of the power)");
    let lines = match tones.lines[..] {
        [] => Block::text("none"),
        _ => table.into(),
    };
    let blocks = [Block::heading("spectral lines", rest), lines];
    blocks.into_iter().chain(pattern(tones)).collect()
}

/// What the names of the lines say beyond the base frequencies: a doubling or a modulation.
fn pattern(tones: &SpectralLines) -> Option<Block> {
    let ending = ["/1", "/2", "/4"][tones.naming.doubling.min(2) as usize];
    let mut labels = tones.lines.iter().map(|named| &*named.line.label);
    let doubled = labels.find(|label| label.ends_with(ending));
    let text = match (tones.naming.bases, doubled) {
        (Bases::Modulated { fm, .. }, _) => format!(
            "symmetric sidebands: a tone modulated at fm = {} Hz; the spectrum does not tell whether the modulation is \
             a motion of its own",
            significant(fm, DIGITS)
        ),
        (Bases::Two { .. }, Some(line)) => {
            format!("two tones, doubled (lines at {line}): a doubled torus, if quasi-periodic")
        }
        (_, Some(line)) => format!("period doubled (lines at {line})"),
        (_, None) => return None,
    };
    Some(Block::text(text))
}

/// Delay and dimension, and why they were chosen.
fn embedding(states: &DelayEmbedding, samples: usize) -> Vec<Block> {
    let choice = &states.choice;
    let reason = match choice.reason {
        LagReason::FirstMinimum => "first minimum of the mutual information",
        LagReason::FirstDecay => "the mutual information falls to 1/e",
        LagReason::Largest => "largest delay tried, the mutual information has no minimum",
    };
    let (lag, dimension) = (choice.lag, choice.dimension);
    let delay = duration(states.lag_s);
    let unit = if lag == 1 { "sample" } else { "samples" };
    let false_share = choice.neighbours.share.get(dimension - 1);
    let false_share = false_share.map_or("unknown share of".to_owned(), |share| percent(*share));
    let folded = if choice.unfolded {
        ""
    } else {
        " (the attractor is not unfolded)"
    };
    vec![
        Block::heading("delay embedding", format!(" of the last {samples} samples")),
        Block::text(format!("delay tau = {delay} ({lag} {unit}): {reason}")),
        Block::text(format!(
            "dimension m = {dimension}: {false_share} false nearest neighbours{folded}"
        )),
    ]
}

/// Threshold, measures and periods of the recurrence plot.
fn recurrence(recurrence: &RecurrenceAnalysis, amount: Amount<'_>) -> Vec<Block> {
    let (threshold, value) = match recurrence.rule.threshold {
        Threshold::Rate(rate) => ("rate", rate),
        Threshold::Distance(distance) => ("distance", distance),
        Threshold::Spread(spread) => ("spread", spread),
        Threshold::Neighbours(count) => ("neighbours", count as f64),
    };
    let epsilon = recurrence.epsilon;
    let epsilon = epsilon.map_or(String::new(), |epsilon| {
        format!(": epsilon = {}", amount(epsilon))
    });
    let (value, states) = (significant(value, DIGITS), recurrence.states);
    let rest = format!(" of {states} states ({threshold} {value}{epsilon})");
    let mut blocks = vec![Block::heading("recurrence", rest)];
    blocks.extend(measures(&recurrence.measures));
    blocks.extend(periods(&recurrence.recurrence_periods));
    blocks
}

/// The spacings of the diagonals of a recurrence plot.
pub(crate) fn periods(periods: &RecurrencePeriods) -> impl Iterator<Item = Block> {
    periods.0.iter().map(|found| {
        Block::text(format!(
            "diagonal spacing, {}: {}: {} Hz ({} of the recurrences)",
            found.kind,
            duration(found.period),
            significant(1.0 / found.period, DIGITS),
            percent(found.share)
        ))
    })
}

/// The measures of recurrence quantification.
pub(crate) fn measures(measures: &Measures) -> [Block; 2] {
    [
        Block::text(format!(
            "RR {}   DET {}   LAM {}   ENTR {}   TREND {}",
            percent(measures.recurrence_rate),
            or_none(measures.determinism, percent),
            or_none(measures.laminarity, percent),
            or_none(measures.entropy, |nats| format!("{nats:.2}")),
            or_none(measures.trend, |trend| significant(trend, DIGITS)),
        )),
        Block::text(format!(
            "L {}   Lmax {}   TT {}   T1 {}   T2 {}",
            or_none(measures.mean_diagonal, duration),
            duration(measures.longest_diagonal),
            or_none(measures.trapping_time, duration),
            or_none(measures.recurrence_time_1, duration),
            or_none(measures.recurrence_time_2, duration)
        )),
    ]
}

/// The shape of the Poincare section.
fn section(section: &PoincareSection, is_periodic: bool, amount: Amount<'_>) -> Vec<Block> {
    let shape = match section.shape {
        SectionShape::TooFew => "too few to classify the shape",
        SectionShape::Points(1) => "one point",
        SectionShape::Points(count) => &format!("{count} points"),
        SectionShape::Loop => "a loop",
        SectionShape::Arc => "an arc",
        SectionShape::Cloud if is_periodic => "a cloud (spread by noise or modulation)",
        SectionShape::Cloud => "a cloud",
    };
    let spacing = section.mean_return_time_s;
    let spacing = spacing.map(|seconds| format!(", mean return time {}", duration(seconds)));
    let rest = format!(
        " y(t + tau) = {}, rising: {} crossings, {shape}{}",
        amount(section.level),
        section.crossings.len(),
        spacing.unwrap_or_default()
    );
    vec![Block::heading("Poincare section", rest)]
}

/// The exponents by divergence of neighbours, and the 0-1 test.
fn chaos(report: &SignalAnalysis) -> Vec<Block> {
    let method = |name: &str, divergence: &Divergence| {
        Block::text(match divergence.region {
            Some(region) => format!(
                "{name:<10}  {} 1/s (± standard error), from {} to {}",
                with_error(region.slope, region.error),
                duration(region.from),
                duration(region.to)
            ),
            None if divergence.curve.is_empty() => {
                format!("{name:<10}  none: too few distinct neighbours")
            }
            None => format!("{name:<10}  none: nearby trajectories do not diverge exponentially"),
        })
    };
    const EXPONENT: &str = "largest Lyapunov exponent";
    let mut blocks = match (report.rosenstein.get(), report.kantz.get()) {
        (Ok(rosenstein), Ok(kantz)) => vec![
            Block::heading(EXPONENT, ""),
            method("Rosenstein", rosenstein),
            method("Kantz", kantz),
        ],
        (Err(reason), _) | (_, Err(reason)) => vec![skipped(EXPONENT, reason)],
    };
    blocks.extend(found("0-1 test", &report.zero_one, |test| {
        let sampling = match test.stride {
            1 => "every sample".to_owned(),
            stride => format!("one sample in {stride}"),
        };
        let k = test.k;
        let rest = format!(" K = {k:.3} (0: regular, 1: chaos or noise), from {sampling}");
        vec![Block::heading("0-1 test", rest)]
    }));
    blocks
}

fn duration(seconds: f64) -> String {
    quantity(seconds, DIGITS, "s")
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn or_none(value: Option<f64>, show: impl Fn(f64) -> String) -> String {
    value.map_or("none".to_owned(), show)
}

/// Relative offset above which it is mentioned.
const LARGE_OFFSET: f64 = 0.1;

/// Number of intervals in a list; the others are counted.
const LISTED: usize = 4;

/// The table of tonal events, and what the condition of the recording gives reason to mention.
/// `duration_s` is that of the signal.
fn sound(sound: &MeasuredSound, duration_s: f64, amount: Amount<'_>) -> Vec<Block> {
    let mut blocks = match &sound.tonal.events[..] {
        [] => vec![Block::heading("no events", "")],
        events => vec![
            Block::heading("events", ""),
            event_table(events, sound.level_reference),
        ],
    };
    let mut lines = condition(&sound.condition, duration_s, amount);
    lines.extend(hum(sound.tonal.hum, sound.level_reference));
    if !lines.is_empty() {
        blocks.push(Block::heading("recording", ""));
        blocks.extend(lines.into_iter().map(Block::text));
    }
    blocks
}

/// The tonal events, one per row.
fn event_table(events: &[TonalEvent], reference: LevelReference) -> Block {
    Table::of((1..).zip(events))
        .right("event", |(number, _)| format!("{number}"))
        .left("kind", |(_, it)| {
            format!("{}, {:.0} %", it.kind, 100.0 * it.probability)
        })
        .right("start, s", |(_, it)| fixed(it.start_s, 3))
        .right("end, s", |(_, it)| fixed(it.end_s, 3))
        .right("frequency, Hz", |(_, it)| fixed(it.frequency_hz, 1))
        .right("low to high, Hz", |(_, it)| {
            let [low, high] = [it.frequency_low_hz, it.frequency_high_hz];
            format!("{low:.1} to {high:.1}")
        })
        .right("harmonics", |(_, it)| it.harmonics.to_string())
        .right(format!("level, {reference}"), |(_, it)| {
            fixed(it.level_db, 1)
        })
        .right("SNR, dB", |(_, it)| fixed(it.snr_db, 1))
        .left("modulation", |(_, it)| modulation(it))
        .into()
}

/// Modulation of amplitude and frequency; empty if there is none.
fn modulation(event: &TonalEvent) -> String {
    let amplitude = event.modulation.map(|m| {
        let (rate, depth) = (significant(m.modulation_hz, 3), 100.0 * m.modulation_depth);
        format!("amplitude {rate} Hz, depth {depth:.0} %")
    });
    let frequency = event.vibrato.map(|v| {
        let [rate, deviation] = [v.vibrato_hz, v.vibrato_deviation_hz].map(|hz| significant(hz, 3));
        format!("vibrato {rate} Hz, deviation {deviation} Hz")
    });
    let parts: Vec<String> = amplitude.into_iter().chain(frequency).collect();
    parts.join("; ")
}

/// Faults of the recording.
fn condition(condition: &RecordingCondition, duration_s: f64, amount: Amount<'_>) -> Vec<String> {
    let mut lines = Vec::new();
    if !condition.clipped.is_empty() {
        let share = significant(100.0 * condition.clipped_share, 2);
        let spans = list(&condition.clipped);
        lines.push(format!("clipping: {share} % of the samples, {spans}"));
    }
    if condition.relative_offset.abs() > LARGE_OFFSET {
        let (mean, share) = (amount(condition.offset), condition.relative_offset.abs());
        lines.push(format!(
            "offset: mean {mean}, {share:.2} times the RMS deviation"
        ));
    }
    if !condition.dropouts.is_empty() {
        lines.push(format!("dropouts: {}", list(&condition.dropouts)));
    }
    let silent: f64 = condition.silence.iter().map(Span::length_s).sum();
    if silent > 0.0 {
        let share = 100.0 * silent / duration_s;
        let spans = list(&condition.silence);
        lines.push(format!("silence: {share:.0} % of the time, {spans}"));
    }
    lines
}

/// Mains hum.
fn hum(hum: Option<Hum>, reference: LevelReference) -> Option<String> {
    hum.map(|hum| {
        let frequency = significant(hum.fundamental_hz, 4);
        let level = hum.level_db;
        match hum.harmonics {
            1 => format!("mains hum: {frequency} Hz, {level:.1} {reference}"),
            n => format!("mains hum: {n} multiples of {frequency} Hz, {level:.1} {reference}"),
        }
    })
}

/// The first intervals, and the number of others.
fn list(spans: &[Span]) -> String {
    let shown = spans.iter().take(LISTED);
    let shown = shown.map(|span| format!("{:.3} to {:.3} s", span.start_s, span.end_s));
    let shown = shown.collect::<Vec<_>>().join(", ");
    match spans.len().saturating_sub(LISTED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}
