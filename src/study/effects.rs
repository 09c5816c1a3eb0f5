//! Measured cost of each effect of a scene.
//!
//! An active effect is removed and an inactive one is added; the same work is timed with and without it. The
//! work is evaluations of the right-hand side at states of the scene's own vibration, the simulation from its
//! start, the analyses of that simulation's frames, or the recording. An inactive effect is not computed; its
//! reported cost is what it would add.
//!
//! Runs with and without an effect alternate in rounds, so that a machine that slows down affects both
//! alike. The result is the mean difference and the half-width of its 95 % interval. Setup before the first
//! sample is not part of the cost per simulated second and is reported separately.

mod bench;
mod effect;
mod joint;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};

use bench::{Bench, Rounds, timed};
pub use bench::{Cause, Measured};
use effect::setting_text;
pub use effect::{Effect, Unavailable};
use joint::joint_effects;

use crate::pipeline::message::{self, Frame, Header};
use crate::pipeline::{Analyser, PipelineError, Sink, SinkError, Source, source};
use crate::scene::{AnalysisSpec, Events, RecordSpec, Scene};
use crate::study::OnProgress;

/// Cost of the effects of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Effects {
    /// The effects, active and inactive.
    pub effects: Vec<Effect>,
    /// CPU time per simulated second with all active effects, without the recording, s/s.
    #[serde(rename = "cpu_s_per_s")]
    pub whole: f64,
    /// Setup: CPU time before the first sample, without the recording, s.
    #[serde(rename = "setup_s")]
    pub setup: f64,
    /// Right-hand-side evaluations per simulated second, 1/s.
    #[serde(rename = "rhs_evals_per_s")]
    pub rhs_evals: f64,
    /// CPU time of one right-hand-side evaluation, s.
    #[serde(rename = "rhs_eval_s")]
    pub rhs_eval: f64,
}

/// Function that makes the record of a scene: it runs the scene with its analyses, and discards the
/// recording.
pub type Record<'a> = &'a mut dyn FnMut(&Scene) -> Result<(), Cause>;

/// Maximum simulated time, s, unless an analysis window is longer.
const MAX_TIME: f64 = 0.1;

/// Simulated time relative to the longest active analysis window.
const WINDOW_FACTOR: f64 = 1.5;

/// Length of the short recording relative to the full one; the two separate setup cost from running cost.
const SHORT_SHARE: f64 = 0.125;

/// Minimum simulated time for measuring a recording, s.
const MIN_TIME: f64 = 5e-3;

/// Recording rate used for an inactive picture, Hz.
const DEFAULT_RATE: f64 = 2e3;

/// An analysis with its own table in the scene, and how to remove it.
struct Analysis {
    name: &'static str,
    table: &'static str,
    is_on: fn(&AnalysisSpec) -> bool,
    remove: fn(&mut AnalysisSpec),
    /// Window length before the first result, s.
    window: fn(&AnalysisSpec) -> Option<f64>,
}

macro_rules! analyses {
    ($($name:literal, $field:ident, $window:expr;)*) => {
        [$(Analysis {
            name: $name,
            table: concat!("analysis.", stringify!($field)),
            is_on: |spec| spec.$field.is_some(),
            remove: |spec| spec.$field = None,
            window: |spec| spec.$field.as_ref().map($window),
        }),*]
    };
}

/// Analyses of the samples.
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

/// Analyses that are integrated together with the state.
const COMPANIONS: [Analysis; 2] = analyses! {
    "Lyapunov exponents", exponents, |of| of.settle + of.every;
    "perturbed trajectory", perturbed_trajectory, |of| of.start + of.every;
};

/// A part of the recording with its own rate.
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

/// A sink that discards everything.
struct NullSink;

