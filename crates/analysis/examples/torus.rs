//! Spectral lines and type of motion of a torus: two tones and their product, as a nonlinearity generates it.
//!
//! ```text
//! cargo run --release -p squeakscope-analysis --example torus
//! ```

use std::f64::consts::TAU;

use squeakscope_analysis::{
    AnalysisError,
    regime::{RegimeSearch, classify},
    tones::{LineCriterion, SpectrumAnalyser, Window, identify_lines},
};

const SAMPLE_RATE: f64 = 48_000.0;

fn main() -> Result<(), AnalysisError> {
    let tone = |frequency: f64, k: u32| (TAU * frequency * f64::from(k) / SAMPLE_RATE).sin();
    let sample = |k: u32| {
        let (slow, fast) = (tone(570.0, k), tone(3873.1, k));
        fast + 0.4 * slow + 0.2 * slow * fast
    };
    let samples: Vec<f64> = (0..24_000).map(sample).collect();

    let spectrum = SpectrumAnalyser::new(Window::BlackmanHarris, SAMPLE_RATE).analyse(&samples)?;
    let lines = spectrum.lines(&LineCriterion::default());
    let names = identify_lines(&lines, 0.25 * spectrum.bin).names;
    for (line, name) in lines.iter().zip(names) {
        let name = name.map_or("unexplained".to_owned(), |name| name.to_string());
        println!("{:8.2} Hz  {:.3}  {name}", line.frequency, line.amplitude);
    }

    let search = RegimeSearch {
        sample_rate: SAMPLE_RATE,
        silence: 0.0,
        background: 0.0,
    };
    let verdict = classify(&samples, &search)?;
    println!("{}", verdict.summary());
    for evidence in &verdict.evidence {
        println!("  {}: {}", evidence.supports, evidence.description);
    }
    Ok(())
}
