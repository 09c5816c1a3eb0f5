//! Figures of a synthetic report, also without data.

use super::*;
use crate::analysis::{
    AnalysisError, chaos::*, delay::*, events::*, poincare::*, recurrence::*, regime::*, tones::*,
};
use crate::import::Signal;
use crate::study::signal::*;
use crate::test_signals;

const LOOK: FigureOptions = FigureOptions {
    style: Style::Screen,
    size: None,
};

/// A report on a torus with two base frequencies; its curves are analytical.
pub fn report(name: &str) -> SignalAnalysis {
    let rate = 200e3;
    let samples: Vec<f64> = test_signals::sines(
        rate,
        20_000,
        &[
            (4110.0, 6e-7, 0.0),
            (3870.0, 1e-7, 1.0),
            (12_330.0, 8e-8, 0.3),
        ],
    );
    let spectrum = SpectrumAnalyser::new(Window::BlackmanHarris, rate)
        .analyse(&samples)
        .unwrap();
    let mut columns = Vec::new();
    Stft::new(Window::BlackmanHarris, 2000, 200.0, rate)
        .push(&samples, |column| {
            columns.push(column);
            Ok::<(), AnalysisError>(())
        })
        .unwrap();
    let vectors = DelayVectors::new(&samples[..1000], 12, 3).unwrap();
    let picks: Vec<usize> = (0..300).map(|k| 3 * k).collect();
    let rule = RecurrenceCriterion {
        norm: Norm::Euclidean,
        threshold: Threshold::Rate(0.08),
        theiler: 1,
    };
    let picture = RecurrenceImage::new(&vectors, &picks, &rule, 0.005, 1.0 / rate).unwrap();
    let windows = (0..80).map(|k| {
        let t = f64::from(k);
        MeasuresAt {
            time_s: 0.01 + 0.001 * t,
            measures: Measures {
                recurrence_rate: 0.05,
                determinism: Some(0.95 + 0.04 * (0.3 * t).sin()),
                laminarity: Some(0.6 + 0.1 * (0.2 * t).cos()),
                mean_diagonal: Some(20.0 + 5.0 * (0.25 * t).sin()),
                trapping_time: Some(4.0),
                recurrence_time_2: Some(48.0),
                entropy: Some(2.0 + 0.3 * (0.1 * t).sin()),
                ..Measures::default()
            }
            .in_seconds(1.0 / rate),
        }
    });
    let crossings = (0..400).map(|k| {
        let phase = 0.37 * f64::from(k);
        let (y, z) = (6e-7 + 1e-7 * phase.cos(), -5e-7 + 8e-8 * phase.sin());
        SectionPoint {
            time_s: 48.6 * f64::from(k) / rate,
            at: [y, z],
        }
    });
    let divergence = |slope: f64| Divergence {
        step: 1.0,
        curve: (0..200)
            .map(|k| (-14.0 + slope * f64::from(k)).min(-12.5))
            .collect(),
        counted: vec![500; 200],
        region: Some(ScalingRegion {
            from: 10.0,
            to: 120.0,
            slope,
            error: 0.1 * slope,
            intercept: -14.0,
        }),
    };
    let evidence = [
        (
            "spectrum",
            0.9,
            Regime::QuasiPeriodic,
            "two tones, f1 = 4.11 kHz and f2 = 3.87 kHz, explain every line",
        ),
        (
            "Poincaré section",
            0.8,
            Regime::QuasiPeriodic,
            "400 passages lie on a closed curve",
        ),
        ("0-1 test", 0.6, Regime::Periodic, "K = 0.03"),
        ("largest exponent", 0.2, Regime::Chaotic, "12 ± 9 1/s"),
    ];
    let signal = Signal {
        name: name.to_owned(),
        unit: "m".to_owned(),
        rate,
        start: 0.0,
        samples: samples.clone(),
    };
    let event = event();
    let choice = DelayChoice {
        lag: 12,
        reason: LagReason::FirstMinimum,
        dimension: 5,
        unfolded: true,
        theiler: 48,
        mutual: MutualInformation {
            bins: 64,
            bits: (0..60)
                .map(|k| 1.0 + 4.0 / (1.0 + f64::from(k)) + (f64::from(k) / 8.0).cos())
                .collect(),
        },
        neighbours: FalseNeighbours {
            lag: 12,
            share: vec![0.99, 0.4, 0.1, 0.02, 0.005, 0.004, 0.004, 0.004],
            evaluated: vec![1000; 8],
        },
    };
    SignalAnalysis {
        file: None,
        sound_levels: None,
        truth: None,
        facts: SignalStatistics::of(&signal),
        signal,
        tones: SpectralLines::of(&spectrum, &spectrum.lines(&LineCriterion::default())),
        spectrum,
        spectrogram: columns,
        embedding: Outcome::Computed(DelayEmbedding {
            lag_s: 12.0 / rate,
            theiler_s: 48.0 / rate,
            choice,
        }),
        recurrence: Outcome::Computed(RecurrenceAnalysis {
            rule: RecurrenceCriterion {
                norm: Norm::Euclidean,
                threshold: Threshold::Rate(0.05),
                theiler: 1,
            },
            epsilon: picture.threshold,
            min_diagonal_states: 2,
            min_vertical_states: 2,
            line_of_identity: false,
            interpolation: 1,
            stride_samples: 1,
            lag_states: 12,
            dimension: 5,
            states: 1000,
            theiler_s: 1.0 / rate,
            recurrence_periods: RecurrencePeriods(vec![RecurrencePeriod {
                kind: RecurrenceKind::Finest,
                period: 2.4e-4,
                uncertainty: 1e-7,
                share: 0.7,
            }]),
            measures: Measures {
                recurrence_rate: 0.08,
                ..Measures::default()
            },
            windows: windows.collect(),
            picture,
        }),
        section: Outcome::Computed(PoincareSection {
            level: 0.0,
            shape: SectionShape::Loop,
            mean_return_time_s: Some(48.6 / rate),
            crossings: crossings.collect(),
        }),
        rosenstein: Outcome::Computed(divergence(0.008).in_seconds(rate)),
        kantz: Outcome::Computed(Divergence {
            region: None,
            ..divergence(0.01).in_seconds(rate)
        }),
        zero_one: Outcome::Computed(ZeroOne {
            k: 0.03,
            by_frequency: (0..100)
                .map(|k| [0.63 + 0.019 * f64::from(k), 0.1 * f64::from(k).sin()])
                .collect(),
            path: (0..500)
                .map(|k| [(0.1 * f64::from(k)).sin(), (0.13 * f64::from(k)).cos()])
                .collect(),
            stride: 12,
            samples: 500,
        }),
        verdict: Outcome::Computed(Verdict {
            regime: Regime::QuasiPeriodic,
            confidence: 0.93,
            likeliest: vec![Regime::QuasiPeriodic],
            limitation: None,
            evidence: evidence
                .into_iter()
                .map(
                    |(criterion, contribution, supports, description)| Evidence {
                        criterion: criterion.to_owned(),
                        supports,
                        contribution,
                        description: description.to_owned(),
                    },
                )
                .collect(),
            intervals: Vec::new(),
        }),
        nonlinear_samples: samples.len(),
        stretch: AnalysedStretch {
            start_s: 0.0,
            end_s: 1.0,
            event: Some(1),
            demodulated: false,
            band_hz: None,
            clipped: false,
        },
        part: None,
        sound: Some(MeasuredSound {
            tonal: TonalEvents {
                events: vec![event],
                ..TonalEvents::default()
            },
            ..MeasuredSound::default()
        }),
    }
}

