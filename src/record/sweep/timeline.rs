//! The timeline of a sweep: parameter values as integers.
//!
//! The viewer's timelines have sequence numbers or nanoseconds. A tilt of 3.5 deg as 3.5 s would look like a
//! time, so the timeline uses sequence numbers in the largest unit in which every value is an integer:
//! degrees, else thousandths of a degree, and so on.

use crate::number::PREFIXES;

/// Names of the fractions of a unit by powers of a thousand.
const PARTS: [&str; 4] = ["", "thousandths", "millionths", "billionths"];
/// Units whose fractions have prefixes.
const PREFIXED: [&str; 7] = ["deg", "m", "s", "N", "Hz", "Pa", "m/s"];
/// Largest deviation of a value from its tick, as a fraction of the smallest distance of two values.
const MISSED: f64 = 2e-3;
/// Upper limit of ticks; smaller numbers are exact integers in double precision.
const LARGEST: f64 = 1e15;

/// Parameter values as ticks of a timeline.
#[derive(Clone, Debug, PartialEq)]
pub struct TimelineTicks {
    /// Name of the timeline: parameter and unit.
    pub name: String,
    /// The tick of each value.
    pub ticks: Vec<i64>,
}

impl TimelineTicks {
    /// Ticks for ascending values of a parameter with a unit, which may repeat. If no unit makes them integers, they
    /// are numbered.
    pub fn new(name: &str, unit: &str, values: &[f64]) -> Self {
        let mut divided = (0..).zip(PARTS);
        let found = divided.find_map(|(power, _)| Some((power, ticks(values, power)?)));
        match found {
            Some((power, ticks)) => Self {
                name: name_of(name, unit, power as usize),
                ticks,
            },
            None => Self {
                name: format!("{name}, index"),
                ticks: (1..).take(values.len()).collect(),
            },
        }
    }

    /// Mean distance between ticks.
    pub fn gap(&self) -> f64 {
        match self.ticks[..] {
            [first, .., last] => (last - first) as f64 / (self.ticks.len() - 1) as f64,
            _ => 1.0,
        }
    }
}

/// The values in a unit divided by a power of a thousand; `None` if they are not integers.
fn ticks(values: &[f64], power: i32) -> Option<Vec<i64>> {
    let parts = 1e3f64.powi(power);
    let gaps = values.windows(2).map(|pair| pair[1] - pair[0]);
    let gap = gaps.filter(|gap| *gap > 0.0).fold(f64::INFINITY, f64::min);
    let sizes = values.iter().map(|value| value.abs());
    let missed = MISSED * parts * gap.min(sizes.fold(0.0, f64::max));
    let tick = |value: &f64| {
        let exact = parts * value;
        let tick = exact.round();
        ((tick - exact).abs() <= missed && tick.abs() < LARGEST).then_some(tick as i64)
    };
    values.iter().map(tick).collect()
}

/// Name of a timeline.
fn name_of(name: &str, unit: &str, power: usize) -> String {
    let symbol = unit.replace('u', "µ");
    let part = (0..).zip(PREFIXES).find_map(|(k, prefix): (usize, _)| {
        let base = symbol.strip_prefix(prefix)?;
        let part = PREFIXES.get(k.checked_sub(power)?)?;
        PREFIXED.contains(&base).then(|| format!("{part}{base}"))
    });
    let unit = match (part, unit, power) {
        (Some(part), ..) => part,
        (None, "", 0) => return name.to_owned(),
        (None, unit, 0) => unit.to_owned(),
        (None, "", _) => PARTS[power].to_owned(),
        (None, unit, _) => format!("{} of {unit}", PARTS[power]),
    };
    format!("{name}, {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timeline(unit: &str, values: &[f64]) -> (String, Vec<i64>) {
        let TimelineTicks { name, ticks } = TimelineTicks::new("load", unit, values);
        (name, ticks)
    }

    #[test]
    fn values_are_integers_in_the_largest_suitable_unit() {
        let case = |unit, values: &[f64], name: &str, ticks: &[i64]| {
            assert_eq!(timeline(unit, values), (name.to_owned(), ticks.to_vec()));
        };
        case("deg", &[-1.0, 0.0, 8.0], "load, deg", &[-1, 0, 8]);
        case("deg", &[1.0, 1.5, 2.0], "load, mdeg", &[1000, 1500, 2000]);
        case("", &[2.0, 4.0], "load", &[2, 4]);
        case("", &[0.1, 0.3], "load, thousandths", &[100, 300]);
        // Sums of steps that are not exact in binary.
        case("um", &[0.1, 0.1 + 0.2], "load, nm", &[100, 300]);
        case("kg/m^3", &[2.5], "load, thousandths of kg/m^3", &[2500]);
        case("", &[0.5e-6, 1e-6], "load, billionths", &[500, 1000]);
        case("GPa", &[0.5, 1.0], "load, MPa", &[500, 1000]);
        case("mm/s", &[0.5], "load, µm/s", &[500]);
        case("N", &[1e-12, 2e-12], "load, index", &[1, 2]);
        case("N", &[0.0], "load, N", &[0]);
        case("N", &[], "load, N", &[]);
        let (name, ticks) = timeline("N", &[1.0, 4.0 / 3.0, 5.0 / 3.0]);
        assert_eq!((&*name, ticks[1]), ("load, mN", 1333));
    }
}
