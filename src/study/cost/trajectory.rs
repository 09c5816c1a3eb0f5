//! Settings whose error is that of a trajectory: integrator, events, contact nodes.

use super::baseline::{Baseline, timed};
use super::{CostError, CostSetting, WorkPrecisionPoint, WorkPrecisionSet};
use crate::chain_of_causes;
use crate::dynamics::MethodName;
use crate::dynamics::SolverStats;
use crate::joint::{BallJoint, Quadrature};
use crate::pipeline::{Prepared, prepare_reusing_body};
use crate::scene::{Events, MAX_ADVISED_STEP, Scene};
use crate::study::OnProgress;

/// Number of times compared, evenly over the horizon.
const TIMES: u32 = 200;

/// Tolerance of the reference, and of a second one that gives its error.
const REFERENCE_TOLERANCE: f64 = 1e-12;

/// Tolerances, two per decade.
const TOLERANCES: [f64; 17] = [
    1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8, 1e-8, 3e-9, 1e-9,
    3e-10, 1e-10,
];

/// Steps of fixed-step methods, s.
const STEPS: [f64; 6] = [6.4e-6, 3.2e-6, 1.6e-6, 8e-7, 4e-7, 2e-7];

/// Maximum number of right-hand-side evaluations of a point.
const MAX_RHS_EVALS: u64 = 3_000_000;

/// Numbers of contact nodes; those of the reference and of a second one that gives its error.
const NODES: [usize; 8] = [7, 16, 28, 64, 100, 201, 452, 1000];
const REFERENCE_NODES: [usize; 2] = [4000, 2000];

/// States `[q | dq/dt]` at the compared times, and the weights of their norm.
pub(super) struct Trajectory {
    rows: Vec<Vec<f64>>,
    /// Angular frequencies, rad/s.
    omega: Vec<f64>,
}

impl Trajectory {
    /// Largest deviation from a reference in the energy norm, relative to the root of the reference's mean
    /// energy.
    fn error(&self, reference: &Self) -> f64 {
        let norm = |z: &mut dyn Iterator<Item = f64>| -> f64 {
            let omega = self.omega.iter().copied();
            let weights = omega.chain(std::iter::repeat(1.0));
            z.zip(weights).map(|(x, w)| (w * x).powi(2)).sum()
        };
        let pairs = self.rows.iter().zip(&reference.rows);
        let off = pairs.map(|(z, r)| norm(&mut z.iter().zip(r).map(|(a, b)| a - b)));
        let size = reference.rows.iter().map(|r| norm(&mut r.iter().copied()));
        let mean = size.sum::<f64>() / reference.rows.len() as f64;
        // `f64::max` would ignore NaN.
        let largest = off.fold(0.0, |a: f64, b| if b <= a { a } else { b });
        (largest / mean).sqrt()
    }
}

/// Integrates a scene from a state over a time (s). `stats` is set even if it fails.
pub(super) fn integrate(
    scene: &Scene,
    state: &[f64],
    time: f64,
    ball: &mut Option<BallJoint>,
    stats: &mut SolverStats,
    should_continue: &mut dyn FnMut() -> bool,
) -> Result<Trajectory, Box<dyn std::error::Error>> {
    *stats = SolverStats::default();
    let Prepared {
        system,
        mut integrator,
        state: mut z,
        ..
    } = prepare_reusing_body(scene, ball)?.starting_from(state);
    integrator.start(&*system, 0.0, &z)?;
    let mut rows = Vec::new();
    for k in 1..=TIMES {
        let time_k = time * f64::from(k) / f64::from(TIMES);
        let reached = integrator.sample(&*system, time_k, &mut z);
        *stats = integrator.stats();
        reached?;
        rows.push(z[..state.len()].to_vec());
        if stats.rhs_evals > MAX_RHS_EVALS {
            let rhs_evals = stats.rhs_evals;
            return Err(format!("stopped after {rhs_evals} right-hand-side evaluations").into());
        }
        if !should_continue() {
            break;
        }
    }
    Ok(Trajectory {
        rows,
        omega: system.omega().to_vec(),
    })
}

/// A scene with another integrator setting.
fn with(scene: &Scene, method: MethodName, value: f64, events: Events) -> Scene {
    let mut scene = scene.clone();
    let integrator = &mut scene.integrator;
    integrator.method = method;
    integrator.events = events;
    match method.has_fixed_step() {
        true => integrator.max_step = value,
        false => {
            integrator.tolerance = value;
            integrator.max_step = MAX_ADVISED_STEP;
        }
    }
    scene
}

