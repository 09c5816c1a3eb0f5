//! A numeric key of a scene that studies vary.

use std::f64::consts::FRAC_1_SQRT_2;

use toml_edit::Value;

use super::edit::{knot_list, number};
use super::error::{SceneError, did_you_mean, nearest_path};
use super::schedule::Schedule;
use super::schema::kind::float;
use super::schema::{Declared, IfAbsent, split};
use super::spec::Scene;
use super::tables::friction::CURVE;
use super::tables::load::{FACTOR, LOAD, is_schedule_key};
use super::tables::{SCHEMA, joint, small};
use crate::number::trimmed;

const LOAD_PATH: &str = "load.load_n";
const TILT_PATH: &str = "load.tilt_deg";
/// One ratio for all modes, or a list.
pub(super) const DAMPING_PATH: &str = "damping.ratio";
const ROTATION_PATH: &str = "rotation.angular_velocity_rad_per_s";

/// Numbers of the discretisation, not of the system.
const NUMERICAL: [&str; 1] = ["body.element_size_mm"];

/// Axis of rotation in the paper.
const PAPER_AXIS: [f64; 3] = [FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0];

/// A numeric key of a scene that can take other values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    path: &'static str,
}

impl Parameter {
    /// Returns the parameter with a dotted path, such as `contact.stiffness_factor`, or with a key name that
    /// occurs in one table only.
    ///
    /// # Errors
    /// If no scene has such a number. The error suggests the most similar one.
    pub fn named(name: &str) -> Result<Self, SceneError> {
        Self::named_among(name, |_| true)
    }

    /// As [`Parameter::named`]; a name without a table means one of some keys.
    fn named_among(name: &str, concerns: impl Fn(&Declared) -> bool) -> Result<Self, SceneError> {
        let key = declared(name, is_free, concerns, "parameter to vary")?;
        Ok(Self { path: &key.path })
    }

    /// The constant tilt of the load.
    pub fn tilt() -> Self {
        Self { path: TILT_PATH }
    }

    fn declared(self) -> &'static Declared {
        SCHEMA.find(self.path).expect("a declared key")
    }

    /// Dotted path of the key.
    pub fn path(self) -> &'static str {
        self.path
    }

    /// Name of the key without its table, such as `tilt_deg`.
    pub fn name(self) -> &'static str {
        split(self.path).1
    }

    /// Whether the value is a real number, not a count or a seed.
    pub fn is_continuous(self) -> bool {
        self.declared().limits.is_real || self.path == ROTATION_PATH
    }

    /// Whether the value is a real number of the simulated system: of body, contact, friction, load and so on.
    pub(super) fn is_physical(self) -> bool {
        let (table, _) = split(self.path);
        let is_system = joint::TABLES.contains(&table) || small::NAMES.contains(&table);
        is_system && self.is_continuous() && !NUMERICAL.contains(&self.path())
    }

    /// Name in words, without the unit: `load`, `Stribeck slope`, `mu_s`.
    pub fn label(self) -> String {
        let unit = self.unit().to_lowercase().replace("1/", "per_");
        let unit = format!("_{}", unit.replace('/', "_per_").replace('^', ""));
        let name = self.name().strip_suffix(&unit).unwrap_or(self.name());
        if name.starts_with("mu") {
            // A symbol.
            name.to_owned()
        } else {
            name.replace('_', " ").replace("stribeck", "Stribeck")
        }
    }

    /// Name, value and unit: `load 200 N`.
    pub fn with_value(self, value: f64) -> String {
        let text = format!("{} {} {}", self.label(), trimmed(value, 6), self.unit());
        text.trim_end().to_owned()
    }

    /// Meaning, in one sentence.
    pub fn meaning(self) -> &'static str {
        self.declared().meaning
    }

    /// Unit of the value in a scene file; empty for a dimensionless number.
    pub fn unit(self) -> &'static str {
        self.declared().limits.unit.symbol
    }
}

impl From<Parameter> for String {
    fn from(parameter: Parameter) -> Self {
        parameter.path.to_owned()
    }
}

/// Finds a key among those of a condition by its dotted path, or by its name if that occurs in one table only of those that
/// concern the scene.
///
/// # Errors
/// If there is no such key. The error suggests the most similar one.
pub(super) fn declared(
    name: &str,
    among: impl Fn(&Declared) -> bool,
    concerns: impl Fn(&Declared) -> bool,
    place: &str,
) -> Result<&'static Declared, SceneError> {
    let keys = || SCHEMA.0.iter().filter(|key| among(key));
    if let Some(key) = keys().find(|key| key.path == name) {
        return Ok(key);
    }
    let mut namesakes: Vec<_> = keys().filter(|key| key.name == name).collect();
    if namesakes.len() > 1 {
        namesakes.retain(|key| concerns(key));
    }
    if let [key] = namesakes[..] {
        return Ok(key);
    }
    let problem = if SCHEMA.find(name).is_some() {
        format!(
            "`{name}` cannot be set or varied: it is not a single number that is constant in time"
        )
    } else {
        format!("unknown key `{name}`")
    };
    let nearest = did_you_mean(nearest_path(name, keys().map(|key| &key.path[..])));
    let remedy = "`squeakscope scenes --keys` lists all keys";
    Err(SceneError::new(
        place.to_owned(),
        problem + &nearest,
        remedy,
    ))
}

