//! Overrides of a scene by the command line, with the ranges of the scene file; warnings about a scene.

use toml_edit::Value;

use super::edit::number;
use super::error::SceneError;
use super::parameter::{Parameter, declared, is_listed};
use super::spec::Scene;
use super::tables::SCHEMA;
use super::tables::analysis::AnalysisSpec;
use super::tables::load::schedules;
use crate::joint::{BodySpec, Frequencies, Friction};

/// Value of an override that removes a key or a table.
const ABSENT: &str = "absent";

/// Half-angle of a Hertz patch above which its error is reported, rad.
const WIDE_PATCH: f64 = 20.0 / 180.0 * std::f64::consts::PI;

impl Scene {
    /// Returns the scene with a constant tilt, -90 to 90 degrees.
    ///
    /// # Errors
    /// If the scene has no joint, the tilt is out of range, or the central contact point would not slide.
    pub fn with_tilt(self, tilt_deg: f64) -> Result<Self, SceneError> {
        self.joint()?;
        self.with_values(&[(Parameter::tilt(), tilt_deg)])
    }

    /// Returns the scene with another simulated time, 0.1 to 100,000 ms.
    ///
    /// # Errors
    /// If the time is out of range.
    pub fn with_duration(self, duration_ms: f64) -> Result<Self, SceneError> {
        self.edited([("time.duration_ms", Some(number(duration_ms)))])
    }

    /// Returns the scene with another relative tolerance of the integrator, 1e-13 to 0.01.
    ///
    /// # Errors
    /// If the tolerance is out of range.
    pub fn with_tolerance(self, tolerance: f64) -> Result<Self, SceneError> {
        self.edited([("time.tolerance", Some(number(tolerance)))])
    }

    /// Returns the scene with other values of any keys. Each override is the dotted path of a key,
    /// or its name if that occurs in one table only, and the value as in a scene file; quotes of a word may be left
    /// out, and `absent` removes the key, or a whole table such as `analysis.lyapunov`. A form of the tilt, the load or the rotation replaces its other forms.
    ///
    /// # Errors
    /// If there is no such key, and as [`Scene::parse`].
    pub fn with_overrides(
        &self,
        overrides: &[(impl AsRef<str>, impl AsRef<str>)],
    ) -> Result<Self, SceneError> {
        let place = self.place_of_override();
        let entries = overrides.iter().map(|(name, value)| {
            let (name, value) = (name.as_ref(), value.as_ref());
            if value == ABSENT && SCHEMA.has_table(name) {
                return Ok((name, None));
            }
            let key = declared(name, |key| !is_listed(key), self.concerns()?, &place)?;
            let parsed = || value.parse().unwrap_or_else(|_| Value::from(value));
            Ok((&key.path[..], (value != ABSENT).then(parsed)))
        });
        self.edited(entries.collect::<Result<Vec<_>, SceneError>>()?)
    }

    /// Returns the scene without analyses and without a lesson; the motion is unchanged.
    pub fn without_analyses(mut self) -> Self {
        self.analysis = AnalysisSpec::default();
        self.mechanism = None;
        self
    }

    /// Whether the run integrates tangent vectors or a perturbed trajectory.
    pub fn computes_lyapunov(&self) -> bool {
        self.analysis.exponents.is_some() || self.analysis.perturbed_trajectory.is_some()
    }

