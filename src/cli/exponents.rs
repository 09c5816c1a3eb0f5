//! What exponents come to, for people and for programs; and how two copies of a motion have parted.

use serde::Serialize;

use crate::dynamics::{Attractor, Exponent, LyapunovSpectrum, Motion, Sign};
use crate::pipeline::message::{Exponents, Parting};

/// More exponents than these are read in the recording or the JSON file.
const EXPONENTS_SHOWN: usize = 4;

/// What JSON says of a spectrum beside its own numbers.
#[derive(Debug, Serialize)]
pub(super) struct Reading {
    /// What the motion comes to: `rest`, `in-step`, `cycle`, `torus`, `chaos`, `hyper-chaos`,
    /// `stable-equilibrium`, `unstable-equilibrium`, `equilibrium` or `undecided`.
    pub attractor: &'static str,
    /// The same in words.
    pub words: String,
    /// What is known of the sign of each exponent.
    pub signs: Vec<Sign>,
    /// The exponents over the lowest natural frequency: for the time `tau = omega_1 t`.
    pub exponents_over_omega_1: Vec<Exponent>,
    /// The Kaplan-Yorke dimension; `null` where it is not known, or where nothing moves: an equilibrium is a
    /// point, whatever its neighbours do.
    pub kaplan_yorke: Option<Exponent>,
}

impl Reading {
    /// Of a spectrum and what it comes to; `omega_1` in rad/s.
    pub fn new(
        spectrum: &LyapunovSpectrum,
        motion: Motion,
        attractor: Attractor,
        omega_1: f64,
    ) -> Self {
        let exponents = &spectrum.exponents;
        let scaled = exponents.iter().map(|exponent| Exponent {
            value: exponent.value / omega_1,
            half_width: exponent.half_width / omega_1,
        });
        let is_point = exponents.is_empty() || motion == Motion::Still;
        Self {
            attractor: attractor.name(),
            words: attractor.to_string(),
            signs: (0..exponents.len()).map(|k| spectrum.sign(k)).collect(),
            exponents_over_omega_1: scaled.collect(),
            kaplan_yorke: spectrum.kaplan_yorke().filter(|_| !is_point),
        }
    }
}

/// The exponents at the end of a run, as JSON has them.
#[derive(Debug, Serialize)]
pub(super) struct RunExponents<'a> {
    #[serde(flatten)]
    exponents: &'a Exponents,
    #[serde(flatten)]
    reading: Reading,
}

impl<'a> RunExponents<'a> {
    pub fn new(exponents: &'a Exponents) -> Self {
        let Exponents {
            spectrum, motion, ..
        } = exponents;
        let attractor = exponents.attractor();
        Self {
            exponents,
            reading: Reading::new(spectrum, *motion, attractor, exponents.omega_1),
        }
    }

    /// A line for the terminal.
    pub fn text(&self) -> String {
        let spectrum = &self.exponents.spectrum;
        let shown = spectrum.exponents.iter().take(EXPONENTS_SHOWN);
        let shown: Vec<String> = shown
            .map(|exponent| match exponent.half_width {
                half if half.is_finite() => format!("{:.1} +- {half:.1}", exponent.value),
                _ => format!("{:.1}", exponent.value),
            })
            .collect();
        let more = match spectrum.exponents.len() > EXPONENTS_SHOWN {
            true => ", ...",
            false => "",
        };
        let dimension = match &self.reading.kaplan_yorke {
            Some(dimension) => format!(", dimension {:.2}", dimension.value),
            None => String::new(),
        };
        format!(
            "  exponents {}{more} 1/s over {:.0} ms: {}{dimension}\n",
            shown.join(", "),
            1e3 * spectrum.time,
            self.reading.words
        )
    }
}

/// How two copies have parted, in a line for the terminal.
pub(super) fn parting(parting: &Parting) -> String {
    let rate = parting.line.map(|line| {
        let (rate, error) = (line.rate, line.half_width);
        if line.grows() {
            format!(", growing by {rate:.1} +- {error:.1} 1/s")
        } else if line.shrinks() {
            format!(", shrinking by {:.1} +- {error:.1} 1/s", -rate)
        } else {
            format!(", neither growing nor shrinking ({rate:.1} +- {error:.1} 1/s)")
        }
    });
    let end = match parting.saturated {
        Some(time) => format!("until it saturated at {:.0} ms", 1e3 * time),
        None => "not saturated".to_owned(),
    };
    format!(
        "  two copies from {:.0} ms on: distance {:.1e} of the motion{}, {end}\n",
        1e3 * parting.start,
        parting.distance,
        rate.unwrap_or_default()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::message::PartingLine;

    #[test]
    fn exponents_are_told_in_a_line_and_in_numbers() {
        let exponent = |value, half_width| Exponent { value, half_width };
        let exponents = Exponents {
            time: 0.25,
            spectrum: LyapunovSpectrum {
                exponents: vec![exponent(71.25, 9.0), exponent(0.5, f64::INFINITY)],
                time: 0.2,
                dimension: 22,
                resolution: 5.0,
                kaplan_yorke: None,
            },
            motion: Motion::Free,
            omega_1: 1e4,
        };
        let found = RunExponents::new(&exponents);
        assert!(
            found
                .text()
                .starts_with("  exponents 71.2 +- 9.0, 0.5 1/s over 200 ms: ")
        );
        let json = serde_json::to_value(&found).expect("JSON");
        assert_eq!(json["exponents_over_omega_1"][0]["value"], 71.25e-4);
        assert_eq!(json["signs"][0], "positive");
        assert_eq!(json["attractor"], "chaos");
        assert_eq!(json["averaged_s"], 0.2);
        assert!(json["exponents_per_s"][1]["half_width"].is_null());
    }

    #[test]
    fn copies_are_told_in_a_line() {
        let mut copies = Parting {
            time: 0.2,
            start: 0.05,
            distance: 2e-3,
            line: None,
            saturated: None,
        };
        assert_eq!(
            parting(&copies),
            "  two copies from 50 ms on: distance 2.0e-3 of the motion, not saturated\n"
        );
        copies.line = Some(PartingLine {
            rate: 70.0,
            half_width: 5.0,
            since: 0.06,
            intercept: 0.0,
        });
        copies.saturated = Some(0.18);
        let text = parting(&copies);
        assert!(text.ends_with("growing by 70.0 +- 5.0 1/s, until it saturated at 180 ms\n"));
        copies.line = copies.line.map(|line| PartingLine { rate: 3.0, ..line });
        let text = parting(&copies);
        assert!(
            text.contains("neither growing nor shrinking (3.0 +- 5.0 1/s)"),
            "{text}"
        );
    }
}
