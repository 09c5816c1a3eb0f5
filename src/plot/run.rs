//! The pictures of a run as panels, from its records. Recordings draw each one when it changes, and figures the last.

use std::collections::VecDeque;
use std::sync::Arc;

use super::chaos::{divergence, embedding, largest_exponents, zero_one_path};
use super::lyapunov::current_spectrum;
use super::response::{self, run_spectrum_axes, spectrum};
use super::{Color, FullScale, Panel, SectionAxes, Unit};
use crate::analysis::chaos::ScalingRegion;
use crate::analysis::poincare::SectionPoint;
use crate::pipeline::message::{DisplayRates, Header, Record, SignalInfo, Subject};

/// Number of intersections shown; a 4 kHz squeak has 1,000 in 0.25 s.
const PASSAGES: usize = 600;
/// Number of points of the path of the 0-1 test.
const PATH_POINTS: usize = 1000;
/// Smallest full scale of the exponents, 1/s.
const SMALLEST_EXPONENT: f64 = 1.0;

/// Draws a picture at a time (s): its name, which is that of its view in a recording, and its panel.
type Draw<'a> = dyn FnMut(f64, &'static str, Panel) + 'a;

/// Units of displacement and velocity of a subject.
pub fn units(subject: &Subject) -> [&str; 2] {
    match subject {
        Subject::Joint(_) | Subject::Small(_) => ["m", "m/s"],
        Subject::Signal(signal) => [&signal.unit; 2],
    }
}

/// Symbol of the samples: u for the displacement of a joint, x for that of a small system, y for a signal.
pub fn letter(subject: &Subject) -> &'static str {
    match subject {
        Subject::Joint(_) => "u",
        Subject::Small(_) => "x",
        Subject::Signal(_) => "y",
    }
}

/// Mean of a signal's range, and the smallest half-range worth showing: 1e-4 of half the range, and a positive value for a
/// constant signal.
pub fn range_shown([low, high]: [f64; 2]) -> [f64; 2] {
    let size = low.abs().max(high.abs());
    let least = if size > 0.0 { 1e-9 * size } else { 1e-9 };
    [0.5 * (low + high), (1e-4 * 0.5 * (high - low)).max(least)]
}

/// Half the range of the samples; positive.
pub fn full_scale(signal: &SignalInfo) -> f64 {
    let [low, high] = signal.span;
    (0.5 * (high - low)).max(range_shown(signal.span)[1])
}

/// Timer of the redraws of a plot: the time of the last picture, s.
#[derive(Debug, Default)]
pub struct RedrawTimer(Option<f64>);

impl RedrawTimer {
    /// Whether a picture is due at a time (s), at most at the picture rate of the viewer; without a viewer every change is
    /// drawn. If so, the interval starts again.
    pub fn is_due(&mut self, time: f64, shown: Option<DisplayRates>) -> bool {
        let interval = shown.map_or(0.0, |shown| 1.0 / shown.pictures);
        let due = self.0.is_none_or(|last| time >= last + interval);
        if due {
            self.0 = Some(time);
        }
        due
    }
}

/// The pictures of the analyses of a run, with what they keep of earlier records.
#[derive(Debug)]
pub struct RunPanels {
    header: Arc<Header>,
    spectrum: Panel,
    section: SectionAxes,
    /// The latest intersections, oldest first.
    recent: VecDeque<SectionPoint>,
    redraw: RedrawTimer,
    shown: Option<DisplayRates>,
    /// Time (s) and largest exponent between the ends of its interval (1/s) of each window that has one.
    largest: Vec<[f64; 4]>,
    /// Full scale of the Lyapunov exponents, 1/s.
    exponents: FullScale,
}

impl RunPanels {
    /// The pictures after a header.
    pub fn new(header: Arc<Header>) -> Self {
        Self {
            spectrum: run_spectrum_axes(&header),
            section: SectionAxes::of_run(&header),
            recent: VecDeque::with_capacity(PASSAGES),
            redraw: RedrawTimer::default(),
            shown: None,
            largest: Vec::new(),
            exponents: FullScale::new(SMALLEST_EXPONENT),
            header,
        }
    }

