//! The effects that make the joint what it is.

use std::sync::Arc;

use super::bench::{Bench, Cause, Measured, timed_here};
use super::effect::{Effect, words};
use crate::dynamics::System;
use crate::fem::Families;
use crate::joint::{
    BallJoint, BodySpec, ContactDamping, Friction, Joint, JointSpec, Model, PUBLISHED,
    StiffnessLaw, Stribeck,
};
use crate::pipeline::message::Frame;
use crate::scene::{Scene, TiltedJoint};

/// Passes over the nodes that are timed together, so many nodes times modes.
const PASSED: usize = 8_000_000;

/// Typical numbers of what is off.
const STRIBECK: Stribeck = Stribeck {
    mu_s: 0.55,
    mu_d: 0.25,
    creep: 1000.0,
    stribeck: 10.0,
};
const DISSIPATION: f64 = 1.0;
const DAMPING_RATIO: f64 = 1e-3;
/// The modes that growth begins with.
const BENDING: Families = Families {
    bending_pairs: 2,
    torsion: 0,
    axial: 0,
};

/// CPU time of a call (s), and the effects of the joint. `None` if it was told to stop.
pub(super) fn of_the_joint(
    scene: &Scene,
    tilted: &TiltedJoint,
    frames: &[Arc<Frame>],
    calls: f64,
    bench: &mut Bench<'_>,
) -> Result<Option<(f64, Vec<Effect>)>, Cause> {
    let tilt = tilted.tilt.at(0.0);
    let ball = BallJoint::new(&tilted.spec)?;
    let model = ball.model(tilt)?;
    let mut all = of_the_nodes(&model);
    all.extend(of_the_spec(&tilted.spec, &ball, tilt)?);
    let passes: Vec<Passes> = std::iter::once(&model)
        .chain(all.iter().map(|(.., other)| other))
        .map(|model| Passes::new(model, frames))
        .collect();
    // The last variant makes the joint anew, which functions of time take at each frame's border.
    let made = passes.len();
    let rounds = bench.rounds(made + 1, &mut |variant| match passes.get(variant) {
        Some(passes) => Ok(passes.time()),
        None => {
            let (again, seconds) = timed_here(|| ball.model(tilt).map(|model| Joint::new(&model)));
            again?;
            Ok(seconds)
        }
    })?;
    let Some(rounds) = rounds else {
        return Ok(None);
    };
    let effects = all
        .into_iter()
        .enumerate()
        .map(|(k, (name, key, on, setting, _))| {
            let cost = rounds.effect(on, 0, k + 1);
            Effect {
                name,
                key,
                on,
                setting,
                cost: Ok(cost.times(calls)),
                setup: None,
            }
        });
    let mut effects: Vec<Effect> = effects.collect();
    let borders = scene.sample_rate / scene.frame_samples as f64;
    effects.push(functions_of_time(tilted, rounds.of(made).times(borders)));
    Ok(Some((rounds.of(0).mean, effects)))
}

/// Passes over the nodes at states of the scene's vibration.
struct Passes {
    joint: Joint,
    states: Vec<Vec<f64>>,
    count: usize,
}

impl Passes {
    /// At some states of the last half of the frames; of fewer modes, at the lowest of theirs.
    fn new(model: &Model, frames: &[Arc<Frame>]) -> Self {
        let modes = model.modes();
        let states = frames[frames.len() / 2..].iter().take(16).map(|frame| {
            let mode = |x: &[f64], i: usize| x.get(i).copied().filter(|_| i < frame.modes);
            let of = |x: &[f64]| {
                (0..modes)
                    .map(|i| mode(x, i).unwrap_or(0.0))
                    .collect::<Vec<_>>()
            };
            [of(&frame.q), of(&frame.qdot)].concat()
        });
        Self {
            joint: Joint::new(model),
            states: states.collect(),
            count: (PASSED / (model.nodes() * modes)).max(1),
        }
    }

    /// CPU time of a pass, s.
    fn time(&self) -> f64 {
        let mut out = vec![0.0; self.joint.dim()];
        let ((), seconds) = timed_here(|| {
            for k in 0..self.count {
                let z = &self.states[k % self.states.len()];
                self.joint.rhs(0.0, std::hint::black_box(z), &mut out);
                std::hint::black_box(&mut out);
            }
        });
        seconds / self.count as f64
    }
}

/// An effect of the nodes: name, key, whether it is on, how, and the model with it changed.
type OfNodes = (&'static str, &'static str, bool, String, Model);

/// A model with something changed.
fn changed(model: &Model, change: impl FnOnce(&mut Model)) -> Model {
    let mut other = model.clone();
    change(&mut other);
    other
}

