//! Records a scene for the Rerun viewer, using the library.
//!
//! The scene is loaded by name or from a file, modified within the permitted ranges of its keys, and run
//! into a sink. Here the sink writes a `.rrd` file, which gets its final name only after it is complete.
//!
//! ```text
//! cargo run --release --example record_scene -- [FOLDER]
//! rerun FOLDER/record_scene.rrd
//! ```

use std::error::Error;
use std::path::PathBuf;

use squeakscope::pipeline::{Monitor, run};
use squeakscope::record::{Output, RerunSink};
use squeakscope::scene::Scene;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).unwrap_or_else(|| ".".into()));
    let path = folder.join("record_scene.rrd");

    let scene = Scene::load("periodic-2deg")?
        .with_tilt(3.0)?
        .with_duration(60.0)?;
    let output = Output {
        save: Some(path.clone()),
        ..Output::default()
    };
    let mut sink = RerunSink::new(&output, scene.record)?;
    let summary = run(
        &scene,
        "example record_scene",
        &mut sink,
        Monitor::default(),
    )?;

    println!(
        "{} at {:.1} deg: {:.0} ms simulated in {:.2} s, {:.2} of real time while integrating",
        scene.name,
        scene.joint()?.tilt.at(0.0).to_degrees(),
        1e3 * summary.simulated_s,
        summary.wall_s,
        summary.real_time_factor,
    );
    println!(
        "displacement up to {:.3} um, velocity up to {:.2} mm/s",
        1e6 * summary.amplitude_m,
        1e3 * summary.peak_velocity_m_per_s,
    );
    for peak in summary.lines.iter().take(3) {
        println!(
            "{:>8.1} Hz  {:>7.3} mm/s  {}",
            peak.frequency,
            1e3 * peak.amplitude,
            peak.label,
        );
    }
    println!(
        "{} steps, {} evaluations of the right-hand side, energy audit {:.1e}",
        summary.stats.steps,
        summary.stats.rhs_evals,
        summary.energy_residual.unwrap_or(f64::NAN),
    );
    let megabytes = 1e-6 * std::fs::metadata(&path)?.len() as f64;
    println!("{}: {megabytes:.1} MB", path.display());
    Ok(())
}