/// An event from 0.02 to 0.08 s with three harmonics.
fn event() -> TonalEvent {
    let ridge = (0..=60).map(|k| RidgePoint {
        time_s: 0.02 + 1e-3 * f64::from(k),
        frequency_hz: 4110.0 + 60.0 * (0.1 * f64::from(k)).sin(),
        level_db: -3.0,
    });
    TonalEvent {
        kind: crate::analysis::events::EventKind::Tone,
        probability: 0.99,
        start_s: 0.02,
        end_s: 0.08,
        frequency_hz: 4110.0,
        frequency_low_hz: 4050.0,
        frequency_high_hz: 4170.0,
        harmonics: 3,
        level_db: -3.0,
        snr_db: 40.0,
        modulation: None,
        vibrato: None,
        ridge: ridge.collect(),
    }
}

/// The result of an analysis that was not skipped.
fn result<T>(outcome: &mut Outcome<T>) -> &mut T {
    match outcome {
        Outcome::Computed(result) => result,
        Outcome::Skipped { skipped } => panic!("{skipped}"),
    }
}

/// Number of the figures of a signal, of which several show more than one result of an analysis.
const SIGNAL_FIGURES: usize = 13;

/// Saves a figure for inspection: `SQUEAKSCOPE_FIGURES=DIR cargo test figure`.
fn show(figure: &Figure, png: &[u8]) {
    if let Some(folder) = std::env::var_os("SQUEAKSCOPE_FIGURES") {
        let path = std::path::Path::new(&folder).join(&figure.name);
        std::fs::write(path.with_extension("png"), png).unwrap();
        std::fs::write(path.with_extension("svg"), figure.svg(&LOOK)).unwrap();
    }
}

