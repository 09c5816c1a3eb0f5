//! Tangent vectors of the joint with hundreds of contact changes, compared with finite differences of
//! the flow and with Liouville's theorem.

use std::sync::Mutex;

use squeakscope::dynamics::{
    Accuracy, Differentiable, Integrator, Method, MethodName, Switching, System,
};
use squeakscope::joint::{BallJoint, Joint};
use squeakscope::pipeline::initial_state;
use squeakscope::scene::Scene;

/// The joint of `doubled-torus-3deg` with `nodes` contact nodes and a kick (m/s) strong enough
/// for chattering contact.
fn kicked(nodes: usize, kick: f64) -> (Joint, Vec<f64>) {
    let mut scene = Scene::load("doubled-torus-3deg").unwrap();
    scene.joint_mut().unwrap().spec.contact.nodes = nodes;
    scene.start.kick = kick;
    let tilted = scene.joint().unwrap();
    let ball = BallJoint::new(&tilted.spec).unwrap();
    let joint = ball.joint(tilted.tilt.at(0.0)).unwrap();
    let z = initial_state(&scene, joint.modes());
    (joint, z)
}

/// Treatment of contact changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ContactChanges {
    Through,
    Located,
}

/// The default method at a tolerance.
fn lawson(tolerance: f64) -> Method {
    MethodName::Lawson54.with(Accuracy::relative(tolerance), 20e-6)
}

fn integrator<Y: System>(sys: &Y, changes: ContactChanges, method: Method) -> Integrator<'_> {
    let integrator = Integrator::new(method, sys).unwrap();
    match changes {
        ContactChanges::Through => integrator,
        ContactChanges::Located => integrator.with_events().unwrap(),
    }
}

/// The state after `span` (s).
fn flow(joint: &Joint, changes: ContactChanges, method: Method, z: &[f64], span: f64) -> Vec<f64> {
    let mut integrator = integrator(joint, changes, method);
    integrator.start(0.0, z).unwrap();
    integrator.integrate_to(span).unwrap();
    integrator.state().to_vec()
}

/// Norm of the vibration energy.
fn length(joint: &Joint, z: impl IntoIterator<Item = f64>) -> f64 {
    let m = joint.modes();
    let squares = z.into_iter().enumerate().map(|(c, z)| {
        let scale = if c < m { joint.omega()[c] } else { 1.0 };
        (scale * z).powi(2)
    });
    squares.sum::<f64>().sqrt()
}

/// Directions of unit length, stored component by component.
fn directions(joint: &Joint, width: usize) -> Vec<f64> {
    let m = joint.modes();
    let mut vectors: Vec<f64> = (0..2 * m * width)
        .map(|k| (1.0 + 1.7 * k as f64).sin())
        .collect();
    for (c, row) in vectors[..m * width].chunks_exact_mut(width).enumerate() {
        row.iter_mut().for_each(|x| *x /= joint.omega()[c]);
    }
    for l in 0..width {
        let column = |vectors: &[f64]| vectors[l..].iter().step_by(width).copied().collect();
        let column: Vec<f64> = column(&vectors);
        let size = length(joint, column);
        vectors[l..]
            .iter_mut()
            .step_by(width)
            .for_each(|x| *x /= size);
    }
    vectors
}

