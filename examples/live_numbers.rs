//! A custom sink: prints the narration and the strongest spectral lines as they arrive.
//!
//! A sink receives the records of a run in order, on the thread that called `run`. It can stop the run
//! with an error. A slow sink can accept that pictures are replaced by later ones.
//!
//! ```text
//! cargo run --release --example live_numbers
//! ```

use std::error::Error;

use squeakscope::pipeline::message::Record;
use squeakscope::pipeline::{Monitor, Sink, SinkError, run};
use squeakscope::scene::Scene;
use squeakscope::text::narration;

/// Prints selected records.
struct Printer;

impl Sink for Printer {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        match record {
            Record::Header(header) => println!("{}: {}", header.scene, header.title),
            Record::Narration { observation, .. } => {
                let text = narration(&observation);
                for line in text.lines().filter(|line| !line.is_empty()) {
                    println!("        | {line}");
                }
            }
            Record::Spectrum { time, peaks, .. } => {
                let lines: Vec<_> = peaks
                    .iter()
                    .take(3)
                    .map(|p| format!("{:.0} Hz ({:.2} mm/s)", p.frequency, 1e3 * p.amplitude))
                    .collect();
                println!("{:5.1} ms  {}", 1e3 * time, lines.join(", "));
            }
            Record::Warning { text, .. } => println!("warning: {text}"),
            Record::Summary(summary) => println!(
                "{} steps for {:.0} ms, {:.2} of real time; energy audit {:.1e}",
                summary.stats.steps,
                1e3 * summary.simulated_s,
                summary.real_time_factor,
                summary.energy_residual.unwrap_or(f64::NAN),
            ),
            // Samples, pictures and health records are ignored.
            _ => {}
        }
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = Scene::load("periodic-2deg")?.with_duration(80.0)?;
    run(
        &scene,
        "example live_numbers",
        &mut Printer,
        Monitor::default(),
    )?;
    Ok(())
}
