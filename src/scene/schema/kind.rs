//! Types of values of scene keys: reading and description.

use std::fmt;
use std::str::FromStr;

use strum::VariantArray;
use toml_edit::{Array, Value};

use super::unit::{ONE, Unit};
use crate::scene::error::{SceneError, did_you_mean, nearest};
use crate::scene::tables::analysis::StateCoordinate;

/// A mismatch of a value and its key: why the value is rejected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Mismatch {
    /// Wrong type.
    Type,
    /// A number that is out of range or not finite.
    Range,
    /// A word that is not among the choices, with the most similar choice.
    Choice(Option<&'static str>),
}

impl Mismatch {
    /// Returns the error for a key with this mismatch; `found` is the value as written, shortened.
    pub fn at(self, place: String, key: &str, expected: &str, found: &str) -> SceneError {
        let problem = match self {
            Self::Type => format!("`{key}` is {found}"),
            Self::Range => format!("`{key}` = {found} is out of range"),
            Self::Choice(nearest) => {
                let nearest = did_you_mean(nearest);
                format!("`{key}` = {found} is not a valid choice{nearest}")
            }
        };
        SceneError::new(place, problem, format!("it must be {expected}"))
    }
}

/// A type of value, read as `T`: SI units, radians, enums.
#[derive(Clone, Copy)]
pub struct Kind<T> {
    /// The permitted values.
    pub limits: Limits,
    read: fn(&Limits, &Value) -> Result<T, Mismatch>,
}

/// The permitted values of a key.
#[derive(Clone, Copy)]
pub struct Limits {
    /// Unit in the scene file.
    pub unit: Unit,
    /// Permitted numbers, in that unit.
    pub range: Range,
    /// A word that is permitted, too; empty for none.
    word: &'static str,
    /// Whether a single number is a permitted value, and whether it is a real number.
    pub is_number: bool,
    pub is_real: bool,
    /// Description, without the word and the unit.
    description: fn(Range) -> String,
}

impl<T> Kind<T> {
    const fn new(
        description: fn(Range) -> String,
        read: fn(&Limits, &Value) -> Result<T, Mismatch>,
    ) -> Self {
        let limits = Limits {
            unit: ONE,
            range: Range::Closed(0.0, 0.0),
            word: "",
            is_number: false,
            is_real: false,
            description,
        };
        Self { limits, read }
    }

    /// Reads a TOML value.
    pub fn read(&self, value: &Value) -> Result<T, Mismatch> {
        (self.read)(&self.limits, value)
    }
}

impl Limits {
    /// Description of the permitted values, without unit.
    pub fn allowed(&self) -> String {
        let description = (self.description)(self.range);
        match self.word {
            "" => description,
            word => format!("\"{word}\", or {description}"),
        }
    }

    /// Description of the permitted values, as the end of "it must be ...".
    pub fn expected(&self) -> String {
        let expected = format!("{} {}", self.allowed(), self.unit.symbol);
        expected.trim_end().to_owned()
    }
}

/// A bounded interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
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
    /// Whether the interval contains the number; always false for NaN and infinities.
    pub fn contains(self, x: f64) -> bool {
        match self {
            Self::Closed(low, high) => low <= x && x <= high,
            Self::HalfOpen(low, high) => low <= x && x < high,
            Self::Open(low, high) => low < x && x < high,
            Self::Positive(high) => 0.0 < x && x <= high,
        }
    }

    /// The number, if the interval contains it.
    pub fn check(self, x: f64) -> Result<f64, Mismatch> {
        self.contains(x).then_some(x).ok_or(Mismatch::Range)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // `{:?}` writes very small and very large numbers with an exponent.
        let short = |x: f64| format!("{x:?}").trim_end_matches(".0").to_owned();
        match *self {
            Self::Closed(low, high) => write!(f, "from {} to {}", short(low), short(high)),
            Self::HalfOpen(low, high) => write!(f, "from {} to below {}", short(low), short(high)),
            Self::Open(low, high) => write!(f, "above {} and below {}", short(low), short(high)),
            Self::Positive(high) => write!(f, "above 0, at most {}", short(high)),
        }
    }
}

