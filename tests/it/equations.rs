//! Each implemented equation of the paper has one documented implementation.

use std::fs;
use std::path::Path;

/// Equations of the paper and the files that implement them.
const IMPLEMENTATIONS: &[(u32, &str)] = &[
    (1, "crates/joint/src/contact_force.rs"),
    (2, "crates/joint/src/contact_force.rs"),
    (3, "crates/joint/src/contact_force.rs"),
    (4, "crates/joint/src/nodes.rs"),
    (5, "crates/joint/src/friction.rs"),
    (6, "crates/joint/src/contact_force.rs"),
    (7, "crates/joint/src/nodes.rs"),
    (8, "crates/joint/src/contact_force.rs"),
    (9, "crates/dynamics/src/system.rs"),
    (10, "crates/dynamics/src/system.rs"),
    (11, "crates/dynamics/src/switching.rs"),
    (12, "crates/dynamics/src/switching.rs"),
    (13, "crates/dynamics/src/switching.rs"),
    (14, "crates/dynamics/src/switching.rs"),
    (15, "crates/dynamics/src/tangents/saltation.rs"),
    (16, "crates/dynamics/src/tangents/saltation.rs"),
    (17, "crates/joint/src/switching.rs"),
    (18, "crates/joint/src/switching.rs"),
    (19, "crates/dynamics/src/switching.rs"),
    (20, "crates/dynamics/src/system.rs"),
    (21, "crates/dynamics/src/tangents/mod.rs"),
    (22, "crates/dynamics/src/tangents/mod.rs"),
    (23, "crates/dynamics/src/lyapunov/growth.rs"),
    (24, "crates/joint/src/system.rs"),
    (25, "crates/analysis/src/delay/embedding.rs"),
    (26, "crates/analysis/src/recurrence/recurrences.rs"),
];

fn headings(folder: &Path, found: &mut Vec<(u32, String)>, root: &Path) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            headings(&path, found, root);
            continue;
        }
        let place = path
            .strip_prefix(root)
            .unwrap()
            .to_string_lossy()
            .into_owned();
        for line in fs::read_to_string(&path).unwrap().lines() {
            let Some(doc) = line.trim_start().strip_prefix("/// Eq. (") else {
                continue;
            };
            if let Some((number, _)) = doc.split_once("):") {
                found.push((number.parse().unwrap(), place.clone()));
            }
        }
    }
}

#[test]
fn every_equation_is_implemented_once() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    for folder in ["src", "crates"] {
        headings(&root.join(folder), &mut found, root);
    }
    for (number, file) in IMPLEMENTATIONS {
        let places: Vec<_> = found
            .iter()
            .filter(|(n, _)| n == number)
            .map(|(_, p)| p)
            .collect();
        assert_eq!(places, [file], "Eq. ({number})");
    }
    for (number, place) in &found {
        assert!(
            IMPLEMENTATIONS.iter().any(|(n, _)| n == number),
            "Eq. ({number}) in {place} is not listed"
        );
    }
}
