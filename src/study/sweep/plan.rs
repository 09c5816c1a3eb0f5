//! What is to be done: axes, starts, the order of the points, and which of them a machine takes.

use serde::{Deserialize, Serialize};

use crate::scene::{Parameter, Scene, SceneError};
use crate::study::response::ResponsePlan;

/// A parameter and the values it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    parameter: Parameter,
    /// In the unit of the scene file, rising.
    values: Vec<f64>,
}

impl Axis {
    /// The parameter at these values, in the unit in which a scene file states it; they are put in
    /// rising order, each once.
    pub fn new(parameter: Parameter, values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        Self { parameter, values }
    }

    /// The parameter.
    pub fn parameter(&self) -> Parameter {
        self.parameter
    }

    /// Its values, rising.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The axis in words: what it is, and its unit.
    pub fn label(&self) -> String {
        if self.parameter == Parameter::tilt() {
            return "tilt of the load, deg".to_owned();
        }
        match self.parameter.unit() {
            "" => self.parameter.path().to_owned(),
            unit => format!("{}, {unit}", self.parameter.path()),
        }
    }
}

/// How each point is started. Attractors coexist, so that this is part of the question.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, strum::Display)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Start {
    /// Each from the scene's kick.
    Cold,
    /// Each from its lower neighbour.
    Up,
    /// Each from its higher neighbour.
    Down,
}

impl Start {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Cold, Self::Up, Self::Down];
}

/// A sweep: every value of the first axis at every value of the second, from every start.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPlan {
    /// The scene that is varied.
    pub scene: Scene,
    /// One axis or two; states are carried on along the first.
    pub axes: Vec<Axis>,
    /// The starts, each once.
    pub starts: Vec<Start>,
    /// How the response at each point is taken.
    pub response: ResponsePlan,
}

/// Where a point of a sweep is.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Place {
    /// Its number, from 0: start by start, row by row along the second axis.
    pub index: usize,
    /// How it is started.
    pub start: Start,
    /// Values of the axes.
    pub values: Vec<f64>,
}

/// Part `number` (from 1) of `of` of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Its number, from 1.
    pub number: usize,
    /// How many there are.
    pub of: usize,
}

impl Shard {
    /// The whole.
    pub const WHOLE: Self = Self { number: 1, of: 1 };
}

impl SweepPlan {
    /// How many points there are in all.
    pub fn len(&self) -> usize {
        self.starts.len() * self.a_start()
    }

