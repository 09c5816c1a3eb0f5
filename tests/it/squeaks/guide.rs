//! The guide's page on tonal events shows the counts of `results.csv` and of the peers.

use std::fs;
use std::path::Path;

use squeakscope::plot::{Axis, Color, Figure, FigureOptions, Layer, Panel};

use super::score::{Counts, Score};

/// Counts of the search, written by `squeaks::study::judging`.
const RESULTS: &str = include_str!("results.csv");

/// Counts of all programs on the same recordings, written by `benches/peers/squeaks.py`.
const PEERS: &str = include_str!("../../../benches/peers/squeaks.csv");

/// The programs of [`PEERS`].
const PROGRAMS: [&str; 3] = ["squeakscope", "piptrack", "pyin"];

fn percent(share: f64) -> String {
    match share.is_nan() {
        true => "-".to_owned(),
        false => format!("{:.0} %", 100.0 * share),
    }
}

/// A table of the sets that `keep` selects: for each program recall and precision, or the share of recordings with a
/// false event.
fn table(counts: &[(&str, Counts)], first: &str, keep: impl Fn(&str) -> bool) -> String {
    let heads = counts.iter().map(|(program, _)| format!(" {program} |"));
    let heads: String = heads.collect();
    let mut text = format!(
        "| {first} | number |{heads}\n|---|---|{}\n",
        "---|".repeat(counts.len())
    );
    for (set, score) in counts[0].1.0.iter().filter(|(set, _)| keep(set)) {
        let number = score
            .squeaks
            .max(score.recordings * usize::from(score.squeaks == 0));
        text += &format!("| {set} | {number} |");
        for (_, counts) in counts {
            let score = counts.of(set);
            text += &match score.squeaks {
                0 => format!(" {} |", percent(score.with_false_share())),
                _ => format!(
                    " {}, {} |",
                    percent(score.recall()),
                    percent(score.precision())
                ),
            };
        }
        text += "\n";
    }
    text
}

fn level_db(set: &str) -> Option<f64> {
    set.strip_suffix(" dB")?.parse().ok()
}

/// All tables of the page.
fn tables() -> String {
    let own = [("squeakscope", Counts::read(RESULTS, "squeakscope"))];
    let peers = PROGRAMS.map(|program| (program, Counts::read(PEERS, program)));
    let level = |set: &str| level_db(set).is_some();
    let part = |set: &str| set.starts_with("with ");
    let other = |set: &str| !level(set) && !part(set);
    [
        "Squeaks found (recall) and events that are squeaks (precision):",
        &table(&own, "signal-to-noise ratio", level),
        "The same at 10 dB or more, by what else is in the recordings:",
        &table(&own, "recordings", part),
        "Recordings without squeaks in which there is an event:",
        &table(&own, "recordings of", other),
        "All programs on the same recordings, recall and precision:",
        &table(&peers, "signal-to-noise ratio", level),
        "Recordings without squeaks in which there is an event:",
        &table(&peers, "recordings of", other),
    ]
    .join("\n")
    .replace(":\n", ":\n\n")
}

/// Recall and precision over the signal-to-noise ratio.
fn figure() -> Figure {
    let curves = PROGRAMS.map(|program| {
        let source = if program == "squeakscope" {
            RESULTS
        } else {
            PEERS
        };
        let counts = Counts::read(source, program).0.into_iter();
        let points = counts.filter_map(|(set, score)| Some((level_db(&set)?, score)));
        (program, points.collect::<Vec<_>>())
    });
    let panel = |title: &str, value: fn(&Score) -> f64| {
        let x = Axis::linear("signal-to-noise ratio, dB", [-11.0, 31.0]);
        let y = Axis::linear(format!("{title}, %"), [-2.0, 102.0]);
        let layers = curves
            .iter()
            .enumerate()
            .flat_map(|(k, (program, points))| {
                let points = points
                    .iter()
                    .map(|(level, score)| [*level, 100.0 * value(score)]);
                let points: Vec<[f64; 2]> = points.collect();
                let line = Layer::line(points.clone(), Color::Series(k)).with_label(*program);
                [line, Layer::points(points, 2.4, Color::Series(k))]
            });
        Panel::new("", x, y, layers.collect())
    };
    let row = vec![
        panel("recall", Score::recall),
        panel("precision", Score::precision),
    ];
    Figure::new("squeaks", "Squeaks found in recordings", 80.0, vec![row])
}

/// The figure as HTML; Markdown needs it on one line.
fn html() -> String {
    let svg = figure().svg(&FigureOptions::default()).replace('\n', " ");
    let (start, rest) = svg.split_once(" width=\"").expect("a width");
    let (_, rest) = rest.split_once(" viewBox").expect("a view box");
    format!("<div>{start} width=\"100%\" viewBox{rest}</div>\n")
}

#[test]
fn the_guide_shows_the_counts() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/guide/explanation");
    let (page, drawing) = (folder.join("events.md"), folder.join("events.html"));
    let text = fs::read_to_string(&page).expect("the page");
    let (before, rest) = text.split_once("<!-- tables -->\n").expect("a mark");
    let (_, after) = rest.split_once("<!-- end of tables -->").expect("a mark");
    let wanted = format!(
        "{before}<!-- tables -->\n\n{}\n<!-- end of tables -->{after}",
        tables()
    );
    if std::env::var_os("SQUEAKSCOPE_WRITE").is_some() {
        fs::write(&page, &wanted).expect("written");
        fs::write(&drawing, html()).expect("written");
    }
    assert!(
        text == wanted,
        "events.md differs from the counts: see study.rs"
    );
    let drawn = fs::read_to_string(drawing).expect("the figure");
    assert!(
        drawn == html(),
        "events.html differs from the counts: see study.rs"
    );
}
