//! Conversion of units: engineering units in scene files, SI units and radians in the program.
//!
//! The program converts inputs only here. The name of a key contains its unit: `tilt_deg`, `load_n`.

use std::f64::consts::{PI, TAU};

/// Unit of a number in a scene file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Symbol for messages and tables; empty for a dimensionless number.
    pub symbol: &'static str,
    /// Factor of the conversion to SI units and radians.
    factor: f64,
    /// Divisor, a power of ten. Unlike its inverse the power is exact in binary, so that the conversion
    /// rounds once: `31.75` mm gives exactly the number of `0.03175` m.
    divisor: f64,
}

const fn unit(symbol: &'static str, factor: f64, divisor: f64) -> Unit {
    Unit {
        symbol,
        factor,
        divisor,
    }
}

pub const ONE: Unit = unit("", 1.0, 1.0);
pub const DEGREE: Unit = unit("deg", PI / 180.0, 1.0);
pub const MILLIMETRE: Unit = unit("mm", 1.0, 1e3);
pub const MICROMETRE: Unit = unit("um", 1.0, 1e6);
pub const MILLISECOND: Unit = unit("ms", 1.0, 1e3);
pub const MICROSECOND: Unit = unit("us", 1.0, 1e6);
pub const HERTZ: Unit = unit("Hz", 1.0, 1.0);
/// A frequency in Hz that is converted to an angular frequency in rad/s.
pub const TURNS_PER_SECOND: Unit = unit("Hz", TAU, 1.0);
pub const KILOHERTZ: Unit = unit("kHz", 1e3, 1.0);
pub const GIGAPASCAL: Unit = unit("GPa", 1e9, 1.0);
pub const MEGAPASCAL: Unit = unit("MPa", 1e6, 1.0);
pub const NEWTON: Unit = unit("N", 1.0, 1.0);
pub const NEWTON_PER_KILOGRAM: Unit = unit("N/kg", 1.0, 1.0);
pub const METRE_PER_SECOND_SQUARED: Unit = unit("m/s^2", 1.0, 1.0);
pub const KILOGRAM_PER_CUBIC_METRE: Unit = unit("kg/m^3", 1.0, 1.0);
pub const METRE_PER_SECOND: Unit = unit("m/s", 1.0, 1.0);
pub const MILLIMETRE_PER_SECOND: Unit = unit("mm/s", 1.0, 1e3);
pub const PER_METRE: Unit = unit("1/m", 1.0, 1.0);
pub const SECOND_PER_METRE: Unit = unit("s/m", 1.0, 1.0);
pub const RADIAN_PER_SECOND: Unit = unit("rad/s", 1.0, 1.0);

impl Unit {
    /// Converts a number to SI units and radians.
    pub fn to_si(self, value: f64) -> f64 {
        value * self.factor / self.divisor
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
