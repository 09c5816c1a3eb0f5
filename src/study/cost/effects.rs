//! The price of each effect that a scene has on, and what it changes.
//!
//! An effect is switched off by an override of the scene. One whose override changes nothing is off already; it costs
//! nothing and is not listed. Runs with and without an effect alternate, so that disturbances of the machine affect both
//! alike.

use std::sync::Arc;

use cpu_time::ProcessTime;
use schemars::JsonSchema;
use serde::Serialize;

use super::Cost;
use super::motion::{Motion, REPEATS, Runner};
use crate::chain_of_causes;
use crate::joint::{Friction, FrictionTable};
use crate::pipeline::message::{Frame, Header, Record};
use crate::pipeline::{Analyser, PipelineError, Simulation, Source as _};
use crate::scene::{AnalysisSpec, Scene};
use crate::study::StudyError;

/// Function that runs a scene with its analyses and its recording, and discards the results.
pub type RunAll<'a> =
    &'a mut dyn FnMut(&Scene) -> Result<(), Box<dyn std::error::Error + Send + Sync>>;

/// Longest simulated time of a timed run, s.
const LONGEST: f64 = 0.2;

/// Smallest price that counts in a noisy measurement, relative to the time of the run.
const NOISE: f64 = 0.01;

/// Part of a run that an effect belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The equations of motion: the effect changes the motion.
    Motion,
    /// Integrated with the state, which it does not change.
    Companion,
    Analysis,
    Recording,
}

/// The name of each effect and its key.
const EFFECTS: [[&str; 2]; 21] = [
    ["radial part of friction", "friction.radial"],
    ["separation of nodes", "contact.unilateral"],
    ["rotation term Omega x u", "rotation.convection"],
    ["moving patch", "rotation.moves_patch"],
    ["contact damping", "contact_damping"],
    ["modal damping", "damping"],
    ["stiffness of nodes", "contact.stiffness_distribution"],
    ["exact events", "time.events"],
    ["Lyapunov exponents", "analysis.lyapunov"],
    ["perturbed trajectory", "analysis.perturbed_trajectory"],
    ["spectrum", "analysis.spectrum"],
    ["spectrogram", "analysis.spectrogram"],
    ["delay and dimension", "analysis.delay"],
    ["recurrence plot", "analysis.recurrence"],
    ["recurrence quantification", "analysis.quantification"],
    ["Poincare section", "analysis.section"],
    ["0-1 test, exponent of samples", "analysis.chaos"],
    ["type of motion", "analysis.regime"],
    ["pictures of the patch", "record.patch_rate_khz"],
    ["pictures of the body", "record.body_rate_khz"],
    ["energy and its audit", "record.energy_rate_khz"],
];

/// The part of a run that the key of an effect belongs to, and the value that switches the effect off.
fn switch(key: &str) -> (Part, &'static str) {
    match key {
        "contact_damping" | "damping" => (Part::Motion, "absent"),
        "contact.stiffness_distribution" => (Part::Motion, "uniform"),
        "time.events" => (Part::Motion, "through"),
        "analysis.lyapunov" | "analysis.perturbed_trajectory" => (Part::Companion, "absent"),
        _ if key.starts_with("analysis.") => (Part::Analysis, "absent"),
        _ if key.starts_with("record.") => (Part::Recording, "0"),
        _ => (Part::Motion, "false"),
    }
}

/// An effect that a scene has on, and its price.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Effect {
    /// Name of the effect.
    pub name: String,
    /// Table or key of the scene that switches it.
    pub key: String,
    /// CPU time that the effect adds, s per simulated second; `null` if it cannot be switched off alone.
    pub price_s_per_s: Option<f64>,
    /// Smallest price that the measurement can tell from zero, s per simulated second.
    pub noise_s_per_s: f64,
    /// CPU time of a complete run with the effect, over that without it; `null` with the price.
    pub ratio: Option<f64>,
    /// The settled motion without the effect; `null` for an effect that does not act on the motion.
    pub without: Option<Motion>,
    /// Relative difference of the motion without the effect from that of the scene.
    pub change: Option<f64>,
    /// Reason why it cannot be switched off alone; `null` if it can.
    pub unavailable: Option<String>,
}

