//! What a Lyapunov spectrum says about the motion.

use schemars::JsonSchema;
use serde::Serialize;

use super::LyapunovStudy;
use crate::dynamics::{Attractor, Exponent, LyapunovSpectrum, Sign};
use crate::pipeline::message::Exponents;

/// Quantities derived from a Lyapunov spectrum.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Classification {
    /// Attractor: `fixed-point`, `phase-locked`, `cycle`, `torus`, `chaos`, `hyperchaos`,
    /// `stable-equilibrium`, `unstable-equilibrium`, `equilibrium` or `undecided`.
    #[schemars(with = "String")]
    pub attractor: Attractor,
    /// The attractor in words.
    pub description: String,
    /// Sign of each exponent.
    pub signs: Vec<Sign>,
    /// Exponents divided by the lowest natural frequency, for the dimensionless time `tau = omega_1 t`; absent for a
    /// system without modes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub exponents_over_omega_1: Vec<Exponent>,
    /// Kaplan-Yorke dimension; `null` if it is unknown, and for an equilibrium.
    pub kaplan_yorke: Option<Exponent>,
}

impl Classification {
    /// Classifies a spectrum; `omega_1` in rad/s, infinite for a system without modes.
    pub fn new(spectrum: &LyapunovSpectrum, attractor: Attractor, omega_1: f64) -> Self {
        let exponents = &spectrum.exponents;
        let scalable = exponents.iter().filter(|_| omega_1.is_finite());
        let scaled = scalable.map(|exponent| Exponent {
            value: exponent.value / omega_1,
            half_width: exponent.half_width / omega_1,
        });
        Self {
            attractor,
            description: attractor.to_string(),
            signs: (0..exponents.len()).map(|k| spectrum.sign(k)).collect(),
            exponents_over_omega_1: scaled.collect(),
            kaplan_yorke: spectrum.kaplan_yorke,
        }
    }
}

/// Exponents with their classification.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Classified<T> {
    /// The exponents.
    #[serde(flatten)]
    pub found: T,
    /// What they say.
    #[serde(flatten)]
    pub classification: Classification,
}

impl<'a> Classified<&'a Exponents> {
    /// The exponents at the end of a run.
    pub fn run(found: &'a Exponents) -> Self {
        let (spectrum, attractor) = (&found.spectrum, found.attractor());
        let classification = Classification::new(spectrum, attractor, found.omega_1);
        Self {
            found,
            classification,
        }
    }
}

impl<'a> Classified<&'a LyapunovStudy> {
    /// The study of a system without modes.
    pub fn study(found: &'a LyapunovStudy) -> Self {
        Self {
            found,
            classification: found.classification(f64::INFINITY),
        }
    }
}
