//! The report of `squeakscope analyse` for the terminal.

use std::fmt::Write as _;
use std::path::Path;

use anstyle::Style;

use super::report::HEADING;
use super::sound_text::sound_text;
use crate::analysis::{
    Bases, Divergence, LagReason, Measures, RecurrencePeriod, SectionShape, SoundLevels, Threshold,
    TonalEvent, Verdict,
};
use crate::escape;
use crate::number::{significant, time};
use crate::study::signal::{
    AnalysedStretch, CalibratedLevels, DelayEmbedding, Outcome, PoincareSection,
    RecurrenceAnalysis, SignalAnalysis, SignalStatistics, SkipReason, SpectralLines,
};
use crate::table::Table;

const FAINT: Style = Style::new().dimmed();

/// Number of significant digits.
const DIGITS: usize = 4;

/// Remark on a stretch with clipped samples.
const CLIPPED: &str =
    "  samples are clipped: harmonics may be artefacts of the recording, not of the motion\n";

/// The report on the signal of a file: what sounds when, then one paragraph per analysis.
pub(super) fn text(file: &Path, report: &SignalAnalysis) -> String {
    let unit = escape::line(&report.facts.unit);
    let amount = |value: f64| {
        let text = format!("{} {unit}", significant(value, DIGITS));
        text.trim_end().to_owned()
    };
    let sound = report.sound.as_ref();
    let sound = sound.map(|sound| sound_text(sound, report.facts.duration_s, &amount));
    let paragraphs = [
        signal_text(file, &report.facts, &amount),
        stretch_text(&report.stretch, report.event()),
        verdict_text(&report.verdict),
        spectrum_text(&report.tones, &amount),
        match report.embedding.get() {
            Ok(embedding) => embedding_text(embedding, report.nonlinear_samples),
            Err(reason) => skipped("delay embedding", reason),
        },
        match report.recurrence.get() {
            Ok(recurrence) => recurrence_text(recurrence, &amount),
            Err(reason) => skipped("recurrence", reason),
        },
        match report.section.get() {
            Ok(section) => section_text(section, &amount),
            Err(reason) => skipped("Poincare section", reason),
        },
        chaos_text(report),
    ];
    let paragraphs: Vec<String> = sound.into_iter().chain(paragraphs).collect();
    paragraphs.join("\n")
}

/// The sound levels of a calibrated signal.
pub(super) fn levels_text(found: &CalibratedLevels) -> String {
    let SoundLevels {
        equivalent_level_db,
        a_weighted_level_db,
        fast_maximum_db,
        peak_level_db,
        third_octaves,
    } = &found.levels;
    let mut text = format!(
        "{HEADING}sound levels{HEADING:#}, dB re 20 uPa\n  A-weighted: equivalent {a_weighted_level_db:.1}, maximum \
             (fast) {fast_maximum_db:.1}; unweighted: equivalent {equivalent_level_db:.1}, peak {peak_level_db:.1}\n"
    );
    let sensitivity = significant(found.calibration.sensitivity_pa, 4);
    let _ = match found.calibration.calibrator {
        None => writeln!(text, "  calibration: 1 unit is {sensitivity} Pa, as given"),
        Some(tone) => writeln!(
            text,
            "  calibration: 1 unit is {sensitivity} Pa, by a tone of {:.1} Hz at {} dB that varies by {:.2} dB; the \
                 uncertainty of the calibrator (class 1: up to 0.4 dB) and of the microphone adds to it",
            tone.tone_hz, tone.stated_level_db, tone.level_deviation_db
        ),
    };
    let mut table = Table::default()
        .right("third octave, Hz")
        .right("dB")
        .right("+-");
    for band in third_octaves {
        table.row([
            band.centre_hz.to_string(),
            format!("{:.1}", band.band_level_db),
            format!("{:.1}", band.standard_deviation_db),
        ]);
    }
    text += &table.text();
    text + "  +-: standard deviation for random noise; less for tones\n"
}

/// An analysis that was skipped.
fn skipped(name: &str, reason: SkipReason) -> String {
    format!("{HEADING}{name}{HEADING:#} skipped: {reason}\n")
}

/// The analysed stretch; nothing for the whole of a signal without events.
fn stretch_text(stretch: &AnalysedStretch, event: Option<&TonalEvent>) -> String {
    let span = format!("{:.3} to {:.3} s", stretch.start_s, stretch.end_s);
    let Some((number, event)) = stretch.event.zip(event) else {
        return match stretch.clipped {
            true => format!("{HEADING}analysed{HEADING:#} {span}, the whole signal\n{CLIPPED}"),
            false => format!("{HEADING}analysed{HEADING:#} {span}, the whole signal\n"),
        };
    };
    let mut text = format!("{HEADING}analysed{HEADING:#} {span}, in event {number}");
    if stretch.demodulated {
        let frequency = significant(event.frequency_hz, 6);
        text += &format!(", demodulated along its ridge to {frequency} Hz");
    }
    if let Some([low, high]) = stretch.band_hz {
        let [low, high] = [low, high].map(|hz| significant(hz, DIGITS));
        text += &format!(", filtered to {low} to {high} Hz");
    }
    text.push('\n');
    if stretch.clipped {
        text += CLIPPED;
    }
    if let Some(modulation) = &event.modulation {
        text += &format!(
            "  the amplitude is modulated at {} Hz: sidebands at this distance are no second frequency of the motion by themselves\n",
            significant(modulation.modulation_hz, 3)
        );
    }
    text
}

