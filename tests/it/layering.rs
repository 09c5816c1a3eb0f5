//! The house's walls: which room may look into which.

use std::fs;
use std::path::{Path, PathBuf};

/// Rooms, and the rooms that each may use.
const EDGES: &[(&str, &[&str])] = &[
    ("fem", &[]),
    ("dynamics", &[]),
    ("memory", &[]),
    ("analysis", &["memory"]),
    ("numpy", &["memory"]),
    ("foreign", &[]),
    ("joint", &["fem", "dynamics", "numpy"]),
    ("systems", &["dynamics"]),
    (
        "scene",
        &["fem", "joint", "systems", "dynamics", "analysis", "numpy"],
    ),
    (
        "pipeline",
        &["fem", "joint", "systems", "dynamics", "analysis", "scene"],
    ),
    ("export", &["joint", "pipeline", "numpy"]),
    ("import", &["memory", "numpy"]),
    (
        "record",
        &[
            "fem", "joint", "analysis", "dynamics", "pipeline", "scene", "export", "foreign",
            "import", "study", "plot",
        ],
    ),
    (
        "study",
        &[
            "fem", "joint", "systems", "dynamics", "analysis", "scene", "pipeline", "export",
            "foreign", "import", "memory",
        ],
    ),
    // Results in, figures out: no figure computes, and none knows where it is shown.
    ("plot", &["fem", "joint", "analysis", "dynamics", "study"]),
    ("sound", &["pipeline", "export"]),
    (
        "live",
        &["joint", "scene", "pipeline", "record", "sound", "study"],
    ),
    (
        "cli",
        &[
            "fem", "joint", "systems", "dynamics", "analysis", "scene", "pipeline", "record",
            "study", "export", "foreign", "import", "plot", "sound", "live",
        ],
    ),
];

/// The Rust files of a folder and those below it, without tests.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && !is_test(&path) {
            found.extend(rust_files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") && !is_test(&path) {
            found.push(path);
        }
    }
    found
}

fn is_test(path: &Path) -> bool {
    path.iter()
        .any(|part| part.to_string_lossy().contains("tests"))
}

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// The code of a file, without comments and without its tests.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let text = text.split("#[cfg(test)]").next().unwrap();
    text.lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn rooms_look_only_where_they_may() {
    let mut seen = 0;
    for (room, allowed) in EDGES {
        for file in rust_files(&source().join(room)) {
            if file
                .file_stem()
                .unwrap()
                .to_string_lossy()
                .contains("tests")
            {
                continue;
            }
            let code = code(&file);
            for (other, _) in EDGES {
                let used = code.contains(&format!("crate::{other}::"))
                    || code.contains(&format!("crate::{other};"));
                assert!(
                    !used || other == room || allowed.contains(other),
                    "{} uses `{other}`, which `{room}` may not",
                    file.display()
                );
                seen += usize::from(used);
            }
        }
    }
    assert!(
        seen > 10,
        "the search finds nothing: it no longer fits the code"
    );
}

#[test]
fn every_room_is_listed() {
    for entry in fs::read_dir(source()).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        if entry.path().is_dir() && name != "guide" {
            assert!(
                EDGES.iter().any(|(room, _)| *room == name),
                "`{name}` has no row"
            );
        }
    }
}

/// Rerun, clap, threads and the like have rooms of their own.
#[test]
fn foreign_things_stay_in_their_room() {
    for (what, home) in [
        ("rerun::", "record"),
        // Choices of figures are options as they are.
        ("clap::", "cli plot"),
        // A viewer may be stuck for ever, and so has a thread that can be left behind.
        ("std::thread", "pipeline study record live"),
        ("crossbeam_channel::", "pipeline study record"),
        ("arrow_array::", "foreign study"),
        ("arrow_ipc::", "foreign study"),
        ("serde_arrow::", "study"),
        ("csv::Writer", "study"),
        ("faer::", "fem joint"),
        ("realfft::", "analysis"),
        ("rustfft::", "analysis"),
        // The program makes the pool before any work: it may be refused.
        ("rayon::", "analysis cli"),
        ("npyz::", "numpy"),
        ("axum::", "live"),
        ("tokio::", "live"),
        ("ratatui::", "cli"),
        ("rubato::", "sound"),
    ] {
        for file in rust_files(&source()) {
            let path = file.strip_prefix(source()).unwrap().to_path_buf();
            let room = path.iter().next().unwrap().to_string_lossy().into_owned();
            let inside = home.split(' ').any(|home| home == room);
            assert!(
                inside || !code(&file).contains(what),
                "{} uses {what}",
                path.display()
            );
        }
    }
}
