//! Choice of the delay embedding (Fig. 8): average mutual information over the delay, and false nearest
//! neighbours over the dimension.

use super::{
    error::RecordError,
    panel_view::PanelView,
    paths,
    plot::Bounds,
    stream::{Moment, RecordingStream},
    style::{Quantity, short},
};
use crate::{
    analysis::{DelayChoice, LagReason},
    plot::{Axis, Panel, false_neighbours, mutual_information},
};

/// Size of both plots, pixels.
const SIZE: [f32; 2] = [400.0, 210.0];

/// Draws choices of delay and dimension.
#[derive(Debug)]
pub struct Delay {
    mutual: PanelView,
    neighbours: PanelView,
}

impl Default for Delay {
    fn default() -> Self {
        Self {
            mutual: PanelView::new(paths::DELAY_MUTUAL, SIZE),
            neighbours: PanelView::new(paths::DELAY_NEIGHBOURS, SIZE),
        }
    }
}

impl Delay {
    /// Bounds of both views.
    pub fn bounds() -> Bounds {
        let axis = || Axis::linear("name", [0.0, 1.0]);
        let panel = Panel::new("", axis(), axis(), Vec::new());
        PanelView::new("", SIZE).bounds(&panel.with_caption("caption"))
    }

    /// Draws the choice of a window that ends at `time` (s), with samples `dt` (s) apart.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        dt: f64,
        choice: &DelayChoice,
    ) -> Result<(), RecordError> {
        let at = Some(Moment::from(time));
        let unit = Quantity::Time.unit(dt * choice.mutual.bits.len() as f64);
        let step = unit.per_si * dt;
        let why = match choice.reason {
            LagReason::FirstMinimum => "first minimum",
            LagReason::FirstDecay => "first value below 1/e of the initial one; no minimum",
            LagReason::Largest => "largest delay tried; no minimum, no decay below 1/e",
        };
        let words = format!(
            "τ = {} {} ({} samples): {why}",
            short(step * choice.lag as f64),
            unit.symbol,
            choice.lag
        );
        let mutual = mutual_information(choice, &unit.symbol, step).with_caption(words);
        self.mutual.draw(rec, at, &mutual)?;
        let share = choice
            .neighbours
            .share
            .get(choice.dimension.wrapping_sub(1));
        let words = format!(
            "m = {}: {} % false{}; Theiler window {}",
            choice.dimension,
            short(100.0 * share.copied().unwrap_or(0.0)),
            if choice.unfolded {
                ""
            } else {
                ", the lowest share"
            },
            Quantity::Time.format(dt * choice.theiler as f64),
        );
        let neighbours = false_neighbours(choice).with_caption(words);
        self.neighbours.draw(rec, at, &neighbours)
    }
}