/// Effects of the nodes, each with the model without it, or with it where it is off.
fn of_the_nodes(model: &Model) -> Vec<OfNodes> {
    let mut all = of_friction(model);
    let lifts = model.unilateral;
    all.push((
        "lift-off",
        "contact.unilateral",
        lifts,
        words(lifts, "Eq. (2)"),
        changed(model, |other| other.unilateral = !lifts),
    ));
    let damping = match model.contact_damping {
        ContactDamping::None => String::new(),
        ContactDamping::KelvinVoigt { time } => format!("dashpots, {:.3} us", 1e6 * time),
        ContactDamping::HuntCrossley { dissipation } => {
            format!("Hunt and Crossley, {dissipation} s/m")
        }
    };
    let damped = !model.contact_damping.is_none();
    let other_damping = match damped {
        true => ContactDamping::None,
        false => ContactDamping::HuntCrossley {
            dissipation: DISSIPATION,
        },
    };
    all.push((
        "damping of the contact",
        "contact_damping",
        damped,
        damping,
        changed(model, |other| other.contact_damping = other_damping),
    ));
    let convected = model.convection.is_some();
    all.push((
        "Omega x u",
        "rotation.convection",
        convected,
        words(convected, "on"),
        changed(model, |other| {
            other.convection = (!convected).then_some([1.0, 0.0, 0.0]);
        }),
    ));
    let has_damping = model.damping.iter().any(|ratio| *ratio != 0.0);
    let most = model.damping.iter().copied().fold(0.0, f64::max);
    all.push((
        "modal damping",
        "damping",
        has_damping,
        words(has_damping, &format!("ratio up to {most}")),
        changed(model, |other| {
            other.damping = match has_damping {
                true => Vec::new(),
                false => vec![DAMPING_RATIO; model.modes()],
            };
        }),
    ));
    all
}

/// Friction, and its radial part where there is friction.
fn of_friction(model: &Model) -> Vec<OfNodes> {
    let radial = model.friction.radial();
    let (setting, turned) = match model.friction {
        Friction::None => (String::new(), None),
        Friction::Constant { law, .. } => {
            let radial = !radial;
            let setting = format!("constant, mu {}", law.mu);
            (setting, Some(Friction::Constant { law, radial }))
        }
        Friction::Stribeck { law, .. } => {
            let radial = !radial;
            let setting = format!("Stribeck, mu {} to {}", law.mu_s, law.mu_d);
            (setting, Some(Friction::Stribeck { law, radial }))
        }
    };
    let is_on = turned.is_some();
    let other = match is_on {
        true => Friction::None,
        false => Friction::Stribeck {
            law: STRIBECK,
            radial: true,
        },
    };
    let with = |friction| changed(model, |other| other.friction = friction);
    let mut all = vec![("friction", "friction", is_on, setting, with(other))];
    all.extend(turned.map(|turned| {
        (
            "radial part of friction",
            "friction.radial",
            radial,
            words(radial, "as in Eq. (8)"),
            with(turned),
        )
    }));
    all
}

/// What is chosen where the joint is made: how the stiffness is spread, and which modes take part; each with the
/// model of the other choice. A body from a file has made these choices itself.
fn of_the_spec(spec: &JointSpec, ball: &BallJoint, tilt: f64) -> Result<Vec<OfNodes>, Cause> {
    let BodySpec::BallOnBeam(body) = &spec.body else {
        return Ok(Vec::new());
    };
    let spread = spec.contact.stiffness == StiffnessLaw::LikePreStress;
    let mut other = spec.clone();
    other.contact.stiffness = match spread {
        true => StiffnessLaw::Uniform,
        false => StiffnessLaw::LikePreStress,
    };
    let mut all: Vec<OfNodes> = vec![(
        "stiffness like the pre-stress",
        "contact.stiffness",
        spread,
        words(spread, "pre-stress"),
        ball.clone().with_spec(&other)?.model(tilt)?,
    )];
    let families = body.families;
    let paper = PUBLISHED;
    let fewer = families.count() < paper.count();
    let mut other = spec.clone();
    if let BodySpec::BallOnBeam(body) = &mut other.body {
        body.families = match fewer {
            true => paper,
            false => BENDING,
        };
    }
    // Ratios of damping are those of the modes that there are.
    other.damping.clear();
    // The paper's frequencies may not be known of the modes that the scene leaves out.
    if let Ok(other) = BallJoint::new(&other) {
        all.push((
            "fewer modes",
            "body.bending_pairs, torsion, axial",
            fewer,
            words(fewer, &format!("{} of {}", families.count(), paper.count())),
            other.model(tilt)?,
        ));
    }
    Ok(all)
}

/// Tilt, load and rotation as functions of time, which share their cost: the joint made anew where a frame
/// starts.
fn functions_of_time(joint: &TiltedJoint, cost: Measured) -> Effect {
    let span = |name: &str, [low, high]: [f64; 2], unit: &str| {
        format!("{name} {low:.4} to {high:.4}{unit}")
    };
    let mut spans = Vec::new();
    if joint.tilt.varies() {
        let degrees = [joint.tilt.min(), joint.tilt.max()].map(f64::to_degrees);
        spans.push(span("tilt", degrees, "\u{b0}"));
    }
    if joint.load.is_some() {
        spans.push(span("load", joint.load_span(), " N"));
    }
    if joint.rotation.is_some() {
        spans.push(span("rotation", joint.rotation_span(), " times"));
    }
    Effect {
        name: "tilt, load, rotation of time",
        key: "load.tilt, load.load, rotation.factor",
        on: !spans.is_empty(),
        setting: spans.join(", "),
        cost: Ok(cost),
        setup: None,
    }
}
