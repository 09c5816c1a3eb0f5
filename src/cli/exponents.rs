//! Lyapunov exponents and the divergence of the perturbed trajectory, for the terminal and JSON.

use schemars::JsonSchema;
use serde::Serialize;

use crate::dynamics::{Attractor, Exponent, LyapunovSpectrum, Motion, Sign};
use crate::number::uncertain;
use crate::pipeline::message::{Exponents, TrajectoryDivergence};
use crate::text;

/// Number of exponents in the terminal. The recording and JSON have all of them.
const MAX_EXPONENTS: usize = 4;

/// Quantities derived from a Lyapunov spectrum.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Classification {
    /// Attractor: `fixed-point`, `phase-locked`, `cycle`, `torus`, `chaos`, `hyperchaos`,
    /// `stable-equilibrium`, `unstable-equilibrium`, `equilibrium` or `undecided`.
    #[schemars(with = "String")]
    pub attractor: Attractor,
    /// The attractor in words.
    pub description: String,
    /// Sign of each exponent.
    pub signs: Vec<Sign>,
    /// Exponents divided by the lowest natural frequency, for the dimensionless time `tau = omega_1 t`.
    pub exponents_over_omega_1: Vec<Exponent>,
    /// Kaplan-Yorke dimension; `null` if it is unknown, and for an equilibrium.
    pub kaplan_yorke: Option<Exponent>,
}

impl Classification {
    /// Classifies a spectrum; `omega_1` in rad/s.
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
            attractor,
            description: attractor.to_string(),
            signs: (0..exponents.len()).map(|k| spectrum.sign(k)).collect(),
            exponents_over_omega_1: scaled.collect(),
            kaplan_yorke: spectrum.kaplan_yorke().filter(|_| !is_point),
        }
    }
}

/// The Lyapunov exponents at the end of a run.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct RunExponents<'a> {
    #[serde(flatten)]
    exponents: &'a Exponents,
    #[serde(flatten)]
    classification: Classification,
}

impl<'a> RunExponents<'a> {
    pub fn new(exponents: &'a Exponents) -> Self {
        let Exponents {
            spectrum, motion, ..
        } = exponents;
        let attractor = exponents.attractor();
        Self {
            exponents,
            classification: Classification::new(spectrum, *motion, attractor, exponents.omega_1),
        }
    }

    /// One line for the terminal.
    pub fn text(&self) -> String {
        let spectrum = &self.exponents.spectrum;
        let shown = spectrum.exponents.iter().take(MAX_EXPONENTS);
        let shown: Vec<String> = shown
            .map(|exponent| match exponent.half_width {
                half if half.is_finite() => uncertain(exponent.value, half),
                _ => format!("{:.1}", exponent.value),
            })
            .collect();
        let more = match spectrum.exponents.len() > MAX_EXPONENTS {
            true => ", ...",
            false => "",
        };
        let dimension = match &self.classification.kaplan_yorke {
            Some(dimension) => format!(", Kaplan-Yorke dimension {:.2}", dimension.value),
            None => String::new(),
        };
        let earlier =
            text::earlier_motion(&self.exponents.segments, self.exponents.chaotic_transient);
        let earlier = earlier.map_or(String::new(), |earlier| format!("{earlier}, then "));
        format!(
            "  Lyapunov exponents {}{more} 1/s, averaged over {:.0} ms: {earlier}{}{dimension}\n",
            shown.join(", "),
            1e3 * spectrum.time,
            self.classification.description
        )
    }
}

/// The divergence of the perturbed trajectory, one line for the terminal.
pub(super) fn divergence_text(divergence: &TrajectoryDivergence) -> String {
    let rate = divergence.line.map(|line| {
        let rate = |sign: f64| uncertain(sign * line.rate, line.half_width) + " 1/s";
        if line.grows() {
            format!(", growing at {}", rate(1.0))
        } else if line.shrinks() {
            format!(", shrinking at {}", rate(-1.0))
        } else {
            format!(", no significant growth ({})", rate(1.0))
        }
    });
    let saturation = match divergence.saturated {
        Some(time) => format!("saturated at {:.0} ms", 1e3 * time),
        None => "not saturated".to_owned(),
    };
    format!(
        "  perturbed trajectory, started at {:.0} ms: relative distance {:.1e}{}, {saturation}\n",
        1e3 * divergence.start,
        divergence.distance,
        rate.unwrap_or_default()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::message::DivergenceFit;

    #[test]
    fn exponents_are_printed_in_a_line_and_written_as_json() {
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
            segments: Vec::new(),
            chaotic_transient: None,
        };
        let result = RunExponents::new(&exponents);
        assert!(
            result
                .text()
                .starts_with("  Lyapunov exponents 71.2 +- 9.0, 0.5 1/s, averaged over 200 ms: ")
        );
        let json = serde_json::to_value(&result).expect("JSON");
        assert_eq!(json["exponents_over_omega_1"][0]["value"], 71.25e-4);
        assert_eq!(json["signs"][0], "positive");
        assert_eq!(json["attractor"], "chaos");
        assert_eq!(json["averaged_s"], 0.2);
        assert!(json["exponents_per_s"][1]["half_width"].is_null());
    }

    #[test]
    fn divergence_is_printed_in_a_line() {
        let mut divergence = TrajectoryDivergence {
            time: 0.2,
            start: 0.05,
            distance: 2e-3,
            line: None,
            saturated: None,
        };
        assert_eq!(
            divergence_text(&divergence),
            "  perturbed trajectory, started at 50 ms: relative distance 2.0e-3, not saturated\n"
        );
        divergence.line = Some(DivergenceFit {
            rate: 70.0,
            half_width: 5.0,
            since: 0.06,
            intercept: 0.0,
        });
        divergence.saturated = Some(0.18);
        let text = divergence_text(&divergence);
        assert!(text.ends_with("growing at 70.0 +- 5.0 1/s, saturated at 180 ms\n"));
        divergence.line = divergence
            .line
            .map(|line| DivergenceFit { rate: 3.0, ..line });
        let text = divergence_text(&divergence);
        assert!(
            text.contains("no significant growth (3.0 +- 5.0 1/s)"),
            "{text}"
        );
    }
}
