//! The pictures of a lesson: what its text names, computed and measured.

use std::collections::VecDeque;

use super::response::{over_time, run_spectrum_axes, spectrum};
use super::{Axis, Color, Layer, Panel, Scale};
use crate::analysis::{stats::range, tones::SpectralLine};
use crate::pipeline::message::{
    Header, JointInfo, LevelSample, NodeState, PredictedCurves, Record, StatusKind, Subject,
    TiltDirection, TrajectoryDivergence,
};
use crate::scene::{Evidence, Mechanism};

/// Most points of a curve.
const POINTS: f64 = 500.0;
/// Time over which a course is shown, s.
const COURSE: f64 = 0.5;
/// Time over which the contact of a joint is shown, s, and that of a small system in periods.
const CONTACT: f64 = 5e-3;
const PERIODS: f64 = 6.0;
/// Most points of the hysteresis loop.
const LOOP: usize = 4000;
/// Number of modes of which the energy is shown, those with the most.
const MODES: usize = 6;

/// Values over the last part of a run, in about [`POINTS`] points.
#[derive(Debug, Default)]
struct Course {
    points: VecDeque<(f64, Vec<f64>)>,
    /// Time after which nothing is added, s: what the course shows is over.
    end: Option<f64>,
}

impl Course {
    /// Adds values at a time (s); only the last `span` seconds remain.
    fn push(&mut self, time: f64, values: Vec<f64>, span: f64) {
        let last = self.points.back().map_or(f64::NEG_INFINITY, |(t, _)| *t);
        if time - last < span / POINTS || self.end.is_some_and(|end| time > end) {
            return;
        }
        let old = self.points.partition_point(|(t, _)| time - t > span);
        self.points.drain(..old);
        self.points.push_back((time, values));
    }

    /// A panel of values over the time: their indices with colours and labels. A logarithmic axis is for positive values.
    fn panel(
        &self,
        title: &str,
        axis: (&str, &str, Scale),
        curves: &[(usize, Color, &str)],
    ) -> Panel {
        let curves = curves.iter().map(|&(k, color, label)| {
            let points = self.points.iter().map(|(t, values)| [*t, values[k]]);
            (label.to_owned(), color, 1.0, points.collect())
        });
        over_time(title, axis, None, &Vec::from_iter(curves))
    }
}

/// What the pictures of the lesson of a run show, kept from its records.
#[derive(Debug, Default)]
pub struct LessonPictures {
    /// What the lesson is about: level and prediction, m/s; or the distance of the perturbed trajectory; or the energy of
    /// each mode, J; or, of the contact of a joint, normal force and friction, N, and the numbers of nodes that slip, stick
    /// and are separated; or, of a small system, displacement (m), velocity (m/s), and 1 while it sticks.
    course: Course,
    /// Tilt (deg) and strongest line (Hz), each with whether the tilt falls.
    tones: VecDeque<([f64; 2], bool)>,
    /// The last result of the perturbed trajectory.
    divergence: Option<TrajectoryDivergence>,
    /// Spacing of the bins, Hz, amplitudes, m/s, and lines of the spectrum.
    spectrum: (f64, Vec<f64>, Vec<SpectralLine>),
}

impl LessonPictures {
    /// Keeps what the lesson of a run shows of a record.
    pub fn accept(&mut self, header: &Header, record: &Record) {
        let Some(computed) = &header.computed else {
            return;
        };
        let evidence = computed.mechanism.evidence();
        match record {
            Record::Samples(frame) if evidence == Evidence::Growth && !frame.kicks.is_empty() => {
                self.course = Course::default();
            }
            Record::LevelSample(sample) if evidence == Evidence::Growth => self.add_level(sample),
            Record::LevelSample(LevelSample { tone, .. }) => {
                let point = tone.map(|tone| [tone.tilt.to_degrees(), tone.frequency]);
                let falls = tone.is_some_and(|tone| tone.way == TiltDirection::Down);
                self.tones.extend(point.map(|point| (point, falls)));
                self.tones.drain(..self.tones.len().saturating_sub(LOOP));
            }
            Record::TrajectoryDivergence(found) if evidence == Evidence::Divergence => {
                let saturated = found.saturated_s;
                self.course.end = saturated.map(|time| 2.0 * time - found.start_s);
                let distance = vec![found.distance];
                self.course.push(found.time_s, distance, 2.0 * COURSE);
                self.divergence = Some(*found);
            }
            Record::Samples(frame) if evidence == Evidence::Modes => {
                for sample in &frame.energy {
                    self.course.push(sample.time, sample.modal.clone(), COURSE);
                }
            }
            Record::Samples(frame) if evidence == Evidence::Contact => {
                for snapshot in &frame.patch {
                    let states = [NodeState::Slip, NodeState::Stick, NodeState::Separated];
                    let counts = states.map(|state| snapshot.count(state) as f64);
                    let contact = snapshot.forces().into_iter().chain(counts).collect();
                    self.course.push(snapshot.time, contact, CONTACT);
                }
                if let Subject::Small(small) = &header.subject {
                    for (k, &status) in frame.status.iter().enumerate() {
                        let status = small.statuses.get(usize::from(status));
                        let holds = status.is_some_and(|status| status.kind == StatusKind::Held);
                        let [u, v] = [frame.displacement[k], frame.velocity[k]];
                        let span = PERIODS / small.frequency_hz;
                        let values = vec![u, v, f64::from(u8::from(holds))];
                        self.course.push(frame.time(k), values, span);
                    }
                }
            }
            Record::Spectrum {
                bin,
                amplitude,
                peaks,
                ..
            } => self.spectrum = (*bin, amplitude.clone(), peaks.clone()),
            _ => {}
        }
    }

