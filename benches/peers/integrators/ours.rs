//! squeakscope's program for `integrators/compare.py`. It answers one request per line, like the peers.
//!
//! ```text
//! cargo bench --no-default-features --bench integrators -- FOLDER START
//! ```
//!
//! FOLDER contains `scene.toml` and `START.npy`, the start states `[q | dq/dt]`. Requests:
//!
//! * `METHOD SETTING`: integrates from each start over [`HORIZON`] with a method named as in scene
//!   files. The setting is its tolerance, or the step (s) of a method with a fixed step. The answer
//!   contains the time for all starts, the evaluations of the force, and the final states
//!   `[omega q | dq/dt]`.
//! * `force CALLS`: seconds per evaluation of the force, and the force at the first start.

use std::error::Error;
use std::fs::{self, File};
use std::hint::black_box;
use std::io::{BufRead, BufReader, stdin};
use std::path::Path;

use npyz::NpyFile;
use serde_json::{Value, json};
use squeakscope::dynamics::System;
use squeakscope::pipeline::{Prepared, prepare};
use squeakscope::scene::{Parameter, Scene, SceneError};

/// Integration time, s.
const HORIZON: f64 = 4e-3;
/// Maximum step of the adaptive methods, us; larger than any step they choose.
const LONGEST_STEP: f64 = 100.0;

/// CPU time of this thread, s, unaffected by other processes.
fn cpu_seconds() -> f64 {
    cpu_time::ThreadTime::now().as_duration().as_secs_f64()
}

fn with_numbers(scene: &Scene, numbers: &[(&str, f64)]) -> Result<Scene, SceneError> {
    let values: Result<Vec<_>, _> = numbers
        .iter()
        .map(|&(name, value)| Ok((Parameter::named(name)?, value)))
        .collect();
    scene.with_values(&values?)
}

/// The scene's joint with a method and a tolerance, or a step (s) if the step is fixed.
fn prepared(scene: &Scene, method: &str, setting: f64) -> Result<Prepared, Box<dyn Error>> {
    let scene = with_numbers(scene, &[("max_step_us", 1.0)])?;
    let scene = scene.with_overrides(&[("time.method", method)])?;
    let is_fixed = prepare(&scene)?.integrator.tolerance().is_none();
    let numbers = if is_fixed {
        vec![("max_step_us", 1e6 * setting)]
    } else {
        vec![("max_step_us", LONGEST_STEP), ("tolerance", setting)]
    };
    Ok(prepare(&with_numbers(&scene, &numbers)?)?)
}

fn integrate(
    scene: &Scene,
    method: &str,
    setting: f64,
    starts: &[f64],
) -> Result<Value, Box<dyn Error>> {
    let mut integrator = prepared(scene, method, setting)?.integrator;
    let dim = integrator.state().len();
    let mut ends = starts.to_vec();
    let began = cpu_seconds();
    for end in ends.chunks_exact_mut(dim) {
        integrator.start(0.0, end)?;
        integrator.integrate_to(HORIZON)?;
        end.copy_from_slice(integrator.state());
    }
    let seconds = cpu_seconds() - began;
    let system = integrator.system();
    for end in ends.chunks_exact_mut(system.dim()) {
        for (q, omega) in end.iter_mut().zip(system.omega()) {
            *q *= omega;
        }
    }
    let ends: Vec<_> = ends.chunks_exact(system.dim()).collect();
    let calls = integrator.stats().rhs_evals;
    Ok(json!({"seconds": seconds, "calls": calls, "derivatives": 0, "ends": ends}))
}

fn force(system: &dyn System, calls: f64, start: &[f64]) -> Value {
    let mut out = vec![0.0; system.modes()];
    let began = cpu_seconds();
    for _ in 0..calls as u64 {
        system.force(0.0, black_box(start), black_box(&mut out));
    }
    let seconds = (cpu_seconds() - began) / calls;
    json!({"seconds": seconds, "force": out})
}

fn serve(folder: &Path, start: &str) -> Result<(), Box<dyn Error>> {
    let scene = Scene::parse("scene.toml", fs::read_to_string(folder.join("scene.toml"))?)?;
    let file = File::open(folder.join(start).with_extension("npy"))?;
    let starts: Vec<f64> = NpyFile::new(BufReader::new(file))?.into_vec()?;
    let system = prepare(&scene)?.integrator.into_system();
    for line in stdin().lock().lines() {
        let line = line?;
        let (what, number) = line
            .split_once(' ')
            .ok_or("a request consists of two words")?;
        let number: f64 = number.trim().parse()?;
        let answer = if what == "force" {
            force(system.as_ref(), number, &starts[..system.dim()])
        } else {
            integrate(&scene, what, number, &starts)
                .unwrap_or_else(|failure| json!({"failed": failure.to_string()}))
        };
        println!("{answer}");
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    // Cargo adds its own flags.
    let args: Vec<_> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with("--"))
        .collect();
    let [folder, start] = &args[..] else {
        println!("benches/peers/integrators/compare.py runs this");
        return Ok(());
    };
    serve(Path::new(folder), start)
}