/// Whether a key can be varied: a number that is constant in time and not in a list of tables, or the angular
/// velocity, which is varied in magnitude.
fn is_free(key: &Declared) -> bool {
    let is_fixed = is_schedule_key(&key.path) || is_listed(key);
    key.limits.is_number && !is_fixed || key.path == ROTATION_PATH
}

/// Whether a key belongs to the tables of a list: its path is that of no single value.
pub(super) fn is_listed(key: &Declared) -> bool {
    // A path that is both a table and a key is a list of tables.
    SCHEMA.find(&key.table).is_some()
}

impl Scene {
    /// Returns the scene with other values of some parameters, in the units of a scene file. The text of the
    /// scene changes accordingly. A tilt replaces a tilt that is a function of time. The value of
    /// `rotation.angular_velocity_rad_per_s` is the magnitude of the angular velocity; its axis is preserved.
    /// For a scene at rest the axis is that of the paper.
    ///
    /// # Errors
    /// As [`Scene::parse`]: values that are out of range or inconsistent. A load or rotation that is a
    /// function of time in this scene cannot take a value.
    pub fn with_values(&self, values: &[(Parameter, f64)]) -> Result<Self, SceneError> {
        for (parameter, _) in values {
            self.reject_function(*parameter)?;
        }
        self.edited(values.iter().map(|&(parameter, value)| {
            let value = match parameter.path() {
                ROTATION_PATH => self.rotation_of(value),
                _ => number(value),
            };
            (parameter.path(), Some(value))
        }))
    }

    /// Value of a parameter in the unit of a scene file: as written, or its default; that at the start for a
    /// function of time, and the magnitude of the angular velocity. `None` if the key is absent and its default is
    /// not a number.
    pub fn value_of(&self, parameter: Parameter) -> Option<f64> {
        if let Ok(joint) = self.joint() {
            let loading = joint.loading(0.0);
            match parameter.path() {
                TILT_PATH => return Some((1e9 * loading.tilt.to_degrees()).round() / 1e9),
                LOAD_PATH => return Some(loading.load),
                ROTATION_PATH => {
                    return Some(loading.rotation.iter().map(|w| w * w).sum::<f64>().sqrt());
                }
                _ => {}
            }
        }
        let document = self.document().ok()?;
        let mut parts = parameter.path().split('.');
        let item = parts.try_fold(document.as_item(), |item, part| item.get(part));
        match (item, parameter.declared().if_absent) {
            (Some(item), _) => float(item.as_value()?).ok(),
            (None, IfAbsent::Default(literal)) => literal.parse().ok(),
            (None, _) => None,
        }
    }

    /// The real numbers of the simulated system (body, contact, friction, load, ...) with their values in the units of
    /// a scene file. Numerical settings and numbers that this scene cannot change are left out.
    pub fn physical_parameters(&self) -> Vec<(Parameter, f64)> {
        SCHEMA
            .0
            .iter()
            .filter(|key| is_free(key))
            .map(|key| Parameter { path: &key.path })
            .filter(|parameter| parameter.is_physical())
            .filter_map(|parameter| {
                let value = self.value_of(parameter)?;
                // A number of another body, law or system is rejected.
                self.with_values(&[(parameter, value)]).ok()?;
                Some((parameter, value))
            })
            .collect()
    }