    /// Whether there is nothing to do.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Points a start.
    fn a_start(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// Where the point with a number is.
    ///
    /// # Panics
    /// When there are not so many points.
    pub fn place(&self, index: usize) -> Place {
        let start = self.starts[index / self.a_start()];
        let mut left = index % self.a_start();
        let values = self.axes.iter().map(|axis| {
            let value = axis.values[left % axis.values.len()];
            left /= axis.values.len();
            value
        });
        Place {
            index,
            start,
            values: values.collect(),
        }
    }

    /// The scene at a point.
    ///
    /// # Errors
    /// When the values are out of range or do not fit together.
    pub fn scene_at(&self, place: &Place) -> Result<Scene, SceneError> {
        let parameters = self.axes.iter().map(Axis::parameter);
        let values: Vec<_> = parameters.zip(place.values.iter().copied()).collect();
        self.scene.with_values(&values)
    }

    /// The points in chains: within a chain each is started from the one before it, and chains do
    /// not depend on each other. A shard has every so-many-eth chain.
    pub fn chains(&self, shard: Shard) -> Vec<Vec<usize>> {
        let Some(row) = self.axes.first().map(|axis| axis.values.len()) else {
            return Vec::new();
        };
        let mut chains: Vec<Vec<usize>> = Vec::new();
        for (number, start) in self.starts.iter().enumerate() {
            let all = number * self.a_start()..(number + 1) * self.a_start();
            match start {
                Start::Cold => chains.extend(all.map(|index| vec![index])),
                Start::Up | Start::Down => {
                    for from in all.step_by(row.max(1)) {
                        let chain = from..from + row;
                        chains.push(match start {
                            Start::Down => chain.rev().collect(),
                            _ => chain.collect(),
                        });
                    }
                }
            }
        }
        let mine = chains.into_iter().enumerate();
        let mine = mine.filter(|(k, _)| k % shard.of == shard.number - 1);
        mine.map(|(_, chain)| chain).collect()
    }

    /// All that the results depend on, as a TOML text: results of plans with the same text belong
    /// together, and the plan can be read back from it ([`SweepPlan::of_identity`]).
    pub fn identity(&self) -> String {
        let axes = self.axes.iter().map(|axis| AxisRecord {
            path: axis.parameter.path().to_owned(),
            values: axis.values.clone(),
        });
        let record = PlanRecord {
            version: crate::VERSION.to_owned(),
            scene: self.scene.name.clone(),
            starts: self.starts.clone(),
            text: self.scene.text.clone(),
            modes: fingerprint(&self.scene),
            response: self.response,
            axes: axes.collect(),
        };
        // Strings, numbers and lists of them always can be written.
        toml::to_string_pretty(&record).unwrap_or_default()
    }

    /// The plan that has an identity.
    ///
    /// # Errors
    /// What is wrong with the text, in words.
    pub fn of_identity(identity: &str) -> Result<Self, String> {
        let record: PlanRecord = toml::from_str(identity).map_err(|e| e.message().to_owned())?;
        let scene = Scene::parse(&record.scene, record.text).map_err(|e| e.to_string())?;
        if fingerprint(&scene) != record.modes {
            return Err("the file of modes has changed since".to_owned());
        }
        let axes = record.axes.into_iter().map(|axis| {
            let parameter = Parameter::named(&axis.path).map_err(|e| e.to_string())?;
            Ok(Axis::new(parameter, axis.values))
        });
        Ok(Self {
            axes: axes.collect::<Result<_, String>>()?,
            starts: record.starts,
            response: record.response,
            scene,
        })
    }
}

/// The fingerprint of the modes that a scene takes from a file.
fn fingerprint(scene: &Scene) -> Option<String> {
    let modes = scene.own_modes()?;
    Some(format!("{:016x}", modes.fingerprint()))
}

/// A plan as a text.
#[derive(Serialize, Deserialize)]
struct PlanRecord {
    version: String,
    scene: String,
    starts: Vec<Start>,
    text: String,
    /// What the file of modes holds, if the scene takes its modes from one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    modes: Option<String>,
    response: ResponsePlan,
    axes: Vec<AxisRecord>,
}

/// An axis as a text.
#[derive(Serialize, Deserialize)]
struct AxisRecord {
    path: String,
    values: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(starts: &[Start]) -> SweepPlan {
        let factor = Parameter::named("stiffness_factor").unwrap();
        SweepPlan {
            scene: Scene::load("torus-3deg").unwrap(),
            axes: vec![
                Axis::new(Parameter::tilt(), [3.0, 1.0, 2.0, 1.0]),
                Axis::new(factor, [2.0, 4.0]),
            ],
            starts: starts.to_vec(),
            response: ResponsePlan::default(),
        }
    }

    #[test]
    fn places_count_start_by_start_and_row_by_row() {
        let plan = plan(&[Start::Cold, Start::Down]);
        assert_eq!(plan.len(), 12);
        let places: Vec<Place> = (0..12).map(|k| plan.place(k)).collect();
        assert_eq!(places[1].values, [2.0, 2.0]);
        assert_eq!(places[3].values, [1.0, 4.0]);
        assert_eq!(
            (places[5].start, places[6].start),
            (Start::Cold, Start::Down)
        );
        assert_eq!(places[8].values, [3.0, 2.0]);
        let scene = plan.scene_at(&places[8]).unwrap();
        assert_eq!(scene.joint().unwrap().tilt.at(0.0), 3.0_f64.to_radians());
        assert_eq!(scene.joint().unwrap().spec.contact.stiffness_factor, 2.0);
    }

    #[test]
    fn chains_go_the_way_of_their_start() {
        let plan = plan(&[Start::Up, Start::Down, Start::Cold]);
        let chains = plan.chains(Shard::WHOLE);
        assert_eq!(chains[..4], [[0, 1, 2], [3, 4, 5], [8, 7, 6], [11, 10, 9]]);
        assert_eq!(chains[4..], [[12], [13], [14], [15], [16], [17]]);
    }

    #[test]
    fn shards_have_every_point_once() {
        let plan = plan(&Start::ALL);
        for of in 1..12 {
            let mut all: Vec<usize> = (1..=of)
                .flat_map(|number| plan.chains(Shard { number, of }).concat())
                .collect();
            all.sort_unstable();
            assert_eq!(all, (0..plan.len()).collect::<Vec<_>>());
        }
    }

    #[test]
    fn another_question_has_another_identity() {
        let one = plan(&[Start::Up]);
        let mut other = one.clone();
        other.response.measure *= 2.0;
        assert_ne!(one.identity(), other.identity());
        assert_ne!(one.identity(), plan(&[Start::Down]).identity());
        assert_eq!(one.identity(), plan(&[Start::Up]).identity());
        assert_eq!(SweepPlan::of_identity(&one.identity()).unwrap(), one);
        assert!(SweepPlan::of_identity("version = 1").is_err());
    }
}