/// Largest difference between the tangent vectors and difference quotients of the flow, relative to
/// their length, over several directions; and the number of crossings.
fn tangent_error(
    joint: &Joint,
    changes: ContactChanges,
    method: Method,
    z: &[f64],
    span: f64,
    step: f64,
) -> (f64, u64) {
    const WIDTH: usize = 3;
    let vectors = directions(joint, WIDTH);
    let mut followed = integrator(joint, changes, method)
        .with_tangents(WIDTH, 1)
        .unwrap();
    followed.start(0.0, z).unwrap();
    followed.set_tangent_vectors(&vectors).unwrap();
    followed.integrate_to(span).unwrap();
    let got = followed.tangent_vectors().unwrap();
    let mut worst = 0.0_f64;
    for l in 0..WIDTH {
        let at = |k: f64| {
            let column = vectors[l..].iter().step_by(WIDTH);
            let moved: Vec<f64> = z
                .iter()
                .zip(column)
                .map(|(z, d)| z + k * step * d)
                .collect();
            flow(joint, changes, method, &moved, span)
        };
        // Fourth-order differences.
        let [one, minus_one, two, minus_two] = [1.0, -1.0, 2.0, -2.0].map(at);
        let quotient =
            |c: usize| (8.0 * (one[c] - minus_one[c]) - (two[c] - minus_two[c])) / (12.0 * step);
        let size = length(joint, (0..z.len()).map(quotient));
        let error = (0..z.len()).map(|c| got[c * WIDTH + l] - quotient(c));
        worst = worst.max(length(joint, error) / size);
    }
    (worst, followed.stats().crossings)
}

/// With event location the tangent vectors are the derivative of the flow, over at least `least` crossings.
fn assert_derivative_of_the_flow((joint, z): &(Joint, Vec<f64>), least: u64) {
    let (located, method) = (ContactChanges::Located, lawson(1e-12));
    let (error, crossings) = tangent_error(joint, located, method, z, 1e-3, 1e-6);
    println!(
        "{} nodes: {error:.1e} over {crossings} crossings",
        joint.contact_nodes()
    );
    assert!(crossings >= least, "{crossings} crossings");
    assert!(error < 1e-6, "{error:e}");
}

#[test]
fn tangents_with_event_location_are_the_derivative_of_the_flow() {
    assert_derivative_of_the_flow(&kicked(100, 30e-3), 1000);
}

/// Without event location the tangent vectors are the derivative of the numerical map. The step is
/// fixed, so the difference quotients contain no step-size variation. The differences are small, so
/// hardly any stage changes its contact status between them.
#[test]
fn tangents_through_kinks_are_the_derivative_of_the_numerical_flow() {
    let (joint, z) = kicked(100, 30e-3);
    let method = MethodName::Rk4.with(Accuracy::relative(1e-6), 0.4e-6);
    let (error, _) = tangent_error(&joint, ContactChanges::Through, method, &z, 1e-3, 1e-9);
    println!("{error:.1e}");
    assert!(error < 1e-6, "{error:e}");
}

/// Without event location the tangent vectors converge to the derivative of the flow as the tolerance
/// decreases, but slowly: in a step with a kink their error is proportional to its length.
#[test]
fn tangents_through_kinks_converge_to_the_derivative_of_the_flow() {
    let (joint, z) = kicked(100, 15e-3);
    let vectors = directions(&joint, 3);
    let after = |changes, tolerance| {
        let mut run = integrator(&joint, changes, lawson(tolerance))
            .with_tangents(3, 1)
            .unwrap();
        run.start(0.0, &z).unwrap();
        run.set_tangent_vectors(&vectors).unwrap();
        run.integrate_to(1e-3).unwrap();
        run.tangent_vectors().unwrap().to_vec()
    };
    let exact = after(ContactChanges::Located, 1e-13);
    let column = |vectors: &[f64], l: usize| -> Vec<f64> {
        vectors[l..].iter().step_by(3).copied().collect()
    };
    let error = |tolerance| {
        let through = after(ContactChanges::Through, tolerance);
        let errors = (0..3).map(|l| {
            let (through, exact) = (column(&through, l), column(&exact, l));
            length(&joint, difference(&through, &exact)) / length(&joint, exact)
        });
        errors.fold(0.0, f64::max)
    };
    let errors = [1e-7, 1e-9, 1e-11, 1e-13].map(error);
    println!("{errors:?}");
    assert!(
        errors[2] < 0.1 * errors[0] && errors[3] < 1e-5,
        "{errors:?}"
    );
}

