//! Figure of the guide: each feature of the type of motion in a signal that has it and in one that has not.

use super::*;
use crate::import::Signal;
use crate::plot::figure::Shape;
use crate::plot::{FigureOptions, Format};
use crate::study::signal::{SignalOptions, analyse_signal};
use crate::test_signals::recorded::RECORDED;
use crate::test_signals::textbook::{JUDGING, TEXTBOOK};

/// Most points of a layer.
const POINTS: usize = 160;

/// The panel of a feature.
type Feature = fn(&SignalAnalysis) -> Panel;

/// Panel of each feature, and what it shows in a signal of which family: with the feature, and without it.
const FEATURES: [(Feature, [[&str; 2]; 2]); 10] = [
    (
        |report| spectrum(report).expect("analysed").swap_remove(0),
        [
            ["one tone", "squeak, locked harmonics"],
            ["more than one tone", "two tones in noise"],
        ],
    ),
    (
        |report| spectrum(report).expect("analysed").swap_remove(0),
        [["two tones", "torus"], ["more than two tones", "music"]],
    ),
    (
        |report| spectrum(report).expect("analysed").swap_remove(0),
        [
            ["broadband floor", "Lorenz"],
            ["no broadband floor", "periodic"],
        ],
    ),
    (
        |report| section(report).expect("analysed").swap_remove(0),
        [
            ["Poincaré section: curve", "torus"],
            ["Poincaré section: cloud", "Mackey-Glass"],
        ],
    ),
    (
        |report| section(report).expect("analysed").swap_remove(1),
        [
            ["repetition", "period doubling cascade"],
            ["no repetition", "Roessler"],
        ],
    ),
    (
        |report| portrait(report).expect("analysed").swap_remove(0),
        [
            ["predictable", "van der Pol, torus"],
            ["not predictable", "coloured noise, resonance"],
        ],
    ),
    (
        |report| divergence(report).expect("analysed").swap_remove(0),
        [
            ["divergence", "Roessler"],
            ["no divergence", "van der Pol, torus"],
        ],
    ),
    (
        |report| zero_one(report).expect("analysed").swap_remove(1),
        [
            ["0-1 test: random walk", "Duffing, two wells"],
            ["0-1 test: bounded path", "near locking 1:3"],
        ],
    ),
    (
        |report| waveform(report).expect("analysed").swap_remove(0),
        [["steady", "periodic"], ["not steady", "decay or growth"]],
    ),
    (
        |report| waveform(report).expect("analysed").swap_remove(0),
        [["long record", "noisy periodic"], ["short record", "short"]],
    ),
];

/// The report on the first signal of a family for judging whose type of motion is found.
fn report(name: &str) -> SignalAnalysis {
    let mut families = TEXTBOOK.iter().chain(RECORDED);
    let family = families
        .find(|family| family.name == name)
        .expect("a family");
    let report = |number| {
        let signal = Signal {
            name: name.to_owned(),
            unit: String::new(),
            rate: 1000.0,
            start: 0.0,
            samples: family.signal(number).0,
        };
        // A signal too short for a report is an error.
        analyse_signal(signal, &SignalOptions::default(), &mut |_, _| Ok(())).ok()
    };
    let is_right = |report: &SignalAnalysis| {
        let verdict = report.verdict.get().expect("classified");
        family.right.contains(&verdict.regime)
    };
    let mut reports = (JUDGING..JUDGING + 400).filter_map(report);
    reports.find(is_right).expect("one of four hundred")
}

/// The picture of a feature in a signal of a family.
fn panel(picture: Feature, [title, name]: [&str; 2]) -> Panel {
    let report = report(name);
    let mut panel = picture(&report);
    panel.square = false;
    for layer in &mut panel.layers {
        layer.label.clear();
        match &mut layer.shape {
            Shape::Lines(strips) => strips.iter_mut().for_each(thin),
            Shape::Points(points) => points.truncate(POINTS),
            _ => {}
        }
    }
    panel.with_title(title).with_caption(name)
}

/// Smallest and largest value of pieces of a curve over time or frequency; the start of any other curve.
fn thin(curve: &mut Vec<[f64; 2]>) {
    if curve.is_sorted_by(|a, b| a[0] <= b[0]) {
        let piece = curve.len().div_ceil(POINTS / 2).max(1);
        let ends = curve.chunks(piece).flat_map(|part| {
            let [low, high] = extent(part.iter().map(|[_, y]| *y));
            [low, high].map(|y| [part[0][0], y])
        });
        *curve = ends.collect();
    }
    curve.truncate(2 * POINTS);
}

/// The figure as HTML, on one line for Markdown.
fn html() -> String {
    let features = FEATURES.into_iter();
    let panels: Vec<Panel> = features
        .flat_map(|(picture, pair)| pair.map(|one| panel(picture, one)))
        .collect();
    let figure = Figure::grid("features", "Features", 40.0, 4, panels);
    if let Some(file) = std::env::var_os("SQUEAKSCOPE_PNG") {
        let png = figure
            .file(&FigureOptions::default(), Format::Png)
            .expect("drawn");
        std::fs::write(file, png).expect("written");
    }
    let svg = figure.svg(&FigureOptions::default()).replace('\n', " ");
    let (start, rest) = svg.split_once(" width=\"").expect("a width");
    let (_, rest) = rest.split_once(" viewBox").expect("a view box");
    format!("<div>{start} width=\"100%\" viewBox{rest}</div>\n")
}

/// `SQUEAKSCOPE_WRITE=1 cargo test --release --lib the_guide_shows_each_feature -- --ignored` draws it anew.
#[test]
#[ignore = "the last digits of a position depend on the machine"]
fn the_guide_shows_each_feature() {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/src/guide/explanation/regimes.html"
    );
    let drawn = html();
    if std::env::var_os("SQUEAKSCOPE_WRITE").is_some() {
        std::fs::write(file, &drawn).expect("written");
    }
    let shown = std::fs::read_to_string(file).expect("the figure");
    assert!(shown == drawn, "regimes.html shows other signals");
}
