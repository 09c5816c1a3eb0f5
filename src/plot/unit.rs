//! Units with SI prefixes for display.

/// A unit for displayed values.
#[derive(Clone, Debug, PartialEq)]
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
        const PREFIXED: [&str; 10] = ["m", "m/s", "m/s²", "m/s^2", "Pa", "V", "A", "N", "s", "Hz"];
        const PREFIXES: [&str; 7] = ["p", "n", "µ", "m", "", "k", "M"];
        let step = match largest.is_finite() && largest > 0.0 {
            true => (largest.log10() / 3.0 + 1e-9).floor() as i32,
            false => 0,
        };
        if PREFIXED.contains(&unit) {
            // Kilometres of displacement and kiloseconds are not in use.
            let most = if ["Pa", "V", "A", "N", "Hz"].contains(&unit) {
                2
            } else {
                0
            };
            let step = step.clamp(-4, most);
            return Self {
                symbol: format!("{}{unit}", PREFIXES[(step + 4) as usize]),
                factor: 10f64.powi(-3 * step),
            };
        }
        if (-1..=1).contains(&step) {
            return Self {
                symbol: unit.to_owned(),
                factor: 1.0,
            };
        }
        let power = format!("1e{}", 3 * step).replace('-', "−");
        Self {
            symbol: format!("{power} {unit}").trim_end().to_owned(),
            factor: 10f64.powi(-3 * step),
        }
    }

    /// A name with the unit, such as `u, µm`.
    pub fn after(&self, name: &str) -> String {
        match &*self.symbol {
            "" => name.to_owned(),
            symbol => format!("{name}, {symbol}"),
        }
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
        assert_eq!(Unit::of("m", 0.0).factor, 1.0);
        assert_eq!(Unit::of("m", 2e-6).after("u"), "u, µm");
    }
}
