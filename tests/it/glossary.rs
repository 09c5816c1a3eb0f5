//! Names are words of the field: the name of every public type and of every JSON field is a term of the guide's
//! glossary, `src/guide/reference/glossary.md`, or plain English of its documentation.
//!
//! A name passes if each of its words is part of a glossary term in the name, or occurs in the first sentence of
//! the documentation. The unit at the end of a field's name does not count. Other names need a reason in
//! [`TYPES`] or [`FIELDS`]; a reason that is no longer needed fails.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::{Attribute, Item, Visibility};

use crate::json;

/// The glossary, a table `| term | meaning | reference |`.
const PAGE: &str = "src/guide/reference/glossary.md";

/// Words that every reader of Rust knows.
const RUST: [&str; 3] = ["error", "spec", "args"];

/// Abbreviations in names, and the words of the documentation.
const ABBREVIATIONS: [(&str, &str); 4] = [
    ("min", "minimum"),
    ("max", "maximum"),
    ("eval", "evaluation"),
    ("rms", "root-mean-square"),
];

/// Units at the end of a field's name.
const UNITS: &[&str] = &[
    "s", "ms", "us", "m", "mm", "um", "hz", "khz", "rad", "deg", "n", "pa", "mpa", "gpa", "j",
    "kg", "w", "per", "bytes", "mb", "samples", "db",
];

/// Public types with another name, and why.
const TYPES: &[(&str, &str)] = &[];

/// JSON fields with another name, and why.
const FIELDS: &[(&str, &str)] = &[];

/// A name and the first sentence of its documentation.
type Named = (String, String);

/// The terms of the glossary, as words in the singular.
fn terms(page: &str) -> BTreeSet<Vec<String>> {
    let rows = page
        .lines()
        .filter_map(|line| line.trim().strip_prefix('|'));
    let first = rows.filter_map(|row| row.split('|').next());
    let terms = first.flat_map(|cell| cell.split([',', '/', ';', '(', ')']));
    terms.map(words).filter(|term| !term.is_empty()).collect()
}

/// The words of a text or a name, each reduced to its stem.
fn words(text: &str) -> Vec<String> {
    let mut spread = String::new();
    let mut before = [' '; 2];
    for c in text.chars() {
        let starts = c.is_uppercase() && (before[1].is_lowercase() || before[1].is_numeric());
        // The last capital of an acronym starts a word: `RMSValue`.
        if c.is_lowercase() && before.iter().all(|c| c.is_uppercase()) {
            let last = spread.pop();
            spread.push(' ');
            spread.extend(last);
        }
        if starts {
            spread.push(' ');
        }
        spread.extend(c.to_lowercase());
        before = [before[1], c];
    }
    let words = spread.split(|c: char| !c.is_alphanumeric());
    words.filter(|word| !word.is_empty()).map(stem).collect()
}

/// Endings of plural, verb forms, and nouns made of verbs, longer ones first.
const ENDINGS: [&str; 15] = [
    "ations", "ation", "ators", "ator", "ings", "ing", "ions", "ion", "ers", "er", "ies", "ed",
    "es", "is", "s",
];

/// A word without its ending, so that `analysis`, `analyser` and `analysed` are equal.
fn stem(word: &str) -> String {
    let word = word.replace("colour", "color").replace('é', "e");
    let cut = |ending: &&str| word.strip_suffix(*ending).filter(|rest| rest.len() > 2);
    let rest = match word.ends_with("ss") || word.ends_with("us") {
        true => &word[..],
        false => ENDINGS.iter().find_map(cut).unwrap_or(&word),
    };
    let rest = rest
        .strip_suffix(['e', 'y'])
        .filter(|rest| rest.len() > 2)
        .unwrap_or(rest);
    // `stopped` is a form of `stop`.
    match rest.as_bytes() {
        [.., a, b] if a == b && rest.len() < word.len() && rest.len() > 3 => {
            rest[..rest.len() - 1].to_owned()
        }
        _ => rest.to_owned(),
    }
}

/// Whether a name is a term, or plain English of its documentation.
fn is_plain(name: &[String], doc: &str, terms: &BTreeSet<Vec<String>>) -> bool {
    let doc = words(doc);
    let is_known = |word: &String| {
        let long = ABBREVIATIONS
            .iter()
            .filter(|(short, _)| stem(short) == *word);
        let is_long = |(_, long): &(&str, &str)| words(long).iter().all(|part| doc.contains(part));
        doc.contains(word) || RUST.map(stem).contains(word) || long.clone().any(is_long)
    };
    let mut from = 0;
    while from < name.len() {
        let mut ends = (from + 1..=name.len()).rev();
        match ends.find(|to| terms.contains(&name[from..*to])) {
            Some(to) => from = to,
            None if is_known(&name[from]) => from += 1,
            None => return false,
        }
    }
    true
}

/// The words of a field's name without its unit.
fn without_unit(name: &str) -> Vec<String> {
    let mut parts: Vec<&str> = name.split('_').collect();
    while parts.len() > 1 && parts.last().is_some_and(|last| UNITS.contains(last)) {
        parts.pop();
    }
    parts.iter().copied().flat_map(words).collect()
}

/// The first sentence of a text.
fn sentence(text: &str) -> String {
    let text = text.replace("Eq. ", "Eq ").replace("Fig. ", "Fig ");
    let end = text.find(". ").unwrap_or(text.len());
    text[..end].to_owned()
}

