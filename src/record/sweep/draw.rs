//! The pictures of a sweep, start by start.

use rerun::{LineStrips3D, Radius, SeriesPoints};

use super::{
    SweepStudy,
    scope::{Planes, Scope},
    words,
};
use crate::{
    analysis::RecurrenceImage,
    dynamics::Exponent,
    plot::{
        self, Color, Layer, Panel,
        response::{self, samples},
    },
    record::{
        error::RecordError,
        exponents,
        figure::View,
        paths::{self, Root},
        plot::Bounds,
        portrait,
        stream::{self, Moment, RecordingStream},
        style::{self, Quantity},
        text,
    },
    study::{
        response::{Portrait, Response, section_lag},
        sweep::Start,
    },
};

/// Fields of the diagram, of what is square and of the spectrum, pixels.
const DIAGRAM: [f32; 2] = [560.0, 300.0];
const SQUARE: [f32; 2] = [400.0, 400.0];
const SPECTRUM: [f32; 2] = [400.0, 150.0];
/// Points on the curve of a spectrum: more than there are pixels.
const SPECTRUM_POINTS: usize = 2000;

/// What a picture says where it has nothing to draw.
const NOTHING_MOVES: &str = "nothing moves here";
const NO_RESPONSE: &str = "no response here";
const NOT_DONE: &str = "not computed yet";
const NOT_KEPT: &str = "no motion was kept here";
const TOO_SHORT: &str = "too short a motion for it";

/// Where the pictures of one start are.
struct Views {
    /// The bifurcation diagram.
    diagram: View,
    /// Velocity over displacement.
    portrait: View,
    /// The Poincaré section.
    section: View,
    /// The spectrum.
    spectrum: View,
    /// The recurrence plot.
    recurrence: View,
}

impl Views {
    /// Those of a start.
    fn new(root: &Root) -> Self {
        let view = |path, field| View::new(root.at(path), field);
        Self {
            diagram: view(paths::DIAGRAM, DIAGRAM),
            portrait: view(paths::PORTRAIT, SQUARE),
            section: view(paths::SECTION, SQUARE),
            spectrum: view(paths::SPECTRUM, SPECTRUM),
            recurrence: view(paths::RECURRENCE, SQUARE),
        }
    }
}

/// A picture of a start: its name, its path, and what a view of it must show.
pub type Picture = (&'static str, String, Bounds);

/// The pictures of a start: diagram, portrait, recurrence plot, spectrum, section.
pub fn pictures(sweep: &SweepStudy<'_>, start: Start, scope: &Scope) -> [Picture; 5] {
    let views = Views::new(&Root::of_start(&start.to_string()));
    let recurrence = response::recurrence(None, true).with_caption(NOT_DONE);
    let section = scope.planes(&[]).section.panel(None);
    let panels = [
        ("Maxima", &views.diagram, diagram(sweep, start)),
        ("Phase portrait", &views.portrait, phase(None, [1.0; 2])),
        ("Recurrence plot", &views.recurrence, recurrence),
        (
            "Spectrum (lines in kHz)",
            &views.spectrum,
            spectrum(scope, None),
        ),
        ("Poincaré section", &views.section, section),
    ];
    panels.map(|(name, view, panel)| (name, view.path().to_owned(), view.bounds(&panel)))
}

/// Draws the points of one start.
pub struct Draw<'a> {
    sweep: &'a SweepStudy<'a>,
    start: Start,
    scope: &'a Scope,
    root: Root,
    views: Views,
    diagram: Panel,
}

impl<'a> Draw<'a> {
    /// Draws what holds at all values.
    pub fn new(
        rec: &RecordingStream,
        sweep: &'a SweepStudy<'a>,
        start: Start,
        scope: &'a Scope,
    ) -> Result<Self, RecordError> {
        let root = Root::of_start(&start.to_string());
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
        let mut draw = Self {
            sweep,
            start,
            scope,
            views: Views::new(&root),
            root,
            diagram: diagram(sweep, start),
        };
        draw.views.diagram.draw(rec, None, &draw.diagram)?;
        Ok(draw)
    }

