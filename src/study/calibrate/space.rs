//! The parameters that the paper does not state, as a search space.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::scene::{Parameter, Scene, SceneError};

/// A numeric parameter that the paper does not state.
struct OpenParameter {
    /// Path of the parameter in a scene.
    path: &'static str,
    low: f64,
    high: f64,
    /// Distribution within the range.
    scale: Scale,
}

#[derive(Clone, Copy, PartialEq)]
enum Scale {
    /// Uniform.
    Linear,
    /// Uniform and periodic.
    Periodic,
    /// Log-uniform.
    Logarithmic,
}

/// The numeric parameters: the azimuth of the tilt relative to the rotation, the stiffness and the radius
/// of the contact, the slope of the friction law (Fig. 3 is inconsistent as printed), and the size of the
/// initial kick.
const NUMBERS: [OpenParameter; 5] = [
    OpenParameter {
        path: "load.azimuth_deg",
        low: -180.0,
        high: 180.0,
        scale: Scale::Periodic,
    },
    OpenParameter {
        path: "contact.stiffness_factor",
        low: 0.5,
        high: 20.0,
        scale: Scale::Logarithmic,
    },
    OpenParameter {
        path: "contact.radius_factor",
        low: 0.9,
        high: 1.25,
        scale: Scale::Linear,
    },
    OpenParameter {
        path: "friction.stribeck_slope_s_per_m",
        low: 7.0,
        high: 25.0,
        scale: Scale::Linear,
    },
    OpenParameter {
        path: "start.kick_mm_per_s",
        low: 1e-3,
        high: 10.0,
        scale: Scale::Logarithmic,
    },
];

/// The choices that the paper does not state, each between two values.
const CHOICES: [(&str, [&str; 2]); 3] = [
    ("contact.stiffness_distribution", ["uniform", "pre-stress"]),
    ("body.beam_length_to", ["sphere", "centre"]),
    ("contact.quadrature", ["rings", "gauss"]),
];

/// Upper bound of the seeds of the kick's direction.
const SEEDS: u64 = 1000;

/// A candidate: one value for every parameter of the space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Positions of the numeric parameters within their ranges, 0 to 1, in the order of the space.
    positions: Vec<f64>,
    /// Choices: `false` for the first value, `true` for the second.
    choices: Vec<bool>,
    /// Seed of the kick.
    seed: u64,
    /// Whether each tilt continues from the final state of the one before instead of a new kick.
    pub continued: bool,
}

impl Candidate {
    /// A random candidate; `number` selects one of the random streams of a `seed`.
    pub fn random(seed: u64, number: u64) -> Self {
        let mut rng = stream(seed, number);
        Self {
            positions: NUMBERS
                .iter()
                .map(|_| rounded(rng.random_range(0.0..1.0)))
                .collect(),
            choices: CHOICES
                .iter()
                .map(|_| rng.random_range(0.0..1.0) < 0.5)
                .collect(),
            seed: rng.random_range(0..SEEDS),
            continued: rng.random_range(0.0..1.0) < 0.5,
        }
    }

    /// A mutation: normally distributed changes of standard deviation `width`, relative to the ranges, and
    /// occasionally a changed choice.
    pub fn mutated(&self, width: f64, seed: u64, number: u64) -> Self {
        const CHOICE_CHANGE_RATE: f64 = 0.15;
        let mut rng = stream(seed, number);
        let positions = self
            .positions
            .iter()
            .zip(&NUMBERS)
            .map(|(position, parameter)| {
                let normal: f64 = StandardNormal.sample(&mut rng);
                let shifted = position + width * normal;
                match parameter.scale {
                    Scale::Periodic => rounded(shifted.rem_euclid(1.0)),
                    // Reflected at the ends of the range.
                    _ => rounded((1.0 - (1.0 - shifted.abs()).abs()).clamp(0.0, 1.0)),
                }
            });
        let positions = positions.collect();
        let mut changed = || rng.random_range(0.0..1.0) < CHOICE_CHANGE_RATE;
        Self {
            positions,
            choices: self
                .choices
                .iter()
                .map(|choice| *choice != changed())
                .collect(),
            continued: self.continued != changed(),
            seed: if changed() {
                rng.random_range(0..SEEDS)
            } else {
                self.seed
            },
        }
    }

    /// Paths and values of the numeric parameters, in the units of the scene file.
    pub fn numbers(&self) -> Vec<(&'static str, f64)> {
        let numbers = NUMBERS
            .iter()
            .zip(&self.positions)
            .map(|(parameter, position)| {
                let value = match parameter.scale {
                    Scale::Linear | Scale::Periodic => {
                        parameter.low + position * (parameter.high - parameter.low)
                    }
                    Scale::Logarithmic => {
                        parameter.low * (parameter.high / parameter.low).powf(*position)
                    }
                };
                // Four significant digits suffice, and the text is exact.
                (
                    parameter.path,
                    format!("{value:.3e}").parse().unwrap_or(value),
                )
            });
        let seed = ("start.seed", self.seed as f64);
        numbers.chain([seed]).collect()
    }

    /// Paths and values of the choices.
    pub fn words(&self) -> Vec<(&'static str, &'static str)> {
        let choices = CHOICES.iter().zip(&self.choices);
        choices
            .map(|((path, words), second)| (*path, words[usize::from(*second)]))
            .collect()
    }

    /// The base scene with this parameter set.
    ///
    /// # Errors
    /// If the values are not consistent with each other.
    pub fn scene(&self, base: &Scene) -> Result<Scene, SceneError> {
        let numbers = self.numbers().into_iter();
        let numbers = numbers.map(|(path, value)| Ok((Parameter::named(path)?, value)));
        let numbers = numbers.collect::<Result<Vec<_>, SceneError>>()?;
        base.with_values(&numbers)?.with_words(&self.words())
    }
}

/// The value rounded to nine decimals, so that writing and reading it is exact.
pub(super) fn rounded(value: f64) -> f64 {
    (1e9 * value).round() / 1e9
}

/// An independent random stream for each candidate.
fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn candidates_are_valid_scenes_and_reproducible() {
        let base = Scene::load("periodic-2deg").unwrap();
        for number in 0..60 {
            let any = Candidate::random(3, number);
            assert_eq!(any, Candidate::random(3, number));
            let scene = any.scene(&base).unwrap();
            let contact = &scene.joint().unwrap().spec.contact;
            assert!((0.5..=20.0).contains(&contact.stiffness_factor));
            let mutated = any.mutated(0.3, 3, 1000 + number);
            mutated.scene(&base).unwrap();
            assert!(
                mutated
                    .positions
                    .iter()
                    .all(|position| (0.0..=1.0).contains(position)),
                "{mutated:?}"
            );
            assert_ne!(any, mutated);
        }
        assert_ne!(Candidate::random(3, 1), Candidate::random(3, 2));
        assert_ne!(Candidate::random(3, 1), Candidate::random(4, 1));
    }

    #[test]
    fn mutations_have_the_requested_width() {
        let any = Candidate::random(1, 1);
        let mut shifted = Vec::new();
        for number in 0..200 {
            let mutated = any.mutated(0.01, 1, number);
            let pairs = any.positions.iter().zip(&mutated.positions).skip(1);
            shifted.extend(pairs.map(|(a, b)| (a - b).abs()));
        }
        let mean = shifted.iter().sum::<f64>() / shifted.len() as f64;
        // The mean absolute value of a normal variable is sqrt(2 / pi) standard deviations.
        assert!((0.006..0.01).contains(&mean), "{mean}");
    }
}
