//! squeakscope watches friction squeak: how a ball joint goes from silence to a
//! pure tone, to a torus, to chaos, as the load on it tilts.
//!
//! One road leads through the crate:
//!
//! ```text
//! scene -> joint -> dynamics -> frame -> analysis -> record
//!           |
//!          fem
//! ```
//!
//! * [`fem`]: meridian finite elements of a solid of revolution; knows no joint.
//! * [`joint`]: the physics of Kang, Lubricants 2022, 10, 201, Eq. (1) to (8).
//! * [`dynamics`]: integrators; knows no joint.
//! * [`systems`]: small systems with known motions, for the engine's tests and small scenes.
//! * [`analysis`]: slices of samples in, values out.
//! * [`scene`]: what to run, parsed and validated once.
//! * [`pipeline`]: the threads and what travels between them.
//! * [`text`]: words for what a run shows.
//! * `record` (feature `record`): the only room that knows Rerun.
//! * `sound` (feature `sound`): motions to listen to.
//! * `live` (feature `live`): a run that is steered while it goes on, and the page that shows it.
//! * `cli` (feature `cli`): the command line.
//! * [`numpy`]: arrays in `.npz` files, as others write them.
//! * [`memory`]: how much there is, for those who read files.
//! * [`import`]: signals from files that somebody else made.
//! * `plot`: figures as data; drawn as SVG, PNG and PDF (feature `figure`).
//! * `escape` (private): text from foreign files, as it is shown.
//! * `number`, `table` (private): numbers and tables as text.
//! * [`guide`]: longer pages, on the equations and on numerical stability.

#![cfg_attr(
    test,
    allow(
        clippy::too_many_lines,
        reason = "the steps of a test are read in one place"
    )
)]

pub mod analysis;
pub mod dynamics;
pub mod export;
pub mod fem;
#[cfg(any(feature = "record", feature = "table"))]
mod foreign;
pub mod guide;
pub mod import;
pub mod joint;
pub mod memory;
#[cfg_attr(
    not(feature = "cli"),
    allow(dead_code, reason = "some formats are those of the terminal")
)]
mod number;
pub mod numpy;
pub mod pipeline;
pub mod scene;
pub mod study;
pub mod systems;
pub mod text;

#[cfg(feature = "cli")]
mod cli;
#[cfg(any(feature = "figure", feature = "record"))]
pub(crate) mod escape;
#[cfg(feature = "live")]
pub mod live;
#[cfg(any(feature = "figure", feature = "record"))]
pub mod plot;
#[cfg(feature = "record")]
pub mod record;
#[cfg(feature = "sound")]
pub mod sound;
#[cfg(feature = "record")]
#[cfg_attr(
    not(feature = "cli"),
    allow(dead_code, reason = "one form is that of the terminal")
)]
mod table;

#[cfg(feature = "cli")]
pub use cli::main;

/// The version of this crate, as written into every recording and result.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