/// A number, written as a decimal or an integer.
pub fn float(value: &Value) -> Result<f64, Mismatch> {
    let whole = || integer(value).map(|whole| whole as f64);
    value.as_float().map_or_else(whole, Ok)
}

fn integer(value: &Value) -> Result<i64, Mismatch> {
    value.as_integer().ok_or(Mismatch::Type)
}

fn items(value: &Value) -> Result<&Array, Mismatch> {
    value.as_array().ok_or(Mismatch::Type)
}

/// A number that may be replaced by a word.
pub trait Number: Sized {
    /// Reads it within its limits, in SI units.
    fn read(limits: &Limits, value: &Value) -> Result<Self, Mismatch>;
}

impl Number for f64 {
    fn read(limits: &Limits, value: &Value) -> Result<Self, Mismatch> {
        let number = limits.range.check(float(value)?)?;
        Ok(limits.unit.to_si(number))
    }
}

impl Number for usize {
    fn read(limits: &Limits, value: &Value) -> Result<Self, Mismatch> {
        Ok(limits.range.check(integer(value)? as f64)? as Self)
    }
}

/// A real number with a unit and a range. Integer literals are accepted.
pub const fn number(unit: Unit, range: Range) -> Kind<f64> {
    let mut kind = Kind::new(|range| format!("a number {range}"), f64::read);
    (kind.limits.unit, kind.limits.range) = (unit, range);
    (kind.limits.is_number, kind.limits.is_real) = (true, true);
    kind
}

/// An integer between two bounds, inclusive.
pub const fn count(low: usize, high: usize) -> Kind<usize> {
    let mut kind = Kind::new(|range| format!("an integer {range}"), usize::read);
    kind.limits.range = Range::Closed(low as f64, high as f64);
    kind.limits.is_number = true;
    kind
}

/// A random seed: a non-negative integer.
pub const fn seed() -> Kind<u64> {
    let mut kind = Kind::new(
        |_| format!("an integer from 0 to {}", i64::MAX),
        |_, value| u64::try_from(integer(value)?).map_err(|_| Mismatch::Range),
    );
    kind.limits.is_number = true;
    kind
}

/// A flag: `true` or `false`.
pub const fn flag() -> Kind<bool> {
    Kind::new(
        |_| "true or false".to_owned(),
        |_, value| value.as_bool().ok_or(Mismatch::Type),
    )
}

/// Text that is not blank.
pub const fn text() -> Kind<String> {
    Kind::new(
        |_| "a non-empty string".to_owned(),
        |_, value| {
            let text = value.as_str().ok_or(Mismatch::Type)?.trim();
            let given = (!text.is_empty()).then(|| text.to_owned());
            given.ok_or(Mismatch::Range)
        },
    )
}

/// A choice among the variants of an enum, by its name.
pub const fn choice<T: VariantArray + Clone + Into<&'static str> + FromStr>() -> Kind<T> {
    Kind::new(
        |_| {
            let names: Vec<_> = names::<T>().map(|name| format!("\"{name}\"")).collect();
            names.join(" or ")
        },
        |_, value| {
            let word = value.as_str().ok_or(Mismatch::Type)?;
            let unknown = |_| Mismatch::Choice(nearest(word, names::<T>()));
            word.parse().map_err(unknown)
        },
    )
}

fn names<T: VariantArray + Clone + Into<&'static str>>() -> impl Iterator<Item = &'static str> {
    T::VARIANTS.iter().map(|variant| variant.clone().into())
}

/// A number, or the word `auto`, which is read as `None`.
pub const fn auto_or<T: Number>(number: Kind<T>) -> Kind<Option<T>> {
    let mut limits = number.limits;
    (limits.word, limits.is_real) = ("auto", false);
    Kind {
        limits,
        read: number_unless_word,
    }
}

/// An upper limit, or the word `all` for no limit.
pub const fn all_or(count: Kind<usize>) -> Kind<usize> {
    let mut limits = count.limits;
    limits.word = "all";
    let read = |limits: &Limits, value: &Value| {
        Ok(number_unless_word(limits, value)?.unwrap_or(usize::MAX))
    };
    Kind { limits, read }
}

