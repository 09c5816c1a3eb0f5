//! The parameters that the paper does not state, as a search space.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
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
    /// Uniform and periodic.
    Periodic,
    /// Log-uniform.
    Logarithmic,
    /// Square of a uniform variable, so that small values are frequent.
    Quadratic,
}

/// The numeric parameters: the azimuth of the tilt relative to the rotation, stiffness and radius of the contact,
/// the slopes of the friction law (Fig. 3 is inconsistent as printed), and the damping of the body.
const NUMBERS: [OpenParameter; 6] = [
    OpenParameter {
        path: "load.azimuth_deg",
        low: -180.0,
        high: 180.0,
        scale: Scale::Periodic,
    },
    OpenParameter {
        path: "contact.stiffness_factor",
        low: 0.3,
        high: 300.0,
        scale: Scale::Logarithmic,
    },
    OpenParameter {
        path: "contact.radius_factor",
        low: 0.1,
        high: 1.25,
        scale: Scale::Logarithmic,
    },
    OpenParameter {
        path: "friction.stribeck_slope_s_per_m",
        low: 5.0,
        high: 40.0,
        scale: Scale::Logarithmic,
    },
    OpenParameter {
        path: "friction.creep_slope_s_per_m",
        low: 200.0,
        high: 5000.0,
        scale: Scale::Logarithmic,
    },
    OpenParameter {
        path: "damping.ratio",
        low: 0.0,
        high: 0.005,
        scale: Scale::Quadratic,
    },
];

/// The choices that the paper does not state: distribution of the stiffness, reading of the beam's length, and
/// the contact nodes: Gauss points, or few rings with one node per cell as in a finite-element mesh.
const DISTRIBUTIONS: [&str; 2] = ["uniform", "pre-stress"];
const READINGS: [&str; 2] = ["sphere", "centre"];
const PATCHES: [(&str, usize); 4] = [("gauss", 28), ("rings", 37), ("rings", 19), ("rings", 7)];

/// Numbers of the choices.
const CHOICES: [usize; 3] = [DISTRIBUTIONS.len(), READINGS.len(), PATCHES.len()];

/// Upper bound of the seeds of the kick's direction.
const SEEDS: u64 = 1000;

/// A candidate: one value for every parameter of the space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Positions of the numeric parameters within their ranges, 0 to 1, in the order of the space.
    pub(super) positions: Vec<f64>,
    /// Choices: index of the value of each.
    pub(super) choices: Vec<usize>,
    /// Seed of the direction of the kicks.
    pub(super) seed: u64,
}

/// Way of starting: the initial state at each tilt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartingWay {
    /// Standard deviation of the initial velocity, mm/s.
    pub kick_mm_per_s: f64,
    /// Whether each tilt continues from the final state of the one before instead of a new kick.
    pub continued: bool,
}

impl Candidate {
    /// A random candidate; `number` selects one of the random streams of a `seed`.
    pub fn random(seed: u64, number: u64) -> Self {
        let mut rng = stream(seed, number);
        Self {
            positions: NUMBERS.map(|_| rounded(rng.random_range(0.0..1.0))).into(),
            choices: CHOICES.map(|count| rng.random_range(0..count)).into(),
            seed: rng.random_range(0..SEEDS),
        }
    }

    /// The candidate with other positions, brought into their ranges, and another seed of the kicks.
    pub(super) fn moved(&self, positions: &[f64], seed: u64) -> Self {
        let inside = positions.iter().zip(&NUMBERS);
        let inside = inside.map(|(position, parameter)| match parameter.scale {
            Scale::Periodic => rounded(position.rem_euclid(1.0)),
            // Reflected at the ends of the range.
            _ => rounded((1.0 - (1.0 - position.rem_euclid(2.0)).abs()).clamp(0.0, 1.0)),
        });
        Self {
            positions: inside.collect(),
            choices: self.choices.clone(),
            seed: seed % SEEDS,
        }
    }

    /// Paths and values of the numeric parameters, in the units of the scene file.
    pub fn numbers(&self) -> Vec<(&'static str, f64)> {
        let numbers = NUMBERS.iter().zip(&self.positions);
        let numbers = numbers.map(|(parameter, position)| {
            let OpenParameter { low, high, .. } = *parameter;
            let value = match parameter.scale {
                Scale::Periodic => low + position * (high - low),
                Scale::Logarithmic => low * (high / low).powf(*position),
                Scale::Quadratic => low + position * position * (high - low),
            };
            // Five significant digits suffice, and the text is exact.
            (
                parameter.path,
                format!("{value:.4e}").parse().unwrap_or(value),
            )
        });
        let nodes = ("contact.nodes", PATCHES[self.choices[2]].1 as f64);
        numbers
            .chain([nodes, ("start.seed", self.seed as f64)])
            .collect()
    }

    /// Paths and values of the choices.
    pub fn words(&self) -> Vec<(&'static str, &'static str)> {
        vec![
            (
                "contact.stiffness_distribution",
                DISTRIBUTIONS[self.choices[0]],
            ),
            ("body.beam_length_to", READINGS[self.choices[1]]),
            ("contact.quadrature", PATCHES[self.choices[2]].0),
        ]
    }