/// Width and height of a PNG image.
fn size(png: &[u8]) -> [u32; 2] {
    let info = png::Decoder::new(std::io::Cursor::new(png))
        .read_info()
        .unwrap();
    [info.info().width, info.info().height]
}

/// Whether all coordinates are finite. Only whole words count, because image data contain the letters.
fn is_finite(figure: &Figure) -> bool {
    let svg = figure.svg(&LOOK);
    let mut words = svg.split(['"', ',', ' ', '(']);
    !words.any(|word| ["NaN", "inf", "-inf"].contains(&word))
}

#[test]
fn every_name_has_a_figure() {
    let figures = signal_figures(&report("probe/displacement"));
    assert_eq!(figures.len(), SIGNAL_FIGURES);
    for figure in &figures {
        assert!(figure_names().contains(&&*figure.name), "{}", figure.name);
        let png = figure.file(&LOOK, Format::Png).unwrap();
        show(figure, &png);
        let svg = figure.svg(&LOOK);
        let document = resvg::usvg::roxmltree::Document::parse(&svg).unwrap();
        let pixels = |name| {
            let side = document.root_element().attribute(name).unwrap();
            let mm: f32 = side.strip_suffix("mm").unwrap().parse().unwrap();
            (mm / 25.4 * LOOK.resolution()).round() as u32
        };
        for (found, wanted) in size(&png).into_iter().zip(["width", "height"].map(pixels)) {
            assert!(found.abs_diff(wanted) <= 1, "{found} and {wanted}");
        }
        assert!(is_finite(figure), "{}", figure.name);
        assert!(svg.len() < 2_000_000, "{}: {}", figure.name, svg.len());
    }
    assert_eq!(figures, signal_figures(&report("probe/displacement")));
}

#[test]
fn names_are_escaped() {
    // XML has no escape character, and a direction override would reverse the rest of the line.
    let figures = signal_figures(&report("a<b & \"c\" \u{1b}[31m\u{202e}d"));
    figures[0].file(&LOOK, Format::Png).unwrap();
    let svg = figures[0].svg(&LOOK);
    let document = resvg::usvg::roxmltree::Document::parse(&svg).unwrap();
    let mut texts = document.descendants().filter_map(|node| node.text());
    assert!(texts.any(|text| text.contains("a<b & \"c\" \\u001b[31m\\u202ed")));
}

