//! What a command line may change of a scene, under the same ranges as in a file.

use super::error::{Place, SceneError, SceneWarning};
use super::schedule::Schedule;
use super::schema::kind::Kind;
use super::spec::Scene;
use super::tables::analysis::AnalysisSpec;
use super::tables::load::{FACTOR, LOAD, TILT};
use super::tables::{SCHEMA, patch_stays, shown_mechanism, sliding};
use crate::joint::Friction;

impl Scene {
    /// The same scene at a constant tilt, in degrees; -90 to 90.
    ///
    /// # Errors
    /// When the scene has no joint, the tilt is out of range, or the central contact point would
    /// not slide.
    pub fn with_tilt(mut self, tilt_deg: f64) -> Result<Self, SceneError> {
        let mut joint = self.joint()?.clone();
        joint.tilt = Schedule::constant(self.overridden("load.tilt_deg", tilt_deg)?);
        sliding(&joint.spec, &joint.tilt, || self.place_of_override())?;
        patch_stays(&joint, || self.place_of_override())?;
        *self.joint_mut()? = joint;
        self.mechanism = shown_mechanism(&self);
        Ok(self)
    }

    /// The same scene run for another time, in milliseconds; 0.1 to 100,000.
    ///
    /// # Errors
    /// When the time is out of range.
    pub fn with_duration(mut self, duration_ms: f64) -> Result<Self, SceneError> {
        self.duration = self.overridden("time.duration_ms", duration_ms)?;
        Ok(self)
    }

    /// The same scene with another relative tolerance of its integrator; 1e-13 to 0.01.
    ///
    /// # Errors
    /// When the tolerance is out of range.
    pub fn with_tolerance(mut self, tolerance: f64) -> Result<Self, SceneError> {
        self.integrator.tolerance = self.overridden("time.tolerance", tolerance)?;
        Ok(self)
    }

    /// The same scene with another seed of its random kick.
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.start.seed = seed;
        self.note("start.seed", seed);
        self
    }

    /// The same motion with nothing analysed along it and no lesson told of it, and no tangent vectors or
    /// second copy beside it.
    pub fn without_analyses(mut self) -> Self {
        self.analysis = AnalysisSpec::default();
        self.mechanism = None;
        self
    }

    /// Whether neighbours of the motion are followed: tangent vectors, or a second copy.
    pub fn follows_neighbours(&self) -> bool {
        self.analysis.exponents.is_some() || self.analysis.butterfly.is_some()
    }

    /// The same scene without tangent vectors and second copy, which cost most; a mechanism that needs them is
    /// not shown.
    pub fn without_neighbours(mut self) -> Self {
        let paths = [
            (self.analysis.exponents.take().is_some(), "exponents"),
            (self.analysis.butterfly.take().is_some(), "butterfly"),
        ];
        for (_, name) in paths.into_iter().filter(|(was_there, _)| *was_there) {
            self.note(&format!("[analysis.{name}]"), "left out");
        }
        self.mechanism = shown_mechanism(&self);
        self
    }

    /// What is allowed in this scene but probably not meant.
    pub fn warnings(&self) -> Vec<SceneWarning> {
        let mut warnings = Vec::new();
        let Ok(joint) = self.joint() else {
            return warnings;
        };
        if let Friction::Stribeck { law, .. } = joint.spec.friction
            && law.mu_d > law.mu_s
        {
            warnings.push(SceneWarning::KineticAboveStatic {
                mu_s: law.mu_s,
                mu_d: law.mu_d,
            });
        }
        let factor = joint.rotation.as_ref().map(|r| &r.factor);
        for (keys, schedule) in [
            (&TILT, Some(&joint.tilt)),
            (&LOAD, joint.load.as_ref()),
            (&FACTOR, factor),
        ] {
            let last = schedule.and_then(Schedule::last_point);
            let steps = schedule
                .and_then(|schedule| schedule.jumps().last())
                .is_some();
            // A knot at the very end has its line before it; a step there has nothing after it.
            let too_late = |last: &f64| *last > self.duration || steps && *last == self.duration;
            if let Some(last) = last.filter(too_late) {
                warnings.push(SceneWarning::ScheduleCutShort {
                    of: keys.word,
                    duration: self.duration,
                    last,
                });
            }
            let frame = self.frame_samples as f64 / self.sample_rate;
            if let Some(time) = schedule.and_then(|schedule| schedule.knot_within(frame)) {
                warnings.push(SceneWarning::PointsWithinFrame {
                    of: keys.word,
                    time,
                    frame,
                });
            }
        }
        let analysis = &self.analysis;
        let starts = [
            (
                "analysis.exponents.settle_ms",
                analysis.exponents.map(|spec| spec.settle),
            ),
            (
                "analysis.butterfly.start_ms",
                analysis.butterfly.map(|spec| spec.start),
            ),
        ];
        for (key, start) in starts {
            if let Some(start) = start.filter(|start| *start >= self.duration) {
                warnings.push(SceneWarning::NeverBegins {
                    key,
                    start,
                    duration: self.duration,
                });
            }
        }
        warnings
    }

    /// Takes a value in place of a number's, and notes it at the end of the recorded text.
    fn overridden(&mut self, path: &str, stated: f64) -> Result<f64, SceneError> {
        let declared = SCHEMA.find(path).expect("a declared key");
        let number = declared.key.kind.as_number().expect("a plain number");
        let value = number.accept(stated).map_err(|mismatch| {
            let fault = mismatch.fault(path.to_owned(), number.expected(), stated.to_string());
            fault.at(self.place_of_override())
        })?;
        self.note(path, stated);
        Ok(value)
    }

    /// Notes a value taken in place of a key's at the end of the recorded text.
    fn note(&mut self, path: &str, stated: impl std::fmt::Display) {
        if !self.text.ends_with('\n') {
            self.text.push('\n');
        }
        self.text
            .push_str(&format!("# overridden for this run: {path} = {stated}\n"));
    }

    pub(super) fn place_of_override(&self) -> Place {
        Place {
            file: format!("override of scene {}", self.name),
            line: None,
        }
    }
}
