//! The lesson of a scene with a mechanism, and its plots: velocity level compared with the computed growth,
//! strongest line over the tilt, and computed curves.

use super::panel_view::PanelView;
use super::paths::{self, Root};
use super::stream::{RecordingStream, STATIC};
use super::text;
use crate::pipeline::message::{self, Header, LevelSample, MechanismPrediction, TiltDirection};
use crate::plot::{Color, Panel, prediction_panel, tone_loop};

/// Draws the text and the plots of a lesson.
#[derive(Debug)]
pub struct Lesson {
    /// The last text.
    text: String,
    /// The strongest line over the tilt, if it varies: view, and tilt and frequency for rising and for falling tilt.
    hysteresis: Option<(PanelView, [Vec<[f64; 2]>; 2])>,
}

impl Lesson {
    /// Names the series, and draws the computed values.
    pub fn new(rec: &RecordingStream, header: &Header, computed: &MechanismPrediction) -> Self {
        rec.name(paths::LESSON_VELOCITY_LEVEL, [("measured", Color::Run)]);
        let predicted = vec![("computed growth".to_owned(), Color::Compared, 2.4)];
        rec.start(paths::LESSON_PREDICTED, predicted, true);
        if let Some(picture) = &computed.picture {
            let mut view = PanelView::of("computed", &Root::of_run());
            view.draw(rec, STATIC, &prediction_panel(picture));
        }
        let hysteresis = empty_loop(header).map(|panel| {
            let mut view = PanelView::of("line-over-tilt", &Root::of_run());
            view.draw_axes(rec, STATIC, &panel);
            (view, Default::default())
        });
        Self {
            text: String::new(),
            hysteresis,
        }
    }

    /// Logs the lesson as text if it has changed.
    pub fn write(&mut self, rec: &RecordingStream, now: &message::Lesson) {
        let words = crate::text::lesson(now);
        if words != self.text {
            rec.log("lesson/text", now.time, &text::document(&words));
            self.text = words;
        }
    }

    /// Adds a point of the velocity level or of the hysteresis loop.
    pub fn push(&mut self, rec: &RecordingStream, header: &Header, sample: &LevelSample) {
        let time = sample.time;
        let Some(tone) = &sample.tone else {
            // Logarithm of the level in mm/s; a gap where it is not finite.
            let levels = [
                (paths::LESSON_VELOCITY_LEVEL, Some(sample.level)),
                (paths::LESSON_PREDICTED, sample.predicted),
            ];
            for (path, level) in levels {
                let log = level.map(|level| (1e3 * level).log10());
                let log = log.filter(|log| log.is_finite());
                rec.row(path, time, [log.unwrap_or(f64::NAN)]);
            }
            return;
        };
        if let (Some((view, tones)), Some(joint)) = (&mut self.hysteresis, header.joint()) {
            let point = [tone.tilt.to_degrees(), tone.frequency];
            let way = usize::from(tone.way == TiltDirection::Down);
            tones[way].push(point);
            let panel = tone_loop(joint, tones.clone(), vec![point]);
            let changed = [&panel.layers[way], &panel.layers[2]].map(Clone::clone);
            view.draw_layers(rec, time.into(), &view.plot(&panel), &changed);
        }
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
        let mut recorded = Vec::new();
        for preset in crate::scene::PRESETS {
            let scene = preset.scene().unwrap().with_duration(100.0).unwrap();
            // Lessons do not use them.
            let unused = ["analysis.recurrence", "analysis.quantification"];
            let scene = scene.with_overrides(&unused.map(|table| (table, "absent")));
            let scene = scene.unwrap();
            // A joint and a small system of each mechanism, and without one.
            let kind = (scene.mechanism, scene.joint().is_ok());
            if recorded.contains(&kind) {
                continue;
            }
            recorded.push(kind);
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
            let texts = entities["lesson/text"].rows;
            assert!((2..=6).contains(&texts), "{}: {texts}", preset.name);
            for entity in evidence_entities(mechanism) {
                assert!(entities.contains_key(*entity), "{}: {entity}", preset.name);
            }
        }
    }
}
