//! Chaos in a signal: divergence of nearby states, largest exponent, 0-1 test.

use rerun::Scalars;

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
    analysis::{Divergence, ScalingRegion, ZeroOne, range},
    number::with_error,
    pipeline::message::Header,
    plot::{Axis, Color, Layer, Panel},
};

/// Size of the divergence plot, pixels.
const DIVERGENCE: [f32; 2] = [400.0, 210.0];
/// Size of the plot of the exponents over time, pixels.
const EXPONENTS: [f32; 2] = [460.0, 130.0];
/// Side of the plot of the 0-1 test, pixels, and number of points of its path.
const PATH_SIDE: f32 = 220.0;
const PATH_POINTS: usize = 1000;

/// Draws the analyses of chaos.
#[derive(Debug)]
pub struct Chaos {
    quantity: Quantity,
    divergence: PanelView,
    path: PanelView,
    history: PanelView,
    /// Time of the first sample and of the end of the run, s.
    span: [f64; 2],
    /// Time (s) and largest exponent with the ends of its error interval (1/s) of each window that has one.
    exponents: Vec<[f64; 4]>,
}

impl Chaos {
    /// Names the series.
    pub fn new(rec: &RecordingStream, header: &Header) -> Result<Self, RecordError> {
        name_series(rec, paths::ZERO_ONE, ["K".to_owned()], [style::ACCENT])?;
        Ok(Self {
            quantity: Quantity::displacement(&header.subject),
            divergence: divergence_view(),
            path: path_view(),
            history: history_view(),
            span: [header.start(), header.start() + header.duration],
            exponents: Vec::new(),
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

    /// Bounds of the view of the exponents over time.
    pub fn exponent_bounds() -> Bounds {
        history_view().bounds(&history_panel(&[], [0.0, 1.0]))
    }

    /// Draws the results of a window of `window` (s) that ends at `time` (s), with samples `dt` (s) apart.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        [time, window, dt]: [f64; 3],
        divergence: &Divergence,
        zero_one: &ZeroOne,
    ) -> Result<(), RecordError> {
        self.draw_divergence(rec, [time, window, dt], divergence)?;
        self.draw_path(rec, time, zero_one)?;
        if let Some(ScalingRegion { slope, error, .. }) = divergence.region {
            let [low, value, high] = [slope - error, slope, slope + error].map(|rate| rate / dt);
            self.exponents.push([time, low, value, high]);
        }
        let [from, to] = self.span;
        let panel = history_panel(&self.exponents, [from, to.max(time)]);
        self.history.draw(rec, Some(Moment::from(time)), &panel)?;
        stream::log_at(rec, paths::ZERO_ONE, time, &Scalars::single(zero_one.k))
    }

    fn draw_divergence(
        &mut self,
        rec: &RecordingStream,
        [time, window, dt]: [f64; 3],
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
                "largest Lyapunov exponent λ = {} per s",
                with_error(region.slope / dt, region.error / dt),
            ),
            None => format!(
                "no scaling region in {}: no chaos, or too weak for this window",
                Quantity::Time.format(window)
            ),
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
        let meaning = match zero_one.k {
            ..0.4 => "regular or weak chaos",
            0.6.. => "chaos or noise",
            _ => "undecided",
        };
        // Without the sign of a zero.
        let hundredths = (100.0 * zero_one.k).round() / 100.0 + 0.0;
        let words = format!("K = {}: {meaning}", short(hundredths));
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

fn history_view() -> PanelView {
    PanelView::new(paths::EXPONENT, EXPONENTS)
}

/// The exponents (time in s, and the value between the ends of its interval in 1/s) over a span of time (s).
fn history_panel(exponents: &[[f64; 4]], span: [f64; 2]) -> Panel {
    let unit = Quantity::Time.unit(span[1]);
    let at = |time: f64| unit.per_si * time;
    let intervals = exponents
        .iter()
        .map(|[t, low, _, high]| [at(*t), *low, *high]);
    let intervals: Vec<[f64; 3]> = intervals.collect();
    let values = exponents.iter().map(|[t, _, value, _]| [at(*t), *value]);
    let layers = vec![
        Layer::intervals(&intervals, Color::Faint),
        Layer::points(values.collect(), 2.5, Color::Ink).with_id("values"),
    ];
    let ends = exponents.iter().flat_map(|[_, low, _, high]| [*low, *high]);
    let values_axis = match exponents {
        [] => Axis::linear("λ, 1/s", [0.0, 100.0]),
        _ => Axis::with_margin("λ, 1/s", ends.chain([0.0])),
    };
    let panel = Panel::new(
        "largest exponent",
        Axis::linear(format!("time, {}", unit.symbol), span.map(at)),
        values_axis,
        layers,
    );
    panel.with_note(match exponents {
        [] => "no exponent so far: no window has a scaling region",
        _ => "",
    })
}

/// The path of the 0-1 test about its centre, on axes of ± `full`.
fn path_panel(full: f64, unit: &str, path: Vec<[f64; 2]>) -> Panel {
    let axis = |name| Axis::linear(style::with_unit(name, unit), [-full, full]);
    let path = Layer::line(path, Color::Ink).with_line_width(0.7);
    let (x, y) = (axis("p − centre"), axis("q − centre"));
    Panel::new("0-1 test", x, y, vec![path.with_id("path")])
}
