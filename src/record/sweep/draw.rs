//! The pictures of a sweep, start by start.

use rerun::{Color, LineStrips2D, LineStrips3D, Points2D, Radius, SeriesPoints};

use super::{
    scope::{Scope, tops},
    view::{ResponseView, StartView, SweepView},
    words,
};
use crate::{
    analysis::Regime,
    dynamics::Exponent,
    record::{
        error::RecordError,
        exponents,
        paths::{self, Root},
        plot::{Axes, Plot},
        portrait::{self, Field},
        recurrence::Recurrence,
        spectrum::{self, Spectrum},
        stream::{self, Moment, RecordingStream},
        style::{self, Quantity, Unit},
        text,
    },
};

/// Points on the curve of a spectrum: more than there are pixels.
const SPECTRUM_POINTS: usize = 2000;
/// What a picture says where it has nothing to draw.
const NOTHING_MOVES: &str = "nothing moves here";
const NO_RESPONSE: &str = "no response here";
const NOT_DONE: &str = "not computed yet";
const NOT_KEPT: &str = "no motion was kept here";

/// What the pictures at one value have in common.
pub struct Frame {
    /// To which displacement (m) the pictures reach.
    reach: f64,
    portrait: Field,
    section: (Plot, Unit),
}

impl Frame {
    /// For the responses at a value.
    pub fn new(scope: &Scope, found: &[&ResponseView]) -> Self {
        let reach = scope.reach(found);
        Self {
            reach: reach[0],
            portrait: Field::new(reach),
            section: scope.section(found),
        }
    }
}

/// Draws the points of one start.
pub struct Draw<'a> {
    sweep: &'a SweepView,
    start: &'a StartView,
    scope: &'a Scope,
    root: Root,
    recurrence: Recurrence,
    /// Axes of portrait and section.
    axes: [Axes; 2],
}

impl<'a> Draw<'a> {
    /// Draws what holds at all values.
    pub fn new(
        rec: &RecordingStream,
        sweep: &'a SweepView,
        start: &'a StartView,
        scope: &'a Scope,
    ) -> Result<Self, RecordError> {
        let root = Root::of_start(&start.key);
        let axes = root.at(paths::SPECTRUM_AXES);
        scope.spectrum.plot.draw(rec, &axes, None)?;
        if scope.exponents > 0 {
            exponents::name_exponents(rec, &root, scope.exponents)?;
            // Points mark the values that were computed; the ends of intervals have none.
            let sizes = [0.0, 2.5, 0.0].repeat(scope.exponents);
            let colors = (0..scope.exponents).flat_map(|k| [exponents::color(k); 3]);
            let marks = SeriesPoints::new()
                .with_marker_sizes(sizes)
                .with_colors(colors);
            rec.log_static(root.at(paths::EXPONENTS_RUNNING), &marks)?;
        }
        let recurrence = Recurrence::new(rec, root.clone(), Quantity::Length)?;
        let draw = Self {
            sweep,
            start,
            scope,
            root,
            recurrence,
            axes: Default::default(),
        };
        draw.diagram(rec)?;
        Ok(draw)
    }

    /// The maxima at all values, in the colours of their kinds.
    fn diagram(&self, rec: &RecordingStream) -> Result<(), RecordError> {
        let (plot, unit) = &self.scope.diagram;
        plot.draw(rec, &self.root.at(paths::DIAGRAM_AXES), None)?;
        // Marks that cover each other within a quarter of a pixel are one.
        let mut marks: Vec<([i32; 2], Color)> = Vec::new();
        let mut kinds: Vec<(String, Color)> = Vec::new();
        for regime in Regime::ALL {
            let found = self.start.points.iter().filter_map(|point| {
                let response = point.outcome.as_ref().ok()?;
                (response.regime == regime).then_some((point.value, response))
            });
            let color = style::regime(regime);
            let before = marks.len();
            marks.extend(found.flat_map(|(value, response)| {
                tops(response).map(move |top| {
                    let at = plot.at(value, unit.per_si * top);
                    (at.map(|c| (4.0 * c).round() as i32), color)
                })
            }));
            if marks.len() > before {
                kinds.push((regime.to_string(), color));
            }
        }
        let failed = self.start.points.iter().filter(|p| p.outcome.is_err());
        let before = marks.len();
        marks.extend(failed.map(|point| {
            let at = plot.at(point.value, plot.y.low);
            (at.map(|c| (4.0 * c).round() as i32), style::AXIS)
        }));
        if marks.len() > before {
            kinds.push(("no response".to_owned(), style::AXIS));
        }
        marks.sort_by_key(|(at, _)| *at);
        marks.dedup_by_key(|(at, _)| *at);
        let points = Points2D::new(marks.iter().map(|(at, _)| at.map(|c| c as f32 / 4.0)))
            .with_colors(marks.iter().map(|(_, color)| *color))
            .with_radii([Radius::new_ui_points(1.8)]);
        rec.log_static(self.root.at(paths::DIAGRAM_POINTS), &points)?;

        plot.draw_key(rec, &self.root.at(paths::DIAGRAM_KEY), &kinds)
    }

