//! What a run says of its exponents and of its two copies.

use serde::Serialize;

use crate::dynamics::{LyapunovSpectrum, Motion, Sign};
use crate::pipeline::message::{Exponents, Parting, PartingLine};

/// More exponents than these are read in the recording or the JSON file.
const EXPONENTS_SHOWN: usize = 4;

/// Lyapunov exponents at the end of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExponentsReport {
    /// What the motion comes to, by the names of `squeakscope lyapunov`: `cycle`, `chaos`, ...
    pub attractor: &'static str,
    /// The same in words, such as `limit cycle`.
    pub words: String,
    /// The exponents, the largest first.
    pub exponents: Vec<ExponentReport>,
    /// How many there are in all.
    pub dimension: usize,
    /// Time over which growth was averaged, s.
    pub averaged_s: f64,
    /// Nearer to zero than this none can be told from zero in that time, 1/s.
    pub resolution_per_s: f64,
    /// The lowest natural frequency, rad/s.
    pub omega_1_rad_per_s: f64,
    /// Kaplan-Yorke dimension of the attractor, where enough exponents are known.
    pub kaplan_yorke: Option<DimensionReport>,
}

/// One exponent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExponentReport {
    /// Its number, from 1.
    pub number: usize,
    /// Its value, 1/s; not finite for a direction that collapses.
    pub value_per_s: f64,
    /// Half the width of its 95 % interval, 1/s; not finite where it cannot be told.
    pub half_width_per_s: f64,
    /// Its value over `omega_1`, the lowest natural frequency: for the time `tau = omega_1 t`.
    pub value_over_omega_1: f64,
    /// Half the width of its interval over `omega_1`.
    pub half_width_over_omega_1: f64,
    /// `positive`, `zero`, `negative` or `doubtful`.
    pub sign: &'static str,
}

/// The exponents of a spectrum.
pub(super) fn exponents(spectrum: &LyapunovSpectrum, omega_1: f64) -> Vec<ExponentReport> {
    let exponents = spectrum.exponents.iter().enumerate();
    exponents
        .map(|(k, e)| ExponentReport {
            number: k + 1,
            value_per_s: e.value,
            half_width_per_s: e.half_width,
            value_over_omega_1: e.value / omega_1,
            half_width_over_omega_1: e.half_width / omega_1,
            sign: match spectrum.sign(k) {
                Sign::Positive => "positive",
                Sign::Zero => "zero",
                Sign::Negative => "negative",
                Sign::Doubtful => "doubtful",
            },
        })
        .collect()
}

/// The dimension of an attractor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DimensionReport {
    /// Its value.
    pub value: f64,
    /// Half the width of its 95 % interval; not finite where it cannot be told.
    pub half_width: f64,
}

impl DimensionReport {
    /// The Kaplan-Yorke dimension; `None` where it is not known, or where nothing moves: an equilibrium is
    /// a point, whatever its neighbours do.
    pub(super) fn of(spectrum: &LyapunovSpectrum, motion: Motion) -> Option<Self> {
        let told = !spectrum.exponents.is_empty() && motion != Motion::Still;
        let known = spectrum.kaplan_yorke().filter(|_| told);
        known.map(|dimension| Self {
            value: dimension.value,
            half_width: dimension.half_width,
        })
    }
}

impl ExponentsReport {
    /// What there is to say of exponents.
    pub fn new(exponents: &Exponents) -> Self {
        let spectrum = &exponents.spectrum;
        Self {
            attractor: exponents.attractor().name(),
            words: exponents.attractor().to_string(),
            exponents: self::exponents(spectrum, exponents.omega_1),
            dimension: spectrum.dimension,
            averaged_s: spectrum.time,
            resolution_per_s: spectrum.resolution,
            omega_1_rad_per_s: exponents.omega_1,
            kaplan_yorke: DimensionReport::of(spectrum, exponents.motion),
        }
    }

