//! Numbers of a scene that change while it runs: the sliders of a live run.

use super::document::Document;
use super::error::{SceneError, ensure};
use super::parameter::{DAMPING_PATH, Parameter};
use super::schema::kind::Range::Closed;
use super::schema::kind::{Kind, number, tables, text};
use super::schema::unit::{DEGREE, ONE};
use super::schema::{IfAbsent, Key, Schema, keys};
use super::spec::Scene;

/// Ends of the range of a slider.
const END: Kind<f64> = number(ONE, Closed(-1e9, 1e9));
/// Half of the range of an angle that the scene does not name, degrees.
const ANGLES: f64 = 10.0;
/// End of the range of a dimensionless number that is 0 in the scene, which does not name it.
const SMALL: f64 = 0.1;

keys! {
    /// Sliders of a live run for the numbers that the scene is about. Others follow under *More*, from half to twice their value.
    static CONTROLS: usize = "controls": tables(12), else "no number is named";
    /// Dotted path of a number of the joint or the small system that changes without a new body, such as `load.load_n`.
    static KEY: String = "key": text();
    /// Lower end of the slider, in the unit of that key.
    static LOW: f64 = "min": END;
    /// Upper end of the slider, in the unit of that key.
    static HIGH: f64 = "max": END;
}

/// A number that a live run can change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Control {
    /// The number.
    pub parameter: Parameter,
    /// Lowest and highest value, in the unit of a scene file.
    pub range: [f64; 2],
    /// Value at the start of the run, in the same unit.
    pub value: f64,
    /// Whether the scene names it as one of the numbers that it is about.
    pub is_named: bool,
}

pub(super) fn declare(schema: &mut Schema) {
    schema.add("", &CONTROLS);
    schema.add("controls", &KEY);
    schema.add("controls", &LOW);
    schema.add("controls", &HIGH);
}

/// Reads the named numbers with their ranges.
pub(super) fn read(document: &Document<'_>) -> Result<Vec<(Parameter, [f64; 2])>, SceneError> {
    let tables = document.table("").list(&CONTROLS)?;
    let controls = tables.into_iter().map(|table| {
        let parameter = Parameter::named(&table.get(&KEY)?);
        let parameter = parameter.map_err(|error| error.moved_to(table.place()))?;
        let range = [table.get(&LOW)?, table.get(&HIGH)?];
        ensure!(table, range[0] < range[1] => "max", &["min"];
            "the slider ends at {} and starts at {}", range[1], range[0];
            "give `max` a higher value than `min`");
        Ok((parameter, range))
    });
    controls.collect()
}

/// Checks that the scene permits both ends of each named range.
pub(super) fn check(document: &Document<'_>, scene: &Scene) -> Result<(), SceneError> {
    let tables = document.table("").list(&CONTROLS)?;
    for (table, &(parameter, range)) in tables.into_iter().zip(&scene.controls) {
        for end in range {
            scene.clone().set(parameter, end).map_err(|error| {
                let problem = format!("`{}` cannot be {end} here: {error}", parameter.path());
                let remedy = "give a range that the scene permits, or delete the slider";
                SceneError::inconsistent(table.place(), "controls", problem, remedy)
            })?;
        }
    }
    Ok(())
}

impl Scene {
    /// Changes a number of the system, in the unit of a scene file. Everything else stays, also what was overridden.
    ///
    /// # Errors
    /// As [`Scene::with_values`], and if the number changes more than the parameters of the equations: another body, or
    /// another law.
    pub fn set(&mut self, parameter: Parameter, value: f64) -> Result<(), SceneError> {
        let changed = self.with_values(&[(parameter, value)])?;
        if let (Ok(new), Ok(old)) = (changed.joint(), self.joint())
            && (new.spec.body != old.spec.body || !parameter.is_physical())
        {
            let problem = "a run cannot change it, since the body would be another one";
            let remedy = "start another run with this value";
            let (place, path) = (self.place_of_override(), parameter.path());
            return Err(SceneError::inconsistent(place, path, problem, remedy));
        }
        self.subject = changed.subject;
        self.text = changed.text;
        Ok(())
    }

    /// The numbers that a live run can change: those that the scene names, then the others.
    pub fn live_controls(&self) -> Vec<Control> {
        let named = self.controls.iter().map(|(parameter, _)| *parameter);
        let mut all: Vec<Parameter> = named.collect();
        for (other, _) in self.physical_parameters() {
            if !all.contains(&other) {
                all.push(other);
            }
        }
        let control = |parameter| self.control(parameter);
        all.into_iter().filter_map(control).collect()
    }

