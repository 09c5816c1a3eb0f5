//! Units with SI prefixes for display.

use serde::Serialize;

use crate::number::short;

/// Units that take a prefix.
const PREFIXED: [&str; 11] = [
    "m", "m/s", "m/s²", "m/s^2", "Pa", "V", "A", "N", "J", "s", "Hz",
];

/// SI prefixes from 1e-12 to 1e6.
pub const PREFIXES: [&str; 7] = ["p", "n", "µ", "m", "", "k", "M"];

/// A unit for displayed values.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unit {
    /// Symbol; may be empty.
    pub symbol: String,
    /// Factor from the unit of the values to this unit.
    pub factor: f64,
}

impl Unit {
    /// The unit for values up to `largest` in `unit`: with an SI prefix if the unit takes one, else with a
    /// power of ten.
    pub fn of(unit: &str, largest: f64) -> Self {
        let size = Some(largest).filter(|size| size.is_finite() && *size > 0.0);
        let step = size.map_or(0, |size| (size.log10() / 3.0 + 1e-9).floor() as i32);
        // Modal coordinates have a root of the mass before their unit.
        let base = unit.strip_prefix("√kg ").unwrap_or(unit);
        let (step, symbol) = if PREFIXED.contains(&base) {
            // Kilometres of displacement and kiloseconds are not in use.
            let is_large = ["Pa", "V", "A", "N", "Hz"].contains(&base);
            let step = step.clamp(-4, if is_large { 2 } else { 0 });
            let root = &unit[..unit.len() - base.len()];
            let prefix = PREFIXES[(step + 4) as usize];
            (step, format!("{root}{prefix}{base}"))
        } else if (-1..=1).contains(&step) {
            (0, unit.to_owned())
        } else {
            let power = format!("1e{}", 3 * step).replace('-', "−");
            (step, format!("{power} {unit}").trim_end().to_owned())
        };
        Self {
            symbol,
            factor: 10f64.powi(-3 * step),
        }
    }

    /// A value with its unit, such as `3.2 µm`.
    pub fn write(value: f64, unit: &str) -> String {
        let (value, symbol) = if PREFIXED.contains(&unit) {
            let Self { symbol, factor } = Self::of(unit, value.abs());
            (factor * value, symbol)
        } else {
            (value, unit.to_owned())
        };
        format!("{} {symbol}", short(value)).trim_end().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_fit_the_size() {
        let symbol = |unit, largest| Unit::of(unit, largest).symbol;
        assert_eq!(symbol("m", 7e-7), "nm");
        assert_eq!(symbol("m", 1e-6), "µm");
        assert_eq!(symbol("m/s", 0.02), "mm/s");
        assert_eq!(symbol("Hz", 15e3), "kHz");
        assert_eq!(symbol("s", 4e5), "s");
        assert_eq!(symbol("", 0.3), "");
        assert_eq!(symbol("counts", 3e7), "1e6 counts");
        assert_eq!(symbol("√kg m/s", 0.02), "√kg mm/s");
        assert_eq!(Unit::of("m", 0.0).factor, 1.0);
        assert_eq!(Unit::write(0.3, "s"), "300 ms");
        assert_eq!(Unit::write(-2e-5, "counts"), "-2e-5 counts");
        assert_eq!(Unit::write(0.0, ""), "0");
    }
}
