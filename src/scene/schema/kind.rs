//! Types of values of scene keys: reading and description.

use std::fmt;
use std::marker::PhantomData;
use std::str::FromStr;

use strum::VariantArray;
use toml_edit::{Array, Value};

use super::unit::{ONE, Unit};
use crate::scene::error::{Location, SceneError, did_you_mean, nearest};
use crate::scene::tables::analysis::{AutoOr, StateCoordinate};

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
    pub fn at(self, place: Location, key: &str, expected: &str, found: &str) -> SceneError {
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

/// A type of value.
pub trait Kind: Sync {
    /// The result of reading: SI units, radians, enums.
    type Value
    where
        Self: Sized;

    /// Reads a TOML value.
    fn read(&self, value: &Value) -> Result<Self::Value, Mismatch>
    where
        Self: Sized;

    /// Description of the permitted values, without unit.
    fn allowed(&self) -> String;

    /// Unit of the value in a scene file.
    fn unit(&self) -> Unit {
        ONE
    }

    /// Whether the value is a real number.
    fn is_real(&self) -> bool {
        false
    }

    /// Whether a single number is a permitted value.
    fn is_number(&self) -> bool {
        self.is_real()
    }

    /// Description of the permitted values, as the end of "it must be ...".
    fn expected(&self) -> String {
        match self.unit().symbol {
            "" => self.allowed(),
            symbol => format!("{} {symbol}", self.allowed()),
        }
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

/// A real number with a unit. Integer literals are accepted.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    /// Unit in the scene file.
    pub unit: Unit,
    /// Permitted values, in that unit.
    pub range: Range,
}

/// A real number with a unit and a range.
pub const fn number(unit: Unit, range: Range) -> Number {
    Number { unit, range }
}

impl Number {
    /// Checks a number in the unit of the file and converts it to SI units.
    pub fn accept(&self, stated: f64) -> Result<f64, Mismatch> {
        let is_allowed = self.range.contains(stated);
        is_allowed
            .then(|| self.unit.to_si(stated))
            .ok_or(Mismatch::Range)
    }
}

impl Kind for Number {
    type Value = f64;

    fn read(&self, value: &Value) -> Result<f64, Mismatch> {
        self.accept(float(value)?)
    }

    fn allowed(&self) -> String {
        format!("a number {}", self.range)
    }

    fn unit(&self) -> Unit {
        self.unit
    }

    fn is_real(&self) -> bool {
        true
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

/// Numbers of a list.
fn numbers(item: &Number, list: &Value) -> Result<Vec<f64>, Mismatch> {
    items(list)?.iter().map(|value| item.read(value)).collect()
}

/// An integer between two bounds, inclusive.
#[derive(Clone, Copy, Debug)]
pub struct Count(pub u32, pub u32);

impl Kind for Count {
    type Value = usize;

    fn read(&self, value: &Value) -> Result<usize, Mismatch> {
        let n = u32::try_from(integer(value)?).ok();
        n.filter(|n| (self.0..=self.1).contains(n))
            .map(|n| n as usize)
            .ok_or(Mismatch::Range)
    }

    fn allowed(&self) -> String {
        format!("an integer from {} to {}", self.0, self.1)
    }

    fn is_number(&self) -> bool {
        true
    }
}

/// A random seed: a non-negative integer.
#[derive(Clone, Copy, Debug)]
pub struct Seed;

impl Kind for Seed {
    type Value = u64;

    fn read(&self, value: &Value) -> Result<u64, Mismatch> {
        u64::try_from(integer(value)?).map_err(|_| Mismatch::Range)
    }

    fn allowed(&self) -> String {
        format!("an integer from 0 to {}", i64::MAX)
    }

    fn is_number(&self) -> bool {
        true
    }
}

/// A flag: `true` or `false`.
#[derive(Clone, Copy, Debug)]
pub struct Flag;

impl Kind for Flag {
    type Value = bool;

    fn read(&self, value: &Value) -> Result<bool, Mismatch> {
        value.as_bool().ok_or(Mismatch::Type)
    }

    fn allowed(&self) -> String {
        "true or false".to_owned()
    }
}

/// Text that is not blank.
#[derive(Clone, Copy, Debug)]
pub struct Text;

impl Kind for Text {
    type Value = String;

    fn read(&self, value: &Value) -> Result<String, Mismatch> {
        let text = value.as_str().ok_or(Mismatch::Type)?.trim();
        let given = (!text.is_empty()).then(|| text.to_owned());
        given.ok_or(Mismatch::Range)
    }

    fn allowed(&self) -> String {
        "a non-empty string".to_owned()
    }
}

/// A variant of an enum, by its name.
#[derive(Clone, Copy, Debug)]
pub struct Choice<T>(PhantomData<T>);

/// A choice among the variants of an enum.
pub const fn choice<T>() -> Choice<T> {
    Choice(PhantomData)
}

impl<T: VariantArray + Clone + Into<&'static str> + Sync> Choice<T> {
    fn names() -> impl Iterator<Item = &'static str> {
        T::VARIANTS.iter().map(|variant| variant.clone().into())
    }
}

impl<T: VariantArray + Clone + Into<&'static str> + FromStr + Sync> Kind for Choice<T> {
    type Value = T;

    fn read(&self, value: &Value) -> Result<T, Mismatch> {
        let word = value.as_str().ok_or(Mismatch::Type)?;
        let unknown = |_| Mismatch::Choice(nearest(word, Self::names()));
        word.parse().map_err(unknown)
    }

    fn allowed(&self) -> String {
        let names: Vec<_> = Self::names().map(|name| format!("\"{name}\"")).collect();
        names.join(" or ")
    }
}

/// A value of another type, or a word with a special meaning.
#[derive(Clone, Copy, Debug)]
pub struct OrWord<K: Kind, V> {
    kind: K,
    given: fn(K::Value) -> V,
    word: &'static str,
    meaning: V,
}

/// A value, or the word `auto`.
pub const fn auto_or<K: Kind>(kind: K) -> OrWord<K, AutoOr<K::Value>>
where
    K::Value: Copy,
{
    OrWord {
        kind,
        given: AutoOr::Given,
        word: "auto",
        meaning: AutoOr::Auto,
    }
}

/// An upper limit, or the word `all` for no limit.
pub const fn all_or(count: Count) -> OrWord<Count, usize> {
    OrWord {
        kind: count,
        given: |limit| limit,
        word: "all",
        meaning: usize::MAX,
    }
}

impl<K: Kind, V: Copy + Sync> Kind for OrWord<K, V> {
    type Value = V;

    fn read(&self, value: &Value) -> Result<V, Mismatch> {
        match value.as_str() {
            Some(word) if word == self.word => Ok(self.meaning),
            Some(_) => Err(Mismatch::Choice(None)),
            None => self.kind.read(value).map(self.given),
        }
    }

    fn allowed(&self) -> String {
        format!("\"{}\", or {}", self.word, self.kind.allowed())
    }

    fn unit(&self) -> Unit {
        self.kind.unit()
    }

    fn is_number(&self) -> bool {
        self.kind.is_number()
    }
}

/// A vector of three numbers, each of the given type.
#[derive(Clone, Copy, Debug)]
pub struct Vector(pub Number);

impl Kind for Vector {
    type Value = [f64; 3];

    fn read(&self, value: &Value) -> Result<[f64; 3], Mismatch> {
        let numbers = numbers(&self.0, value)?;
        numbers.try_into().map_err(|_| Mismatch::Type)
    }

    fn allowed(&self) -> String {
        format!("three values [x, y, z], each {}", self.0.allowed())
    }

    fn unit(&self) -> Unit {
        self.0.unit
    }
}

/// A list of at least one number, each of the given type; possibly a single number instead.
#[derive(Clone, Copy, Debug)]
pub struct List {
    item: Number,
    takes_one: bool,
}

/// A list of numbers.
pub const fn list(item: Number) -> List {
    List {
        item,
        takes_one: false,
    }
}

/// One number or a list of many.
pub const fn one_or_many(item: Number) -> List {
    List {
        item,
        takes_one: true,
    }
}

impl Kind for List {
    type Value = Vec<f64>;

    fn read(&self, value: &Value) -> Result<Vec<f64>, Mismatch> {
        if self.takes_one && !value.is_array() {
            return Ok(vec![self.item.read(value)?]);
        }
        let numbers = numbers(&self.item, value)?;
        (!numbers.is_empty())
            .then_some(numbers)
            .ok_or(Mismatch::Range)
    }

    fn allowed(&self) -> String {
        let item = self.item.allowed();
        if self.takes_one {
            format!("{item}, or a list of them")
        } else {
            format!("a list of numbers, each {item}")
        }
    }

    fn unit(&self) -> Unit {
        self.item.unit
    }

    fn is_real(&self) -> bool {
        self.takes_one
    }
}

/// Two coordinates of the modal state: `q` or `qdot` followed by the number of the mode, counted from 1.
#[derive(Clone, Copy, Debug)]
pub struct Coordinates;

impl Kind for Coordinates {
    type Value = [StateCoordinate; 2];

    fn read(&self, value: &Value) -> Result<Self::Value, Mismatch> {
        let pair: Result<Vec<_>, _> = items(value)?.iter().map(coordinate).collect();
        pair?.try_into().map_err(|_| Mismatch::Type)
    }

    fn allowed(&self) -> String {
        "two of \"q1\", \"qdot1\", \"q2\", \"qdot2\", ...".to_owned()
    }
}

/// A coordinate of the modal state, such as `qdot12`.
fn coordinate(value: &Value) -> Result<StateCoordinate, Mismatch> {
    let word = value.as_str().ok_or(Mismatch::Type)?;
    let (number, make): (_, fn(usize) -> StateCoordinate) = match word.strip_prefix("qdot") {
        Some(number) => (number, StateCoordinate::Qdot),
        None => (
            word.strip_prefix('q').unwrap_or_default(),
            StateCoordinate::Q,
        ),
    };
    let number: u16 = number.parse().map_err(|_| Mismatch::Choice(None))?;
    let index = number.checked_sub(1).ok_or(Mismatch::Range)?;
    Ok(make(usize::from(index)))
}

/// A list of 1 to the given number of tables. The keys of the tables are declared separately; the value is
/// the number of tables.
#[derive(Clone, Copy, Debug)]
pub struct Tables(pub usize);

impl Kind for Tables {
    type Value = usize;

    fn read(&self, value: &Value) -> Result<usize, Mismatch> {
        let tables = items(value)?;
        if !tables.iter().all(Value::is_inline_table) {
            return Err(Mismatch::Type);
        }
        let is_allowed = (1..=self.0).contains(&tables.len());
        is_allowed.then_some(tables.len()).ok_or(Mismatch::Range)
    }

    fn allowed(&self) -> String {
        format!("a list of 1 to {} tables", self.0)
    }
}
