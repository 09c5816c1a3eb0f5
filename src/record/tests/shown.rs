//! Texts, colours and draw orders in a recording, and the escaping of names from files.

use std::{fs::File, io::BufReader, path::Path, sync::Arc};

use crate::record::sdk::{
    external::re_log_encoding::DecoderApp,
    log::{Chunk, LogMsg},
};

use super::demo;
use crate::pipeline::message::RunExponents;
use crate::pipeline::{
    Sink,
    message::{Header, Record, Subject},
};
use crate::plot::{Layer, RunPanels, shown};
use crate::record::branch::save_branch;
use crate::record::{Output, RerunSink};
use crate::report::{Report as _, agreement, markdown};
use crate::scene::{Parameter, Scene};
use crate::study::branch::{BranchPlan, OrbitStarts};

/// The chunks of a recording and its blueprint.
fn chunks(path: &Path) -> Vec<Chunk> {
    let messages = DecoderApp::decode_lazy(BufReader::new(File::open(path).unwrap()));
    let chunks = messages.filter_map(|message| match message.unwrap() {
        LogMsg::ArrowMsg(_, message) => Some(Chunk::from_arrow_msg(&message).unwrap()),
        _ => None,
    });
    chunks.collect()
}

/// All texts of a recording and its blueprint, with the names of their components.
fn texts(path: &Path) -> Vec<(String, String)> {
    let mut texts = Vec::new();
    for chunk in chunks(path) {
        for &name in chunk.components().keys() {
            let rows = chunk.iter_slices::<String>(name).flatten();
            texts.extend(rows.map(|text| (name.to_string(), text.to_string())));
        }
    }
    texts
}

/// The viewer draws images with the same draw order at the same depth, where they hide each other's edges.
#[test]
fn each_tile_of_a_spectrogram_has_its_own_draw_order() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    super::record(&path, 0.01);
    let mut orders = Vec::new();
    for chunk in chunks(&path) {
        let entity = chunk.entity_path().to_string();
        for &name in chunk.components().keys() {
            if entity.contains("/spectrogram/tile_") && name == "Image:draw_order" {
                let rows = chunk.iter_slices::<f32>(name).flatten();
                orders.extend(rows.map(|order| (entity.clone(), *order)));
            }
        }
    }
    orders.sort_by(|a, b| a.0.cmp(&b.0));
    assert_eq!(
        orders.len(),
        40,
        "one order per tile, for the whole recording"
    );
    assert!(orders.is_sorted_by(|a, b| a.1 < b.1), "{orders:?}");
    assert!(orders.iter().all(|(_, order)| *order < -2.0));
}

/// The series of one view are told apart by their colours.
#[test]
fn the_times_of_recurrence_have_different_colours() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    super::record(&path, 0.01);
    let series = [
        "quantification/period",
        "quantification/recurrence_time_1",
        "quantification/recurrence_time_2",
        "quantification/trapping_time",
    ];
    let mut colors: Vec<u32> = Vec::new();
    for chunk in chunks(&path) {
        let entity = chunk.entity_path().to_string();
        for &name in chunk.components().keys() {
            let is_series = series.contains(&entity.trim_start_matches('/'));
            if is_series && name == "SeriesLines:colors" {
                colors.extend(chunk.iter_slices::<u32>(name).flatten());
            }
        }
    }
    assert_eq!(colors.len(), 6, "three periods, T1, T2 and TT");
    colors.sort_unstable();
    assert!(colors.is_sorted_by(|a, b| a < b), "{colors:x?}");
}

/// The texts of orbits name the parameter as those of a sweep do, and every entity is shown.
#[test]
fn a_branch_names_its_parameter_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("branch.rrd");
    let scene = Scene::load("negative-slope").unwrap();
    let speed = Parameter::named("mass_on_belt.belt_speed_mm_per_s").unwrap();
    let plan = BranchPlan::new(scene.clone(), speed, [50.0, 200.0], 20);
    let starts = Some(OrbitStarts::Scene);
    let branch = plan
        .follow(starts, &mut |_, _| Ok(()), &mut |_| ())
        .unwrap();
    assert!(!branch.points.is_empty());
    save_branch(&path, &scene, &branch, "squeakscope branch test").unwrap();
    let texts = texts(&path);
    let is_orbit = |text: &str| text.starts_with("## Belt speed ") && text.contains("orbit");
    assert!(texts.iter().any(|(_, text)| is_orbit(text)));
    let report = shown(&markdown(&branch.blocks(&scene.name)));
    assert!(texts.iter().any(|(_, text)| text.starts_with(&report)));
    let title = "Branch diagram: solid if the motion attracts, dashed if not";
    assert!(texts.iter().any(|(_, text)| text == title));
}

