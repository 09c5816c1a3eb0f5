//! Figures of a run: the pictures and the time series of its recording, as files.

use std::sync::Arc;

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
    encoder: Option<(RecordingStream, Encoder)>,
    lesson: LessonPictures,
}

impl RunFigures {
    /// Starts without pictures; `spec` is that of the scene.
    pub fn new(mut spec: RecordSpec) -> Self {
        // No figure shows the body.
        spec.body_rate = 0.0;
        Self {
            spec,
            encoder: None,
            lesson: LessonPictures::default(),
        }
    }

    /// The figures; what the run has no data for is missing.
    pub fn figures(&self) -> Vec<Figure> {
        let Some((rec, Encoder { header, .. })) = &self.encoder else {
            return Vec::new();
        };
        let spec = self.spec;
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
            let rec = RecordingStream::for_figures(header.duration);
            let encoder = Encoder::new(&rec, Arc::clone(header), self.spec);
            self.encoder = Some((rec, encoder));
        }
        if let Some((rec, encoder)) = &mut self.encoder {
            encoder.accept(rec, &record);
            self.lesson.accept(&encoder.header, &record);
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        if let Some((rec, encoder)) = &mut self.encoder {
            encoder.finish(rec);
        }
        Ok(())
    }
}

/// Time series as a panel over the times of the whole run (s), or, without these, of the last part of a run, which start
/// at zero. `None` without values.
pub fn series_panel(
    title: &str,
    curves: impl Iterator<Item = Curve>,
    whole: Option<[f64; 2]>,
) -> Option<Panel> {
    let mut curves: Vec<Curve> = curves.collect();
    // A single curve is named by the axis.
    let name = match &mut curves[..] {
        [(label, ..)] => std::mem::take(label),
        _ => String::new(),
    };
    curves.retain(|(.., points)| points.iter().any(|point| point[1].is_finite()));
    let [start, _] = curves.first()?.3[0];
    for (label, color, _, points) in &mut curves {
        if whole.is_none() {
            points.iter_mut().for_each(|point| point[0] -= start);
        }
        // The ends of intervals have a paler colour than their middle.
        if matches!(color, Color::Shade(_)) {
            label.clear();
        }
    }
    Some(over_time(title, (&name, "", Scale::Linear), whole, &curves))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Shape, figure_names};
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

    fn panel(curves: &[(&str, &[[f64; 2]])], whole: Option<[f64; 2]>) -> Option<Panel> {
        let curve = |(label, points): &(&str, &[[f64; 2]])| {
            ((*label).to_owned(), Color::Run, 0.9, points.to_vec())
        };

        series_panel("Energy, µJ", curves.iter().map(curve), whole)
    }

    #[test]
    fn time_series_become_a_panel() {
        assert_eq!(panel(&[], None), None);
        assert_eq!(panel(&[("K", &[[0.0, f64::NAN]])], None), None);
        let load: &[[f64; 2]] = &[[2.0, 5.0], [2.5, 7.0]];
        let one = panel(&[("load, N", load)], None).expect("a panel");
        assert_eq!(one.y.label(), "load, N");
        assert_eq!(one.x.range, [0.0, 0.5]);
        assert_eq!(one.layers[0].label, "");
        let whole = panel(&[("load, N", load)], Some([0.0, 4.0])).expect("a panel");
        assert_eq!(whole.x.range, [0.0, 4.0]);
        assert_eq!(whole.layers[0].shape, Shape::Lines(vec![load.to_vec()]));
        let curve: &[[f64; 2]] = &[[0.0, 1.0], [1.0, f64::NAN], [2.0, 3.0], [3.0, 3.0]];
        let two = panel(&[("a", curve), ("b", &[[1.0, f64::NAN]])], None).expect("a panel");
        assert_eq!((two.layers.len(), &*two.layers[0].label), (1, "a"));
        // A line would bridge the gap.
        let values = vec![[0.0, 1.0], [2.0, 3.0], [3.0, 3.0]];
        assert_eq!(two.layers[0].shape, Shape::Points(values));
    }
}