fn signal_text(file: &Path, facts: &SignalStatistics, amount: &dyn Fn(f64) -> String) -> String {
    let [smallest, largest, deviation, mean] =
        [facts.smallest, facts.largest, facts.deviation, facts.mean].map(amount);
    format!(
        "{HEADING}{}{HEADING:#} {FAINT}{}{FAINT:#}\n  \
         {} samples at {} Hz: {}, starting at {:.6} s\n  \
         range {smallest} to {largest}, mean {mean}, standard deviation {deviation}\n",
        escape::line(&facts.name),
        escape::path(file),
        facts.samples,
        facts.rate_hz,
        duration(facts.duration_s),
        facts.start_s,
    )
}

fn verdict_text(verdict: &Outcome<Verdict>) -> String {
    let verdict = match verdict.get() {
        Ok(verdict) => verdict,
        Err(reason) => return skipped("type of motion", reason),
    };
    let limitation = verdict.limitation.map(|what| format!("  {what}\n"));
    let limitation = limitation.unwrap_or_default();
    let evidence = verdict.evidence.iter().filter(|piece| piece.matters());
    let evidence = evidence.map(|piece| {
        let factor = significant(piece.factor(), 2);
        format!(
            "  {factor:>5} x {}: {}\n",
            piece.supports, piece.description
        )
    });
    let summary = verdict.summary();
    let (regime, rest) = summary.split_at(verdict.regime.to_string().len());
    format!("{HEADING}{regime}{HEADING:#}{rest}\n{limitation}") + &evidence.collect::<String>()
}

fn spectrum_text(tones: &SpectralLines, amount: &dyn Fn(f64) -> String) -> String {
    // Frequencies are accurate to a small fraction of a bin.
    let decimals = (3.0 - tones.bin_hz.log10().floor()).clamp(3.0, 15.0) as usize;
    let mut table = Table::default().right("").right("").left("").left("");
    for named in &tones.lines {
        let line = &named.line;
        // The misfit of a fundamental is zero by definition.
        let is_fundamental = ["f1", "f2"].contains(&&*line.label);
        let misfit = named.misfit_hz.filter(|_| !is_fundamental);
        table.row([
            format!("{:.decimals$} Hz", line.frequency),
            amount(line.amplitude),
            line.label.clone(),
            misfit.map_or_else(String::new, |hz| format!("misfit {hz:+.decimals$} Hz")),
        ]);
    }
    let lines = match tones.lines[..] {
        [] => "  none\n".to_owned(),
        _ => table.text(),
    };
    let lines = lines + &pattern_text(tones);
    format!(
        "{HEADING}spectral lines{HEADING:#} (bin width {} Hz, broadband share {} of the power)\n{lines}",
        significant(tones.bin_hz, DIGITS),
        percent(tones.broadband_share)
    )
}

/// What the names of the lines say beyond the base frequencies: a doubling or a modulation.
fn pattern_text(tones: &SpectralLines) -> String {
    let ending = ["/1", "/2", "/4"][tones.naming.doubling.min(2) as usize];
    let mut labels = tones.lines.iter().map(|named| &*named.line.label);
    match (
        tones.naming.bases,
        labels.find(|label| label.ends_with(ending)),
    ) {
        (Bases::Modulated { fm, .. }, _) => format!(
            "  symmetric sidebands: a tone modulated at fm = {} Hz; the spectrum does not tell whether the \
             modulation is a motion of its own\n",
            significant(fm, DIGITS)
        ),
        (Bases::Two { .. }, Some(line)) => {
            format!("  two tones, doubled (lines at {line}): a doubled torus, if quasi-periodic\n")
        }
        (_, Some(line)) => format!("  period doubled (lines at {line})\n"),
        (_, None) => String::new(),
    }
}

