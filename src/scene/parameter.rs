//! One number of a scene by its path: what a study varies.

use std::f64::consts::FRAC_1_SQRT_2;
use std::fmt;

use toml_edit::{DocumentMut, Value};

use super::edit::{number, remove, set, syntax};
use super::error::{CLOSE, Fault, Place, SceneError, nearest};
use super::schema::Declared;
use super::spec::Scene;
use super::tables::SCHEMA;
use super::tables::load::{FACTOR, LOAD, TILT, is_of_a_schedule};

const LOAD_PATH: &str = "load.load_n";
const TILT_PATH: &str = "load.tilt_deg";
const ROTATION_PATH: &str = "rotation.rad_s";

/// The axis about which the ball of the paper turns.
const PAPER_AXIS: [f64; 3] = [FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0];

/// A number of a scene file that can be given another value.
#[derive(Clone, Copy)]
pub struct Parameter {
    key: &'static Declared,
}

impl Parameter {
    /// The parameter of a dotted path, such as `contact.stiffness_factor`, or of the key's own name
    /// where only one table has it.
    ///
    /// # Errors
    /// When no scene has such a number; the error names the nearest one.
    pub fn named(name: &str) -> Result<Self, SceneError> {
        let keys = || SCHEMA.0.iter().filter(|key| is_free(key));
        if let Some(key) = keys().find(|key| key.path == name) {
            return Ok(Self { key });
        }
        let place = Place {
            file: "the parameter to vary".to_owned(),
            line: None,
        };
        let key = name.to_owned();
        // A key of the file, but no number.
        if SCHEMA.find(name).is_some() {
            return Err(Fault::NotANumber { key }.at(place));
        }
        let namesakes: Vec<_> = keys().filter(|key| key.key.name == name).collect();
        if let [key] = namesakes[..] {
            return Ok(Self { key });
        }
        let nearest = match namesakes.first() {
            Some(namesake) => Some(&namesake.path[..]),
            None => nearest(name, keys().map(|key| &key.path[..]), CLOSE),
        };
        let unknown = Fault::UnknownKey {
            key,
            nearest: nearest.map(str::to_owned),
            known: "`squeakscope scenes --keys` lists every number of a scene".to_owned(),
        };
        Err(unknown.at(place))
    }

    /// The tilt of the load, constant in time.
    pub fn tilt() -> Self {
        Self {
            key: SCHEMA.find(TILT_PATH).expect("a declared key"),
        }
    }

    /// The dotted path.
    pub fn path(self) -> &'static str {
        &self.key.path
    }

    /// What it is, in a sentence.
    pub fn meaning(self) -> &'static str {
        self.key.key.meaning
    }

    /// The unit in which it is stated; empty for a pure number.
    pub fn unit(self) -> &'static str {
        self.key.key.kind.unit().symbol
    }
}

/// Whether a key is a number that holds for a whole run, not a part of a function of time; or the rotation,
/// which is varied by its size.
fn is_free(key: &Declared) -> bool {
    let number = key.key.kind.is_number() && !is_of_a_schedule(&key.path);
    number || key.path == ROTATION_PATH
}

impl PartialEq for Parameter {
    fn eq(&self, other: &Self) -> bool {
        self.path() == other.path()
    }
}

impl fmt::Debug for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Parameter({})", self.path())
    }
}

impl Scene {
    /// The same scene with other values of some parameters, each in the unit in which a scene file
    /// states it. The scene's text says them, too. A tilt given takes the place of a function of time; the
    /// value of `rotation.rad_s` is the size of the rotation, whose axis stays; a scene at rest has none,
    /// and takes the paper's.
    ///
    /// # Errors
    /// As [`Scene::parse`]: values out of range, and values that do not fit together. A load or a
    /// rotation that is a function of time in this scene takes no value.
    pub fn with_values(&self, values: &[(Parameter, f64)]) -> Result<Self, SceneError> {
        for (parameter, _) in values {
            self.refuse_function(*parameter)?;
        }
        let values = values
            .iter()
            .map(|&(parameter, value)| match parameter.path() {
                path @ ROTATION_PATH => (path, self.rotation_of(value)),
                path => (path, number(value)),
            });
        self.with_entries(values)
    }

