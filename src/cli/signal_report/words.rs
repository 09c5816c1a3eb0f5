//! The report on a signal as words for the terminal.

use std::fmt::Write as _;

use anstyle::Style;

use super::AnalyseReport;
use crate::cli::report::Report;
use crate::escape;

const NAME: Style = Style::new().bold();
const FAINT: Style = Style::new().dimmed();

impl Report for AnalyseReport {
    fn text(&self) -> String {
        let mut text = String::new();
        self.signal_text(&mut text);
        self.verdict_text(&mut text);
        self.spectrum_text(&mut text);
        self.states_text(&mut text);
        self.chaos_text(&mut text);
        if !self.files.is_empty() {
            text.push('\n');
        }
        for file in &self.files {
            let megabytes = file.bytes as f64 / 1e6;
            let _ = writeln!(text, "  {} ({megabytes:.1} MB)", escape::path(&file.path));
        }
        text
    }
}

/// The paragraphs of the text. Writing to a string cannot fail.
impl AnalyseReport {
    fn signal_text(&self, text: &mut String) {
        let facts = &self.signal;
        let _ = writeln!(
            text,
            "{NAME}{}{NAME:#} {FAINT}{}{FAINT:#}",
            escape::line(&facts.name),
            escape::path(&self.file)
        );
        let _ = writeln!(
            text,
            "  {} samples at {} Hz: {} from {:.6} s on",
            facts.samples,
            facts.rate_hz,
            time(facts.duration_s),
            facts.start_s
        );
        let _ = writeln!(
            text,
            "  from {} to {}, deviation {} about {}",
            self.amount(facts.smallest),
            self.amount(facts.largest),
            self.amount(facts.deviation),
            self.amount(facts.mean),
        );
    }

    /// A number with the signal's unit.
    fn amount(&self, value: f64) -> String {
        let text = format!("{} {}", figures(value), escape::line(&self.signal.unit));
        text.trim_end().to_owned()
    }

    fn verdict_text(&self, text: &mut String) {
        let verdict = &self.verdict;
        let _ = writeln!(
            text,
            "\n{NAME}{}{NAME:#}, {:.0} % sure",
            verdict.regime,
            100.0 * verdict.confidence
        );
        for evidence in &verdict.evidence {
            let bar = "#".repeat((5.0 * evidence.weight).round() as usize);
            let _ = writeln!(text, "  {bar:<5} {}", evidence.words);
        }
    }

    fn spectrum_text(&self, text: &mut String) {
        let spectrum = &self.spectrum;
        let _ = writeln!(
            text,
            "\n{NAME}lines{NAME:#} of the spectrum (bin {} Hz, {:.1} % of the power in the floor)",
            figures(spectrum.bin_hz),
            100.0 * spectrum.floor_share
        );
        if spectrum.lines.is_empty() {
            text.push_str("  none\n");
        }
        // A line is placed well below a bin, however slow the signal.
        let decimals = (3.0 - spectrum.bin_hz.log10().floor()).clamp(3.0, 15.0) as usize;
        for line in &spectrum.lines {
            let misfit = line.misfit_hz.filter(|_| !is_base(&line.label));
            let misfit =
                misfit.map_or_else(String::new, |hz| format!("misses by {hz:+.decimals$} Hz"));
            let row = format!(
                "  {:>12.decimals$} Hz  {:>14}  {:<12} {misfit}",
                line.frequency_hz,
                self.amount(line.amplitude),
                line.label
            );
            let _ = writeln!(text, "{}", row.trim_end());
        }
    }

