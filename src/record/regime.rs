//! The kind of motion: its history in colours by how sure it is, and the evidence in words.

use rerun::{Scalars, SeriesPoints};

use super::{
    error::RecordError,
    paths,
    samples::name_series,
    stream::{self, RecordingStream},
    style, text,
};
use crate::{
    analysis::{Regime, Verdict},
    pipeline::message::Header,
};

/// All kinds, in the order of the key.
const KINDS: [Regime; 7] = [
    Regime::Silent,
    Regime::Transient,
    Regime::Periodic,
    Regime::QuasiPeriodic,
    Regime::Chaotic,
    Regime::Noise,
    Regime::Unsure,
];

/// Names kinds and series.
pub fn name_kinds(rec: &RecordingStream) -> Result<(), RecordError> {
    let colors = KINDS.map(style::regime);
    let names = KINDS.map(|kind| kind.to_string());
    name_series(rec, paths::REGIME_CONFIDENCE, names, colors)?;
    // A verdict between others has no line.
    let points = SeriesPoints::new()
        .with_colors(colors)
        .with_marker_sizes([3.0; KINDS.len()]);
    rec.log_static(paths::REGIME_CONFIDENCE, &points)
}

/// Draws the verdict on a window of `window` (s) that ends at `time` (s).
pub fn draw_verdict(
    rec: &RecordingStream,
    header: &Header,
    time: f64,
    window: f64,
    verdict: &Verdict,
) -> Result<(), RecordError> {
    let confidence = |kind| match kind == verdict.regime {
        true => verdict.confidence,
        false => f64::NAN,
    };
    let confidences = Scalars::new(KINDS.map(confidence));
    stream::log_at(rec, paths::REGIME_CONFIDENCE, time, &confidences)?;
    let text = document(header, time, window, verdict);
    let document = text::document(text);
    stream::log_at(rec, paths::REGIME_VERDICT, time, &document)
}

/// The verdict as a heading with a line on how sure it is.
fn heading(verdict: &Verdict) -> String {
    let name = verdict.regime.to_string();
    let mut letters = name.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    let name: String = first.chain(letters).collect();
    format!("## {name}\n\n**{:.0} % sure**", 1e2 * verdict.confidence)
}

/// The verdict with the strongest evidence in words.
pub fn words(verdict: &Verdict) -> String {
    let strongest = verdict.evidence.iter().take(3);
    let words: String = strongest.map(|e| format!("* {}\n", e.words)).collect();
    format!("{}\n\n{words}", heading(verdict))
}

/// The verdict with its evidence, strongest first.
fn document(header: &Header, time: f64, window: f64, verdict: &Verdict) -> String {
    let rows: String = verdict
        .evidence
        .iter()
        .map(|evidence| {
            format!(
                "| {:.2} | {} | {} |\n",
                evidence.weight,
                evidence.what,
                evidence.kinds(),
            )
        })
        .collect();
    let words: String = verdict
        .evidence
        .iter()
        .map(|evidence| format!("* {}\n", evidence.words))
        .collect();
    format!(
        "{heading}, from the {window} before {now}.\n\n\
         | weight | evidence | speaks for |\n|---|---|---|\n{rows}\n{words}",
        heading = heading(verdict),
        window = style::Quantity::Time.words(window),
        now = style::moment(header, time),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{analysis::Evidence, record::tests::demo};

    #[test]
    fn a_verdict_reads_well() {
        let verdict = Verdict {
            regime: Regime::QuasiPeriodic,
            confidence: 0.874,
            evidence: vec![Evidence::new(
                "0-1 test",
                0.0213,
                &[Regime::Periodic, Regime::QuasiPeriodic],
                0.5,
                "K = 0.02: regular.".to_owned(),
            )],
        };
        let text = document(&demo::header(0.3), 0.12, 0.04, &verdict);
        assert!(
            text.starts_with("## Quasi-periodic\n\n**87 % sure**, from the 40 ms before 120 ms.")
        );
        assert!(text.contains("| 0.50 | 0-1 test | periodic or quasi-periodic |\n"));
        assert!(text.ends_with("* K = 0.02: regular.\n"));
    }
}