/// A number; `None` for the word.
fn number_unless_word<T: Number>(limits: &Limits, value: &Value) -> Result<Option<T>, Mismatch> {
    match value.as_str() {
        Some(word) if word == limits.word => Ok(None),
        Some(_) => Err(Mismatch::Choice(None)),
        None => T::read(limits, value).map(Some),
    }
}

/// Numbers of a list.
fn numbers(limits: &Limits, list: &Value) -> Result<Vec<f64>, Mismatch> {
    let numbers = items(list)?.iter().map(|value| f64::read(limits, value));
    numbers.collect()
}

/// Numbers of a list that is not empty.
fn some_numbers(limits: &Limits, list: &Value) -> Result<Vec<f64>, Mismatch> {
    let numbers = Some(numbers(limits, list)?);
    let given = numbers.filter(|numbers| !numbers.is_empty());
    given.ok_or(Mismatch::Range)
}

/// A vector of three numbers.
pub const fn vector(item: Kind<f64>) -> Kind<[f64; 3]> {
    let mut kind = Kind::new(
        |range| format!("three values [x, y, z], each a number {range}"),
        |limits, value| {
            let numbers = numbers(limits, value)?;
            numbers.try_into().map_err(|_| Mismatch::Type)
        },
    );
    (kind.limits.unit, kind.limits.range) = (item.limits.unit, item.limits.range);
    kind
}

/// A list of at least one number.
pub const fn list(item: Kind<f64>) -> Kind<Vec<f64>> {
    let description = |range| format!("a list of numbers, each a number {range}");
    let mut kind = Kind::new(description, some_numbers);
    (kind.limits.unit, kind.limits.range) = (item.limits.unit, item.limits.range);
    kind
}

/// One number or a list of many.
pub const fn one_or_many(item: Kind<f64>) -> Kind<Vec<f64>> {
    let mut limits = item.limits;
    limits.description = |range| format!("a number {range}, or a list of them");
    let read = |limits: &Limits, value: &Value| match value {
        Value::Array(_) => some_numbers(limits, value),
        one => Ok(vec![f64::read(limits, one)?]),
    };
    Kind { limits, read }
}

/// Two coordinates of the modal state: `q` or `qdot` followed by the number of the mode, counted from 1.
pub const fn coordinates() -> Kind<[StateCoordinate; 2]> {
    Kind::new(
        |_| "two of \"q1\", \"qdot1\", \"q2\", \"qdot2\", ...".to_owned(),
        |_, value| {
            let pair: Result<Vec<_>, _> = items(value)?.iter().map(coordinate).collect();
            pair?.try_into().map_err(|_| Mismatch::Type)
        },
    )
}

/// A coordinate of the modal state, such as `qdot12`.
fn coordinate(value: &Value) -> Result<StateCoordinate, Mismatch> {
    use StateCoordinate::{Q, Qdot};

    let word = value.as_str().ok_or(Mismatch::Type)?;
    let (number, make): (_, fn(usize) -> StateCoordinate) = match word.strip_prefix("qdot") {
        Some(number) => (number, Qdot),
        None => (word.strip_prefix('q').unwrap_or_default(), Q),
    };
    let number: u16 = number.parse().map_err(|_| Mismatch::Choice(None))?;
    let index = number.checked_sub(1).ok_or(Mismatch::Range)?;
    Ok(make(usize::from(index)))
}

/// A list of 1 to the given number of tables. The keys of the tables are declared separately; the value is
/// the number of tables.
pub const fn tables(most: usize) -> Kind<usize> {
    let mut kind = Kind::new(
        |range| format!("a list of {range} tables").replace("from ", ""),
        |limits, value| {
            let tables = items(value)?;
            if !tables.iter().all(Value::is_inline_table) {
                return Err(Mismatch::Type);
            }
            limits.range.check(tables.len() as f64)?;
            Ok(tables.len())
        },
    );
    kind.limits.range = Range::Closed(1.0, most as f64);
    kind
}
