//! `squeakscope cost`: what accuracy and effects cost in a scene.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::console;
use super::error::CliError;
use super::figures::STUDY;
use super::harness::{Outputs, Watch};
use super::resources;
use super::study_args::CostArgs;
use crate::pipeline::{Monitor, Simulation, drive};
use crate::plot::cost_figure;
use crate::record::{Output, RerunSink};
use crate::scene::Scene;
use crate::study::StudyError;
use crate::study::cost::{Cost, cost};

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while running or writing; an interrupt, after the complete part is written.
pub(super) fn execute(args: &CostArgs, stop: &Arc<AtomicBool>) -> Result<(), CliError> {
    let scene = args.scene.load()?;
    console::print_study_warnings(&scene);
    let outputs = Outputs::new(args.scene.input(), &args.output);
    let files = outputs.figures(&args.figures, STUDY, ["cost"])?;
    resources::check_memory()?;
    resources::start_thread_pool()?;
    let watch = Watch::new(stop);
    let study = measure(&scene, stop, &watch).map_err(CliError::during("cost study"))?;
    files.finish(watch, Some(&scene.name), &study, |files| {
        files.draw(|| vec![cost_figure(&scene.name, &study)])
    })
}

/// Runs the study; recordings go to a temporary directory.
fn measure(scene: &Scene, stop: &Arc<AtomicBool>, watch: &Watch<'_>) -> Result<Cost, StudyError> {
    let run_all = &mut |scene: &Scene| {
        let folder = tempfile::tempdir()?;
        let output = Output {
            save: Some(folder.path().join("cost.rrd")),
            ..Output::default()
        };
        let run = Simulation::new(scene)?;
        let mut sink = RerunSink::new(&output, scene.record)?;
        let monitor = Monitor {
            stop,
            ..Monitor::default()
        };
        drive(run, "", &mut sink, monitor)?;
        Ok(())
    };
    cost(scene, Some(run_all), &mut watch.progress())
}
