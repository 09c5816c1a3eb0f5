//! Kinds of values that a key of a scene file can have: how each is read, and how it is described.

use std::fmt;

use toml::Spanned;
use toml::de::DeValue;

use super::error::{CLOSE, nearest};
use super::spec::{Amount, Setting, StateCoordinate};
use super::units::Unit;

/// Why a value cannot be taken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Mismatch {
    /// It is of another type.
    Type,
    /// It is a number out of range, or not finite.
    Range,
    /// It is a word, but none of the choices; with the one spelt most like it.
    Choice(Option<&'static str>),
}

/// A kind of value.
pub(super) trait Kind: Sync {
    /// What reading gives: SI units, radians, enums.
    type Value;

    /// Whether one number is a value.
    const IS_NUMBER: bool = false;

    /// Reads a TOML value.
    fn read(&self, value: &DeValue<'_>) -> Result<Self::Value, Mismatch>;

    /// What the value must be, without its unit.
    fn allowed(&self) -> String;

    /// The unit in which it is stated.
    fn unit(&self) -> Unit {
        Unit::One
    }

    /// What the value must be, as the end of "it must be ...".
    fn expected(&self) -> String {
        match self.unit().symbol() {
            "" => self.allowed(),
            symbol => format!("{} {symbol}", self.allowed()),
        }
    }
}

/// A bounded interval of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Range {
    /// `low <= x <= high`.
    Closed(f64, f64),
    /// `low <= x < high`.
    HalfOpen(f64, f64),
    /// `low < x < high`.
    Open(f64, f64),
    /// `0 < x <= high`.
    Positive(f64),
}

impl Range {
    /// Whether it holds the number; never true of NaN or an infinity.
    pub fn contains(self, x: f64) -> bool {
        match self {
            Self::Closed(low, high) => low <= x && x <= high,
            Self::HalfOpen(low, high) => low <= x && x < high,
            Self::Open(low, high) => low < x && x < high,
            Self::Positive(high) => 0.0 < x && x <= high,
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // `{:?}` writes very small and very large numbers with an exponent.
        let short = |x: f64| match format!("{x:?}").strip_suffix(".0") {
            Some(whole) => whole.to_owned(),
            None => format!("{x:?}"),
        };
        match *self {
            Self::Closed(low, high) => write!(f, "from {} to {}", short(low), short(high)),
            Self::HalfOpen(low, high) => write!(f, "from {} to below {}", short(low), short(high)),
            Self::Open(low, high) => write!(f, "above {} and below {}", short(low), short(high)),
            Self::Positive(high) => write!(f, "above 0, at most {}", short(high)),
        }
    }
}

/// A real number, stated in a unit. An integer literal is taken as well.
#[derive(Clone, Copy, Debug)]
pub(super) struct Number {
    /// The unit of the file.
    pub unit: Unit,
    /// Allowed values, in that unit.
    pub range: Range,
}

impl Number {
    /// Takes a number stated in the file's unit, and gives it in SI units.
    pub fn accept(&self, stated: f64) -> Result<f64, Mismatch> {
        if self.range.contains(stated) {
            Ok(self.unit.to_si(stated))
        } else {
            Err(Mismatch::Range)
        }
    }
}

impl Kind for Number {
    type Value = f64;

    const IS_NUMBER: bool = true;

    fn read(&self, value: &DeValue<'_>) -> Result<f64, Mismatch> {
        let stated = match value {
            DeValue::Float(float) => float.as_str().parse().map_err(|_| Mismatch::Range)?,
            DeValue::Integer(_) => integer(value)? as f64,
            _ => return Err(Mismatch::Type),
        };
        self.accept(stated)
    }

    fn allowed(&self) -> String {
        format!("a number {}", self.range)
    }

