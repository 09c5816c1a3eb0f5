//! Axes: quantity, unit with an SI prefix, range, scale and ticks.

use serde::Serialize;

use super::text::shown;
use crate::analysis::stats::range;
use crate::number::{brief, prefix, rounded, short, without_zeros};

/// An axis of a panel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Axis {
    /// The quantity; may be empty.
    pub name: String,
    /// The unit in which the values are written.
    pub unit: Unit,
    /// Smallest and largest value shown; like the values of the layers without the prefix of the unit.
    pub range: [f64; 2],
    /// The mapping of values to positions.
    pub scale: Scale,
    /// Names of the rows of [`Scale::Rows`], from the top.
    pub names: Vec<String>,
}

/// The scale of an axis: the mapping of values to positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Scale {
    /// Linear.
    Linear,
    /// Linear, with ticks at integers only.
    Integer,
    /// Logarithmic; values must be positive.
    Logarithmic,
    /// Named rows of height 1, the last at the bottom between 0 and 1.
    Rows,
}

/// Largest number of ticks at 1, 2 and 5 times powers of ten; with more, only powers of ten get ticks.
const MOST_ROUND: usize = 9;
/// First digits of the distance of two ticks.
pub const TICK_STEPS: [f64; 4] = [1.0, 2.0, 2.5, 5.0];
/// First digits of a full scale.
pub const FULL_SCALES: [f64; 8] = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0];

impl Axis {
    /// A linear axis over a range. `name` is the quantity, optionally followed by a comma and a unit that takes no
    /// prefix. An empty or non-finite range is widened so that it can be drawn.
    pub fn linear(name: impl AsRef<str>, range: [f64; 2]) -> Self {
        let name = name.as_ref();
        let (name, unit) = name.rsplit_once(", ").unwrap_or((name, ""));
        Self {
            name: name.to_owned(),
            unit: Unit {
                symbol: unit.to_owned(),
                factor: 1.0,
            },
            range: drawable(range),
            scale: Scale::Linear,
            names: Vec::new(),
        }
    }

    /// A linear axis of cells around ascending values: half a step beyond the first and the last.
    pub fn cells(name: impl AsRef<str>, values: &[f64]) -> Self {
        let [low, high] = range(values.iter().copied());
        let half = match values.len() {
            0 | 1 => 0.5,
            count => 0.5 * (high - low) / (count - 1) as f64,
        };
        Self::linear(name, [low - half, high + half])
    }

    /// Sets the unit of the values; they are written with the SI prefix that suits the range.
    pub fn of(self, unit: &str) -> Self {
        let unit = Unit::of(unit, self.range[0].abs().max(self.range[1].abs()));
        self.written_in(unit)
    }

    /// Sets the unit in which the values are written.
    pub fn written_in(self, unit: Unit) -> Self {
        Self { unit, ..self }
    }

    /// A linear axis of the integers from 1 to `count`, with half a unit of margin at each end.
    pub fn integers(name: impl AsRef<str>, count: usize) -> Self {
        Self {
            scale: Scale::Integer,
            ..Self::linear(name, [0.5, count.max(1) as f64 + 0.5])
        }
    }

    /// Named rows from the top.
    pub fn rows(names: Vec<String>) -> Self {
        let range = [0.0, names.len().max(1) as f64];
        Self {
            scale: Scale::Rows,
            names,
            ..Self::linear("", range)
        }
    }

    /// The centre of a row.
    pub fn row(&self, number: usize) -> f64 {
        self.range[1] - 0.5 - number as f64
    }

    /// A logarithmic axis between two positive values.
    pub fn logarithmic(name: impl AsRef<str>, range: [f64; 2]) -> Self {
        Self {
            scale: Scale::Logarithmic,
            ..Self::linear(name, range)
        }
    }

    /// A logarithmic axis from `10^low` to `10^high`.
    pub fn decades(name: impl AsRef<str>, [low, high]: [i32; 2]) -> Self {
        Self::logarithmic(name, [10f64.powi(low), 10f64.powi(high.max(low + 1))])
    }

    /// A logarithmic axis that encloses the positive `values`, with ends at 1, 2 or 5 times a power of ten.
    pub fn rounded_logarithmic(name: impl AsRef<str>, values: impl Iterator<Item = f64>) -> Self {
        let [low, high] = match range(values.filter(|value| *value > 0.0)) {
            [low, high] if low < high => [low, high],
            [only, same] if only == same => [0.7 * only, 1.5 * only],
            _ => [0.1, 1.0],
        };
        let round = round_numbers(low, high);
        let below = round.iter().rfind(|value| **value <= low * (1.0 + 1e-9));
        let above = round.iter().find(|value| **value >= high * (1.0 - 1e-9));
        let ends = [*below.unwrap_or(&low), *above.unwrap_or(&high)];
        Self::logarithmic(name, ends)
    }

