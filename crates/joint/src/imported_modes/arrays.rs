//! Arrays of a file by name, with checks of shape and values.

use std::error::Error;

use super::ImportedModesError::{self, Content};

/// A file or one of its arrays that cannot be read.
pub type ArrayError = Box<dyn Error + Send + Sync>;

/// Arrays of real numbers by name, in row-major order. Only those that are asked for need be read.
pub trait NamedArrays {
    /// Shape of an array; `None` if there is no array of this name.
    ///
    /// # Errors
    /// If the array cannot be read.
    fn shape(&mut self, name: &str) -> Result<Option<Vec<usize>>, ArrayError>;

    /// Values of an array that has a shape.
    ///
    /// # Errors
    /// If the array cannot be read.
    fn values(&mut self, name: &str) -> Result<Vec<f64>, ArrayError>;
}

/// An array of the file format: its name, and its content with shape and unit for messages.
pub(super) struct Named(pub &'static str, pub &'static str);

impl Named {
    /// Checks values of a shape one by one; `demand` is the text for the first that is invalid.
    fn check(
        &self,
        values: &[f64],
        shape: &[usize],
        demand: &str,
        is_valid: impl Fn(f64) -> bool,
    ) -> Result<(), ImportedModesError> {
        let Some(at) = values.iter().position(|value| !is_valid(*value)) else {
            return Ok(());
        };
        // The index along each axis; the last axis varies fastest.
        let (mut index, mut rest) = (vec![0; shape.len()], at);
        for (along, length) in index.iter_mut().zip(shape).rev() {
            *along = rest % length;
            rest /= length;
        }
        let Self(name, content) = self;
        Err(Content(format!(
            "`{name}`{index:?} is {}; {demand}: {content}",
            values[at]
        )))
    }

    /// Rejects an array that contains zeros only, with their effect.
    pub fn check_motion(&self, values: &[f64], effect: &str) -> Result<(), ImportedModesError> {
        let Self(name, content) = self;
        if values.iter().any(|value| *value != 0.0) {
            return Ok(());
        }
        Err(Content(format!(
            "`{name}` contains zeros only: {effect}; it must contain {content}"
        )))
    }
}

/// The arrays of a file.
pub(super) struct Arrays<'a>(pub &'a mut dyn NamedArrays);

impl Arrays<'_> {
    /// Length of the first axis of an optional array, from its header; zero for a single number.
    pub fn len(&mut self, named: &Named) -> Result<Option<usize>, ImportedModesError> {
        let shape = self.0.shape(named.0)?;
        Ok(shape.map(|shape| shape.first().copied().unwrap_or(0)))
    }

    /// Reads an optional array; its shape is checked before its values are read, which are finite.
    pub fn optional(
        &mut self,
        named: &Named,
        shape: &[usize],
    ) -> Result<Option<Vec<f64>>, ImportedModesError> {
        let Named(name, content) = named;
        let Some(found) = self.0.shape(name)? else {
            return Ok(None);
        };
        if found != shape {
            return Err(Content(format!(
                "`{name}` has the shape {found:?} instead of {shape:?}; it must contain {content}"
            )));
        }
        let values = self.0.values(name)?;
        let demand = "correct the file, or repeat the modal analysis";
        named.check(&values, shape, demand, f64::is_finite)?;
        Ok(Some(values))
    }

    /// Reads a required array of a given shape.
    pub fn need(&mut self, named: &Named, shape: &[usize]) -> Result<Vec<f64>, ImportedModesError> {
        let Named(name, content) = named;
        let missing = || Content(format!("the array `{name}` is missing; add {content}"));
        self.optional(named, shape)?.ok_or_else(missing)
    }

    /// Reads a required array of positive numbers with one axis.
    pub fn positive(
        &mut self,
        named: &Named,
        count: usize,
    ) -> Result<Vec<f64>, ImportedModesError> {
        let values = self.need(named, &[count])?;
        named.check(&values, &[count], "it must be above 0", |x| x > 0.0)?;
        Ok(values)
    }

    /// As [`Arrays::positive`], with any number of values from 1 to `most`.
    pub fn counted(&mut self, named: &Named, most: usize) -> Result<Vec<f64>, ImportedModesError> {
        let shape = self.0.shape(named.0)?.unwrap_or_else(|| vec![1]);
        match shape[..] {
            [count] if (1..=most).contains(&count) => self.positive(named, count),
            _ => Err(Content(format!(
                "`{}` has the shape {shape:?}; it must have one axis with a length of 1 to {most}",
                named.0
            ))),
        }
    }

    /// Reads a required array of indices below a limit.
    pub fn indices(
        &mut self,
        named: &Named,
        shape: &[usize],
        limit: usize,
    ) -> Result<Vec<usize>, ImportedModesError> {
        let values = self.need(named, shape)?;
        let demand = format!("it must be a whole number from 0 and below {limit}");
        let is_index = |x: f64| x.fract() == 0.0 && (0.0..limit as f64).contains(&x);
        named.check(&values, shape, &demand, is_index)?;
        Ok(values.into_iter().map(|index| index as usize).collect())
    }
}
