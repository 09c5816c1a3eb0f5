//! Simulation and analysis of friction-induced vibration: as the load of a ball joint tilts, steady sliding
//! gives way to periodic, quasi-periodic and chaotic motion.
//!
//! Data flows one way:
//!
//! ```text
//! scene -> joint -> dynamics -> frames -> analysis -> records -> recording, viewer, page, figures
//!           |
//!          fem
//! ```
//!
//! # Five examples
//!
//! Simulate a scene. A [`Sink`](pipeline::Sink) receives the records of the run in order:
//!
//! ```
//! use squeakscope::pipeline::message::Record;
//! use squeakscope::pipeline::{Monitor, Sink, SinkError, run};
//! use squeakscope::scene::Scene;
//! /// The largest displacement of the patch centre, m.
//! struct Largest(f64);
//!
//! impl Sink for Largest {
//!     fn accept(&mut self, record: Record) -> Result<(), SinkError> {
//!         if let Record::Samples(frame) = record {
//!             self.0 = frame.displacement.iter().fold(self.0, |largest, u| largest.max(u.abs()));
//!         }
//!         Ok(())
//!     }
//! }
//!
//! let scene = Scene::load("periodic-2deg")?.with_duration(5.0)?;
//! let mut largest = Largest(0.0);
//! let summary = run(&scene, "an example", &mut largest, Monitor::default())?;
//! assert!((summary.simulated_s - 5e-3).abs() < 1e-5);
//! assert!(largest.0 > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Find the unstable modes from the complex eigenvalues at steady sliding, at tilts in rad:
//!
//! ```
//! use squeakscope::joint::BallJoint;
//! use squeakscope::scene::Scene;
//! use squeakscope::study::stability;
//!
//! let scene = Scene::load("torus-1.75deg")?;
//! let ball = BallJoint::new(&scene.joint()?.spec)?;
//! for at in stability(&ball, &[1.0_f64.to_radians(), 3.0_f64.to_radians()])? {
//!     for mode in at.unstable() {
//!         println!("{:.1} Hz grows by {:.0} 1/s: {}", mode.frequency_hz, mode.growth, mode.label);
//!     }
//!     assert!(at.unstable().count() > 0);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Compute Lyapunov exponents with their 95 % intervals:
//!
//! ```
//! use squeakscope::scene::Scene;
//! use squeakscope::study::lyapunov::{Goal, LyapunovRequest, scene_lyapunov};
//!
//! let request = LyapunovRequest {
//!     count: None,
//!     settle: None,
//!     goal: Goal::Time(2.0),
//!     tolerance: None,
//! };
//! let scene = Scene::load("impact-oscillator")?;
//! let found = scene_lyapunov(&scene, &request, &mut |_, _| Ok(()))?;
//! for exponent in &found.study.spectrum.exponents {
//!     println!("{:.3} ± {:.3} 1/s", exponent.value, exponent.half_width);
//! }
//! println!("{}", found.study.attractor());
//! assert_eq!(found.study.spectrum.exponents.len(), found.study.spectrum.dimension);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Classify the type of motion of a signal, here a synthetic one; [`import::read_signal`] reads files:
//!
//! ```
//! use squeakscope::analysis::regime::Regime;
//! use squeakscope::import::Signal;
//! use squeakscope::study::signal::{SignalOptions, analyse_signal};
//!
//! let signal = Signal {
//!     name: "tone".to_owned(),
//!     unit: "m".to_owned(),
//!     rate: 48_000.0,
//!     start: 0.0,
//!     samples: (0..9600).map(|k| (0.5 * f64::from(k)).sin()).collect(),
//! };
//! let report = analyse_signal(signal, &SignalOptions::default(), &mut |_, _| Ok(()))?;
//! assert_eq!(report.verdict.get()?.regime, Regime::Periodic);
//! println!("{:.1} Hz", report.tones.lines[0].line.frequency);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Run a sweep: the settled response at each value of a scene parameter, here by upward continuation
//! from one value to the next:
//!
//! ```
//! use squeakscope::scene::{Parameter, Scene};
//! use squeakscope::study::response::ResponsePlan;
//! use squeakscope::study::StudyError;
//! use squeakscope::study::sweep::{Axis, Shard, Start, SweepPlan, sweep};
//!
//! let plan = SweepPlan {
//!     subject: Scene::load("periodic-2deg")?,
//!     axes: vec![Axis::new(Parameter::tilt(), [1.5, 2.0])],
//!     starts: vec![Start::Upward],
//!     response: ResponsePlan {
//!         min_transient_s: 0.02,
//!         max_transient_s: 0.03,
//!         measurement_s: 0.01,
//!         exponents: 0,
//!         ..ResponsePlan::default()
//!     },
//! };
//! let points = sweep(&plan, Shard::WHOLE, Vec::new(), 1, &mut |_, _| Ok(()), |point| {
//!     println!("computed: {:?}", point.place.values);
//!     Ok::<_, StudyError>(())
//! })?;
//! for point in &points {
//!     let response = point.outcome.clone()?;
//!     println!("{} deg: {}, {:.2e} m", point.place.values[0], response.regime, response.amplitude_m);
//! }
//! assert_eq!(points.len(), 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Modules
//!
//! Three crates of their own, which know nothing of the program:
//!
//! * [`dynamics`]: integrators, events, tangent flow (`squeakscope-dynamics`).
//! * [`analysis`]: signal analysis of slices of samples (`squeakscope-analysis`).
//! * [`joint`]: the physics of Kang, Lubricants 2022, 10, 201, Eq. (1) to (8), with [`fem`], axisymmetric finite elements
//!   of a solid of revolution, and [`systems`], small systems with known motions (`squeakscope-joint`).
//!
//! The program:
//!
//! * [`scene`]: the description of a run, parsed and validated once.
//! * [`pipeline`]: the threads of a run and the messages between them.
//! * [`study`]: many runs: sweeps, basins, exponents, cost, the paper.
//! * [`text`]: texts that describe the results of a run, from templates.
//! * [`import`], [`export`], [`numpy`]: signals, samples and models as files.
//! * `plot`: figures as data, rendered as SVG, PNG and PDF (feature `figure`).
//! * `record`: recordings for the Rerun viewer (feature `record`).
//! * `sound`: audio of the motion (feature `sound`).
//! * [`memory`]: available memory, used to limit the size of files that are read.
//! * [`guide`]: the user guide: equations, numerics and commands.

