//! Lyapunov exponents and the divergence of the perturbed trajectory, for the terminal and JSON.

use crate::number::uncertain;
use crate::pipeline::message::{Exponents, TrajectoryDivergence};
use crate::study::lyapunov::Classified;
use crate::text;

/// Number of exponents in the terminal. The recording and JSON have all of them.
const MAX_EXPONENTS: usize = 4;

/// The Lyapunov exponents at the end of a run, classified.
pub(super) type RunExponents<'a> = Classified<&'a Exponents>;

impl RunExponents<'_> {
    /// One line for the terminal.
    pub fn text(&self) -> String {
        let spectrum = &self.found.spectrum;
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
        let earlier = text::earlier_motion(&self.found.segments, self.found.chaotic_transient);
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
    use crate::dynamics::{Exponent, LyapunovSpectrum, Motion};
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
        let result = Classified::run(&exponents);
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