#[test]
fn figures_without_data_are_valid() {
    let mut empty = report("empty");
    empty.tones.lines.clear();
    empty.spectrogram.clear();
    result(&mut empty.section).crossings.clear();
    result(&mut empty.recurrence).windows.clear();
    result(&mut empty.recurrence).picture.size = 0;
    result(&mut empty.rosenstein).region = None;
    result(&mut empty.zero_one).by_frequency.clear();
    result(&mut empty.zero_one).path.clear();
    result(&mut empty.verdict).evidence.clear();
    empty.sound = None;
    empty.signal.samples = vec![0.0; 40];
    for figure in signal_figures(&empty) {
        let png = figure.file(&LOOK, Format::Png).unwrap();
        assert!(size(&png)[0] > 0);
        assert!(is_finite(&figure), "{}", figure.name);
    }
}

#[test]
fn events_are_drawn_over_the_spectrogram() {
    let mut report = report("squeak");
    let figure = &signal_figures(&report)[0];
    let layers = |figure: &Figure| -> Vec<String> {
        let layers = figure.rows[0][0].layers.iter();
        layers.map(|layer| layer.id.clone()).collect()
    };
    let drawn = ["image", "ridges", "peaks"];
    assert_eq!(layers(figure), drawn);
    report.sound = Some(MeasuredSound::default());
    let figure = &signal_figures(&report)[0];
    assert_eq!(layers(figure), ["image"]);
    assert!(figure.svg(&LOOK).contains("no tonal events"));
}

#[test]
fn figures_of_skipped_analyses_say_why() {
    fn skip<T>(outcome: &mut Outcome<T>) {
        let skipped = SkipReason::NotStationary;
        *outcome = Outcome::Skipped { skipped };
    }
    let mut report = report("squeak");
    skip(&mut report.embedding);
    skip(&mut report.recurrence);
    skip(&mut report.section);
    skip(&mut report.rosenstein);
    skip(&mut report.kantz);
    skip(&mut report.zero_one);
    skip(&mut report.verdict);
    let figures = signal_figures(&report);
    assert_eq!(figures.len(), SIGNAL_FIGURES);
    for figure in &figures[4..] {
        let svg = figure.svg(&LOOK);
        assert!(svg.contains("no stationary stretch"), "{}", figure.name);
    }
}

#[test]
fn a_divergence_without_neighbours_says_so() {
    let mut report = report("squeak");
    let Outcome::Computed(kantz) = &mut report.kantz else {
        panic!("computed");
    };
    kantz.curve.clear();
    let figures = signal_figures(&report);
    let figure = figures.iter().find(|figure| figure.name == "divergence");
    let svg = figure.expect("a figure").svg(&LOOK);
    assert!(svg.contains("too few distinct neighbours"));
}

/// A figure with one layer of each kind.
fn everything() -> Figure {
    let points = vec![[0.0, 0.0], [1.0, 2.0], [2.0, 0.0], [f64::NAN, 1.0]];
    let image = Image {
        x: [0.0, 1.0],
        y: [0.0, 0.5],
        size: [2, 1],
        pixels: vec![0, 1],
        palette: figure::plain_palette([[0; 3], [255, 0, 0]]),
    };
    let layers = vec![
        Layer::image(image),
        Layer::band(
            [[0.0, 0.1, 0.2], [1.0, 0.2, 0.3], [0.5, 0.2, f64::INFINITY]],
            Color::Faint,
        ),
        Layer::areas(
            vec![vec![[0.4, 0.0], [0.6, 0.0], [0.6, 0.4]]],
            1.0,
            Color::Pale,
        )
        .with_label("columns"),
        Layer::intervals([[0.5, 0.1, 0.9]], Color::Series(1)),
        Layer::line(points.clone(), Color::Series(0))
            .dashed()
            .with_label("a line"),
        Layer::points(points, 2.0, Color::Series(2))
            .with_marker(Marker::Cross)
            .with_label("points"),
        Layer::peaks(vec![
            ([0.5, 0.8], "f1".to_owned()),
            ([0.51, 0.8], "f2".to_owned()),
        ]),
        Layer::horizontal_line(0.5),
        Layer::vertical_lines([0.7], Color::Accent).with_label("chosen"),
    ];
    let axis = |name| Axis::linear(name, [0.0, 1.0]);
    let panel = Panel::new("one panel", axis("x, mm"), axis("y, s"), layers).with_note("a note");
    Figure::new("everything", "Everything", 80.0, vec![vec![panel]])
}

