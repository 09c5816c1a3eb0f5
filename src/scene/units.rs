//! The border of the units: engineering units in a scene file, SI and radians inside.
//!
//! Nothing else in the crate converts on the way in. A key carries its unit in its name:
//! `tilt_deg`, `load_n`.

/// The unit in which a scene file states a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    /// A pure number.
    One,
    /// Degree of arc.
    Degree,
    /// Millimetre.
    Millimetre,
    /// Micrometre.
    Micrometre,
    /// Millisecond.
    Millisecond,
    /// Microsecond.
    Microsecond,
    /// Hertz.
    Hertz,
    /// Kilohertz.
    Kilohertz,
    /// Gigapascal.
    Gigapascal,
    /// Newton.
    Newton,
    /// Newton per kilogram.
    NewtonPerKilogram,
    /// Metre per second squared.
    MetrePerSecondSquared,
    /// Kilogram per cubic metre.
    KilogramPerCubicMetre,
    /// Millimetre per second.
    MillimetrePerSecond,
    /// Second per metre.
    SecondPerMetre,
    /// Radian per second.
    RadianPerSecond,
}

impl Unit {
    /// The value in SI units and radians.
    ///
    /// Small units are divided by a power of ten rather than multiplied by its inverse: the
    /// power is exact in binary and its inverse is not, so there is one rounding only, and
    /// `31.75` mm gives the very number that `0.03175` m would.
    pub fn to_si(self, value: f64) -> f64 {
        match self {
            Self::One
            | Self::Hertz
            | Self::Newton
            | Self::NewtonPerKilogram
            | Self::MetrePerSecondSquared
            | Self::KilogramPerCubicMetre
            | Self::SecondPerMetre
            | Self::RadianPerSecond => value,
            Self::Degree => value.to_radians(),
            Self::Millimetre | Self::Millisecond | Self::MillimetrePerSecond => value / 1e3,
            Self::Micrometre | Self::Microsecond => value / 1e6,
            Self::Kilohertz => value * 1e3,
            Self::Gigapascal => value * 1e9,
        }
    }

    /// The number stated for a value in SI units and radians, to twelve digits or so.
    pub fn of_si(self, value: f64) -> f64 {
        value / self.to_si(1.0)
    }

    /// The unit's symbol for messages and tables; empty for a pure number.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::One => "",
            Self::Degree => "deg",
            Self::Millimetre => "mm",
            Self::Micrometre => "um",
            Self::Millisecond => "ms",
            Self::Microsecond => "us",
            Self::Hertz => "Hz",
            Self::Kilohertz => "kHz",
            Self::Gigapascal => "GPa",
            Self::Newton => "N",
            Self::NewtonPerKilogram => "N/kg",
            Self::MetrePerSecondSquared => "m/s^2",
            Self::KilogramPerCubicMetre => "kg/m^3",
            Self::MillimetrePerSecond => "mm/s",
            Self::SecondPerMetre => "s/m",
            Self::RadianPerSecond => "rad/s",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversions_round_once() {
        assert_eq!(Unit::Millimetre.to_si(31.75), 0.03175);
        assert_eq!(Unit::Micrometre.to_si(0.75), 0.75e-6);
        assert_eq!(Unit::Millisecond.to_si(300.0), 0.3);
        assert_eq!(Unit::Microsecond.to_si(1.5), 1.5e-6);
        assert_eq!(Unit::Kilohertz.to_si(200.0), 2e5);
        assert_eq!(Unit::Gigapascal.to_si(207.0), 2.07e11);
        assert_eq!(Unit::MillimetrePerSecond.to_si(15.75), 0.01575);
        assert_eq!(Unit::Degree.to_si(180.0), std::f64::consts::PI);
        assert_eq!(Unit::Newton.to_si(150.0), 150.0);
    }
}