#![cfg_attr(
    test,
    allow(
        clippy::too_many_lines,
        reason = "a test that reads from top to bottom is easier to follow than one split into helpers"
    )
)]

mod causes;
pub mod export;
mod foreign;
pub mod guide;
pub mod import;
#[cfg_attr(
    not(feature = "cli"),
    allow(dead_code, reason = "some formats are used by the command line only")
)]
mod number;
pub mod numpy;
pub mod pipeline;
pub mod report;
pub mod scene;
pub mod study;
pub mod text;

pub use causes::chain_of_causes;
pub use squeakscope_analysis as analysis;
pub(crate) use squeakscope_analysis::memory;
pub use squeakscope_dynamics as dynamics;
pub use squeakscope_joint as joint;
pub use squeakscope_joint::{fem, systems};

#[cfg(test)]
#[allow(
    dead_code,
    reason = "the tests of the analysis use more of these signals"
)]
#[path = "../crates/analysis/src/test_signals/mod.rs"]
mod test_signals;

#[cfg(feature = "cli")]
mod cli;
#[cfg_attr(
    not(feature = "record"),
    allow(
        dead_code,
        reason = "some functions are used by recordings and figures only"
    )
)]
mod escape;
// Public only for the integration tests, which control sessions through it.
#[cfg(feature = "live")]
#[doc(hidden)]
pub mod live;
#[cfg(feature = "figure")]
pub mod plot;
#[cfg(feature = "record")]
pub mod record;
#[cfg(feature = "sound")]
pub mod sound;

#[cfg(feature = "cli")]
pub use cli::main;

/// The version of this crate; every recording and result file contains it.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
