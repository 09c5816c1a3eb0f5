//! Which effects a scene calls for, and what each costs in it: measured, not told.
//!
//! An effect is taken away where it is on, and added where it is off, and the same work is timed with and
//! without it: passes over the contact nodes at a state of the scene's own vibration, the simulation from
//! its start, the analyses on the frames of that simulation, the recording. What is off costs nothing; what
//! is told of it is what it would cost.
//!
//! Work with and work without take turns, round after round, so that a machine that slows down slows down both;
//! what is told is the mean of the differences, and the half-width of its interval of 95 %. What is done once,
//! before the first sample, is not part of the cost of a simulated second, and is told apart.

mod bench;
mod joint;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::{Serialize, Serializer};

pub use bench::Measured;
use bench::{Bench, Rounds, timed};
use joint::of_the_joint;

use crate::pipeline::message::{self, Frame, Header};
use crate::pipeline::{Analyser, PipelineError, Sink, SinkError, Source, source};
use crate::scene::{AnalysisSpec, Events, RecordSpec, Scene};

/// An effect in a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effect {
    /// What it is called.
    pub name: &'static str,
    /// The table or key of a scene that calls for it.
    pub key: &'static str,
    /// Whether the scene does.
    pub on: bool,
    /// How, in words; empty where it is off.
    pub setting: String,
    /// CPU time that it takes, or would take, of a simulated second, s; or why that cannot be told.
    #[serde(flatten, serialize_with = "cost_or_reason")]
    pub cost: Result<Measured, Untold>,
    /// CPU time that it takes once, before the first sample, s; `None` where it takes none worth telling.
    #[serde(rename = "setup_s")]
    pub setup: Option<Measured>,
}

/// The cost, or why it cannot be told, as JSON has it.
fn cost_or_reason<S: Serializer>(
    cost: &Result<Measured, Untold>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Record {
        cpu_s_per_s: Option<Measured>,
        untold: Option<String>,
    }
    let record = Record {
        cpu_s_per_s: cost.ok(),
        untold: cost.err().map(|why| why.to_string()),
    };
    record.serialize(serializer)
}

/// Why the cost of an effect cannot be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Untold {
    /// Nothing comes of it in a run this short.
    #[error("the run is shorter than its window")]
    ShorterThanWindow,
    /// What a recording takes once is far more than what so short a run takes.
    #[error("the run is too short to tell")]
    TooShort,
    /// The scene's file leaves no room for its table.
    #[error("its table cannot be added to this scene")]
    NoRoom,
    /// Others take their choices from it.
    #[error("others take their choices from it")]
    Needed,
}

/// The effects of a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effects {
    /// Each of them.
    pub effects: Vec<Effect>,
    /// CPU time of a simulated second with all that is on, without the recording, s.
    #[serde(rename = "cpu_s_per_s")]
    pub whole: f64,
    /// CPU time until the first sample, without the recording, s.
    #[serde(rename = "setup_s")]
    pub setup: f64,
    /// Calls of the right-hand side in a simulated second.
    #[serde(rename = "calls_per_s")]
    pub calls: f64,
    /// CPU time of a call, s.
    #[serde(rename = "call_s")]
    pub call: f64,
}

/// Why something failed.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Runs a scene with its analyses, and records it where nobody looks.
pub type Record<'a> = &'a mut dyn FnMut(&Scene) -> Result<(), Cause>;

/// Is told the share of the work that is done, and answers whether to go on.
pub type Watch<'a> = &'a mut dyn FnMut(f64) -> bool;

/// The longest stretch that is simulated, s, where no window is longer.
const STRETCH: f64 = 0.1;

/// The longest stretch over the longest window of what is on.
const WINDOWS: f64 = 1.5;

/// A recording that is this part of another tells what both take once.
const SHORT: f64 = 0.125;

/// The shortest run whose recording is measured, s.
const SHORTEST: f64 = 5e-3;

/// The rate of a picture that is off, Hz.
const USUAL_RATE: f64 = 2e3;

/// An analysis of its own table, and how to take it away.
struct Analysis {
    name: &'static str,
    table: &'static str,
    is_on: fn(&AnalysisSpec) -> bool,
    take_away: fn(&mut AnalysisSpec),
    /// How long it takes until something comes of it, s.
    window: fn(&AnalysisSpec) -> Option<f64>,
}

macro_rules! analyses {
    ($($name:literal, $field:ident, $window:expr;)*) => {
        [$(Analysis {
            name: $name,
            table: concat!("analysis.", stringify!($field)),
            is_on: |spec| spec.$field.is_some(),
            take_away: |spec| spec.$field = None,
            window: |spec| spec.$field.as_ref().map($window),
        }),*]
    };
}

/// Those that look at samples.
const ANALYSES: [Analysis; 8] = analyses! {
    "spectrum", spectrum, |of| of.sliding.window;
    "spectrogram", spectrogram, |of| of.sliding.window;
    "delay and dimension", delay, |of| of.sliding.window;
    "recurrence plot", recurrence, |of| of.sliding.window;
    "recurrence quantification", quantification, |of| of.sliding.window;
    "Poincare section", section, |of| of.every;
    "exponent and 0-1 test of samples", chaos, |of| of.sliding.window;
    "regime", regime, |of| of.sliding.window;
};