#[test]
fn layers_are_clipped_at_the_axes() {
    let square = |points| {
        let axis = || Axis::linear("", [0.0, 1.0]);
        let line = Layer::line(points, Color::Accent).with_size(6.0);
        let panel = Panel::new("", axis(), axis(), vec![line]).square();
        Figure {
            size_mm: [60.0; 2],
            ..Figure::new("cut", "", 60.0, vec![vec![panel]])
        }
    };
    let accent = |figure: &Figure| -> Vec<[usize; 2]> {
        let png = figure.file(&LOOK, Format::Png).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(png))
            .read_info()
            .unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        let width = info.width as usize;
        let samples = info.color_type.samples();
        let colored = pixels.chunks(samples).enumerate();
        let colored = colored.filter(|(_, pixel)| pixel[..3] == Color::Accent.on_light());
        colored.map(|(k, _)| [k % width, k / width]).collect()
    };
    // A diagonal that extends far beyond both corners fills the same square as one that ends in them.
    let inside = accent(&square(vec![[0.0, 0.0], [1.0, 1.0]]));
    let beyond = accent(&square(vec![[-9.0, -9.0], [9.0, 9.0]]));
    let ends = |pixels: &[[usize; 2]], c: usize| {
        let along = || pixels.iter().map(|pixel| pixel[c]);
        [along().min().unwrap(), along().max().unwrap()]
    };
    for c in [0, 1] {
        let (inside, beyond) = (ends(&inside, c), ends(&beyond, c));
        for (inside, beyond) in inside.into_iter().zip(beyond) {
            assert!(inside.abs_diff(beyond) < 12, "{inside} and {beyond}");
        }
    }
    // A line outside the axes draws no pixel.
    assert!(accent(&square(vec![[2.0, -1.0], [3.0, 5.0]])).is_empty());
}

#[test]
fn every_shape_is_drawn_in_every_format_and_style() {
    for style in [Style::Paper, Style::Screen, Style::Slides] {
        let options = FigureOptions { style, size: None };
        let svg = everything().svg(&options);
        for words in [
            "one panel",
            "a line",
            "columns",
            "f1",
            "f2",
            "chosen",
            "a note",
            "x, mm",
        ] {
            assert!(svg.contains(words), "{words}");
        }
        assert!(svg.contains("<image") && svg.contains("stroke-dasharray"));
        // Only the style `paper` omits the title; the metadata contain it in every style.
        assert_eq!(
            svg.matches("Everything").count(),
            1 + usize::from(options.has_title())
        );
        let [svg, png, pdf] = [Format::Svg, Format::Png, Format::Pdf]
            .map(|format| everything().file(&options, format).unwrap());
        assert!(svg.starts_with(b"<svg"));
        assert!(png.starts_with(b"\x89PNG"));
        assert!(pdf.starts_with(b"%PDF-"));
        show(&everything(), &png);
    }
    let sized = FigureOptions {
        style: Style::Paper,
        size: Some(parse_size("90x60").unwrap()),
    };
    assert!(
        everything()
            .svg(&sized)
            .contains("width=\"90.00mm\" height=\"60.00mm\"")
    );
    // 90 mm at 300 dpi.
    assert_eq!(
        size(&everything().file(&sized, Format::Png).unwrap()),
        [1063, 709]
    );
}
