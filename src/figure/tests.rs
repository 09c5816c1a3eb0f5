//! Figures of a report made by hand: every subject, also where there is nothing to show.

use super::*;
use crate::analysis::*;
use crate::import::Signal;
use crate::study::signal::*;

/// A report on a torus of two tones, its curves in closed form.
fn report(name: &str) -> SignalReport {
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
    let lines = spectrum.lines(&LineCriterion::default());
    let naming = name_lines(&lines, FREQUENCY_UNCERTAINTY * spectrum.bin);
    let mut columns = Vec::new();
    Stft::new(Window::BlackmanHarris, 2000, 200.0, rate)
        .push(&samples, |column| {
            columns.push(column);
            Ok::<(), AnalysisError>(())
        })
        .unwrap();
    let vectors = DelayVectors::new(&samples[..1000], 12, 3).unwrap();
    let mut plot = RecurrencePlot::new();
    let picks: Vec<usize> = (0..300).map(|k| 3 * k).collect();
    plot.measure(&vectors, &picks);
    let recurrences = plot.recurrences(Threshold::Rate(0.08)).unwrap();
    let along = (0..80).map(|k| {
        let t = f64::from(k);
        MeasuresAt {
            time: 0.01 + 0.001 * t,
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
    let passages = (0..400).map(|k| {
        let phase = 0.37 * f64::from(k);
        let (y, z) = (6e-7 + 1e-7 * phase.cos(), -5e-7 + 8e-8 * phase.sin());
        SectionPoint {
            time: 48.6 * f64::from(k) / rate,
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
            &[Regime::QuasiPeriodic][..],
            "two tones, f1 = 4.11 kHz and f2 = 3.87 kHz, explain every line",
        ),
        (
            "Poincaré section",
            0.8,
            &[Regime::QuasiPeriodic][..],
            "400 passages lie on a closed curve",
        ),
        ("0–1 test", 0.6, &[Regime::Periodic][..], "K = 0.03"),
        (
            "largest exponent",
            0.2,
            &[Regime::Chaotic][..],
            "12 ± 9 1/s",
        ),
    ];
    let signal = Signal {
        name: name.to_owned(),
        unit: "m".to_owned(),
        rate,
        start: 0.0,
        samples: samples.clone(),
    };
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
            judged: vec![1000; 8],
        },
    };
    SignalReport {
        facts: SignalFacts::of(&signal),
        signal,
        tones: Tones::new(&spectrum, &lines, naming),
        spectrum,
        spectrogram: columns,
        embedding: StateSpace::new(choice, rate),
        recurrence: RecurrenceReport {
            rule: RecurrenceRule {
                norm: Norm::Euclidean,
                threshold: Threshold::Rate(0.05),
                theiler: 1,
            },
            epsilon: recurrences.distance,
            stride_samples: 1,
            states: 1000,
            theiler_s: 1.0 / rate,
            period_s: Some(2.4e-4),
            measures: Measures {
                recurrence_rate: 0.08,
                ..Measures::default()
            },
            along: along.collect(),
            picture: RecurrenceImage {
                window: 0.005,
                size: plot.size(),
                distance: plot.distance_picture(),
                recurrent: recurrences.pixels,
                ..RecurrenceImage::default()
            },
        },
        section: Section {
            level: 0.0,
            shape: SectionShape::Loop,
            mean_return_s: Some(48.6 / rate),
            passages: passages.collect(),
        },
        rosenstein: divergence(0.008).in_seconds(rate),
        kantz: Divergence {
            region: None,
            ..divergence(0.01).in_seconds(rate)
        },
        zero_one: ZeroOne {
            k: 0.03,
            by_frequency: (0..100)
                .map(|k| [0.63 + 0.019 * f64::from(k), 0.1 * f64::from(k).sin()])
                .collect(),
            path: (0..500)
                .map(|k| [(0.1 * f64::from(k)).sin(), (0.13 * f64::from(k)).cos()])
                .collect(),
            stride: 12,
            samples: 500,
        },
        verdict: Verdict {
            regime: Regime::QuasiPeriodic,
            confidence: 0.93,
            evidence: evidence
                .into_iter()
                .map(|(what, weight, says, words)| {
                    Evidence::new(what, weight, says, weight, words.to_owned())
                })
                .collect(),
        },
        nonlinear_samples: samples.len(),
    }
}

/// Where the figures go if someone wants to look: `SQUEAKSCOPE_FIGURES=DIR cargo test figure`.
fn show(figure: &Figure, png: &[u8]) {
    if let Some(folder) = std::env::var_os("SQUEAKSCOPE_FIGURES") {
        let path = std::path::Path::new(&folder).join(&figure.name);
        std::fs::write(path.with_extension("png"), png).unwrap();
        std::fs::write(path.with_extension("svg"), &figure.svg).unwrap();
    }
}

/// Width and height a PNG says it has.
fn size(png: &[u8]) -> [u32; 2] {
    let info = png::Decoder::new(std::io::Cursor::new(png))
        .read_info()
        .unwrap();
    [info.info().width, info.info().height]
}

/// Whether every coordinate is a number; letters alone prove nothing, pictures are full of them.
fn is_finite(figure: &Figure) -> bool {
    let mut words = figure.svg.split(['"', ',', ' ', '(']);
    !words.any(|word| ["NaN", "inf", "-inf"].contains(&word))
}

#[test]
fn every_subject_has_its_figure() {
    let figures = signal_figures(&report("probe/displacement")).unwrap();
    let names: Vec<&str> = figures.iter().map(|f| &*f.name).collect();
    assert_eq!(names, SIGNAL_FIGURES);
    for figure in &figures {
        let png = figure.png().unwrap();
        show(figure, &png);
        let document = resvg::usvg::roxmltree::Document::parse(&figure.svg).unwrap();
        let points = |name| {
            document
                .root_element()
                .attribute(name)
                .unwrap()
                .parse::<u32>()
                .unwrap()
        };
        assert_eq!(size(&png), [2 * points("width"), 2 * points("height")]);
        assert!(is_finite(figure), "{}", figure.name);
        assert!(
            figure.svg.len() < 2_000_000,
            "{}: {}",
            figure.name,
            figure.svg.len()
        );
    }
    assert_eq!(
        figures,
        signal_figures(&report("probe/displacement")).unwrap()
    );
}

#[test]
fn names_are_words_not_markup() {
    // XML allows no escape character, and a reader would turn the rest of the line round.
    let figures = signal_figures(&report("a<b & \"c\" \u{1b}[31m\u{202e}d")).unwrap();
    figures[0].png().unwrap();
    let document = resvg::usvg::roxmltree::Document::parse(&figures[0].svg).unwrap();
    let mut texts = document.descendants().filter_map(|node| node.text());
    assert!(texts.any(|text| text.contains("a<b & \"c\" \\u001b[31m\\u202ed")));
}

#[test]
fn nothing_to_show_is_shown_as_such() {
    let mut empty = report("empty");
    empty.tones.lines.clear();
    empty.spectrogram.clear();
    empty.section.passages.clear();
    empty.recurrence.along.clear();
    empty.recurrence.picture.size = 0;
    empty.rosenstein.region = None;
    empty.zero_one.by_frequency.clear();
    empty.zero_one.path.clear();
    empty.verdict.evidence.clear();
    empty.signal.samples = vec![0.0; 40];
    for figure in signal_figures(&empty).unwrap() {
        let png = figure.png().unwrap();
        assert!(size(&png)[0] > 0);
        assert!(is_finite(&figure), "{}", figure.name);
    }
}
