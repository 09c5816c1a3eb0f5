//! Checks that a system can be integrated.

use crate::dynamics::{DynamicsError, System};

/// Checks that every mode is an oscillator.
pub(super) fn check_modes<Y: System + ?Sized>(sys: &Y) -> Result<(), DynamicsError> {
    if !sys.damping().is_empty() {
        check_size(
            "the list of damping ratios",
            sys.modes(),
            sys.damping().len(),
        )?;
    }
    for (mode, &omega) in sys.omega().iter().enumerate() {
        let damping = sys.damping().get(mode).copied().unwrap_or(0.0);
        if !(omega >= 0.0 && omega.is_finite() && damping.abs() < 1.0) {
            return Err(DynamicsError::Mode {
                mode,
                omega,
                damping,
            });
        }
    }
    Ok(())
}

/// Checks the length of a slice.
pub(super) fn check_size(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), DynamicsError> {
    if expected == found {
        Ok(())
    } else {
        Err(DynamicsError::Size {
            what,
            expected,
            found,
        })
    }
}
