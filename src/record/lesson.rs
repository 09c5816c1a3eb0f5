//! The lesson of a scene that shows a mechanism, and the pictures that prove it: the velocity level
//! against the computed growth, the strongest line over the tilt, and computed curves.

use std::sync::Arc;

use rerun::{Color, LineStrips2D, Points2D, Radius, SeriesLines};

use super::{
    error::RecordError,
    paths,
    plot::{self, Bounds, Plot},
    samples::{Rows, name_series},
    spectrum::SpectrumPlot,
    stream::{self, RecordingStream},
    style, text,
};
use crate::{
    analysis::range,
    pipeline::message::{
        self, Computed, ComputedPicture, Course, CurveSubject, Header, TiltedTone, Way,
    },
    plot::Axis,
    scene::Mechanism,
    text::LessonText,
};

/// Colours of computed curves.
const CURVES: [Color; 3] = [style::SIGNAL, style::SECOND, style::ROTATION];

/// Draws a lesson.
#[derive(Debug)]
pub struct Lesson {
    text: LessonText,
    level: Rows,
    foretold: Rows,
    /// The loop, where there is one.
    turns: Option<Turns>,
}

/// What is heard at which tilt.
#[derive(Debug)]
struct Turns {
    plot: Plot,
    /// Points of the plot on the way up and on the way down.
    heard: [Vec<[f64; 2]>; 2],
}

impl Lesson {
    /// Names the series, and draws what was computed.
    pub fn new(
        rec: &RecordingStream,
        header: &Header,
        computed: &Arc<Computed>,
        spectrum: &SpectrumPlot,
    ) -> Result<Self, RecordError> {
        let one = |path, name: &str, color| name_series(rec, path, [name.to_owned()], [color]);
        one(paths::LESSON_LEVEL, "measured", style::SIGNAL)?;
        one(paths::LESSON_FORETOLD, "computed growth", style::ACCENT)?;
        let width = SeriesLines::update_fields().with_widths([2.4]);
        rec.log_static(paths::LESSON_FORETOLD, &width)?;
        let compares = [Mechanism::WhichModeWins, Mechanism::Prediction];
        if compares.contains(&computed.mechanism) {
            draw_modes(rec, computed, spectrum)?;
        }
        if let Some(picture) = &computed.picture {
            draw_picture(rec, picture)?;
        }
        let turns = turns_plot(header);
        if let Some(plot) = &turns {
            plot.draw(rec, paths::LESSON_LOOP, None)?;
            plot.draw_key(rec, paths::LESSON_LOOP, &turns_key())?;
        }
        Ok(Self {
            text: LessonText::default(),
            level: Rows::new(paths::LESSON_LEVEL, 1),
            foretold: Rows::new(paths::LESSON_FORETOLD, 1),
            turns: turns.map(|plot| Turns {
                plot,
                heard: [Vec::new(), Vec::new()],
            }),
        })
    }

    /// Shows the lesson in words, if they have changed.
    pub fn write(
        &mut self,
        rec: &RecordingStream,
        now: &message::Lesson,
    ) -> Result<(), RecordError> {
        match self.text.next(now) {
            Some(words) => stream::log_at(rec, paths::LESSON, now.time, &text::document(words)),
            None => Ok(()),
        }
    }

    /// Takes a point of the course.
    pub fn push(&mut self, rec: &RecordingStream, course: &Course) -> Result<(), RecordError> {
        // Of the logarithm of the level in mm/s; a gap where there is none.
        let shown = |level: f64| match (1e3 * level).log10() {
            log if log.is_finite() => log,
            _ => f64::NAN,
        };
        if let Some(tone) = &course.tone {
            return match &mut self.turns {
                Some(turns) => turns.push(rec, course.time, tone),
                None => Ok(()),
            };
        }
        self.level.push(course.time, [shown(course.level)]);
        let foretold = course.predicted.map_or(f64::NAN, shown);
        self.foretold.push(course.time, [foretold]);
        self.level.send_full(rec)?;
        self.foretold.send_full(rec)
    }

    /// Sends what is left.
    pub fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        self.level.send(rec)?;
        self.foretold.send(rec)
    }
}

impl Turns {
    fn push(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        tone: &TiltedTone,
    ) -> Result<(), RecordError> {
        let point = [tone.tilt.to_degrees(), 1e-3 * tone.frequency];
        let (way, path, color) = match tone.way {
            Way::Up => (0, paths::LESSON_LOOP_UP, style::SIGNAL),
            Way::Down => (1, paths::LESSON_LOOP_DOWN, style::ACCENT),
        };
        self.heard[way].push(point);
        let heard = self.heard[way].iter().copied();
        self.plot
            .draw_points(rec, path, time, heard, (color, 3.0))?;
        let now = Points2D::new([self.plot.at(point[0], point[1])])
            .with_colors([style::POLE])
            .with_radii([Radius::new_ui_points(5.0)])
            .with_draw_order(1.0);
        stream::log_at(rec, paths::LESSON_LOOP_NOW, time, &now)
    }
}

fn turns_key() -> Vec<(String, Color)> {
    vec![
        ("way up".to_owned(), style::SIGNAL),
        ("way down".to_owned(), style::ACCENT),
        ("now".to_owned(), style::POLE),
    ]
}

