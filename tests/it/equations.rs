//! Each implemented equation of the paper has one documented implementation.

use std::fs;
use std::path::Path;

/// Equations of the paper and the files that implement them.
const IMPLEMENTATIONS: &[(u32, &str)] = &[
    (1, "joint/contact_force.rs"),
    (2, "joint/contact_force.rs"),
    (3, "joint/contact_force.rs"),
    (4, "joint/nodes.rs"),
    (5, "joint/friction.rs"),
    (6, "joint/contact_force.rs"),
    (7, "joint/nodes.rs"),
    (8, "joint/contact_force.rs"),
    (9, "dynamics/system.rs"),
    (10, "dynamics/system.rs"),
    (11, "dynamics/switching.rs"),
    (12, "dynamics/switching.rs"),
    (13, "dynamics/switching.rs"),
    (14, "dynamics/switching.rs"),
    (15, "dynamics/tangents/saltation.rs"),
    (16, "dynamics/tangents/saltation.rs"),
    (17, "joint/switching.rs"),
    (18, "joint/contact.rs"),
    (19, "dynamics/switching.rs"),
    (20, "dynamics/system.rs"),
    (21, "dynamics/tangents/mod.rs"),
    (22, "dynamics/tangents/mod.rs"),
    (23, "dynamics/lyapunov/growth.rs"),
    (24, "joint/system.rs"),
    (25, "analysis/delay/embedding.rs"),
    (26, "analysis/recurrence/plot.rs"),
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
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    headings(&root, &mut found, &root);
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
