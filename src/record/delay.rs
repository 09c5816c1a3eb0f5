//! Choice of the delay embedding (Fig. 8): average mutual information over the delay, and false nearest
//! neighbours over the dimension.

use super::{
    error::RecordError,
    paths,
    plot::{Axes, Bounds, CAPTION_HEIGHT, Plot},
    stream::RecordingStream,
    style::{self, Quantity, short},
};
use crate::{
    analysis::{DelayChoice, LagReason},
    plot::Axis,
};

/// Size of both plots, pixels.
const SIZE: [f32; 2] = [400.0, 210.0];

/// Draws choices of delay and dimension.
#[derive(Debug, Default)]
pub struct Delay {
    mutual: Axes,
    neighbours: Axes,
}

impl Delay {
    /// Bounds of both views.
    pub fn bounds() -> Bounds {
        let axis = || Axis::linear("", [0.0, 1.0]);
        plot(axis(), axis()).bounds()
    }

    /// Draws the choice of a window that ends at `time` (s), with samples `dt` (s) apart.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        dt: f64,
        choice: &DelayChoice,
    ) -> Result<(), RecordError> {
        self.draw_mutual(rec, time, dt, choice)?;
        self.draw_neighbours(rec, time, dt, choice)
    }

    fn draw_mutual(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        dt: f64,
        choice: &DelayChoice,
    ) -> Result<(), RecordError> {
        let bits = &choice.mutual.bits;
        let unit = Quantity::Time.unit(dt * bits.len() as f64);
        let lag = |samples: usize| unit.per_si * dt * samples as f64;
        let largest = bits.len().saturating_sub(1).max(1);
        let top = bits.iter().fold(1e-3, |a: f64, b| a.max(*b));
        let plot = plot(
            Axis::linear(format!("delay, {}", unit.symbol), [0.0, lag(largest)]),
            Axis::linear(
                "average mutual information, bits",
                [0.0, style::round_up(top)],
            ),
        );
        self.mutual.draw(rec, paths::DELAY_MUTUAL, time, &plot)?;
        let curve = bits.iter().enumerate().map(|(k, bits)| [lag(k), *bits]);
        plot.draw_curve(
            rec,
            paths::DELAY_MUTUAL_CURVE,
            time,
            curve,
            (style::SIGNAL, 1.2),
        )?;
        let height = bits.get(choice.lag).copied().unwrap_or(0.0);
        let chosen = [lag(choice.lag), height];
        plot.draw_marker_line(rec, paths::DELAY_MUTUAL_CHOSEN, time, chosen)?;
        let why = match choice.reason {
            LagReason::FirstMinimum => "first minimum",
            LagReason::FirstDecay => "first value below 1/e of the initial one; no minimum",
            LagReason::Largest => "largest delay tried; no minimum, no decay below 1/e",
        };
        let words = format!(
            "τ = {} {} ({} samples): {why}",
            short(chosen[0]),
            unit.symbol,
            choice.lag
        );
        plot.draw_caption(rec, paths::DELAY_MUTUAL, time, &words)
    }

    fn draw_neighbours(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        dt: f64,
        choice: &DelayChoice,
    ) -> Result<(), RecordError> {
        let share = &choice.neighbours.share;
        let plot = plot(
            Axis::integers("embedding dimension m", share.len()),
            Axis::linear("false nearest neighbours, %", [0.0, 100.0]),
        );
        self.neighbours
            .draw(rec, paths::DELAY_NEIGHBOURS, time, &plot)?;
        let points: Vec<_> = share
            .iter()
            .enumerate()
            .map(|(k, share)| [k as f64 + 1.0, 1e2 * share])
            .collect();
        plot.draw_curve(
            rec,
            paths::DELAY_NEIGHBOURS_CURVE,
            time,
            points.iter().copied(),
            (style::SIGNAL, 1.2),
        )?;
        plot.draw_points(
            rec,
            paths::DELAY_NEIGHBOURS_POINTS,
            time,
            points.iter().copied(),
            (style::SIGNAL, 3.0),
        )?;
        let index = choice.dimension.saturating_sub(1);
        let chosen = points.get(index).copied().unwrap_or([1.0, 0.0]);
        plot.draw_marker_line(rec, paths::DELAY_NEIGHBOURS_CHOSEN, time, chosen)?;
        let words = format!(
            "m = {}: {} % false{}; Theiler window {}",
            choice.dimension,
            short(chosen[1]),
            if choice.unfolded {
                ""
            } else {
                ", the lowest share"
            },
            Quantity::Time.format(dt * choice.theiler as f64),
        );
        plot.draw_caption(rec, paths::DELAY_NEIGHBOURS, time, &words)
    }
}

fn plot(x: Axis, y: Axis) -> Plot {
    Plot {
        width: SIZE[0],
        height: SIZE[1],
        top_margin: CAPTION_HEIGHT,
        x,
        y,
        grid: true,
    }
}