    /// The slider of a number; `None` if a live run cannot change it.
    pub fn control(&self, parameter: Parameter) -> Option<Control> {
        let value = match self.value_of(parameter) {
            None if parameter.path() == DAMPING_PATH => 0.0,
            value => value?,
        };
        let mut controls = self.controls.iter();
        let named = controls.find(|(named, _)| *named == parameter);
        let named = named.map(|(_, range)| *range);
        let [low, high] = named.or_else(|| self.usual_range(parameter, value))?;
        Some(Control {
            parameter,
            range: [low.min(value), high.max(value)],
            value,
            is_named: named.is_some(),
        })
    }

    /// A range around a value that the scene permits; `None` if the number cannot change, or its scale is unknown.
    fn usual_range(&self, parameter: Parameter, value: f64) -> Option<[f64; 2]> {
        let ends = match parameter.unit() {
            unit if unit == DEGREE.symbol => [value - ANGLES, value + ANGLES],
            "" if value == 0.0 => [0.0, SMALL],
            _ if value == 0.0 => return None,
            _ if value < 0.0 => [2.0 * value, 0.5 * value],
            _ => [0.5 * value, 2.0 * value],
        };
        // Closer to the value if the scene does not permit the whole range.
        let ends = ends.map(|end| {
            [1.0, 0.5, 0.2, 0.05]
                .map(|part| value + part * (end - value))
                .into_iter()
                .find(|end| self.clone().set(parameter, *end).is_ok())
        });
        match ends {
            [Some(low), Some(high)] if low < high => Some([low, high]),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::PRESETS;

    /// The scene permits every value that a slider can reach, and another body is never among them.
    #[test]
    fn every_end_of_every_slider_is_permitted() {
        for preset in PRESETS {
            let scene = preset.scene().unwrap();
            let controls = scene.live_controls();
            let named = controls.iter().filter(|control| control.is_named).count();
            assert!((2..=3).contains(&named), "{}", preset.name);
            for control in &controls {
                let path = control.parameter.path();
                assert!(!path.starts_with("body."), "{path}");
                let [low, high] = control.range;
                assert!(low <= control.value && control.value <= high, "{path}");
                for end in control.range {
                    scene.clone().set(control.parameter, end).unwrap();
                }
            }
        }
    }

    #[test]
    fn a_change_keeps_what_was_overridden() {
        let scene = Scene::load("chaos-5deg").unwrap();
        let mut scene = scene.with_tilt(4.0).unwrap().with_duration(7.0).unwrap();
        scene
            .set(Parameter::named("load_n").unwrap(), 200.0)
            .unwrap();
        let joint = scene.joint().unwrap();
        assert_eq!(
            (joint.spec.load, joint.tilt.at(0.0)),
            (200.0, 4.0_f64.to_radians())
        );
        assert_eq!(scene.duration, 7e-3);
        for (name, value) in [
            ("ball_diameter_mm", 31.0),
            ("contact.nodes", 36.0),
            ("load_n", -1.0),
        ] {
            let before = scene.clone();
            assert!(
                scene.set(Parameter::named(name).unwrap(), value).is_err(),
                "{name}"
            );
            assert_eq!(scene, before);
        }
    }

    #[test]
    fn faulty_sliders_are_refused_with_their_line() {
        let rest = "load = { load_n = 150, tilt_deg = 1 }\ntime.duration_ms = 1\n";
        for (control, part) in [
            ("key = \"load.lod_n\", min = 1, max = 2", "load.load_n"),
            ("key = \"load.load_n\", min = 2, max = 1", "ends at 1"),
            (
                "key = \"load.load_n\", min = 0, max = 1",
                "cannot be 0 here",
            ),
            (
                "key = \"body.ball_diameter_mm\", min = 25, max = 30",
                "cannot change",
            ),
            ("key = \"load.load_n\", min = 1", "controls.max"),
        ] {
            let text = format!("controls = [{{ {control} }}]\n{rest}");
            let error = Scene::parse("mine.toml", text).unwrap_err().to_string();
            assert!(
                error.contains(part) && error.starts_with("mine.toml:1"),
                "{error}"
            );
        }
    }
}
