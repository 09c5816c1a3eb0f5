//! Checks `src/guide/reference/json.md`: the fields of real results, with the types and doc comments of their structs.
//!
//! `UPDATE_GUIDE=1 cargo test --release --test it json` rewrites the page.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;
use squeakscope::read_back;
use squeakscope::scene::{Parameter, Scene};
use squeakscope::study::paper::paper_plan;
use squeakscope::study::sweep::{Start, SweepPoint, write_table};
use syn::{Attribute, Fields, Type};

/// Each command with a short example.
const EXAMPLES: &[(&str, &str)] = &[
    ("scenes", "scenes periodic-2deg"),
    ("scenes --effects", "scenes impact-oscillator --effects"),
    (
        "run",
        "run periodic-2deg --duration 25 --save a.rrd --wav a.wav --npz b.npz",
    ),
    ("stability", "stability periodic-2deg --tilt 2 --causes"),
    (
        "stability --sensitivities",
        "stability periodic-2deg --tilt 2 --sensitivities",
    ),
    (
        "branch",
        "branch periodic-2deg --tilt 1.9:2.1 --points 3 --out branch.arrow",
    ),
    (
        "branch --tori",
        "branch periodic-2deg --tilt 6.7:7 --points 3 --start 6.7 --tori 1",
    ),
    (
        "branch --equilibria",
        "branch torus-3deg --param friction.stribeck_slope_s_per_m=0:12 --points 9 --equilibria",
    ),
    (
        "branch --tilt 0:4 --param friction.stribeck_slope_s_per_m=0:6",
        "branch torus-3deg --tilt 0:4 --param friction.stribeck_slope_s_per_m=0:6 --points 4",
    ),
    ("model", "model periodic-2deg --out a.npz"),
    (
        "lyapunov",
        "lyapunov impact-oscillator --duration 60 --settle 10 --average-time 0.5 --csv a.csv",
    ),
    (
        "sweep",
        "sweep torus-3deg --tilt 2:3:1 --start downward --min-transient 100 --max-transient 140 --measure 60 --exponents 1 --out a.arrow",
    ),
    (
        "basins",
        "basins periodic-2deg --tilt 2 --kicks 2 --min-transient 20 --max-transient 30 --measure 10 --exponents 0 --out b.arrow",
    ),
    (
        "cost",
        "cost impact-oscillator --setting integrator --repeats 1 --horizon 5 --out cost",
    ),
    (
        "growth",
        "growth impact-oscillator --repeats 1 --threads 1 --out growth",
    ),
    (
        "calibrate",
        "calibrate coarse.toml --screened 20 --starts 2 --generations 0 --out a.jsonl --best best.toml",
    ),
    // The points of the sweep come from an earlier run, which `prepare` writes.
    ("paper", "paper --figure 4 --out paper"),
    (
        "analyse",
        "analyse sound.wav --calibration 2Pa --json a.json",
    ),
    ("friction", "friction measured.csv"),
    (
        "analyse FILE FILE",
        "analyse sound.wav sound.wav --json a.json",
    ),
];

/// A field of a struct in the source.
pub struct Field {
    kind: String,
    /// The first paragraph of its documentation.
    pub doc: String,
}

/// The fields of each serialised struct by their JSON names.
pub fn structs() -> Vec<BTreeMap<String, Field>> {
    let mut found = Vec::new();
    let mut open = vec![root().join("src")];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            let inside = fs::read_dir(&path).unwrap();
            open.extend(inside.map(|entry| entry.unwrap().path()));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            items(&syn::parse_file(&text).unwrap().items, &mut found);
        }
    }
    // A value of the parameter of a branch has the name of its key.
    for name in ["tilt_deg", "stribeck_slope_s_per_m"] {
        let field = Field {
            kind: "number".to_owned(),
            doc: "Value of the parameter, in its unit; the field has the name of its key."
                .to_owned(),
        };
        found.push(BTreeMap::from([(name.to_owned(), field)]));
    }
    found
}

/// Collects the serialised structs, including those defined in functions.
fn items(items: &[syn::Item], found: &mut Vec<BTreeMap<String, Field>>) {
    for item in items {
        match item {
            syn::Item::Struct(item) if derives_serialize(&item.attrs) => {
                if let Fields::Named(fields) = &item.fields {
                    found.push(fields.named.iter().filter_map(field).collect());
                }
            }
            syn::Item::Enum(item) if derives_serialize(&item.attrs) => found.push(of_enum(item)),
            syn::Item::Fn(item) => {
                let inside = item
                    .block
                    .stmts
                    .iter()
                    .filter_map(|statement| match statement {
                        syn::Stmt::Item(item) => Some(item.clone()),
                        _ => None,
                    });
                self::items(&inside.collect::<Vec<_>>(), found);
            }
            _ => {}
        }
    }
}