/// An effect, and the scene without it, unless it cannot be switched off alone.
pub type Switched = (Part, Effect, Option<Scene>);

fn named(name: &str, key: &str) -> Effect {
    Effect {
        name: name.to_owned(),
        key: key.to_owned(),
        ..Effect::default()
    }
}

/// The effects that a scene has on.
pub fn effects_of(scene: &Scene) -> Vec<Switched> {
    let mut effects = Vec::new();
    for [name, key] in EFFECTS {
        let (part, off) = switch(key);
        let mut effect = named(name, key);
        match scene.with_overrides(&[(key, off)]) {
            Ok(other) if is_same(&other, scene) => {}
            Ok(mut other) => {
                other.duration = scene.duration;
                effects.push((part, effect, Some(other)));
            }
            // A small system has no such key.
            Err(_) if matches!(part, Part::Motion | Part::Recording) => {}
            Err(error) => {
                effect.unavailable = Some(error.to_string());
                effects.push((part, effect, None));
            }
        }
    }
    let memory = named("memory of friction", "friction.law");
    effects.extend(without_memory(scene).map(|other| (Part::Motion, memory, Some(other))));
    effects
}

/// Whether two scenes simulate, analyse and record the same.
fn is_same(a: &Scene, b: &Scene) -> bool {
    a.subject == b.subject
        && a.integrator == b.integrator
        && a.analysis == b.analysis
        && a.record == b.record
}

/// The scene whose friction is that of steady sliding at each instant.
fn without_memory(scene: &Scene) -> Option<Scene> {
    /// Speeds of the curve, m/s: from 10 um/s, 16 per decade.
    const SPEEDS: [f64; 2] = [1e-5, 16.0];
    /// Default slope factor of the creep region, s/m.
    const CREEP: f64 = 1000.0;
    let mut other = scene.clone();
    let spec = &mut other.joint_mut().ok()?.spec;
    let Friction::Dynamic { law, radial } = &spec.friction else {
        return None;
    };
    let radial = *radial;
    let speeds = (0..96).map(|k| SPEEDS[0] * 10f64.powf(f64::from(k) / SPEEDS[1]));
    let points = speeds.map(|speed| {
        let [coefficient, _] = law.response([speed, 0.0, 0.0], law.steady_state(speed));
        [speed, coefficient[0].max(0.0)]
    });
    let law = FrictionTable::new(points.collect(), CREEP)?;
    spec.friction = Friction::Table {
        law: Arc::new(law),
        radial,
    };
    Some(other)
}

/// Measures the price of each effect.
pub fn price(
    runner: &mut Runner<'_>,
    mut run_all: Option<RunAll<'_>>,
    study: &mut Cost,
) -> Result<(), StudyError> {
    runner.begin("effects", 0.82);
    let mut scene = runner.scene.clone();
    scene.duration = scene.duration.min(LONGEST);
    let own = runner.motion(&scene, 0)?;
    let mut run = Simulation::new(&scene.clone().without_analyses())?;
    let mut timer = Timer {
        header: run.header(""),
        frames: Vec::new(),
        run_all: run_all.as_mut(),
    };
    while let Some(frame) = run.next_frame()? {
        runner.check()?;
        timer.frames.push(Arc::new(frame));
    }
    let mut time = |part| Ok::<_, StudyError>(timer.times(part, &[&scene], runner)?[0][0]);
    let [simulated, analysed] = [time(Part::Companion)?, time(Part::Analysis)?];
    let without_recording = simulated + analysed;
    let mut recording = named("the whole recording", "--save");
    let run_time = match time(Part::Recording) {
        // A full disk, for example: the rest is still worth while.
        Err(StudyError::Run(cause)) => {
            recording.unavailable = Some(chain_of_causes(&*cause));
            without_recording
        }
        // A complete run simulates and analyses, too.
        time => time?.max(without_recording),
    };
    study.run_cpu_s_per_s = Some(run_time);
    if recording.unavailable.is_none() {
        recording.set_price(run_time, run_time - without_recording, NOISE * run_time);
    }
    if timer.run_all.is_some() {
        study.effects.push(recording.clone());
    }
    timer.run_all = timer.run_all.filter(|_| recording.unavailable.is_none());
    let effects = effects_of(&scene);
    let count = effects.len() as f64;
    for (k, (part, mut effect, without)) in effects.into_iter().enumerate() {
        runner.begin("effects", 0.84 + 0.16 * k as f64 / count);
        if part == Part::Recording && timer.run_all.is_none() {
            continue;
        }
        if let Some(other) = without {
            let times = timer.times(part, &[&scene, &other], runner)?;
            let noise =
                (times[0][1] - times[0][0] + times[1][1] - times[1][0]).max(NOISE * times[0][0]);
            effect.set_price(run_time, times[0][0] - times[1][0], noise);
            if part == Part::Motion {
                let motion = runner.motion(&other, 0)?;
                effect.change = Some(motion.difference(&own));
                effect.without = Some(motion);
            }
        }
        study.effects.push(effect);
    }
    Ok(())
}