    fn states_text(&self, text: &mut String) {
        let embedding = &self.embedding;
        let _ = writeln!(
            text,
            "\n{NAME}state space{NAME:#} of the newest {} samples",
            self.nonlinear_samples
        );
        let _ = writeln!(
            text,
            "  tau = {} ({} {}): {} of the mutual information",
            time(embedding.lag_s),
            embedding.lag_samples,
            if embedding.lag_samples == 1 {
                "sample"
            } else {
                "samples"
            },
            embedding.lag_reason
        );
        let false_share = embedding.false_neighbours.get(embedding.dimension - 1);
        let _ = writeln!(
            text,
            "  m = {}: {} of the neighbours are false{}",
            embedding.dimension,
            false_share.map_or("no known share".to_owned(), |share| percent(*share)),
            if embedding.unfolded {
                ""
            } else {
                ", so it is not unfolded"
            }
        );
        let recurrence = &self.recurrence;
        let whole = &recurrence.whole;
        let _ = writeln!(
            text,
            "\n{NAME}recurrence{NAME:#} of {} states ({} {}{})",
            recurrence.states,
            recurrence.threshold,
            figures(recurrence.threshold_value),
            recurrence.epsilon.map_or_else(String::new, |epsilon| {
                format!(": epsilon = {}", self.amount(epsilon))
            })
        );
        let _ = writeln!(
            text,
            "  RR {}   DET {}   LAM {}   ENTR {}   TREND {}",
            percent(whole.recurrence_rate),
            or_none(whole.determinism, percent),
            or_none(whole.laminarity, percent),
            or_none(whole.entropy_nats, |nats| format!("{nats:.2}")),
            or_none(whole.trend_per_1000_states, figures)
        );
        let _ = writeln!(
            text,
            "  L {}   Lmax {}   TT {}   T1 {}   T2 {}",
            or_none(whole.mean_diagonal_s, time),
            time(whole.longest_diagonal_s),
            or_none(whole.trapping_time_s, time),
            or_none(whole.recurrence_time_1_s, time),
            or_none(whole.recurrence_time_2_s, time)
        );
        if let Some(period) = recurrence.period_s {
            let _ = writeln!(
                text,
                "  diagonals {} apart: {} Hz",
                time(period),
                figures(1.0 / period)
            );
        }
        let section = &self.section;
        let shape = match (section.points, section.shape) {
            (Some(1), _) => "one point".to_owned(),
            (Some(points), _) => format!("{points} points"),
            (None, "too few") => "too few to tell the shape".to_owned(),
            (None, shape) => format!("a {shape}").replace("a arc", "an arc"),
        };
        let _ = writeln!(
            text,
            "\n{NAME}section{NAME:#} y(t + tau) = {}, rising: {} passages, {shape}{}",
            self.amount(section.level),
            section.passages.len(),
            section
                .mean_return_s
                .map_or_else(String::new, |s| format!(", {} apart on average", time(s)))
        );
    }

    fn chaos_text(&self, text: &mut String) {
        let _ = writeln!(text, "\n{NAME}largest exponent{NAME:#}");
        for (method, parting) in [("Rosenstein", &self.rosenstein), ("Kantz", &self.kantz)] {
            let _ = match (parting.exponent_per_s, parting.error_per_s) {
                (Some(exponent), Some(error)) => writeln!(
                    text,
                    "  {method:<10}  {} +- {} 1/s, from {} to {}",
                    figures(exponent),
                    figures(error),
                    or_none(parting.from_s, time),
                    or_none(parting.to_s, time)
                ),
                _ => writeln!(
                    text,
                    "  {method:<10}  none: neighbours do not part exponentially"
                ),
            };
        }
        let test = &self.zero_one;
        let _ = writeln!(
            text,
            "\n{NAME}0-1 test{NAME:#} K = {:.3} (0 regular, 1 chaos or noise) from {}",
            test.k,
            match test.stride_samples {
                1 => "every sample".to_owned(),
                stride => format!("one sample in {stride}"),
            }
        );
    }
}

/// Whether a label is that of a base, which fits itself.
fn is_base(label: &str) -> bool {
    ["f1", "f2"].contains(&label)
}

/// A number with four significant digits.
fn figures(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let magnitude = value.abs().log10().floor() as i32;
    match magnitude {
        -4..=5 => {
            let decimals = (3 - magnitude).max(0) as usize;
            format!("{value:.decimals$}")
        }
        _ => format!("{value:.3e}"),
    }
}

/// A time with a unit that suits it.
fn time(seconds: f64) -> String {
    let (scale, unit) = match seconds.abs() {
        s if s == 0.0 || s >= 1.0 => (1.0, "s"),
        s if s >= 1e-3 => (1e3, "ms"),
        _ => (1e6, "us"),
    };
    format!("{} {unit}", figures(seconds * scale))
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn or_none(value: Option<f64>, show: impl Fn(f64) -> String) -> String {
    value.map_or("none".to_owned(), show)
}