    /// The same scene with other words for some keys, such as `"pre-stress"` for
    /// `contact.stiffness`.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn with_words(&self, words: &[(&str, &str)]) -> Result<Self, SceneError> {
        self.with_entries(words.iter().map(|&(path, word)| (path, Value::from(word))))
    }

    /// Refuses a value for what is a function of time. A tilt is not among it: its steady values are
    /// what studies go through.
    fn refuse_function(&self, parameter: Parameter) -> Result<(), SceneError> {
        let Ok(joint) = self.joint() else {
            return Ok(());
        };
        let path = parameter.path();
        let word = match path {
            LOAD_PATH if joint.load.is_some() => LOAD.word,
            ROTATION_PATH if joint.rotation.is_some() => FACTOR.word,
            _ => return Ok(()),
        };
        let problem = format!(
            "the {word} of this scene is a function of time, and a value would hold for the whole run"
        );
        let remedy = format!("take a scene in which the {word} is constant");
        Err(Fault::inconsistent(path, problem, remedy).at(self.place_of_override()))
    }

    /// The scene's rotation with another size, rad/s.
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

    pub(super) fn with_entries(
        &self,
        entries: impl IntoIterator<Item = (impl AsRef<str>, Value)>,
    ) -> Result<Self, SceneError> {
        let mut document: DocumentMut = self
            .text
            .parse()
            .map_err(|error| syntax(&error).at(self.place_of_override()))?;
        for (path, value) in entries {
            let path = path.as_ref();
            set(document.as_table_mut(), path, value);
            if path == TILT_PATH {
                for form in TILT.paths().filter(|form| *form != TILT_PATH) {
                    remove(&mut document, form);
                }
            }
        }
        // A file of modes is not read again: it is the same, wherever the scene came from.
        Self::parse_changed(&self.name, &document.to_string(), self.own_modes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_found_by_path_or_by_a_name_of_their_own() {
        let factor = Parameter::named("contact.stiffness_factor").unwrap();
        assert_eq!(Parameter::named("stiffness_factor").unwrap(), factor);
        assert_eq!(factor.unit(), "");
        assert_eq!(Parameter::tilt().unit(), "deg");
        assert_eq!(Parameter::named("tilt_deg").unwrap(), Parameter::tilt());
        // Several tables have a window.
        for name in ["window_ms", "contact.stifness_factor"] {
            let error = Parameter::named(name).unwrap_err().to_string();
            assert!(
                error.contains("did you mean") || error.contains("nearest"),
                "{error}"
            );
        }
    }

    #[test]
    fn the_rotation_is_varied_by_its_size() {
        let rotation = Parameter::named("rotation.rad_s").unwrap();
        let scene = Scene::load("torus-3deg").unwrap();
        let slow = scene.with_values(&[(rotation, 0.5)]).unwrap();
        let spun = slow.joint().unwrap().spec.rotation;
        let size = spun.iter().map(|w| w * w).sum::<f64>().sqrt();
        assert!((size - 0.5).abs() < 1e-15 && spun[0] > 0.3 && spun[2] == 0.0);
        // From rest it turns about the paper's axis: a sweep may start at zero.
        let rest = slow.with_values(&[(rotation, 0.0)]).unwrap();
        assert_eq!(rest.joint().unwrap().spec.rotation, [0.0; 3]);
        let again = rest.with_values(&[(rotation, 0.5)]).unwrap();
        let spun_again = again.joint().unwrap().spec.rotation;
        assert!(
            spun.iter()
                .zip(spun_again)
                .all(|(a, b)| (a - b).abs() < 1e-15)
        );
        let word = Parameter::named("contact.stiffness")
            .unwrap_err()
            .to_string();
        assert!(word.contains("no single number"), "{word}");
    }

    #[test]
    fn a_scene_takes_values_and_says_so() {
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
        // What was not asked for stays, comments included.
        assert!(scene.text.lines().filter(|line| line.contains('#')).count() > 3);
    }

    #[test]
    fn values_out_of_range_are_refused() {
        let scene = Scene::load("chaos-5deg").unwrap();
        let nodes = Parameter::named("nodes").unwrap();
        for (parameter, value) in [(Parameter::tilt(), 91.0), (nodes, 2.5), (nodes, 0.0)] {
            assert!(scene.with_values(&[(parameter, value)]).is_err(), "{value}");
        }
    }
}
