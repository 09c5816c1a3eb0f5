//! Benchmarks of the hot loops of the joint, each over one parameter.
//!
//! * `force/nodes`, `force/modes`: Eq. (8) over the number of contact nodes and of modes, with Eq. (5), lift-off and
//!   the radial part; the growth of time is printed as a ratio to the smallest size.
//! * `force/effect`: the same at 100 nodes with one effect disabled, with a user-defined friction law,
//!   and the straightforward scalar loop as the baseline.
//! * `jacobian`, `separated_nodes`, `retilt`: called once per stiff step, per sample and per frame.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use squeakscope::dynamics::System;
use squeakscope::dynamics::equilibrium::Linearised;
use squeakscope::joint::{
    BallJoint, BodySpec, Frequencies, Friction, FrictionLaw, Joint, Model, Ratio, Stribeck,
};
use squeakscope::scene::Scene;

/// Numbers of contact nodes.
const NODES: [usize; 5] = [16, 64, 100, 1000, 10_000];
/// Numbers of bending pairs, torsion modes and axial modes of the finite-element body.
const FAMILIES: [[usize; 3]; 5] = [[1, 0, 0], [4, 2, 1], [8, 4, 2], [16, 8, 8], [34, 16, 16]];
/// Number of nodes in the benchmarks over other parameters.
const DEFAULT_NODES: usize = 100;

fn ball(nodes: usize) -> BallJoint {
    let mut scene = Scene::load("doubled-torus-3deg").expect("a preset");
    let spec = &mut scene.joint_mut().expect("the preset has a joint").spec;
    spec.contact.nodes = nodes;
    BallJoint::new(spec).expect("the preset's joint")
}

fn model(nodes: usize) -> Model {
    ball(nodes)
        .model(TILT)
        .expect("a patch that does not touch the beam")
}

/// The joint with the frequencies of its finite elements, and these numbers of modes.
fn with_modes([bending_pairs, torsion, axial]: [usize; 3]) -> Model {
    let mut scene = Scene::load("doubled-torus-3deg").expect("a preset");
    let BodySpec::BallOnBeam(body) = &mut scene.joint_mut().expect("a joint").spec.body else {
        unreachable!("the preset has a ball on a beam")
    };
    body.frequencies = Frequencies::FiniteElement;
    body.families.bending_pairs = bending_pairs;
    body.families.torsion = torsion;
    body.families.axial = axial;
    let spec = &scene.joint().expect("the preset has a joint").spec;
    let ball = BallJoint::new(spec).expect("the preset's joint");
    ball.model(TILT)
        .expect("a patch that does not touch the beam")
}

/// Tilt of the load, rad.
const TILT: f64 = 0.05;

/// Modal velocities of the timed state, sqrt(kg) m/s.
const SPEED: f64 = 30e-3;

/// A state of vibration with the speed of the developed one in each mode.
fn vibration(joint: &Joint) -> Vec<f64> {
    let m = joint.modes();
    let mut z = vec![0.0; joint.dim()];
    for i in 0..m {
        let phase = 1.0 + 2.3 * i as f64;
        z[i] = SPEED * phase.cos() / joint.omega()[i];
        z[m + i] = -SPEED * phase.sin();
    }
    z
}

/// A state of the developed vibration: some nodes separated, the others in contact and sliding.
fn state(joint: &Joint) -> Vec<f64> {
    let (z, m) = (vibration(joint), joint.modes());
    let mut open = vec![0; joint.contact_nodes().div_ceil(8)];
    joint.separated_nodes(&z[..m], &mut open);
    let open = open
        .iter()
        .map(|byte| byte.count_ones() as usize)
        .sum::<usize>();
    assert!(
        0 < open && open < joint.contact_nodes(),
        "{open} separated nodes: not a state of the developed vibration"
    );
    z
}

/// Eq. (5) implemented as a user-defined law.
#[derive(Debug)]
struct UserLaw(Stribeck);

impl FrictionLaw for UserLaw {
    fn ratio(&self, speed: f64) -> Ratio {
        self.0.ratio(speed)
    }

    fn stick_speed(&self) -> f64 {
        self.0.stick_speed()
    }
}

/// Baseline: Eq. (8) as written, node by node and mode by mode, without the equilibrium.
struct Plain<'a> {
    model: &'a Model,
    law: Stribeck,
}

impl Plain<'_> {
    fn force(&self, q: &[f64], v: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        let model = self.model;
        for k in 0..model.nodes() {
            let (shapes, normal) = (model.shapes_at(k), model.normals[k]);
            let mut u_r = 0.0;
            let mut slip = model.sliding_velocity[k];
            for (i, shape) in shapes.iter().enumerate() {
                for axis in 0..3 {
                    u_r += shape[axis] * normal[axis] * q[i];
                    slip[axis] += shape[axis] * v[i];
                }
            }
            let stress = (model.pre_stress[k] + model.stiffness[k] * u_r).max(0.0);
            let load = stress * model.areas[k];
            let speed = slip.iter().map(|x| x * x).sum::<f64>().sqrt();
            let drag = load * self.law.coefficient(speed) / speed;
            for (out, shape) in out.iter_mut().zip(shapes) {
                for axis in 0..3 {
                    *out -= shape[axis] * (drag * slip[axis] + load * normal[axis]);
                }
            }
        }
    }
}