    /// A linear axis that contains all `values` and a margin of 5 % at each end.
    pub fn with_margin(name: impl AsRef<str>, values: impl Iterator<Item = f64>) -> Self {
        let [low, high] = extent(values);
        let margin = 0.05 * (high - low);
        Self::linear(name, [low - margin, high + margin])
    }

    /// Quantity and unit, such as `tilt, deg`.
    pub fn label(&self) -> String {
        let parts = [&*self.name, &*self.unit.symbol].into_iter();
        let parts: Vec<&str> = parts.filter(|part| !part.is_empty()).collect();
        parts.join(", ")
    }

    /// Relative position of a value: 0 at the lower end, 1 at the upper. Not finite if the value has no
    /// position.
    pub fn fraction(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        match self.scale {
            Scale::Linear | Scale::Integer | Scale::Rows => (value - low) / (high - low),
            Scale::Logarithmic => {
                let value = value.max(f64::MIN_POSITIVE);
                (value / low).ln() / (high / low).ln()
            }
        }
    }

    /// Values that are round in the unit of the axis, at most about `most`, with their labels: decimals, or powers of ten
    /// if any is very small or large.
    pub fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        let [low, high] = self.range.map(|end| self.unit.factor * end);
        let rough = (high - low) / most.max(1) as f64;
        let ticks = match self.scale {
            Scale::Rows => {
                let rows = self.names.iter().enumerate();
                return rows.map(|(k, name)| (self.row(k), name.clone())).collect();
            }
            Scale::Linear => multiples(low, high, round_step(rough, &TICK_STEPS)),
            Scale::Integer => multiples(low, high, round_step(rough.max(1.0), &[1.0, 2.0, 5.0])),
            Scale::Logarithmic => {
                let inside = |v: &f64| low * (1.0 - 1e-9) <= *v && *v <= high * (1.0 + 1e-9);
                let mut ticks = round_numbers(low, high);
                ticks.retain(inside);
                let is_power = |tick: &f64| (tick.log10() - tick.log10().round()).abs() < 1e-9;
                let powers: Vec<f64> = ticks.iter().copied().filter(is_power).collect();
                if ticks.len() > most.min(MOST_ROUND) && powers.len() > 1 {
                    ticks = powers;
                }
                let step = ticks.len().div_ceil(most.max(1)).max(1);
                ticks.into_iter().step_by(step).collect()
            }
        };
        let (decimals, plain) = match self.scale {
            Scale::Logarithmic => (3, ticks.iter().all(|tick| (1e-3..1e5).contains(tick))),
            // As many as distinguish the values of the range.
            _ => (
                (2.0 - (high - low).log10().floor()).clamp(0.0, 6.0) as usize,
                (1e-3..1e5).contains(&low.abs().max(high.abs())),
            ),
        };
        let ticks = ticks.into_iter().map(|tick| {
            let label = if plain || tick == 0.0 {
                without_zeros(&rounded(tick, decimals)).to_owned()
            } else {
                format!("{tick:.1e}").replace(".0e", "e")
            };
            (tick / self.unit.factor, shown(&label))
        });
        ticks.collect()
    }
}

/// A key of a scene as the name of an axis or row: its table and its words, then the unit.
pub fn readable(path: &str, unit: &str) -> String {
    if path == "load.tilt_deg" {
        return "tilt, deg".to_owned();
    }
    let (table, key) = path.rsplit_once('.').unwrap_or(("", path));
    let symbol = unit.to_lowercase().replace("1/", "/").replace('^', "");
    let symbol = symbol.replace('²', "2").replace('µ', "u");
    let endings = ["_per_", "_"].map(|per| symbol.replace('/', per));
    let strip = |ending: &String| key.strip_suffix(&**ending);
    let name = endings.iter().find_map(strip).unwrap_or(key);
    let name = name.trim_end_matches('_').replace("mu_", "μ");
    let name = name.replace("stribeck", "Stribeck");
    // Keys of a belt already contain the word.
    let is_said = name.starts_with(table) || table.ends_with("_belt");
    let table = if is_said { "" } else { table };
    let label = format!("{table} {name}").replace('_', " ") + ", " + unit;
    label.trim_start().trim_end_matches(", ").to_owned()
}

