//! The type of motion: its confidence over time, and the evidence as text.

use strum::VariantArray as _;

use crate::record::sdk::SeriesPoints;

use super::{paths, stream::RecordingStream, style, text};
use crate::analysis::regime::{Regime, Verdict};
use crate::number::significant;
use crate::pipeline::message::Header;
use crate::plot::{Color, Unit, evidence_panel};

/// Names the regimes and the series.
pub fn name_regimes(rec: &RecordingStream) {
    let colors = Regime::VARIANTS.iter().map(|kind| Color::Regime(*kind));
    let names = Regime::VARIANTS.iter().map(Regime::to_string);
    let series = names.clone().zip(colors.clone());
    rec.name(paths::REGIME_CONFIDENCE, series);
    // A value between two gaps has no line segment. The legend takes the names from the points.
    let points = SeriesPoints::new()
        .with_names(names)
        .with_colors(colors)
        .with_marker_sizes([3.0; Regime::VARIANTS.len()]);
    rec.log_static(paths::REGIME_CONFIDENCE, &points);
}

/// Draws the classification of a window of `window` (s) that ends at `time` (s).
pub fn draw_verdict(
    rec: &RecordingStream,
    header: &Header,
    (time, window): (f64, f64),
    verdict: &Verdict,
) {
    let confidence = |kind| match kind {
        Regime::Undetermined if kind == verdict.regime => 0.0,
        kind if kind == verdict.regime => verdict.confidence,
        _ => f64::NAN,
    };
    let shown = Regime::VARIANTS.iter().copied().map(confidence);
    rec.row(paths::REGIME_CONFIDENCE, time, shown);
    rec.keep("evidence", || evidence_panel(verdict));
    let text = document(header, time, window, verdict);
    let document = text::document(text);
    rec.log("regime/verdict", time, &document);
}

/// The classification as a heading, with its confidence or, without a decision, the likeliest types of motion.
fn heading(verdict: &Verdict) -> String {
    let second = match verdict.regime {
        Regime::Undetermined => verdict.summary(),
        _ => format!("Confidence {:.0} %", 1e2 * verdict.confidence),
    };
    let regime = style::capitalize(&verdict.regime.to_string());
    format!("## {regime}\n\n**{}**", style::capitalize(&second))
}

/// The classification with the strongest evidence.
pub fn markdown(verdict: &Verdict) -> String {
    let strongest: String = evidence(verdict).take(3).collect();
    let limitation = limitation(verdict);
    format!("{}\n\n{limitation}\n\n{strongest}", heading(verdict))
}

/// What the signal leaves open; may be empty.
fn limitation(verdict: &Verdict) -> String {
    let limitation = verdict.limitation;
    limitation.map_or_else(String::new, |limitation| limitation.to_string())
}

/// A line for each piece of evidence, strongest first.
fn evidence(verdict: &Verdict) -> impl Iterator<Item = String> {
    let pieces = verdict.evidence.iter().filter(|piece| piece.matters());
    pieces.map(|piece| {
        let (criterion, regime) = (style::capitalize(&piece.criterion), piece.supports);
        let (factor, text) = (significant(piece.factor(), 2), &piece.description);
        format!("* **{criterion}: {regime}** (odds times {factor}). {text}\n")
    })
}

/// The classification with all evidence, strongest first. A list wraps in a narrow view, a table does not.
fn document(header: &Header, time: f64, window: f64, verdict: &Verdict) -> String {
    let items: String = evidence(verdict).collect();
    let (heading, limitation) = (heading(verdict), limitation(verdict));
    let (window, now) = (Unit::write(window, "s"), style::format_time(header, time));
    format!("{heading}, window of {window} before {now}. {limitation}\n\n{items}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        analysis::regime::{Evidence, Limitation},
        record::tests::demo,
    };

    #[test]
    fn a_classification_is_described() {
        let verdict = Verdict {
            regime: Regime::QuasiPeriodic,
            confidence: 0.874,
            likeliest: vec![Regime::QuasiPeriodic, Regime::Periodic],
            limitation: Some(Limitation::Modulation),
            evidence: vec![Evidence {
                criterion: "0-1 test".to_owned(),
                supports: Regime::QuasiPeriodic,
                contribution: 0.7,
                description: "K = 0.02: regular.".to_owned(),
            }],
            intervals: Vec::new(),
        };
        let text = document(&demo::header(0.3), 0.12, 0.04, &verdict);
        assert!(text.starts_with(
            "## Quasi-periodic\n\n**Confidence 87 %**, window of 40 ms before 120 ms. The lines are those"
        ));
        assert!(
            text.ends_with("* **0-1 test: quasi-periodic** (odds times 2.0). K = 0.02: regular.\n")
        );
    }

    #[test]
    fn an_undetermined_classification_has_no_confidence() {
        let verdict = Verdict {
            regime: Regime::Undetermined,
            confidence: 0.48,
            likeliest: vec![Regime::QuasiPeriodic, Regime::Chaotic],
            limitation: Some(Limitation::TooShort),
            evidence: Vec::new(),
            intervals: Vec::new(),
        };
        let text = markdown(&verdict);
        assert!(
            text.contains("**Undetermined: quasi-periodic or chaotic**"),
            "{text}"
        );
        assert!(
            text.contains("The record contains too few periods or samples."),
            "{text}"
        );
        assert!(!text.contains("48"), "{text}");
    }
}
