//! What the paper leaves open, as a space to search.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::scene::{Parameter, Scene, SceneError};

/// A number that the paper leaves open.
struct Open {
    /// Its path in a scene.
    path: &'static str,
    low: f64,
    high: f64,
    /// How it is spread between them.
    spread: Spread,
}

#[derive(Clone, Copy, PartialEq)]
enum Spread {
    /// Evenly.
    Even,
    /// Evenly, and its ends are the same.
    Round,
    /// Its logarithm evenly.
    Logarithm,
}

/// The numbers that the paper leaves open: the direction of the tilt against that of the rotation,
/// the contact's stiffness and radius, the slope of the friction law (Fig. 3 cannot be as printed),
/// and the size of the initial kick.
const NUMBERS: [Open; 5] = [
    Open {
        path: "load.azimuth_deg",
        low: -180.0,
        high: 180.0,
        spread: Spread::Round,
    },
    Open {
        path: "contact.stiffness_factor",
        low: 0.5,
        high: 20.0,
        spread: Spread::Logarithm,
    },
    Open {
        path: "contact.radius_factor",
        low: 0.9,
        high: 1.25,
        spread: Spread::Even,
    },
    Open {
        path: "friction.stribeck_slope_s_per_m",
        low: 7.0,
        high: 25.0,
        spread: Spread::Even,
    },
    Open {
        path: "start.kick_mm_per_s",
        low: 1e-3,
        high: 10.0,
        spread: Spread::Logarithm,
    },
];

/// The choices that it leaves open, each between two words.
const CHOICES: [(&str, [&str; 2]); 3] = [
    ("contact.stiffness", ["uniform", "pre-stress"]),
    ("body.beam_reaches", ["sphere", "centre"]),
    ("contact.quadrature", ["rings", "gauss"]),
];

/// Seeds of the kick's direction are below this.
const SEEDS: u64 = 1000;

/// A set of all that is open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// The numbers in the order of the space, each as its place between its ends, 0 to 1.
    places: Vec<f64>,
    /// The choices, each the first or the second word.
    choices: Vec<bool>,
    /// Seed of the kick.
    seed: u64,
    /// Whether each tilt goes on from the one before, or is kicked anew.
    pub continued: bool,
}

impl Candidate {
    /// Anywhere; `number` says which of all random sets of a `seed`.
    pub fn anywhere(seed: u64, number: u64) -> Self {
        let mut rng = stream(seed, number);
        Self {
            places: NUMBERS
                .iter()
                .map(|_| short(rng.random_range(0.0..1.0)))
                .collect(),
            choices: CHOICES
                .iter()
                .map(|_| rng.random_range(0.0..1.0) < 0.5)
                .collect(),
            seed: rng.random_range(0..SEEDS),
            continued: rng.random_range(0.0..1.0) < 0.5,
        }
    }

    /// Near another one: its numbers displaced by `width` of their range, and now and then another
    /// choice.
    pub fn near(&self, width: f64, seed: u64, number: u64) -> Self {
        const CHANGES: f64 = 0.15;
        let mut rng = stream(seed, number);
        let places = self.places.iter().zip(&NUMBERS).map(|(place, open)| {
            let normal: f64 = StandardNormal.sample(&mut rng);
            let moved = place + width * normal;
            match open.spread {
                Spread::Round => short(moved.rem_euclid(1.0)),
                // Back from the wall.
                _ => short((1.0 - (1.0 - moved.abs()).abs()).clamp(0.0, 1.0)),
            }
        });
        let places = places.collect();
        let mut changed = || rng.random_range(0.0..1.0) < CHANGES;
        Self {
            places,
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

    /// The numbers with their paths, in the units of a scene file.
    pub fn numbers(&self) -> Vec<(&'static str, f64)> {
        let numbers = NUMBERS.iter().zip(&self.places).map(|(open, place)| {
            let value = match open.spread {
                Spread::Even | Spread::Round => open.low + place * (open.high - open.low),
                Spread::Logarithm => open.low * (open.high / open.low).powf(*place),
            };
            // Four digits are enough for anybody, and can be written down.
            (open.path, format!("{value:.3e}").parse().unwrap_or(value))
        });
        let seed = ("start.seed", self.seed as f64);
        numbers.chain([seed]).collect()
    }

    /// The choices with their paths.
    pub fn words(&self) -> Vec<(&'static str, &'static str)> {
        let choices = CHOICES.iter().zip(&self.choices);
        choices
            .map(|((path, words), second)| (*path, words[usize::from(*second)]))
            .collect()
    }

    /// A scene with this set.
    ///
    /// # Errors
    /// When the values do not fit together.
    pub fn scene(&self, base: &Scene) -> Result<Scene, SceneError> {
        let numbers = self.numbers().into_iter();
        let numbers = numbers.map(|(path, value)| Ok((Parameter::named(path)?, value)));
        let numbers = numbers.collect::<Result<Vec<_>, SceneError>>()?;
        base.with_values(&numbers)?.with_words(&self.words())
    }
}

/// The nearest decimal of nine places: what is written and read again is the same number.
pub(super) fn short(value: f64) -> f64 {
    (1e9 * value).round() / 1e9
}

/// Random numbers of their own for each set.
fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn candidates_are_valid_scenes_and_repeatable() {
        let base = Scene::load("periodic-2deg").unwrap();
        for number in 0..60 {
            let any = Candidate::anywhere(3, number);
            assert_eq!(any, Candidate::anywhere(3, number));
            let scene = any.scene(&base).unwrap();
            let contact = &scene.joint().unwrap().spec.contact;
            assert!((0.5..=20.0).contains(&contact.stiffness_factor));
            let near = any.near(0.3, 3, 1000 + number);
            near.scene(&base).unwrap();
            assert!(
                near.places.iter().all(|place| (0.0..=1.0).contains(place)),
                "{near:?}"
            );
            assert_ne!(any, near);
        }
        assert_ne!(Candidate::anywhere(3, 1), Candidate::anywhere(3, 2));
        assert_ne!(Candidate::anywhere(3, 1), Candidate::anywhere(4, 1));
    }

    #[test]
    fn near_is_near() {
        let any = Candidate::anywhere(1, 1);
        let mut moved = Vec::new();
        for number in 0..200 {
            let near = any.near(0.01, 1, number);
            let pairs = any.places.iter().zip(&near.places).skip(1);
            moved.extend(pairs.map(|(a, b)| (a - b).abs()));
        }
        let mean = moved.iter().sum::<f64>() / moved.len() as f64;
        // The mean of the absolute value of a normal variable is sqrt(2 / pi) deviations.
        assert!((0.006..0.01).contains(&mean), "{mean}");
    }
}
