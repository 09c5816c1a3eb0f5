//! Evenly spaced values on the command line: `A:B:STEP`.

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

/// Reason why a text is not a valid [`Steps`].
#[derive(Clone, Debug, Error, PartialEq)]
pub enum StepsError {
    /// Neither one number nor three.
    #[error("give one number, or A:B:STEP, such as 0:7:0.5")]
    Form,
    /// No `KEY=` before the numbers.
    #[error("give KEY=A:B:STEP, such as contact.stiffness_factor=1:20:0.5")]
    NoKey,
    /// A part that is not a finite number.
    #[error("`{0}` is not a number; give A:B:STEP, such as 0:7:0.5")]
    NotANumber(String),
    /// A tilt beyond the horizontal.
    #[error("a tilt of {0} degrees is out of range; give -90 to 90 degrees")]
    TiltOutOfRange(f64),
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

impl FromStr for Steps {
    type Err = StepsError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parts = text
            .split(':')
            .map(|part| match part.trim().parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(number),
                _ => Err(StepsError::NotANumber(part.to_owned())),
            })
            .collect::<Result<Vec<_>, _>>()?;
        let (from, to, step) = match parts[..] {
            [value] => (value, value, 1.0),
            [from, to, step] => (from, to, step),
            _ => return Err(StepsError::Form),
        };
        // The margin makes 0:0.3:0.1 end at 0.3 despite rounding.
        let steps = ((to - from) / step + 1e-9).floor();
        if step == 0.0 || steps < 0.0 {
            return Err(StepsError::Direction { from, to, step });
        }
        if steps >= Self::MAX_STEPS {
            return Err(StepsError::TooMany { step });
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

    fn values(text: &str) -> Result<Vec<f64>, StepsError> {
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
        assert_eq!(values("0:7"), Err(StepsError::Form));
        assert_eq!(values("0:7:1:1"), Err(StepsError::Form));
        for text in ["", "a:7:1", "0:nan:1", "0:7:inf", "0::1"] {
            let error = values(text);
            assert!(matches!(error, Err(StepsError::NotANumber(_))), "{text}");
        }
        for text in ["0:7:0", "0:7:-1", "7:0:1", "0:0:0"] {
            let error = values(text);
            assert!(matches!(error, Err(StepsError::Direction { .. })), "{text}");
        }
        let error = values("0:90:1e-9");
        assert!(matches!(error, Err(StepsError::TooMany { .. })));
    }
}
