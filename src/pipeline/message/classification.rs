//! What Lyapunov exponents say, and those of a run.

use schemars::JsonSchema;
use serde::Serialize;

use super::{Exponents, Regime};
use crate::dynamics::{Attractor, Exponent, LyapunovSpectrum, Motion, Sign};
use crate::number::{brief, quantity, short};
use crate::report::{Block, Measured, Report, Table, Tone};
use crate::text::earlier_motion;

/// Quantities derived from a Lyapunov spectrum.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Classification {
    /// Attractor: `fixed-point`, `phase-locked`, `cycle`, `torus`, `chaos`, `hyperchaos`,
    /// `stable-equilibrium`, `unstable-equilibrium`, `equilibrium` or `undecided`.
    #[schemars(with = "String")]
    pub attractor: Attractor,
    /// The attractor in words, with the reason and the motion before.
    pub description: String,
    /// Sign of each exponent.
    pub signs: Vec<Sign>,
    /// Exponents divided by the lowest natural frequency, for the dimensionless time `tau = omega_1 t`; absent for a
    /// system without modes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub exponents_over_omega_1: Vec<Exponent>,
}

impl Classification {
    /// Classifies a spectrum; `omega_1` in rad/s, infinite for a system without modes. `earlier` is the motion before,
    /// if there was another one.
    pub fn new(
        spectrum: &LyapunovSpectrum,
        motion: Motion,
        omega_1: f64,
        earlier: Option<String>,
    ) -> Self {
        let exponents = &spectrum.exponents;
        let attractor = if exponents.is_empty() {
            Attractor::Undecided
        } else {
            spectrum.attractor_of(motion)
        };
        let earlier = earlier.map_or(String::new(), |earlier| format!("{earlier}, then "));
        let scalable = exponents.iter().filter(|_| omega_1.is_finite());
        let scaled = scalable.map(|exponent| Exponent {
            value: exponent.value / omega_1,
            half_width: exponent.half_width / omega_1,
        });
        Self {
            attractor,
            description: earlier + &description(spectrum, motion, attractor),
            signs: (0..exponents.len()).map(|k| spectrum.sign(k)).collect(),
            exponents_over_omega_1: scaled.collect(),
        }
    }

    /// The exponents with their signs, one per row.
    pub fn table(&self, exponents: &[Exponent]) -> Block {
        let parts = exponents.iter().map(|it| Measured::from(it).parts());
        Table::of(parts.zip(&self.signs).enumerate())
            .right("", |(k, _)| (k + 1).to_string())
            .right("exponent, 1/s", |(_, (parts, _))| parts[0].clone())
            .right("95 % ±", |(_, (parts, _))| parts[1].clone())
            .right("/ omega_1", |(k, _)| {
                let scaled = self.exponents_over_omega_1.get(*k);
                scaled.map(|scaled| format!("{:.3e}", scaled.value))
            })
            .left("sign", |(_, (_, sign))| {
                let tone = match sign {
                    Sign::Positive => Tone::Bad,
                    Sign::Undetermined => Tone::Doubtful,
                    Sign::Zero | Sign::Negative => Tone::Plain,
                };
                tone.cell(sign)
            })
            .into()
    }
}

/// The regime of a motion on an attractor; `None` for an equilibrium or a fixed point, and if the attractor is undecided.
pub fn regime_on(attractor: Attractor) -> Option<Regime> {
    match attractor {
        Attractor::Cycle | Attractor::PhaseLocked => Some(Regime::Periodic),
        Attractor::Torus(_) => Some(Regime::QuasiPeriodic),
        Attractor::Chaos | Attractor::Hyperchaos(_) => Some(Regime::Chaotic),
        _ => None,
    }
}

/// The attractor, and the reason for the classification.
fn description(spectrum: &LyapunovSpectrum, motion: Motion, attractor: Attractor) -> String {
    if spectrum.exponents.is_empty() {
        return "undecided: the averaging has not started".to_owned();
    }
    let zeros = spectrum.count(Sign::Zero);
    let zero = match zeros {
        1 => "one exponent is zero".to_owned(),
        zeros => format!("{zeros} exponents are zero"),
    };
    let others = if spectrum.dimension > zeros {
        ", the others are negative"
    } else {
        ""
    };
    let reason = match attractor {
        Attractor::StableEquilibrium => {
            "the state is constant, and all exponents are negative".to_owned()
        }
        Attractor::UnstableEquilibrium => {
            "the state is constant, but small perturbations grow".to_owned()
        }
        Attractor::Equilibrium => {
            "the state is constant, and no exponent is significantly positive".to_owned()
        }
        Attractor::FixedPoint | Attractor::PhaseLocked => "all exponents are negative".to_owned(),
        Attractor::Torus(_) if motion == Motion::Driven => {
            format!("one frequency is that of the drive; {zero}{others}")
        }
        Attractor::Cycle | Attractor::Torus(_) => format!("{zero}{others}"),
        Attractor::Chaos => "one exponent is positive".to_owned(),
        Attractor::Hyperchaos(count) => format!("{count} exponents are positive"),
        Attractor::Undecided => {
            "the sign of a decisive exponent is uncertain, or too few exponents are computed"
                .to_owned()
        }
    };
    format!("{attractor}: {reason}")
}

