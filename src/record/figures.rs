//! Figures of a run: the pictures and the time series of its recording, as files.

use std::sync::Arc;

use super::APPLICATION;
use super::blueprint::run::Run;
use super::encode::Encoder;
use super::stream::RecordingStream;
use crate::pipeline::message::Record;
use crate::pipeline::{Sink, SinkError};
use crate::plot::response::{Curve, over_time};
use crate::plot::{Color, Figure, LessonPictures, Panel, Scale, figures};
use crate::scene::RecordSpec;

/// A sink that keeps the pictures of a run for its figures.
#[derive(Debug)]
pub struct RunFigures {
    spec: RecordSpec,
    rec: RecordingStream,
    encoder: Option<Encoder>,
    lesson: LessonPictures,
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
            encoder: None,
            lesson: LessonPictures::default(),
        }
    }

    /// The figures; what the run has no data for is missing.
    pub fn figures(&self) -> Vec<Figure> {
        let Some(Encoder { header, .. }) = &self.encoder else {
            return Vec::new();
        };
        let (rec, spec) = (&self.rec, self.spec);
        let run = Run { header, spec };
        let lesson = self.lesson.panels(header);
        figures(&header.scene, |name| match name.strip_prefix("lesson-") {
            Some(number) => lesson.get(number.parse::<usize>().ok()? - 1).cloned(),
            None => run.panel(rec, name),
        })
    }
}

impl Sink for &mut RunFigures {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        if let Record::Header(header) = &record {
            self.encoder = Some(Encoder::new(&self.rec, Arc::clone(header), self.spec));
        }
        if let Some(encoder) = &mut self.encoder {
            encoder.accept(&self.rec, &record);
            self.lesson.accept(&encoder.header, &record);
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        if let Some(encoder) = &mut self.encoder {
            encoder.finish(&self.rec);
        }
        Ok(())
    }
}

/// Time series as a panel; those of the last part of a run start at zero. `None` without values.
pub fn series_panel(
    title: &str,
    curves: impl Iterator<Item = Curve>,
    is_recent: bool,
) -> Option<Panel> {
    let has_values = |(.., points): &Curve| points.iter().any(|point| point[1].is_finite());
    let mut curves: Vec<Curve> = curves.filter(has_values).collect();
    let [start, _] = curves.first()?.2[0];
    for (label, color, points) in &mut curves {
        let zero = if is_recent { start } else { 0.0 };
        points.iter_mut().for_each(|point| point[0] -= zero);
        // The ends of intervals have a paler colour than their middle.
        if matches!(color, Color::Shade(_)) {
            label.clear();
        }
    }
    // A single curve is named by the axis.
    let name = match &mut curves[..] {
        [(label, ..)] => std::mem::take(label),
        _ => String::new(),
    };
    // What follows a colon explains the colours of the viewer.
    let title = title.split(": ").next().unwrap_or_default();
    Some(over_time(title, (&name, "", Scale::Linear), &curves))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::figure_names;
    use crate::record::tests::demo;

    /// A run of a joint with all analyses has a figure of each, and each panel of it has data.
    #[test]
    fn a_run_has_the_figures_of_its_recording() {
        let mut kept = RunFigures::new(demo::spec());
        let mut sink = &mut kept;
        for record in demo::records(0.05) {
            sink.accept(record).unwrap();
        }
        sink.finish().unwrap();
        let found = kept.figures();
        let names: Vec<&str> = found.iter().map(|figure| &*figure.name).collect();
        // Those of the others are of signals, or of a scene with a lesson.
        let absent = ["lesson", "events", "waveform"];
        for name in figure_names().iter().filter(|name| !absent.contains(name)) {
            assert!(names.contains(name), "{name}: {names:?}");
        }
        let energy = found.iter().find(|figure| figure.name == "energy").unwrap();
        assert_eq!(energy.rows.len(), 3);
        for panel in found.iter().flat_map(|figure| figure.rows.concat()) {
            assert!(!panel.layers.is_empty(), "{}", panel.title);
            assert!(!panel.title.contains("blue"), "{}", panel.title);
        }
    }

    fn panel(curves: &[(&str, &[[f64; 2]])]) -> Option<Panel> {
        let curves = curves.iter();
        let curves = curves.map(|(name, points)| ((*name).to_owned(), Color::Run, points.to_vec()));
        series_panel("Energy, µJ: stored blue", curves, true)
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
        // A line would bridge the gap.
        let values = vec![[0.0, 1.0], [2.0, 3.0], [3.0, 3.0]];
        assert_eq!(two.layers[0].shape, crate::plot::Shape::Points(values));
    }
}