    /// Returns the scene without Lyapunov exponents and perturbed trajectory, the most expensive analyses. A
    /// mechanism that requires one of them is removed.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn without_lyapunov(&self) -> Result<Self, SceneError> {
        let tables = ["analysis.lyapunov", "analysis.perturbed_trajectory"];
        self.edited(tables.map(|table| (table, None)))
    }

    /// Properties of this valid scene that are probably unintended, with the remedy.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let Ok(joint) = self.joint() else {
            return warnings;
        };
        if let BodySpec::BallOnBeam(body) = &joint.spec.body
            && body.frequencies == Frequencies::Published
            && !body.is_published()
        {
            warnings.push(
                "the published natural frequencies are those of the body of the paper, and body has other dimensions or \
                 another material; set body.frequencies = \"scaled\" or \"fe\""
                    .to_owned(),
            );
        }
        if let Friction::Stribeck { law, .. } = joint.spec.friction
            && law.mu_d > law.mu_s
        {
            warnings.push(format!(
                "friction.mu_d = {} exceeds friction.mu_s = {}: friction increases with speed, and no negative slope \
                 excites vibration",
                law.mu_d, law.mu_s
            ));
        }
        let half_angle = joint.spec.hertz_half_angle(joint.load_span()[1]);
        if let Some(half_angle) = half_angle.filter(|angle| *angle > WIDE_PATCH) {
            warnings.push(format!(
                "the contact patch has a half-angle of {:.0} degrees, and Hertz contact holds for small ones: the normal \
                 force along the load is {:.1} % too small; give the pressure over the radius as contact.pressure",
                half_angle.to_degrees(),
                100.0 * joint.spec.lost_load(half_angle)
            ));
        }
        let duration = self.duration;
        for (keys, schedule) in schedules().into_iter().zip(joint.schedules()) {
            let word = keys.word;
            let has_steps = schedule.jumps().next().is_some();
            // The segment before a knot at the end of the run is simulated; no sample follows a step there.
            let too_late = |last: &f64| *last > duration || has_steps && *last == duration;
            if let Some(last) = schedule.last_point().filter(too_late) {
                warnings.push(format!(
                    "the run ends at {} ms, {} the last change of the {word} at {} ms; increase time.duration_ms",
                    1e3 * duration,
                    if last > duration {
                        "before"
                    } else {
                        "without a sample after"
                    },
                    1e3 * last
                ));
            }
            let frame = self.frame_samples as f64 / self.sample_rate;
            if let Some(time) = schedule.first_knot_within(frame) {
                warnings.push(format!(
                    "the {word} has a knot at {} ms that follows the previous knot by less than a frame; the {word} is \
                     updated once per frame, every {} ms, and knots within a frame have no effect; reduce \
                     time.frame_samples, or use steps",
                    1e3 * time,
                    1e3 * frame
                ));
            }
        }
        let exponents = self.analysis.exponents.map(|spec| spec.settle);
        let perturbed = self.analysis.perturbed_trajectory.map(|spec| spec.start);
        for (key, start) in [
            ("analysis.lyapunov.transient_ms", exponents),
            ("analysis.perturbed_trajectory.start_ms", perturbed),
        ] {
            if let Some(start) = start.filter(|start| *start >= duration) {
                warnings.push(format!(
                    "the run ends at {} ms, before {key} = {}, so this analysis has no result; increase time.duration_ms",
                    1e3 * duration,
                    1e3 * start
                ));
            }
        }
        warnings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_key_can_be_overridden_by_path_or_name() {
        let scene = Scene::load("tilt-ramp").unwrap();
        let changed = scene
            .with_overrides(&[
                ("tilt_deg", "4"),
                ("nodes", "28"),
                ("mu_s", "0.5"),
                ("contact.stiffness_distribution", "pre-stress"),
                ("damping.ratio", "0.002"),
                ("analysis.recurrence.recurrence_rate", "0.07"),
            ])
            .unwrap();
        let joint = changed.joint().unwrap();
        assert_eq!(joint.tilt.at(1.0), 4.0_f64.to_radians());
        assert!(!joint.tilt.varies());
        assert_eq!(joint.spec.contact.nodes, 28);
        assert_eq!(Scene::parse(&changed.name, &changed.text).unwrap(), changed);
        let back = changed
            .with_overrides(&[(
                "load.tilt",
                "[{time_ms = 0, tilt_deg = 1}, {time_ms = 10, tilt_deg = 2}]",
            )])
            .unwrap();
        assert!(back.joint().unwrap().tilt.varies());
        let default = changed.with_overrides(&[("nodes", "absent")]).unwrap();
        assert_ne!(default.joint().unwrap().spec.contact.nodes, 28);
    }

    #[test]
    fn keys_and_tables_can_be_removed() {
        let scene = Scene::load("doubled-torus-3deg").unwrap();
        let without = |name: &str| scene.with_overrides(&[(name, "absent")]).unwrap();
        assert!(scene.analysis.exponents.is_some());
        assert_eq!(without("analysis.lyapunov").analysis.exponents, None);
        assert_eq!(without("mechanism").mechanism, None);
        let default = without("analysis.recurrence.size").analysis.recurrence;
        assert_ne!(default, scene.analysis.recurrence);
        let plain = scene
            .with_overrides(&[("mechanism", "absent"), ("analysis", "absent")])
            .unwrap();
        assert!(plain.analysis.spectrum.is_none());
    }

    #[test]
    fn faulty_overrides_name_the_key() {
        let scene = Scene::load("doubled-torus-3deg").unwrap();
        for (key, value, part) in [
            ("contact.nodse", "28", "contact.nodes"),
            ("contact.nodes", "many", "contact.nodes"),
            ("contact.nodes", "0", "out of range"),
            ("window_ms", "3", "did you mean"),
            ("tilt_dge", "3", "did you mean `load.tilt_deg`?"),
            ("load.tilt.tilt_deg", "3", "did you mean `load.tilt_deg`?"),
            ("load.tilt_deg", "95", "out of range"),
        ] {
            let error = scene
                .with_overrides(&[(key, value)])
                .unwrap_err()
                .to_string();
            assert!(error.contains(part), "{key}: {error}");
            assert!(error.starts_with("override of scene"), "{error}");
        }
    }
}