/// The exponents at the end of a run, with their classification.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RunExponents<'a> {
    /// The exponents.
    #[serde(flatten)]
    pub found: &'a Exponents,
    /// What they say.
    #[serde(flatten)]
    pub classification: Classification,
}

impl<'a> RunExponents<'a> {
    /// Classifies the exponents of a run.
    pub fn new(found: &'a Exponents) -> Self {
        let earlier = earlier_motion(&found.segments, found.chaotic_transient);
        let (spectrum, motion) = (&found.spectrum, found.motion);
        let classification = Classification::new(spectrum, motion, found.omega_1, earlier);
        Self {
            found,
            classification,
        }
    }
}

/// Number of exponents of a run that are printed. The recording and JSON have all of them.
const RUN_EXPONENTS: usize = 4;

impl Report for RunExponents<'_> {
    fn blocks(&self, _name: &str) -> Vec<Block> {
        let spectrum = &self.found.spectrum;
        let dimension = match &spectrum.kaplan_yorke {
            Some(dimension) => Tone::Strong.cell(Measured::from(dimension)),
            None => "not defined by these exponents".into(),
        };
        let attractor = self.classification.attractor;
        let mut blocks = vec![
            Block::heading("Lyapunov exponents", format!(": {attractor}")),
            Block::text(&*self.classification.description),
            Block::text(format!(
                "{} of {} exponents, averaged over {} up to {}.",
                spectrum.exponents.len(),
                spectrum.dimension,
                brief(spectrum.time, "s"),
                brief(self.found.time, "s"),
            )),
            self.classification.table(&spectrum.exponents),
            Block::Text(vec!["Kaplan-Yorke dimension: ".into(), dimension]),
            Block::text(format!(
                "± is the 95 % interval. Exponents within ± {} 1/s cannot be distinguished from zero in this averaging \
                 time. omega_1 = {:.0} rad/s.",
                short(spectrum.resolution),
                self.found.omega_1
            )),
        ];
        let largest = spectrum.exponents.first();
        if let Some(largest) = largest.filter(|_| spectrum.sign(0) == Sign::Positive) {
            blocks.push(Block::text(format!(
                "An uncertainty of the initial state grows e-fold every {}.",
                quantity(1.0 / largest.value, 2, "s")
            )));
        }
        blocks
    }
}

impl RunExponents<'_> {
    /// The exponents at the end of a run in one line.
    pub fn line(&self) -> String {
        let spectrum = &self.found.spectrum;
        let shown = listed(&spectrum.exponents, RUN_EXPONENTS);
        let more = if spectrum.exponents.len() > RUN_EXPONENTS {
            ", ..."
        } else {
            ""
        };
        let dimension = spectrum.kaplan_yorke.as_ref();
        let dimension = dimension.map_or(String::new(), |dimension| {
            format!("; Kaplan-Yorke dimension {}", Measured::from(dimension))
        });
        format!(
            "Lyapunov exponents {shown}{more} 1/s, averaged over {:.0} ms; {}{dimension}",
            1e3 * spectrum.time,
            self.classification.description
        )
    }
}

/// The first of some exponents as text.
pub(crate) fn listed(exponents: &[Exponent], count: usize) -> String {
    let exponents = exponents.iter().take(count);
    let exponents = exponents.map(|exponent| Measured::from(exponent).to_string());
    exponents.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert!(result.line().starts_with(
            "Lyapunov exponents 71.2 ± 9.0, 0.5 (error unknown) 1/s, averaged over 200 ms; "
        ));
        let json = serde_json::to_value(&result).expect("JSON");
        assert_eq!(json["exponents_over_omega_1"][0]["value"], 71.25e-4);
        assert_eq!(json["signs"][0], "positive");
        assert_eq!(json["attractor"], "chaos");
        assert_eq!(json["description"], "chaos: one exponent is positive");
        assert_eq!(json["averaged_s"], 0.2);
        assert!(json["exponents_per_s"][1]["half_width"].is_null());
    }
}
