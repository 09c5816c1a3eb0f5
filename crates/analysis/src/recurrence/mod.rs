//! Recurrence plots and recurrence quantification analysis.
//!
//! [`Recurrences`] are the recurrent pairs of a signal, or of two. [`RecurrenceCounts`] count their points and lines,
//! and [`Measures`] follow from the counts. A [`RecurrenceImage`] shows a few hundred states.

mod counts;
mod measures;
mod period;
mod plot;
mod recurrences;
mod threshold;

pub use crate::norm::Norm;
pub use counts::{LineHistogram, RecurrenceCounts};
pub use measures::{Measures, RateBase};
pub use period::{RecurrenceKind, RecurrencePeriod, RecurrencePeriods};
pub use plot::RecurrenceImage;
pub use recurrences::Recurrences;
pub use threshold::{RecurrenceCriterion, Threshold};
