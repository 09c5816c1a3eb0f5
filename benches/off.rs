//! Effects that are off cost nothing: runs of the joint with effects off, against runs of the plain law.
//!
//! The plain law is a loop over nodes and modes that contains the remaining effects only, without any test
//! for the others. Both sides use the same integrator from the same state of `doubled-torus-3deg` and agree in the
//! force. Runs alternate, which exposes both to the same other load; the ratio is that of the shortest
//! times. It is far below 1 because the joint evaluates several nodes at a time. The last column divides
//! it by the ratio with all effects: near 1 or below, switching effects off saves as much in the joint as it
//! does in the plain law.

use std::hint::black_box;
use std::time::Instant;

use squeakscope::dynamics::{Accuracy, Integrator, MethodName, System};
use squeakscope::joint::{BallJoint, Friction, Joint, Model, Stribeck};
use squeakscope::scene::Scene;

/// Tilt of the load, rad.
const TILT: f64 = 0.05;
/// Modal velocities of the initial state, sqrt(kg) m/s: some nodes separate.
const SPEED: f64 = 30e-3;
/// Integrated time, s, in steps of [`STEP`].
const SPAN: f64 = 0.2e-3;
/// The fixed step makes the number of evaluations equal on both sides.
const STEP: f64 = 1e-6;
const ROUNDS: usize = 61;
const NODES: usize = 100;

/// A friction law `mu(V)/V`, s/m.
trait Law: Copy + Send + Sync {
    const HAS_FRICTION: bool = true;
    fn ratio(self, speed: f64) -> f64;
}

#[derive(Clone, Copy)]
struct Frictionless;

impl Law for Frictionless {
    const HAS_FRICTION: bool = false;
    fn ratio(self, _: f64) -> f64 {
        0.0
    }
}

/// A constant coefficient, regularised.
#[derive(Clone, Copy)]
struct Constant {
    mu: f64,
    creep: f64,
}

impl Law for Constant {
    fn ratio(self, speed: f64) -> f64 {
        -self.mu * (-self.creep * speed).exp_m1() / speed
    }
}

impl Law for Stribeck {
    fn ratio(self, speed: f64) -> f64 {
        self.coefficient(speed) / speed
    }
}

/// Eq. (8) of one law: node by node and mode by mode.
struct Plain<'a, L, const UNILATERAL: bool, const RADIAL: bool> {
    model: &'a Model,
    law: L,
    /// Modal force of steady sliding.
    steady: &'a [f64],
}

impl<L: Law, const UNILATERAL: bool, const RADIAL: bool> System
    for Plain<'_, L, UNILATERAL, RADIAL>
{
    fn omega(&self) -> &[f64] {
        &self.model.omega
    }

    fn damping(&self) -> &[f64] {
        &self.model.damping
    }

    fn is_autonomous(&self) -> bool {
        true
    }

    fn force(&self, _t: f64, z: &[f64], out: &mut [f64]) {
        let model = self.model;
        let (q, v) = z.split_at(model.modes());
        out.iter_mut()
            .zip(self.steady)
            .for_each(|(out, steady)| *out = -steady);
        for k in 0..model.nodes() {
            let (shapes, normal) = (model.shapes_at(k), model.normals[k]);
            let mut u_r = 0.0;
            let mut slip = model.sliding_velocity[k];
            for (i, shape) in shapes.iter().enumerate() {
                for axis in 0..3 {
                    u_r += shape[axis] * normal[axis] * q[i];
                    if L::HAS_FRICTION {
                        slip[axis] += shape[axis] * v[i];
                    }
                }
            }
            let mut stress = model.pre_stress[k] + model.stiffness[k] * u_r;
            if UNILATERAL {
                stress = stress.max(0.0);
            }
            let load = stress * model.areas[k];
            let mut traction = normal.map(|n| load * n);
            if L::HAS_FRICTION {
                if !RADIAL {
                    let outward: f64 = (0..3).map(|axis| slip[axis] * normal[axis]).sum();
                    (0..3).for_each(|axis| slip[axis] -= outward * normal[axis]);
                }
                let speed = slip.iter().map(|x| x * x).sum::<f64>().sqrt();
                let drag = load * self.law.ratio(speed);
                (0..3).for_each(|axis| traction[axis] += drag * slip[axis]);
            }
            for (out, shape) in out.iter_mut().zip(shapes) {
                for axis in 0..3 {
                    *out -= shape[axis] * traction[axis];
                }
            }
        }
    }
}