/// Times the force of models of increasing size, and prints each time relative to that of the first.
fn growth(c: &mut Criterion, name: &str, models: &mut dyn Iterator<Item = (usize, Model)>) {
    let mut group = c.benchmark_group(name);
    let mut first = None;
    for (size, model) in models {
        let joint = Joint::new(&model);
        let z = vibration(&joint);
        let mut out = vec![0.0; joint.modes()];
        let mut fastest = f64::INFINITY;
        group.throughput(Throughput::Elements(size as u64));
        group.bench_function(BenchmarkId::from_parameter(size), |b| {
            b.iter_custom(|count| {
                let start = Instant::now();
                for _ in 0..count {
                    joint.force(0.0, black_box(&z), black_box(&mut out));
                }
                let time = start.elapsed();
                fastest = fastest.min(time.as_secs_f64() / count as f64);
                time
            });
        });
        let (least, shortest) = *first.get_or_insert((size, fastest));
        println!(
            "{name}: {size} take {:.2} times the time of {least}",
            fastest / shortest
        );
    }
    group.finish();
}

fn force(c: &mut Criterion) {
    let mut by_nodes = NODES.into_iter().map(|nodes| (nodes, model(nodes)));
    growth(c, "force/nodes", &mut by_nodes);
    let mut by_modes = FAMILIES.into_iter().map(|families| {
        let model = with_modes(families);
        (model.modes(), model)
    });
    growth(c, "force/modes", &mut by_modes);

    let model = model(DEFAULT_NODES);
    let Friction::Stribeck { law, .. } = model.friction else {
        panic!("the preset has friction");
    };
    let without = |friction| {
        Joint::new(&Model {
            friction,
            ..model.clone()
        })
    };
    let full = Joint::new(&model);
    let z = state(&full);
    let m = full.modes();
    let mut out = vec![0.0; m];

    let mut group = c.benchmark_group("force/effect");
    for (name, joint) in [
        ("eq5", full.clone()),
        (
            "no-radial",
            without(Friction::Stribeck { law, radial: false }),
        ),
        ("no-friction", without(Friction::None)),
        (
            "no-lift-off",
            Joint::new(&Model {
                unilateral: false,
                ..model.clone()
            }),
        ),
        (
            "own-law",
            Joint::with_friction(&model, Arc::new(UserLaw(law)), true),
        ),
    ] {
        group.bench_function(name, |b| {
            b.iter(|| joint.force(0.0, black_box(&z), black_box(&mut out)));
        });
    }
    let plain = Plain { model: &model, law };
    assert_same_force(&plain, &full, &z);
    let (q, v) = z.split_at(m);
    group.bench_function("plain-loop", |b| {
        b.iter(|| plain.force(black_box(q), black_box(v), black_box(&mut out)));
    });
    group.finish();
}

/// Checks that the baseline computes the same force.
fn assert_same_force(plain: &Plain<'_>, joint: &Joint, z: &[f64]) {
    let m = joint.modes();
    let (mut a, mut b) = (vec![0.0; m], vec![0.0; m]);
    plain.force(&z[..m], &z[m..], &mut a);
    joint.force(0.0, z, &mut b);
    for ((a, b), steady) in a.iter().zip(&b).zip(&joint.equilibrium().force) {
        assert!(
            (a - steady - b).abs() < 1e-11 * steady.abs().max(1.0),
            "{a} - {steady} != {b}"
        );
    }
}

fn others(c: &mut Criterion) {
    let ball = ball(DEFAULT_NODES);
    let joint = Joint::new(&model(DEFAULT_NODES));
    let z = state(&joint);
    let m = joint.modes();
    c.bench_function("jacobian/100", |b| {
        b.iter(|| Linearised::at(&joint, None, 0.0, black_box(&z)));
    });
    let mut open = vec![0; DEFAULT_NODES.div_ceil(8)];
    c.bench_function("separated_nodes/100", |b| {
        b.iter(|| joint.separated_nodes(black_box(&z[..m]), black_box(&mut open)));
    });
    c.bench_function("retilt/100", |b| {
        b.iter(|| {
            ball.joint(black_box(TILT))
                .expect("a patch that does not touch the beam")
        });
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(40)
        .warm_up_time(std::time::Duration::from_millis(300))
        .measurement_time(std::time::Duration::from_secs(1));
    targets = force, others
}
criterion_main!(benches);
