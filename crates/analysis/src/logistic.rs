//! Multinomial logistic models.
//!
//! The logarithm of the odds of two classes is a linear function of inputs that are standardised by their mean and
//! standard deviation over the training examples. The coefficients are fitted by maximum likelihood with a small penalty on
//! their squares, and kept in a JSON file beside the code that measures the inputs. An example for which
//! several classes are right counts with the sum of their probabilities.

use serde::Deserialize;

/// Coefficient of an input.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
pub(super) struct Coefficient {
    /// Name of the input.
    pub input: String,
    /// Mean and standard deviation of the input in the training examples.
    pub mean: f64,
    pub deviation: f64,
    /// Weight of the standardised input for each class.
    pub weights: Vec<f64>,
}

/// A fitted model.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
pub(super) struct Model {
    /// Constants of the classes.
    pub constants: Vec<f64>,
    /// Coefficients of the inputs.
    pub coefficients: Vec<Coefficient>,
}

impl Model {
    /// The model of a file of the program.
    pub fn of_program(json: &str) -> Self {
        serde_json::from_str(json).expect("a fitted model of the program is a valid file")
    }

    /// Contribution of each input to the logarithm of the probability of each class, up to a constant.
    pub fn contributions<'a>(&'a self, inputs: &'a [f64]) -> impl Iterator<Item = Vec<f64>> + 'a {
        let terms = self.coefficients.iter().zip(inputs);
        terms.map(|(coefficient, input)| {
            let standard = (input - coefficient.mean) / coefficient.deviation;
            let weights = coefficient.weights.iter();
            weights.map(|weight| weight * standard).collect()
        })
    }

    /// Probabilities of the classes.
    pub fn probabilities(&self, inputs: &[f64]) -> Vec<f64> {
        let mut logarithms = self.constants.clone();
        for terms in self.contributions(inputs) {
            for (sum, term) in logarithms.iter_mut().zip(terms) {
                *sum += term;
            }
        }
        let largest = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let odds = logarithms.iter().map(|x| (x - largest).exp());
        let total: f64 = odds.clone().sum();
        odds.map(|odds| odds / total).collect()
    }
}

#[cfg(test)]
#[path = "logistic_fit_tests.rs"]
pub(super) mod fit;