/// Names and texts from a file cannot contain control sequences or imitate the surrounding text. The scene's
/// text and the command are stored unchanged in the properties.
#[test]
fn names_and_texts_of_a_file_are_escaped() {
    const NAME: &str = "a\u{1b}[2J\u{9b}1m\u{202e}b\n# Faked ![x](http://x)`\n```\n# Out";
    let folder = tempfile::tempdir().unwrap();
    let name = || NAME.to_owned();
    for (file, records) in [
        ("joint.rrd", demo::records(0.01)),
        ("signal.rrd", demo::signal_records(0.01)),
    ] {
        let path = folder.path().join(file);
        let mut sink = RerunSink::new(
            &Output {
                save: Some(path.clone()),
                ..Output::default()
            },
            demo::spec(),
        )
        .unwrap();
        for record in records {
            let record = match record {
                Record::Header(header) => {
                    let mut header = Header::clone(&header);
                    (header.scene, header.title, header.about) = (name(), name(), name());
                    (header.scene_text, header.command) = (name(), name());
                    if let Subject::Signal(signal) = &mut header.subject {
                        (signal.source, signal.column, signal.unit) = (name(), name(), name());
                    }
                    Record::Header(Arc::new(header))
                }
                other => other,
            };
            sink.accept(record).unwrap();
        }
        sink.accept(Record::Warning {
            time: 0.0,
            text: name(),
        })
        .unwrap();
        sink.finish().unwrap();
        let texts = texts(&path);
        let (kept, shown): (Vec<_>, Vec<_>) = texts.into_iter().partition(|(component, _)| {
            component.ends_with(":scene_text") || component.ends_with(":command")
        });
        assert_eq!(kept.len(), 2);
        assert!(kept.iter().all(|(_, text)| text == NAME));
        let escaped = shown.iter().filter(|(_, text)| text.contains("\\u001b"));
        assert!(escaped.count() > 3, "{file} shows the names");
        for (component, text) in &shown {
            let hidden = |c: char| c.is_control() && c != '\n' || c == '\u{202e}';
            assert!(!text.contains(hidden), "{component}: {text:?}");
            let is_markdown = component.starts_with("TextDocument:");
            assert!(!is_markdown || !text.contains("!["), "{text:?}");
            // Only the description has several lines; a code fence is longer than any fence in it.
            let about = text.matches("\n# Faked").count();
            let code = text.matches("````toml\na").count();
            assert!(about <= 1 + code, "{component}: {text:?}");
        }
    }
}

/// The intervals of the exponents so far are within their axis.
#[test]
fn the_intervals_of_exponents_are_not_cut() {
    let mut records = demo::records(0.05).into_iter();
    let Some(Record::Header(header)) = records.next() else {
        panic!("a header first");
    };
    let mut panels = RunPanels::new(header);
    let mut drawn = 0;
    for record in records {
        panels.accept(&record, &mut |time, name, panel| {
            if name == "lyapunov-spectrum" {
                drawn += 1;
                let [low, high] = panel.y.range;
                let mut points = panel.layers.iter().flat_map(Layer::points_of);
                let is_inside = points.all(|[_, y]| (low..=high).contains(&y));
                assert!(is_inside, "{time}: {:?}", panel.layers);
            }
        });
    }
    assert!(drawn > 3);
}

/// The document on the exponents in a recording has the numbers of their JSON.
#[test]
fn the_exponents_of_a_recording_are_those_of_the_result() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("exponents.rrd");
    let output = Output {
        save: Some(path.clone()),
        ..Output::default()
    };
    let mut sink = RerunSink::new(&output, demo::spec()).unwrap();
    let mut last = None;
    for record in demo::records(0.05) {
        if let Record::Exponents(exponents) = &record {
            last = Some(Arc::clone(exponents));
        }
        sink.accept(record).unwrap();
    }
    sink.finish().unwrap();
    let texts = texts(&path);
    let mut documents = texts
        .iter()
        .filter(|(_, text)| text.contains("Kaplan-Yorke"));
    let (_, document) = documents.next_back().expect("a document");
    let last = last.expect("exponents");
    let result = RunExponents::new(&last);
    assert_eq!(*document, shown(&markdown(&result.blocks(""))));
    agreement::check(&result, &[1.0, 2.0, 3.0, 95.0]);
}
