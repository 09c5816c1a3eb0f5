//! The comparison with the paper as text: report, captions, the page with the table of claims, and the description of the
//! scene.

use std::collections::BTreeMap;

use minijinja::context;
use minijinja::value::{Serde, Value};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::filled;
use crate::number::with_error;
use crate::report::{Block, Report, Table, Tone};
use crate::study::paper::{Comparison, Finding, Score, Verdict};
use crate::study::response::SettledResponse;
use crate::study::sweep::Start;
use crate::{VERSION, escape};

/// The caption of a figure, with the differences from the paper. Figures 4 to 7 show a response at a tilt in
/// degrees.
pub fn caption(
    number: u8,
    motion: Option<(f64, &SettledResponse)>,
    findings: &[Finding],
) -> String {
    let differing = findings
        .iter()
        .filter(|finding| differs_from_paper(finding, number));
    let words = |finding: &Finding| {
        let (statement, found) = (&finding.claim.statement, &finding.comparison);
        let (expected, measured) = (&found.expected, &found.measured);
        format!("{statement}: published {expected}, computed {measured}")
    };
    let motion = motion.map(|(tilt, response)| motion_values(tilt, response));
    let values = context! {
        number,
        differing => differing.map(words).collect::<Vec<_>>(),
        ..motion.unwrap_or_default()
    };
    filled("paper/caption", values)
}

/// Template variables of the caption of a response.
fn motion_values(tilt: f64, response: &SettledResponse) -> Value {
    let lines = response.lines.iter().take(3);
    let lines = lines.map(|line| format!("{:.2}", 1e-3 * line.frequency));
    let spectrum = response.exponents.as_ref();
    let exponent = spectrum.and_then(|spectrum| spectrum.exponents.first());
    let exponent = exponent.map(|exponent| with_error(exponent.value, exponent.half_width));
    context! {
        tilt => tilt.to_string(),
        regime => response.regime.to_string(),
        lines => lines.collect::<Vec<_>>().join(", "),
        exponent,
        settled => response.settled,
    }
}

/// Whether a figure differs from the paper's statement about it.
fn differs_from_paper(finding: &Finding, number: u8) -> bool {
    let (place, found) = (&finding.claim.place, &finding.comparison);
    let mut figures = place.split([',', ';']).filter_map(|part| {
        let digits = part.trim().trim_start_matches("Fig. ");
        let end = digits.find(|c: char| !c.is_ascii_digit());
        digits[..end.unwrap_or(digits.len())].parse::<u8>().ok()
    });
    let differs = matches!(found.verdict, Verdict::Partly { .. } | Verdict::NotMet);
    let is_there = place.starts_with("Fig.") && figures.any(|figure| figure == number);
    is_there && differs && found.measured != found.expected
}

/// The comparison with the paper.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
pub struct PaperResult {
    /// Initial states of the sweep over the tilt.
    pub start: Start,
    /// Agreement with the paper.
    #[serde(flatten)]
    pub score: Score,
    /// Agreement with the paper of short averages: over 0.1 s that begin 0.05 s after the start, settled or not.
    pub short_average: Score,
    /// Claims in the order of the paper.
    pub claims: Vec<Finding>,
    /// Caption (Markdown) of the figure selected with `--figure`.
    pub captions: Vec<String>,
}

impl Report for PaperResult {
    fn blocks(&self, scene: &str) -> Vec<Block> {
        let mut blocks = Vec::new();
        if !self.claims.is_empty() {
            let rest = format!(" (start: {}): {}", self.start, score_text(&self.score));
            blocks.push(Block::heading(scene, rest));
            blocks.push(Block::text(format!(
                "averages over 0.1 s, 0.05 s after the start: {}",
                score_text(&self.short_average)
            )));
        }
        for finding in &self.claims {
            let (claim, found) = (&finding.claim, &finding.comparison);
            let tone = match found.verdict {
                Verdict::Met => Tone::Good,
                Verdict::NotMet => Tone::Bad,
                _ => Tone::Plain,
            };
            let (place, statement) = (&claim.place, &claim.statement);
            let (expected, measured) = (&found.expected, &found.measured);
            blocks.push(Block::text(format!("{place:<13} {statement}")));
            blocks.push(Block::Text(vec![
                format!("{:<13}   paper {expected}, simulation {measured}: ", "").into(),
                tone.cell(verdict(found)),
            ]));
            let short = finding.short_average.as_ref();
            if short.is_some_and(|short| short.verdict != found.verdict) {
                let short = short_average(finding);
                blocks.push(Block::text(format!("{:<13}   short average {short}", "")));
            }
        }
        blocks.extend(self.captions.iter().map(Block::text));
        blocks
    }
}

