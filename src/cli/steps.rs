//! Ranges on the command line: evenly spaced values `A:B:STEP`, intervals `A:B`, and either for a key, `KEY=...`.

use std::str::FromStr;

use super::error::CliError;
use crate::number::to_digits;
use crate::scene::{Parameter, Scene};

/// Evenly spaced values from A to B, both included if B - A is a multiple of the step.
#[derive(Clone, Debug, PartialEq)]
pub struct Steps(pub Vec<f64>);

/// An interval of a parameter, with ascending ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval(pub [f64; 2]);

/// A key of the scene file and its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Keyed<T> {
    /// Path or name of the key.
    pub key: String,
    /// Values in the unit of the key.
    pub range: T,
}

/// One or two different parameters of a scene, each with its range: the tilt and keys. Without any, the tilt has the range
/// `default`.
///
/// # Errors
/// Other parameters; a scene without a tilt.
pub fn parameters<T: Clone>(
    scene: &Scene,
    tilt: Option<T>,
    keys: &[Keyed<T>],
    default: T,
) -> Result<Vec<(Parameter, T)>, CliError> {
    let tilt = tilt.or(keys.is_empty().then_some(default));
    let mut all = Vec::from_iter(tilt.map(|range| (Parameter::tilt(), range)));
    for Keyed { key, range } in keys {
        all.push((scene.parameter(key)?, range.clone()));
    }
    if scene.joint().is_err() && all.iter().any(|(one, _)| *one == Parameter::tilt()) {
        return Err(CliError::Input(format!(
            "the scene `{}` has no load, and therefore no tilt; choose a parameter with --param",
            scene.name
        )));
    }
    match &all[..] {
        [(one, _), (two, _)] if one == two => Err(CliError::Input(format!(
            "`{}` is swept twice; give it once",
            one.path()
        ))),
        [_] | [_, _] => Ok(all),
        _ => Err(CliError::Input(format!(
            "{} parameters are swept; give one, or two for a map (--tilt counts as one)",
            all.len()
        ))),
    }
}

/// The numbers of a range of this form.
fn numbers(text: &str, form: &'static str) -> Result<Vec<f64>, String> {
    text.split(':')
        .map(|part| match part.trim().parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(format!("`{part}` is not a number; give {form}")),
        })
        .collect()
}

impl FromStr for Interval {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const FORM: &str = "A:B, such as 0:8";
        match numbers(text, FORM)?[..] {
            [from, to] if from < to => Ok(Self([from, to])),
            [from, to] => Err(format!(
                "{from}:{to} is not an interval; give A:B with A less than B"
            )),
            _ => Err(format!("give {FORM}")),
        }
    }
}

impl<T: FromStr<Err = String>> FromStr for Keyed<T> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (key, range) = text.split_once('=').ok_or_else(|| {
            format!("`{text}` has no key; give KEY=RANGE, such as contact.stiffness_factor=1:3")
        })?;
        Ok(Self {
            key: key.trim().to_owned(),
            range: range.parse()?,
        })
    }
}

impl FromStr for Steps {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const FORM: &str = "one number, or A:B:STEP, such as 0:7:0.5";
        const MAX_STEPS: u32 = 10_000;
        let (from, to, step) = match numbers(text, FORM)?[..] {
            [value] => (value, value, 1.0),
            [from, to, step] => (from, to, step),
            _ => return Err(format!("give {FORM}")),
        };
        // The margin makes 0:0.3:0.1 end at 0.3 despite rounding.
        let steps = ((to - from) / step + 1e-9).floor();
        if step == 0.0 || steps < 0.0 {
            return Err(format!(
                "a step of {step} does not lead from {from} to {to}; give a nonzero step in that direction"
            ));
        }
        if steps >= f64::from(MAX_STEPS) {
            return Err(format!(
                "a step of {step} gives more than {MAX_STEPS} values; give a larger step"
            ));
        }
        // Multiples of the step do not accumulate rounding errors. Rounding gives 2.4, not 2.4000000000000004.
        let value = |k| to_digits(from + f64::from(k) * step, 12);
        Ok(Self((0..=steps as u32).map(value).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Result<Vec<f64>, String> {
        text.parse::<Steps>().map(|steps| steps.0)
    }

    #[test]
    fn steps_include_their_end() {
        assert_eq!(values("0:7:3.5"), Ok(vec![0.0, 3.5, 7.0]));
        assert_eq!(values("3"), Ok(vec![3.0]));
        assert_eq!(values("-1:1:2"), Ok(vec![-1.0, 1.0]));
        assert_eq!(values("2:0:-1"), Ok(vec![2.0, 1.0, 0.0]));
        assert_eq!(values("0:1:0.7"), Ok(vec![0.0, 0.7]));
        assert_eq!(values("2:2:0.1"), Ok(vec![2.0]));
        assert_eq!(values("0:0.3:0.1"), Ok(vec![0.0, 0.1, 0.2, 0.3]));
        assert_eq!(values("2.4:3:0.2"), Ok(vec![2.4, 2.6, 2.8, 3.0]));
        assert_eq!(values("1e-7:3e-7:1e-7"), Ok(vec![1e-7, 2e-7, 3e-7]));
        assert_eq!(values("0:90:0.01").expect("steps").len(), 9001);
    }

    #[test]
    fn bad_steps_are_refused_with_a_reason() {
        for text in ["0:7", "0:7:1:1"] {
            assert!(values(text).unwrap_err().starts_with("give "), "{text}");
        }
        for text in ["", "a:7:1", "0:nan:1", "0:7:inf", "0::1"] {
            let error = values(text).unwrap_err();
            assert!(error.contains("is not a number"), "{error}");
        }
        for text in ["0:7:0", "0:7:-1", "7:0:1", "0:0:0"] {
            let error = values(text).unwrap_err();
            assert!(error.contains("does not lead"), "{error}");
        }
        let error = values("0:90:1e-9").unwrap_err();
        assert!(error.contains("gives more than 10000 values"), "{error}");
    }
    #[test]
    fn intervals_are_ascending_numbers() {
        assert_eq!("0:8".parse(), Ok(Interval([0.0, 8.0])));
        assert_eq!("-1.5:1e1".parse(), Ok(Interval([-1.5, 10.0])));
        for text in ["0", "0:8:1", "8:0", "1:1", "a:2", "0:nan", ""] {
            assert!(text.parse::<Interval>().is_err(), "{text}");
        }
    }

    #[test]
    fn a_key_precedes_its_range() {
        let steps: Keyed<Steps> = "contact.stiffness_factor=1:3:0.5".parse().unwrap();
        assert_eq!(steps.key, "contact.stiffness_factor");
        assert_eq!(steps.range.0.len(), 5);
        let interval: Keyed<Interval> = "contact.stiffness_factor=1:3".parse().unwrap();
        assert_eq!(interval.range, Interval([1.0, 3.0]));
        let error = "0:8".parse::<Keyed<Interval>>().unwrap_err();
        assert!(error.contains("has no key"), "{error}");
    }
}