/// The public types of the source outside its tests.
fn types() -> Vec<Named> {
    let mut found = Vec::new();
    let mut open = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    while let Some(path) = open.pop() {
        if path
            .file_stem()
            .is_some_and(|stem| stem.to_string_lossy().contains("tests"))
        {
            continue;
        }
        if path.is_dir() {
            open.extend(
                fs::read_dir(&path)
                    .unwrap()
                    .map(|entry| entry.unwrap().path()),
            );
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            public_types(&syn::parse_file(&text).unwrap().items, &mut found);
        }
    }
    found
}

/// Collects public types, including those of modules within a file.
fn public_types(items: &[Item], found: &mut Vec<Named>) {
    for item in items {
        let (visibility, name, attributes) = match item {
            Item::Struct(item) => (&item.vis, &item.ident, &item.attrs),
            Item::Enum(item) => (&item.vis, &item.ident, &item.attrs),
            Item::Trait(item) => (&item.vis, &item.ident, &item.attrs),
            Item::Type(item) => (&item.vis, &item.ident, &item.attrs),
            Item::Mod(module) if !is_test(&module.attrs) => {
                let inside = module.content.as_ref().map(|(_, items)| &items[..]);
                public_types(inside.unwrap_or_default(), found);
                continue;
            }
            _ => continue,
        };
        if matches!(visibility, Visibility::Public(_)) && !is_test(attributes) {
            found.push((name.to_string(), sentence(&json::doc(attributes))));
        }
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        syn::Meta::List(list) => {
            list.path.is_ident("cfg") && list.tokens.to_string().contains("test")
        }
        _ => false,
    })
}

/// The fields of all serialised structs.
fn fields() -> Vec<Named> {
    let structs = json::structs().into_iter().flatten();
    structs
        .map(|(name, field)| (name, sentence(&field.doc)))
        .collect()
}

/// Names that fail, and exceptions that are not needed.
fn faults(
    names: &[Named],
    split: impl Fn(&str) -> Vec<String>,
    exceptions: &[(&str, &str)],
    terms: &BTreeSet<Vec<String>>,
) -> Vec<String> {
    let fails = |(name, doc): &&Named| !is_plain(&split(name), doc, terms);
    let failed: BTreeMap<&str, &str> = names
        .iter()
        .filter(fails)
        .map(|(name, doc)| (name.as_str(), doc.as_str()))
        .collect();
    let excepted: BTreeSet<&str> = exceptions.iter().map(|(name, _)| *name).collect();
    let wrong = failed.iter().filter(|(name, _)| !excepted.contains(**name));
    let wrong = wrong.map(|(name, doc)| {
        format!("`{name}` is neither a term of {PAGE} nor plain English of its doc: {doc}")
    });
    let unneeded = excepted.iter().filter(|name| !failed.contains_key(**name));
    let unneeded = unneeded.map(|name| format!("the exception `{name}` is not needed: remove it"));
    wrong.chain(unneeded).collect()
}

fn assert_terms(names: &[Named], split: impl Fn(&str) -> Vec<String>, exceptions: &[(&str, &str)]) {
    let faults = faults(names, split, exceptions, &glossary());
    assert!(
        faults.is_empty(),
        "{} names:\n{}",
        faults.len(),
        faults.join("\n")
    );
}

fn glossary() -> BTreeSet<Vec<String>> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(PAGE);
    terms(&fs::read_to_string(path).expect(PAGE))
}

#[test]
fn names_of_public_types_are_terms_or_plain_english() {
    let found = types();
    assert!(found.len() > 100, "{}", found.len());
    assert_terms(&found, words, TYPES);
}

#[test]
fn json_fields_are_terms_or_plain_english() {
    let found = fields();
    assert!(found.len() > 100, "{}", found.len());
    assert_terms(&found, without_unit, FIELDS);
}

#[test]
fn names_are_split_into_words_and_compared_by_stems() {
    assert_eq!(words("LyapunovSpectrum"), ["lyapunov", "spectrum"]);
    assert_eq!(
        words("FFTWindow2d of modes"),
        ["fft", "window2d", "of", "mod"]
    );
    assert_eq!(stem("frequencies"), stem("frequency"));
    assert_eq!(stem("stopped"), stem("stop"));
    assert_eq!(stem("settling"), stem("settled"));
    assert_eq!(stem("analysis"), stem("analysers"));
    assert_eq!(stem("assembly"), stem("assembled"));
    assert_ne!(stem("mass"), stem("mast"));
    assert_eq!(without_unit("rms_velocity_m_per_s"), words("RMS velocity"));
    assert_eq!(without_unit("s"), ["s"]);
}

#[test]
fn terms_docs_and_exceptions_count() {
    let terms = terms(
        "| term | meaning |\n|---|---|\n| `Lyapunov exponents`, LE | ... |\n| Poincaré section | ... |\n",
    );
    assert!(terms.contains(&words("LyapunovExponent")) && terms.contains(&words("le")));
    let plain = |name: &str, doc: &str| is_plain(&words(name), doc, &terms);
    assert!(
        plain("LyapunovExponent", "") && plain("LyapunovExponentPlan", "Plan of the averaging.")
    );
    assert!(plain("PlanError", "Error of a plan.") && !plain("Widget", "Controls a run."));
    let names = [
        ("Widget".to_owned(), String::new()),
        ("Plan".to_owned(), "A plan".to_owned()),
    ];
    let count = |exceptions| faults(&names, words, exceptions, &terms).len();
    assert_eq!(count(&[]), 1);
    assert_eq!(count(&[("Widget", "a test")]), 0);
    assert_eq!(count(&[("Widget", "a test"), ("Plan", "plain")]), 1);
}
