//! The keys in which two scenes differ.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use toml_edit::ser::ValueSerializer;

use super::Scene;
use super::parameter::is_listed;
use super::schema::{Declared, IfAbsent};
use super::tables::SCHEMA;
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
    /// Its value in each scene, as in a scene file; the default of a key that is absent, `null` without one.
    pub values: [Option<String>; 2],
}

impl SceneComparison {
    /// Compares two scenes.
    pub fn new(one: &Scene, other: &Scene) -> Self {
        // A scene has been parsed from its text.
        let tables: [Value; 2] =
            [one, other].map(|scene| toml_edit::de::from_str(&scene.text).unwrap_or_default());
        let differences = SCHEMA.0.iter().filter_map(|key| {
            let is_compared = !["name", "title", "about"].contains(&&*key.path) && !is_listed(key);
            let values = tables.each_ref().map(|table| written(table, key));
            (is_compared && values[0] != values[1]).then(|| KeyDifference {
                key: key.path.clone(),
                values,
            })
        });
        Self {
            scenes: [one, other].map(|scene| scene.name.clone()),
            differences: differences.collect(),
        }
    }
}

/// The value of a key, or its default. Whole numbers of a real key are written with and without a point.
fn written(scene: &Value, key: &Declared) -> Option<String> {
    let short = |number: f64| number.to_string();
    let value = scene.pointer(&format!("/{}", key.path.replace('.', "/")));
    match (value, key.if_absent) {
        (Some(Value::Number(number)), _) => number.as_f64().map(short),
        (Some(value), _) => Some(value.serialize(ValueSerializer::new()).ok()?.to_string()),
        (None, IfAbsent::Default(literal)) => {
            Some(literal.parse().map_or_else(|_| literal.to_owned(), short))
        }
        (None, _) => None,
    }
}

impl Report for SceneComparison {
    fn blocks(&self, _name: &str) -> Vec<Block> {
        let [one, other] = &self.scenes;
        let count = format!(": {} keys differ", self.differences.len());
        let table = Table::of(&self.differences)
            .left("key", |found| found.key.clone())
            .left(one, |found| found.values[0].clone())
            .left(other, |found| found.values[1].clone());
        vec![
            Block::heading(format!("{one} and {other}"), count),
            table.into(),
        ]
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
        let found = SceneComparison::new(&one, &other);
        let keys: Vec<_> = found.differences.iter().map(|found| &*found.key).collect();
        assert_eq!(keys, ["friction.mu_s", "time.method"]);
        assert_eq!(
            found.differences[0].values,
            ["0.5", "0.4"].map(|value| Some(value.to_owned()))
        );
        assert_eq!(found.differences[1].values[1], Some("\"tsit5\"".to_owned()));
        assert!(SceneComparison::new(&one, &one).differences.is_empty());
        // A key with its default value does not differ from an absent one.
        let default = &found.differences[1].values[0].clone().expect("a default");
        let same = scene(
            "c.toml",
            &format!(
                "[time]\nduration_ms = 10\nmethod = {default}\n[friction]\nmu_s = 0.5\nmu_d = 0.2\n"
            ),
        );
        assert!(SceneComparison::new(&one, &same).differences.is_empty());
    }
}
