//! The content of a recording, read back from the file.

use std::{
    collections::BTreeMap,
    fs::File,
    io::BufReader,
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

use crate::record::sdk::{
    EntityPath,
    external::{
        re_log_encoding::DecoderApp,
        re_log_types::{EntityPathFilter, EntityPathSubs, ResolvedEntityPathFilter},
    },
    log::{Chunk, LogMsg},
};

use super::{
    APPLICATION, Output, RecordError, RerunSink, blueprint, encode::Encoder, file, paths, stream,
};
use crate::pipeline::{
    Monitor, Sink,
    message::{Header, Health, JointInfo, Record, Subject},
    run,
};
use crate::scene::Scene;

pub mod demo;
mod files;
mod shown;

/// The content of an entity.
#[derive(Clone, Debug, Default)]
pub(super) struct Entity {
    /// Number of rows on the timeline.
    pub rows: usize,
    /// First and last time, ns.
    pub range: Option<(i64, i64)>,
    /// Names of the components.
    pub components: Vec<String>,
}

/// Reads a recording with one timeline: its entities by path, and the number of chunks of its blueprint.
pub(super) fn read(path: &Path, timeline: &'static str) -> (BTreeMap<String, Entity>, usize) {
    let mut entities = BTreeMap::<String, Entity>::new();
    let mut blueprint = 0;
    let file = BufReader::new(File::open(path).unwrap());
    for message in DecoderApp::decode_lazy(file) {
        let LogMsg::ArrowMsg(store, message) = message.unwrap() else {
            continue;
        };
        if store.is_blueprint() {
            blueprint += 1;
            continue;
        }
        let chunk = Chunk::from_arrow_msg(&message).unwrap();
        let path = chunk.entity_path().to_string();
        let entity = entities
            .entry(path.trim_start_matches('/').to_owned())
            .or_default();
        let names = chunk.components().keys().map(ToString::to_string);
        entity.components.extend(names);
        if let Some(times) = chunk.timelines().get(&timeline.into()) {
            entity.rows += chunk.num_rows();
            let range = times.time_range();
            let (min, max) = (range.min().as_i64(), range.max().as_i64());
            let so_far = entity.range.get_or_insert((min, max));
            *so_far = (so_far.0.min(min), so_far.1.max(max));
        }
        assert!(
            chunk.timelines().len() <= 1,
            "{}: more than one timeline",
            chunk.entity_path()
        );
    }
    (entities, blueprint)
}

/// The views of the layout of a recording: their names and the entities that they show.
fn views(path: &Path) -> Vec<(String, ResolvedEntityPathFilter)> {
    let texts = |chunk: &Chunk, component: &str| -> Vec<String> {
        let components = chunk.components().keys().copied();
        let mut components = components.filter(|name| name.to_string().ends_with(component));
        let rows = components
            .next()
            .map(|name| chunk.iter_slices::<String>(name));
        let rows = rows.into_iter().flatten().flatten();
        rows.map(|text| text.to_string()).collect()
    };
    let mut views: BTreeMap<String, [Vec<String>; 3]> = BTreeMap::new();
    let file = BufReader::new(File::open(path).unwrap());
    for message in DecoderApp::decode_lazy(file) {
        let LogMsg::ArrowMsg(store, message) = message.unwrap() else {
            continue;
        };
        let chunk = Chunk::from_arrow_msg(&message).unwrap();
        let path = chunk.entity_path().to_string();
        let Some(view) = path.strip_prefix("/view/").filter(|_| store.is_blueprint()) else {
            continue;
        };
        let id = view.split('/').next().unwrap_or_default();
        let [name, origin, query] = views.entry(id.to_owned()).or_default();
        name.extend(texts(&chunk, ":display_name"));
        origin.extend(texts(&chunk, ":space_origin"));
        query.extend(texts(&chunk, "ViewContents:query"));
    }
    let resolved = views.into_values().map(|[name, origin, query]| {
        let origin = EntityPathSubs::new_with_origin(&EntityPath::from(origin.concat()));
        let filter = EntityPathFilter::parse_forgiving(query.join("\n"));
        (name.concat(), filter.resolve_forgiving(&origin))
    });
    resolved.collect()
}

/// The entities of a recording.
fn entities(path: &Path, timeline: &'static str) -> Vec<EntityPath> {
    let (entities, _) = read(path, timeline);
    let named = entities
        .keys()
        .filter(|path| !path.starts_with("__properties"));
    named.map(|path| EntityPath::from(path.as_str())).collect()
}

/// Every view of a recording shows at least one entity.
fn assert_no_view_is_empty(path: &Path, timeline: &'static str) {
    let (views, entities) = (views(path), entities(path, timeline));
    assert!(!views.is_empty());
    for (name, filter) in &views {
        let shows = entities.iter().any(|entity| filter.matches(entity));
        assert!(shows, "the view {name:?} is empty");
    }
}

/// Every view of a recording shows at least one entity, and every entity is shown by a view.
pub(super) fn assert_shown(path: &Path, timeline: &'static str) {
    assert_no_view_is_empty(path, timeline);
    let views = views(path);
    for entity in &entities(path, timeline) {
        let is_shown = views.iter().any(|(_, filter)| filter.matches(entity));
        assert!(is_shown, "no view shows {entity}");
    }
}

fn to_file(path: impl Into<PathBuf>) -> Output {
    Output {
        save: Some(path.into()),
        ..Output::default()
    }
}

/// Records a synthetic run of `duration` s.
fn record(path: &Path, duration: f64) {
    let mut sink = RerunSink::new(&to_file(path), demo::spec()).unwrap();
    for record in demo::records(duration) {
        sink.accept(record).unwrap();
    }
    sink.finish().unwrap();
}

#[test]
fn a_signal_is_drawn_without_a_joint() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("signal.rrd");
    let duration = 0.05;
    let mut sink = RerunSink::new(&to_file(&path), demo::spec()).unwrap();
    for record in demo::signal_records(duration) {
        sink.accept(record).unwrap();
    }
    sink.finish().unwrap();
    assert_no_view_is_empty(&path, paths::TIMELINE);
    let (entities, _) = read(&path, paths::TIMELINE);
    assert_eq!(entities[paths::WAVEFORM].rows, demo::samples(duration));
    for name in entities.keys() {
        let folder = name.split('/').next().unwrap_or_default();
        let of_a_joint = [
            "joint",
            "modes",
            "energy",
            "contact",
            "probe",
            "solver",
            "phase_portrait",
        ];
        assert!(!of_a_joint.contains(&folder), "{name}");
    }
}

