//! Integration steps and evaluations of the joint do not allocate, for any friction law.
#![allow(
    unsafe_code,
    reason = "a counting allocator must implement the unsafe GlobalAlloc trait"
)]

use std::alloc::{GlobalAlloc, Layout, System as SystemAllocator};
use std::cell::Cell;
use std::sync::Arc;

use squeakscope::dynamics::{Accuracy, Differentiable, Integrator, Method, MethodName, System};
use squeakscope::joint::{
    BallJoint, ContactDamping, Friction, FrictionLaw, FrictionTable, Joint, Model, Ratio, Stribeck,
};
use squeakscope::scene::Scene;
use squeakscope::systems::{DampedContact, ImpactOscillator, MassOnBelt};

/// The system allocator with a counter of the requests of each thread.
struct Counting;

thread_local! {
    static REQUESTS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every request is forwarded unchanged to the system allocator; counting accesses only a
// constant-initialised thread-local without destructor, which never allocates.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        REQUESTS.set(REQUESTS.get() + 1);
        // SAFETY: the caller upholds the contract of the system allocator.
        unsafe { SystemAllocator.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above; `pointer` came from the same allocator.
        unsafe { SystemAllocator.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        REQUESTS.set(REQUESTS.get() + 1);
        // SAFETY: as above; `pointer` came from the same allocator.
        unsafe { SystemAllocator.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Number of memory requests of `work` on this thread.
fn requests(work: impl FnOnce()) -> u64 {
    let before = REQUESTS.get();
    work();
    REQUESTS.get() - before
}

/// Eleven oscillators with unilateral springs and the work of the springs.
struct Springs {
    omega: Vec<f64>,
}

impl Springs {
    fn new() -> Self {
        Self {
            omega: (1..=11).map(f64::from).collect(),
        }
    }
}

impl System for Springs {
    fn omega(&self) -> &[f64] {
        &self.omega
    }
    fn first_order(&self) -> usize {
        1
    }
    fn force(&self, _t: f64, z: &[f64], out: &mut [f64]) {
        let (q, v) = z.split_at(11);
        for i in 0..11 {
            out[i] = 0.2 - (0.2 + q[i] + q[(i + 1) % 11]).max(0.0);
        }
        out[11] = (0..11).map(|i| out[i] * v[i]).sum();
    }
    fn quadratures(&self) -> usize {
        1
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
    fn is_autonomous(&self) -> bool {
        true
    }
}

impl Differentiable for Springs {
    fn product(
        &self,
        _status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let q = &record[1..12];
        out.fill(0.0);
        for i in (0..11).filter(|&i| 0.2 + q[i] + q[(i + 1) % 11] > 0.0) {
            for l in 0..width {
                out[i * width + l] = -vectors[i * width + l] - vectors[(i + 1) % 11 * width + l];
            }
        }
    }
}

/// All methods, adaptive ones first.
fn methods(accuracy: Accuracy, max_step: f64, step: f64) -> [Method; 7] {
    [
        MethodName::Lawson54.with(accuracy, max_step),
        MethodName::Lawson853.with(accuracy, max_step),
        MethodName::Tsit5.with(accuracy, max_step),
        MethodName::Dop853.with(accuracy, max_step),
        MethodName::Rodas5P.with(accuracy, max_step),
        MethodName::Auto.with(accuracy, max_step),
        MethodName::Rk4.with(Accuracy::relative(1e-6), step),
    ]
}

#[test]
fn the_counter_detects_an_allocation() {
    assert_eq!(requests(|| drop(std::hint::black_box(vec![1.0_f64; 8]))), 1);
}

#[test]
fn integration_does_not_allocate() {
    let springs = Springs::new();
    let mut start = vec![0.0; 23];
    start[11..22].fill(0.5);
    let mut z = vec![0.0; 23];
    let methods = methods(Accuracy::relative(1e-6), 1.0, 0.01);
    for method in methods {
        let mut integrator = Integrator::new(method, &springs).expect("valid parameters");
        let again: Arc<dyn System + '_> = Arc::new(&springs);
        let mut estimates = 0;
        let count = requests(|| {
            integrator.start(0.0, &start).expect("finite initial state");
            for frame in 1..=10 {
                let frame_end = f64::from(frame);
                for k in 0..20 {
                    let t = frame_end - 1.0 + 0.05 * f64::from(k);
                    integrator.sample(t, &mut z).expect("a sample");
                }
                integrator.integrate_to(frame_end).expect("a step end");
                integrator
                    .restart(Arc::clone(&again))
                    .expect("the same system again");
                estimates += u32::from(integrator.take_error_estimate().is_some());
            }
        });
        let stats = integrator.stats();
        assert_eq!(count, 0, "{method:?} allocated in {stats:?}");
        let adaptive = method.name != MethodName::Rk4;
        assert_eq!(estimates, if adaptive { 10 } else { 0 }, "{method:?}");
        assert!(
            stats.steps > 50 && (stats.rejections > 0) == adaptive,
            "{method:?}: {stats:?}"
        );
    }
}

/// Integrates a system for 60 s with event location and tangent vectors; returns the number of events.
fn count_events<Y: System>(name: &str, sys: &Y, start: [f64; 2]) -> u64 {
    let methods = methods(Accuracy::relative(1e-8), 0.2, 0.01);
    let mut events = u64::MAX;
    for method in methods {
        let integrator = Integrator::new(method, sys).expect("valid parameters");
        let mut integrator = integrator
            .with_events()
            .and_then(|new| new.with_tangents(2, 1))
            .expect("the system has guards and a derivative");
        let again: Arc<dyn System + '_> = Arc::new(sys);
        let mut z = start;
        let count = requests(|| {
            integrator.start(0.0, &start).expect("finite initial state");
            for k in 0..400 {
                let t = 0.1 * f64::from(k);
                integrator.sample(t, &mut z).expect("a sample");
            }
            integrator.integrate_to(40.0).expect("a step end");
            integrator
                .restart(Arc::clone(&again))
                .expect("the same system again");
            integrator.reset_growth();
            while integrator.time() < 60.0 {
                integrator.next_event(60.0).expect("an event");
            }
        });
        assert_eq!(count, 0, "{name}: {method:?} allocated");
        events = events.min(integrator.stats().events);
    }
    events
}

#[test]
fn event_location_does_not_allocate() {
    let impact = ImpactOscillator {
        omega: 1.0,
        damping: 0.02,
        drive: 1.0,
        drive_omega: 2.8,
        drive_phase: 0.0,
        wall: 0.0,
        restitution: 0.8,
    };
    let belt = MassOnBelt {
        omega: 1.0,
        damping: 0.0,
        load: 1.0,
        mu_s: 1.0,
        mu_d: 0.5,
        belt: 0.2,
        stribeck: None,
    };
    let damped = DampedContact {
        omega: 1.0,
        damping: 0.05,
        drive: 0.8,
        drive_omega: 1.7,
        drive_phase: 0.0,
        contact_stiffness: 9.0,
        contact_damping: 1.2,
    };
    let events = [
        count_events("impact oscillator", &impact, [0.5, 0.0]),
        count_events("mass on a belt", &belt, [0.0, 0.2]),
        count_events("damped contact", &damped, [0.5, 0.0]),
    ];
    assert!(events.iter().all(|&events| events > 10), "{events:?}");
}

/// A user-defined viscous law.
#[derive(Debug)]
struct Viscous;

impl FrictionLaw for Viscous {
    fn ratio(&self, _speed: f64) -> Ratio {
        Ratio {
            value: 10.0,
            slope: 0.0,
        }
    }

    fn stick_speed(&self) -> f64 {
        0.0
    }
}

/// The joint of a preset with each type of friction, by name.
fn joints() -> Vec<(&'static str, Joint)> {
    let scene = Scene::load("doubled-torus-3deg").expect("a preset");
    let tilted = scene.joint().expect("the preset has a joint");
    let ball = BallJoint::new(&tilted.spec).expect("the preset's joint");
    let model = ball.model(tilted.tilt.at(0.0)).expect("the preset's tilt");
    let Friction::Stribeck { law, .. } = model.friction else {
        panic!("the preset has friction");
    };
    let smooth = |radial| Friction::Stribeck { law, radial };
    let with = |friction, unilateral| {
        Joint::new(&Model {
            friction,
            unilateral,
            ..model.clone()
        })
    };
    let points = vec![[0.0, 0.5], [0.01, 0.45], [0.5, 0.3]];
    let measured = Friction::Table {
        law: Arc::new(FrictionTable::new(points, law.creep).expect("increasing speeds")),
        radial: true,
    };
    let custom = |radial| Joint::with_friction(&model, Arc::new(Viscous), radial);
    vec![
        ("Eq. (5)", with(smooth(true), true)),
        ("no radial part", with(smooth(false), true)),
        ("no separation", with(smooth(true), false)),
        ("no friction", with(Friction::None, true)),
        (
            "constant",
            with(
                Friction::Stribeck {
                    law: Stribeck::constant(law.mu_d, law.creep),
                    radial: true,
                },
                true,
            ),
        ),
        ("measured curve", with(measured, true)),
        (
            "contact damping and Omega x u",
            Joint::new(&Model {
                contact_damping: ContactDamping::KelvinVoigt { time: 1e-7 },
                convection: Some(tilted.spec.rotation),
                ..model.clone()
            }),
        ),
        ("custom law", custom(true)),
        ("custom law, no radial part", custom(false)),
        ("energy audit", with(smooth(true), true).with_audit()),
    ]
}

/// Modal velocities of 10 mm/s with alternating signs, which separate some nodes.
fn kick(joint: &Joint) -> Vec<f64> {
    let m = joint.modes();
    let mut z = vec![0.0; joint.dim()];
    for i in 0..m {
        z[m + i] = if i % 2 == 0 { 0.01 } else { -0.01 };
    }
    z
}

#[test]
fn evaluating_the_contact_nodes_does_not_allocate() {
    for (name, joint) in joints() {
        let m = joint.modes();
        let mut z = kick(&joint);
        // Displacements as large as during the motion: q is v over omega.
        for i in 0..m {
            z[i] = z[m + i] / joint.omega()[i];
        }
        let mut out = vec![0.0; joint.dim()];
        let (mut record, mut product) = (vec![0.0; joint.record_len()], vec![0.0; 2 * m * m]);
        let identity: Vec<f64> = (0..4 * m * m)
            .map(|k| f64::from(u8::from(k % (2 * m + 1) == 0)))
            .collect();
        let mut gaps = vec![0.0; joint.contact_nodes()];
        let mut open = vec![0; joint.contact_nodes().div_ceil(8)];
        let mut probe = 0.0;
        let count = requests(|| {
            joint.rhs(0.0, &z, &mut out);
            joint.force_recorded(None, 0.0, &z, &mut out[..joint.dim() - m], &mut record);
            joint.product(None, &mut record, &identity, 2 * m, &mut product);
            joint.gaps(&z[..m], &mut gaps);
            joint.separated_nodes(&z[..m], &mut open);
            for k in 0..joint.contact_nodes() {
                probe += joint.node_action(k, &z[..m], &z[m..2 * m], &[]).normal;
            }
            probe += joint.probe_value(&z[..m]);
        });
        assert_eq!(count, 0, "{name} allocated");
        // The evaluation covers nodes in contact and separated ones.
        let open: u32 = open.iter().map(|byte| byte.count_ones()).sum();
        let negative = gaps.iter().filter(|gap| **gap < 0.0).count();
        assert_eq!(open as usize, negative);
        assert!(
            0 < negative && negative < gaps.len(),
            "{negative} separated"
        );
        assert!(probe.is_finite() && probe > 0.0);
        assert!(out.iter().chain(&product).all(|x| x.is_finite()));
    }
}

#[test]
fn integrating_the_joint_does_not_allocate() {
    let methods = methods(Accuracy::relative(1e-6), 20e-6, 0.5e-6);
    let cases = joints()
        .into_iter()
        .flat_map(|case| methods.map(|method| (case.clone(), method)));
    for ((name, joint), method) in cases {
        let m = joint.modes();
        let start = kick(&joint);
        let mut z = start.clone();
        let mut integrator = Integrator::new(method, &joint).expect("valid parameters");
        let mut open = vec![0; joint.contact_nodes().div_ceil(8)];
        let mut separated = 0;
        let again: Arc<dyn System + '_> = Arc::new(&joint);
        let count = requests(|| {
            integrator.start(0.0, &start).expect("finite initial state");
            for k in 0..200 {
                let t = 5e-6 * f64::from(k);
                integrator.sample(t, &mut z).expect("a sample");
                joint.separated_nodes(&z[..m], &mut open);
                separated += open.iter().map(|byte| byte.count_ones()).sum::<u32>();
            }
            integrator.integrate_to(1e-3).expect("a step end");
            integrator
                .restart(Arc::clone(&again))
                .expect("the same joint again");
        });
        let stats = integrator.stats();
        assert_eq!(count, 0, "{name} allocated in {stats:?}");
        assert!(stats.steps > 50, "{name}: {stats:?}");
        assert!(separated > 0, "{name}: no node separated");
    }
}
