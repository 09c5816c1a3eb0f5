//! Recurrence plots and recurrence quantification analysis.
//!
//! [`RecurrenceCounts`] defines the counts. [`quantify`] computes them for a signal. A [`RecurrencePlot`] is an image of a few hundred states.

mod counts;
mod cross;
mod diagonals;
mod line_counter;
mod measures;
mod period;
mod plot;
mod quantify;
mod threshold;

pub use counts::{LineHistogram, RecurrenceCounts};
pub use cross::CrossRecurrence;
pub use measures::{Measures, RateBase};
pub use period::{RecurrenceKind, RecurrencePeriod, RecurrencePeriods};
pub use plot::{RecurrenceImage, RecurrencePlot, ThresholdedPlot};
pub use quantify::quantify;
pub use threshold::{RecurrenceCriterion, Threshold, find_threshold};
