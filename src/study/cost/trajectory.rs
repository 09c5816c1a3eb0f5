//! Knobs whose error is that of a trajectory: integrator, events, contact nodes.

use super::ground::{Ground, timed};
use super::{CostError, CostPoint, CostSet, Knob};
use crate::dynamics::MethodName;
use crate::dynamics::Tally;
use crate::joint::{BallJoint, Quadrature};
use crate::pipeline::{Prepared, prepare_on};
use crate::scene::{Events, LONGEST_STEP, Scene};
use crate::study::Watch;

/// Instants compared, evenly over the horizon.
const INSTANTS: u32 = 200;

/// Error allowed in a step of the reference, and of the other one that tells the reference's own error.
const REFERENCE: f64 = 1e-12;

/// Tolerances tried, two a decade.
const TOLERANCES: [f64; 17] = [
    1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8, 1e-8, 3e-9, 1e-9,
    3e-10, 1e-10,
];

/// Steps of methods with a fixed one, s.
const STEPS: [f64; 6] = [6.4e-6, 3.2e-6, 1.6e-6, 8e-7, 4e-7, 2e-7];

/// A setting that needs more calls than this is given up.
const MOST_CALLS: u64 = 3_000_000;

/// Contact nodes tried, and of the reference and the other one that tells its own error.
const NODES: [usize; 8] = [7, 16, 28, 64, 100, 201, 452, 1000];
const NODES_REFERENCES: [usize; 2] = [4000, 2000];

/// States at the instants compared, `[q | dq/dt]` each, and what they are measured by.
struct Path {
    rows: Vec<Vec<f64>>,
    /// Circular frequencies, rad/s.
    omega: Vec<f64>,
}

impl Path {
    /// The largest deviation from a reference, in the norm of the vibration's energy, relative to the
    /// root of the reference's mean energy.
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
        // Not `max`, which would pass over what is not a number.
        let largest = off.fold(0.0, |a: f64, b| if b <= a { a } else { b });
        (largest / mean).sqrt()
    }
}

/// Follows a scene from a state over a time (s), and tells what that took, even where it fails.
fn follow(
    scene: &Scene,
    state: &[f64],
    time: f64,
    ball: &mut Option<BallJoint>,
    tally: &mut Tally,
    goes_on: &mut dyn FnMut() -> bool,
) -> Result<Path, Box<dyn std::error::Error>> {
    *tally = Tally::default();
    let Prepared {
        system,
        mut integrator,
        state: mut z,
        ..
    } = prepare_on(scene, ball)?.starting_from(state);
    integrator.start(&*system, 0.0, &z)?;
    let mut rows = Vec::new();
    for k in 1..=INSTANTS {
        let instant = time * f64::from(k) / f64::from(INSTANTS);
        let reached = integrator.sample(&*system, instant, &mut z);
        *tally = integrator.tally();
        reached?;
        rows.push(z[..state.len()].to_vec());
        if tally.calls > MOST_CALLS {
            let calls = tally.calls;
            return Err(format!("given up after {calls} calls of the right-hand side").into());
        }
        if !goes_on() {
            break;
        }
    }
    Ok(Path {
        rows,
        omega: system.omega().to_vec(),
    })
}

/// A scene with another integrator.
fn with(scene: &Scene, method: MethodName, value: f64, events: Events) -> Scene {
    let mut scene = scene.clone();
    let integrator = &mut scene.integrator;
    integrator.method = method;
    integrator.events = events;
    match method.has_fixed_step() {
        true => integrator.max_step = value,
        false => {
            integrator.tolerance = value;
            integrator.max_step = LONGEST_STEP;
        }
    }
    scene
}

impl Ground<'_> {
    /// The reference from the settled state, and its own error.
    fn reference(&mut self, scene: &Scene) -> Result<(Path, f64), CostError> {
        let events = Events::Exact;
        let best = self.path(&with(scene, MethodName::Lawson54, REFERENCE, events))?;
        let other = self.path(&with(scene, MethodName::Tsit54, REFERENCE, events))?;
        let floor = other.error(&best);
        Ok((best, floor))
    }

    fn path(&mut self, scene: &Scene) -> Result<Path, CostError> {
        let (ball, tally) = (&mut self.ball, &mut Tally::default());
        follow(scene, &self.state, self.horizon, ball, tally, &mut || true)
            .map_err(|error| CostError::NoReference(error.to_string()))
    }

    /// A point: a setting against the reference. `None` if it was told to stop.
    fn point(
        &mut self,
        value: f64,
        scene: &Scene,
        reference: &Path,
        goes_on: &mut dyn FnMut() -> bool,
    ) -> Option<CostPoint> {
        let (mut stopped, mut tally) = (false, Tally::default());
        let (found, seconds) = timed(self.plan.repeats, || {
            if stopped {
                return Err("stopped".to_owned());
            }
            let on = &mut || {
                stopped |= !goes_on();
                !stopped
            };
            let (ball, tally) = (&mut self.ball, &mut tally);
            follow(scene, &self.state, self.horizon, ball, tally, on)
                .map_err(|error| chain(&*error))
        });
        if stopped {
            return None;
        }
        let error = found.and_then(|path| match path.error(reference) {
            error if error.is_finite() => Ok(error),
            _ => Err("not a number".to_owned()),
        });
        Some(CostPoint {
            value,
            seconds,
            calls: tally.calls,
            error,
            detail: match (scene.integrator.events, tally.events) {
                (Events::Through, _) => String::new(),
                (Events::Exact, 0) => "no event".to_owned(),
                (Events::Exact, 1) => "1 event".to_owned(),
                (Events::Exact, events) => format!("{events} events"),
            },
        })
    }
}

