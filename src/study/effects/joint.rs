//! Effects of the joint's mechanics.

use std::sync::Arc;

use super::bench::{Bench, Cause, Measured, thread_timed};
use super::effect::{Effect, setting_text};
use crate::dynamics::System;
use crate::fem::Families;
use crate::joint::{
    BallJoint, BodySpec, ContactDamping, DynamicFriction, Friction, FrictionTable, Joint,
    JointSpec, LuGre, Model, PUBLISHED, RateAndState, StiffnessLaw, Stribeck,
};
use crate::pipeline::message::Frame;
use crate::scene::{LoadedJoint, Scene};

/// Right-hand-side evaluations timed together, times nodes times modes.
const EVALUATIONS: usize = 8_000_000;

/// Typical values of inactive effects.
const STRIBECK: Stribeck = Stribeck {
    mu_s: 0.55,
    mu_d: 0.25,
    creep: 1000.0,
    stribeck: 10.0,
};
const LUGRE: LuGre = LuGre {
    mu_s: 0.55,
    mu_d: 0.25,
    stribeck: 10.0,
    stiffness: 1e5,
    damping: 1.0,
    viscous: 0.0,
};
const RATE_AND_STATE: RateAndState = RateAndState {
    mu_0: 0.5,
    direct: 0.01,
    evolution: 0.04,
    reference_speed: 0.016,
    distance: 5e-6,
};
/// Number of points of a measured friction curve, up to 1 m/s.
const CURVE_POINTS: u32 = 32;
const DISSIPATION: f64 = 1.0;
const DAMPING_RATIO: f64 = 1e-3;
/// The smallest mode set used for comparison.
const BENDING: Families = Families {
    bending_pairs: 2,
    torsion: 0,
    axial: 0,
};

/// CPU time of one right-hand-side evaluation (s), and the effects of the joint; `None` if stopped.
pub(super) fn joint_effects(
    scene: &Scene,
    tilted: &LoadedJoint,
    frames: &[Arc<Frame>],
    calls: f64,
    bench: &mut Bench<'_>,
) -> Result<Option<(f64, Vec<Effect>)>, Cause> {
    let tilt = tilted.tilt.at(0.0);
    let ball = BallJoint::new(&tilted.spec)?;
    let model = ball.model(tilt)?;
    let mut all = node_effects(&model);
    all.extend(build_effects(&tilted.spec, &ball, tilt)?);
    let evaluations: Vec<Evaluations> = std::iter::once(&model)
        .chain(all.iter().map(|(.., other)| other))
        .map(|model| Evaluations::new(model, frames))
        .collect();
    // The last variant rebuilds the joint, which scheduled parameters do at every frame boundary.
    let made = evaluations.len();
    let rounds = bench.rounds(made + 1, &mut |variant| match evaluations.get(variant) {
        Some(evaluations) => Ok(evaluations.time()),
        None => {
            let (again, seconds) =
                thread_timed(|| ball.model(tilt).map(|model| Joint::new(&model)));
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
                name: name.into(),
                key: key.into(),
                on,
                setting,
                cost: Ok(cost.times(calls)),
                setup: None,
            }
        });
    let mut effects: Vec<Effect> = effects.collect();
    let borders = scene.sample_rate / scene.frame_samples as f64;
    effects.push(schedule_effect(tilted, rounds.of(made).times(borders)));
    Ok(Some((rounds.of(0).mean, effects)))
}

/// Right-hand-side evaluations at states of the scene's vibration.
struct Evaluations {
    joint: Joint,
    states: Vec<Vec<f64>>,
    count: usize,
}

impl Evaluations {
    /// At up to 16 states from the last half of the frames; a smaller model takes their lowest modes.
    fn new(model: &Model, frames: &[Arc<Frame>]) -> Self {
        let modes = model.modes();
        let joint = Joint::new(model);
        let states = frames[frames.len() / 2..].iter().take(16).map(|frame| {
            let mode = |x: &[f64], i: usize| x.get(i).copied().filter(|_| i < frame.modes);
            let of = |x: &[f64]| {
                (0..modes)
                    .map(|i| mode(x, i).unwrap_or(0.0))
                    .collect::<Vec<_>>()
            };
            let mut z = [of(&frame.q), of(&frame.qdot)].concat();
            z.resize(joint.dim(), 0.0);
            z
        });
        Self {
            states: states.collect(),
            joint,
            count: (EVALUATIONS / (model.nodes() * modes)).max(1),
        }
    }