    fn unit(&self) -> Unit {
        self.unit
    }
}

/// An integer literal of any base; out of range if it does not fit 64 bits.
fn integer(value: &DeValue<'_>) -> Result<i64, Mismatch> {
    let digits = value.as_integer().ok_or(Mismatch::Type)?;
    i64::from_str_radix(digits.as_str(), digits.radix()).map_err(|_| Mismatch::Range)
}

/// A whole number from `min` to `max`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Count {
    /// Smallest value.
    pub min: u32,
    /// Largest value.
    pub max: u32,
}

impl Kind for Count {
    type Value = usize;

    const IS_NUMBER: bool = true;

    fn read(&self, value: &DeValue<'_>) -> Result<usize, Mismatch> {
        let n = u32::try_from(integer(value)?).map_err(|_| Mismatch::Range)?;
        if (self.min..=self.max).contains(&n) {
            Ok(n as usize)
        } else {
            Err(Mismatch::Range)
        }
    }

    fn allowed(&self) -> String {
        format!("a whole number from {} to {}", self.min, self.max)
    }
}

/// The seed of random numbers: any integer that TOML can hold and that is not negative.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seed;

impl Kind for Seed {
    type Value = u64;

    const IS_NUMBER: bool = true;

    fn read(&self, value: &DeValue<'_>) -> Result<u64, Mismatch> {
        u64::try_from(integer(value)?).map_err(|_| Mismatch::Range)
    }

    fn allowed(&self) -> String {
        format!("a whole number from 0 to {}", i64::MAX)
    }
}

/// `true` or `false`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flag;

impl Kind for Flag {
    type Value = bool;

    fn read(&self, value: &DeValue<'_>) -> Result<bool, Mismatch> {
        value.as_bool().ok_or(Mismatch::Type)
    }

    fn allowed(&self) -> String {
        "true or false".to_owned()
    }
}

/// Text that says something.
#[derive(Clone, Copy, Debug)]
pub(super) struct Text;

impl Kind for Text {
    type Value = String;

    fn read(&self, value: &DeValue<'_>) -> Result<String, Mismatch> {
        let text = value.as_str().ok_or(Mismatch::Type)?.trim();
        if text.is_empty() {
            Err(Mismatch::Range)
        } else {
            Ok(text.to_owned())
        }
    }

    fn allowed(&self) -> String {
        "a text in quotes, not empty".to_owned()
    }
}

/// One of a few words, each meaning a value of `T`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice<T: 'static> {
    /// The words and what they mean.
    pub options: &'static [(&'static str, T)],
}

impl<T: Clone + Sync> Kind for Choice<T> {
    type Value = T;

    fn read(&self, value: &DeValue<'_>) -> Result<T, Mismatch> {
        let word = value.as_str().ok_or(Mismatch::Type)?;
        self.options
            .iter()
            .find(|(name, _)| *name == word)
            .map(|(_, meaning)| meaning.clone())
            .ok_or_else(|| Mismatch::Choice(nearest(word, self.options.iter().map(|o| o.0), CLOSE)))
    }

    fn allowed(&self) -> String {
        let names: Vec<_> = self
            .options
            .iter()
            .map(|o| format!("\"{}\"", o.0))
            .collect();
        names.join(" or ")
    }
}

/// Three numbers: a vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vector {
    /// What each component must be.
    pub component: Number,
}

impl Kind for Vector {
    type Value = [f64; 3];

    fn read(&self, value: &DeValue<'_>) -> Result<[f64; 3], Mismatch> {
        let items = value.as_array().ok_or(Mismatch::Type)?;
        if items.len() != 3 {
            return Err(Mismatch::Type);
        }
        let mut vector = [0.0; 3];
        for (x, item) in vector.iter_mut().zip(items) {
            *x = self.component.read(item.get_ref())?;
        }
        Ok(vector)
    }

    fn allowed(&self) -> String {
        format!("three values [x, y, z], each {}", self.component.allowed())
    }

    fn unit(&self) -> Unit {
        self.component.unit
    }
}

/// A value, or the word `auto`.
#[derive(Clone, Copy, Debug)]
pub(super) struct AutoOr<K>(pub K);

