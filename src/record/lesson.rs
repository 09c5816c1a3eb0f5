//! The lesson of a scene with a mechanism, and its plots: velocity level compared with the computed growth,
//! strongest line over the tilt, and computed curves.

use std::sync::Arc;

use rerun::{Color, LineStrips2D, Points2D, Radius, SeriesLines};

use super::{
    error::RecordError,
    panel_view::PanelView,
    paths,
    plot::{Bounds, Plot, legend_height},
    samples::{Rows, name_series},
    spectrum::SpectrumPlot,
    stream::{self, RecordingStream},
    style, text,
};
use crate::{
    analysis::range,
    pipeline::message::{
        self, Header, LevelSample, MechanismPrediction, PredictedCurves, TiltDirection, TiltedTone,
    },
    plot::{Axis, prediction_panel},
    scene::Mechanism,
    text::LessonText,
};

/// Size of the plots, pixels.
const FIELD: [f32; 2] = [400.0, 260.0];

/// Draws the text and the plots of a lesson.
#[derive(Debug)]
pub struct Lesson {
    text: LessonText,
    level: Rows,
    predicted_level: Rows,
    /// The hysteresis loop, if the tilt varies.
    hysteresis: Option<HysteresisLoop>,
}

/// The strongest line over the tilt.
#[derive(Debug)]
struct HysteresisLoop {
    plot: Plot,
    /// Tilt and frequency for increasing and for decreasing tilt.
    heard: [Vec<[f64; 2]>; 2],
}

impl Lesson {
    /// Names the series, and draws the computed values.
    pub fn new(
        rec: &RecordingStream,
        header: &Header,
        computed: &Arc<MechanismPrediction>,
        spectrum: &SpectrumPlot,
    ) -> Result<Self, RecordError> {
        let one = |path, name: &str, color| name_series(rec, path, [name.to_owned()], [color]);
        one(paths::LESSON_VELOCITY_LEVEL, "measured", style::SIGNAL)?;
        one(paths::LESSON_PREDICTED, "computed growth", style::ACCENT)?;
        let width = SeriesLines::update_fields().with_widths([2.4]);
        rec.log_static(paths::LESSON_PREDICTED, &width)?;
        let compares = [Mechanism::WhichModeWins, Mechanism::Prediction];
        if compares.contains(&computed.mechanism) {
            draw_modes(rec, computed, spectrum)?;
        }
        if let Some(picture) = &computed.picture {
            picture_view().draw(rec, None, &prediction_panel(picture))?;
        }
        let hysteresis = loop_plot(header);
        if let Some(plot) = &hysteresis {
            plot.draw(rec, paths::HYSTERESIS, None)?;
            plot.draw_legend(rec, paths::HYSTERESIS, &loop_legend())?;
        }
        Ok(Self {
            text: LessonText::default(),
            level: Rows::new(paths::LESSON_VELOCITY_LEVEL, 1),
            predicted_level: Rows::new(paths::LESSON_PREDICTED, 1),
            hysteresis: hysteresis.map(|plot| HysteresisLoop {
                plot,
                heard: [Vec::new(), Vec::new()],
            }),
        })
    }

    /// Logs the lesson as text if it has changed.
    pub fn write(
        &mut self,
        rec: &RecordingStream,
        now: &message::Lesson,
    ) -> Result<(), RecordError> {
        match self.text.next(now) {
            Some(words) => {
                let document = text::document(text::lists(words));
                stream::log_at(rec, paths::LESSON, now.time, &document)
            }
            None => Ok(()),
        }
    }

    /// Adds a point of the velocity level or of the hysteresis loop.
    pub fn push(&mut self, rec: &RecordingStream, course: &LevelSample) -> Result<(), RecordError> {
        // Logarithm of the level in mm/s; a gap where it is not finite.
        let shown = |level: f64| match (1e3 * level).log10() {
            log if log.is_finite() => log,
            _ => f64::NAN,
        };
        if let Some(tone) = &course.tone {
            return match &mut self.hysteresis {
                Some(hysteresis) => hysteresis.push(rec, course.time, tone),
                None => Ok(()),
            };
        }
        self.level.push(course.time, [shown(course.level)]);
        let predicted_level = course.predicted.map_or(f64::NAN, shown);
        self.predicted_level.push(course.time, [predicted_level]);
        self.level.send_full(rec)?;
        self.predicted_level.send_full(rec)
    }

    /// Sends pending rows.
    pub fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        self.level.send(rec)?;
        self.predicted_level.send(rec)
    }
}

impl HysteresisLoop {
    fn push(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        tone: &TiltedTone,
    ) -> Result<(), RecordError> {
        let point = [tone.tilt.to_degrees(), 1e-3 * tone.frequency];
        let (way, path, color) = match tone.way {
            TiltDirection::Up => (0, paths::HYSTERESIS_UP, style::SIGNAL),
            TiltDirection::Down => (1, paths::HYSTERESIS_DOWN, style::ACCENT),
        };
        self.heard[way].push(point);
        let heard = self.heard[way].iter().copied();
        self.plot
            .draw_points(rec, path, time, heard, (color, 3.0))?;
        let now = Points2D::new([self.plot.at(point[0], point[1])])
            .with_colors([style::POLE])
            .with_radii([Radius::new_ui_points(5.0)])
            .with_draw_order(1.0);
        stream::log_at(rec, paths::HYSTERESIS_NOW, time, &now)
    }
}

