//! Benchmarks of the analyses, each over one parameter.
//!
//! The signal is a torus of the three strongest tones of the natural set. The cost does not depend on
//! the values, except for the number of identified lines.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use squeakscope::analysis::{
    delay::DelayVectors,
    recurrence::{Norm, RecurrenceCriterion, RecurrenceImage, Threshold},
    tones::{Line, LineCriterion, SpectrumAnalyser, Window, identify_lines},
};
use squeakscope::pipeline::message::{Frame, Record};
use squeakscope::pipeline::{Analyser, Simulation, Sink, SinkError, Source};
use squeakscope::scene::{AnalysisSpec, Scene};

/// Sample rate, Hz.
const RATE: f64 = 200_000.0;

fn torus(samples: usize) -> Vec<f64> {
    let tones = [(4113.0, 16e-3), (3873.0, 2.4e-3), (12_339.0, 6e-3)];
    let at = |i: usize| {
        let t = i as f64 / RATE;
        let tone = |(f, a): &(f64, f64)| a * (std::f64::consts::TAU * f * t).sin();
        tones.iter().map(tone).sum()
    };
    (0..samples).map(at).collect()
}

/// A spectrum and its lines, by window length.
fn spectrum(c: &mut Criterion) {
    let mut group = c.benchmark_group("spectrum");
    for samples in [1000, 4000, 16_000] {
        let signal = torus(samples);
        let mut analyser = SpectrumAnalyser::new(Window::BlackmanHarris, RATE);
        group.throughput(Throughput::Elements(samples as u64));
        group.bench_function(BenchmarkId::new("samples", samples), |b| {
            b.iter(|| {
                let spectrum = analyser.analyse(black_box(&signal)).unwrap();
                spectrum.lines(&LineCriterion::default())
            });
        });
    }
    group.finish();
}

/// Identification of lines, by the number of lines.
fn names(c: &mut Criterion) {
    let mut group = c.benchmark_group("names");
    let orders = [
        (1, 0),
        (3, 0),
        (1, 1),
        (0, 1),
        (2, 1),
        (4, 0),
        (2, 0),
        (4, -1),
        (0, 2),
        (5, 0),
        (3, -2),
        (5, 1),
    ];
    for count in [3, 6, 12] {
        let line = |(rank, &(n, m)): (usize, &(i32, i32))| Line {
            frequency: f64::from(n) * 4113.0 + f64::from(m) * 3873.0,
            amplitude: 0.7_f64.powi(rank as i32),
        };
        let lines: Vec<Line> = orders[..count].iter().enumerate().map(line).collect();
        group.bench_function(BenchmarkId::new("lines", count), |b| {
            b.iter(|| identify_lines(black_box(&lines), 5.0));
        });
    }
    group.finish();
}

/// A recurrence plot with its threshold, recurrence rate and both images, by size.
fn recurrence(c: &mut Criterion) {
    let mut group = c.benchmark_group("recurrence");
    let signal = torus(4048);
    let vectors = DelayVectors::new(&signal, 12, 5).unwrap();
    for size in [100, 200, 400, 800] {
        let indices: Vec<usize> = (0..size).map(|i| i * vectors.len() / size).collect();
        let criterion = RecurrenceCriterion {
            norm: Norm::Euclidean,
            threshold: Threshold::Rate(0.1),
            theiler: 1,
        };
        group.throughput(Throughput::Elements((size * size) as u64));
        group.bench_function(BenchmarkId::new("size", size), |b| {
            b.iter(|| {
                RecurrenceImage::new(black_box(&vectors), &indices, &criterion, 1.0, 1.0).unwrap()
            });
        });
    }
    group.finish();
}

/// Discards all records.
struct Drain;

impl Sink for Drain {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        black_box(record);
        Ok(())
    }
}

/// Analyses of 100 ms of simulated time, by the set of active analyses.
fn stages(c: &mut Criterion) {
    let mut scene = Scene::load("doubled-torus-3deg").unwrap();
    scene.duration = 0.1;
    let all = scene.analysis.clone();
    let only = |select: fn(&mut AnalysisSpec, &AnalysisSpec)| {
        let mut spec = AnalysisSpec::default();
        select(&mut spec, &all);
        spec
    };
    let cases = [
        ("none", AnalysisSpec::default()),
        ("spectrum", only(|spec, all| spec.spectrum = all.spectrum)),
        (
            "spectrogram",
            only(|spec, all| spec.spectrogram = all.spectrogram),
        ),
        ("delay", only(|spec, all| spec.delay = all.delay)),
        (
            "recurrence",
            only(|spec, all| spec.recurrence = all.recurrence),
        ),
        (
            "quantification",
            only(|spec, all| spec.quantification = all.quantification),
        ),
        (
            "section",
            only(|spec, all| spec.section = all.section.clone()),
        ),
        ("chaos", only(|spec, all| spec.chaos = all.chaos)),
        ("regime", only(|spec, all| spec.regime = all.regime)),
        ("all", all.clone()),
    ];
    let mut simulation = Simulation::new(&scene).unwrap();
    let header = simulation.header("");
    let next = || simulation.next_frame().unwrap().map(Arc::new);
    let frames: Vec<Arc<Frame>> = std::iter::from_fn(next).collect();

    let mut group = c.benchmark_group("stages of 100 ms");
    group.sample_size(20);
    for (name, analysis) in cases {
        group.bench_function(name, |b| {
            b.iter(|| {
                let mut analyser = Analyser::new(&analysis, &header);
                frames
                    .iter()
                    .for_each(|frame| analyser.push(frame, &mut Drain).unwrap());
                analyser.summary()
            });
        });
    }
    group.finish();
}

criterion_group!(benches, spectrum, names, recurrence, stages);
criterion_main!(benches);