/// Those that go along with the simulation.
const COMPANIONS: [Analysis; 2] = analyses! {
    "Lyapunov exponents", exponents, |of| of.settle + of.every;
    "butterfly: a second copy", butterfly, |of| of.start + of.every;
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

/// Measures the effects of a scene; `stop` is heeded within runs, too. `None` if `watch` says no.
///
/// # Errors
/// If the scene cannot be simulated, analysed or recorded.
pub fn effects(
    scene: &Scene,
    record: Record<'_>,
    stop: &Arc<AtomicBool>,
    watch: Watch<'_>,
) -> Result<Option<Effects>, Cause> {
    let bare = bare(scene);
    let mut bench = Bench { watch, stage: 0.0 };
    if !bench.goes_on(0.0) {
        return Ok(None);
    }
    // Beside the simulation, each by itself.
    let events = scene.integrator.events == Events::Exact;
    let mut variants = vec![bare.clone(), bare.clone()];
    variants[1].integrator.events = match events {
        true => Events::Through,
        false => Events::Exact,
    };
    let companions = COMPANIONS.map(|kind| {
        let with = added(scene, &kind).ok_or(Untold::NoRoom)?;
        if (kind.window)(&with.analysis).is_some_and(|window| window > bare.duration) {
            return Err(Untold::ShorterThanWindow);
        }
        let mut beside = bare.clone();
        beside.analysis = with.analysis;
        for other in COMPANIONS.iter().filter(|other| other.table != kind.table) {
            (other.take_away)(&mut beside.analysis);
        }
        for other in ANALYSES {
            (other.take_away)(&mut beside.analysis);
        }
        variants.push(beside);
        Ok(variants.len() - 1)
    });
    let (mut simulated, mut setups) = (None, Vec::new());
    let runs = bench.rounds(variants.len(), &mut |variant| {
        let (source, setup) = timed(|| source(&variants[variant]));
        let source = source?;
        let (ran, seconds) = timed(|| simulate(source, bare.duration, stop));
        if variant == 0 {
            setups.push(setup);
            simulated = Some(ran?);
        } else {
            ran?;
        }
        Ok(seconds / bare.duration)
    })?;
    let (Some(runs), Some(simulated)) = (runs, simulated) else {
        return Ok(None);
    };
    let Simulated {
        header,
        frames,
        calls,
    } = simulated;
    let mut beside = vec![Effect {
        name: "steps that end at events",
        key: "time.events",
        on: events,
        setting: words(events, "exact"),
        cost: Ok(match events {
            true => runs.difference(0, 1),
            false => runs.difference(1, 0),
        }),
        setup: None,
    }];
    let mut whole = runs.of(0).mean;
    for (kind, variant) in COMPANIONS.iter().zip(companions) {
        let on = (kind.is_on)(&scene.analysis);
        let cost = variant.map(|variant| runs.difference(variant, 0));
        if on {
            whole += cost.map_or(0.0, |cost| cost.mean);
        }
        beside.push(kind.effect(on, cost));
    }

    let (mut all, mut call) = (Vec::new(), 0.0);
    if let Ok(tilted) = scene.joint() {
        let Some((of_a_call, found)) = of_the_joint(scene, tilted, &frames, calls, &mut bench)?
        else {
            return Ok(None);
        };
        (call, all) = (of_a_call, found);
    }
    all.extend(beside);

    let Some((seconds, found)) = of_the_samples(scene, &bare, &header, &frames, &mut bench)? else {
        return Ok(None);
    };
    whole += seconds;
    all.extend(found);
    if scene.joint().is_ok() {
        let Some(found) = of_the_pictures(&bare, record, &mut bench)? else {
            return Ok(None);
        };
        all.extend(found);
    }
    Ok(Some(Effects {
        effects: all,
        whole,
        // The first one found the caches cold, as that of a run does.
        setup: setups.first().copied().unwrap_or(0.0),
        calls,
        call,
    }))
}

/// The scene without analyses, as long as it takes to measure it.
fn bare(scene: &Scene) -> Scene {
    let spec = &scene.analysis;
    let windows = ANALYSES
        .iter()
        .chain(&COMPANIONS)
        .filter_map(|kind| (kind.window)(spec));
    let longest = windows
        .filter(|window| *window <= scene.duration)
        .fold(0.0, f64::max);
    let mut bare = scene.clone().without_analyses();
    bare.duration = scene.duration.min(STRETCH.max(WINDOWS * longest));
    bare
}

impl Analysis {
    fn effect(&self, on: bool, cost: Result<Measured, Untold>) -> Effect {
        Effect {
            name: self.name,
            key: self.table,
            on,
            setting: words(on, "on"),
            cost,
            setup: None,
        }
    }
}

/// CPU time of the analyses of samples that are on, of a simulated second (s), and the effect of each. `None` if
/// it was told to stop.
fn of_the_samples(
    scene: &Scene,
    bare: &Scene,
    header: &Header,
    frames: &[Arc<Frame>],
    bench: &mut Bench<'_>,
) -> Result<Option<(f64, Vec<Effect>)>, Cause> {
    let of_samples = |mut spec: AnalysisSpec| {
        for kind in COMPANIONS {
            (kind.take_away)(&mut spec);
        }
        spec
    };
    let spec = of_samples(scene.analysis.clone());
    let mut variants = vec![spec.clone()];
    let places = ANALYSES.map(|kind| {
        let other = match (kind.is_on)(&spec) {
            true => {
                let mut without = spec.clone();
                (kind.take_away)(&mut without);
                without
            }
            false => of_samples(added(scene, &kind).ok_or(Untold::NoRoom)?.analysis),
        };
        let window = (kind.window)(&spec).or_else(|| (kind.window)(&other));
        if window.is_some_and(|window| window > bare.duration) {
            return Err(Untold::ShorterThanWindow);
        }
        // What takes its choice from it goes, too: then they cannot be told apart.
        analyse(&other, header, &frames[..1]).map_err(|_| Untold::Needed)?;
        variants.push(other);
        Ok(variants.len() - 1)
    });
    let rounds = bench.rounds(variants.len(), &mut |variant| {
        let (ran, seconds) = timed(|| analyse(&variants[variant], header, frames));
        ran?;
        Ok(seconds / bare.duration)
    })?;
    let Some(rounds) = rounds else {
        return Ok(None);
    };
    let effects = ANALYSES.iter().zip(places).map(|(kind, place)| {
        let on = (kind.is_on)(&spec);
        let cost = place.map(|other| match on {
            true => rounds.difference(0, other),
            false => rounds.difference(other, 0),
        });
        kind.effect(on, cost)
    });
    Ok(Some((rounds.of(0).mean, effects.collect())))
}

/// The effects of what is recorded at rates of its own. `None` if it was told to stop.
fn of_the_pictures(
    bare: &Scene,
    record: Record<'_>,
    bench: &mut Bench<'_>,
) -> Result<Option<Vec<Effect>>, Cause> {
    let mut variants = vec![bare.clone()];
    for kind in PICTURES {
        let mut other = bare.clone();
        let rate = (kind.rate)(&mut other.record);
        *rate = if *rate > 0.0 { 0.0 } else { USUAL_RATE };
        variants.push(other);
    }
    // A short run and a whole one tell what is done once from what each second takes.
    let short = variants.iter().map(|whole| Scene {
        duration: SHORT * bare.duration,
        ..whole.clone()
    });
    let short: Vec<Scene> = short.collect();
    let count = variants.len();
    variants.extend(short);
    let rounds = bench.rounds(variants.len(), &mut |variant| {
        let (recorded, seconds) = timed(|| record(&variants[variant]));
        recorded?;
        Ok(seconds)
    })?;
    let Some(Rounds(taken)) = rounds else {
        return Ok(None);
    };
    // What a variant takes of a simulated second, and once.
    let (mut steady, mut once) = (Vec::new(), Vec::new());
    for (whole, short) in taken.iter().zip(&taken[count..]) {
        let pairs = || whole.iter().zip(short);
        let rate = |(whole, short): (&f64, &f64)| (whole - short) / ((1.0 - SHORT) * bare.duration);
        steady.push(pairs().map(rate).collect());
        once.push(
            pairs()
                .map(|pair| pair.1 - SHORT * bare.duration * rate(pair))
                .collect(),
        );
    }
    let (steady, once) = (Rounds(steady), Rounds(once));
    let mut effects = Vec::new();
    for (k, kind) in PICTURES.iter().enumerate() {
        let mut spec = bare.record;
        let khz = 1e-3 * *(kind.rate)(&mut spec);
        let on = khz > 0.0;
        let (with, without) = match on {
            true => (0, k + 1),
            false => (k + 1, 0),
        };
        effects.push(Effect {
            name: kind.name,
            key: kind.key,
            on,
            setting: words(on, &format!("{khz} a ms, with the recording of it")),
            cost: match bare.duration < SHORTEST {
                true => Err(Untold::TooShort),
                false => Ok(steady.difference(with, without)),
            },
            setup: Some(once.difference(with, without))
                .filter(|once| once.is_told() && once.mean > 0.0),
        });
    }
    Ok(Some(effects))
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

/// Runs to the end, or until told to stop; `duration` is that of the run, s.
fn simulate(
    mut source: impl Source,
    duration: f64,
    stop: &Arc<AtomicBool>,
) -> Result<Simulated, PipelineError> {
    source.heed(stop);
    let header = source.header("");
    let mut frames = Vec::new();
    while let Some(frame) = source.next_frame()? {
        frames.push(Arc::new(frame));
    }
    let calls = frames.last().map_or(0, |frame| frame.tally.calls);
    Ok(Simulated {
        header,
        frames,
        calls: calls as f64 / duration,
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
