//! The multinomial logistic model of the classification.
//!
//! The logarithm of the odds of two classes is a linear function of the inputs. The classes are the regimes and *not
//! enough evidence*, which has training signals of its own (short records, speech, music, creak). The coefficients in
//! `model.json` are fitted by maximum likelihood to signals of known regime, with a small penalty on their squares; the
//! ignored test `the_model_is_fitted` repeats the fit. A signal for which several regimes are right counts with the
//! sum of their probabilities.

use std::sync::LazyLock;

use serde::Deserialize;

use super::Regime;

/// The inputs, and the criterion to which each belongs.
pub(super) const INPUTS: [(&str, &str); 18] = [
    ("beside_one", "one tone"),
    ("beside_two", "two tones"),
    ("floor", "broadband floor"),
    ("floor_excess", "broadband floor"),
    ("coloured_excess", "broadband floor"),
    ("floor_over_error", "broadband floor"),
    ("loop", "Poincare section"),
    ("points", "Poincare section"),
    ("repetition", "repetition"),
    ("long_error", "predictability"),
    ("error_over_linear", "predictability"),
    ("divergence", "divergence"),
    ("drift", "divergence"),
    ("zero_one", "0-1 test"),
    ("level", "steadiness"),
    ("change", "steadiness"),
    ("period_drift", "steadiness"),
    ("periods", "record length"),
];

/// The classes. The last one stands for too little evidence.
pub(super) const CLASSES: [Regime; 6] = [
    Regime::Transient,
    Regime::Periodic,
    Regime::QuasiPeriodic,
    Regime::Chaotic,
    Regime::Noise,
    Regime::Undetermined,
];

/// Values of all inputs.
pub(super) type Inputs = [f64; INPUTS.len()];

/// Coefficient of an input.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
pub(super) struct Coefficient {
    /// Name of the input.
    pub input: String,
    /// Mean and standard deviation of the input in the training signals.
    pub mean: f64,
    pub deviation: f64,
    /// Weight of the standardised input for each class.
    pub weights: [f64; CLASSES.len()],
}

/// The fitted model.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
pub(super) struct Model {
    /// Constants of the classes.
    pub constants: [f64; CLASSES.len()],
    /// In the order of [`INPUTS`].
    pub coefficients: Vec<Coefficient>,
}

/// The model of `model.json`.
pub(super) static MODEL: LazyLock<Model> = LazyLock::new(|| {
    serde_json::from_str(include_str!("model.json")).expect("the fitted model is a valid file")
});

impl Model {
    /// Contribution of each input to the logarithm of the probability of each class, up to a constant.
    pub fn contributions(&self, inputs: &Inputs) -> [[f64; CLASSES.len()]; INPUTS.len()] {
        std::array::from_fn(|i| {
            let coefficient = &self.coefficients[i];
            let standard = (inputs[i] - coefficient.mean) / coefficient.deviation;
            coefficient.weights.map(|weight| weight * standard)
        })
    }

    /// Probabilities of the classes.
    pub fn probabilities(&self, inputs: &Inputs) -> [f64; CLASSES.len()] {
        let mut logarithms = self.constants;
        for terms in self.contributions(inputs) {
            for (sum, term) in logarithms.iter_mut().zip(terms) {
                *sum += term;
            }
        }
        let largest = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let odds = logarithms.map(|logarithm| (logarithm - largest).exp());
        let total: f64 = odds.iter().sum();
        odds.map(|odds| odds / total)
    }
}