    /// A line for the terminal.
    pub fn text(&self) -> String {
        let shown = self.exponents.iter().take(EXPONENTS_SHOWN);
        let shown: Vec<String> = shown
            .map(|exponent| match exponent.half_width_per_s {
                half if half.is_finite() => format!("{:.1} +- {half:.1}", exponent.value_per_s),
                _ => format!("{:.1}", exponent.value_per_s),
            })
            .collect();
        let more = match self.exponents.len() > EXPONENTS_SHOWN {
            true => ", ...",
            false => "",
        };
        let dimension = match &self.kaplan_yorke {
            Some(dimension) => format!(", dimension {:.2}", dimension.value),
            None => String::new(),
        };
        format!(
            "  exponents {}{more} 1/s over {:.0} ms: {}{dimension}\n",
            shown.join(", "),
            1e3 * self.averaged_s,
            self.words
        )
    }
}

/// Two copies from almost the same state, at the end of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ButterflyReport {
    /// When the second copy started, s.
    pub start_s: f64,
    /// Distance of the two over the size of the motion.
    pub distance: f64,
    /// Slope of the distance's logarithm, from above the errors of the steps until it is saturated, 1/s;
    /// `null` where there is none.
    pub rate_per_s: Option<f64>,
    /// Half the width of its 95 % interval, 1/s.
    pub rate_half_width_per_s: Option<f64>,
    /// When the distance had become as large as the motion, s.
    pub saturated_s: Option<f64>,
    #[serde(skip)]
    line: Option<PartingLine>,
}

impl ButterflyReport {
    /// What there is to say of two copies.
    pub fn new(parting: &Parting) -> Self {
        Self {
            start_s: parting.start,
            distance: parting.distance,
            rate_per_s: parting.line.map(|line| line.rate),
            rate_half_width_per_s: parting.line.map(|line| line.half_width),
            line: parting.line,
            saturated_s: parting.saturated,
        }
    }

    /// A line for the terminal.
    pub fn text(&self) -> String {
        let rate = match &self.line {
            Some(line) => {
                let (rate, error) = (line.rate, line.half_width);
                if line.grows() {
                    format!(", growing by {rate:.1} +- {error:.1} 1/s")
                } else if line.shrinks() {
                    format!(", shrinking by {:.1} +- {error:.1} 1/s", -rate)
                } else {
                    format!(", neither growing nor shrinking ({rate:.1} +- {error:.1} 1/s)")
                }
            }
            None => String::new(),
        };
        let end = match self.saturated_s {
            Some(time) => format!("until it saturated at {:.0} ms", 1e3 * time),
            None => "not saturated".to_owned(),
        };
        format!(
            "  two copies from {:.0} ms on: distance {:.1e} of the motion{rate}, {end}\n",
            1e3 * self.start_s,
            self.distance
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::Exponent;

    #[test]
    fn exponents_are_told_in_a_line_and_in_numbers() {
        let exponent = |value, half_width| Exponent { value, half_width };
        let report = ExponentsReport::new(&Exponents {
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
        });
        assert!(
            report
                .text()
                .starts_with("  exponents 71.2 +- 9.0, 0.5 1/s over 200 ms: ")
        );
        let json = serde_json::to_value(&report).expect("JSON");
        assert_eq!(json["exponents"][0]["value_over_omega_1"], 71.25e-4);
        assert_eq!(json["exponents"][0]["sign"], "positive");
        assert_eq!(json["attractor"], "chaos");
        assert!(json["exponents"][1]["half_width_per_s"].is_null());
    }

    #[test]
    fn copies_are_told_in_a_line() {
        let mut parting = Parting {
            time: 0.2,
            start: 0.05,
            distance: 2e-3,
            line: None,
            saturated: None,
        };
        assert_eq!(
            ButterflyReport::new(&parting).text(),
            "  two copies from 50 ms on: distance 2.0e-3 of the motion, not saturated\n"
        );
        parting.line = Some(PartingLine {
            rate: 70.0,
            half_width: 5.0,
            since: 0.06,
            intercept: 0.0,
        });
        parting.saturated = Some(0.18);
        let text = ButterflyReport::new(&parting).text();
        assert!(text.ends_with("growing by 70.0 +- 5.0 1/s, until it saturated at 180 ms\n"));
        parting.line = parting.line.map(|line| PartingLine { rate: 3.0, ..line });
        let text = ButterflyReport::new(&parting).text();
        assert!(
            text.contains("neither growing nor shrinking (3.0 +- 5.0 1/s)"),
            "{text}"
        );
    }
}
