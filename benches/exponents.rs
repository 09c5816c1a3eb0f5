//! Cost of the tangent flow relative to the plain run.
//!
//! * `product/vectors`: the derivative of the force applied to several tangent vectors at once.
//! * At the end, tables for the vibration of `doubled-torus-3deg` with its own tolerance: the run with exponents
//!   over the plain run. Contact is evaluated continuously (`Through`) or with event location (`Exact`),
//!   once in the developed vibration and once just after a kick so hard that nodes separate and close
//!   thousands of times per millisecond. The runs of a round alternate, which exposes them equally to
//!   other load on the machine. Ratios are those of the shortest times (other load only increases
//!   times), and medians over the rounds.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, criterion_group};
use squeakscope::dynamics::{Accuracy, Differentiable, Integrator, Method, MethodName, System};
use squeakscope::joint::{BallJoint, Joint};
use squeakscope::pipeline::initial_state;
use squeakscope::scene::Scene;

/// Numbers of tangent vectors.
const WIDTHS: [usize; 6] = [1, 2, 3, 5, 11, 22];
/// Time until the vibration has developed, and measured time span, s. The span is short enough that most
/// runs are not interrupted even on a busy machine.
const GROWN: f64 = 40e-3;
const SPAN: f64 = 0.2e-3;
/// Rounds of a table.
const ROUNDS: usize = 61;

const METHOD: Method = MethodName::Lawson54.with(
    Accuracy {
        floor: 1e-12,
        ..Accuracy::relative(1e-5)
    },
    20e-6,
);

/// The joint of `doubled-torus-3deg` and its state just after a kick, m/s.
fn kicked(kick: f64) -> (Joint, Vec<f64>) {
    let mut scene = Scene::load("doubled-torus-3deg").expect("a preset");
    scene.start.kick = kick;
    let tilted = scene.joint().expect("the preset has a joint");
    let ball = BallJoint::new(&tilted.spec).expect("the preset's joint");
    let joint = ball.joint(tilted.tilt.at(0.0)).expect("a clear patch");
    let start = initial_state(&scene, joint.modes());
    (joint, start)
}

/// The joint of `doubled-torus-3deg` and its state in the developed vibration.
fn grown() -> (Joint, Vec<f64>) {
    let (joint, start) = kicked(5e-3);
    let mut integrator = Integrator::new(METHOD, &joint).expect("a sound method");
    let started = integrator.start(0.0, &start);
    started.expect("a sound state");
    integrator.integrate_to(GROWN).expect("a sound run");
    let state = integrator.state().to_vec();
    drop(integrator);
    (joint, state)
}

fn product(c: &mut Criterion) {
    let (joint, z) = grown();
    let m = joint.modes();
    let (mut force, mut record) = (vec![0.0; m], vec![0.0; joint.record_len()]);
    joint.force_recorded(None, 0.0, &z, &mut force, &mut record);
    let mut group = c.benchmark_group("product/vectors");
    for width in [1, 2, 3, 4, 5, 6, 8, 11, 16, 22] {
        let vectors: Vec<f64> = (0..2 * m * width).map(|i| (i as f64).sin()).collect();
        let mut out = vec![0.0; m * width];
        group.bench_function(BenchmarkId::from_parameter(width), |b| {
            b.iter(|| {
                joint.product(None, &mut record, black_box(&vectors), width, &mut out);
                black_box(&out);
            });
        });
    }
    group.finish();
    let mut group = c.benchmark_group("force");
    group.bench_function("plain", |b| {
        b.iter(|| joint.force(0.0, black_box(&z), black_box(&mut force)));
    });
    group.bench_function("recorded", |b| {
        b.iter(|| {
            joint.force_recorded(None, 0.0, black_box(&z), black_box(&mut force), &mut record);
        });
    });
    group.finish();
}

/// Treatment of contact in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Through,
    Exact,
}

/// Integrator of one line of the table.
fn integrator(joint: &Joint, mode: Mode, width: usize) -> Integrator<'_> {
    let mut integrator = Integrator::new(METHOD, joint).expect("a sound method");
    if mode == Mode::Exact {
        integrator = integrator.with_events().expect("the joint's guards");
    }
    if width > 0 {
        let followed = integrator.with_tangents(width, 1);
        integrator = followed.expect("no more vectors than dimensions");
    }
    integrator
}

/// Times one run of an integrator over the span.
fn run(start: &[f64], integrator: &mut Integrator<'_>) -> Duration {
    let begin = Instant::now();
    integrator.start(0.0, start).expect("a sound state");
    integrator.integrate_to(SPAN).expect("a sound run");
    begin.elapsed()
}

fn median(numbers: &mut [f64]) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

fn shortest(times: &[f64]) -> f64 {
    times.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Prints a table of ratios.
fn ratios(title: &str, (joint, start): &(Joint, Vec<f64>)) {
    let mut lines: Vec<(Mode, usize, Integrator<'_>)> = Vec::new();
    for mode in [Mode::Through, Mode::Exact] {
        for width in [0].into_iter().chain(WIDTHS) {
            lines.push((mode, width, integrator(joint, mode, width)));
        }
    }
    let mut times = vec![Vec::new(); lines.len()];
    for _ in 0..ROUNDS {
        for ((_, _, integrator), times) in lines.iter_mut().zip(&mut times) {
            times.push(run(start, integrator).as_secs_f64());
        }
    }
    println!("\n{title}");
    println!("mode     vectors   us per ms   over plain   over plain, same mode   (median)");
    let per = lines.len() / 2;
    for (k, (mode, width, _)) in lines.iter().enumerate() {
        let (own, plain, same) = (&times[k], &times[0], &times[k / per * per]);
        let pairs = own.iter().zip(same);
        let typical = median(&mut pairs.map(|(a, b)| a / b).collect::<Vec<_>>());
        println!(
            "{:8} {width:7} {:11.0} {:12.2} {:23.2}     {typical:.2}",
            format!("{mode:?}"),
            shortest(own) / SPAN * 1e3,
            shortest(own) / shortest(plain),
            shortest(own) / shortest(same),
        );
    }
    let runs = ROUNDS as f64 * SPAN * 1e3;
    for k in [0, per] {
        let (mode, _, integrator) = &lines[k];
        let stats = integrator.stats();
        let each = |count: u64| count as f64 / runs;
        let (crossings, steps, calls) = (
            each(stats.crossings),
            each(stats.steps),
            each(stats.rhs_evals),
        );
        println!(
            "{mode:?}: {crossings:.0} crossings, {steps:.0} steps, {calls:.0} calls a millisecond"
        );
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(40)
        .warm_up_time(std::time::Duration::from_millis(300))
        .measurement_time(std::time::Duration::from_secs(1));
    targets = product
}

fn main() {
    benches();
    ratios("grown vibration", &grown());
    ratios("hard kick", &kicked(30e-3));
    Criterion::default().configure_from_args().final_summary();
}