    /// CPU time of one evaluation, s.
    fn time(&self) -> f64 {
        let mut out = vec![0.0; self.joint.dim()];
        let ((), seconds) = thread_timed(|| {
            for k in 0..self.count {
                let z = &self.states[k % self.states.len()];
                self.joint.rhs(0.0, std::hint::black_box(z), &mut out);
                std::hint::black_box(&mut out);
            }
        });
        seconds / self.count as f64
    }
}

/// An effect of the contact nodes: name, key, whether it is active, its setting, and the model with it
/// switched.
type SwitchedModel = (&'static str, &'static str, bool, String, Model);

/// A modified copy of a model.
fn changed(model: &Model, change: impl FnOnce(&mut Model)) -> Model {
    let mut other = model.clone();
    change(&mut other);
    other
}

/// Effects of the contact nodes, each with the model in which it is switched.
fn node_effects(model: &Model) -> Vec<SwitchedModel> {
    let mut all = friction_effects(model);
    let lifts = model.unilateral;
    all.push((
        "lift-off",
        "contact.unilateral",
        lifts,
        setting_text(lifts, "Eq. (2)"),
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
        "contact damping",
        "contact_damping",
        damped,
        damping,
        changed(model, |other| other.contact_damping = other_damping),
    ));
    let convected = model.convection.is_some();
    all.push((
        "convection, Omega x u",
        "rotation.convection",
        convected,
        setting_text(convected, "on"),
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
        setting_text(has_damping, &format!("ratio up to {most}")),
        changed(model, |other| {
            other.damping = match has_damping {
                true => Vec::new(),
                false => vec![DAMPING_RATIO; model.modes()],
            };
        }),
    ));
    all
}

/// Friction, and its radial component if there is friction.
fn friction_effects(model: &Model) -> Vec<SwitchedModel> {
    let radial = model.friction.radial();
    let (setting, switched) = match &model.friction {
        Friction::None => (String::new(), None),
        Friction::Constant { law, .. } => {
            let (law, radial) = (*law, !radial);
            let setting = format!("constant, mu {}", law.mu);
            (setting, Some(Friction::Constant { law, radial }))
        }
        Friction::Stribeck { law, .. } => {
            let (law, radial) = (*law, !radial);
            let setting = format!("Stribeck, mu {} to {}", law.mu_s, law.mu_d);
            (setting, Some(Friction::Stribeck { law, radial }))
        }
        Friction::Table { law, .. } => {
            let (law, radial) = (Arc::clone(law), !radial);
            let setting = format!("measured curve of {} points", law.points().len());
            (setting, Some(Friction::Table { law, radial }))
        }
        Friction::Dynamic { law, .. } => {
            let (law, radial) = (*law, !radial);
            let setting = match law {
                DynamicFriction::LuGre(law) => format!("LuGre, mu {} to {}", law.mu_s, law.mu_d),
                DynamicFriction::RateAndState(law) => format!("rate and state, mu {}", law.mu_0),
            };
            (setting, Some(Friction::Dynamic { law, radial }))
        }
    };
    let is_on = switched.is_some();
    let other = match is_on {
        true => Friction::None,
        false => Friction::Stribeck {
            law: STRIBECK,
            radial: true,
        },
    };
    let with = |friction| changed(model, |other| other.friction = friction);
    let mut all = vec![
        ("friction", "friction", is_on, setting, with(other)),
        measured_curve(model),
        friction_with_state(
            model,
            "bristles (LuGre friction)",
            DynamicFriction::LuGre(LUGRE),
        ),
        friction_with_state(
            model,
            "age of the contact (rate and state)",
            DynamicFriction::RateAndState(RATE_AND_STATE),
        ),
    ];
    all.extend(switched.map(|switched| {
        (
            "radial friction component",
            "friction.radial",
            radial,
            setting_text(radial, "as in Eq. (8)"),
            with(switched),
        )
    }));
    all
}

