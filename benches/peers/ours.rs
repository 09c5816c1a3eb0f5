//! squeakscope's program for `compare.py`: times on the series in a folder, as one line of JSON.
//!
//! ```text
//! cargo bench --no-default-features --bench peers -- FOLDER
//! ```
//!
//! FOLDER contains `rqa.npy`, `ami.npy`, `fnn.npy` and `stft.npy`. `RAYON_NUM_THREADS` sets the number
//! of threads.

use std::error::Error;
use std::fs::File;
use std::hint::black_box;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::time::Instant;

use npyz::NpyFile;
use serde_json::{Value, json};
use squeakscope::analysis::{
    AnalysisError,
    delay::{DelayVectors, FalseNeighbourSearch, false_neighbours, mutual_information},
    recurrence::{Norm, RateBase, RecurrenceCriterion, Recurrences, Threshold},
    tones::{Stft, Window},
};

/// Lag of the recurrence plot and of the false neighbours, samples.
const LAG: usize = 16;
/// Recurrent share of the pairs.
const RATE: f64 = 0.05;
/// Repetitions of a task; the shortest time counts.
const REPEATS: usize = 7;

/// Shortest time of a task, s, and its result.
fn timed<T>(mut task: impl FnMut() -> Result<T, AnalysisError>) -> Result<(f64, T), AnalysisError> {
    let mut result = task()?;
    let mut best = f64::INFINITY;
    for _ in 0..REPEATS {
        let began = Instant::now();
        result = black_box(task()?);
        best = best.min(began.elapsed().as_secs_f64());
    }
    Ok((best, result))
}

fn series(folder: &Path, name: &str) -> Result<Vec<f64>, Box<dyn Error>> {
    let file = File::open(folder.join(name).with_extension("npy"))?;
    Ok(NpyFile::new(BufReader::new(file))?.into_vec()?)
}

fn quantification(samples: &[f64]) -> Result<Value, AnalysisError> {
    let vectors = DelayVectors::new(samples, LAG, 5)?;
    let rule = |threshold| RecurrenceCriterion {
        norm: Norm::Euclidean,
        threshold,
        theiler: 1,
    };
    let epsilon = Recurrences::of(&vectors, &rule(Threshold::Rate(RATE)))?
        .distance()
        .expect("a rate has a distance");
    // As in normal use: counts and all measures.
    let (seconds, measures) = timed(|| {
        let rule = rule(Threshold::Distance(epsilon));
        let recurrences = Recurrences::of(black_box(&vectors), &rule)?;
        Ok(recurrences.counts().measures(2, 2, RateBase::Counted))
    })?;
    let result = json!({
        "epsilon": epsilon,
        "recurrence_rate": measures.recurrence_rate,
        "determinism": measures.determinism,
        "mean_diagonal": measures.mean_diagonal,
    });
    Ok(json!({"seconds": seconds, "result": result}))
}

fn information(samples: &[f64]) -> Result<Value, AnalysisError> {
    let (seconds, found) = timed(|| mutual_information(black_box(samples), 100, 64))?;
    let result = json!({
        "first_minimum": found.first_clear_minimum(),
        "bits_at_lag_10": found.bits[10],
    });
    Ok(json!({"seconds": seconds, "result": result}))
}

fn neighbours(samples: &[f64]) -> Result<Value, AnalysisError> {
    let search = FalseNeighbourSearch {
        lag: LAG,
        largest_dimension: 8,
        theiler: 16,
        distance_ratio: 15.0,
        size_ratio: 2.0,
    };
    let (seconds, found) = timed(|| false_neighbours(black_box(samples), &search))?;
    Ok(json!({"seconds": seconds, "result": {"share": found.share[..4]}}))
}

fn spectrogram(samples: &[f64]) -> Result<Value, AnalysisError> {
    let (seconds, columns) = timed(|| {
        let mut stft = Stft::new(Window::Hann, 1024, 256.0, 1.0);
        let mut columns = 0;
        stft.push(black_box(samples), |column| {
            black_box(column);
            columns += 1;
            Ok::<(), AnalysisError>(())
        })?;
        Ok(columns)
    })?;
    Ok(json!({"seconds": seconds, "result": {"columns": columns}}))
}

fn main() -> Result<(), Box<dyn Error>> {
    // Cargo adds its own flags.
    let folder = std::env::args().skip(1).find(|a| !a.starts_with("--"));
    let Some(folder) = folder.map(PathBuf::from) else {
        println!("benches/peers/compare.py runs this; give the folder with its series");
        return Ok(());
    };
    let of = |name: &str| series(&folder, name);
    let report = json!({
        "rqa": quantification(&of("rqa")?)?,
        "ami": information(&of("ami")?)?,
        "fnn": neighbours(&of("fnn")?)?,
        "stft": spectrogram(&of("stft")?)?,
    });
    println!("{report}");
    Ok(())
}