fn embedding_text(states: &DelayEmbedding, samples: usize) -> String {
    let choice = &states.choice;
    let reason = match choice.reason {
        LagReason::FirstMinimum => "first minimum of the mutual information",
        LagReason::FirstDecay => "the mutual information falls to 1/e",
        LagReason::Largest => "largest delay tried, the mutual information has no minimum",
    };
    let false_share = choice.neighbours.share.get(choice.dimension - 1);
    format!(
        "{HEADING}delay embedding{HEADING:#} of the last {samples} samples\n  \
         delay tau = {} ({} {}): {reason}\n  \
         dimension m = {}: {} false nearest neighbours{}\n",
        duration(states.lag_s),
        choice.lag,
        if choice.lag == 1 { "sample" } else { "samples" },
        choice.dimension,
        false_share.map_or("unknown share of".to_owned(), |share| percent(*share)),
        if choice.unfolded {
            ""
        } else {
            " (the attractor is not unfolded)"
        },
    )
}

fn recurrence_text(recurrence: &RecurrenceAnalysis, amount: &dyn Fn(f64) -> String) -> String {
    let (threshold, value) = match recurrence.rule.threshold {
        Threshold::Rate(rate) => ("rate", rate),
        Threshold::Distance(distance) => ("distance", distance),
        Threshold::Spread(spread) => ("spread", spread),
        Threshold::Neighbours(count) => ("neighbours", count as f64),
    };
    let epsilon = recurrence
        .epsilon
        .map(|epsilon| format!(": epsilon = {}", amount(epsilon)));
    let period = |found: &RecurrencePeriod| {
        let frequency = significant(1.0 / found.period, DIGITS);
        format!(
            "  diagonal spacing, {}: {}: {frequency} Hz ({} of the recurrences)\n",
            found.kind,
            duration(found.period),
            percent(found.share)
        )
    };
    let periods: String = recurrence.periods.0.iter().map(period).collect();
    format!(
        "{HEADING}recurrence{HEADING:#} of {} states ({threshold} {}{})\n{}{}",
        recurrence.states,
        significant(value, DIGITS),
        epsilon.unwrap_or_default(),
        measures_text(&recurrence.measures),
        periods
    )
}

fn measures_text(measures: &Measures) -> String {
    format!(
        "  RR {}   DET {}   LAM {}   ENTR {}   TREND {}\n  L {}   Lmax {}   TT {}   T1 {}   T2 {}\n",
        percent(measures.recurrence_rate),
        or_none(measures.determinism, percent),
        or_none(measures.laminarity, percent),
        or_none(measures.entropy, |nats| format!("{nats:.2}")),
        or_none(measures.trend, |trend| significant(trend, DIGITS)),
        or_none(measures.mean_diagonal, duration),
        duration(measures.longest_diagonal),
        or_none(measures.trapping_time, duration),
        or_none(measures.recurrence_time_1, duration),
        or_none(measures.recurrence_time_2, duration)
    )
}

fn section_text(section: &PoincareSection, amount: &dyn Fn(f64) -> String) -> String {
    let shape = match section.shape {
        SectionShape::TooFew => "too few to classify the shape",
        SectionShape::Points(1) => "one point",
        SectionShape::Points(count) => &format!("{count} points"),
        SectionShape::Loop => "a loop",
        SectionShape::Arc => "an arc",
        SectionShape::Cloud => "a cloud",
    };
    let spacing = section.mean_return_s;
    let spacing = spacing.map(|seconds| format!(", mean return time {}", duration(seconds)));
    format!(
        "{HEADING}Poincare section{HEADING:#} y(t + tau) = {}, rising: {} crossings, {shape}{}\n",
        amount(section.level),
        section.passages.len(),
        spacing.unwrap_or_default()
    )
}

fn chaos_text(report: &SignalAnalysis) -> String {
    let method = |name: &str, divergence: &Divergence| match divergence.region {
        Some(region) => format!(
            "  {name:<10}  {} +- {} 1/s, from {} to {}\n",
            significant(region.slope, DIGITS),
            significant(region.error, DIGITS),
            duration(region.from),
            duration(region.to)
        ),
        None => format!("  {name:<10}  none: nearby trajectories do not diverge exponentially\n"),
    };
    let exponents = match (report.rosenstein.get(), report.kantz.get()) {
        (Ok(rosenstein), Ok(kantz)) => format!(
            "{HEADING}largest Lyapunov exponent{HEADING:#}\n{}{}",
            method("Rosenstein", rosenstein),
            method("Kantz", kantz)
        ),
        (Err(reason), _) | (_, Err(reason)) => skipped("largest Lyapunov exponent", reason),
    };
    let test = match report.zero_one.get() {
        Ok(test) => {
            let sampling = match test.stride {
                1 => "every sample".to_owned(),
                stride => format!("one sample in {stride}"),
            };
            format!(
                "{HEADING}0-1 test{HEADING:#} K = {:.3} (0: regular, 1: chaos or noise), from {sampling}\n",
                test.k
            )
        }
        Err(reason) => skipped("0-1 test", reason),
    };
    format!("{exponents}\n{test}")
}

fn duration(seconds: f64) -> String {
    time(seconds, DIGITS)
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn or_none(value: Option<f64>, show: impl Fn(f64) -> String) -> String {
    value.map_or("none".to_owned(), show)
}
