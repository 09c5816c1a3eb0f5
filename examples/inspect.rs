//! Lists the entities of a recording with their numbers of rows and time ranges.
//!
//! Fails if an entity that every full run writes is missing or empty. Given a folder (default: the
//! current one), it first records 25 ms of `periodic-2deg` there and inspects that recording.
//!
//! ```text
//! cargo run --release --example inspect -- [FILE.rrd | FOLDER]
//! ```

use std::collections::BTreeMap;
use std::error::Error;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use re_log_encoding::DecoderApp;
use rerun::log::{Chunk, LogMsg};
use squeakscope::pipeline::{Monitor, run};
use squeakscope::record::{Output, RerunSink, paths};
use squeakscope::scene::Scene;

/// Entities of a run with all analyses, after a quarter of their windows is filled.
const EXPECTED: &[&str] = &[
    paths::ABOUT,
    paths::NARRATION,
    paths::LOG,
    paths::DISPLACEMENT,
    paths::VELOCITY,
    paths::TILT,
    paths::MODES_Q,
    paths::MODES_QDOT,
    paths::MODES_ENERGY,
    paths::ENERGY,
    paths::BODY,
    paths::LOAD,
    paths::ROTATION,
    paths::NODES,
    paths::FRICTION,
    paths::NODE_COUNTS,
    paths::CONTACT_FORCE,
    paths::PORTRAIT_TRAIL,
    "spectrum/curve",
    "recurrence/image",
    "delay/mutual_information/curve",
    "quantification/determinism",
    "poincare_section/points",
    "solver/real_time_factor",
    "solver/steps",
    "solver/energy_residual",
];

/// Contents of an entity.
#[derive(Default)]
struct Entity {
    /// Rows on the timeline.
    rows: usize,
    /// Static rows, valid at all times.
    fixed: usize,
    /// First and last time, ns.
    range: Option<(i64, i64)>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let given = PathBuf::from(std::env::args_os().nth(1).unwrap_or_else(|| ".".into()));
    let path = if given.is_dir() {
        record(&given)?
    } else {
        given
    };
    let entities = read(&path)?;

    println!("entity                       rows  static  simulated time in ms");
    for (name, Entity { rows, fixed, range }) in &entities {
        let ms = |ns: i64| format!("{:.3}", 1e-6 * ns as f64);
        let range = range.map_or(String::new(), |(a, b)| format!("{} to {}", ms(a), ms(b)));
        println!("{name:<25} {rows:>7} {fixed:>7}  {range}");
    }
    let is_present = |name: &&str| entities.get(*name).is_some_and(|e| e.rows + e.fixed > 0);
    let missing: Vec<_> = EXPECTED
        .iter()
        .filter(|name| !is_present(name))
        .copied()
        .collect();
    if !missing.is_empty() {
        return Err(format!(
            "{}: entities missing or empty: {}",
            path.display(),
            missing.join(", ")
        )
        .into());
    }
    println!(
        "all {} required entities are present, {} in total",
        EXPECTED.len(),
        entities.len()
    );
    Ok(())
}

/// Records a short run to a folder.
fn record(folder: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let path = folder.join("inspect.rrd");
    let scene = Scene::load("periodic-2deg")?.with_duration(25.0)?;
    let output = Output {
        save: Some(path.clone()),
        ..Output::default()
    };
    let mut sink = RerunSink::new(&output, scene.record)?;
    run(&scene, "example inspect", &mut sink, Monitor::default())?;
    Ok(path)
}

/// The entities of a recording, without its blueprint.
fn read(path: &Path) -> Result<BTreeMap<String, Entity>, Box<dyn Error>> {
    let mut entities = BTreeMap::<String, Entity>::new();
    let file = File::open(path).map_err(|fault| format!("{}: {fault}", path.display()))?;
    for message in DecoderApp::decode_lazy(BufReader::new(file)) {
        let LogMsg::ArrowMsg(store, message) = message? else {
            continue;
        };
        if store.is_blueprint() {
            continue;
        }
        let chunk = Chunk::from_arrow_msg(&message)?;
        let name = chunk.entity_path().to_string();
        let entity = entities
            .entry(name.trim_start_matches('/').to_owned())
            .or_default();
        if let Some(times) = chunk.timelines().get(&paths::TIMELINE.into()) {
            entity.rows += chunk.num_rows();
            let range = times.time_range();
            let (first, last) = (range.min().as_i64(), range.max().as_i64());
            let total = entity.range.get_or_insert((first, last));
            *total = (total.0.min(first), total.1.max(last));
        } else {
            entity.fixed += chunk.num_rows();
        }
    }
    Ok(entities)
}
