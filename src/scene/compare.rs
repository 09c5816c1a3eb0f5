//! The keys in which two scenes differ.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use toml_edit::ser::ValueSerializer;

use super::Scene;
use super::error::SceneError;
use super::parameter::is_listed;
use super::schema::{Declared, IfAbsent};
use super::tables::SCHEMA;
use crate::number::counted;
use crate::report::{Block, Report, Table};

/// The keys in which two scenes differ. Names, titles and descriptions are not compared.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SceneComparison {
    /// Names of the two scenes.
    pub scenes: [String; 2],
    /// Keys in the order of the guide.
    pub differences: Vec<KeyDifference>,
}

/// A key in which two scenes differ.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct KeyDifference {
    /// Path of the key in the scene file.
    pub key: String,
    /// Its value in each scene, as in a scene file: for an absent key its default, and `null` if it has none or the scene
    /// does not have its table.
    pub values: [Option<String>; 2],
}

impl SceneComparison {
    /// Compares two scenes.
    ///
    /// # Errors
    /// If the text of a scene is no TOML.
    pub fn new(one: &Scene, other: &Scene) -> Result<Self, SceneError> {
        let concerned = [one.concerns()?, other.concerns()?];
        // A scene has been parsed from its text.
        let tables: [Value; 2] =
            [one, other].map(|scene| toml_edit::de::from_str(&scene.text).unwrap_or_default());
        let differences = SCHEMA.0.iter().filter_map(|key| {
            let is_compared = !["name", "title", "about"].contains(&&*key.path) && !is_listed(key);
            let values = [0, 1].map(|k| written(&tables[k], key, concerned[k](key)));
            (is_compared && values[0] != values[1]).then(|| KeyDifference {
                key: key.path.clone(),
                values,
            })
        });
        Ok(Self {
            scenes: [one, other].map(|scene| scene.name.clone()),
            differences: differences.collect(),
        })
    }
}

/// The value of a key, or its default if it concerns the scene. A table within another one is optional, and its defaults are
/// those of a scene that has it. Whole numbers of a real key are written with and without a point.
fn written(scene: &Value, key: &Declared, is_concerned: bool) -> Option<String> {
    let short = |number: f64| match number.abs() {
        size if size > 0.0 && size < 1e-3 => format!("{number:e}"),
        _ => number.to_string(),
    };
    let find = |path: &str| scene.pointer(&format!("/{}", path.replace('.', "/")));
    let has_table = !key.table.contains('.') || find(&key.table).is_some();
    match (find(&key.path), key.if_absent) {
        (Some(Value::Number(number)), _) => number.as_f64().map(short),
        (Some(value), _) => Some(value.serialize(ValueSerializer::new()).ok()?.to_string()),
        (None, IfAbsent::Default(literal)) if is_concerned && has_table => {
            Some(literal.parse().map_or_else(|_| literal.to_owned(), short))
        }
        (None, _) => None,
    }
}

impl Report for SceneComparison {
    fn blocks(&self, _name: &str) -> Vec<Block> {
        let [one, other] = &self.scenes;
        let heading = |rest: &str| Block::heading(format!("{one} and {other}"), rest);
        if self.differences.is_empty() {
            return vec![heading(": no key differs")];
        }
        let count = counted(self.differences.len(), "different key");
        let table = Table::of(&self.differences)
            .left("key", |found| found.key.clone())
            .left(one, |found| found.values[0].clone())
            .left(other, |found| found.values[1].clone());
        vec![heading(&format!(": {count}")), table.into()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_keys_whose_values_differ_are_listed() {
        let scene = |name: &str, lines: &str| {
            let text = format!("[load]\nload_n = 100\ntilt_deg = 2.0\n{lines}");
            Scene::parse(name, text).expect("a scene")
        };
        let one = scene(
            "a.toml",
            "[time]\nduration_ms = 10\n[friction]\nmu_s = 0.5\nmu_d = 0.2\n",
        );
        let other = scene(
            "b.toml",
            "[time]\nduration_ms = 10.0\nmethod = \"tsit5\"\n[friction]\nmu_s = 0.4\nmu_d = 0.2\n",
        );
        let found = SceneComparison::new(&one, &other).expect("TOML");
        let keys: Vec<_> = found.differences.iter().map(|found| &*found.key).collect();
        assert_eq!(keys, ["friction.mu_s", "time.method"]);
        assert_eq!(
            found.differences[0].values,
            ["0.5", "0.4"].map(|value| Some(value.to_owned()))
        );
        assert_eq!(found.differences[1].values[1], Some("\"tsit5\"".to_owned()));
        let differences = |one, other| SceneComparison::new(one, other).expect("TOML").differences;
        assert!(differences(&one, &one).is_empty());
        // A key with its default value does not differ from an absent one.
        let default = &found.differences[1].values[0].clone().expect("a default");
        let same = scene(
            "c.toml",
            &format!(
                "[time]\nduration_ms = 10\nmethod = {default}\n[friction]\nmu_s = 0.5\nmu_d = 0.2\n"
            ),
        );
        assert!(differences(&one, &same).is_empty());
    }

    #[test]
    fn defaults_are_those_of_the_tables_that_a_scene_has() {
        let joint = |lines: &str| {
            let text = format!(
                "[load]\nload_n = 100\ntilt_deg = 2\n[friction]\nmu_s = 0.5\nmu_d = 0.2\n{lines}"
            );
            Scene::parse("a.toml", text).expect("a scene")
        };
        let plain = joint("[time]\nduration_ms = 100\n");
        let analysed = joint("[time]\nduration_ms = 100\ntolerance = 1e-9\n[analysis.lyapunov]\n");
        let found = SceneComparison::new(&plain, &analysed).expect("TOML");
        let of = |key: &str| found.differences.iter().find(|found| found.key == key);
        let transient = &of("analysis.lyapunov.transient_ms")
            .expect("differs")
            .values;
        assert!(transient[0].is_none() && transient[1].is_some());
        let tolerance = &of("time.tolerance").expect("differs").values;
        assert_eq!(tolerance[1].as_deref(), Some("1e-9"));
        // A scene without a joint has no default of a joint.
        let belt = Scene::load("mass-on-belt").expect("preset");
        let found = SceneComparison::new(&belt, &plain).expect("TOML");
        let contact = found
            .differences
            .iter()
            .find(|found| found.key == "contact.nodes");
        assert_eq!(contact.map(|found| found.values[0].clone()), Some(None));
        let same = SceneComparison::new(&plain, &plain).expect("TOML");
        assert_eq!(same.blocks("").len(), 1);
    }
}
