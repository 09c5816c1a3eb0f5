//! When does the system come back to where it was? Recurrence plots and their quantification.
//!
//! What is counted is defined once, with [`RecurrenceCounts`]; [`quantify`] counts a whole signal,
//! [`RecurrenceWindow`] a stream. A [`RecurrencePlot`] draws a few hundred states.

mod counts;
mod measures;
mod period;
mod plot;
mod quantify;
mod sweep;
mod tally;
mod threshold;
mod window;

pub use counts::{LineHistogram, RecurrenceCounts};
pub use measures::{Measures, RateBase};
pub use plot::{RecurrenceImage, RecurrencePicture, RecurrencePlot};
pub use quantify::quantify;
pub use threshold::{RecurrenceRule, Threshold, find_threshold};
pub use window::RecurrenceWindow;