/// A measured friction curve, compared with Eq. (5): the same curve as a table and as a formula.
fn measured_curve(model: &Model) -> SwitchedModel {
    let radial = model.friction.radial();
    let (is_on, setting, friction) = match &model.friction {
        Friction::Table { law, .. } => {
            let setting = format!("{} points", law.points().len());
            let law = STRIBECK;
            (true, setting, Friction::Stribeck { law, radial })
        }
        _ => {
            let speeds = (0..CURVE_POINTS).map(|k| f64::from(k) / f64::from(CURVE_POINTS));
            let points = speeds.map(|v| [v, STRIBECK.sliding(v)]).collect();
            let law = FrictionTable::new(points, STRIBECK.creep).expect("increasing speeds");
            let law = Arc::new(law);
            (false, String::new(), Friction::Table { law, radial })
        }
    };
    (
        "measured friction curve",
        "friction.points",
        is_on,
        setting,
        changed(model, |other| other.friction = friction),
    )
}

/// A friction law with states like `typical`, compared with Eq. (5).
fn friction_with_state(
    model: &Model,
    name: &'static str,
    typical: DynamicFriction,
) -> SwitchedModel {
    let radial = model.friction.radial();
    let is_alike =
        |law: &DynamicFriction| std::mem::discriminant(law) == std::mem::discriminant(&typical);
    let is_on = matches!(&model.friction, Friction::Dynamic { law, .. } if is_alike(law));
    let (setting, friction) = match is_on {
        true => {
            let states = model.friction.states() * model.nodes();
            let law = STRIBECK;
            (
                format!("{states} states"),
                Friction::Stribeck { law, radial },
            )
        }
        false => (
            String::new(),
            Friction::Dynamic {
                law: typical,
                radial,
            },
        ),
    };
    let other = changed(model, |other| other.friction = friction);
    (name, "friction.law", is_on, setting, other)
}

/// Effects of choices made when the joint is built: the stiffness distribution and the mode set, each with
/// the model of the other choice. A body from a file has fixed choices.
fn build_effects(
    spec: &JointSpec,
    ball: &BallJoint,
    tilt: f64,
) -> Result<Vec<SwitchedModel>, Cause> {
    let mut all: Vec<SwitchedModel> = Vec::new();
    let BodySpec::BallOnBeam(body) = &spec.body else {
        return Ok(all);
    };
    let spread = spec.contact.stiffness == StiffnessLaw::LikePreStress;
    let mut other = spec.clone();
    other.contact.stiffness = match spread {
        true => StiffnessLaw::Uniform,
        false => StiffnessLaw::LikePreStress,
    };
    all.push((
        "stiffness distributed like the pre-stress",
        "contact.stiffness_distribution",
        spread,
        setting_text(spread, "pre-stress"),
        ball.clone().with_spec(&other)?.model(tilt)?,
    ));
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
    // The damping ratios belong to the scene's own modes.
    other.damping.clear();
    // The paper's frequencies may be unknown for the additional modes.
    if let Ok(other) = BallJoint::new(&other) {
        all.push((
            "fewer modes",
            "body.bending_pairs, torsion, axial",
            fewer,
            setting_text(fewer, &format!("{} of {}", families.count(), paper.count())),
            other.model(tilt)?,
        ));
    }
    Ok(all)
}

/// Scheduled tilt, load and rotation. They share one cost: the joint is rebuilt at the start of each frame.
fn schedule_effect(joint: &LoadedJoint, cost: Measured) -> Effect {
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
    if joint.patch_moves() {
        spans.push("patch moved by the rotation".to_owned());
    }
    Effect {
        name: "scheduled tilt, load, rotation".into(),
        key: "load.tilt, load.load, rotation.factor, rotation.moves_patch".into(),
        on: !spans.is_empty(),
        setting: spans.join(", "),
        cost: Ok(cost),
        setup: None,
    }
}