/// At each event of a strongly kicked run, the general correction of Eq. (15) and (16) is evaluated from
/// the laws before and after. It is the identity up to the rounding of the event time.
#[test]
fn the_saltation_correction_vanishes_at_contact_changes() {
    let (joint, z) = kicked(100, 30e-3);
    let mut run = integrator(&joint, ContactChanges::Located, lawson(1e-10));
    run.start(0.0, &z).unwrap();
    let m = joint.modes();
    let (mut before, mut after) = (vec![0.0; m], vec![0.0; m]);
    let (mut slope, mut gradient) = (vec![0.0; 2 * m], vec![0.0; 2 * m]);
    let (mut worst, mut grazing, mut events) = (0.0_f64, f64::INFINITY, 0);
    loop {
        let crossed = run.next_event(4e-3).unwrap().to_vec();
        if crossed.is_empty() {
            break;
        }
        let (t, z) = (run.time(), run.state().to_vec());
        let mut status = run.status().to_vec();
        joint.force_in(&status, t, &z, &mut after);
        for &guard in &crossed {
            status[guard / 8] ^= 1 << (guard % 8);
        }
        joint.force_in(&status, t, &z, &mut before);
        joint.rhs(t, &z, &mut slope);
        let jump = length(&joint, [vec![0.0; m], difference(&before, &after)].concat());
        for &guard in &crossed {
            joint.guard_gradient(&status, guard, t, &z, &mut gradient);
            let rate: f64 = gradient.iter().zip(&slope).map(|(h, f)| h * f).sum();
            // The largest |dh/dz . delta z| of a vector of unit length.
            let scaled = gradient
                .iter()
                .zip(joint.omega())
                .map(|(h, omega)| h / omega);
            let sensitivity = scaled.map(|x| x * x).sum::<f64>().sqrt();
            worst = worst.max(jump * sensitivity / rate.abs());
            grazing = grazing.min(rate.abs() / sensitivity);
        }
        events += 1;
    }
    println!("{events} events, correction at most {worst:.2e}, slowest guard {grazing:.2e}");
    assert!(events >= 300, "{events} events");
    assert!(worst < 1e-9, "{worst:e}");
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// A joint with an additional component: the integral of the trace of `dF/dz`.
struct Traced {
    joint: Joint,
    scratch: Mutex<Scratch>,
}

/// Workspace of the trace.
struct Scratch {
    record: Vec<f64>,
    identity: Vec<f64>,
    derivative: Vec<f64>,
}

impl Traced {
    fn new(joint: Joint) -> Self {
        let m = joint.modes();
        let scratch = Mutex::new(Scratch {
            record: vec![0.0; joint.record_len()],
            identity: (0..4 * m * m)
                .map(|k| f64::from(u8::from(k % (2 * m + 1) == 0)))
                .collect(),
            derivative: vec![0.0; 2 * m * m],
        });
        Self { joint, scratch }
    }

    /// The force, followed by the trace (the presets have no damping).
    fn both(&self, status: Option<&[u8]>, t: f64, z: &[f64], out: &mut [f64]) {
        let m = self.joint.modes();
        let mut scratch = self.scratch.lock().unwrap();
        let Scratch {
            record,
            identity,
            derivative,
        } = &mut *scratch;
        let (force, trace) = out.split_at_mut(m);
        self.joint
            .force_recorded(status, t, &z[..2 * m], force, record);
        self.joint
            .product(status, record, identity, 2 * m, derivative);
        trace[0] = (0..m).map(|i| derivative[i * 2 * m + m + i]).sum();
    }
}

impl System for Traced {
    fn omega(&self) -> &[f64] {
        self.joint.omega()
    }

    fn first_order(&self) -> usize {
        1
    }

    fn quadratures(&self) -> usize {
        1
    }

    fn force(&self, t: f64, z: &[f64], out: &mut [f64]) {
        self.both(None, t, z, out);
    }

    fn switching(&self) -> Option<&dyn Switching> {
        Some(self)
    }

    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }

    fn is_autonomous(&self) -> bool {
        self.joint.is_autonomous()
    }
}