/// The tag of an enum, its content, and the fields of its variants.
fn of_enum(item: &syn::ItemEnum) -> BTreeMap<String, Field> {
    let mut names = BTreeMap::new();
    for attribute in item.attrs.iter().filter(|a| a.path().is_ident("serde")) {
        let _ = attribute.parse_nested_meta(|meta| {
            let value = meta.value()?.parse::<syn::LitStr>()?.value();
            let kind = match meta.path.get_ident().map(ToString::to_string).as_deref() {
                Some("tag") => "string",
                Some("content") => "number",
                _ => return Ok(()),
            };
            let (kind, doc) = (kind.to_owned(), doc(&item.attrs));
            names.insert(value, Field { kind, doc });
            Ok(())
        });
    }
    let fields = item.variants.iter().flat_map(|variant| &variant.fields);
    names.extend(fields.filter_map(field));
    names
}

fn derives_serialize(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        syn::Meta::List(list) => list.tokens.to_string().contains("Serialize"),
        _ => false,
    })
}

fn field(field: &syn::Field) -> Option<(String, Field)> {
    let mut name = field.ident.as_ref()?.to_string();
    let mut is_hidden = false;
    for attribute in field.attrs.iter().filter(|a| a.path().is_ident("serde")) {
        let _ = attribute.parse_nested_meta(|meta| {
            let value = meta.value().and_then(|value| value.parse::<syn::LitStr>());
            match value {
                Ok(value) if meta.path.is_ident("rename") => name = value.value(),
                _ => {
                    is_hidden |= meta.path.is_ident("flatten") || meta.path.is_ident("skip");
                }
            }
            Ok(())
        });
    }
    let doc = doc(&field.attrs);
    let kind = kind(&field.ty);
    (!is_hidden).then_some((name, Field { kind, doc }))
}

/// The first paragraph of a doc comment, on one line.
pub fn doc(attributes: &[Attribute]) -> String {
    let lines = attributes.iter().filter_map(|attribute| {
        let value = &attribute.meta.require_name_value().ok()?.value;
        match value {
            syn::Expr::Lit(syn::ExprLit {
                lit: syn::Lit::Str(text),
                ..
            }) => Some(text.value().trim().to_owned()),
            _ => None,
        }
    });
    let first: Vec<String> = lines.take_while(|line| !line.is_empty()).collect();
    let text = first.join(" ").replace('|', "\\|");
    // The page has no links; Rust's `None` is `null` in JSON.
    text.replace("[`", "`")
        .replace("`]", "`")
        .replace("`None`", "`null`")
}

/// JSON type of a Rust type.
fn kind(kind: &Type) -> String {
    let Type::Path(path) = kind else {
        return match kind {
            Type::Reference(reference) => self::kind(&reference.elem),
            Type::Slice(_) | Type::Array(_) | Type::Tuple(_) => "list".to_owned(),
            _ => "object".to_owned(),
        };
    };
    let last = path.path.segments.last().unwrap();
    let inner = match &last.arguments {
        syn::PathArguments::AngleBracketed(arguments) => {
            arguments
                .args
                .iter()
                .rev()
                .find_map(|argument| match argument {
                    syn::GenericArgument::Type(kind) => Some(self::kind(kind)),
                    _ => None,
                })
        }
        _ => None,
    };
    match (last.ident.to_string().as_str(), inner) {
        ("Option", Some(inner)) => format!("{inner} or null"),
        ("Vec", Some(_)) => "list".to_owned(),
        ("Box" | "Arc" | "Cow", Some(inner)) => inner,
        ("f64" | "f32", _) => "number".to_owned(),
        ("u64" | "u32" | "u8" | "usize" | "i64" | "i32", _) => "integer".to_owned(),
        ("bool", _) => "boolean".to_owned(),
        ("String" | "str" | "PathBuf" | "Path", _) => "string".to_owned(),
        _ => String::new(),
    }
}