impl Sink for NullSink {
    fn accept(&mut self, _: message::Record) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Measures the effects of a scene. `stop` also ends a run in progress. `watch` receives the fraction of the
/// work done; the result is `None` if it returns `false`.
///
/// # Errors
/// If the scene cannot be simulated, analysed or recorded.
pub fn effects(
    scene: &Scene,
    record: Record<'_>,
    stop: &Arc<AtomicBool>,
    watch: OnProgress<'_, f64>,
) -> Result<Option<Effects>, Cause> {
    let base = base_scene(scene);
    let mut bench = Bench { watch, stage: 0.0 };
    if !bench.should_continue(0.0) {
        return Ok(None);
    }
    let Some(simulated) = simulation_effects(scene, &base, stop, &mut bench)? else {
        return Ok(None);
    };
    let (mut all, mut rhs_eval) = (Vec::new(), 0.0);
    if let Ok(tilted) = scene.joint() {
        let Simulated { frames, calls, .. } = &simulated.one;
        let Some(found) = joint_effects(scene, tilted, frames, *calls, &mut bench)? else {
            return Ok(None);
        };
        (rhs_eval, all) = found;
    }
    all.extend(simulated.effects);
    let Some((seconds, found)) = analysis_effects(scene, &base, &simulated.one, &mut bench)? else {
        return Ok(None);
    };
    all.extend(found);
    if scene.joint().is_ok() {
        let Some(found) = recording_effects(&base, record, &mut bench)? else {
            return Ok(None);
        };
        all.extend(found);
    }
    Ok(Some(Effects {
        effects: all,
        whole: simulated.seconds + seconds,
        setup: simulated.setup,
        rhs_evals: simulated.one.calls,
        rhs_eval,
    }))
}

/// Cost of the simulation and of the analyses integrated with it.
struct SimulationEffects {
    /// The simulated base scene.
    one: Simulated,
    effects: Vec<Effect>,
    /// CPU time per simulated second with all active effects, s/s.
    seconds: f64,
    /// CPU time before the first sample, s.
    setup: f64,
}

/// Measures the event location and each analysis integrated with the state, one at a time; `None` if stopped.
fn simulation_effects(
    scene: &Scene,
    base: &Scene,
    stop: &Arc<AtomicBool>,
    bench: &mut Bench<'_>,
) -> Result<Option<SimulationEffects>, Cause> {
    let exact = scene.integrator.events == Events::Exact;
    let mut variants = vec![base.clone(), base.clone()];
    variants[1].integrator.events = match exact {
        true => Events::Through,
        false => Events::Exact,
    };
    let companions = COMPANIONS.map(|kind| {
        variants.push(with_companion(scene, base, &kind)?);
        Ok(variants.len() - 1)
    });
    let (mut simulated, mut setups) = (None, Vec::new());
    let runs = bench.rounds(variants.len(), &mut |variant| {
        let (source, setup) = timed(|| source(&variants[variant]));
        let source = source?;
        let (ran, seconds) = timed(|| simulate(source, base.duration, stop));
        let ran = ran?;
        if variant == 0 {
            setups.push(setup);
            simulated = Some(ran);
        }
        Ok(seconds / base.duration)
    })?;
    let (Some(runs), Some(simulated)) = (runs, simulated) else {
        return Ok(None);
    };
    let mut effects = vec![Effect {
        name: "exact event location".into(),
        key: "time.events".into(),
        on: exact,
        setting: setting_text(exact, "exact"),
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
    Ok(Some(SimulationEffects {
        one: simulated,
        effects,
        seconds,
        // The first setup runs with cold caches, like the setup of a normal run.
        setup: setups.first().copied().unwrap_or(0.0),
    }))
}

/// The base scene with one analysis that is integrated with the state.
fn with_companion(scene: &Scene, base: &Scene, kind: &Analysis) -> Result<Scene, Unavailable> {
    let mut with_one = Scene {
        analysis: with_analysis(scene, kind)
            .ok_or(Unavailable::CannotAdd)?
            .analysis,
        ..base.clone()
    };
    if (kind.window)(&with_one.analysis).is_some_and(|window| window > base.duration) {
        return Err(Unavailable::ShorterThanWindow);
    }
    let others = COMPANIONS.iter().chain(&ANALYSES);
    for other in others.filter(|other| other.table != kind.table) {
        (other.remove)(&mut with_one.analysis);
    }
    Ok(with_one)
}

/// The base scene: without analyses, and as long as the measurement needs.
fn base_scene(scene: &Scene) -> Scene {
    let spec = &scene.analysis;
    let windows = ANALYSES
        .iter()
        .chain(&COMPANIONS)
        .filter_map(|kind| (kind.window)(spec));
    let longest = windows
        .filter(|window| *window <= scene.duration)
        .fold(0.0, f64::max);
    let mut base = scene.clone().without_analyses();
    base.duration = scene.duration.min(MAX_TIME.max(WINDOW_FACTOR * longest));
    base
}

impl Analysis {
    fn effect(&self, on: bool, cost: Result<Measured, Unavailable>) -> Effect {
        Effect {
            name: self.name.into(),
            key: self.table.into(),
            on,
            setting: setting_text(on, "on"),
            cost,
            setup: None,
        }
    }
}

/// CPU time per simulated second of the active analyses of samples, s/s, and the effect of each; `None` if
/// stopped.
fn analysis_effects(
    scene: &Scene,
    base: &Scene,
    Simulated { header, frames, .. }: &Simulated,
    bench: &mut Bench<'_>,
) -> Result<Option<(f64, Vec<Effect>)>, Cause> {
    let of_samples = |mut spec: AnalysisSpec| {
        for kind in COMPANIONS {
            (kind.remove)(&mut spec);
        }
        spec
    };
    let spec = of_samples(scene.analysis.clone());
    let mut variants = vec![spec.clone()];
    let places = ANALYSES.map(|kind| {
        let other = match (kind.is_on)(&spec) {
            true => {
                let mut without = spec.clone();
                (kind.remove)(&mut without);
                without
            }
            false => of_samples(
                with_analysis(scene, &kind)
                    .ok_or(Unavailable::CannotAdd)?
                    .analysis,
            ),
        };
        let window = (kind.window)(&spec).or_else(|| (kind.window)(&other));
        if window.is_some_and(|window| window > base.duration) {
            return Err(Unavailable::ShorterThanWindow);
        }
        // Analyses that depend on it would be removed as well, so its own cost cannot be measured.
        analyse(&other, header, &frames[..1]).map_err(|_| Unavailable::Needed)?;
        variants.push(other);
        Ok(variants.len() - 1)
    });
    let rounds = bench.rounds(variants.len(), &mut |variant| {
        let (ran, seconds) = timed(|| analyse(&variants[variant], header, frames));
        ran?;
        Ok(seconds / base.duration)
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

/// Effects of the parts of the recording with their own rates; `None` if stopped.
fn recording_effects(
    base: &Scene,
    record: Record<'_>,
    bench: &mut Bench<'_>,
) -> Result<Option<Vec<Effect>>, Cause> {
    let mut variants = vec![base.clone()];
    for kind in PICTURES {
        let mut other = base.clone();
        let rate = (kind.rate)(&mut other.record);
        *rate = if *rate > 0.0 { 0.0 } else { DEFAULT_RATE };
        variants.push(other);
    }
    // A short and a full run separate the setup cost from the cost per second.
    let short = variants.iter().map(|whole| Scene {
        duration: SHORT_SHARE * base.duration,
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
    // Cost of each variant: per simulated second, and once.
    let (mut steady, mut once) = (Vec::new(), Vec::new());
    for (whole, short) in taken.iter().zip(&taken[count..]) {
        let pairs = || whole.iter().zip(short);
        let rate =
            |(whole, short): (&f64, &f64)| (whole - short) / ((1.0 - SHORT_SHARE) * base.duration);
        steady.push(pairs().map(rate).collect());
        once.push(
            pairs()
                .map(|pair| pair.1 - SHORT_SHARE * base.duration * rate(pair))
                .collect(),
        );
    }
    let (steady, once) = (Rounds(steady), Rounds(once));
    let mut effects = Vec::new();
    for (k, kind) in PICTURES.iter().enumerate() {
        let mut spec = base.record;
        let khz = 1e-3 * *(kind.rate)(&mut spec);
        let on = khz > 0.0;
        effects.push(Effect {
            name: kind.name.into(),
            key: kind.key.into(),
            on,
            setting: setting_text(on, &format!("{khz} kHz, including its recording")),
            cost: match base.duration < MIN_TIME {
                true => Err(Unavailable::TooShort),
                false => Ok(steady.effect(on, 0, k + 1)),
            },
            setup: Some(once.effect(on, 0, k + 1))
                .filter(|once| once.is_significant() && once.mean > 0.0),
        });
    }
    Ok(Some(effects))
}

/// The scene with an analysis at its default settings, if it does not have it already; `None` if the table
/// cannot be added to its file.
fn with_analysis(scene: &Scene, kind: &Analysis) -> Option<Scene> {
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
    /// Right-hand-side evaluations per simulated second, 1/s.
    calls: f64,
}

/// Runs to the end, or until stopped; `duration` is the length of the run, s.
fn simulate(
    mut source: impl Source,
    duration: f64,
    stop: &Arc<AtomicBool>,
) -> Result<Simulated, PipelineError> {
    source.set_stop_flag(stop);
    let header = source.header("");
    let mut frames = Vec::new();
    while let Some(frame) = source.next_frame()? {
        frames.push(Arc::new(frame));
    }
    let calls = frames.last().map_or(0, |frame| frame.stats.rhs_evals);
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
        analyser.push(frame, &mut NullSink)?;
    }
    Ok(analyser.finish(&mut NullSink)?)
}