    /// The base scene with this parameter set and the kick of a way of starting.
    ///
    /// # Errors
    /// If the values are not consistent with each other.
    pub fn scene(&self, base: &Scene, start: StartingWay) -> Result<Scene, SceneError> {
        let kick = ("start.kick_mm_per_s", start.kick_mm_per_s);
        let numbers = self.numbers().into_iter().chain([kick]);
        let numbers = numbers.map(|(path, value)| Ok((Parameter::named(path)?, value)));
        let numbers = numbers.collect::<Result<Vec<_>, SceneError>>()?;
        base.with_values(&numbers)?.with_words(&self.words())
    }
}

/// The parameter sets from which the search starts, besides those that it finds by screening: sets with the
/// paper's numbers of unstable modes, and sets whose tones or tori are those of the paper.
const KNOWN: &str = include_str!("../../../assets/paper/sets.toml");

#[derive(Deserialize)]
struct KnownSets {
    set: Vec<KnownSet>,
}

/// A known set, in the units of a scene file.
#[derive(Deserialize)]
struct KnownSet {
    azimuth_deg: f64,
    stiffness_factor: f64,
    radius_factor: f64,
    stribeck_slope_s_per_m: f64,
    stiffness_distribution: String,
    beam_length_to: String,
    seed: u64,
}

/// The known sets as candidates.
pub(super) fn known_sets() -> Vec<Candidate> {
    // A test parses the built-in file.
    let sets = toml::from_str::<KnownSets>(KNOWN).map_or_else(|_| Vec::new(), |sets| sets.set);
    sets.iter().map(KnownSet::candidate).collect()
}

impl KnownSet {
    fn candidate(&self) -> Candidate {
        let values = [
            self.azimuth_deg,
            self.stiffness_factor,
            self.radius_factor,
            self.stribeck_slope_s_per_m,
            1000.0,
            0.0,
        ];
        let positions = NUMBERS.iter().zip(values).map(|(parameter, value)| {
            let OpenParameter { low, high, .. } = *parameter;
            rounded(match parameter.scale {
                Scale::Periodic => (value - low) / (high - low),
                Scale::Logarithmic => (value / low).ln() / (high / low).ln(),
                Scale::Quadratic => ((value - low) / (high - low)).sqrt(),
            })
        });
        let index = |words: &[&str], word: &str| words.iter().position(|w| *w == word).unwrap_or(0);
        Candidate {
            positions: positions.collect(),
            choices: vec![
                index(&DISTRIBUTIONS, &self.stiffness_distribution),
                index(&READINGS, &self.beam_length_to),
                0,
            ],
            seed: self.seed,
        }
    }
}

/// The value rounded to nine decimals, so that writing and reading it is exact.
pub(super) fn rounded(value: f64) -> f64 {
    (1e9 * value).round() / 1e9
}

/// An independent random stream for each candidate.
pub(super) fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLD: StartingWay = StartingWay {
        kick_mm_per_s: 0.01,
        continued: false,
    };

    #[test]
    fn candidates_are_valid_scenes_and_reproducible() {
        let base = Scene::load("periodic-2deg").unwrap();
        for number in 0..60 {
            let any = Candidate::random(3, number);
            assert_eq!(any, Candidate::random(3, number));
            let scene = any.scene(&base, COLD).unwrap();
            let contact = &scene.joint().unwrap().spec.contact;
            assert!((0.3..=300.0).contains(&contact.stiffness_factor));
            let far: Vec<f64> = any.positions.iter().map(|x| 5.0 * x - 2.0).collect();
            let moved = any.moved(&far, number + 2000);
            moved.scene(&base, COLD).unwrap();
            let mut inside = moved.positions.iter();
            assert!(
                inside.all(|position| (0.0..=1.0).contains(position)),
                "{moved:?}"
            );
            assert!(moved.seed < SEEDS);
            assert_eq!(any.moved(&any.positions, any.seed), any);
        }
        assert_ne!(Candidate::random(3, 1), Candidate::random(3, 2));
        assert_ne!(Candidate::random(3, 1), Candidate::random(4, 1));
    }

    /// The positions of the known sets give their values again.
    #[test]
    fn known_sets_have_their_values() {
        let sets = toml::from_str::<KnownSets>(KNOWN).unwrap().set;
        assert!(sets.len() >= 10);
        for (set, candidate) in sets.iter().zip(known_sets()) {
            let numbers = candidate.numbers();
            let value = |path: &str| numbers.iter().find(|(p, _)| *p == path).unwrap().1;
            for (path, expected) in [
                ("load.azimuth_deg", set.azimuth_deg),
                ("contact.stiffness_factor", set.stiffness_factor),
                ("contact.radius_factor", set.radius_factor),
                (
                    "friction.stribeck_slope_s_per_m",
                    set.stribeck_slope_s_per_m,
                ),
                ("friction.creep_slope_s_per_m", 1000.0),
                ("damping.ratio", 0.0),
            ] {
                let found = value(path);
                assert!(
                    (found - expected).abs() <= 1e-4 * expected.abs(),
                    "{path}: {found} {expected}"
                );
            }
            let words = candidate.words();
            assert!(words.contains(&(
                "contact.stiffness_distribution",
                &*set.stiffness_distribution
            )));
            assert!(words.contains(&("body.beam_length_to", &*set.beam_length_to)));
        }
    }
}