impl Baseline<'_> {
    /// The reference from the settled state, and its error.
    fn reference(&mut self, scene: &Scene) -> Result<(Trajectory, f64), CostError> {
        let events = Events::Exact;
        let best = self.path(&with(
            scene,
            MethodName::Lawson54,
            REFERENCE_TOLERANCE,
            events,
        ))?;
        let other = self.path(&with(scene, MethodName::Tsit5, REFERENCE_TOLERANCE, events))?;
        let floor = other.error(&best);
        Ok((best, floor))
    }

    fn path(&mut self, scene: &Scene) -> Result<Trajectory, CostError> {
        let (ball, stats) = (&mut self.ball, &mut SolverStats::default());
        integrate(scene, &self.state, self.horizon, ball, stats, &mut || true)
            .map_err(|error| CostError::NoReference(error.to_string()))
    }

    /// A point: a setting compared with the reference; `None` if stopped.
    fn point(
        &mut self,
        value: f64,
        scene: &Scene,
        reference: &Trajectory,
        should_continue: &mut dyn FnMut() -> bool,
    ) -> Option<WorkPrecisionPoint> {
        let (mut stopped, mut stats) = (false, SolverStats::default());
        let (found, seconds) = timed(self.plan.repeats, || {
            if stopped {
                return Err("stopped".to_owned());
            }
            let on = &mut || {
                stopped |= !should_continue();
                !stopped
            };
            let (ball, stats) = (&mut self.ball, &mut stats);
            integrate(scene, &self.state, self.horizon, ball, stats, on)
                .map_err(|error| chain_of_causes(&*error))
        });
        if stopped {
            return None;
        }
        let error = found.and_then(|path| match path.error(reference) {
            error if error.is_finite() => Ok(error),
            _ => Err("the error is not finite".to_owned()),
        });
        Some(WorkPrecisionPoint {
            value,
            seconds,
            rhs_evals: stats.rhs_evals,
            error,
            detail: match (scene.integrator.events, stats.events) {
                (Events::Through, _) => String::new(),
                (Events::Exact, 0) => "no event".to_owned(),
                (Events::Exact, 1) => "1 event".to_owned(),
                (Events::Exact, events) => format!("{events} events"),
            },
        })
    }
}

/// Methods and their tolerances or steps.
pub(super) fn integrator_sets(
    baseline: &mut Baseline<'_>,
    should_continue: OnProgress<'_, f64>,
) -> Result<Option<Vec<WorkPrecisionSet>>, CostError> {
    let scene = baseline.plan.scene.clone();
    let events = scene.integrator.events;
    let (reference, floor) = baseline.reference(&scene)?;
    let mut sets = Vec::new();
    for (k, method) in MethodName::ALL.iter().copied().enumerate() {
        let values: Vec<f64> = match method.has_fixed_step() {
            true => STEPS.to_vec(),
            false => TOLERANCES.to_vec(),
        };
        let mut points = Vec::new();
        for value in values {
            let varied = with(&scene, method, value, events);
            let on = &mut || should_continue(k as f64 / MethodName::ALL.len() as f64);
            let Some(point) = baseline.point(value, &varied, &reference, on) else {
                return Ok(None);
            };
            points.push(point);
        }
        sets.push(WorkPrecisionSet {
            setting: CostSetting::Integrator,
            family: method.name().to_owned(),
            parameter: match method.has_fixed_step() {
                true => "step, s".into(),
                false => "tolerance".into(),
            },
            floor: Some(floor),
            points,
        });
    }
    Ok(Some(sets))
}

/// Steps through events, and exact event location.
pub(super) fn event_sets(
    baseline: &mut Baseline<'_>,
    should_continue: OnProgress<'_, f64>,
) -> Result<Option<Vec<WorkPrecisionSet>>, CostError> {
    let scene = baseline.plan.scene.clone();
    let (reference, floor) = baseline.reference(&scene)?;
    let mut sets = Vec::new();
    for (k, events) in [Events::Through, Events::Exact].into_iter().enumerate() {
        let mut points = Vec::new();
        for value in TOLERANCES.into_iter().step_by(2) {
            let varied = with(&scene, MethodName::Lawson54, value, events);
            let on = &mut || should_continue(0.5 * k as f64);
            let Some(point) = baseline.point(value, &varied, &reference, on) else {
                return Ok(None);
            };
            points.push(point);
        }
        sets.push(WorkPrecisionSet {
            setting: CostSetting::Events,
            family: match events {
                Events::Through => "through",
                Events::Exact => "exact",
            }
            .to_owned(),
            parameter: "tolerance".into(),
            floor: Some(floor),
            points,
        });
    }
    Ok(Some(sets))
}

/// Quadratures and numbers of contact nodes.
pub(super) fn node_sets(
    baseline: &mut Baseline<'_>,
    should_continue: OnProgress<'_, f64>,
) -> Result<Option<Vec<WorkPrecisionSet>>, CostError> {
    const TOLERANCE: f64 = 1e-9;
    let with_nodes = |quadrature, nodes| -> Result<Scene, CostError> {
        let mut scene = with(
            &baseline.plan.scene,
            MethodName::Lawson54,
            TOLERANCE,
            Events::Through,
        );
        let contact = &mut scene.joint_mut()?.spec.contact;
        contact.quadrature = quadrature;
        contact.nodes = nodes;
        Ok(scene)
    };
    let families = [(Quadrature::Rings, "rings"), (Quadrature::Gauss, "gauss")];
    let settings = |quadrature| {
        NODES
            .iter()
            .map(move |&nodes| Ok((nodes as f64, with_nodes(quadrature, nodes)?)))
            .collect::<Result<Vec<_>, CostError>>()
    };
    let all = [settings(families[0].0)?, settings(families[1].0)?];
    let references = [
        with_nodes(Quadrature::Gauss, REFERENCE_NODES[0])?,
        with_nodes(Quadrature::Gauss, REFERENCE_NODES[1])?,
    ];
    let reference = baseline.path(&references[0])?;
    let floor = baseline.path(&references[1])?.error(&reference);
    let mut sets = Vec::new();
    for (k, ((_, family), settings)) in families.into_iter().zip(all).enumerate() {
        let mut points = Vec::new();
        for (value, scene) in settings {
            let on = &mut || should_continue(0.5 * k as f64);
            let Some(point) = baseline.point(value, &scene, &reference, on) else {
                return Ok(None);
            };
            points.push(point);
        }
        sets.push(WorkPrecisionSet {
            setting: CostSetting::Nodes,
            family: family.to_owned(),
            parameter: "nodes".into(),
            floor: Some(floor),
            points,
        });
    }
    Ok(Some(sets))
}
