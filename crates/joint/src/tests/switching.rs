//! Guards and contact status.

use super::*;
use squeakscope_dynamics::Switching;

fn force_in(joint: &Joint, status: &[u8], z: &[f64]) -> Vec<f64> {
    let mut force = vec![0.0; joint.modes()];
    joint.force_in(status, 0.0, z, &mut force);
    force
}

/// A fixed status is the smooth continuation of its law: all nodes closed is the bonded joint, all nodes separated
/// is no contact, and the nodes are independent.
#[test]
fn fixed_status_continues_beyond_its_guards() {
    for friction in frictions() {
        let model = scattered(37, 11, friction);
        let joint = Joint::new(&model);
        let bonded = Joint::new(&Model {
            unilateral: false,
            ..model
        });
        let z = state(&joint, 23);
        let (none, all) = ([0_u8; 5], [0xff_u8; 5]);
        let some = [0x5a, 0x0f, 0xc3, 0x91, 0x04];
        let others = some.map(|bits: u8| !bits);
        let closed = force_in(&joint, &none, &z);
        assert_eq!(closed, force_in(&bonded, &none, &z));
        let mut plain = vec![0.0; 11];
        bonded.force(0.0, &z, &mut plain);
        assert_eq!(closed, plain);
        joint.force(0.0, &z, &mut plain);
        assert_ne!(
            closed, plain,
            "the state must contain nodes beyond their guards"
        );
        let separated = force_in(&joint, &all, &z);
        for (force, steady) in separated.iter().zip(&joint.equilibrium().force) {
            assert_eq!(*force, -steady);
        }
        let (a, b) = (force_in(&joint, &some, &z), force_in(&joint, &others, &z));
        let size = closed.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        for i in 0..11 {
            assert!((a[i] + b[i] - closed[i] - separated[i]).abs() < 1e-13 * size);
        }
    }
}

/// One guard per node: the gap with the sign of its status, positive in the status of the state; none for padding,
/// none for bonded nodes.
#[test]
fn guards_are_the_gaps() {
    let joint = Joint::new(&scattered(37, 11, STRIBECK));
    let z = state(&joint, 5);
    let (mut own, mut gaps) = (vec![0; joint.status_len()], vec![0.0; 37]);
    joint.status_of(0.0, &z, &mut own);
    joint.gaps(&z[..11], &mut gaps);
    assert_eq!((joint.guards(), own.len()), (37, 5));
    let mut values = vec![0.0; 37];
    joint.guard_values(&own, 0.0, &z, &mut values);
    assert!(values.iter().all(|h| *h >= 0.0));
    let closed = vec![0; 5];
    joint.guard_values(&closed, 0.0, &z, &mut values);
    for (value, gap) in values.iter().zip(&gaps) {
        assert!((value - gap).abs() < 1e-13 * 2.5e7);
    }
    assert!(values.iter().any(|h| *h < 0.0));

    let bonded = Joint::new(&Model {
        unilateral: false,
        ..scattered(37, 11, STRIBECK)
    });
    assert_eq!(bonded.guards(), 0);
    own.fill(1);
    bonded.status_of(0.0, &z, &mut own);
    assert_eq!(own, [0; 5]);
    bonded.guard_values(&own, 0.0, &z, &mut []);
}

/// Guards are linear in the displacements with the stated gradient.
#[test]
fn gradients_are_exact() {
    let joint = Joint::new(&scattered(37, 11, STRIBECK)).with_audit();
    let (near, far) = (state(&joint, 5), state(&joint, 6));
    let mut status = vec![0; 5];
    joint.status_of(0.0, &near, &mut status);
    let (mut here, mut there) = (vec![0.0; 37], vec![0.0; 37]);
    joint.guard_values(&status, 0.0, &near, &mut here);
    joint.guard_values(&status, 0.0, &far, &mut there);
    let mut gradient = vec![1.0; joint.dim()];
    for guard in 0..37 {
        let by_time = joint.guard_gradient(&status, guard, 0.0, &near, &mut gradient);
        assert_eq!(by_time, 0.0);
        assert!(gradient[11..].iter().all(|x| *x == 0.0));
        let change: f64 = (0..joint.dim())
            .map(|i| gradient[i] * (far[i] - near[i]))
            .sum();
        assert!((there[guard] - here[guard] - change).abs() < 1e-13 * 2.5e7);
    }
}

/// A transition flips the bit of its node only and makes its guard positive.
#[test]
fn transitions_flip_one_bit() {
    let joint = Joint::new(&scattered(37, 11, STRIBECK));
    let mut z = state(&joint, 5);
    let mut status = vec![0; 5];
    joint.status_of(0.0, &z, &mut status);
    for guard in [0, 7, 8, 36] {
        // Displaced along the gradient of the guard until it is just past zero.
        let (mut values, mut gradient) = (vec![0.0; 37], vec![0.0; 22]);
        joint.guard_values(&status, 0.0, &z, &mut values);
        joint.guard_gradient(&status, guard, 0.0, &z, &mut gradient);
        let square: f64 = gradient.iter().map(|x| x * x).sum();
        let past = values[guard] * (1.0 + 1e-12);
        for (z, slope) in z.iter_mut().zip(&gradient) {
            *z -= past / square * slope;
        }
        joint.guard_values(&status, 0.0, &z, &mut values);
        assert!(values[guard] < 0.0);
        let (before, state) = (status.clone(), z.clone());
        joint.cross(guard, 0.0, &mut z, &mut status);
        assert_eq!(z, state);
        joint.guard_values(&status, 0.0, &z, &mut values);
        assert!(values[guard] > 0.0);
        for (byte, (before, after)) in before.iter().zip(&status).enumerate() {
            let own = if byte == guard / 8 {
                1 << (guard % 8)
            } else {
                0
            };
            assert_eq!(before ^ after, own);
        }
        joint.status_of(0.0, &z, &mut status);
    }
}
