//! Classifies the motion in a slice of samples, using the library.
//!
//! ```text
//! cargo run --release --no-default-features --example analyse_signal
//! ```
//!
//! The signal consists of two tones and their product, as a nonlinearity generates it: a torus.
//! `squeakscope::import::read_signal` reads a signal from a file.

use std::error::Error;
use std::f64::consts::TAU;

use squeakscope::import::Signal;
use squeakscope::study::signal::{SignalOptions, analyse_signal};

fn main() -> Result<(), Box<dyn Error>> {
    let rate = 48_000.0;
    let tone = |frequency: f64, k: u32| (TAU * frequency * f64::from(k) / rate).sin();
    let sample = |k: u32| {
        let (slow, fast) = (tone(570.0, k), tone(3873.1, k));
        fast + 0.4 * slow + 0.2 * slow * fast
    };
    let signal = Signal {
        name: "two tones".to_owned(),
        unit: "m/s".to_owned(),
        rate,
        start: 0.0,
        samples: (0..24_000).map(sample).collect(),
    };
    let report = analyse_signal(signal, &SignalOptions::default(), &mut |share, step| {
        eprintln!("{:>3.0} % {step}", 100.0 * share);
        Ok(())
    })?;

    for event in report.events() {
        let (start, end) = (event.start_s, event.end_s);
        println!("{start:.3} to {end:.3} s: {:.1} Hz", event.frequency_hz);
    }
    let verdict = report.verdict.get()?;
    println!("{}", verdict.summary());
    for evidence in &verdict.evidence {
        println!("  {}: {}", evidence.supports, evidence.description);
    }
    for named in &report.tones.lines {
        println!("{:>10.2} Hz  {}", named.line.frequency, named.line.label);
    }
    println!(
        "tau = {:.0} us, m = {}, DET = {:.3}, K = {:.2}",
        1e6 * report.embedding.get()?.lag_s,
        report.embedding.get()?.choice.dimension,
        report.recurrence.get()?.measures.determinism.unwrap_or(0.0),
        report.zero_one.get()?.k
    );
    Ok(())
}
