//! Evenly spaced numbers as written on the command line: `A:B:STEP`.

use std::str::FromStr;

use thiserror::Error;

/// Evenly spaced numbers, both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    from: f64,
    step: f64,
    steps: u32,
}

impl Steps {
    /// The most steps there may be.
    const MOST: f64 = 10_000.0;

    /// The numbers in order, each the nearest to a short decimal.
    pub fn values(self) -> impl Iterator<Item = f64> {
        let Self { from, step, steps } = self;
        // A multiple of the step each, so that no rounding adds up; and 2.4 rather than
        // 2.4000000000000004, since that is what was meant.
        (0..=steps).map(move |k| {
            let value = from + f64::from(k) * step;
            format!("{value:.11e}").parse().unwrap_or(value)
        })
    }
}

/// Why a text is no [`Steps`].
#[derive(Clone, Debug, Error, PartialEq)]
pub enum StepsError {
    /// Neither one number nor three.
    #[error("write one number, or A:B:STEP, such as 0:7:0.5")]
    Form,
    /// No `KEY=` before the numbers.
    #[error("write KEY=A:B:STEP, such as contact.stiffness_factor=1:20:0.5")]
    NoKey,
    /// A part that is not a finite number.
    #[error("`{0}` is not a number; write A:B:STEP, such as 0:7:0.5")]
    NotANumber(String),
    /// A tilt past the horizontal.
    #[error("a tilt of {0} is out of range; it must be from -90 to 90 degrees")]
    TiltOutOfRange(f64),
    /// A step that does not lead from A to B.
    #[error("a step of {step} does not lead from {from} to {to}; give it the other sign, not 0")]
    Direction {
        /// The first number.
        from: f64,
        /// The last number.
        to: f64,
        /// The step.
        step: f64,
    },
    /// More steps than anyone would read.
    #[error(
        "a step of {step} makes more than {} numbers; make it larger",
        Steps::MOST
    )]
    TooMany {
        /// The step.
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
        // A hair more than the quotient, so that 0:0.3:0.1 ends at 0.3 in spite of rounding.
        let steps = ((to - from) / step + 1e-9).floor();
        if step == 0.0 || steps < 0.0 {
            return Err(StepsError::Direction { from, to, step });
        }
        if steps >= Self::MOST {
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
    fn bad_steps_say_why() {
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