fn loop_legend() -> Vec<(String, Color)> {
    vec![
        ("increasing tilt".to_owned(), style::SIGNAL),
        ("decreasing tilt".to_owned(), style::ACCENT),
        ("current".to_owned(), style::POLE),
    ]
}

/// The plot of the strongest line over the tilt; `None` if the tilt is constant or there is no joint.
fn loop_plot(header: &Header) -> Option<Plot> {
    let joint = header.joint()?;
    let [low, high] = [joint.min_tilt, joint.max_tilt].map(f64::to_degrees);
    let frequencies = joint.modes.iter().map(|mode| 1e-3 * mode.frequency_hz);
    let [_, highest] = range(frequencies);
    (low < high).then(|| Plot {
        width: FIELD[0],
        height: FIELD[1],
        top_margin: legend_height(FIELD[0], &loop_legend()),
        x: Axis::linear("tilt, deg", [low, 1.05 * high]),
        y: Axis::rounded_logarithmic(
            "strongest line, kHz",
            [1.0, 1.2 * highest.max(2.0)].into_iter(),
        ),
        grid: true,
    })
}

/// Bounds of the view of the hysteresis loop; `None` if the tilt is constant.
pub fn loop_bounds(header: &Header) -> Option<Bounds> {
    loop_plot(header).map(|plot| plot.bounds())
}

fn picture_view() -> PanelView {
    PanelView::new(paths::LESSON_COMPUTED, FIELD)
}

/// Bounds of the view of a computed plot.
pub fn picture_bounds(picture: &PredictedCurves) -> Bounds {
    picture_view().bounds(&prediction_panel(picture))
}

/// Draws the computed frequencies of the unstable modes as vertical lines in the spectrum.
fn draw_modes(
    rec: &RecordingStream,
    computed: &MechanismPrediction,
    spectrum: &SpectrumPlot,
) -> Result<(), RecordError> {
    let plot = spectrum.plot();
    let unstable = computed.unstable();
    let shown = unstable
        .iter()
        .map(|mode| spectrum.frequency.per_si * mode.frequency_hz);
    let across = shown.filter(|frequency| *frequency <= plot.x.range[1]);
    let lines = across.map(|frequency| {
        let [x, _] = plot.at(frequency, plot.y.range[0]);
        [[x, 0.0], [x, plot.height]]
    });
    let lines = LineStrips2D::new(lines)
        .with_colors([style::AXIS])
        .with_radii([Radius::new_ui_points(0.8)])
        .with_draw_order(-0.5);
    rec.log_static(paths::SPECTRUM_COMPUTED, &lines)
}

#[cfg(test)]
mod tests {
    use super::super::{Output, RerunSink, tests::read};
    use super::*;
    use crate::pipeline::{Monitor, run};

    /// Entities that show each mechanism.
    fn evidence_entities(mechanism: Mechanism) -> &'static [&'static str] {
        match mechanism {
            Mechanism::NegativeSlope | Mechanism::ModeCoupling | Mechanism::ExchangedFriction => &[
                paths::LESSON_VELOCITY_LEVEL,
                paths::LESSON_PREDICTED,
                paths::LESSON_COMPUTED_CURVES,
                paths::LESSON_COMPUTED_MARKS,
            ],
            Mechanism::Bristles | Mechanism::ContactAge | Mechanism::MeasuredFriction => &[
                paths::LESSON_VELOCITY_LEVEL,
                paths::LESSON_PREDICTED,
                paths::LESSON_COMPUTED_CURVES,
                paths::LESSON_COMPUTED_MARKS,
            ],
            Mechanism::Articulation => &[
                paths::LESSON_VELOCITY_LEVEL,
                paths::LESSON_COMPUTED_CURVES,
                paths::HYSTERESIS_UP,
            ],
            Mechanism::StickSlip => &[paths::PORTRAIT_TRAIL, paths::VELOCITY],
            Mechanism::LiftOff => &[paths::NODES, paths::NODE_COUNTS, paths::CONTACT_FORCE],
            Mechanism::WhichModeWins | Mechanism::Prediction => {
                &[paths::SPECTRUM_COMPUTED, paths::MODES_ENERGY]
            }
            Mechanism::Hysteresis => &[paths::HYSTERESIS_UP, paths::HYSTERESIS_NOW],
            Mechanism::Torus => &[paths::SPECTRUM_PEAKS, paths::SECTION_POINTS],
            Mechanism::TorusBirth => &[paths::SPECTRUM_PEAKS, paths::LESSON_COMPUTED_CURVES],
            Mechanism::Chaos => &[paths::DIVERGENCE_DISTANCE, paths::REFERENCE_TRAIL],
        }
    }

    #[test]
    fn a_lesson_is_recorded_with_its_plots() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.rrd");
        for preset in crate::scene::PRESETS {
            let scene = preset.scene().unwrap().with_duration(100.0).unwrap();
            let output = Output {
                save: Some(path.clone()),
                ..Output::default()
            };
            let mut sink = RerunSink::new(&output, scene.record).unwrap();
            run(&scene, "", &mut sink, Monitor::default()).unwrap();
            let (entities, _) = read(&path, paths::TIMELINE);
            let Some(mechanism) = scene.mechanism else {
                let of_lesson = |path: &String| path.starts_with("lesson");
                assert!(!entities.keys().any(of_lesson), "{}", preset.name);
                continue;
            };
            let texts = entities[paths::LESSON].rows;
            assert!((2..=6).contains(&texts), "{}: {texts}", preset.name);
            for entity in evidence_entities(mechanism) {
                assert!(entities.contains_key(*entity), "{}: {entity}", preset.name);
            }
        }
    }
}