/// A run with one analysis: the views of others would be empty.
#[test]
fn only_views_of_enabled_analyses_exist() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plain.rrd");
    let full = Scene::load("doubled-torus-3deg").unwrap();
    let mut scene = full.with_duration(100.0).unwrap();
    let spectrum = scene.analysis.spectrum;
    scene = scene.without_analyses();
    scene.analysis.spectrum = spectrum;
    let mut sink = RerunSink::new(&to_file(&path), scene.record).unwrap();
    run(&scene, "", &mut sink, Monitor::default()).unwrap();
    assert_no_view_is_empty(&path, paths::TIMELINE);
}

#[test]
fn a_recording_contains_all_samples_and_pictures_with_their_times() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    let duration = 0.05;
    record(&path, duration);
    assert_shown(&path, paths::TIMELINE);
    let (entities, _) = read(&path, paths::TIMELINE);
    let samples = demo::samples(duration);
    for path in [
        paths::DISPLACEMENT,
        paths::VELOCITY,
        paths::MODES_Q,
        paths::MODES_QDOT,
    ] {
        let entity = &entities[path];
        assert_eq!(entity.rows, samples, "{path}");
        let last = (1e9 * (samples - 1) as f64 / demo::SAMPLE_RATE).round() as i64;
        assert_eq!(entity.range, Some((0, last)), "{path}");
    }
    let frames = samples / 256;
    let snapshots = frames * 256usize.div_ceil(10);
    for path in [
        paths::FRICTION,
        paths::NODES,
        paths::NODE_COUNTS,
        paths::CONTACT_FORCE,
        paths::MODES_ENERGY,
        paths::ENERGY,
        paths::PORTRAIT_NOW,
    ] {
        // The tilt changes with every frame of this run, so the geometry of nodes and arrows is logged once a
        // frame.
        let moves = [paths::FRICTION, paths::NODES].contains(&path);
        let expected = snapshots + if moves { frames } else { 0 };
        assert_eq!(entities[path].rows, expected, "{path}");
    }
    assert_eq!(entities[paths::TILT].rows, frames);
    let pictures = (duration * demo::spec().body_rate).ceil() as usize;
    assert!(entities[paths::BODY].rows.abs_diff(pictures) <= 1);
    assert_eq!(entities[paths::PERTURBED_DISPLACEMENT].rows, samples);
    // The fitted line has two points.
    assert_eq!(entities[paths::DIVERGENCE_FIT].rows, 2);
    for path in ["reference", "perturbed"].map(|name| format!("divergence/phase_portrait/{name}")) {
        assert_eq!(entities[&path].rows, frames, "{path}");
    }
    // The last column is within one window of the end, and so is the last tile.
    let last = &entities[&paths::spectrogram_tile(39)];
    assert!(last.range.unwrap().1 > (0.97 * duration * 1e9) as i64);
}

#[test]
fn a_recording_contains_versions_scene_and_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    record(&path, 0.005);
    let (entities, _) = read(&path, paths::TIMELINE);
    let run = entities
        .iter()
        .find(|(path, _)| path.contains("properties") && path.ends_with(paths::RUN_PROPERTY));
    let (_, run) = run.expect("the run's properties");
    for field in [
        "scene",
        "scene_text",
        "command",
        "squeakscope_version",
        "rerun_version",
    ] {
        assert!(
            run.components
                .iter()
                .any(|c| c.ends_with(&format!(":{field}"))),
            "{field} in {:?}",
            run.components
        );
    }
}

#[test]
fn the_stated_rerun_version_is_the_linked_one() {
    let linked = crate::record::sdk::build_info().version.to_string();
    assert_eq!(linked, super::RERUN_VERSION);
}

