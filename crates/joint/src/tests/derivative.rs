//! The derivative of the force compared with differences.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use squeakscope_dynamics::Switching;

/// Random numbers between -1 and 1.
fn noise(count: usize, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..count).map(|_| rng.random_range(-1.0..1.0)).collect()
}

/// Joints with every law, with and without separation, with and without padding.
fn joints() -> Vec<Joint> {
    let mut joints = Vec::new();
    for (nodes, modes) in [(37, 11), (16, 5), (3, 1), (41, 14)] {
        for unilateral in [true, false] {
            for friction in frictions() {
                joints.push(Joint::new(&Model {
                    unilateral,
                    ..scattered(nodes, modes, friction)
                }));
            }
            let model = Model {
                unilateral,
                ..scattered(nodes, modes, STRIBECK)
            };
            for radial in [true, false] {
                joints.push(Joint::with_friction(&model, Arc::new(LAW), radial));
            }
        }
    }
    joints
}

const LAW: Stribeck = Stribeck {
    mu_s: 0.55,
    mu_d: 0.25,
    creep: 1000.0,
    stribeck: 10.0,
};

fn record(joint: &Joint) -> Vec<f64> {
    vec![0.0; joint.record_len()]
}

fn status(joint: &Joint, z: &[f64]) -> Vec<u8> {
    let mut status = vec![0; joint.status_len()];
    joint.status_of(0.0, z, &mut status);
    status
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|x| x.to_bits()).collect()
}

/// A record and the status of the state leave force and audit bit-identical.
#[test]
fn records_and_status_leave_the_force_unchanged() {
    for joint in joints() {
        let joint = joint.with_audit();
        let z = state(&joint, 5);
        let status = status(&joint, &z);
        let mut plain = vec![0.0; joint.modes() + 1];
        joint.force(0.0, &z, &mut plain);
        let mut other = plain.clone();
        joint.force_in(&status, 0.0, &z, &mut other);
        assert_eq!(bits(&plain), bits(&other));
        for status in [None, Some(status.as_slice())] {
            other.fill(0.0);
            joint.force_recorded(status, 0.0, &z, &mut other, &mut record(&joint));
            assert_eq!(bits(&plain), bits(&other));
        }
    }
}

/// Fourth-order difference quotient of the force along a direction.
fn quotient(joint: &Joint, status: Option<&[u8]>, z: &[f64], along: &[f64], step: f64) -> Vec<f64> {
    let m = joint.modes();
    let at = |k: f64| {
        let moved: Vec<f64> = z.iter().zip(along).map(|(z, d)| z + k * step * d).collect();
        let mut force = vec![0.0; m];
        joint.force_recorded(status, 0.0, &moved, &mut force, &mut record(joint));
        force
    };
    let [one, minus_one, two, minus_two] = [1.0, -1.0, 2.0, -2.0].map(at);
    (0..m)
        .map(|i| (8.0 * (one[i] - minus_one[i]) - (two[i] - minus_two[i])) / (12.0 * step))
        .collect()
}

/// Maximum difference of two vectors relative to their largest component.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let largest = |x: &mut dyn Iterator<Item = f64>| x.fold(0.0, |max: f64, x| max.max(x.abs()));
    let size = largest(&mut a.iter().chain(b).copied());
    largest(&mut a.iter().zip(b).map(|(a, b)| a - b)) / size.max(f64::MIN_POSITIVE)
}

