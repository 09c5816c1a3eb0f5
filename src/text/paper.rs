//! Words for the counterparts of the paper's figures: captions, and the page with the table of claims.

use minijinja::context;
use minijinja::value::Value;

use super::or_fault;
use super::template::fill;
use crate::study::paper::{Finding, Holds};
use crate::study::response::Response;
use crate::table::Table;
use crate::{VERSION, escape};

/// The caption of a figure, with what the paper says of it and is not so here. Fig. 4 to 7 are of a response at
/// a tilt, degrees.
pub fn caption(number: u8, motion: Option<(f64, &Response)>, findings: &[Finding]) -> String {
    let missed = findings.iter().filter(|finding| is_missed(finding, number));
    let words = |finding: &Finding| {
        let Finding {
            published, ours, ..
        } = finding;
        format!("{}: published {published}, here {ours}", finding.claim.says)
    };
    let motion = motion.map(|(tilt, response)| of_motion(tilt, response));
    let values = context! {
        number,
        missed => missed.map(words).collect::<Vec<_>>(),
        ..motion.unwrap_or_default()
    };
    or_fault(fill("paper/caption", values))
}

/// The names of the caption of a motion.
fn of_motion(tilt: f64, response: &Response) -> Value {
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

/// Whether a figure shows something else than the paper says of it.
fn is_missed(finding: &Finding, number: u8) -> bool {
    let place = &finding.claim.place;
    let mut figures = place.split([',', ';']).filter_map(|part| {
        let digits = part.trim().trim_start_matches("Fig. ");
        let end = digits.find(|c: char| !c.is_ascii_digit());
        digits[..end.unwrap_or(digits.len())].parse::<u8>().ok()
    });
    let is_known = !matches!(finding.holds, Holds::Yes | Holds::Unknown);
    let is_there = place.starts_with("Fig.") && figures.any(|figure| figure == number);
    is_there && is_known && finding.ours != finding.published
}

/// The page of figures, by their names and captions, with the claims: of a scene, started in some way.
pub fn page(
    (scene, start): (&str, &str),
    figures: &[(&str, &str)],
    ending: &str,
    (score, findings): (f64, &[Finding]),
) -> String {
    let mut table = Table::default()
        .left("where")
        .left("claim")
        .left("published");
    table = table.left("here").left("holds");
    for finding in findings {
        let claim = &finding.claim;
        table.row([
            claim.place.clone(),
            claim.says.clone(),
            finding.published.clone(),
            finding.ours.clone(),
            verdict(finding),
        ]);
    }
    let figures = figures.iter();
    let values = context! {
        scene => escape::code(scene),
        start,
        version => VERSION,
        figures => figures.map(|&(name, caption)| context! { name, caption }).collect::<Vec<_>>(),
        ending,
        score => format!("{:.0}", 100.0 * score),
        claims => table.markdown(),
    };
    or_fault(fill("paper/page", values))
}

/// Whether a claim holds, with the deviation of a number, or how far it holds.
pub fn verdict(finding: &Finding) -> String {
    let name = finding.holds.name();
    match (finding.holds, finding.deviation) {
        (Holds::Partly(share), _) => format!("{name}, {:.0} %", 100.0 * share),
        (_, Some(off)) => format!("{name} ({:+.1} %)", 100.0 * off),
        (_, None) => name.to_owned(),
    }
}