    /// Draws the point at a value.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        at: Moment,
        value: f64,
        planes: &Planes,
    ) -> Result<(), RecordError> {
        let point = self.sweep.at(self.start, value);
        let document = words::point(self.sweep, self.start, value, point);
        let document = text::document(document);
        stream::log_at(rec, self.root.at(paths::POINT_WORDS), at, &document)?;
        let cursor = Layer::upright(value, Color::Ink).at(paths::CURSOR);
        let plot = self.views.diagram.plot(&self.diagram);
        let views = &mut self.views;
        views.diagram.draw_layers(rec, Some(at), &plot, &[cursor])?;
        let found = point.and_then(|point| point.outcome.as_ref().ok());
        let missing = match (point, found) {
            (None, _) => NOT_DONE,
            (Some(_), None) => NO_RESPONSE,
            _ => "",
        };
        let portrait = phase(found, planes.reach);
        let motion = found.and_then(|found| found.portrait.as_ref());
        let note = match found {
            None => missing,
            Some(_) if motion.is_none() => NOT_KEPT,
            Some(found) if found.maxima.is_empty() => NOTHING_MOVES,
            Some(_) => "",
        };
        views
            .portrait
            .draw(rec, Some(at), &portrait.with_note(note))?;
        let section = planes.section.panel(found);
        let note = match found {
            Some(found) if found.section.is_empty() => NOTHING_MOVES,
            _ => missing,
        };
        views
            .section
            .draw(rec, Some(at), &section.with_note(note))?;
        let spectrum = spectrum(self.scope, found);
        let note = match motion {
            None if found.is_some() => NOT_KEPT,
            _ => missing,
        };
        views
            .spectrum
            .draw(rec, Some(at), &spectrum.with_note(note))?;
        let recurrence = recurrence(found, missing)?;
        views.recurrence.draw(rec, Some(at), &recurrence)?;
        self.embedding(rec, at, planes.reach[0], found)?;
        self.exponents(rec, at, found)
    }

    /// Delay vectors of three coordinates, Eq. (25), in a cube.
    fn embedding(
        &self,
        rec: &RecordingStream,
        at: Moment,
        reach: f64,
        found: Option<&Response>,
    ) -> Result<(), RecordError> {
        let range = format!("±{}", Quantity::Length.words(reach));
        let names = portrait::delay_names(self.sweep.letter(), &range);
        portrait::draw_cube(rec, &self.root, at, &names)?;
        let lag = section_lag(&self.sweep.plan.scene);
        let trail = found.and_then(|found| {
            let motion = found.portrait.as_ref()?;
            let lag = ((lag / motion.dt).round() as usize).max(1);
            let unit = |u: f32| u / reach as f32;
            // The newest first in a vector.
            let points = motion.displacement.windows(2 * lag + 1);
            let points = points.map(|w| [w[2 * lag], w[lag], w[0]].map(unit));
            Some((points.collect::<Vec<_>>(), style::regime(found.regime)))
        });
        let strips = trail.iter().map(|(points, _)| points);
        let lines = LineStrips3D::new(strips)
            .with_colors(trail.iter().map(|(_, color)| *color))
            .with_radii([Radius::new_ui_points(0.7)]);
        stream::log_at(rec, self.root.at(paths::EMBEDDING_TRAIL), at, &lines)
    }

    fn exponents(
        &self,
        rec: &RecordingStream,
        at: Moment,
        found: Option<&Response>,
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
}

/// The maxima at all values, and where there is no response.
fn diagram(sweep: &SweepStudy<'_>, start: Start) -> Panel {
    let mut panel = plot::maxima(sweep.plan, sweep.points, start);
    let of_start = sweep
        .points
        .iter()
        .filter(|point| point.place.start == start);
    let failed = of_start.filter(|point| point.outcome.is_err());
    let failed: Vec<[f64; 2]> = failed
        .map(|point| [point.place.values[0], panel.y.range[0]])
        .collect();
    if !failed.is_empty() {
        panel
            .layers
            .push(Layer::points(failed, 1.5, Color::Faint).named("no response"));
    }
    panel
}

/// The phase plot of a response; what hardly moves is shown by a point.
fn phase(found: Option<&Response>, reach: [f64; 2]) -> Panel {
    let motion = found.and_then(|found| found.portrait.as_ref());
    let trail = motion.map_or_else(Vec::new, samples);
    let color = found.map_or(Color::Ink, response::color);
    let mut panel = response::phase(&trail, Some(reach), color);
    let still = found.is_some_and(|found| found.maxima.is_empty());
    let last = panel.layers[0].last_point().filter(|_| still);
    let last = Layer::points(last.into_iter().collect(), 3.3, Color::Ink);
    panel.layers.push(last.at(paths::NOW));
    panel
}

/// The spectrum of a response with as many points as can be told apart.
fn spectrum(scope: &Scope, found: Option<&Response>) -> Panel {
    let lines = found.map_or(&[][..], |found| &found.lines);
    let (bin, amplitude) = match found.and_then(|found| found.portrait.as_ref()) {
        Some(motion) => thinned(motion.bin, &motion.spectrum),
        None => (1.0, Vec::new()),
    };
    scope.spectrum.panel(bin, &amplitude, lines)
}

/// The recurrence plot of a response, or why there is none.
fn recurrence(found: Option<&Response>, missing: &str) -> Result<Panel, RecordError> {
    // A plot of what does not move would show the rounding of its numbers.
    let moving = found.filter(|found| !found.maxima.is_empty());
    let moving = moving.and_then(|found| found.portrait.as_ref());
    let plot = moving.map(Portrait::recurrence).transpose();
    let plot = plot.map_err(|error| RecordError::Encode(error.to_string()))?;
    let plot = plot.flatten();
    let caption = match (&plot, found) {
        (Some(plot), _) => recurrence_words(plot),
        (None, None) => missing.to_owned(),
        (None, Some(found)) if found.portrait.is_none() => NOT_KEPT.to_owned(),
        (None, Some(found)) if found.maxima.is_empty() => NOTHING_MOVES.to_owned(),
        (None, Some(_)) => TOO_SHORT.to_owned(),
    };
    Ok(response::recurrence(plot.as_ref(), true).with_caption(caption))
}

fn recurrence_words(plot: &RecurrenceImage) -> String {
    let epsilon = match plot.threshold {
        Some(threshold) => format!("ε = {}", Quantity::Length.words(threshold)),
        None => "ε of each state its own".to_owned(),
    };
    format!(
        "{:.0} % recurrent, {epsilon}, m = {}, τ = {}",
        1e2 * plot.rate,
        plot.dimension,
        Quantity::Time.words(plot.lag),
    )
}

/// A spectrum with fewer points, if it has too many: the least and the largest of so many bins each,
/// in their order.
fn thinned(bin: f64, amplitude: &[f32]) -> (f64, Vec<f32>) {
    let many = (2 * amplitude.len()).div_ceil(SPECTRUM_POINTS);
    if many <= 2 {
        return (bin, amplitude.to_vec());
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
        [bins[first], bins[second]]
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
        assert_eq!((thin[100], thin[125]), (1.0, 1e-6f32));
        let few = thinned(2.0, &amplitude[..SPECTRUM_POINTS]);
        assert_eq!((few.0, few.1.len()), (2.0, SPECTRUM_POINTS));
    }
}
