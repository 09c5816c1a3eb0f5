//! Forms in JSON that `serde` does not derive.

use serde::de::{DeserializeOwned, Error};
use serde::{Deserialize, Deserializer};

/// A number, or a list of numbers.
pub(crate) trait Numbers {
    /// The same with `null`, which JSON has in place of a non-finite number.
    type Nullable: DeserializeOwned;

    /// Replaces `null` by a value.
    fn fill(nullable: Self::Nullable, null: f64) -> Self;
}

impl Numbers for f64 {
    type Nullable = Option<f64>;

    fn fill(nullable: Option<f64>, null: f64) -> f64 {
        nullable.unwrap_or(null)
    }
}

impl Numbers for Vec<f64> {
    type Nullable = Vec<Option<f64>>;

    fn fill(nullable: Vec<Option<f64>>, null: f64) -> Self {
        nullable.into_iter().map(|x| x.unwrap_or(null)).collect()
    }
}

/// Reads numbers that may be infinite.
pub(crate) fn infinite<'de, N: Numbers, D: Deserializer<'de>>(from: D) -> Result<N, D::Error> {
    Ok(N::fill(N::Nullable::deserialize(from)?, f64::INFINITY))
}

/// Reads numbers that may be minus infinity.
pub(crate) fn minus_infinite<'de, N: Numbers, D: Deserializer<'de>>(
    from: D,
) -> Result<N, D::Error> {
    Ok(N::fill(N::Nullable::deserialize(from)?, f64::NEG_INFINITY))
}

/// Reads one of `all` by its name.
pub(crate) fn by_name<'de, T: Copy, N: AsRef<str>, D: Deserializer<'de>>(
    all: &[T],
    name: impl Fn(T) -> N,
    from: D,
) -> Result<T, D::Error> {
    let text = String::deserialize(from)?;
    let found = all.iter().copied().find(|one| name(*one).as_ref() == text);
    found.ok_or_else(|| D::Error::custom(format!("unknown name `{text}`")))
}