/// The plot of pitch over tilt, of a joint whose tilt changes.
fn turns_plot(header: &Header) -> Option<Plot> {
    let joint = header.joint()?;
    let [low, high] = [joint.min_tilt, joint.max_tilt].map(f64::to_degrees);
    let frequencies = joint.modes.iter().map(|mode| 1e-3 * mode.frequency_hz);
    let [_, highest] = range(frequencies);
    (low < high).then(|| Plot {
        width: 400.0,
        height: 260.0,
        head: plot::key_height(400.0, &turns_key()),
        x: Axis::linear("tilt, degrees", [low, 1.05 * high]),
        y: Axis::closely(
            "strongest line, kHz",
            [1.0, 1.2 * highest.max(2.0)].into_iter(),
        ),
        grid: true,
    })
}

/// What the view of the loop must show; `None` where the tilt is constant.
pub fn turns_bounds(header: &Header) -> Option<Bounds> {
    turns_plot(header).map(|plot| plot.bounds())
}

/// The title of a computed picture.
pub fn picture_title(picture: &ComputedPicture) -> &'static str {
    match picture.subject {
        CurveSubject::Friction => "Computed: friction over sliding speed; dots: steady sliding",
        CurveSubject::Flutter => {
            "Computed: two frequencies merge, and growth begins; dots: this run"
        }
    }
}

fn picture_key(picture: &ComputedPicture) -> Vec<(String, Color)> {
    let names: &[&str] = match (picture.subject, picture.curves.len()) {
        (CurveSubject::Friction, 1) => &["the belt's friction"],
        (CurveSubject::Friction, _) => &["as in the scene", "exchanged"],
        (CurveSubject::Flutter, _) => &["lower frequency", "higher frequency", "growth rate"],
    };
    let names = names.iter().map(|&name| name.to_owned());
    names.zip(CURVES).collect()
}

fn picture_plot(picture: &ComputedPicture) -> Plot {
    let points = || picture.curves.iter().flatten();
    let [x_low, x_high] = range(points().map(|p| p[0]));
    let [y_low, y_high] = range(points().map(|p| p[1]));
    let [x, y] = match picture.subject {
        CurveSubject::Friction => ["sliding speed, mm/s", "coefficient of friction"],
        CurveSubject::Flutter => ["coefficient of friction", "frequency, Hz; growth rate, 1/s"],
    };
    Plot {
        width: 400.0,
        height: 260.0,
        head: plot::key_height(400.0, &picture_key(picture)),
        x: Axis::linear(x, [x_low, x_high]),
        y: Axis::linear(y, [y_low.min(0.0), 1.1 * y_high]),
        grid: true,
    }
}

/// What the view of a computed picture must show.
pub fn picture_bounds(picture: &ComputedPicture) -> Bounds {
    picture_plot(picture).bounds()
}

/// Curves, and where the run is on them.
fn draw_picture(rec: &RecordingStream, picture: &ComputedPicture) -> Result<(), RecordError> {
    let plot = picture_plot(picture);
    plot.draw(rec, paths::LESSON_COMPUTED, None)?;
    plot.draw_key(rec, paths::LESSON_COMPUTED, &picture_key(picture))?;
    let at = |points: &[[f64; 2]]| {
        points
            .iter()
            .map(|p| plot.at(p[0], p[1]))
            .collect::<Vec<_>>()
    };
    let curves = LineStrips2D::new(picture.curves.iter().map(|curve| at(curve)))
        .with_colors(picture_key(picture).into_iter().map(|(_, color)| color))
        .with_radii([Radius::new_ui_points(1.2)]);
    rec.log_static(paths::LESSON_COMPUTED_CURVES, &curves)?;
    let marks = Points2D::new(at(&picture.marks))
        .with_colors([style::ACCENT])
        .with_radii([Radius::new_ui_points(5.0)])
        .with_draw_order(1.0);
    rec.log_static(paths::LESSON_COMPUTED_MARKS, &marks)
}

/// The computed frequencies of the modes that grow, as lines across the spectrum.
fn draw_modes(
    rec: &RecordingStream,
    computed: &Computed,
    spectrum: &SpectrumPlot,
) -> Result<(), RecordError> {
    let plot = &spectrum.plot;
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

    /// What the picture of each mechanism is made of.
    fn proofs(mechanism: Mechanism) -> &'static [&'static str] {
        match mechanism {
            Mechanism::NegativeSlope | Mechanism::ModeCoupling | Mechanism::ExchangedFriction => &[
                paths::LESSON_LEVEL,
                paths::LESSON_FORETOLD,
                paths::LESSON_COMPUTED_CURVES,
                paths::LESSON_COMPUTED_MARKS,
            ],
            Mechanism::StickSlip => &[paths::PORTRAIT_TRAIL, paths::VELOCITY],
            Mechanism::LiftOff => &[paths::NODES, paths::NODE_COUNTS, paths::CONTACT_FORCE],
            Mechanism::WhichModeWins | Mechanism::Prediction => {
                &[paths::SPECTRUM_COMPUTED, paths::MODES_ENERGY]
            }
            Mechanism::Hysteresis => &[paths::LESSON_LOOP_UP, paths::LESSON_LOOP_NOW],
            Mechanism::Torus => &[paths::SPECTRUM_PEAKS, paths::SECTION_POINTS],
            Mechanism::Chaos => &[paths::BUTTERFLY_DISTANCE, paths::BUTTERFLY_FIRST],
        }
    }

    #[test]
    fn a_lesson_is_recorded_with_its_proof() {
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
            let told = entities[paths::LESSON].rows;
            assert!((2..=6).contains(&told), "{}: {told}", preset.name);
            for proof in proofs(mechanism) {
                assert!(entities.contains_key(*proof), "{}: {proof}", preset.name);
            }
        }
    }
}