/// Time of one run, s.
fn time(system: &impl System, start: &[f64]) -> f64 {
    let method = MethodName::Rk4.with(Accuracy::relative(1e-6), STEP);
    let mut integrator = Integrator::new(method, system).expect("a step");
    integrator.start(0.0, start).expect("a finite state");
    let begin = Instant::now();
    integrator.integrate_to(SPAN).expect("a sound run");
    black_box(integrator.state());
    begin.elapsed().as_secs_f64()
}

/// Shortest times of the joint and of the plain law, s.
fn compare<L: Law, const UNILATERAL: bool, const RADIAL: bool>(
    model: &Model,
    friction: Friction,
    law: L,
    z: &[f64],
) -> [f64; 2] {
    let model = Model {
        friction,
        unilateral: UNILATERAL,
        ..model.clone()
    };
    let joint = Joint::new(&model);
    let plain = Plain::<L, UNILATERAL, RADIAL> {
        model: &model,
        law,
        steady: &joint.equilibrium().force,
    };
    let [mut a, mut b] = [vec![0.0; model.modes()], vec![0.0; model.modes()]];
    joint.force(0.0, z, &mut a);
    plain.force(0.0, z, &mut b);
    let scale = b.iter().fold(0.0, |max: f64, x| max.max(x.abs()));
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).abs() < 1e-11 * scale, "{a} != {b}");
    }
    let mut shortest = [f64::INFINITY; 2];
    for _ in 0..ROUNDS {
        shortest[0] = shortest[0].min(time(&joint, z));
        shortest[1] = shortest[1].min(time(&plain, z));
    }
    shortest
}

fn main() {
    let scene = Scene::load("doubled-torus-3deg").expect("a preset");
    let mut spec = scene.joint().expect("the preset has a joint").spec.clone();
    spec.contact.nodes = NODES;
    let ball = BallJoint::new(&spec).expect("the preset's joint");
    let model = ball.model(TILT).expect("a clear patch");
    let Friction::Stribeck { law, .. } = model.friction else {
        panic!("the preset has friction");
    };
    let stribeck = |radial| Friction::Stribeck { law, radial };
    let level = Constant {
        mu: law.mu_d,
        creep: law.creep,
    };
    let constant = |radial| Friction::Stribeck {
        law: Stribeck::constant(law.mu_d, law.creep),
        radial,
    };
    let m = model.modes();
    let mut z = vec![0.0; 2 * m];
    for i in 0..m {
        let phase = 1.0 + 2.3 * i as f64;
        z[i] = SPEED * phase.cos() / model.omega[i];
        z[m + i] = -SPEED * phase.sin();
    }
    let rows = [
        (
            "nothing",
            compare::<_, true, true>(&model, stribeck(true), law, &z),
        ),
        (
            "radial part",
            compare::<_, true, false>(&model, stribeck(false), law, &z),
        ),
        (
            "falling friction",
            compare::<_, true, true>(&model, constant(true), level, &z),
        ),
        (
            "separation",
            compare::<_, false, true>(&model, stribeck(true), law, &z),
        ),
        (
            "friction",
            compare::<_, true, true>(&model, Friction::None, Frictionless, &z),
        ),
        (
            "friction, separation",
            compare::<_, false, true>(&model, Friction::None, Frictionless, &z),
        ),
    ];
    let whole = rows[0].1[0] / rows[0].1[1];
    println!("{NODES} nodes, {m} modes");
    println!(
        "| off | joint, us per ms | plain law, us per ms | ratio | over that of all effects |"
    );
    println!("|---|---|---|---|---|");
    for (name, [joint, plain]) in rows {
        let [per_ms, plain_per_ms] = [joint, plain].map(|time| time / SPAN * 1e3);
        let ratio = joint / plain;
        println!(
            "| {name} | {per_ms:.0} | {plain_per_ms:.0} | {ratio:.3} | {:.2} |",
            ratio / whole
        );
    }
}
