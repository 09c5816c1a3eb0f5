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
mod effect;
mod joint;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::Serialize;

use bench::{Bench, Rounds, timed};
pub use bench::{Cause, Measured};
use effect::words;
pub use effect::{Effect, Untold};
use joint::of_the_joint;

use crate::pipeline::message::{self, Frame, Header};
use crate::pipeline::{Analyser, PipelineError, Sink, SinkError, Source, source};
use crate::scene::{AnalysisSpec, Events, RecordSpec, Scene};
use crate::study::Watch;

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

/// Runs a scene with its analyses, and records it where nobody looks.
pub type Record<'a> = &'a mut dyn FnMut(&Scene) -> Result<(), Cause>;

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

/// Measures the effects of a scene; `stop` is heeded within runs, too. `None` if `watch`, which is told the share
/// of the work that is done, says no.
///
/// # Errors
/// If the scene cannot be simulated, analysed or recorded.
pub fn effects(
    scene: &Scene,
    record: Record<'_>,
    stop: &Arc<AtomicBool>,
    watch: Watch<'_, f64>,
) -> Result<Option<Effects>, Cause> {
    let bare = bare(scene);
    let mut bench = Bench { watch, stage: 0.0 };
    if !bench.goes_on(0.0) {
        return Ok(None);
    }
    let Some(simulated) = of_the_simulation(scene, &bare, stop, &mut bench)? else {
        return Ok(None);
    };
    let (mut all, mut call) = (Vec::new(), 0.0);
    if let Ok(tilted) = scene.joint() {
        let Simulated { frames, calls, .. } = &simulated.one;
        let Some(found) = of_the_joint(scene, tilted, frames, *calls, &mut bench)? else {
            return Ok(None);
        };
        (call, all) = found;
    }
    all.extend(simulated.effects);
    let Some((seconds, found)) = of_the_samples(scene, &bare, &simulated.one, &mut bench)? else {
        return Ok(None);
    };
    all.extend(found);
    if scene.joint().is_ok() {
        let Some(found) = of_the_pictures(&bare, record, &mut bench)? else {
            return Ok(None);
        };
        all.extend(found);
    }
    Ok(Some(Effects {
        effects: all,
        whole: simulated.seconds + seconds,
        setup: simulated.setup,
        calls: simulated.one.calls,
        call,
    }))
}

/// What the simulation takes, and what goes along with it.
struct OfTheSimulation {
    /// The bare scene, simulated.
    one: Simulated,
    effects: Vec<Effect>,
    /// CPU time of a simulated second with all of them that are on, s.
    seconds: f64,
    /// CPU time until the first sample, s.
    setup: f64,
}

/// The effects beside the simulation, each by itself. `None` if it was told to stop.
fn of_the_simulation(
    scene: &Scene,
    bare: &Scene,
    stop: &Arc<AtomicBool>,
    bench: &mut Bench<'_>,
) -> Result<Option<OfTheSimulation>, Cause> {
    let exact = scene.integrator.events == Events::Exact;
    let mut variants = vec![bare.clone(), bare.clone()];
    variants[1].integrator.events = match exact {
        true => Events::Through,
        false => Events::Exact,
    };
    let companions = COMPANIONS.map(|kind| {
        variants.push(beside(scene, bare, &kind)?);
        Ok(variants.len() - 1)
    });
    let (mut simulated, mut setups) = (None, Vec::new());
    let runs = bench.rounds(variants.len(), &mut |variant| {
        let (source, setup) = timed(|| source(&variants[variant]));
        let source = source?;
        let (ran, seconds) = timed(|| simulate(source, bare.duration, stop));
        let ran = ran?;
        if variant == 0 {
            setups.push(setup);
            simulated = Some(ran);
        }
        Ok(seconds / bare.duration)
    })?;
    let (Some(runs), Some(simulated)) = (runs, simulated) else {
        return Ok(None);
    };
    let mut effects = vec![Effect {
        name: "steps that end at events",
        key: "time.events",
        on: exact,
        setting: words(exact, "exact"),
        cost: Ok(runs.effect(exact, 0, 1)),
        setup: None,
    }];
    let mut seconds = runs.of(0).mean;
    for (kind, variant) in COMPANIONS.iter().zip(companions) {
        let on = (kind.is_on)(&scene.analysis);
        let cost = variant.map(|variant| runs.difference(variant, 0));
        if on {
            seconds += cost.map_or(0.0, |cost| cost.mean);
        }
        effects.push(kind.effect(on, cost));
    }
    Ok(Some(OfTheSimulation {
        one: simulated,
        effects,
        seconds,
        // The first one found the caches cold, as that of a run does.
        setup: setups.first().copied().unwrap_or(0.0),
    }))
}

/// The bare scene with one companion.
fn beside(scene: &Scene, bare: &Scene, kind: &Analysis) -> Result<Scene, Untold> {
    let mut beside = Scene {
        analysis: added(scene, kind).ok_or(Untold::NoRoom)?.analysis,
        ..bare.clone()
    };
    if (kind.window)(&beside.analysis).is_some_and(|window| window > bare.duration) {
        return Err(Untold::ShorterThanWindow);
    }
    let others = COMPANIONS.iter().chain(&ANALYSES);
    for other in others.filter(|other| other.table != kind.table) {
        (other.take_away)(&mut beside.analysis);
    }
    Ok(beside)
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
    Simulated { header, frames, .. }: &Simulated,
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
        let cost = place.map(|other| rounds.effect(on, 0, other));
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
        effects.push(Effect {
            name: kind.name,
            key: kind.key,
            on,
            setting: words(on, &format!("{khz} a ms, with the recording of it")),
            cost: match bare.duration < SHORTEST {
                true => Err(Untold::TooShort),
                false => Ok(steady.effect(on, 0, k + 1)),
            },
            setup: Some(once.effect(on, 0, k + 1)).filter(|once| once.is_told() && once.mean > 0.0),
        });
    }
    Ok(Some(effects))
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
