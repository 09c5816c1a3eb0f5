//! Chaos in a signal: divergence of nearby states, largest exponent, 0-1 test.

use rerun::{Scalars, SeriesLines, SeriesPoints};

use super::{
    error::RecordError,
    panel_view::PanelView,
    paths,
    plot::Bounds,
    samples::name_series,
    stream::{self, Moment, RecordingStream},
    style::{self, Quantity, short},
};
use crate::{
    analysis::{Divergence, ZeroOne, range},
    pipeline::message::Subject,
    plot::{Axis, Color, Layer, Panel},
};

/// Size of the divergence plot, pixels.
const DIVERGENCE: [f32; 2] = [400.0, 210.0];
/// Side of the plot of the 0-1 test, pixels, and number of points of its path.
const PATH_SIDE: f32 = 220.0;
const PATH_POINTS: usize = 1000;

/// Draws the analyses of chaos.
#[derive(Debug)]
pub struct Chaos {
    quantity: Quantity,
    divergence: PanelView,
    path: PanelView,
}

impl Chaos {
    /// Names the series.
    pub fn new(rec: &RecordingStream, subject: &Subject) -> Result<Self, RecordError> {
        let faint = style::faded(style::SIGNAL, 0.5);
        let names = ["λ − error, 1/s", "λ, 1/s", "λ + error, 1/s"];
        name_series(
            rec,
            paths::EXPONENT,
            names.map(str::to_owned),
            [faint, style::SIGNAL, faint],
        )?;
        let widths = SeriesLines::update_fields().with_widths([0.8, 2.0, 0.8]);
        rec.log_static(paths::EXPONENT, &widths)?;
        // A value between two gaps has no line segment. The legend takes the names from the points.
        let points = SeriesPoints::new()
            .with_names(names)
            .with_colors([faint, style::SIGNAL, faint])
            .with_marker_sizes([1.0, 2.5, 1.0]);
        rec.log_static(paths::EXPONENT, &points)?;
        name_series(rec, paths::ZERO_ONE, ["K".to_owned()], [style::ACCENT])?;
        Ok(Self {
            quantity: Quantity::displacement(subject),
            divergence: divergence_view(),
            path: path_view(),
        })
    }

    /// Bounds of the view of the divergence.
    pub fn divergence_bounds() -> Bounds {
        let axis = || Axis::linear("name", [0.0, 1.0]);
        let panel = Panel::new("", axis(), axis(), Vec::new());
        divergence_view().bounds(&panel.with_caption("caption"))
    }

    /// Bounds of the view of the path of the 0-1 test.
    pub fn path_bounds() -> Bounds {
        path_view().bounds(&path_panel(1.0, "", Vec::new()).with_caption("caption"))
    }

    /// Draws the results of a window that ends at `time` (s), with samples `dt` (s) apart.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        dt: f64,
        divergence: &Divergence,
        zero_one: &ZeroOne,
    ) -> Result<(), RecordError> {
        self.draw_divergence(rec, time, dt, divergence)?;
        self.draw_path(rec, time, zero_one)?;
        // Without a scaling region there is no exponent: a gap.
        let region = divergence.region;
        let [slope, error] = region.map_or([f64::NAN; 2], |r| [r.slope / dt, r.error / dt]);
        let row = Scalars::new([slope - error, slope, slope + error]);
        stream::log_at(rec, paths::EXPONENT, time, &row)?;
        stream::log_at(rec, paths::ZERO_ONE, time, &Scalars::single(zero_one.k))
    }

    fn draw_divergence(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        dt: f64,
        divergence: &Divergence,
    ) -> Result<(), RecordError> {
        // Converts logarithms of SI values to logarithms in the displayed unit.
        let unit = self.quantity.unit(1.0);
        let shift = unit.per_si.ln();
        let curve = divergence.curve.iter().map(|value| value + shift);
        let curve: Vec<f64> = curve.collect();
        let finite = curve.iter().copied().filter(|value| value.is_finite());
        let [low, high] = range(finite);
        let (low, high) = (low.floor(), high.ceil());
        let (low, high) = if low < high { (low, high) } else { (-1.0, 1.0) };
        let last = curve.len().saturating_sub(1).max(1);
        let time_unit = Quantity::Time.unit(dt * last as f64);
        let after = |samples: f64| time_unit.per_si * dt * samples;
        let divisor = match unit.symbol.as_str() {
            "" => String::new(),
            symbol => format!(" / {symbol}"),
        };
        let points = curve.iter().enumerate();
        let points = points.map(|(k, value)| [after(k as f64), *value]);
        let line = divergence.region.map(|region| {
            let at = |k: f64| [after(k), region.intercept + region.slope * k + shift];
            vec![at(region.from), at(region.to)]
        });
        let layers = vec![
            Layer::line(points.collect(), Color::Ink),
            Layer::line(line.unwrap_or_default(), Color::Accent)
                .with_line_width(3.0)
                .with_id("fit"),
        ];
        let panel = Panel::new(
            "divergence",
            Axis::linear(
                format!("time, {}", time_unit.symbol),
                [0.0, after(last as f64)],
            ),
            Axis::linear(format!("mean ln(distance{divisor})"), [low, high]),
            layers,
        );
        let words = match divergence.region {
            Some(region) => format!(
                "largest Lyapunov exponent λ = {} ± {} per s",
                short(region.slope / dt),
                short(region.error / dt),
            ),
            None => "no scaling region, no exponent".to_owned(),
        };
        let at = Some(Moment::from(time));
        self.divergence.draw(rec, at, &panel.with_caption(words))
    }

    fn draw_path(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        zero_one: &ZeroOne,
    ) -> Result<(), RecordError> {
        let path = &zero_one.path[..zero_one.path.len().min(PATH_POINTS)];
        let span = |c: usize| {
            let [low, high] = range(path.iter().map(|point| point[c]));
            if low <= high { [low, high] } else { [0.0; 2] }
        };
        let spans = [span(0), span(1)];
        let middle = spans.map(|[low, high]| 0.5 * (low + high));
        let half = spans.map(|[low, high]| 0.5 * (high - low));
        let half = half[0].max(half[1]).max(1e-12);
        let unit = self.quantity.unit(half);
        let path = path.iter();
        let path = path.map(|[p, q]| [p - middle[0], q - middle[1]].map(|c| unit.per_si * c));
        let full = style::round_up(unit.per_si * half);
        let panel = path_panel(full, &unit.symbol, path.collect());
        let words = format!("K = {}", short(zero_one.k));
        let at = Some(Moment::from(time));
        self.path.draw(rec, at, &panel.with_caption(words))
    }
}

fn divergence_view() -> PanelView {
    PanelView::new(paths::DIVERGENCE, DIVERGENCE)
}

fn path_view() -> PanelView {
    PanelView::new(paths::ZERO_ONE_PICTURE, [PATH_SIDE; 2])
}

/// The path of the 0-1 test about its centre, on axes of ± `full`.
fn path_panel(full: f64, unit: &str, path: Vec<[f64; 2]>) -> Panel {
    let axis = |name| Axis::linear(style::with_unit(name, unit), [-full, full]);
    let path = Layer::line(path, Color::Ink).with_line_width(0.7);
    let (x, y) = (axis("p − centre"), axis("q − centre"));
    Panel::new("0-1 test", x, y, vec![path.with_id("path")])
}
