//! Figures of a run: the pictures and the time series of its recording, as files.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::APPLICATION;
use super::blueprint::run::Run;
use super::encode::Encoder;
use super::paths;
use super::stream::{Curve, RecordingStream};
use crate::analysis::{regime::Verdict, stats::range, tones::Column};
use crate::pipeline::message::{Exponents, Header, Record, Subject};
use crate::pipeline::{Sink, SinkError};
use crate::plot::response::{self, WINDOW, envelope};
use crate::plot::{
    Axis, Color, Figure, Layer, LessonPictures, Panel, evidence, figures, panel_names,
    running_exponents, spectrogram_panel,
};
use crate::scene::RecordSpec;
use crate::study::lyapunov::RunningExponents;

/// Natural periods in the phase portrait of a small system.
const PERIODS: f64 = 40.0;
/// Width of the spectrogram, pixels.
const PIXELS: f64 = 640.0;
/// Most points of a curve, and most of one whose points have marks.
const POINTS: usize = 4000;
const MARKED: usize = 60;
/// Names of the panels of a lesson.
const LESSON: [&str; 3] = ["lesson-1", "lesson-2", "lesson-3"];

/// A sink that keeps the pictures of a run for its figures.
#[derive(Debug)]
pub struct RunFigures {
    spec: RecordSpec,
    rec: RecordingStream,
    run: Option<(Arc<Header>, Encoder)>,
    lesson: LessonPictures,
    /// The columns of the spectrogram by their pixels.
    columns: BTreeMap<usize, Column>,
    verdict: Option<Arc<Verdict>>,
    running: Vec<RunningExponents>,
    exponents: Option<Arc<Exponents>>,
}

impl RunFigures {
    /// Starts without pictures; `spec` is that of the scene.
    pub fn new(spec: RecordSpec) -> Self {
        Self {
            // The body has no figure.
            spec: RecordSpec {
                body_rate: 0.0,
                ..spec
            },
            rec: RecordingStream::for_figures(APPLICATION),
            run: None,
            lesson: LessonPictures::default(),
            columns: BTreeMap::new(),
            verdict: None,
            running: Vec::new(),
            exponents: None,
        }
    }

    /// The figures; what the run has no data for is missing.
    pub fn figures(&self) -> Vec<Figure> {
        let Some((header, _)) = &self.run else {
            return Vec::new();
        };
        let run = Run {
            header,
            spec: self.spec,
        };
        let views = panel_names().map(|name| (name, run.panel(&self.rec, name)));
        let columns: Vec<Column> = self.columns.values().cloned().collect();
        let spectrogram = || spectrogram_panel(&columns, header.highest_frequency(), |time| time);
        let exponents = self.exponents.as_ref();
        let others = [
            ("portrait", self.portrait(header)),
            ("spectrogram", (!columns.is_empty()).then(spectrogram)),
            ("evidence", self.verdict.as_deref().map(evidence)),
            (
                "running-exponents",
                exponents.map(|found| running_exponents(&self.running, &found.spectrum, "")),
            ),
        ];
        let lesson = self.lesson.panels(header).into_iter().map(Some);
        let panels = views.chain(others).chain(LESSON.into_iter().zip(lesson));
        let panels = panels.filter_map(|(name, panel)| Some((name, panel?)));
        figures(&header.scene, &panels.collect())
    }

    /// The phase portrait of the last part of the run.
    fn portrait(&self, header: &Header) -> Option<Panel> {
        let window = match &header.subject {
            Subject::Small(small) => PERIODS / small.frequency_hz,
            Subject::Joint(_) | Subject::Signal(_) => 2.0 * WINDOW,
        };
        let series = |path| Some(self.rec.curves(path, window).pop()?.2);
        let (u, v) = (series(paths::DISPLACEMENT)?, series(paths::VELOCITY)?);
        let dt = (u.last()?[0] - u[0][0]) / (u.len() - 1) as f64;
        let samples = u.iter().zip(&v);
        let samples: Vec<_> = samples
            .map(|([_, u], [_, v])| [1e-6 * u, 1e-3 * v])
            .collect();
        let motion = response::interpolated(&samples, dt);
        Some(response::phase_portrait(&motion, None, Color::Run).square())
    }

    /// Adds a column of the spectrogram; a pixel shows the highest level of its columns.
    fn add_column(&mut self, header: &Header, (time, bin): (f64, f64), level_db: &[f32]) {
        let pixel = PIXELS * (time - header.start()) / header.duration;
        let shown = (header.highest_frequency() / bin) as usize + 2;
        let amplitude = level_db.iter().take(shown);
        let amplitude = amplitude.map(|level| 10f64.powf(f64::from(*level) / 20.0));
        let column = self.columns.entry(pixel as usize);
        let column = column.or_insert_with(|| Column {
            centre: time,
            bin,
            amplitude: vec![0.0; shown.min(level_db.len())],
        });
        let values = column.amplitude.iter_mut().zip(amplitude);
        values.for_each(|(most, value)| *most = most.max(value));
    }
}

