//! Rerun recordings: the only room that knows Rerun, and the only one that names an entity path.
//!
//! [`RerunSink`] takes the pipeline's records and writes them to a `.rrd` file, to a viewer, or
//! to both. What each record draws is said in one file a subject; `paths` spells every entity,
//! `blueprint` lays out the viewer's screen.
//!
//! * Time: one timeline, `sim_time`, a duration in ns of simulated time. ([`sweep`] saves a sweep
//!   instead of a run, with the swept parameter as its timeline, [`cost`] what accuracy costs, with none.)
//! * Units: µm, mm/s, mm, kHz, degrees, µJ, as the names of the series say. (SI ends here.)
//! * Rows: samples go as columns, about a thousand rows a call, which costs 10 to 20 bytes a
//!   row; pictures go one by one at a fixed size.
//! * Threads: none of Rerun's recording stream, see `stream`; a file has one of its own, which ends with it.
//!   So a long session of recordings keeps neither threads nor memory, and the variable `RERUN`, which turns
//!   Rerun's streams off, has no effect.
//! * Safety: the file is written beside its place and renamed at the end ([`RerunSink`]), so an
//!   existing recording is never replaced by a failed run.
//!
//! ```no_run
//! use squeakscope::{pipeline::Sink, record::{Output, RerunSink}, scene::RecordSpec};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
//! # let (spec, records) = (RecordSpec {
//! #     patch_rate: 20e3, body_rate: 2e3, energy_rate: 20e3, exaggeration: 3000.0,
//! # }, Vec::new());
//! let output = Output { save: Some("squeak.rrd".into()), ..Output::default() };
//! let mut sink = RerunSink::new(&output, spec)?;
//! for record in records {
//!     sink.accept(record)?;
//! }
//! sink.finish()?;
//! # Ok(())
//! # }
//! ```

mod audience;
mod blueprint;
mod body;
mod butterfly;
mod chaos;
pub mod cost;
mod delay;
mod due;
mod encode;
mod error;
mod exponents;
mod figure;
mod file_stream;
mod health;
mod lesson;
mod messages;
mod part_file;
mod patch;
pub mod paths;
mod plot;
mod portrait;
mod quantification;
mod read;
mod recurrence;
mod regime;
mod rrd_file;
mod samples;
mod section;
mod sink;
mod small;
mod spectrum;
mod stream;
mod style;
pub mod sweep;
mod text;
mod vantage;
mod viewer;

#[cfg(test)]
mod tests;

pub use audience::{Audience, Piece};
pub use error::RecordError;
pub use messages::Damage;
pub(crate) use part_file::PartFile;
pub use read::{ReadError, Series, read_series};
pub use sink::{APPLICATION, Output, RerunSink};

/// Address space that a recording may take, bytes. Its threads reserve nearly all of it; little is ever used.
const ADDRESS_SPACE: usize = 640 << 20;

/// Makes sure that there is memory for a recording.
///
/// # Errors
/// [`RecordError::Memory`].
pub fn check_memory() -> Result<(), RecordError> {
    match crate::memory::is_granted(ADDRESS_SPACE) {
        true => Ok(()),
        false => Err(RecordError::Memory),
    }
}

/// The version of Rerun that recordings are written with; a viewer of this version opens them.
pub const RERUN_VERSION: &str = "0.36.3";