    /// Draws the pictures that a record changes.
    pub fn accept(&mut self, record: &Record, draw: &mut Draw<'_>) {
        let [unit, _] = units(&self.header.subject);
        match record {
            Record::Samples(frame) => self.shown = frame.shown,
            Record::Spectrum {
                time,
                bin,
                amplitude,
                peaks,
            } => {
                let values = amplitude.iter().copied();
                let panel = spectrum(&self.spectrum, *bin, values, peaks, Color::Ink);
                draw(*time, "spectrum", panel);
            }
            Record::Recurrence { time, image } => {
                let panel = response::recurrence(Some(image), true);
                let caption = response::recurrence_caption(image, unit);
                draw(*time, "recurrence", panel.with_caption(caption));
            }
            Record::Delay {
                time, dt, choice, ..
            } => {
                let [mutual, neighbours] = embedding(*dt, choice);
                draw(*time, "mutual-information", mutual);
                draw(*time, "false-neighbours", neighbours);
            }
            Record::Section { time, points } => self.section(*time, points, draw),
            Record::Chaos {
                time,
                dt,
                divergence: found,
                zero_one,
                ..
            } => {
                let found = (**found).clone().in_seconds(dt.recip());
                if let Some(ScalingRegion { slope, error, .. }) = found.region {
                    let [low, high] = [slope - error, slope + error];
                    self.largest.push([*time, low, slope, high]);
                }
                let start = self.header.start();
                let span = [start, (start + self.header.duration).max(*time)];
                let distance = match &self.header.subject {
                    Subject::Joint(_) | Subject::Small(_) => Unit::of(unit, 5e-7),
                    Subject::Signal(signal) => Unit::of(unit, full_scale(signal)),
                };
                let path = zero_one_path(zero_one, unit, PATH_POINTS).square();
                let largest = largest_exponents(&self.largest, span);
                draw(*time, "divergence", divergence(&found, &distance));
                draw(*time, "zero-one-path", path);
                draw(*time, "largest-exponent", largest);
            }
            Record::Exponents(found) => {
                // Exponents of minus infinity have no position on the axis.
                let exponents = found.spectrum.exponents.iter();
                let ends = exponents.flat_map(|e| [e.value.abs(), e.low().abs(), e.high().abs()]);
                let largest = ends.filter(|end| end.is_finite()).fold(0.0, f64::max);
                self.exponents.update(1.1 * largest, SMALLEST_EXPONENT);
                let panel = current_spectrum(&found.spectrum, self.exponents.get());
                draw(found.time, "lyapunov-spectrum", panel);
            }
            _ => {}
        }
    }

    /// Adds intersections, complete up to `time` (s).
    fn section(&mut self, time: f64, points: &[SectionPoint], draw: &mut Draw<'_>) {
        self.recent.extend(points);
        let surplus = self.recent.len().saturating_sub(PASSAGES);
        self.recent.drain(..surplus);
        if points.is_empty() || !self.redraw.is_due(time, self.shown) {
            return;
        }
        let points: Vec<[f64; 2]> = self.recent.iter().map(|point| point.at).collect();
        let times: Vec<f64> = self.recent.iter().map(|point| point.time_s).collect();
        let axes = &mut self.section;
        axes.fit(points.iter());
        draw(time, "section", axes.section(&points, Color::Run));
        draw(time, "return-map", axes.return_map(&points, Color::Run));
        draw(time, "return-times", axes.return_times(&times, Color::Run));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_for_a_viewer_keep_their_interval() {
        let mut due = RedrawTimer::default();
        assert!(due.is_due(0.0, None) && due.is_due(1e-3, None));
        let shown = Some(DisplayRates {
            speed: 1.0,
            pictures: 20.0,
            every: 1,
            apart: 0,
        });
        let drawn = (1..=120).filter(|ms| due.is_due(1e-3 * f64::from(*ms), shown));
        assert_eq!(drawn.collect::<Vec<_>>(), [51, 101]);
        assert!(due.is_due(0.1211, None));
    }
}
