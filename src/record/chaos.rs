//! Chaos in a signal: divergence of nearby states, largest exponent, 0-1 test.

use rerun::{Scalars, SeriesLines, SeriesPoints};

use super::{
    error::RecordError,
    paths,
    plot::{Axes, Bounds, CAPTION_HEIGHT, Plot},
    samples::name_series,
    stream::{self, RecordingStream},
    style::{self, Quantity, short},
};
use crate::{
    analysis::{Divergence, ZeroOne, range},
    pipeline::message::Subject,
    plot::Axis,
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
    divergence: Axes,
    path: Axes,
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
            divergence: Axes::default(),
            path: Axes::default(),
        })
    }

    /// Bounds of the view of the divergence.
    pub fn divergence_bounds() -> Bounds {
        let axis = || Axis::linear("", [0.0, 1.0]);
        divergence_plot(axis(), axis()).bounds()
    }

    /// Bounds of the view of the path of the 0-1 test.
    pub fn path_bounds() -> Bounds {
        path_plot(1.0, "").bounds()
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
        let plot = divergence_plot(
            Axis::linear(
                format!("time, {}", time_unit.symbol),
                [0.0, after(last as f64)],
            ),
            Axis::linear(format!("mean ln(distance{divisor})"), [low, high]),
        );
        self.divergence.draw(rec, paths::DIVERGENCE, time, &plot)?;
        let points = curve.iter().enumerate();
        let points = points.filter(|(_, value)| value.is_finite());
        plot.draw_curve(
            rec,
            paths::DIVERGENCE_CURVE,
            time,
            points.map(|(k, value)| [after(k as f64), *value]),
            (style::SIGNAL, 1.2),
        )?;
        let line = divergence.region.map(|region| {
            let at = |k: f64| [after(k), region.intercept + region.slope * k + shift];
            [at(region.from), at(region.to)]
        });
        plot.draw_curve(
            rec,
            paths::DIVERGENCE_LINE,
            time,
            line.into_iter().flatten(),
            (style::ACCENT, 2.4),
        )?;
        let words = match divergence.region {
            Some(region) => format!(
                "largest Lyapunov exponent λ = {} ± {} per s",
                short(region.slope / dt),
                short(region.error / dt),
            ),
            None => "no scaling region, no exponent".to_owned(),
        };
        plot.draw_caption(rec, paths::DIVERGENCE, time, &words)
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
        let plot = path_plot(style::round_up(unit.per_si * half), &unit.symbol);
        self.path.draw(rec, paths::ZERO_ONE_PICTURE, time, &plot)?;
        plot.draw_curve(
            rec,
            paths::ZERO_ONE_PATH,
            time,
            path.iter()
                .map(|[p, q]| [p - middle[0], q - middle[1]].map(|c| unit.per_si * c)),
            (style::SIGNAL, 0.7),
        )?;
        let words = format!("K = {}", short(zero_one.k));
        plot.draw_caption(rec, paths::ZERO_ONE_PICTURE, time, &words)
    }
}

fn divergence_plot(x: Axis, y: Axis) -> Plot {
    Plot {
        width: DIVERGENCE[0],
        height: DIVERGENCE[1],
        top_margin: CAPTION_HEIGHT,
        x,
        y,
        grid: true,
    }
}

fn path_plot(full: f64, unit: &str) -> Plot {
    let axis = |name| Axis::linear(style::with_unit(name, unit), [-full, full]);
    Plot {
        width: PATH_SIDE,
        height: PATH_SIDE,
        top_margin: CAPTION_HEIGHT,
        x: axis("p − centre"),
        y: axis("q − centre"),
        grid: true,
    }
}
