//! Plan of a sweep: axes, starts, order of the points, and shards for several machines.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::{Parameter, Scene, SceneError};
use crate::study::response::ResponsePlan;
use crate::study::subject::scene_at;

/// An axis of a sweep: a parameter and its values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// Name of the parameter: the path of the key for a scene.
    #[serde(rename = "path")]
    pub name: String,
    /// The values in the unit of the scene file, ascending.
    pub values: Vec<f64>,
}

impl Axis {
    /// Creates an axis from values in the unit of the scene file. The values are sorted in ascending order
    /// and duplicates are removed.
    pub fn new(name: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        Self {
            name: name.into(),
            values,
        }
    }

    /// The key of a scene.
    ///
    /// # Errors
    /// If no scene has such a number.
    pub fn parameter(&self) -> Result<Parameter, SceneError> {
        Parameter::named(&self.name)
    }

    /// Unit of the values; empty for a number without one.
    pub fn unit(&self) -> &'static str {
        // A caller's parameter may have the name of a key without its table.
        let key = self.parameter().ok().filter(|key| key.path() == self.name);
        key.map_or("", Parameter::unit)
    }

    /// Label of the axis: the parameter and its unit.
    pub fn label(&self) -> String {
        if self.name == Parameter::tilt().path() {
            return "tilt of the load, deg".to_owned();
        }
        match self.unit() {
            "" => self.name.clone(),
            unit => format!("{}, {unit}", self.name),
        }
    }
}

/// Start of each point: a fresh start or continuation. Attractors coexist, so the result depends on it.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema, strum::Display,
)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Start {
    /// The initial state of the scene, with its random kick.
    Fresh,
    /// The settled state at the next lower value.
    Upward,
    /// The settled state at the next higher value.
    Downward,
}

impl Start {
    /// All starts.
    pub const ALL: [Self; 3] = [Self::Fresh, Self::Upward, Self::Downward];
}

/// A plan of a sweep: every combination of the axes' values, for every start.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPlan<S = Scene> {
    /// The scene whose parameters are varied, or systems of a caller.
    pub subject: S,
    /// One or two axes; continuation follows the first.
    pub axes: Vec<Axis>,
    /// The starts, without duplicates.
    pub starts: Vec<Start>,
    /// Plan of the response at each point.
    pub response: ResponsePlan,
}

impl<S> SweepPlan<S> {
    /// Total number of points.
    pub fn size(&self) -> usize {
        self.starts.len() * self.points_per_start()
    }

    /// Names of the parameters.
    pub fn names(&self) -> Vec<String> {
        self.axes.iter().map(|axis| axis.name.clone()).collect()
    }

    /// Points per start.
    fn points_per_start(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// The place of the point with an index.
    ///
    /// # Panics
    /// If `index` is not less than [`SweepPlan::size`].
    pub fn place(&self, index: usize) -> Place {
        let start = self.starts[index / self.points_per_start()];
        let mut left = index % self.points_per_start();
        let values = self.axes.iter().map(|axis| {
            let value = axis.values[left % axis.values.len()];
            left /= axis.values.len();
            value
        });
        let values: Vec<f64> = values.collect();
        Place {
            named: self.names().into_iter().zip(values.clone()).collect(),
            index,
            start,
            values,
        }
    }

    /// The points of a shard as chains, the longest first. Within a chain each point continues from the one before
    /// it; chains are independent of each other. Of `n` shards, each has every `n`-th chain.
    pub fn chains(&self, shard: Shard) -> Vec<Vec<usize>> {
        let Some(row) = self.axes.first().map(|axis| axis.values.len()) else {
            return Vec::new();
        };
        let mut chains: Vec<Vec<usize>> = Vec::new();
        for (number, start) in self.starts.iter().enumerate() {
            let all = number * self.points_per_start()..(number + 1) * self.points_per_start();
            for from in all.step_by(row.max(1)) {
                let chain = from..from + row;
                match start {
                    Start::Fresh => chains.extend(chain.map(|index| vec![index])),
                    Start::Upward => chains.push(chain.collect()),
                    Start::Downward => chains.push(chain.rev().collect()),
                }
            }
        }
        // Long chains first: at the end no thread waits for one, and shards have about the same work.
        chains.sort_by_key(|chain| std::cmp::Reverse(chain.len()));
        let mine = chains.into_iter().enumerate();
        let mine = mine.filter(|(k, _)| k % shard.of == shard.number - 1);
        mine.map(|(_, chain)| chain).collect()
    }
}

/// The place of a point in a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Place {
    /// Values of the parameters by their names.
    #[serde(flatten)]
    pub named: BTreeMap<String, f64>,
    /// Index of the point, from 0; the first axis varies fastest, the start slowest.
    pub index: usize,
    /// Start of the point.
    pub start: Start,
    /// Values of the axes, in the units of the scene file.
    pub values: Vec<f64>,
}

/// A shard: part `number` (from 1) of a sweep divided into `of` parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of this shard, from 1.
    pub number: usize,
    /// Total number of shards.
    pub of: usize,
}

impl Shard {
    /// The whole sweep as a single shard.
    pub const WHOLE: Self = Self { number: 1, of: 1 };
}

impl SweepPlan {
    /// The scene at a point.
    ///
    /// # Errors
    /// If a value is out of range, or the values are not consistent with each other.
    pub fn scene_at(&self, place: &Place) -> Result<Scene, SceneError> {
        scene_at(&self.subject, &self.names(), &place.values)
    }

