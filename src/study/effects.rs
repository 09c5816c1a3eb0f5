//! Which effects a scene calls for, and what each costs in it: measured, not told.
//!
//! An effect is taken away where it is on, and added where it is off, and the same work is timed with and
//! without it: passes over the contact nodes at a state of the scene's own vibration, the simulation from
//! its start, the analyses on the frames of that simulation, the recording. What is off costs nothing; what
//! is told of it is what it would cost.

#[cfg(test)]
mod tests;

use std::sync::Arc;

use super::cost::timed;
use crate::dynamics::System;
use crate::joint::{BallJoint, ContactDamping, Friction, Joint, Model, Stribeck};
use crate::pipeline::message::{self, Frame, Header};
use crate::pipeline::{Analyser, PipelineError, Sink, SinkError, Source, source};
use crate::scene::{AnalysisSpec, Events, RecordSpec, Scene, TiltedJoint};

/// An effect in a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// What it is called.
    pub name: &'static str,
    /// The table or key of a scene that calls for it.
    pub key: &'static str,
    /// Whether the scene does.
    pub on: bool,
    /// How, in words; empty where it is off.
    pub setting: String,
    /// CPU time that it takes, or would take, of a simulated second, s. Where it is less than the time
    /// scatters, about zero and of either sign.
    pub seconds: Option<f64>,
}

/// The effects of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Effects {
    /// Each of them.
    pub effects: Vec<Effect>,
    /// CPU time of a simulated second with all that is on, without the recording, s.
    pub whole: f64,
    /// Calls of the right-hand side in a simulated second.
    pub calls: f64,
    /// CPU time of a call, s.
    pub call: f64,
}

/// Why something failed.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Runs a scene with its analyses, and records it where nobody looks.
pub type Record<'a> = &'a mut dyn FnMut(&Scene) -> Result<(), Cause>;

/// Is told the share of the work that is done, and answers whether to go on.
pub type Watch<'a> = &'a mut dyn FnMut(f64) -> bool;

/// The longest stretch that is simulated, s.
const STRETCH: f64 = 0.1;

/// Runs of each setting, of which the median counts.
const REPEATS: usize = 3;

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
const USUAL_RATE: f64 = 2e3;

/// An analysis of its own table, and how to take it away.
struct Analysis {
    name: &'static str,
    table: &'static str,
    is_on: fn(&AnalysisSpec) -> bool,
    take_away: fn(&mut AnalysisSpec),
}

macro_rules! analyses {
    ($($name:literal, $field:ident;)*) => {
        [$(Analysis {
            name: $name,
            table: concat!("analysis.", stringify!($field)),
            is_on: |spec| spec.$field.is_some(),
            take_away: |spec| spec.$field = None,
        }),*]
    };
}

/// Those that look at samples.
const ANALYSES: [Analysis; 8] = analyses! {
    "spectrum", spectrum;
    "spectrogram", spectrogram;
    "delay and dimension", delay;
    "recurrence plot", recurrence;
    "recurrence quantification", quantification;
    "Poincare section", section;
    "exponent and 0-1 test of samples", chaos;
    "regime", regime;
};

/// Those that go along with the simulation.
const COMPANIONS: [Analysis; 2] = analyses! {
    "Lyapunov exponents", exponents;
    "butterfly: a second copy", butterfly;
};

/// What is recorded at a rate of its own.
struct Picture {
    name: &'static str,
    key: &'static str,
    rate: fn(&mut RecordSpec) -> &mut f64,
}

const PICTURES: [Picture; 3] = [
    Picture {
        name: "contact patch",
        key: "record.patch_rate_khz",
        rate: |spec| &mut spec.patch_rate,
    },
    Picture {
        name: "body in three dimensions",
        key: "record.body_rate_khz",
        rate: |spec| &mut spec.body_rate,
    },
    Picture {
        name: "energy and its audit",
        key: "record.energy_rate_khz",
        rate: |spec| &mut spec.energy_rate,
    },
];

/// Keeps nothing.
struct Nowhere;