impl Switching for Traced {
    fn status_len(&self) -> usize {
        self.joint.status_len()
    }

    fn status_of(&self, t: f64, z: &[f64], status: &mut [u8]) {
        self.joint.status_of(t, z, status);
    }

    fn force_in(&self, status: &[u8], t: f64, z: &[f64], out: &mut [f64]) {
        self.both(Some(status), t, z, out);
    }

    fn guards(&self) -> usize {
        self.joint.guards()
    }

    fn guard_values(&self, status: &[u8], t: f64, z: &[f64], values: &mut [f64]) {
        self.joint.guard_values(status, t, z, values);
    }

    fn cross(&self, guard: usize, t: f64, z: &mut [f64], status: &mut [u8]) {
        self.joint.cross(guard, t, z, status);
    }

    fn is_continuous(&self) -> bool {
        true
    }

    fn guard_gradient(
        &self,
        status: &[u8],
        guard: usize,
        t: f64,
        z: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        self.joint.guard_gradient(status, guard, t, z, gradient)
    }
}

impl Differentiable for Traced {
    fn record_len(&self) -> usize {
        self.joint.record_len()
    }

    fn force_recorded(
        &self,
        status: Option<&[u8]>,
        t: f64,
        z: &[f64],
        out: &mut [f64],
        record: &mut [f64],
    ) {
        self.both(status, t, z, out);
        record.copy_from_slice(&self.scratch.lock().unwrap().record);
    }

    fn product(
        &self,
        status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        self.joint.product(status, record, vectors, width, out);
    }
}

/// State-space volumes change at the rate of the trace of `dF/dz` (Liouville's theorem). The sum of all
/// 22 exponents is therefore its mean along the trajectory.
#[test]
fn the_sum_of_all_exponents_is_the_mean_trace() {
    let span = 2e-3;
    for changes in [ContactChanges::Located, ContactChanges::Through] {
        let (joint, z) = kicked(100, 30e-3);
        let traced = Traced::new(joint);
        let width = traced.tangent_dim();
        assert_eq!(width, 22);
        let mut run = integrator(&traced, changes, lawson(1e-10))
            .with_tangents(width, 1)
            .unwrap();
        let start = [z, vec![0.0]].concat();
        run.start(0.0, &start).unwrap();
        run.integrate_to(span).unwrap();
        let spectrum = run.exponents().unwrap();
        let sum: f64 = spectrum.exponents.iter().map(|e| e.value).sum();
        let mean = run.state()[22] / spectrum.time;
        println!(
            "{changes:?}: sum {sum:.9e}, mean trace {mean:.9e}, {:.1e}",
            sum / mean - 1.0
        );
        assert!((spectrum.time - span).abs() < 1e-12);
        assert!(mean < -100.0, "friction must contract volumes: {mean}");
        assert!((sum / mean - 1.0).abs() < 1e-6, "{sum} {mean}");
    }
}

/// Thousands of crossings per millisecond: integration with event location succeeds and agrees with
/// accurate integration through the kinks.
#[test]
fn thousands_of_crossings_per_millisecond() {
    let span = 0.5e-3;
    let (joint, z) = kicked(400, 30e-3);
    let mut exact = integrator(&joint, ContactChanges::Located, lawson(1e-11));
    exact.start(0.0, &z).unwrap();
    exact.integrate_to(span).unwrap();
    let stats = exact.stats();
    let through = flow(&joint, ContactChanges::Through, lawson(1e-13), &z, span);
    let distance = length(&joint, difference(exact.state(), &through)) / length(&joint, through);
    println!("{stats:?}, distance {distance:.1e}");
    assert!(stats.crossings >= 2000, "{} crossings", stats.crossings);
    assert_eq!(stats.steps_without_event_location, 0);
    assert!(distance < 1e-8, "{distance:e}");
}
