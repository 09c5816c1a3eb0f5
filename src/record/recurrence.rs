//! The recurrence plot, Eq. (26): recurrent pairs are bright, other pairs are shaded by distance.
//!
//! A pixel is a class index of one byte: a shade of distance, or recurrence. The viewer looks up the colour
//! and displays the name of the class under the cursor. Colours instead of indices would take three times the
//! space.

use super::{
    error::RecordError,
    panel_view::PanelView,
    paths,
    plot::Bounds,
    stream::{Moment, RecordingStream},
    style::Quantity,
};
use crate::analysis::RecurrenceImage;
use crate::plot::response;

/// Side of the plot area, pixels.
const SIDE: f32 = 400.0;

/// Draws recurrence plots.
#[derive(Debug)]
pub struct Recurrence {
    view: PanelView,
    quantity: Quantity,
}

impl Recurrence {
    /// Starts without a plot; the axes are drawn with the first one.
    pub fn new(quantity: Quantity) -> Self {
        Self {
            view: PanelView::new(paths::RECURRENCE, [SIDE; 2]),
            quantity,
        }
    }

    /// Bounds of the view; they do not depend on the window.
    pub fn bounds() -> Bounds {
        let panel = response::recurrence(None, true).with_caption("caption");
        PanelView::new(paths::RECURRENCE, [SIDE; 2]).bounds(&panel)
    }

    /// Draws a plot at the end of its window.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        at: impl Into<Moment>,
        picture: &RecurrenceImage,
    ) -> Result<(), RecordError> {
        let caption = caption(picture, &self.quantity);
        let panel = response::recurrence(Some(picture), true).with_caption(caption);
        self.view.draw(rec, Some(at.into()), &panel)
    }
}

/// Recurrence rate, threshold (a distance in the unit of `quantity`), dimension and delay of a recurrence
/// plot.
pub fn caption(plot: &RecurrenceImage, quantity: &Quantity) -> String {
    let epsilon = match plot.threshold {
        Some(threshold) => format!("ε = {}", quantity.format(threshold)),
        None => "ε chosen for each state".to_owned(),
    };
    format!(
        "RR = {:.0} %, {epsilon}, m = {}, τ = {}",
        1e2 * plot.rate,
        plot.dimension,
        Quantity::Time.format(plot.lag),
    )
}