impl Sink for &mut RunFigures {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        if let Record::Header(header) = &record {
            let encoder = Encoder::new(&self.rec, Arc::clone(header), self.spec);
            self.run = Some((Arc::clone(header), encoder));
        }
        let Some((header, encoder)) = &mut self.run else {
            return Ok(());
        };
        encoder.accept(&self.rec, &record);
        self.lesson.accept(header, &record);
        let header = Arc::clone(header);
        match record {
            Record::SpectrogramColumn {
                time,
                bin,
                level_db,
            } => self.add_column(&header, (time, bin), &level_db),
            Record::Regime { verdict, .. } => self.verdict = Some(verdict),
            Record::Exponents(found) => {
                let time = found.spectrum.time;
                // The averaging starts again when the motion changes.
                self.running.retain(|at| at.time < time);
                let exponents = found.spectrum.exponents.clone();
                if time > 0.0 && !exponents.is_empty() {
                    self.running.push(RunningExponents { time, exponents });
                }
                self.exponents = Some(found);
            }
            _ => {}
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        if let Some((_, encoder)) = &mut self.run {
            encoder.finish(&self.rec);
        }
        Ok(())
    }
}

/// Time series as a panel, on an axis of the values with a range if it is given; those of the last part of a run start at
/// zero. `None` without values.
pub fn series_panel(
    title: &str,
    values: Option<[f64; 2]>,
    curves: impl Iterator<Item = Curve>,
    is_recent: bool,
) -> Option<Panel> {
    let is_finite = |[_, y]: &[f64; 2]| y.is_finite();
    let curves = curves.filter(|(.., points)| points.iter().any(is_finite));
    let curves: Vec<Curve> = curves.collect();
    let [start, end] = range(curves.iter().flat_map(|(.., points)| points).map(|p| p[0]));
    let zero = if is_recent { start } else { 0.0 };
    // A single curve is named by the axis.
    let (name, has_legend) = match &curves[..] {
        [] => return None,
        [(name, ..)] => (name.as_str(), false),
        _ => ("", true),
    };
    let layers = curves.iter().flat_map(|(label, color, points)| {
        let points = points.iter().map(|[time, value]| [time - zero, *value]);
        let points: Vec<[f64; 2]> = points.collect();
        let strips = points.split(|point| !is_finite(point));
        let strips = strips.map(|strip| envelope(strip.to_vec(), POINTS));
        let line = Layer::lines(strips.collect(), *color);
        let label = if has_legend { label } else { "" };
        // A value between two gaps has no line.
        let marked = points.iter().filter(|_| points.len() <= MARKED).copied();
        [
            line.with_label(label),
            Layer::points(marked.filter(is_finite).collect(), 1.4, *color),
        ]
    });
    let layers: Vec<Layer> = layers.collect();
    let shown = || layers.iter().flat_map(Layer::points_of).map(|p| p[1]);
    let y = values.map_or_else(
        || Axis::with_margin(name, shown()),
        |range| Axis::linear(name, range),
    );
    let x = Axis::linear("time", [start - zero, end - zero]).of("s");
    // What follows a colon explains the colours of the viewer.
    let title = title.split(": ").next().unwrap_or_default();
    Some(Panel::new(title, x, y, layers))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(curves: &[(&str, &[[f64; 2]])]) -> Option<Panel> {
        let curves = curves.iter();
        let curves = curves.map(|(name, points)| ((*name).to_owned(), Color::Run, points.to_vec()));
        series_panel("Energy, µJ: stored blue", None, curves, true)
    }

    #[test]
    fn time_series_become_a_panel() {
        assert_eq!(panel(&[]), None);
        assert_eq!(panel(&[("K", &[[0.0, f64::NAN]])]), None);
        let one = panel(&[("load, N", &[[2.0, 5.0], [2.5, 7.0]])]).expect("a panel");
        assert_eq!(
            (&*one.title, one.y.label()),
            ("Energy, µJ", "load, N".to_owned())
        );
        assert_eq!(one.x.range, [0.0, 0.5]);
        assert_eq!(one.layers[0].label, "");
        let curve: &[[f64; 2]] = &[[0.0, 1.0], [1.0, f64::NAN], [2.0, 3.0], [3.0, 3.0]];
        let two = panel(&[("a", curve), ("b", curve)]).expect("a panel");
        assert_eq!(two.layers[0].label, "a");
        let gap = vec![vec![[0.0, 1.0]], vec![[2.0, 3.0], [3.0, 3.0]]];
        assert_eq!(two.layers[0].shape, crate::plot::Shape::Lines(gap));
        assert_eq!(two.layers[1].points_of().count(), 3);
    }
}
