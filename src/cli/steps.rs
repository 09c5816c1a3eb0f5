//! Ranges on the command line: evenly spaced values `A:B:STEP`, intervals `A:B`, and either for a key, `KEY=...`.

use std::str::FromStr;

use thiserror::Error;

/// Evenly spaced values from A to B, both included if B - A is a multiple of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    from: f64,
    step: f64,
    steps: u32,
}

impl Steps {
    /// Limit on the number of values.
    const MAX_STEPS: f64 = 10_000.0;

    /// The values in order, rounded to 12 significant digits.
    pub fn values(self) -> impl Iterator<Item = f64> {
        let Self { from, step, steps } = self;
        // Multiples of the step do not accumulate rounding errors. Rounding gives 2.4, not
        // 2.4000000000000004.
        (0..=steps).map(move |k| {
            let value = from + f64::from(k) * step;
            format!("{value:.11e}").parse().unwrap_or(value)
        })
    }
}

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

/// Reason why a text is not a range.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RangeError {
    /// Too few or too many numbers.
    #[error("give {0}")]
    Form(&'static str),
    /// No `KEY=` before the numbers.
    #[error("`{0}` has no key; give KEY=RANGE, such as contact.stiffness_factor=1:3")]
    NoKey(String),
    /// A part that is not a finite number.
    #[error("`{0}` is not a number; give {1}")]
    NotANumber(String, &'static str),
    /// A tilt beyond the horizontal.
    #[error("a tilt of {0} degrees is out of range; give -90 to 90 degrees")]
    TiltOutOfRange(f64),
    /// The ends of an interval are equal or in descending order.
    #[error("{from}:{to} is not an interval; give A:B with A less than B")]
    Empty {
        /// First end.
        from: f64,
        /// Second end.
        to: f64,
    },
    /// A step of zero, or of the wrong sign.
    #[error(
        "a step of {step} does not lead from {from} to {to}; give a nonzero step in that direction"
    )]
    Direction {
        /// First value.
        from: f64,
        /// Last value.
        to: f64,
        /// Step between values.
        step: f64,
    },
    /// Too many values.
    #[error(
        "a step of {step} gives more than {} values; give a larger step",
        Steps::MAX_STEPS
    )]
    TooMany {
        /// Step between values.
        step: f64,
    },
}

/// The numbers of a range of this form.
fn numbers(text: &str, form: &'static str) -> Result<Vec<f64>, RangeError> {
    text.split(':')
        .map(|part| match part.trim().parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(RangeError::NotANumber(part.to_owned(), form)),
        })
        .collect()
}

impl FromStr for Interval {
    type Err = RangeError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const FORM: &str = "A:B, such as 0:8";
        match numbers(text, FORM)?[..] {
            [from, to] if from < to => Ok(Self([from, to])),
            [from, to] => Err(RangeError::Empty { from, to }),
            _ => Err(RangeError::Form(FORM)),
        }
    }
}

impl<T: FromStr<Err = RangeError>> FromStr for Keyed<T> {
    type Err = RangeError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let no_key = || RangeError::NoKey(text.to_owned());
        let (key, range) = text.split_once('=').ok_or_else(no_key)?;
        Ok(Self {
            key: key.trim().to_owned(),
            range: range.parse()?,
        })
    }
}

impl FromStr for Steps {
    type Err = RangeError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const FORM: &str = "one number, or A:B:STEP, such as 0:7:0.5";
        let (from, to, step) = match numbers(text, FORM)?[..] {
            [value] => (value, value, 1.0),
            [from, to, step] => (from, to, step),
            _ => return Err(RangeError::Form(FORM)),
        };
        // The margin makes 0:0.3:0.1 end at 0.3 despite rounding.
        let steps = ((to - from) / step + 1e-9).floor();
        if step == 0.0 || steps < 0.0 {
            return Err(RangeError::Direction { from, to, step });
        }
        if steps >= Self::MAX_STEPS {
            return Err(RangeError::TooMany { step });
        }
        Ok(Self {
            from,
            step,
            steps: steps as u32,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Result<Vec<f64>, RangeError> {
        text.parse::<Steps>().map(|steps| steps.values().collect())
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
            assert!(matches!(values(text), Err(RangeError::Form(_))), "{text}");
        }
        for text in ["", "a:7:1", "0:nan:1", "0:7:inf", "0::1"] {
            let error = values(text);
            assert!(matches!(error, Err(RangeError::NotANumber(..))), "{text}");
        }
        for text in ["0:7:0", "0:7:-1", "7:0:1", "0:0:0"] {
            let error = values(text);
            assert!(matches!(error, Err(RangeError::Direction { .. })), "{text}");
        }
        let error = values("0:90:1e-9");
        assert!(matches!(error, Err(RangeError::TooMany { .. })));
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
        assert_eq!(steps.range.values().count(), 5);
        let interval: Keyed<Interval> = "contact.stiffness_factor=1:3".parse().unwrap();
        assert_eq!(interval.range, Interval([1.0, 3.0]));
        let error = "0:8".parse::<Keyed<Interval>>();
        assert!(matches!(error, Err(RangeError::NoKey(_))));
    }
}