/// The product gives the derivative of the force, by gaps and under a fixed status far
/// beyond its guards, with separated nodes and nodes in reverse slip.
#[test]
fn products_are_the_derivative() {
    let (mut separated, mut closed, mut reversed) = (0, 0, 0);
    for joint in joints() {
        let m = joint.modes();
        let z = state(&joint, 11);
        let elsewhere = status(&joint, &state(&joint, 12));
        for k in 0..joint.contact_nodes() {
            let action = joint.node_action(k, &z[..m], &z[m..], &[]);
            separated += usize::from(action.normal == 0.0);
            closed += usize::from(action.normal > 0.0);
            reversed += usize::from(action.slip[0] < 0.0);
        }
        for (status, step) in [(None, 1e-5), (Some(elsewhere.as_slice()), 1e-4)] {
            let mut along = noise(2 * m, 13);
            along[..m].iter_mut().for_each(|x| *x *= 4e-7);
            along[m..].iter_mut().for_each(|x| *x *= 5e-3);
            let want = quotient(&joint, status, &z, &along, step);
            let (mut record, mut force) = (record(&joint), vec![0.0; m]);
            joint.force_recorded(status, 0.0, &z, &mut force, &mut record);
            let mut got = vec![0.0; m];
            joint.product(status, &mut record, &along, 1, &mut got);
            assert!(distance(&got, &want) < 1e-8, "{:e}", distance(&got, &want));
        }
    }
    assert!(
        separated > 50 && closed > 50 && reversed > 50,
        "{separated} separated, {closed} closed, {reversed} in reverse slip"
    );
}

/// Products in the creep region, where the direction of slip changes within the difference quotient, and at zero
/// slip.
#[test]
fn products_are_exact_near_rest() {
    let mut model = scattered(24, 11, STRIBECK);
    model.sliding_velocity = vec![[0.0; 3]; 24];
    let joint = Joint::new(&model);
    let (mut record, mut force) = (record(&joint), vec![0.0; 11]);
    let along = [vec![0.0; 11], noise(11, 3)].concat();
    for speed in [1e-7, 1e-6, 1e-5, 1e-4] {
        let z = [vec![0.0; 11], noise(11, 4)].concat();
        let z: Vec<f64> = z.iter().map(|z| speed * z).collect();
        joint.force_recorded(None, 0.0, &z, &mut force, &mut record);
        let mut got = vec![0.0; 11];
        joint.product(None, &mut record, &along, 1, &mut got);
        let want = quotient(&joint, None, &z, &along, 3e-3 * speed);
        assert!(distance(&got, &want) < 1e-7, "{:e}", distance(&got, &want));
    }
    // At rest mu(V)/V is creep mu_s, and friction is viscous.
    joint.force_recorded(None, 0.0, &[0.0; 22], &mut force, &mut record);
    let mut got = vec![0.0; 11];
    joint.product(None, &mut record, &along, 1, &mut got);
    let mut want = vec![0.0; 11];
    for k in 0..24 {
        let shapes = model.shapes_at(k);
        let load = model.areas[k] * model.pre_stress[k];
        for i in 0..11 {
            for j in 0..11 {
                want[i] -= load * 550.0 * dot(shapes[i], shapes[j]) * along[11 + j];
            }
        }
    }
    assert!(distance(&got, &want) < 1e-13);
}

/// The products are those with the Jacobian for any number of vectors; a record can be used repeatedly.
#[test]
fn products_of_any_width_are_those_of_the_jacobian() {
    for joint in joints() {
        let m = joint.modes();
        let z = state(&joint, 17);
        let (mut record, mut jacobian) = (record(&joint), jacobian(&joint, &z));
        joint.force_recorded(None, 0.0, &z, &mut vec![0.0; m], &mut record);
        // The force excludes modal stiffness and damping.
        for i in 0..m {
            let row = &mut jacobian[2 * m * (m + i)..];
            row[i] += joint.omega()[i].powi(2);
            row[m + i] += 2.0 * joint.damping()[i] * joint.omega()[i];
        }
        for width in [1, 2, 3, 8, 2 * m] {
            let mut vectors = noise(2 * m * width, width as u64);
            vectors[..m * width].iter_mut().for_each(|q| *q /= 4e4);
            let mut got = vec![0.0; m * width];
            joint.product(None, &mut record, &vectors, width, &mut got);
            let want: Vec<f64> = (0..m * width)
                .map(|k| {
                    let row = &jacobian[2 * m * (m + k / width)..][..2 * m];
                    let column = vectors[k % width..].iter().step_by(width);
                    row.iter().zip(column).map(|(a, b)| a * b).sum()
                })
                .collect();
            assert!(distance(&got, &want) < 1e-11);
        }
    }
}