impl Sink for Nowhere {
    fn accept(&mut self, _: message::Record) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Measures the effects of a scene. `None` if `watch` says no.
///
/// # Errors
/// If the scene cannot be simulated, analysed or recorded.
pub fn effects(
    scene: &Scene,
    record: Record<'_>,
    watch: Watch<'_>,
) -> Result<Option<Effects>, Cause> {
    let steps = 15.0 + (ANALYSES.len() + COMPANIONS.len()) as f64;
    let mut done = 0.0;
    let mut goes_on = || {
        done += 1.0;
        watch((done / steps).min(1.0))
    };
    let mut bare = scene.clone().without_analyses();
    bare.duration = scene.duration.min(STRETCH);
    let (frames, simulated) = timed(REPEATS, || simulate(&bare));
    let Simulated {
        header,
        frames,
        calls,
    } = frames?;
    if !goes_on() {
        return Ok(None);
    }
    let mut effects = Vec::new();
    let mut call = 0.0;
    if let Ok(tilted) = scene.joint() {
        let ball = BallJoint::new(&tilted.spec)?;
        let model = ball.model(tilted.tilt.at(0.0))?;
        let passes = Passes::new(&model, &frames);
        call = passes.time(&model);
        for (name, key, on, setting, other) in of_the_nodes(&model) {
            if !goes_on() {
                return Ok(None);
            }
            let [with, without] = match on {
                true => [call, passes.time(&other)],
                false => [passes.time(&other), call],
            };
            effects.push(Effect {
                name,
                key,
                on,
                setting,
                seconds: Some((with - without) * calls),
            });
        }
        effects.extend(functions_of_time(tilted, scene, &ball)?);
    }
    // Beside the simulation, each by itself.
    let events = scene.integrator.events == Events::Exact;
    let mut exact = bare.clone();
    exact.integrator.events = match events {
        true => Events::Through,
        false => Events::Exact,
    };
    let beside = |other: &Scene, on: bool| {
        let (ran, time) = timed(REPEATS, || simulate(other));
        ran?;
        let sign = if on { -1.0 } else { 1.0 };
        Ok::<_, Cause>(Some(sign * (time - simulated) / bare.duration))
    };
    effects.push(Effect {
        name: "steps that end at events",
        key: "time.events",
        on: events,
        setting: words(events, "exact"),
        seconds: beside(&exact, events)?,
    });
    let mut whole = simulated / bare.duration;
    for kind in COMPANIONS {
        if !goes_on() {
            return Ok(None);
        }
        let on = (kind.is_on)(&scene.analysis);
        let seconds = match added(scene, &kind) {
            None => None,
            Some(with) => {
                let mut with_it = bare.clone();
                with_it.analysis.exponents = with.analysis.exponents;
                with_it.analysis.butterfly = with.analysis.butterfly;
                for other in COMPANIONS.iter().filter(|other| other.table != kind.table) {
                    (other.take_away)(&mut with_it.analysis);
                }
                beside(&with_it, false)?
            }
        };
        if on {
            whole += seconds.unwrap_or(0.0);
        }
        effects.push(Effect {
            name: kind.name,
            key: kind.table,
            on,
            setting: words(on, "on"),
            seconds,
        });
    }
    let look = |spec: &AnalysisSpec| -> Result<f64, Cause> {
        let (ran, time) = timed(REPEATS, || analyse(spec, &header, &frames));
        ran?;
        Ok(time / bare.duration)
    };
    let mut spec = scene.analysis.clone();
    for kind in COMPANIONS {
        (kind.take_away)(&mut spec);
    }
    let all = look(&spec)?;
    whole += all;
    for kind in ANALYSES {
        if !goes_on() {
            return Ok(None);
        }
        let on = (kind.is_on)(&spec);
        let seconds = match on {
            true => {
                let mut without = spec.clone();
                (kind.take_away)(&mut without);
                // What takes its choice from it goes, too: then they cannot be told apart.
                look(&without).ok().map(|time| all - time)
            }
            false => match added(scene, &kind) {
                None => None,
                Some(with) => {
                    let mut with = with.analysis;
                    for kind in COMPANIONS {
                        (kind.take_away)(&mut with);
                    }
                    Some(look(&with)? - all)
                }
            },
        };
        effects.push(Effect {
            name: kind.name,
            key: kind.table,
            on,
            setting: words(on, "on"),
            seconds,
        });
    }
    if scene.joint().is_ok() {
        let (recorded, all) = timed(REPEATS, || record(&bare));
        recorded?;
        for kind in PICTURES {
            if !goes_on() {
                return Ok(None);
            }
            let mut other = bare.clone();
            let rate = (kind.rate)(&mut other.record);
            let (khz, on) = (1e-3 * *rate, *rate > 0.0);
            *rate = if on { 0.0 } else { USUAL_RATE };
            let (recorded, time) = timed(REPEATS, || record(&other));
            recorded?;
            let sign = if on { 1.0 } else { -1.0 };
            effects.push(Effect {
                name: kind.name,
                key: kind.key,
                on,
                setting: words(on, &format!("{khz} a ms, with the recording of it")),
                seconds: Some(sign * (all - time) / bare.duration),
            });
        }
    }
    Ok(Some(Effects {
        effects,
        whole,
        calls,
        call,
    }))
}

fn words(on: bool, setting: &str) -> String {
    match on {
        true => setting.to_owned(),
        false => String::new(),
    }
}

/// The scene with an analysis of the usual numbers, if it has not got it; `None` where its file leaves no
/// room for the table.
fn added(scene: &Scene, kind: &Analysis) -> Option<Scene> {
    if (kind.is_on)(&scene.analysis) {
        return Some(scene.clone());
    }
    let text = format!("{}\n[{}]\n", scene.text, kind.table);
    Scene::parse(&scene.name, text).ok()
}

/// The frames of a simulation.
struct Simulated {
    header: Header,
    frames: Vec<Arc<Frame>>,
    /// Calls of the right-hand side in a simulated second.
    calls: f64,
}

fn simulate(scene: &Scene) -> Result<Simulated, PipelineError> {
    let mut source = source(scene)?;
    let header = source.header("");
    let mut frames = Vec::new();
    while let Some(frame) = source.next_frame()? {
        frames.push(Arc::new(frame));
    }
    let calls = frames.last().map_or(0, |frame| frame.tally.calls);
    Ok(Simulated {
        header,
        frames,
        calls: calls as f64 / scene.duration,
    })
}

fn analyse(
    spec: &AnalysisSpec,
    header: &Header,
    frames: &[Arc<Frame>],
) -> Result<(), PipelineError> {
    let mut analyser = Analyser::new(spec, header);
    for frame in frames {
        analyser.push(frame, &mut Nowhere)?;
    }
    Ok(analyser.finish(&mut Nowhere)?)
}

/// Passes over the nodes at states of the scene's vibration.
struct Passes {
    states: Vec<Vec<f64>>,
    count: usize,
}

impl Passes {
    /// At some states of the last half of the frames.
    fn new(model: &Model, frames: &[Arc<Frame>]) -> Self {
        let modes = model.modes();
        let states = frames[frames.len() / 2..].iter().take(16).map(|frame| {
            let (q, v) = (&frame.q[..modes], &frame.qdot[..modes]);
            [q, v].concat()
        });
        Self {
            states: states.collect(),
            count: (PASSED / (model.nodes() * modes)).max(1),
        }
    }

