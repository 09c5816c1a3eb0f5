//! Text for the reproduction of the paper's figures: captions, and the page with the table of claims.

use std::collections::BTreeMap;

use minijinja::context;
use minijinja::value::Value;

use super::or_error_text;
use super::template::fill;
use crate::report::Table;
use crate::study::paper::{Finding, Score, Verdict};
use crate::study::response::SettledResponse;
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
        let Finding {
            statement,
            expected,
            measured,
            ..
        } = finding;
        format!("{statement}: published {expected}, computed {measured}")
    };
    let motion = motion.map(|(tilt, response)| motion_values(tilt, response));
    let values = context! {
        number,
        differing => differing.map(words).collect::<Vec<_>>(),
        ..motion.unwrap_or_default()
    };
    or_error_text(fill("paper/caption", values))
}

/// Template variables of the caption of a response.
fn motion_values(tilt: f64, response: &SettledResponse) -> Value {
    let lines = response.lines.iter().take(3);
    let lines = lines.map(|line| format!("{:.2}", 1e-3 * line.frequency));
    let spectrum = response.exponents.as_ref();
    let exponent = spectrum.and_then(|spectrum| spectrum.exponents.first());
    let exponent = exponent.map(|exponent| {
        let places = if exponent.half_width < 2.0 { 2 } else { 0 };
        format!(
            "{:.places$} ± {:.places$}",
            exponent.value, exponent.half_width
        )
    });
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
    let place = &finding.place;
    let mut figures = place.split([',', ';']).filter_map(|part| {
        let digits = part.trim().trim_start_matches("Fig. ");
        let end = digits.find(|c: char| !c.is_ascii_digit());
        digits[..end.unwrap_or(digits.len())].parse::<u8>().ok()
    });
    let differs = matches!(finding.verdict, Verdict::Partly { .. } | Verdict::NotMet);
    let is_there = place.starts_with("Fig.") && figures.any(|figure| figure == number);
    is_there && differs && finding.measured != finding.expected
}

/// The page of figures, given by names and captions, with the table of claims. `scene` and `start` are
/// printed in its heading.
pub fn page(
    (scene, start): (&str, &str),
    figures: &[(&str, &str)],
    ending: &str,
    (score, findings): (&Score, &[Finding]),
) -> String {
    let table = Table::of(findings)
        .left("reference", |it| it.place.clone())
        .left("claim", |it| it.statement.clone())
        .left("published", |it| it.expected.clone())
        .left("computed", |it| it.measured.clone())
        .left("verdict", |it| verdict(it))
        .left("short average", |it| short_average(it))
        .right("weight", |it| it.weight.to_string());
    let figures = figures.iter();
    let values = context! {
        scene => escape::code(scene),
        start,
        version => VERSION,
        figures => figures.map(|&(name, caption)| context! { name, caption }).collect::<Vec<_>>(),
        ending,
        score => score_text(score),
        claims => table.markdown(),
    };
    or_error_text(fill("paper/page", values))
}

/// The strict score, the numbers of claims by verdict, and the score with partial credit.
pub fn score_text(score: &Score) -> String {
    or_error_text(fill(
        "paper/score",
        context! {
            strict => format!("{:.0}", 100.0 * score.strict_score),
            partial => format!("{:.0}", 100.0 * score.partial_score),
            met => score.met,
            partly => score.partly,
            not_met => score.not_met,
            not_comparable => score.not_comparable,
        },
    ))
}

/// The description of a scene that is compared with the paper, from the findings and their score: lines of at most 88
/// characters. `start` says how each tilt was started.
pub fn description(start: &str, (score, findings): (&Score, &[Finding])) -> String {
    let claims = findings.iter().map(|finding| {
        let verdict = match finding.verdict {
            Verdict::Met => "met",
            _ => "not met",
        };
        let claim = context! {
            measured => &*finding.measured,
            expected => &*finding.expected,
            verdict,
        };
        (&*finding.id, claim)
    });
    let values = context! {
        start,
        strict => format!("{:.0}", 100.0 * score.strict_score),
        met => score.met,
        partly => score.partly,
        not_met => score.not_met,
        comparable => score.met + score.partly + score.not_met,
        claims => claims.collect::<BTreeMap<_, _>>(),
    };
    let text = or_error_text(fill("paper/scene", values));
    let paragraphs = text.trim().lines().map(|line| wrapped(line, 88));
    paragraphs.collect::<Vec<_>>().join("\n") + "\n"
}

/// A paragraph in lines of at most `width` characters, broken at spaces, but not behind a number.
fn wrapped(paragraph: &str, width: usize) -> String {
    let mut words: Vec<String> = Vec::new();
    for word in paragraph.split_whitespace() {
        match words.last_mut().filter(|last| ends_with_number(last)) {
            Some(last) => *last = format!("{last} {word}"),
            None => words.push(word.to_owned()),
        }
    }
    let mut text = String::new();
    let mut length = 0;
    for word in &words {
        let size = word.chars().count();
        if length > 0 {
            let fits = length + 1 + size <= width;
            text.push(if fits { ' ' } else { '\n' });
            length = if fits { length + 1 } else { 0 };
        }
        text += word;
        length += size;
    }
    text
}

/// Whether the last word of some words is a number.
fn ends_with_number(words: &str) -> bool {
    let last = words.rsplit(' ').next();
    last.is_some_and(|word| word.parse::<f64>().is_ok_and(f64::is_finite))
}

/// The verdict on a claim, with the deviation of its number or the share of the tilts at which it holds.
pub fn verdict(finding: &Finding) -> String {
    let name = finding.verdict.name();
    match (finding.verdict, finding.deviation) {
        (Verdict::Partly { share }, _) => format!("{name}, {:.0} %", 100.0 * share),
        (_, Some(off)) => format!("{name} ({:+.1} %)", 100.0 * off),
        (_, None) => name.to_owned(),
    }
}

/// The verdict from a short average and its value, or that it is the same.
pub fn short_average(finding: &Finding) -> String {
    match &finding.short_average {
        None => String::new(),
        Some(short) if short.verdict == finding.verdict => "same".to_owned(),
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
