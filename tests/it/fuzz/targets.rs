//! Targets: every reader of untrusted files.

use std::fs;
use std::path::Path;

use squeakscope::import::{Selection, read_signal};
use squeakscope::live::Command;
use squeakscope::numpy::read_npz;
use squeakscope::record::{paths, read_series};
use squeakscope::scene::Scene;
use squeakscope::study::sweep::read_table;

use super::corpus;
use crate::damage::Desk;

/// Kind of content, which determines the damage.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    /// Binary data.
    Binary,
    /// Text, damaged by tokens and by bytes.
    Text,
    /// An Ogg file, damaged also with correct checksums.
    Ogg,
    /// A zip archive, damaged as a whole and file by file, since its checksums hide most damage from the
    /// reader.
    Archive,
}

/// A reader.
pub struct Target {
    pub name: &'static str,
    /// Extension of its files.
    pub extension: &'static str,
    pub kind: Kind,
    /// Number of mutants in the standard tests.
    pub usual: u64,
    /// Undamaged files.
    pub corpus: fn(&Desk) -> Vec<Vec<u8>>,
    /// Reads a file or returns the error message. Panics if the result violates a guarantee.
    pub read: fn(&Path) -> Result<(), String>,
}

#[rustfmt::skip]
pub const TARGETS: &[Target] = &[
    Target { name: "WAV", extension: "wav", kind: Kind::Binary, usual: 1500, corpus: corpus::wav, read: signal },
    Target { name: "CSV", extension: "csv", kind: Kind::Text, usual: 1500, corpus: corpus::csv, read: signal },
    Target { name: "oscilloscopes", extension: "csv", kind: Kind::Text, usual: 1500, corpus: corpus::oscilloscopes, read: signal },
    Target { name: "FLAC", extension: "flac", kind: Kind::Binary, usual: 400, corpus: corpus::flac, read: signal },
    Target { name: "MP3", extension: "mp3", kind: Kind::Binary, usual: 400, corpus: corpus::mp3, read: signal },
    Target { name: "Ogg", extension: "ogg", kind: Kind::Ogg, usual: 150, corpus: corpus::ogg, read: signal },
    Target { name: "MP4", extension: "m4a", kind: Kind::Binary, usual: 400, corpus: corpus::mp4, read: signal },
    Target { name: "universal", extension: "uff", kind: Kind::Text, usual: 800, corpus: corpus::universal, read: signal },
    Target { name: "AIFF", extension: "aiff", kind: Kind::Binary, usual: 400, corpus: corpus::aiff, read: signal },
    Target { name: "MATLAB", extension: "mat", kind: Kind::Binary, usual: 800, corpus: corpus::matlab, read: signal },
    Target { name: "npy", extension: "npy", kind: Kind::Binary, usual: 1500, corpus: corpus::npy, read: bare_signal },
    Target { name: "npz", extension: "npz", kind: Kind::Archive, usual: 1500, corpus: corpus::npz, read: signal },
    Target { name: "arrays", extension: "npz", kind: Kind::Archive, usual: 1500, corpus: corpus::npz, read: arrays },
    Target { name: "rrd", extension: "rrd", kind: Kind::Binary, usual: 200, corpus: corpus::recordings, read: series },
    Target { name: "Arrow", extension: "arrow", kind: Kind::Binary, usual: 400, corpus: corpus::table, read: table },
    Target { name: "Parquet", extension: "parquet", kind: Kind::Binary, usual: 400, corpus: corpus::parquet, read: table },
    Target { name: "scene", extension: "toml", kind: Kind::Text, usual: 1500, corpus: corpus::scenes, read: scene },
    Target { name: "modes", extension: "npz", kind: Kind::Archive, usual: 400, corpus: corpus::modes, read: modes },
    Target { name: "commands", extension: "json", kind: Kind::Text, usual: 1500, corpus: corpus::commands, read: command },
];

fn selected(path: &Path, rate: Option<f64>) -> Result<(), String> {
    let selection = Selection {
        // The first column.
        column: Some("0".to_owned()),
        rate,
        ..Selection::default()
    };
    let signal = read_signal(path, &selection).map_err(|error| error.to_string())?;
    assert!(!signal.samples.is_empty() && signal.rate > 0.0);
    assert!(signal.samples.iter().all(|sample| sample.is_finite()));
    Ok(())
}

fn signal(path: &Path) -> Result<(), String> {
    selected(path, None)
}

/// A file without a clock.
fn bare_signal(path: &Path) -> Result<(), String> {
    selected(path, Some(48e3))
}

fn arrays(path: &Path) -> Result<(), String> {
    for (name, array) in read_npz(path).map_err(|error| error.to_string())? {
        let count: usize = array.shape.iter().product();
        assert_eq!(array.values.len(), count, "{name}");
    }
    Ok(())
}

fn series(path: &Path) -> Result<(), String> {
    let series = read_series(path, Some(paths::DISPLACEMENT))
        .or_else(|_| read_series(path, None))
        .map_err(|error| error.to_string())?;
    assert_eq!(series.times.len(), series.values.len());
    assert!(series.times.is_sorted());
    Ok(())
}

fn table(path: &Path) -> Result<(), String> {
    let table = read_table(path);
    table.map(drop).map_err(|error| error.to_string())
}

fn scene(path: &Path) -> Result<(), String> {
    let text = fs::read(path).expect("written");
    let scene = Scene::parse("fuzz", text).map_err(|error| error.to_string())?;
    let again = Scene::parse("fuzz", &scene.text).expect("the text of a scene is one");
    assert!(again == scene, "{scene:?}\n{again:?}");
    Ok(())
}

/// The modes that a scene reads from a file.
fn modes(path: &Path) -> Result<(), String> {
    let scene = path.with_file_name(corpus::SCENE_OF_MODES);
    let scene = Scene::load(scene.to_str().expect("text"));
    scene.map(drop).map_err(|error| error.to_string())
}

fn command(path: &Path) -> Result<(), String> {
    let text = fs::read(path).expect("written");
    let command: Command = serde_json::from_slice(&text).map_err(|error| error.to_string())?;
    let text = serde_json::to_string(&command).expect("JSON");
    let again = serde_json::from_str::<Command>(&text);
    assert!(again.is_ok(), "{text}: {again:?}");
    Ok(())
}