    fn add_level(&mut self, sample: &LevelSample) {
        let time = sample.time;
        let predicted = sample.predicted.unwrap_or(f64::NAN);
        let ends = [self.course.points.front(), self.course.points.back()];
        if let [Some((start, _)), Some((_, last))] = ends
            && last[1].is_finite()
            && predicted.is_nan()
        {
            // The growth and half as long after it.
            self.course.end = Some(time + 0.5 * (time - start));
        }
        self.course
            .push(time, vec![sample.level, predicted], COURSE);
    }

    /// The pictures that the lesson of a run names; empty for a scene without a mechanism.
    pub fn panels(&self, header: &Header) -> Vec<Panel> {
        let Some(computed) = &header.computed else {
            return Vec::new();
        };
        let mut panels = match computed.mechanism.evidence() {
            Evidence::Growth => {
                let curves = [
                    (0, Color::Run, "measured"),
                    (1, Color::Compared, "computed growth"),
                ];
                let level = ("level", "m/s", Scale::Logarithmic);
                vec![self.course.panel("Velocity level", level, &curves)]
            }
            Evidence::Turning | Evidence::Loop => {
                let way = |down| self.tones.iter().filter(move |(_, falls)| *falls == down);
                let tones = [false, true].map(|down| way(down).map(|(at, _)| *at).collect());
                let now = Vec::from_iter(self.tones.back().map(|(at, _)| *at));
                let picture = |joint| tone_loop(joint, tones, now);
                Vec::from_iter(header.joint().map(picture))
            }
            Evidence::Contact if header.joint().is_none() => vec![self.portrait()],
            Evidence::Contact if computed.mechanism == Mechanism::StickSlip => vec![self.nodes()],
            Evidence::Contact => {
                let curves = [(0, Color::Run, "normal"), (1, Color::Compared, "friction")];
                let force = ("force", "N", Scale::Linear);
                let forces = self.course.panel("Contact force", force, &curves);
                vec![forces, self.nodes()]
            }
            Evidence::Modes => vec![self.energies(header), self.spectrum(header)],
            Evidence::Torus | Evidence::Birth => vec![self.spectrum(header)],
            Evidence::Divergence => vec![self.distance()],
        };
        panels.extend(computed.picture.as_ref().map(prediction_panel));
        panels
    }

    fn distance(&self) -> Panel {
        let title = "Distance of the perturbed trajectory";
        let axis = ("relative to the motion", "", Scale::Logarithmic);
        let curve = (0, Color::Run, "distance");
        let mut panel = self.course.panel(title, axis, &[curve]);
        if let Some((now, line)) = self.divergence.and_then(|now| Some((now, now.line?))) {
            let at = |t: f64| {
                let level = line.intercept + line.rate_per_s * (t - now.start_s);
                [t, level.exp()]
            };
            let ends = vec![at(line.since_s), at(now.saturated_s.unwrap_or(now.time_s))];
            let line = Layer::line(ends, Color::Compared);
            panel.layers.push(line.with_label("straight line"));
        }
        panel
    }