impl PaperResult {
    /// The page of figures, given by names and captions, with the table of claims. `scene` is printed in its heading.
    pub fn page(&self, scene: &str, figures: &[(&str, &str)], ending: &str) -> String {
        let table = Table::of(&self.claims)
            .left("reference", |it| it.claim.place.clone())
            .left("claim", |it| it.claim.statement.clone())
            .left("published", |it| it.comparison.expected.clone())
            .left("computed", |it| it.comparison.measured.clone())
            .left("verdict", |it| verdict(&it.comparison))
            .left("short average", |it| short_average(it))
            .right("weight", |it| it.claim.weight.to_string());
        let figures = figures.iter();
        let values = context! {
            scene => escape::code(scene),
            start => self.start.to_string(),
            version => VERSION,
            figures => figures.map(|&(name, caption)| context! { name, caption }).collect::<Vec<_>>(),
            ending,
            score => score_text(&self.score),
            claims => table.markdown(),
        };
        filled("paper/page", values)
    }

    /// The description of the scene that was compared: lines of at most 88 characters.
    pub fn description(&self) -> String {
        let claims = self.claims.iter();
        let claims = claims.map(|finding| (&*finding.claim.id, &finding.comparison));
        let claims: BTreeMap<_, _> = claims.collect();
        let start = self.start.to_string();
        let values = context! { start, claims => Serde(claims), ..Value::from(Serde(&self.score)) };
        let text = filled("paper/scene", values);
        let paragraphs = text.trim().lines().map(|line| wrapped(line, 88));
        paragraphs.collect::<Vec<_>>().join("\n") + "\n"
    }
}

/// The strict score, the numbers of claims by verdict, and the score with partial credit.
fn score_text(score: &Score) -> String {
    filled("paper/score", Value::from(Serde(score)))
}

/// A paragraph in lines of at most `width` characters, broken at spaces, but not behind a number.
fn wrapped(paragraph: &str, width: usize) -> String {
    const NO_BREAK: char = '\u{a0}';
    let mut text = String::new();
    let mut space = ' ';
    for word in paragraph.split_whitespace() {
        text.push(space);
        text += word;
        let is_number = word.parse::<f64>().is_ok_and(f64::is_finite);
        space = if is_number { NO_BREAK } else { ' ' };
    }
    let mut lines: Vec<String> = Vec::new();
    for words in text.split(' ').skip(1) {
        let length = words.chars().count() + 1;
        match lines.last_mut() {
            Some(line) if line.chars().count() + length <= width => *line += &format!(" {words}"),
            _ => lines.push(words.to_owned()),
        }
    }
    lines.join("\n").replace(NO_BREAK, " ")
}

/// The verdict on a claim, with the deviation of its number or the share of the tilts at which it holds.
fn verdict(found: &Comparison) -> String {
    let name = found.verdict.name();
    match (found.verdict, found.deviation) {
        (Verdict::Partly { share }, _) => format!("{name}, {:.0} %", 100.0 * share),
        (_, Some(off)) => format!("{name} ({:+.1} %)", 100.0 * off),
        (_, None) => name.to_owned(),
    }
}

/// The verdict from a short average and its value, or that it is the same.
fn short_average(finding: &Finding) -> String {
    match &finding.short_average {
        None => String::new(),
        Some(short) if short.verdict == finding.comparison.verdict => "same".to_owned(),
        Some(short) => format!("{}: {}", short.verdict.name(), short.measured),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_paragraph_is_broken_at_spaces() {
        assert_eq!(wrapped("one two  three", 7), "one two\nthree");
        assert_eq!(wrapped("unbreakable a", 4), "unbreakable\na");
        assert_eq!(wrapped("", 4), "");
        assert_eq!(wrapped("at 4.1 kHz, or", 6), "at\n4.1 kHz,\nor");
    }
}
