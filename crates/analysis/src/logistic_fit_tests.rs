//! Fit of a model to examples.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::{Coefficient, Model};

/// Penalty on half the square of each weight, per example.
const PENALTY: f64 = 4e-4;

/// Newton steps: the likelihood is concave, and the last steps change nothing.
const STEPS: usize = 60;

/// A training example: its inputs and whether each class is right.
pub struct Example {
    pub inputs: Vec<f64>,
    pub right: Vec<bool>,
}

impl Model {
    /// The model of maximum likelihood of examples, by Newton's method. An example for which several classes are
    /// right has the share of each in its probability as its target.
    pub fn fitted(names: &[&str], examples: &[Example]) -> Self {
        let (inputs, classes) = (names.len(), examples[0].right.len());
        let count = examples.len() as f64;
        let coefficient = |(i, name): (usize, &&str)| {
            let column = || examples.iter().map(|example| example.inputs[i]);
            let mean = column().sum::<f64>() / count;
            let variance = column().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
            Coefficient {
                input: (*name).to_owned(),
                mean,
                deviation: variance.sqrt(),
                weights: vec![0.0; classes],
            }
        };
        let mut model = Self {
            constants: vec![0.0; classes],
            coefficients: names.iter().enumerate().map(coefficient).collect(),
        };
        let row = |example: &Example| {
            let standard = model.coefficients.iter().zip(&example.inputs);
            let standard = standard.map(|(c, x)| (x - c.mean) / c.deviation);
            DVector::from_iterator(inputs + 1, std::iter::once(1.0).chain(standard))
        };
        let rows: Vec<DVector<f64>> = examples.iter().map(row).collect();
        for _ in 0..STEPS {
            model.step(examples, &rows);
        }
        model
    }

    /// One step of Newton's method. The unknowns are, class by class, the constant and the weights.
    fn step(&mut self, examples: &[Example], rows: &[DVector<f64>]) {
        let (width, classes) = (self.coefficients.len() + 1, self.constants.len());
        let size = width * classes;
        let zero = || (DVector::zeros(size), DMatrix::zeros(size, size));
        let parts = examples.par_iter().zip(rows).fold(
            zero,
            |(mut gradient, mut curvature): (DVector<f64>, DMatrix<f64>), (example, row)| {
                let p = self.probabilities(&example.inputs);
                let right: f64 = p
                    .iter()
                    .zip(&example.right)
                    .filter(|x| *x.1)
                    .map(|x| x.0)
                    .sum();
                for (c, is_right) in example.right.iter().enumerate() {
                    let target = if *is_right { p[c] / right } else { 0.0 };
                    let mut own = gradient.rows_mut(c * width, width);
                    own.axpy(target - p[c], row, 1.0);
                }
                let square = row * row.transpose();
                for (r, c) in (0..classes).flat_map(|r| (0..classes).map(move |c| (r, c))) {
                    let factor = p[r] * (f64::from(u8::from(r == c)) - p[c]);
                    let mut block = curvature.view_mut((r * width, c * width), (width, width));
                    block += factor * &square;
                }
                (gradient, curvature)
            },
        );
        let (mut gradient, mut curvature) = parts.reduce(zero, |a, b| (a.0 + b.0, a.1 + b.1));
        let penalty = PENALTY * examples.len() as f64;
        for at in 0..size {
            curvature[(at, at)] += penalty;
            if at % width > 0 {
                gradient[at] -= penalty * self.coefficients[at % width - 1].weights[at / width];
            }
        }
        let step = curvature.cholesky().unwrap().solve(&gradient);
        for (at, step) in step.iter().enumerate() {
            match at % width {
                0 => self.constants[at / width] += step,
                i => self.coefficients[i - 1].weights[at / width] += step,
            }
        }
    }

    /// Writes the model to the file that `SQUEAKSCOPE_MODEL` names, or asserts that it is `used`, that of the program.
    pub fn write_or_compare(&self, used: &Self) {
        if let Ok(file) = std::env::var("SQUEAKSCOPE_MODEL") {
            let text = serde_json::to_string_pretty(self).unwrap() + "\n";
            std::fs::write(file, text).unwrap();
            return;
        }
        for (fitted, used) in self.coefficients.iter().zip(&used.coefficients) {
            assert_eq!(fitted.input, used.input);
            for (fitted, used) in fitted.weights.iter().zip(&used.weights) {
                assert!((fitted - used).abs() < 0.01, "{fitted} {used}");
            }
        }
    }
}
