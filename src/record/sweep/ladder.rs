//! The timeline of a sweep: a parameter's values as whole numbers.
//!
//! The viewer's timelines count whole numbers or nanoseconds. A tilt of 3.5 deg as 3.5 s would read
//! as a time; so it counts, in the largest unit in which every value is a whole number: degrees if
//! all are, else thousandths of them, and so on.

/// Powers of a thousand by which a unit is divided, and what such a part is called.
const PARTS: [&str; 4] = ["", "thousandths", "millionths", "billionths"];
/// Units with parts that have a name of their own: the thousandth, the millionth.
const NAMED: [(&str, [&str; 3]); 10] = [
    ("deg", ["deg", "mdeg", "µdeg"]),
    ("mm", ["mm", "µm", "nm"]),
    ("um", ["µm", "nm", "pm"]),
    ("ms", ["ms", "µs", "ns"]),
    ("us", ["µs", "ns", "ps"]),
    ("N", ["N", "mN", "µN"]),
    ("Hz", ["Hz", "mHz", "µHz"]),
    ("kHz", ["kHz", "Hz", "mHz"]),
    ("GPa", ["GPa", "MPa", "kPa"]),
    ("mm/s", ["mm/s", "µm/s", "nm/s"]),
];
/// By how much a value may miss its tick, as a share of the least distance of two values.
const MISSED: f64 = 2e-3;
/// Ticks are smaller than this: numbers below it are whole exactly.
const LARGEST: f64 = 1e15;

/// A parameter's values as ticks of a timeline.
#[derive(Clone, Debug, PartialEq)]
pub struct Ladder {
    /// Name of the timeline: what it counts, and in which unit.
    pub name: String,
    /// The tick of each value.
    pub ticks: Vec<i64>,
}

impl Ladder {
    /// For these values, rising, of something that is called so and has a unit. Where no unit makes them
    /// whole numbers they are just counted.
    pub fn new(name: &str, unit: &str, values: &[f64]) -> Self {
        let mut divided = (0..).zip(PARTS);
        let found = divided.find_map(|(power, _)| Some((power, ticks(values, power)?)));
        match found {
            Some((power, ticks)) => Self {
                name: name_of(name, unit, power as usize),
                ticks,
            },
            None => Self {
                name: format!("{name}, numbered"),
                ticks: (1..).take(values.len()).collect(),
            },
        }
    }

    /// Mean distance of neighbouring ticks.
    pub fn gap(&self) -> f64 {
        match self.ticks[..] {
            [first, .., last] => (last - first) as f64 / (self.ticks.len() - 1) as f64,
            _ => 1.0,
        }
    }
}

/// The values in a unit divided by a power of a thousand, if these are whole numbers.
fn ticks(values: &[f64], power: i32) -> Option<Vec<i64>> {
    let parts = 1e3f64.powi(power);
    let gaps = values.windows(2).map(|pair| pair[1] - pair[0]);
    let gap = gaps.fold(f64::INFINITY, f64::min);
    let sizes = values.iter().map(|value| value.abs());
    let missed = MISSED * parts * gap.min(sizes.fold(0.0, f64::max));
    let tick = |value: &f64| {
        let exact = parts * value;
        let tick = exact.round();
        ((tick - exact).abs() <= missed && tick.abs() < LARGEST).then_some(tick as i64)
    };
    values.iter().map(tick).collect()
}

/// What a timeline counts.
fn name_of(name: &str, unit: &str, power: usize) -> String {
    let named = NAMED.iter().find(|(symbol, _)| *symbol == unit);
    let part = named.and_then(|(_, parts)| parts.get(power));
    let unit = match (part, unit, power) {
        (Some(part), ..) => (*part).to_owned(),
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

    fn ladder(unit: &str, values: &[f64]) -> (String, Vec<i64>) {
        let Ladder { name, ticks } = Ladder::new("load", unit, values);
        (name, ticks)
    }

    #[test]
    fn values_are_whole_numbers_of_the_largest_unit_that_serves() {
        let case = |unit, values: &[f64], name: &str, ticks: &[i64]| {
            assert_eq!(ladder(unit, values), (name.to_owned(), ticks.to_vec()));
        };
        case("deg", &[-1.0, 0.0, 8.0], "load, deg", &[-1, 0, 8]);
        case("deg", &[1.0, 1.5, 2.0], "load, mdeg", &[1000, 1500, 2000]);
        case("", &[2.0, 4.0], "load", &[2, 4]);
        case("", &[0.1, 0.3], "load, thousandths", &[100, 300]);
        // Sums of steps that binary numbers do not have.
        case("um", &[0.1, 0.1 + 0.2], "load, nm", &[100, 300]);
        case("kg/m^3", &[2.5], "load, thousandths of kg/m^3", &[2500]);
        case("", &[0.5e-6, 1e-6], "load, billionths", &[500, 1000]);
        case("N", &[1e-12, 2e-12], "load, numbered", &[1, 2]);
        case("N", &[0.0], "load, N", &[0]);
        case("N", &[], "load, N", &[]);
        let (name, ticks) = ladder("N", &[1.0, 4.0 / 3.0, 5.0 / 3.0]);
        assert_eq!((&*name, ticks[1]), ("load, mN", 1333));
    }
}
