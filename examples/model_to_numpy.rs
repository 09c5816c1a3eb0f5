//! Exports the contact model as NumPy arrays and evaluates Eq. (8) from these arrays.
//!
//! The file contains everything another program needs to integrate the same joint. To show this, Eq. (8)
//! is implemented here with plain loops over the exported arrays and compared with the right-hand side
//! of the library at random states. In Python:
//!
//! ```text
//! cargo run --release --example model_to_numpy -- [FOLDER]
//! python3 -c "import numpy; m = numpy.load('model.npz'); print({k: m[k].shape for k in m})"
//! ```

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use squeakscope::dynamics::System;
use squeakscope::export::{encode_model, replace_file};
use squeakscope::joint::{BallJoint, Joint};
use squeakscope::numpy::{Array, read_npz};
use squeakscope::pipeline::initial_state;
use squeakscope::scene::Scene;

/// Number of random states.
const STATES: usize = 200;
/// Standard deviation of the modal velocities, sqrt(kg) m/s, and of `omega q`.
const SPEED: f64 = 10e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).unwrap_or_else(|| ".".into()));
    let path = folder.join("model.npz");

    let scene = Scene::load("torus-1.75deg")?;
    let tilted = scene.joint()?;
    let model = BallJoint::new(&tilted.spec)?.model(tilted.tilt.at(0.0))?;
    let joint = Joint::new(&model);
    let m = joint.modes();
    let start = initial_state(&scene, m);
    replace_file(&path, |file| encode_model(file, &model, &start))?;
    let arrays = read_npz(&path)?;
    for (name, array) in &arrays {
        println!("{name:>17} {:?}", array.shape);
    }

    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(8);
    let (mut worst, mut some_separated) = (0.0_f64, 0);
    for _ in 0..STATES {
        let mut z: Vec<f64> = (0..2 * m)
            .map(|_| StandardNormal.sample(&mut rng))
            .collect();
        for (i, omega) in joint.omega().iter().enumerate() {
            z[i] *= SPEED / omega;
            z[m + i] *= SPEED;
        }
        let mut exact = vec![0.0; 2 * m];
        joint.rhs(0.0, &z, &mut exact);
        let found = acceleration(&arrays, &z[..m], &z[m..]);
        let largest = exact[m..].iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        for (exact, found) in exact[m..].iter().zip(&found) {
            worst = worst.max((exact - found).abs() / largest);
        }
        let mut gaps = vec![0.0; joint.contact_nodes()];
        joint.gaps(&z[..m], &mut gaps);
        some_separated += usize::from(gaps.iter().any(|gap| *gap < 0.0));
    }
    println!("{STATES} random states, with separated nodes in {some_separated} of them:");
    println!("Eq. (8) from the file compared with the library: relative error {worst:.1e}");
    if worst > 1e-12 {
        return Err(
            "the exported arrays do not reproduce the right-hand side of the library".into(),
        );
    }
    println!("{}", path.display());
    Ok(())
}

/// Eq. (8): the modal accelerations at displacement `q` and velocity `v`, from the arrays of a model
/// file.
fn acceleration(file: &BTreeMap<String, Array>, q: &[f64], v: &[f64]) -> Vec<f64> {
    let get = |name: &str| &file[name].values;
    let [mu_s, mu_d, creep, stribeck] = get("friction")[..] else {
        unreachable!("four numbers")
    };
    let m = q.len();
    let mut a: Vec<f64> = (0..m)
        .map(|i| -get("omega")[i].powi(2) * (get("q_eq")[i] + q[i]))
        .collect();
    for (k, area) in get("areas").iter().enumerate() {
        let row = |axis: usize| &get("shapes")[(3 * k + axis) * m..][..m];
        let dot = |axis: usize, x: &[f64]| row(axis).iter().zip(x).map(|(a, b)| a * b).sum::<f64>();
        let normal: [f64; 3] = std::array::from_fn(|axis| get("normals")[3 * k + axis]);
        let u_r: f64 = (0..3).map(|axis| normal[axis] * dot(axis, q)).sum();
        let stress = (get("pre_stress")[k] + get("stiffness")[k] * u_r).max(0.0);
        let slip: [f64; 3] =
            std::array::from_fn(|axis| get("sliding_velocity")[3 * k + axis] + dot(axis, v));
        let speed = slip.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mu = -(-creep * speed).exp_m1() * (mu_d + (mu_s - mu_d) * (-stribeck * speed).exp());
        for axis in 0..3 {
            let force = -stress * area * (mu * slip[axis] / speed + normal[axis]);
            a.iter_mut()
                .zip(row(axis))
                .for_each(|(a, shape)| *a += shape * force);
        }
    }
    a
}