    /// CPU time of a pass, s.
    fn time(&self, model: &Model) -> f64 {
        let joint = Joint::new(model);
        let mut out = vec![0.0; joint.dim()];
        let ((), seconds) = timed(REPEATS, || {
            for k in 0..self.count {
                let z = &self.states[k % self.states.len()];
                joint.rhs(0.0, std::hint::black_box(z), &mut out);
                std::hint::black_box(&mut out);
            }
        });
        seconds / self.count as f64
    }
}

/// An effect of the nodes: name, key, whether it is on, how, and the model with it changed.
type OfNodes = (&'static str, &'static str, bool, String, Model);

/// Effects of the nodes, each with the model without it, or with it where it is off.
fn of_the_nodes(model: &Model) -> Vec<OfNodes> {
    let friction = match model.friction {
        Friction::None => String::new(),
        Friction::Constant { law, .. } => format!("constant, mu {}", law.mu),
        Friction::Stribeck { law, .. } => format!("Stribeck, mu {} to {}", law.mu_s, law.mu_d),
    };
    let damping = match model.contact_damping {
        ContactDamping::None => String::new(),
        ContactDamping::KelvinVoigt { time } => format!("dashpots, {:.3} us", 1e6 * time),
        ContactDamping::HuntCrossley { dissipation } => {
            format!("Hunt and Crossley, {dissipation} s/m")
        }
    };
    let with_friction = |friction| Model {
        friction,
        ..model.clone()
    };
    let is_on = model.friction != Friction::None;
    let other_friction = match is_on {
        true => Friction::None,
        false => Friction::Stribeck {
            law: STRIBECK,
            radial: true,
        },
    };
    let radial = model.friction.radial();
    let mut all = vec![(
        "friction",
        "friction",
        is_on,
        friction,
        with_friction(other_friction),
    )];
    let turned = match model.friction {
        Friction::None => None,
        Friction::Constant { law, .. } => Some(Friction::Constant {
            law,
            radial: !radial,
        }),
        Friction::Stribeck { law, .. } => Some(Friction::Stribeck {
            law,
            radial: !radial,
        }),
    };
    if let Some(turned) = turned {
        all.push((
            "radial part of friction",
            "friction.radial",
            radial,
            words(radial, "as in Eq. (8)"),
            with_friction(turned),
        ));
    }
    let bonded = Model {
        unilateral: !model.unilateral,
        ..model.clone()
    };
    all.push((
        "lift-off",
        "contact.unilateral",
        model.unilateral,
        words(model.unilateral, "Eq. (2)"),
        bonded,
    ));
    let damped = !model.contact_damping.is_none();
    let other = Model {
        contact_damping: match damped {
            true => ContactDamping::None,
            false => ContactDamping::HuntCrossley {
                dissipation: DISSIPATION,
            },
        },
        ..model.clone()
    };
    all.push((
        "damping of the contact",
        "contact_damping",
        damped,
        damping,
        other,
    ));
    let convected = model.convection.is_some();
    let other = Model {
        convection: match convected {
            true => None,
            false => Some([1.0, 0.0, 0.0]),
        },
        ..model.clone()
    };
    all.push((
        "Omega x u",
        "rotation.convection",
        convected,
        words(convected, "on"),
        other,
    ));
    let has_damping = model.damping.iter().any(|ratio| *ratio != 0.0);
    let other = Model {
        damping: match has_damping {
            true => Vec::new(),
            false => vec![DAMPING_RATIO; model.modes()],
        },
        ..model.clone()
    };
    let most = model.damping.iter().copied().fold(0.0, f64::max);
    all.push((
        "modal damping",
        "damping",
        has_damping,
        words(has_damping, &format!("ratio up to {most}")),
        other,
    ));
    all
}

/// What it takes to make the joint anew at each frame's border, which is where functions of time are looked
/// at.
fn functions_of_time(
    joint: &TiltedJoint,
    scene: &Scene,
    ball: &BallJoint,
) -> Result<Vec<Effect>, PipelineError> {
    let (made, seconds) = timed(REPEATS, || {
        ball.model(joint.tilt.at(0.0)).map(|m| Joint::new(&m))
    });
    made?;
    let frames = scene.sample_rate / scene.frame_samples as f64;
    let span = |[low, high]: [f64; 2], unit: &str| format!("{low:.4} to {high:.4}{unit}");
    let degrees = [joint.tilt.min(), joint.tilt.max()].map(f64::to_degrees);
    let courses = [
        (
            "tilt as a function of time",
            "load.tilt",
            joint.tilt.varies(),
            span(degrees, "°"),
        ),
        (
            "load as a function of time",
            "load.load",
            joint.load.is_some(),
            span(joint.load_span(), " N"),
        ),
        (
            "rotation as a function of time",
            "rotation.factor",
            joint.rotation.is_some(),
            span(joint.rotation_span(), " times"),
        ),
    ];
    // Together they cost as much as one of them.
    let all = courses.map(|(name, key, on, setting)| Effect {
        name,
        key,
        on,
        setting: words(on, &setting),
        seconds: Some(seconds * frames),
    });
    Ok(all.into())
}
