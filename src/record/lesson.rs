//! The lesson of a scene with a mechanism, and its plots: velocity level compared with the computed growth,
//! strongest line over the tilt, and computed curves.

use crate::record::sdk::SeriesLines;

use super::{
    error::RecordError,
    panel_view::PanelView,
    paths::{self, Root},
    samples::Rows,
    stream::{self, RecordingStream},
    style, text,
};
use crate::{
    pipeline::message::{
        self, Header, LevelSample, MechanismPrediction, TiltDirection, TiltedTone,
    },
    plot::{Panel, prediction_panel, tone_loop},
    text::LessonText,
};

/// Draws the text and the plots of a lesson.
#[derive(Debug)]
pub struct Lesson {
    text: LessonText,
    /// The hysteresis loop, if the tilt varies.
    hysteresis: Option<HysteresisLoop>,
}

/// The strongest line over the tilt.
#[derive(Debug)]
struct HysteresisLoop {
    view: PanelView,
    /// Tilt and frequency for increasing and for decreasing tilt.
    tones: [Vec<[f64; 2]>; 2],
}

impl Lesson {
    /// Names the series, and draws the computed values.
    pub fn new(
        rec: &RecordingStream,
        rows: &mut Rows,
        header: &Header,
        computed: &MechanismPrediction,
    ) -> Result<Self, RecordError> {
        let mut one = |path, name, color| rows.name(rec, path, [(name, color)]);
        one(paths::LESSON_VELOCITY_LEVEL, "measured", style::SIGNAL)?;
        one(paths::LESSON_PREDICTED, "computed growth", style::ACCENT)?;
        let width = SeriesLines::update_fields().with_widths([2.4]);
        rec.log_static(paths::LESSON_PREDICTED, &width)?;
        if let Some(picture) = &computed.picture {
            let mut view = PanelView::of("computed", &Root::of_run());
            view.draw(rec, None, &prediction_panel(picture))?;
        }
        let hysteresis = match empty_loop(header) {
            Some(panel) => {
                let mut view = PanelView::of("line-over-tilt", &Root::of_run());
                view.draw_axes(rec, None, &panel)?;
                let tones = Default::default();
                Some(HysteresisLoop { view, tones })
            }
            None => None,
        };
        Ok(Self {
            text: LessonText::default(),
            hysteresis,
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
    pub fn push(
        &mut self,
        rec: &RecordingStream,
        rows: &mut Rows,
        header: &Header,
        course: &LevelSample,
    ) -> Result<(), RecordError> {
        // Logarithm of the level in mm/s; a gap where it is not finite.
        let shown = |level: f64| match (1e3 * level).log10() {
            log if log.is_finite() => log,
            _ => f64::NAN,
        };
        if let Some(tone) = &course.tone {
            return match &mut self.hysteresis {
                Some(hysteresis) => hysteresis.push(rec, (header, course.time), tone),
                None => Ok(()),
            };
        }
        let predicted = course.predicted.map_or(f64::NAN, shown);
        rows.push(
            paths::LESSON_VELOCITY_LEVEL,
            course.time,
            [shown(course.level)],
        );
        rows.push(paths::LESSON_PREDICTED, course.time, [predicted]);
        Ok(())
    }
}

impl HysteresisLoop {
    fn push(
        &mut self,
        rec: &RecordingStream,
        (header, time): (&Header, f64),
        tone: &TiltedTone,
    ) -> Result<(), RecordError> {
        let point = [tone.tilt.to_degrees(), tone.frequency];
        let way = usize::from(tone.way == TiltDirection::Down);
        self.tones[way].push(point);
        let Some(joint) = header.joint() else {
            return Ok(());
        };
        let panel = tone_loop(joint, self.tones.clone(), vec![point]);
        let changed = [&panel.layers[way], &panel.layers[2]].map(Clone::clone);
        let plot = self.view.plot(&panel);
        self.view
            .draw_layers(rec, Some(time.into()), &plot, &changed)
    }
}

/// The plot of the strongest line over the tilt without data; `None` if the tilt is constant or there is no joint.
pub fn empty_loop(header: &Header) -> Option<Panel> {
    let joint = header.joint()?;
    (joint.min_tilt < joint.max_tilt).then(|| tone_loop(joint, Default::default(), Vec::new()))
}

#[cfg(test)]
mod tests {
    use super::super::{Output, RerunSink, tests::read};
    use super::*;
    use crate::pipeline::{Monitor, run};
    use crate::scene::Mechanism;

    /// Entities that show each mechanism.
    fn evidence_entities(mechanism: Mechanism) -> &'static [&'static str] {
        match mechanism {
            Mechanism::NegativeSlope | Mechanism::ModeCoupling | Mechanism::ExchangedFriction => &[
                paths::LESSON_VELOCITY_LEVEL,
                paths::LESSON_PREDICTED,
                "lesson/computed/curves",
                "lesson/computed/marks",
            ],
            Mechanism::Bristles | Mechanism::ContactAge | Mechanism::MeasuredFriction => &[
                paths::LESSON_VELOCITY_LEVEL,
                paths::LESSON_PREDICTED,
                "lesson/computed/curves",
                "lesson/computed/marks",
            ],
            Mechanism::Articulation => &[
                paths::LESSON_VELOCITY_LEVEL,
                "lesson/computed/curves",
                "lesson/hysteresis/up",
            ],
            Mechanism::StickSlip => &[paths::PORTRAIT_TRAIL, paths::VELOCITY],
            Mechanism::LiftOff => &[paths::NODES, paths::NODE_COUNTS, paths::CONTACT_FORCE],
            Mechanism::WhichModeWins | Mechanism::Prediction => {
                &["spectrum/computed", paths::MODES_ENERGY]
            }
            Mechanism::Hysteresis => &["lesson/hysteresis/up", "lesson/hysteresis/now"],
            Mechanism::Torus => &["spectrum/peaks", "poincare_section/points"],
            Mechanism::TorusBirth => &["spectrum/peaks", "lesson/computed/curves"],
            Mechanism::Chaos => &[
                paths::DIVERGENCE_DISTANCE,
                "divergence/phase_portrait/reference",
            ],
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