/// The rows of a result: each path with its type and meaning.
fn rows(
    structs: &[BTreeMap<String, Field>],
    value: &Value,
    path: &str,
    rows: &mut BTreeMap<String, [String; 2]>,
) {
    match value {
        Value::Array(values) => {
            for value in values {
                self::rows(structs, value, &format!("{path}[]"), rows);
            }
        }
        Value::Object(fields) => {
            // A result may combine flattened structs: take the struct that shares most fields with the rest.
            // Of several, take one that has no other fields.
            let shared = |candidate: &&BTreeMap<String, Field>| {
                let names = candidate.keys().filter(|name| fields.contains_key(*name));
                let count = names.count();
                (count, count == candidate.len())
            };
            for (name, value) in fields {
                let candidates = structs.iter().filter(|names| names.contains_key(name));
                let best = candidates.max_by_key(shared);
                let field = best.unwrap_or_else(|| panic!("no struct has `{path}.{name}`"));
                let Field { kind, doc } = &field[name];
                let kind = match (kind.as_str(), value) {
                    ("", Value::String(_)) => "string",
                    ("", Value::Object(_)) => "object",
                    ("", _) => "list",
                    (" or null", Value::String(_)) => "string or null",
                    (" or null", Value::Array(_)) => "list or null",
                    (" or null", _) => "object or null",
                    (kind, _) => kind,
                };
                let dot = if path.is_empty() { "" } else { "." };
                let path = format!("{path}{dot}{name}");
                rows.entry(path.clone())
                    .or_insert([kind.to_owned(), doc.clone()]);
                self::rows(structs, value, &path, rows);
            }
        }
        _ => {}
    }
}

/// Writes what the examples read: a scene with a coarse mesh, and the table of a sweep whose runs have failed.
fn prepare(folder: &Path) {
    let coarse = [("nodes", 16.0), ("time.tolerance", 1e-3)];
    let coarse = coarse.map(|(key, value)| (Parameter::named(key).unwrap(), value));
    let scene = Scene::load("periodic-2deg").unwrap();
    let scene = scene.with_values(&coarse).unwrap();
    fs::write(folder.join("coarse.toml"), scene.text).unwrap();
    let plan = paper_plan(Scene::load("paper").unwrap(), Start::Fresh);
    let points = (0..plan.len()).map(|index| SweepPoint {
        place: plan.place(index),
        outcome: Err("not simulated".to_owned()),
    });
    let mut points: Vec<SweepPoint> = points.collect();
    fs::create_dir(folder.join("paper")).unwrap();
    let table = folder.join("paper/sweep.arrow");
    write_table(&table, &plan, &mut points).unwrap();
}

/// The JSON result of an example.
fn result(folder: &Path, words: &str) -> Value {
    let mut command = Command::new(env!("CARGO_BIN_EXE_squeakscope"));
    command.current_dir(folder).args(words.split(' '));
    command.arg("--force");
    if !words.contains("--json") {
        command.args(["--json", "a.json"]);
    }
    command.assert().success();
    let document: Value =
        serde_json::from_slice(&fs::read(folder.join("a.json")).unwrap()).unwrap();
    let command = words.split(' ').next().unwrap();
    assert_eq!(read_back(command, &document).unwrap(), document, "{words}");
    document
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
        sample_rate: 44_100,
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

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

const HEAD: &str = "# JSON

`--json FILE` writes the result of a command for other programs: the result struct in SI units, with the
version of the program, the name of the scene and the list of written files. The name of a field ends
with the unit of its number. A field without a unit is a count, a share (0 to 1), or has the unit given
in its meaning. Non-finite numbers are `null`. Later versions may add fields; the meaning of a field does
not change. Fields that do not apply to a scene are `null` or absent.

A test generates this page from real results and the documentation of their types, and checks that it is current.
It also reads each result as its Rust type and compares what that writes. `merge` writes the same fields as
`sweep`.
";

#[test]
fn the_guide_lists_every_field_of_every_result() {
    let folder = tempfile::tempdir().unwrap();
    prepare(folder.path());
    write_sound(&folder.path().join("sound.wav"));
    write_friction(&folder.path().join("measured.csv"));
    let structs = structs();
    let mut page = HEAD.to_owned();
    let mut undescribed = BTreeSet::new();
    for (command, example) in EXAMPLES {
        let mut found = BTreeMap::new();
        rows(&structs, &result(folder.path(), example), "", &mut found);
        assert!(found.len() > 3, "{command}");
        page +=
            &format!("\n## `squeakscope {command}`\n\n| field | type | meaning |\n|---|---|---|\n");
        for (path, [kind, doc]) in found {
            if doc.is_empty() {
                undescribed.insert(path.clone());
            }
            page += &format!("| `{path}` | {kind} | {doc} |\n");
        }
    }
    assert!(
        undescribed.is_empty(),
        "without documentation: {undescribed:?}"
    );
    let file = root().join("src/guide/reference/json.md");
    if std::env::var_os("UPDATE_GUIDE").is_some() {
        fs::write(&file, &page).unwrap();
    }
    let there = fs::read_to_string(&file).unwrap_or_default();
    let differs = page
        .lines()
        .zip(there.lines())
        .find(|(new, old)| new != old);
    assert!(
        differs.is_none() && page.len() == there.len(),
        "src/guide/reference/json.md is out of date; UPDATE_GUIDE=1 rewrites it: {differs:?}"
    );
}