impl<K: Kind> Kind for AutoOr<K> {
    type Value = Setting<K::Value>;

    const IS_NUMBER: bool = K::IS_NUMBER;

    fn read(&self, value: &DeValue<'_>) -> Result<Self::Value, Mismatch> {
        match value.as_str() {
            Some("auto") => Ok(Setting::Auto),
            Some(_) => Err(Mismatch::Choice(None)),
            None => self.0.read(value).map(Setting::Given),
        }
    }

    fn allowed(&self) -> String {
        format!("\"auto\", or {}", self.0.allowed())
    }

    fn unit(&self) -> Unit {
        self.0.unit()
    }
}

/// A count, or the word `all`.
#[derive(Clone, Copy, Debug)]
pub(super) struct AllOr<K>(pub K);

impl<K: Kind<Value = usize>> Kind for AllOr<K> {
    type Value = Amount;

    fn read(&self, value: &DeValue<'_>) -> Result<Amount, Mismatch> {
        match value.as_str() {
            Some("all") => Ok(Amount::All),
            Some(_) => Err(Mismatch::Choice(None)),
            None => self.0.read(value).map(Amount::First),
        }
    }

    fn allowed(&self) -> String {
        format!("\"all\", or {}", self.0.allowed())
    }
}

/// A list of numbers, one at least.
#[derive(Clone, Copy, Debug)]
pub(super) struct List {
    /// What each must be.
    pub item: Number,
}

impl Kind for List {
    type Value = Vec<f64>;

    fn read(&self, value: &DeValue<'_>) -> Result<Vec<f64>, Mismatch> {
        let items = value.as_array().ok_or(Mismatch::Type)?;
        if items.is_empty() {
            return Err(Mismatch::Range);
        }
        items
            .iter()
            .map(|item| self.item.read(item.get_ref()))
            .collect()
    }

    fn allowed(&self) -> String {
        format!("a list of numbers, each {}", self.item.allowed())
    }

    fn unit(&self) -> Unit {
        self.item.unit
    }
}

/// Two coordinates of the modal state: `q` or `qdot` with the number of the mode, from 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coordinates;

impl Kind for Coordinates {
    type Value = [StateCoordinate; 2];

    fn read(&self, value: &DeValue<'_>) -> Result<Self::Value, Mismatch> {
        let [first, second] = &value.as_array().ok_or(Mismatch::Type)?[..] else {
            return Err(Mismatch::Type);
        };
        let coordinate = |item: &Spanned<DeValue<'_>>| {
            let word = item.get_ref().as_str().ok_or(Mismatch::Type)?;
            let (number, make): (_, fn(usize) -> StateCoordinate) = match word.strip_prefix("qdot")
            {
                Some(number) => (number, StateCoordinate::Qdot),
                None => (
                    word.strip_prefix('q').unwrap_or_default(),
                    StateCoordinate::Q,
                ),
            };
            let number: u16 = number.parse().map_err(|_| Mismatch::Choice(None))?;
            let index = number.checked_sub(1).ok_or(Mismatch::Range)?;
            Ok(make(usize::from(index)))
        };
        Ok([coordinate(first)?, coordinate(second)?])
    }

    fn allowed(&self) -> String {
        "two of \"q1\", \"qdot1\", \"q2\", \"qdot2\", ...".to_owned()
    }
}

/// One number, or a list of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct OneOrMany {
    /// What each must be.
    pub item: Number,
}

/// What [`OneOrMany`] reads.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Numbers {
    /// The same number everywhere.
    One(f64),
    /// A number each.
    Many(Vec<f64>),
}

impl Kind for OneOrMany {
    type Value = Numbers;

    const IS_NUMBER: bool = true;

    fn read(&self, value: &DeValue<'_>) -> Result<Numbers, Mismatch> {
        match value.as_array() {
            None => self.item.read(value).map(Numbers::One),
            Some(items) => items
                .iter()
                .map(|item| self.item.read(item.get_ref()))
                .collect::<Result<_, _>>()
                .map(Numbers::Many),
        }
    }