/// An error with its causes, in one line.
fn chain(error: &dyn std::error::Error) -> String {
    crate::study::sweep::chain_of_causes(error)
}

/// Methods and their tolerances or steps.
pub(super) fn integrator_sets(
    ground: &mut Ground<'_>,
    goes_on: Watch<'_, f64>,
) -> Result<Option<Vec<CostSet>>, CostError> {
    let scene = ground.plan.scene.clone();
    let events = scene.integrator.events;
    let (reference, floor) = ground.reference(&scene)?;
    let mut sets = Vec::new();
    for (k, method) in MethodName::ALL.iter().copied().enumerate() {
        let values: Vec<f64> = match method.has_fixed_step() {
            true => STEPS.to_vec(),
            false => TOLERANCES.to_vec(),
        };
        let mut points = Vec::new();
        for value in values {
            let turned = with(&scene, method, value, events);
            let on = &mut || goes_on(k as f64 / MethodName::ALL.len() as f64);
            let Some(point) = ground.point(value, &turned, &reference, on) else {
                return Ok(None);
            };
            points.push(point);
        }
        sets.push(CostSet {
            knob: Knob::Integrator,
            family: method.name().to_owned(),
            turned: match method.has_fixed_step() {
                true => "step, s",
                false => "tolerance",
            },
            floor: Some(floor),
            points,
        });
    }
    Ok(Some(sets))
}

/// Through events, or ending there.
pub(super) fn event_sets(
    ground: &mut Ground<'_>,
    goes_on: Watch<'_, f64>,
) -> Result<Option<Vec<CostSet>>, CostError> {
    let scene = ground.plan.scene.clone();
    let (reference, floor) = ground.reference(&scene)?;
    let mut sets = Vec::new();
    for (k, events) in [Events::Through, Events::Exact].into_iter().enumerate() {
        let mut points = Vec::new();
        for value in TOLERANCES.into_iter().step_by(2) {
            let turned = with(&scene, MethodName::Lawson54, value, events);
            let on = &mut || goes_on(0.5 * k as f64);
            let Some(point) = ground.point(value, &turned, &reference, on) else {
                return Ok(None);
            };
            points.push(point);
        }
        sets.push(CostSet {
            knob: Knob::Events,
            family: match events {
                Events::Through => "through",
                Events::Exact => "exact",
            }
            .to_owned(),
            turned: "tolerance",
            floor: Some(floor),
            points,
        });
    }
    Ok(Some(sets))
}

/// Families and numbers of contact nodes.
pub(super) fn node_sets(
    ground: &mut Ground<'_>,
    goes_on: Watch<'_, f64>,
) -> Result<Option<Vec<CostSet>>, CostError> {
    const TOLERANCE: f64 = 1e-9;
    let turned = |quadrature, nodes| -> Result<Scene, CostError> {
        let mut scene = with(
            &ground.plan.scene,
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
            .map(move |&nodes| Ok((nodes as f64, turned(quadrature, nodes)?)))
            .collect::<Result<Vec<_>, CostError>>()
    };
    let all = [settings(families[0].0)?, settings(families[1].0)?];
    let references = [
        turned(Quadrature::Rings, NODES_REFERENCES[0])?,
        turned(Quadrature::Rings, NODES_REFERENCES[1])?,
    ];
    let reference = ground.path(&references[0])?;
    let floor = ground.path(&references[1])?.error(&reference);
    let mut sets = Vec::new();
    for (k, ((_, family), settings)) in families.into_iter().zip(all).enumerate() {
        let mut points = Vec::new();
        for (value, scene) in settings {
            let on = &mut || goes_on(0.5 * k as f64);
            let Some(point) = ground.point(value, &scene, &reference, on) else {
                return Ok(None);
            };
            points.push(point);
        }
        sets.push(CostSet {
            knob: Knob::Nodes,
            family: family.to_owned(),
            turned: "nodes",
            floor: Some(floor),
            points,
        });
    }
    Ok(Some(sets))
}