/// The values 1, 2 and 5 times powers of ten that enclose two positive values, in ascending order.
fn round_numbers(low: f64, high: f64) -> Vec<f64> {
    let powers = low.log10().floor() as i32 - 1..=high.log10().ceil() as i32 + 1;
    let round = powers.flat_map(|k| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(k)));
    round.collect()
}

/// The smallest of `digits` times a power of ten that is not below `least`.
fn round_step(least: f64, digits: &[f64]) -> f64 {
    let decade = 10f64.powf(least.log10().floor());
    let digits = digits.iter().chain(&[10.0]);
    let mut steps = digits.map(|digit| digit * decade);
    let step = steps.find(|step| *step >= least * (1.0 - 1e-9));
    step.unwrap_or(least)
}

/// The smallest round number (one of [`FULL_SCALES`] times a power of ten) that is not below `x` (positive).
pub fn round_up(x: f64) -> f64 {
    round_step(x, &FULL_SCALES)
}

/// The full scale of a plot: a round number that changes only if the data exceed it or fall far below it, so
/// that the plot does not rescale continuously.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FullScale(f64);

impl FullScale {
    /// Starts at the smallest scale.
    pub fn new(smallest: f64) -> Self {
        Self(round_up(smallest))
    }

    /// The current full scale.
    pub fn get(self) -> f64 {
        self.0
    }

    /// Updates the scale with the largest magnitude shown; returns whether it changed.
    pub fn update(&mut self, peak: f64, smallest: f64) -> bool {
        let before = self.0;
        if peak.is_finite() && (peak > self.0 || peak < 0.3 * self.0) {
            self.0 = round_up(peak.max(smallest));
        }
        self.0 != before
    }
}

fn multiples(low: f64, high: f64, step: f64) -> Vec<f64> {
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last).map(|k| k as f64 * step).collect()
}

/// Smallest and largest of the finite values; `[0, 1]` if there is none.
pub fn extent(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] = range(values.filter(|v| v.is_finite()));
    if low <= high { [low, high] } else { [0.0, 1.0] }
}

/// The lower end of an axis of growth rates, from the smallest and the largest: overdamped modes would determine it.
pub fn lowest_growth([low, high]: [f64; 2]) -> f64 {
    let bound = if high > 0.0 { -1.2 * high } else { low };
    low.max(bound)
}

fn drawable([low, high]: [f64; 2]) -> [f64; 2] {
    let usable = low.is_finite() && high.is_finite() && low <= high;
    let [low, high] = if usable { [low, high] } else { [0.0, 1.0] };
    let least = 1e-9 * low.abs().max(high.abs());
    if high - low > least {
        return [low, high];
    }
    let half = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
    [low - half, high + half]
}