    /// Everything that the results depend on, as TOML. Plans with equal text have equal results; the plan can
    /// be restored from the text ([`SweepPlan::from_identity`]).
    pub fn identity(&self) -> String {
        let record = PlanRecord {
            version: crate::VERSION.to_owned(),
            scene: self.subject.name.clone(),
            starts: self.starts.clone(),
            text: self.subject.text.clone(),
            modes: fingerprint(&self.subject),
            response: self.response,
            axes: self.axes.clone(),
        };
        // TOML can represent strings, numbers and lists of them without errors.
        toml_edit::ser::to_string_pretty(&record).unwrap_or_default()
    }

    /// The plan described by an identity text.
    ///
    /// # Errors
    /// A description of the fault in the text.
    pub fn from_identity(identity: &str) -> Result<Self, String> {
        let record = PlanRecord::parse(identity)?;
        for axis in &record.axes {
            axis.parameter().map_err(|e| e.to_string())?;
        }
        let scene = Scene::parse(&record.scene, record.text.clone()).map_err(|e| e.to_string())?;
        if fingerprint(&scene) != record.modes {
            return Err(
                "the modes file has changed since; restore it, or choose another --out".to_owned(),
            );
        }
        Ok(record.plan(scene))
    }
}

/// Fingerprint of the modes file of a scene, if it has one.
fn fingerprint(scene: &Scene) -> Option<String> {
    let modes = scene.imported_modes()?;
    Some(format!("{:016x}", modes.fingerprint()))
}

/// A plan in serialised form.
#[derive(Serialize, Deserialize)]
pub(super) struct PlanRecord {
    /// Version of the program.
    version: String,
    /// Name of the scene.
    scene: String,
    /// The starts.
    starts: Vec<Start>,
    /// Text of the scene file.
    text: String,
    /// Fingerprint of the modes file, if the scene has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    modes: Option<String>,
    /// Plan of the response at each point.
    response: ResponsePlan,
    /// The axes.
    axes: Vec<Axis>,
}

impl PlanRecord {
    /// The plan of an identity text, or the fault in it.
    pub fn parse(identity: &str) -> Result<Self, String> {
        let record: Self = toml_edit::de::from_str(identity).map_err(|e| e.message().to_owned())?;
        match record.axes.len() {
            1 | 2 => Ok(record),
            count => Err(format!("it has {count} axes instead of 1 or 2")),
        }
    }

    /// The plan for a scene, or for systems of a caller.
    pub fn plan<S>(self, subject: S) -> SweepPlan<S> {
        SweepPlan {
            subject,
            axes: self.axes,
            starts: self.starts,
            response: self.response,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(starts: &[Start]) -> SweepPlan {
        let factor = Parameter::named("stiffness_factor").unwrap();
        SweepPlan {
            subject: Scene::load("doubled-torus-3deg").unwrap(),
            axes: vec![
                Axis::new(Parameter::tilt(), [3.0, 1.0, 2.0, 1.0]),
                Axis::new(factor, [2.0, 4.0]),
            ],
            starts: starts.to_vec(),
            response: ResponsePlan::default(),
        }
    }

    #[test]
    fn places_count_the_first_axis_fastest_and_the_start_slowest() {
        let plan = plan(&[Start::Fresh, Start::Downward]);
        assert_eq!(plan.size(), 12);
        let places: Vec<Place> = (0..12).map(|k| plan.place(k)).collect();
        assert_eq!(places[1].values, [2.0, 2.0]);
        assert_eq!(places[3].values, [1.0, 4.0]);
        assert_eq!(
            (places[5].start, places[6].start),
            (Start::Fresh, Start::Downward)
        );
        assert_eq!(places[8].values, [3.0, 2.0]);
        let scene = plan.scene_at(&places[8]).unwrap();
        assert_eq!(scene.joint().unwrap().tilt.at(0.0), 3.0_f64.to_radians());
        assert_eq!(scene.joint().unwrap().spec.contact.stiffness_factor, 2.0);
    }

    #[test]
    fn chains_follow_the_direction_of_their_start() {
        let plan = plan(&[Start::Upward, Start::Downward, Start::Fresh]);
        let chains = plan.chains(Shard::WHOLE);
        assert_eq!(chains[..4], [[0, 1, 2], [3, 4, 5], [8, 7, 6], [11, 10, 9]]);
        assert_eq!(chains[4..], [[12], [13], [14], [15], [16], [17]]);
        // The long chains come first whatever the order of the starts.
        let chains = self::plan(&[Start::Fresh, Start::Upward]).chains(Shard::WHOLE);
        assert_eq!(chains[..3], [vec![6, 7, 8], vec![9, 10, 11], vec![0]]);
    }

    #[test]
    fn shards_partition_the_points() {
        let plan = plan(&Start::ALL);
        for of in 1..12 {
            let mut all: Vec<usize> = (1..=of)
                .flat_map(|number| plan.chains(Shard { number, of }).concat())
                .collect();
            all.sort_unstable();
            assert_eq!(all, (0..plan.size()).collect::<Vec<_>>());
        }
    }

    #[test]
    fn different_plans_have_different_identities() {
        let one = plan(&[Start::Upward]);
        let mut other = one.clone();
        other.response.measurement_s *= 2.0;
        assert_ne!(one.identity(), other.identity());
        assert_ne!(one.identity(), plan(&[Start::Downward]).identity());
        assert_eq!(one.identity(), plan(&[Start::Upward]).identity());
        assert_eq!(SweepPlan::from_identity(&one.identity()).unwrap(), one);
        assert!(SweepPlan::from_identity("version = 1").is_err());
        let no_axes = SweepPlan {
            axes: Vec::new(),
            ..one
        };
        let reason = SweepPlan::from_identity(&no_axes.identity()).unwrap_err();
        assert!(reason.contains("axes"), "{reason}");
    }
}
