//! Conversion of units: engineering units in scene files, SI units and radians in the program.
//!
//! The program converts inputs only here. The name of a key contains its unit: `tilt_deg`, `load_n`.

use std::f64::consts::TAU;

/// Unit of a number in a scene file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Symbol for messages and tables; empty for a dimensionless number.
    pub symbol: &'static str,
    scale: Scale,
}

/// Conversion to SI units and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Scale {
    Times(f64),
    /// Division by a power of ten. Unlike its inverse the power is exact in binary, so that the conversion
    /// rounds once: `31.75` mm gives exactly the number of `0.03175` m.
    Over(f64),
    Degrees,
}

const fn unit(symbol: &'static str, scale: Scale) -> Unit {
    Unit { symbol, scale }
}

use Scale::{Degrees, Over, Times};

pub const ONE: Unit = unit("", Times(1.0));
pub const DEGREE: Unit = unit("deg", Degrees);
pub const MILLIMETRE: Unit = unit("mm", Over(1e3));
pub const MICROMETRE: Unit = unit("um", Over(1e6));
pub const MILLISECOND: Unit = unit("ms", Over(1e3));
pub const MICROSECOND: Unit = unit("us", Over(1e6));
pub const HERTZ: Unit = unit("Hz", Times(1.0));
/// A frequency in Hz that is converted to an angular frequency in rad/s.
pub const TURNS_PER_SECOND: Unit = unit("Hz", Times(TAU));
pub const KILOHERTZ: Unit = unit("kHz", Times(1e3));
pub const GIGAPASCAL: Unit = unit("GPa", Times(1e9));
pub const MEGAPASCAL: Unit = unit("MPa", Times(1e6));
pub const NEWTON: Unit = unit("N", Times(1.0));
pub const NEWTON_PER_KILOGRAM: Unit = unit("N/kg", Times(1.0));
pub const METRE_PER_SECOND_SQUARED: Unit = unit("m/s^2", Times(1.0));
pub const KILOGRAM_PER_CUBIC_METRE: Unit = unit("kg/m^3", Times(1.0));
pub const METRE_PER_SECOND: Unit = unit("m/s", Times(1.0));
pub const MILLIMETRE_PER_SECOND: Unit = unit("mm/s", Over(1e3));
pub const PER_METRE: Unit = unit("1/m", Times(1.0));
pub const SECOND_PER_METRE: Unit = unit("s/m", Times(1.0));
pub const RADIAN_PER_SECOND: Unit = unit("rad/s", Times(1.0));

impl Unit {
    /// Converts a number to SI units and radians.
    pub fn to_si(self, value: f64) -> f64 {
        match self.scale {
            Times(factor) => value * factor,
            Over(divisor) => value / divisor,
            Degrees => value.to_radians(),
        }
    }

    /// Converts back from SI units and radians, with about twelve significant digits.
    pub fn of_si(self, value: f64) -> f64 {
        value / self.to_si(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversions_round_once() {
        assert_eq!(MILLIMETRE.to_si(31.75), 0.03175);
        assert_eq!(MICROMETRE.to_si(0.75), 0.75e-6);
        assert_eq!(MILLISECOND.to_si(300.0), 0.3);
        assert_eq!(MICROSECOND.to_si(1.5), 1.5e-6);
        assert_eq!(KILOHERTZ.to_si(200.0), 2e5);
        assert_eq!(GIGAPASCAL.to_si(207.0), 2.07e11);
        assert_eq!(MILLIMETRE_PER_SECOND.to_si(15.75), 0.01575);
        assert_eq!(DEGREE.to_si(180.0), std::f64::consts::PI);
        assert_eq!(NEWTON.to_si(150.0), 150.0);
        assert_eq!(TURNS_PER_SECOND.to_si(200.0), TAU * 200.0);
    }
}
