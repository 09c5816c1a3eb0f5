//! Rerun recordings. This is the only module that depends on Rerun and names entity paths.
//!
//! [`RerunSink`] receives the records of the pipeline and writes them to a `.rrd` file, to a viewer, or to
//! both. Each submodule draws one type of record; `paths` defines all entity paths, and `blueprint` defines
//! the layout of the viewer.
//!
//! * Time: one timeline, `sim_time`, the simulated time as a duration in ns. [`sweep`] saves a sweep with the
//!   swept parameter as its timeline.
//! * Units: µm, mm/s, mm, kHz, degrees, µJ, as stated in the names of the series. All other modules use SI
//!   units.
//! * Rows: samples are sent as columns, about 1,000 rows per call, which takes 10 to 20 bytes per row. Plots
//!   have a fixed size and are sent one by one.
//! * Threads: Rerun's own recording stream is not used; see `stream`. Each file has one thread, which ends
//!   when the file is complete. A long session with many recordings therefore leaks neither threads nor
//!   memory, and the environment variable `RERUN`, which disables Rerun's streams, has no effect.
//! * Safety: the file is written next to its final path and renamed at the end ([`RerunSink`]), so a failed
//!   run never replaces an existing recording.
//!
//! ```no_run
//! use squeakscope::{pipeline::Sink, record::{Output, RerunSink}, scene::RecordSpec};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
//! # let (spec, records) = (RecordSpec {
//! #     patch_rate: 20e3, patch_nodes: 100, body_rate: 2e3, energy_rate: 20e3, deformation_scale: 3000.0,
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

mod blueprint;
mod body;
pub mod branch;
mod camera;
mod controls;
mod encode;
mod error;
mod exponents;
mod figures;
mod file;
mod health;
mod lesson;
mod messages;
mod panel_view;
mod part_file;
mod patch;
pub mod paths;
mod perturbed;
mod plot;
mod portrait;
mod quantification;
mod read;
mod regime;
mod samples;
mod series;
mod sink;
mod small;
mod spectrogram;
mod stream;
mod style;
pub mod sweep;
mod text;
mod viewer;

#[cfg(test)]
mod tests;

/// Rerun's SDK with its types.
pub(crate) mod sdk {
    pub use re_sdk_types::DynamicArchetype;
    pub use re_sdk_types::archetypes::*;
    pub use re_sdk_types::components::{self, Color, Radius, TextLogLevel};
    pub use re_sdk_types::datatypes::{self, ClassDescription, Rgba32};
    pub use rerun::log::TimeColumn;
    pub use rerun::*;
}

pub use error::RecordError;
pub use figures::RunFigures;
pub use messages::Damage;
pub(crate) use part_file::PartFile;
#[cfg(feature = "live")]
pub(crate) use portrait::TRAIL;
pub use read::{ReadError, Series, check_recording, read_series};
pub use sink::{APPLICATION, Output, RerunSink};
#[cfg(feature = "live")]
pub(crate) use style::node as node_color;

/// Address space required for a recording, bytes. Its threads reserve nearly all of it, but use little.
const ADDRESS_SPACE: usize = 640 << 20;

/// Checks that enough address space for a recording is available.
///
/// # Errors
/// [`RecordError::Memory`] if it is not.
pub fn check_memory() -> Result<(), RecordError> {
    if crate::memory::can_reserve(ADDRESS_SPACE) {
        Ok(())
    } else {
        Err(RecordError::Memory)
    }
}

/// The Rerun version of the recordings; a viewer of this version opens them.
pub const RERUN_VERSION: &str = "0.36.3";