impl Effect {
    /// Sets the price of an effect in a run of a time, each s per simulated second.
    fn set_price(&mut self, run_time: f64, price: f64, noise: f64) {
        self.price_s_per_s = Some(price);
        self.noise_s_per_s = noise;
        self.ratio = Some(run_time / (run_time - price));
    }
}

/// Times the parts of runs.
struct Timer<'a, 'b> {
    header: Header,
    frames: Vec<Arc<Frame>>,
    run_all: Option<&'a mut RunAll<'b>>,
}

impl Timer<'_, '_> {
    /// CPU time of a part of a run, s per simulated second.
    fn once(
        &mut self,
        part: Part,
        scene: &Scene,
        runner: &mut Runner<'_>,
    ) -> Result<f64, StudyError> {
        runner.check()?;
        let mut simulation = match part {
            Part::Motion => Some(Simulation::new(&scene.clone().without_analyses())?),
            Part::Companion => Some(Simulation::new(scene)?),
            Part::Analysis | Part::Recording => None,
        };
        let began = ProcessTime::now();
        if let Some(simulation) = &mut simulation {
            while simulation.next_frame()?.is_some() {
                runner.check()?;
            }
        } else if part == Part::Analysis {
            self.analyse(&scene.analysis)?;
        } else if let Some(run_all) = &mut self.run_all {
            (**run_all)(scene).map_err(StudyError::Run)?;
        }
        let seconds = began.elapsed().as_secs_f64();
        // A run that was stopped on the way has no time.
        runner.check()?;
        Ok(seconds / scene.duration)
    }

    /// The shortest time of each scene and the next longer one, from alternate runs.
    fn times(
        &mut self,
        part: Part,
        scenes: &[&Scene],
        runner: &mut Runner<'_>,
    ) -> Result<Vec<[f64; 2]>, StudyError> {
        let mut shortest = vec![[f64::INFINITY; 2]; scenes.len()];
        for _ in 0..REPEATS {
            for ([first, second], scene) in shortest.iter_mut().zip(scenes) {
                let time = self.once(part, scene, runner)?;
                *second = time.max(*first).min(*second);
                *first = time.min(*first);
            }
        }
        Ok(shortest)
    }

    /// Analyses the frames, which have neither tangent vectors nor a perturbed trajectory, and discards the results.
    fn analyse(&self, spec: &AnalysisSpec) -> Result<(), PipelineError> {
        let spec = AnalysisSpec {
            exponents: None,
            perturbed_trajectory: None,
            ..spec.clone()
        };
        let mut analyser = Analyser::new(&spec, &self.header);
        for frame in &self.frames {
            analyser.push(frame, &mut Vec::<Record>::new())?;
        }
        Ok(analyser.finish(&mut Vec::<Record>::new())?)
    }
}