    /// Draws the point at a value.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        at: Moment,
        value: f64,
        frame: &Frame,
    ) -> Result<(), RecordError> {
        let point = self.start.at(value);
        let document = words::point(self.sweep, self.start, value, point);
        let document = text::document(document);
        stream::log_at(rec, self.root.at(paths::POINT_WORDS), at, &document)?;
        self.cursor(rec, at, value)?;
        let found = point.and_then(|point| point.outcome.as_ref().ok());
        let missing = match point {
            None => NOT_DONE,
            Some(_) => NO_RESPONSE,
        };
        self.portrait(rec, at, &frame.portrait, found, missing)?;
        self.embedding(rec, at, frame.reach, found)?;
        self.section(rec, at, &frame.section, found, missing)?;
        self.spectrum(rec, at, found, missing)?;
        self.recurrence(rec, at, found, missing)?;
        self.exponents(rec, at, found)
    }

    /// The present value in the diagram.
    fn cursor(&self, rec: &RecordingStream, at: Moment, value: f64) -> Result<(), RecordError> {
        let (plot, _) = &self.scope.diagram;
        let [x, _] = plot.at(value, plot.y.low);
        let line = LineStrips2D::new([[[x, 0.0], [x, plot.height]]])
            .with_colors([style::POLE])
            .with_radii([Radius::new_ui_points(0.8)])
            .with_draw_order(1.0);
        stream::log_at(rec, self.root.at(paths::DIAGRAM_CURSOR), at, &line)
    }

    fn portrait(
        &mut self,
        rec: &RecordingStream,
        at: Moment,
        field: &Field,
        found: Option<&ResponseView>,
        missing: &str,
    ) -> Result<(), RecordError> {
        let axes = self.root.at(paths::PORTRAIT_AXES);
        self.axes[0].draw(rec, &axes, at, &field.plot)?;
        let motion = found.and_then(|found| found.motion.as_ref());
        let color = found.map_or(style::SIGNAL, |found| style::regime(found.regime));
        let pairs = motion.into_iter().flat_map(|motion| {
            let pairs = motion.displacement.iter().zip(&motion.velocity);
            pairs.map(|(&u, &v)| field.values([u, v].map(f64::from)))
        });
        let trail = self.root.at(paths::PORTRAIT_TRAIL);
        field
            .plot
            .draw_curve(rec, &trail, at, pairs, (color, 0.7))?;
        // What hardly moves is seen by a point.
        let last = motion.and_then(|motion| {
            let ends = [motion.displacement.last()?, motion.velocity.last()?];
            Some(field.values(ends.map(|end| f64::from(*end))))
        });
        let still = found.is_some_and(|found| found.maxima.is_empty());
        let last = last.filter(|_| still);
        let now = self.root.at(paths::PORTRAIT_NOW);
        let look = (style::POLE, 4.0);
        field
            .plot
            .draw_points(rec, &now, at, last.into_iter(), look)?;
        let words = match (found, motion) {
            (None, _) => missing,
            (Some(_), None) => NOT_KEPT,
            (Some(_), Some(_)) if still => NOTHING_MOVES,
            _ => "",
        };
        self.note(rec, at, paths::PORTRAIT, &field.plot, words)
    }

    /// Delay vectors of three coordinates, Eq. (25), in a cube.
    fn embedding(
        &self,
        rec: &RecordingStream,
        at: Moment,
        reach: f64,
        found: Option<&ResponseView>,
    ) -> Result<(), RecordError> {
        let range = format!("±{}", Quantity::Length.words(reach));
        let names = portrait::delay_names(self.sweep.letter, &range);
        portrait::draw_cube(rec, &self.root, at, &names)?;
        let trail = found.and_then(|found| {
            let motion = found.motion.as_ref()?;
            let lag = ((self.sweep.lag / motion.dt).round() as usize).max(1);
            let u = &motion.displacement[..];
            let unit = |u: f32| u / reach as f32;
            // The newest first in a vector.
            let points = u.windows(2 * lag + 1);
            let points = points.map(|w| [w[2 * lag], w[lag], w[0]].map(unit));
            Some((points.collect::<Vec<_>>(), style::regime(found.regime)))
        });
        let strips = trail.iter().map(|(points, _)| points);
        let lines = LineStrips3D::new(strips)
            .with_colors(trail.iter().map(|(_, color)| *color))
            .with_radii([Radius::new_ui_points(0.7)]);
        stream::log_at(rec, self.root.at(paths::EMBEDDING_TRAIL), at, &lines)
    }

    fn section(
        &mut self,
        rec: &RecordingStream,
        at: Moment,
        (plot, unit): &(Plot, Unit),
        found: Option<&ResponseView>,
        missing: &str,
    ) -> Result<(), RecordError> {
        let axes = self.root.at(paths::SECTION_AXES);
        self.axes[1].draw(rec, &axes, at, plot)?;
        let points = found.map_or(&[][..], |found| &found.section);
        let color = found.map_or(style::SIGNAL, |found| style::regime(found.regime));
        let shown = points.iter().map(|point| point.map(|c| unit.per_si * c));
        let path = self.root.at(paths::SECTION_POINTS);
        plot.draw_points(rec, &path, at, shown, (color, 1.8))?;
        let words = match found {
            None => missing,
            Some(_) if points.is_empty() => NOTHING_MOVES,
            Some(_) => "",
        };
        self.note(rec, at, paths::SECTION, plot, words)
    }

    fn spectrum(
        &self,
        rec: &RecordingStream,
        at: Moment,
        found: Option<&ResponseView>,
        missing: &str,
    ) -> Result<(), RecordError> {
        let motion = found.and_then(|found| found.motion.as_ref());
        let (bin, amplitude) = match motion {
            Some(motion) => thinned(motion.bin, &motion.spectrum),
            None => (1.0, Vec::new()),
        };
        let shown = Spectrum {
            bin,
            amplitude: &amplitude,
            peaks: found.map_or(&[], |found| &found.lines),
        };
        let plot = &self.scope.spectrum;
        spectrum::draw_spectrum(rec, &self.root, plot, at, shown)?;
        let words = match (found, motion) {
            (None, _) => missing,
            (Some(_), None) => NOT_KEPT,
            _ => "",
        };
        self.note(rec, at, paths::SPECTRUM, &plot.plot, words)
    }

    fn recurrence(
        &mut self,
        rec: &RecordingStream,
        at: Moment,
        found: Option<&ResponseView>,
        missing: &str,
    ) -> Result<(), RecordError> {
        let Some(found) = found else {
            return self.recurrence.clear(rec, at, missing);
        };
        let Some(plot) = &found.recurrence else {
            let words = match found.motion {
                None => NOT_KEPT,
                Some(_) if found.maxima.is_empty() => NOTHING_MOVES,
                Some(_) => "too short a motion for it",
            };
            return self.recurrence.clear(rec, at, words);
        };
        self.recurrence.draw(rec, at, plot)
    }

    fn exponents(
        &self,
        rec: &RecordingStream,
        at: Moment,
        found: Option<&ResponseView>,
    ) -> Result<(), RecordError> {
        if self.scope.exponents == 0 {
            return Ok(());
        }
        let spectrum = found.and_then(|found| found.exponents.as_ref());
        let known = spectrum
            .into_iter()
            .flat_map(|s| s.exponents.iter().copied());
        // A direction that collapses has no place on the axis either.
        let known = known.map(|e| Exponent {
            value: Some(e.value).filter(|v| v.is_finite()).unwrap_or(f64::NAN),
            ..e
        });
        let unknown = std::iter::repeat(Exponent {
            value: f64::NAN,
            half_width: f64::NAN,
        });
        let row: Vec<Exponent> = known.chain(unknown).take(self.scope.exponents).collect();
        exponents::log_exponents(rec, &self.root, at, &row)
    }

    /// Says in the middle of a picture why it is empty; no words take them away.
    fn note(
        &self,
        rec: &RecordingStream,
        at: Moment,
        picture: &str,
        plot: &Plot,
        words: &str,
    ) -> Result<(), RecordError> {
        let middle = [0.5 * plot.width, 0.5 * plot.height];
        let words = Some(words).filter(|words| !words.is_empty());
        let note = Points2D::new(words.map(|_| middle))
            .with_labels(words)
            .with_show_labels(true)
            .with_colors(words.map(|_| style::POLE))
            .with_radii([Radius::new_ui_points(0.0)]);
        stream::log_at(rec, self.root.at(&paths::note(picture)), at, &note)
    }
}

