//! The report on a signal as text for the terminal.

use std::path::Path;

use anstyle::Style;

use crate::analysis::{Divergence, LagReason, Measures, SectionShape, Threshold, Verdict};
use crate::escape;
use crate::number::{significant, time};
use crate::study::signal::{
    RecurrenceReport, Section, SignalFacts, SignalReport, StateSpace, Tones,
};
use crate::table::Table;

const NAME: Style = Style::new().bold();
const FAINT: Style = Style::new().dimmed();

/// Significant digits of numbers.
const DIGITS: usize = 4;

/// The report on the signal of a file: paragraphs with an empty line between.
pub(super) fn text(file: &Path, report: &SignalReport) -> String {
    let unit = escape::line(&report.facts.unit);
    let amount = |value: f64| {
        let text = format!("{} {unit}", significant(value, DIGITS));
        text.trim_end().to_owned()
    };
    [
        of_signal(file, &report.facts, &amount),
        of_verdict(&report.verdict),
        of_tones(&report.tones, &amount),
        of_states(&report.embedding, report.nonlinear_samples),
        of_recurrence(&report.recurrence, &amount),
        of_section(&report.section, &amount),
        of_chaos(report),
    ]
    .join("\n")
}

fn of_signal(file: &Path, facts: &SignalFacts, amount: &dyn Fn(f64) -> String) -> String {
    let [smallest, largest, deviation, mean] =
        [facts.smallest, facts.largest, facts.deviation, facts.mean].map(amount);
    format!(
        "{NAME}{}{NAME:#} {FAINT}{}{FAINT:#}\n  \
         {} samples at {} Hz: {} from {:.6} s on\n  \
         from {smallest} to {largest}, deviation {deviation} about {mean}\n",
        escape::line(&facts.name),
        escape::path(file),
        facts.samples,
        facts.rate_hz,
        duration(facts.duration_s),
        facts.start_s,
    )
}

fn of_verdict(verdict: &Verdict) -> String {
    let sure = 100.0 * verdict.confidence;
    let evidence = verdict.evidence.iter().map(|evidence| {
        let bar = "#".repeat((5.0 * evidence.weight).round() as usize);
        format!("  {bar:<5} {}\n", evidence.words)
    });
    format!("{NAME}{}{NAME:#}, {sure:.0} % sure\n", verdict.regime) + &evidence.collect::<String>()
}

fn of_tones(tones: &Tones, amount: &dyn Fn(f64) -> String) -> String {
    // A line is placed well below a bin, however slow the signal.
    let decimals = (3.0 - tones.bin_hz.log10().floor()).clamp(3.0, 15.0) as usize;
    let mut table = Table::default().right("").right("").left("").left("");
    for named in &tones.lines {
        let line = &named.line;
        // A base fits itself.
        let is_base = ["f1", "f2"].contains(&&*line.label);
        let misfit = named.misfit_hz.filter(|_| !is_base);
        table.row([
            format!("{:.decimals$} Hz", line.frequency),
            amount(line.amplitude),
            line.label.clone(),
            misfit.map_or_else(String::new, |hz| format!("misses by {hz:+.decimals$} Hz")),
        ]);
    }
    let lines = match tones.lines[..] {
        [] => "  none\n".to_owned(),
        _ => table.text(),
    };
    format!(
        "{NAME}lines{NAME:#} of the spectrum (bin {} Hz, {} of the power in the floor)\n{lines}",
        significant(tones.bin_hz, DIGITS),
        percent(tones.floor_share)
    )
}

fn of_states(states: &StateSpace, samples: usize) -> String {
    let choice = &states.choice;
    let reason = match choice.reason {
        LagReason::FirstMinimum => "first minimum",
        LagReason::FirstDecay => "first decay",
        LagReason::Largest => "largest",
    };
    let false_share = choice.neighbours.share.get(choice.dimension - 1);
    format!(
        "{NAME}state space{NAME:#} of the newest {samples} samples\n  \
         tau = {} ({} {}): {reason} of the mutual information\n  \
         m = {}: {} of the neighbours are false{}\n",
        duration(states.lag_s),
        choice.lag,
        if choice.lag == 1 { "sample" } else { "samples" },
        choice.dimension,
        false_share.map_or("no known share".to_owned(), |share| percent(*share)),
        if choice.unfolded {
            ""
        } else {
            ", so it is not unfolded"
        },
    )
}

fn of_recurrence(recurrence: &RecurrenceReport, amount: &dyn Fn(f64) -> String) -> String {
    let (threshold, value) = match recurrence.rule.threshold {
        Threshold::Rate(rate) => ("rate", rate),
        Threshold::Distance(distance) => ("distance", distance),
        Threshold::Spread(spread) => ("spread", spread),
        Threshold::Neighbours(count) => ("neighbours", count as f64),
    };
    let epsilon = recurrence
        .epsilon
        .map(|epsilon| format!(": epsilon = {}", amount(epsilon)));
    let period = recurrence.period_s.map(|period| {
        let frequency = significant(1.0 / period, DIGITS);
        format!("  diagonals {} apart: {frequency} Hz\n", duration(period))
    });
    format!(
        "{NAME}recurrence{NAME:#} of {} states ({threshold} {}{})\n{}{}",
        recurrence.states,
        significant(value, DIGITS),
        epsilon.unwrap_or_default(),
        of_measures(&recurrence.measures),
        period.unwrap_or_default()
    )
}

fn of_measures(measures: &Measures) -> String {
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

fn of_section(section: &Section, amount: &dyn Fn(f64) -> String) -> String {
    let shape = match section.shape {
        SectionShape::TooFew => "too few to tell the shape",
        SectionShape::Points(1) => "one point",
        SectionShape::Points(count) => &format!("{count} points"),
        SectionShape::Loop => "a loop",
        SectionShape::Arc => "an arc",
        SectionShape::Cloud => "a cloud",
    };
    let apart = section.mean_return_s;
    let apart = apart.map(|seconds| format!(", {} apart on average", duration(seconds)));
    format!(
        "{NAME}section{NAME:#} y(t + tau) = {}, rising: {} passages, {shape}{}\n",
        amount(section.level),
        section.passages.len(),
        apart.unwrap_or_default()
    )
}

fn of_chaos(report: &SignalReport) -> String {
    let method = |name: &str, divergence: &Divergence| match divergence.region {
        Some(region) => format!(
            "  {name:<10}  {} +- {} 1/s, from {} to {}\n",
            significant(region.slope, DIGITS),
            significant(region.error, DIGITS),
            duration(region.from),
            duration(region.to)
        ),
        None => format!("  {name:<10}  none: neighbours do not part exponentially\n"),
    };
    let test = &report.zero_one;
    let taken = match test.stride {
        1 => "every sample".to_owned(),
        stride => format!("one sample in {stride}"),
    };
    format!(
        "{NAME}largest exponent{NAME:#}\n{}{}\n\
         {NAME}0-1 test{NAME:#} K = {:.3} (0 regular, 1 chaos or noise) from {taken}\n",
        method("Rosenstein", &report.rosenstein),
        method("Kantz", &report.kantz),
        test.k
    )
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