    fn energies(&self, header: &Header) -> Panel {
        let modes = header.joint().map_or(&[][..], |joint| &joint.modes);
        let most = |k: &usize| {
            let values = self.course.points.iter().map(|(_, energies)| energies[*k]);
            values.fold(0.0, f64::max)
        };
        let mut order: Vec<usize> = (0..modes.len()).collect();
        order.sort_by(|a, b| most(b).total_cmp(&most(a)));
        let curves = order.iter().zip(0..MODES);
        let curves = curves.map(|(&k, color)| (k, Color::Series(color), &*modes[k].label));
        let curves: Vec<_> = curves.collect();
        let energy = ("energy", "J", Scale::Logarithmic);
        self.course.panel("Energy of each mode", energy, &curves)
    }

    fn nodes(&self) -> Panel {
        let curves = [
            (2, Color::Run, "slip"),
            (3, Color::Compared, "stick"),
            (4, Color::Ink, "separated"),
        ];
        let nodes = ("nodes", "", Scale::Linear);
        self.course.panel("Contact nodes", nodes, &curves)
    }

    fn portrait(&self) -> Panel {
        let values = || self.course.points.iter().map(|(_, values)| values);
        let layer = |holds: f64, color, label| {
            let points = values().filter(|values| values[2] == holds);
            let points = points.map(|v| [v[0], v[1]]).collect();
            Layer::points(points, 1.2, color).with_label(label)
        };
        let layers = vec![
            layer(0.0, Color::Run, "slides"),
            layer(1.0, Color::Compared, "sticks"),
        ];
        let x = Axis::with_margin("displacement", values().map(|v| v[0])).of("m");
        let y = Axis::with_margin("velocity", values().map(|v| v[1])).of("m/s");
        Panel::new("Phase portrait", x, y, layers)
    }

    /// The spectrum with its named lines, and with computed frequencies as grey lines.
    fn spectrum(&self, header: &Header) -> Panel {
        let (bin, amplitude, lines) = &self.spectrum;
        let named = lines.iter().filter(|line| !line.label.is_empty());
        let named: Vec<SpectralLine> = named.cloned().collect();
        let axes = run_spectrum_axes(header);
        let mut panel = spectrum(&axes, *bin, amplitude.iter().copied(), &named, Color::Run);
        for layer in &mut panel.layers {
            match &*layer.id {
                "computed" => layer.label = "computed, unstable modes".to_owned(),
                "curve" => layer.label = "measured".to_owned(),
                _ => {}
            }
        }
        panel.with_title("Spectrum")
    }
}

/// The strongest line (Hz) over the tilt (deg), with rising and with falling tilt and now: the hysteresis loop. `modes`
/// gives the axes.
pub fn tone_loop(joint: &JointInfo, [up, down]: [Vec<[f64; 2]>; 2], now: Vec<[f64; 2]>) -> Panel {
    let layers = [
        (up, 2.0, Color::Run, "rising tilt", "up"),
        (down, 2.0, Color::Compared, "falling tilt", "down"),
        (now, 3.5, Color::Ink, "now", "now"),
    ];
    let layers = layers.map(|(points, radius, color, label, id)| {
        let points = Layer::points(points, radius, color);
        points.with_label(label).with_id(id)
    });
    let [low, high] = [joint.min_tilt, joint.max_tilt].map(f64::to_degrees);
    let frequencies = joint.modes.iter().map(|mode| mode.frequency_hz);
    let highest = 1.2 * frequencies.fold(2e3, f64::max);
    let x = Axis::linear("tilt, deg", [low, 1.05 * high]);
    let y = Axis::rounded_logarithmic("strongest line", [1e3, highest].into_iter()).of("Hz");
    Panel::new("Strongest line over tilt", x, y, layers.to_vec())
}

/// The computed curves of a lesson, with the operating points of the run.
pub fn prediction_panel(picture: &PredictedCurves) -> Panel {
    let points = || picture.curves.iter().flatten();
    let [x_low, x_high] = range(points().map(|p| p[0]));
    let [y_low, y_high] = range(points().map(|p| p[1]));
    let colors = [Color::Run, Color::Compared, Color::Series(2)];
    let curves = colors.into_iter().zip(&picture.curves).zip(picture.names);
    let curves = curves.map(|((color, curve), name)| {
        let curve = Layer::line(curve.clone(), color);
        curve.with_label(*name).with_id("curves")
    });
    let marks = Layer::points(picture.marks.clone(), 4.2, Color::Accent).with_id("marks");
    let x = Axis::linear(picture.axes[0], [x_low, x_high]);
    let y = Axis::linear(picture.axes[1], [y_low.min(0.0), (1.1 * y_high).max(0.0)]);
    Panel::new(picture.title, x, y, curves.chain([marks]).collect())
}