#[test]
fn a_recording_of_100_ms_is_small() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    let records = demo::records(0.1);
    let mut sink = RerunSink::new(&to_file(&path), demo::spec()).unwrap();
    let start = Instant::now();
    for record in records {
        sink.accept(record).unwrap();
    }
    let encoding = start.elapsed();
    sink.finish().unwrap();
    let size = std::fs::metadata(&path).unwrap().len();
    println!(
        "{:.1} MB, {:.0} ms to encode, {:.0} ms in total",
        1e-6 * size as f64,
        1e3 * encoding.as_secs_f64(),
        1e3 * start.elapsed().as_secs_f64()
    );
    assert!(size < 30_000_000, "{size} bytes");
}

/// Writes longer synthetic runs for inspection, one file for each tab of the layout, into a folder:
/// `SQUEAKSCOPE_DEMO=folder cargo test demo_files`.
#[test]
fn demo_files() {
    let Some(folder) = std::env::var_os("SQUEAKSCOPE_DEMO").map(PathBuf::from) else {
        return;
    };
    for (name, tabs, records) in [
        ("joint", 8, demo::records(0.3)),
        ("signal", 5, demo::signal_records(0.3)),
    ] {
        for tab in 0..tabs {
            let path = folder.join(format!("{name}_{tab}.rrd"));
            let draw = |rec: &stream::RecordingStream| {
                let mut encoder = None;
                for record in &records {
                    if let Record::Header(header) = record {
                        blueprint::send(rec, header, demo::spec(), tab);
                        encoder = Some(Encoder::new(rec, Arc::clone(header), demo::spec()));
                    }
                    encoder.as_mut().unwrap().accept(rec, record);
                }
                encoder.unwrap().finish(rec);
            };
            file::save(&path, APPLICATION, draw).unwrap();
        }
    }
}

/// The series of load and rotation exist only if these vary.
#[test]
fn load_and_rotation_are_recorded_if_they_vary() {
    let folder = tempfile::tempdir().unwrap();
    let series = |load_span: [f64; 2], rotation_span: [f64; 2]| {
        let path = folder.path().join("run.rrd");
        let mut sink = RerunSink::new(&to_file(&path), demo::spec()).unwrap();
        for record in demo::records(0.01) {
            let record = match record {
                Record::Header(header) => {
                    let subject = Subject::Joint(JointInfo {
                        load_span,
                        rotation_span,
                        ..demo::joint()
                    });
                    let header = (*header).clone();
                    Record::Header(Arc::new(Header { subject, ..header }))
                }
                other => other,
            };
            sink.accept(record).unwrap();
        }
        sink.finish().unwrap();
        let (entities, _) = read(&path, paths::TIMELINE);
        let rows = |path: &str| entities.get(path).map_or(0, |entity| entity.rows);
        [paths::TILT, paths::LOAD_NOW, paths::ROTATION_FACTOR].map(rows)
    };
    let [tilts, load, rotation] = series([150.0; 2], [1.0; 2]);
    assert!(tilts > 0);
    assert_eq!([load, rotation], [0, 0]);
    assert_eq!(series([100.0, 150.0], [1.0; 2]), [tilts, tilts, 0]);
    assert_eq!(series([150.0; 2], [0.5, 2.0]), [tilts, 0, tilts]);
}

#[test]
fn frames_of_one_tilt_log_their_nodes_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    let mut sink = RerunSink::new(&to_file(&path), demo::spec()).unwrap();
    let mut geometry = None;
    let mut snapshots = 0;
    for record in demo::records(0.01) {
        let record = match record {
            Record::Samples(frame) => {
                let mut frame = (*frame).clone();
                let shared = geometry.get_or_insert_with(|| Arc::clone(&frame.geometry));
                frame.geometry = Arc::clone(shared);
                snapshots += frame.patch.len();
                Record::Samples(Arc::new(frame))
            }
            other => other,
        };
        sink.accept(record).unwrap();
    }
    sink.finish().unwrap();
    assert_eq!(
        read(&path, paths::TIMELINE).0[paths::NODES].rows,
        snapshots + 1
    );
}

/// The status of a mass on a belt is a band and the colour of its series.
#[test]
fn a_small_system_is_drawn_with_its_status() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("belt.rrd");
    let scene = Scene::load("mass-on-belt").unwrap();
    let mut sink = RerunSink::new(&to_file(&path), scene.record).unwrap();
    run(&scene, "", &mut sink, Monitor::default()).unwrap();
    assert_no_view_is_empty(&path, paths::TIMELINE);
    let (entities, _) = read(&path, paths::TIMELINE);
    let changes = entities[paths::STATUS].rows;
    assert!(changes > 30, "{changes}");
    let samples = scene.samples() as usize;
    for series in [paths::DISPLACEMENT, paths::VELOCITY] {
        assert_eq!(entities[series].rows, samples + changes, "{series}");
    }
    for absent in [
        paths::BODY,
        paths::NODES,
        paths::MODES_Q,
        paths::ENERGY,
        paths::TILT,
    ] {
        assert!(!entities.contains_key(absent), "{absent}");
    }
}
