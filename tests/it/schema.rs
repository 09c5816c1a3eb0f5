//! The JSON of every command agrees with the schema that `squeakscope schema` prints.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::{Map, Value, json};
use squeakscope::scene::Scene;
use squeakscope::study::paper::paper_plan;
use squeakscope::study::sweep::{Start, SweepPoint, write_table};

/// Short runs of each command; a command with several forms of results has an example of each.
const EXAMPLES: &[&str] = &[
    "scenes",
    "scenes periodic-2deg",
    "scenes --compare periodic-2deg mass-on-belt",
    "run periodic-2deg --duration 25 --save a.rrd --wav a.wav --npz b.npz",
    "run chaos-5deg --duration 12 --accuracy 1e-3 --npz b.npz",
    "stability periodic-2deg --tilt 2 --causes",
    "stability periodic-2deg --tilt 2 --sensitivities --set body.element_order=2",
    "branch periodic-2deg --tilt 1.9:2.1 --points 3 --out branch.arrow",
    "branch periodic-2deg --tilt 6.7:7 --points 3 --start 6.7 --tori 1",
    "branch doubled-torus-3deg --param friction.stribeck_slope_s_per_m=0:12 --points 9 --equilibria",
    "branch doubled-torus-3deg --tilt 0:4 --param friction.stribeck_slope_s_per_m=0:6 --points 4",
    "model periodic-2deg --out a.npz",
    "lyapunov impact-oscillator --duration 60 --settle 10 --average-time 0.5 --csv a.csv",
    "sweep doubled-torus-3deg --tilt 2:3:1 --start downward --min-transient 100 --max-transient 140 --measure 60 --exponents 1 --out a.arrow",
    "merge a.arrow --out merged.arrow",
    "basins periodic-2deg --tilt 2 --kicks 2 --min-transient 20 --max-transient 30 --measure 10 --exponents 0 --out b.arrow",
    "cost mass-on-belt --set time.duration_ms=40 --set time.sample_rate_khz=10",
    // The points of the sweep come from an earlier run, which `prepare` writes.
    "paper --figure 4 --out paper",
    "analyse sound.wav --calibration 2Pa",
    "analyse sound.wav missing.wav",
    "friction measured.csv",
];

/// Writes what the examples read: the table of a sweep whose runs have failed, a sound and points of a friction law.
fn prepare(folder: &Path) {
    let plan = paper_plan(Scene::load("paper").unwrap(), Start::Fresh);
    let points = (0..plan.size()).map(|index| SweepPoint {
        place: plan.place(index),
        outcome: Err("not simulated".to_owned()),
    });
    let points: Vec<SweepPoint> = points.collect();
    fs::create_dir(folder.join("paper")).unwrap();
    write_table(&folder.join("paper/sweep.arrow"), &plan, &points).unwrap();
    write_sound(&folder.join("sound.wav"));
    write_friction(&folder.join("measured.csv"));
}

/// Points of a Stribeck law with a small error, for the results of `friction`.
fn write_friction(file: &Path) {
    let point = |k: u32| {
        let speed = 2e-3 * 1.3_f64.powi(k as i32);
        let error = if k.is_multiple_of(3) { 0.004 } else { -0.002 };
        let mu = 0.25 + 0.3 * (-12.0 * speed).exp() + error;
        format!("{speed},{mu},0.004\n")
    };
    let points: String = (0..20).map(point).collect();
    fs::write(file, format!("speed_m_per_s,mu,mu_deviation\n{points}")).unwrap();
}

/// A sound of 3 s for the results of `analyse`: a modulated tone from 0.5 to 2.5 s, with hum and noise.
fn write_sound(file: &Path) {
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: 16_000,
        bits_per_sample: 16,
        sample_format: hound::SampleFormat::Int,
    };
    let mut writer = hound::WavWriter::create(file, spec).unwrap();
    let mut noise = 1_u32;
    for k in 0..3 * spec.sample_rate {
        let t = f64::from(k) / f64::from(spec.sample_rate);
        let sine = |hz: f64| (TAU * hz * t).sin();
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = f64::from(noise >> 16) / 32768.0 - 1.0;
        let envelope = ((t - 0.5) / 0.02).clamp(0.0, 1.0) * ((2.5 - t) / 0.02).clamp(0.0, 1.0);
        let tone = 6000.0 * envelope * (1.0 + 0.4 * sine(12.0)) * (TAU * 1513.0 * t).sin();
        let hum = 2000.0 * (sine(50.0) + 0.5 * sine(100.0) + 0.3 * sine(150.0));
        writer
            .write_sample((tone + hum + 200.0 * noise).round() as i16)
            .unwrap();
    }
    writer.finalize().unwrap();
}