/// Units that take a prefix.
const PREFIXED: [&str; 11] = [
    "m", "m/s", "m/s²", "m/s^2", "Pa", "V", "A", "N", "J", "s", "Hz",
];

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
            let root = &unit[..unit.len() - base.len()];
            let (step, prefix) = prefix(step, base);
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
        if PREFIXED.contains(&unit) {
            return brief(value, unit);
        }
        format!("{} {unit}", short(value)).trim_end().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_can_always_be_drawn() {
        for range in [[0.0, 0.0], [3.0, 3.0], [f64::NAN, 1.0], [2.0, -2.0]] {
            let axis = Axis::linear("x", range);
            assert!(axis.range[1] > axis.range[0], "{range:?}");
        }
        assert_eq!(Axis::with_margin("x", [].into_iter()).range, [-0.05, 1.05]);
        assert_eq!(Axis::decades("x", [2, 2]).range, [100.0, 1000.0]);
    }

    #[test]
    fn names_have_units() {
        let axis = Axis::linear("tilt of the load, deg", [0.0, 1.0]);
        assert_eq!(
            (&*axis.name, &*axis.unit.symbol),
            ("tilt of the load", "deg")
        );
        assert_eq!(axis.label(), "tilt of the load, deg");
        assert_eq!(Axis::linear("p", [0.0, 1.0]).label(), "p");
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let values = |axis: &Axis, most| -> Vec<f64> {
            axis.ticks(most).into_iter().map(|(tick, _)| tick).collect()
        };
        let ticks = |range, most| values(&Axis::linear("x", range), most);
        assert_eq!(ticks([0.0, 15.0], 5), [0.0, 5.0, 10.0, 15.0]);
        assert_eq!(ticks([-2.0, 2.0], 4), [-2.0, -1.0, 0.0, 1.0, 2.0]);
        assert_eq!(values(&Axis::integers("k", 3), 8), [1.0, 2.0, 3.0]);
        assert_eq!(Axis::integers("k", 22).ticks(8).len(), 4);
        assert_eq!(Axis::decades("x", [-4, 1]).ticks(9).len(), 6);
        assert_eq!(Axis::decades("x", [-16, 0]).ticks(9).len(), 9);
        let close = Axis::rounded_logarithmic("calls", [1600.0, 40e3].into_iter());
        assert_eq!(close.range, [1e3, 5e4]);
        assert_eq!(values(&close, 9), [1e3, 2e3, 5e3, 1e4, 2e4, 5e4]);
        let close = Axis::rounded_logarithmic("calls", [30.0, 3e5].into_iter());
        assert_eq!(values(&close, 9), [1e2, 1e3, 1e4, 1e5]);
    }

    #[test]
    fn ticks_are_short() {
        let labels = |axis: Axis, most| -> Vec<String> {
            axis.ticks(most)
                .into_iter()
                .map(|(_, label)| label)
                .collect()
        };
        let linear = |range| labels(Axis::linear("x", range), 2);
        assert_eq!(linear([0.0, 1.0]), ["0", "0.5", "1"]);
        assert_eq!(linear([-40.0, 0.0]), ["−40", "−20", "0"]);
        assert_eq!(linear([0.0, 4e-7]), ["0", "2 × 10⁻⁷", "4 × 10⁻⁷"]);
        assert_eq!(linear([0.0, 4000.0]), ["0", "2000", "4000"]);
        assert_eq!(without_zeros(&rounded(-1e-17, 2)), "0");
        let powers = |ends, most| labels(Axis::decades("x", ends), most);
        assert_eq!(powers([-6, 0], 3), ["10⁻⁶", "10⁻³", "10⁰"]);
        assert_eq!(powers([-1, 2], 4), ["0.1", "1", "10", "100"]);
        let close = Axis::logarithmic("x", [2e3, 5e4]);
        assert_eq!(
            labels(close, 9),
            ["2000", "5000", "10000", "20000", "50000"]
        );
    }

    #[test]
    fn values_are_written_with_a_prefix() {
        let axis = Axis::linear("u", [-2e-6, 2e-6]).of("m");
        assert_eq!(axis.label(), "u, µm");
        let labels = axis.ticks(2).into_iter().map(|(_, label)| label);
        assert_eq!(labels.collect::<Vec<_>>(), ["−2", "0", "2"]);
        assert!((axis.ticks(2)[0].0 + 2e-6).abs() < 1e-18);
    }

    #[test]
    fn full_scale_is_constant_within_its_band() {
        let mut scale = FullScale::new(1e-3);
        assert!(scale.update(0.9, 1e-3));
        assert!((scale.get() - 1.0).abs() < 1e-12);
        assert!(!scale.update(0.31, 1e-3), "within the band");
        assert!(scale.update(0.1, 1e-3));
        assert!((scale.get() - 0.1).abs() < 1e-12);
        assert!(
            scale.update(0.0, 1e-3),
            "a zero signal has the smallest scale"
        );
        assert!((scale.get() - 1e-3).abs() < 1e-12);
        assert!(!scale.update(f64::NAN, 1e-3));
    }

    #[test]
    fn keys_are_readable() {
        for (path, unit, name) in [
            ("load.tilt_deg", "deg", "tilt, deg"),
            ("load.load_n", "N", "load, N"),
            ("friction.mu_s", "", "friction μs"),
            (
                "friction.stribeck_slope_s_per_m",
                "s/m",
                "friction Stribeck slope, s/m",
            ),
            (
                "friction.bristle_stiffness_per_m",
                "1/m",
                "friction bristle stiffness, 1/m",
            ),
            (
                "mass_on_belt.belt_speed_mm_per_s",
                "mm/s",
                "belt speed, mm/s",
            ),
            ("body.density_kg_m3", "kg/m^3", "body density, kg/m^3"),
            (
                "rotation.angular_velocity_rad_per_s",
                "rad/s",
                "rotation angular velocity, rad/s",
            ),
        ] {
            assert_eq!(readable(path, unit), name);
        }
    }

    #[test]
    fn fraction_is_the_relative_position() {
        assert_eq!(Axis::linear("x", [0.0, 10.0]).fraction(5.0), 0.5);
        let log = Axis::decades("x", [-2, 1]);
        assert!((log.fraction(0.1) - 1.0 / 3.0).abs() < 1e-12);
        assert!(log.fraction(-1.0) < 0.0 && log.fraction(0.0).is_finite());
    }

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