    /// Returns the scene with other points of its measured friction curve: slip speed (m/s) and coefficient.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn with_friction_points(&self, points: &[[f64; 2]]) -> Result<Self, SceneError> {
        let list = knot_list(&CURVE, points);
        self.edited([(CURVE.path(), Some(list))])
    }

    /// Returns the parameter as [`Parameter::named`]; a name that several systems have is that of this scene's system.
    ///
    /// # Errors
    /// As [`Parameter::named`].
    pub fn parameter(&self, name: &str) -> Result<Parameter, SceneError> {
        Parameter::named_among(name, self.concerns()?)
    }

    /// Whether a key is not one of a system that this scene does not simulate.
    pub(super) fn concerns(&self) -> Result<impl Fn(&Declared) -> bool + use<>, SceneError> {
        let document = self.document()?;
        let has_joint = self.joint().is_ok();
        Ok(move |key: &Declared| {
            let table = &key.table[..];
            if small::NAMES.contains(&table) {
                document.contains_key(table)
            } else {
                has_joint || !joint::TABLES.contains(&table)
            }
        })
    }

    /// Rejects a value for a load or rotation that is a function of time. A tilt is accepted: studies run
    /// through constant tilts.
    fn reject_function(&self, parameter: Parameter) -> Result<(), SceneError> {
        let Ok(joint) = self.joint() else {
            return Ok(());
        };
        let path = parameter.path();
        let word = match path {
            LOAD_PATH if joint.load.varies() => LOAD.word,
            // A constant factor other than 1 would change the value, too.
            ROTATION_PATH if joint.rotation_factor != Schedule::constant(1.0) => FACTOR.word,
            _ => return Ok(()),
        };
        let problem = format!(
            "the {word} of this scene is a function of time and cannot take a constant value"
        );
        let remedy = format!("use a scene with a constant {word}");
        let place = self.place_of_override();
        Err(SceneError::inconsistent(place, path, problem, remedy))
    }

    /// The scene's angular velocity with another magnitude, rad/s.
    fn rotation_of(&self, size: f64) -> Value {
        let rotation = self.joint().map_or([0.0; 3], |joint| joint.spec.rotation);
        let before = rotation.iter().map(|w| w * w).sum::<f64>().sqrt();
        let axis = if before > 0.0 {
            rotation.map(|w| w / before)
        } else {
            PAPER_AXIS
        };
        Value::from_iter(axis.map(|w| size * w))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_found_by_path_or_unique_name() {
        let factor = Parameter::named("contact.stiffness_factor").unwrap();
        assert_eq!(Parameter::named("stiffness_factor").unwrap(), factor);
        assert_eq!(factor.unit(), "");
        assert_eq!(Parameter::tilt().unit(), "deg");
        assert_eq!(Parameter::named("tilt_deg").unwrap(), Parameter::tilt());
        for (name, nearest) in [
            // Several tables have this key.
            ("window_ms", "analysis.spectrum.window_ms"),
            ("contact.stifness_factor", "contact.stiffness_factor"),
            ("lod", "load.load_n"),
            ("laod_n", "load.load_n"),
        ] {
            let error = Parameter::named(name).unwrap_err().to_string();
            let expected = format!("did you mean `{nearest}`?");
            assert!(error.contains(&expected), "{error}");
        }
    }

    #[test]
    fn the_angular_velocity_is_varied_in_magnitude() {
        let rotation = Parameter::named("rotation.angular_velocity_rad_per_s").unwrap();
        let scene = Scene::load("doubled-torus-3deg").unwrap();
        let slow = scene.with_values(&[(rotation, 0.5)]).unwrap();
        let spun = slow.joint().unwrap().spec.rotation;
        let size = spun.iter().map(|w| w * w).sum::<f64>().sqrt();
        assert!((size - 0.5).abs() < 1e-15 && spun[0] > 0.3 && spun[2] == 0.0);
        // A scene at rest takes the axis of the paper, so that a sweep can start at zero.
        let rest = slow.with_values(&[(rotation, 0.0)]).unwrap();
        assert_eq!(rest.joint().unwrap().spec.rotation, [0.0; 3]);
        let again = rest.with_values(&[(rotation, 0.5)]).unwrap();
        let spun_again = again.joint().unwrap().spec.rotation;
        assert!(
            spun.iter()
                .zip(spun_again)
                .all(|(a, b)| (a - b).abs() < 1e-15)
        );
        let word = Parameter::named("contact.stiffness_distribution")
            .unwrap_err()
            .to_string();
        assert!(word.contains("is not a single number"), "{word}");
    }

    #[test]
    fn new_values_are_written_to_the_text() {
        let ramp = Scene::load("tilt-ramp").unwrap();
        let factor = Parameter::named("stiffness_factor").unwrap();
        let nodes = Parameter::named("nodes").unwrap();
        let damping = Parameter::named("damping.ratio").unwrap();
        let values = [
            (Parameter::tilt(), 2.5),
            (factor, 4.0),
            (nodes, 64.0),
            (damping, 0.001),
        ];
        let scene = ramp.with_values(&values).unwrap();
        let joint = scene.joint().unwrap();
        assert_eq!(joint.tilt.at(1.0), 2.5_f64.to_radians());
        assert!(!joint.tilt.varies());
        assert_eq!(joint.spec.contact.stiffness_factor, 4.0);
        assert_eq!(joint.spec.contact.nodes, 64);
        assert_eq!(
            Scene::parse("tilt-ramp", scene.text.clone()).unwrap(),
            scene
        );
        // The rest of the text is unchanged, including comments.
        assert!(scene.text.lines().filter(|line| line.contains('#')).count() > 3);
    }

    #[test]
    fn values_out_of_range_are_rejected() {
        let scene = Scene::load("chaos-5deg").unwrap();
        let nodes = Parameter::named("nodes").unwrap();
        for (parameter, value) in [(Parameter::tilt(), 91.0), (nodes, 2.5), (nodes, 0.0)] {
            assert!(scene.with_values(&[(parameter, value)]).is_err(), "{value}");
        }
    }
}