/// What the program prints with these arguments.
fn printed(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_squeakscope"))
        .args(arguments)
        .output()
        .unwrap();
    assert!(output.status.success(), "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// A check of JSON against a schema, as far as derived schemas use the language. Unlike a validator it rejects fields that
/// the schema does not declare.
struct Checker {
    definitions: Map<String, Value>,
    /// Declared fields without a description.
    undescribed: BTreeSet<String>,
}

impl Checker {
    fn new(schema: &Value) -> Self {
        let definitions = schema["$defs"].as_object().cloned().unwrap_or_default();
        Self {
            definitions,
            undescribed: BTreeSet::new(),
        }
    }

    /// The fields of `value` that the schema declares.
    ///
    /// # Errors
    /// The first place at which the value contradicts the schema.
    fn fields(
        &mut self,
        schema: &Value,
        value: &Value,
        path: &str,
    ) -> Result<BTreeSet<String>, String> {
        let mut declared = BTreeSet::new();
        // The schema `true` allows everything.
        let rules = schema.as_object().into_iter().flatten();
        for (word, rule) in rules {
            let list = || rule.as_array().into_iter().flatten();
            let items = value.as_array().into_iter().flatten();
            match word.as_str() {
                "$ref" => {
                    let name = rule.as_str().unwrap().trim_start_matches("#/$defs/");
                    let definition = self.definitions[name].clone();
                    declared.extend(self.fields(&definition, value, path)?);
                }
                "allOf" => {
                    for rule in list() {
                        declared.extend(self.fields(rule, value, path)?);
                    }
                }
                "anyOf" | "oneOf" => {
                    let forms: Vec<_> = list().map(|rule| self.fields(rule, value, path)).collect();
                    if forms.iter().all(Result::is_err) {
                        let errors: Vec<_> = forms.into_iter().filter_map(Result::err).collect();
                        return Err(errors.join("\n or "));
                    }
                    declared.extend(forms.into_iter().flatten().flatten());
                }
                "properties" => declared.extend(self.properties(rule, value, path)?),
                "additionalProperties" if rule.is_object() => {
                    for (name, value) in value.as_object().into_iter().flatten() {
                        if schema["properties"].get(name).is_none() {
                            declared.insert(name.clone());
                            self.check(rule, value, &format!("{path}.{name}"))?;
                        }
                    }
                }
                "items" => {
                    let first = schema["prefixItems"].as_array().map_or(0, Vec::len);
                    for value in items.skip(first) {
                        self.check(rule, value, &format!("{path}[]"))?;
                    }
                }
                "prefixItems" => {
                    for (rule, value) in list().zip(items) {
                        self.check(rule, value, &format!("{path}[]"))?;
                    }
                }
                _ if !allows(word, rule, value) => {
                    return Err(format!("{path}: {value} is not {word} {rule}"));
                }
                _ => {}
            }
        }
        Ok(declared)
    }

    /// Checks the declared fields of an object, and returns those that it has.
    fn properties(
        &mut self,
        rules: &Value,
        value: &Value,
        path: &str,
    ) -> Result<BTreeSet<String>, String> {
        let mut declared = BTreeSet::new();
        let rules = rules.as_object().unwrap();
        // Beside the tag of a variant stands its content, which the documentation of the variant describes.
        let is_variant = rules.values().any(|rule| rule.get("const").is_some());
        for (name, rule) in rules {
            let path = format!("{path}.{name}");
            if let Some(value) = value.get(name) {
                declared.insert(name.clone());
                self.check(rule, value, &path)?;
            }
            if rule.get("description").is_none() && !is_variant {
                self.undescribed.insert(path);
            }
        }
        Ok(declared)
    }

    /// Checks a value and that the schema declares all its fields.
    fn check(&mut self, schema: &Value, value: &Value, path: &str) -> Result<(), String> {
        let declared = self.fields(schema, value, path)?;
        let fields = value.as_object().into_iter().flatten();
        match fields
            .map(|(name, _)| name)
            .find(|name| !declared.contains(*name))
        {
            Some(name) => Err(format!("{path}: the schema does not declare {name}")),
            None => Ok(()),
        }
    }
}

/// Whether a rule of a schema that has no schemas in it allows a value.
fn allows(word: &str, rule: &Value, value: &Value) -> bool {
    let mut list = rule.as_array().into_iter().flatten();
    let count = value.as_array().map(|items| items.len() as u64);
    let (number, limit) = (value.as_f64(), rule.as_f64());
    match word {
        "type" if rule.is_string() => is_a(value, rule.as_str().unwrap()),
        "type" => list.any(|name| is_a(value, name.as_str().unwrap())),
        "const" => value == rule,
        "enum" => list.any(|rule| rule == value),
        "required" => {
            !value.is_object() || list.all(|name| value.get(name.as_str().unwrap()).is_some())
        }
        "minItems" => count.is_none_or(|count| Some(count) >= rule.as_u64()),
        "maxItems" => count.is_none_or(|count| Some(count) <= rule.as_u64()),
        "minimum" => number.is_none_or(|number| Some(number) >= limit),
        "maximum" => number.is_none_or(|number| Some(number) <= limit),
        "additionalProperties"
        | "$schema"
        | "$defs"
        | "title"
        | "description"
        | "format"
        | "default" => true,
        other => panic!("`{other}` is not known to this test"),
    }
}

fn is_a(value: &Value, name: &str) -> bool {
    match name {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_u64() || value.is_i64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        _ => panic!("type {name}"),
    }
}

#[test]
fn the_check_rejects_what_a_schema_does_not_allow() {
    let schema = json!({
        "$defs": {"length": {"type": ["number", "null"]}},
        "type": "object",
        "properties": {
            "length_m": {"$ref": "#/$defs/length", "description": "Length, m."},
            "sizes": {"type": "array", "items": {"type": "integer"}},
        },
        "required": ["length_m"],
    });
    let check = |value| {
        let mut checker = Checker::new(&schema);
        let result = checker.check(&schema, &value, "");
        assert_eq!(checker.undescribed.iter().collect::<Vec<_>>(), [".sizes"]);
        result
    };
    assert_eq!(check(json!({"length_m": null, "sizes": [1, 2]})), Ok(()));
    for wrong in [
        json!({"length_m": 1.0, "extra": 2}),
        json!({"length_m": "1", "sizes": []}),
        json!({"length_m": 1.0, "sizes": [1.5]}),
        json!({"sizes": []}),
    ] {
        let mut checker = Checker::new(&schema);
        assert!(checker.check(&schema, &wrong, "").is_err(), "{wrong}");
    }
}

#[test]
fn results_agree_with_their_schemas() {
    let folder = tempfile::tempdir().unwrap();
    prepare(folder.path());
    let mut checkers = BTreeMap::new();
    for example in EXAMPLES {
        let mut command = Command::new(env!("CARGO_BIN_EXE_squeakscope"));
        command.current_dir(folder.path()).args(example.split(' '));
        command.args(["--force", "--json", "a.json"]);
        let output = command.output().unwrap();
        let file = fs::read(folder.path().join("a.json"));
        let errors = String::from_utf8_lossy(&output.stderr);
        let document: Value = serde_json::from_slice(&file.expect(&errors)).unwrap();
        fs::remove_file(folder.path().join("a.json")).unwrap();
        let name = example.split(' ').next().unwrap();
        let (schema, checker) = checkers.entry(name).or_insert_with(|| {
            let schema: Value = serde_json::from_str(&printed(&["schema", name])).unwrap();
            let checker = Checker::new(&schema);
            (schema, checker)
        });
        if let Err(fault) = checker.check(schema, &document, "") {
            panic!("{example}: {fault}");
        }
    }
    for (name, (_, checker)) in &checkers {
        let undescribed = &checker.undescribed;
        assert!(
            undescribed.is_empty(),
            "{name}: no description of {undescribed:?}"
        );
    }
    let listed = printed(&["schema"]);
    let listed: BTreeSet<&str> = listed.lines().collect();
    assert_eq!(listed, checkers.keys().copied().collect());
}

/// Every command with the option `--json` has a schema.
#[test]
fn every_command_that_writes_json_has_a_schema() {
    let listed = printed(&["schema"]);
    let help = printed(&["--help"]);
    let commands = help
        .lines()
        .filter_map(|line| line.strip_prefix("  "))
        .filter_map(|line| line.split("  ").next())
        .filter(|name| !name.is_empty() && name.chars().all(|c| c.is_ascii_lowercase()));
    let mut count = 0;
    for command in commands {
        let help = printed(&[command, "--help"]);
        let writes_json = help
            .lines()
            .any(|line| line.trim_start().starts_with("--json"));
        let has_schema = listed.lines().any(|name| name == command);
        assert_eq!(has_schema, writes_json, "{command}");
        count += usize::from(writes_json);
    }
    assert_eq!(count, listed.lines().count());
}