    fn allowed(&self) -> String {
        format!("{}, or a list of them", self.item.allowed())
    }

    fn unit(&self) -> Unit {
        self.item.unit
    }
}

/// A list of tables; their own keys are described apart. Reading gives their number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tables {
    /// The most there may be; there must be one.
    pub max: usize,
}

impl Kind for Tables {
    type Value = usize;

    fn read(&self, value: &DeValue<'_>) -> Result<usize, Mismatch> {
        let items = value.as_array().ok_or(Mismatch::Type)?;
        if !items.iter().all(|item| item.get_ref().is_table()) {
            return Err(Mismatch::Type);
        }
        if (1..=self.max).contains(&items.len()) {
            Ok(items.len())
        } else {
            Err(Mismatch::Range)
        }
    }

    fn allowed(&self) -> String {
        format!("a list of 1 to {} tables", self.max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read<K: Kind>(kind: &K, text: &str) -> Result<K::Value, Mismatch> {
        kind.read(DeValue::parse(text).expect("valid TOML").get_ref())
    }

    const TILT: Number = Number {
        unit: Unit::Degree,
        range: Range::Closed(-90.0, 90.0),
    };

    #[test]
    fn numbers_take_both_literals_and_refuse_what_is_not_finite() {
        assert_eq!(read(&TILT, "90"), Ok(std::f64::consts::FRAC_PI_2));
        assert_eq!(read(&TILT, "-9_0.0"), Ok(-std::f64::consts::FRAC_PI_2));
        for out in [
            "90.000001",
            "nan",
            "-nan",
            "inf",
            "-inf",
            "1e400",
            "99999999999999999999",
        ] {
            assert_eq!(read(&TILT, out), Err(Mismatch::Range), "{out}");
        }
        for other in ["\"3\"", "true", "[3]", "{ a = 3 }", "2024-01-01"] {
            assert_eq!(read(&TILT, other), Err(Mismatch::Type), "{other}");
        }
    }

    #[test]
    fn open_ends_are_left_out() {
        let range = Range::Open(-1.0, 0.5);
        assert!(range.contains(0.499) && !range.contains(0.5) && !range.contains(-1.0));
        assert_eq!(range.to_string(), "above -1 and below 0.5");
        let range = Range::Positive(2.0);
        assert!(range.contains(2.0) && range.contains(5e-324) && !range.contains(0.0));
        assert_eq!(range.to_string(), "above 0, at most 2");
        let range = Range::HalfOpen(0.0, 1.0);
        assert!(range.contains(0.0) && !range.contains(1.0));
        assert_eq!(range.to_string(), "from 0 to below 1");
        let range = Range::Closed(1e-13, 0.01);
        assert!(range.contains(1e-13) && range.contains(0.01) && !range.contains(0.011));
        assert_eq!(range.to_string(), "from 1e-13 to 0.01");
    }

    #[test]
    fn counts_are_whole_and_bounded() {
        let nodes = Count {
            min: 1,
            max: 10_000,
        };
        assert_eq!(read(&nodes, "0x64"), Ok(100));
        for out in ["0", "-1", "10001", "4294967297", "18446744073709551616"] {
            assert_eq!(read(&nodes, out), Err(Mismatch::Range), "{out}");
        }
        assert_eq!(read(&nodes, "100.0"), Err(Mismatch::Type));
        assert_eq!(read(&Seed, "9223372036854775807"), Ok(i64::MAX as u64));
        assert_eq!(read(&Seed, "-1"), Err(Mismatch::Range));
    }

    #[test]
    fn choices_offer_the_nearest_word() {
        let choice = Choice {
            options: &[("rings", 1), ("gauss", 2)],
        };
        assert_eq!(read(&choice, "\"gauss\""), Ok(2));
        assert_eq!(
            read(&choice, "\"guass\""),
            Err(Mismatch::Choice(Some("gauss")))
        );
        assert_eq!(read(&choice, "\"zzz\""), Err(Mismatch::Choice(None)));
        assert_eq!(choice.expected(), "\"rings\" or \"gauss\"");
    }

    #[test]
    fn lists_have_their_length() {
        let vector = Vector { component: TILT };
        assert_eq!(read(&vector, "[0, 0.0, 0]"), Ok([0.0; 3]));
        assert_eq!(read(&vector, "[0, 0]"), Err(Mismatch::Type));
        assert_eq!(read(&vector, "[0, 0, nan]"), Err(Mismatch::Range));
        let many = OneOrMany { item: TILT };
        assert_eq!(read(&many, "0"), Ok(Numbers::One(0.0)));
        assert_eq!(read(&many, "[0, 0]"), Ok(Numbers::Many(vec![0.0, 0.0])));
        let list = List { item: TILT };
        assert_eq!(read(&list, "[0, 0.0]"), Ok(vec![0.0, 0.0]));
        assert_eq!(read(&list, "[]"), Err(Mismatch::Range));
        assert_eq!(read(&list, "0"), Err(Mismatch::Type));
        let tables = Tables { max: 2 };
        assert_eq!(read(&tables, "[{}, {}]"), Ok(2));
        assert_eq!(read(&tables, "[{}, {}, {}]"), Err(Mismatch::Range));
        assert_eq!(read(&tables, "[]"), Err(Mismatch::Range));
        assert_eq!(read(&tables, "[{}, 1]"), Err(Mismatch::Type));
        assert_eq!(read(&tables, "{}"), Err(Mismatch::Type));
    }

    #[test]
    fn auto_is_a_word_among_numbers() {
        let lag = AutoOr(TILT);
        assert_eq!(read(&lag, "\"auto\""), Ok(Setting::Auto));
        assert_eq!(read(&lag, "0"), Ok(Setting::Given(0.0)));
        assert_eq!(read(&lag, "\"automatic\""), Err(Mismatch::Choice(None)));
        assert_eq!(read(&lag, "91"), Err(Mismatch::Range));
        assert_eq!(lag.expected(), "\"auto\", or a number from -90 to 90 deg");
    }

    #[test]
    fn all_is_a_word_among_counts() {
        let count = AllOr(Count { min: 1, max: 9 });
        assert_eq!(read(&count, "\"all\""), Ok(Amount::All));
        assert_eq!(read(&count, "3"), Ok(Amount::First(3)));
        assert_eq!(read(&count, "\"every\""), Err(Mismatch::Choice(None)));
        assert_eq!(read(&count, "0"), Err(Mismatch::Range));
        assert_eq!(read(&count, "2.0"), Err(Mismatch::Type));
        assert_eq!(count.expected(), "\"all\", or a whole number from 1 to 9");
    }

    #[test]
    fn coordinates_are_two_modes_counted_from_one() {
        use StateCoordinate::{Q, Qdot};
        let pair = |text: &str| read(&Coordinates, text);
        assert_eq!(pair("[\"q1\", \"qdot12\"]"), Ok([Q(0), Qdot(11)]));
        assert_eq!(pair("[\"q1\"]"), Err(Mismatch::Type));
        assert_eq!(pair("[\"q1\", 2]"), Err(Mismatch::Type));
        assert_eq!(pair("[\"q0\", \"q1\"]"), Err(Mismatch::Range));
        for wrong in ["q", "p1", "qdot", "q-1", "q1x", ""] {
            let text = format!("[\"q1\", \"{wrong}\"]");
            assert_eq!(pair(&text), Err(Mismatch::Choice(None)), "{wrong}");
        }
    }

    #[test]
    fn texts_say_something() {
        assert_eq!(read(&Text, "\" a \""), Ok("a".to_owned()));
        assert_eq!(read(&Text, "\" \""), Err(Mismatch::Range));
        assert_eq!(read(&Text, "1"), Err(Mismatch::Type));
    }
}
