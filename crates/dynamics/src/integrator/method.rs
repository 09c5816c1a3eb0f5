//! The integration methods and their parameters.

use strum::VariantArray;

use crate::DynamicsError;
use crate::error_control::Accuracy;
use crate::step_controller::StepController;

/// An integration method with its parameters: [`MethodName::with`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// The method.
    pub name: MethodName,
    /// Error tolerance per step. A method with a fixed step has none.
    pub accuracy: Accuracy,
    /// Maximum step, s. The integration fails if it needs less than 1e-10 of this. A method with a fixed
    /// step takes this step.
    pub max_step: f64,
}

/// An integration method.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, strum::VariantArray, strum::IntoStaticStr, strum::EnumString,
)]
#[strum(serialize_all = "kebab-case")]
pub enum MethodName {
    /// Exponential pair of order 5(4) with exact free vibration: Lawson's integrating factor with the
    /// pair of Tsitouras. The default.
    Lawson54,
    /// Exponential method of order 8(5, 3) with exact free vibration: Lawson's integrating factor with
    /// the tableau of [`MethodName::Dop853`]; dense output of order 7.
    Lawson853,
    /// Embedded pair of order 5(4) of Tsitouras, plain form.
    Tsit5,
    /// Embedded method of order 8(5, 3) of Dormand and Prince, plain form, with dense output of order 7.
    /// More efficient than order 5 below relative errors of about 1e-8 on a smooth problem.
    Dop853,
    /// Rodas5P, a linearly implicit (Rosenbrock) method of order 5(4), for systems that are stiff throughout.
    /// Needs [`System::differentiable`](crate::System::differentiable).
    #[strum(to_string = "rodas5p")]
    Rodas5P,
    /// [`MethodName::Lawson54`], and [`MethodName::Rodas5P`] while stiffness limits the explicit step, for
    /// example during the transition from sliding to sticking. Needs
    /// [`System::differentiable`](crate::System::differentiable).
    Auto,
    /// Classical Runge–Kutta method of order 4, with a fixed step.
    Rk4,
}

impl MethodName {
    /// All method names.
    pub const ALL: &[Self] = Self::VARIANTS;

    /// The name on the command line and in scene files, for example `lawson54`.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Whether the method takes fixed steps, without error estimate.
    pub const fn has_fixed_step(self) -> bool {
        matches!(self, Self::Rk4)
    }

    /// The method with the given parameters. A fixed-step method uses `max_step` (s) as its step.
    pub const fn with(self, accuracy: Accuracy, max_step: f64) -> Method {
        Method {
            name: self,
            accuracy,
            max_step,
        }
    }
}

impl Method {
    /// Whether the method needs the derivative of the force.
    pub(crate) fn needs_derivative(self) -> bool {
        matches!(self.name, MethodName::Rodas5P | MethodName::Auto)
    }

    /// The step-size control, with checked parameters.
    pub(super) fn controller(self) -> Result<StepController, DynamicsError> {
        let is_fixed = self.name.has_fixed_step();
        if !is_fixed {
            self.accuracy.check()?;
        }
        if !(self.max_step > 0.0 && self.max_step.is_finite()) {
            return Err(DynamicsError::Parameter {
                name: if is_fixed {
                    "the step"
                } else {
                    "the maximum step"
                },
                value: self.max_step,
                allowed: "positive and finite",
            });
        }
        let accuracy = (!is_fixed).then_some(self.accuracy);
        let implicit = self.needs_derivative();
        Ok(StepController::new(accuracy, self.max_step, implicit))
    }
}

#[cfg(test)]
mod tests {
    use super::MethodName;

    #[test]
    fn names_are_parsed() {
        for method in MethodName::ALL {
            assert_eq!(method.name().parse(), Ok(*method));
        }
        assert_eq!(MethodName::Tsit5.name(), "tsit5");
        assert_eq!(MethodName::Rodas5P.name(), "rodas5p");
    }
}