/// A spectrum with fewer points, if it has too many: the least and the largest of so many bins each,
/// in their order.
fn thinned(bin: f64, amplitude: &[f32]) -> (f64, Vec<f64>) {
    let many = (2 * amplitude.len()).div_ceil(SPECTRUM_POINTS);
    if many <= 2 {
        return (bin, amplitude.iter().map(|&a| f64::from(a)).collect());
    }
    let pairs = amplitude.chunks(many).flat_map(|bins| {
        let place = |better: fn(f32, f32) -> bool| {
            (1..bins.len()).fold(
                0,
                |best, k| if better(bins[k], bins[best]) { k } else { best },
            )
        };
        let (least, largest) = (place(|a, b| a < b), place(|a, b| a > b));
        let [first, second] = [least.min(largest), least.max(largest)];
        [bins[first], bins[second]].map(f64::from)
    });
    (0.5 * many as f64 * bin, pairs.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_spectrum_keeps_its_lines_and_its_floor() {
        let mut amplitude = vec![1e-3f32; 8 * SPECTRUM_POINTS];
        amplitude[800] = 1.0;
        amplitude[1001] = 1e-6;
        let (bin, thin) = thinned(2.0, &amplitude);
        assert_eq!((bin, thin.len()), (16.0, SPECTRUM_POINTS));
        assert_eq!((thin[100], thin[125]), (1.0, f64::from(1e-6f32)));
        let few = thinned(2.0, &amplitude[..SPECTRUM_POINTS]);
        assert_eq!((few.0, few.1.len()), (2.0, SPECTRUM_POINTS));
    }
}
