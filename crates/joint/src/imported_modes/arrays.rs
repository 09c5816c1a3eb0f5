//! Arrays of a file by name, with checks of shape and finiteness.

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

/// An array of the file format.
pub(super) struct Named {
    /// Name in the file.
    pub name: &'static str,
    /// Content, with shape and unit.
    pub what: &'static str,
}

impl Named {
    /// Error for a wrong shape.
    pub fn shape(&self, found: &[usize], expected: &[usize]) -> ImportedModesError {
        let Self { name, what } = self;
        Content(format!(
            "`{name}` has the shape {found:?} instead of {expected:?}; it must contain {what}"
        ))
    }

    /// Error for a missing array.
    pub fn missing(&self) -> ImportedModesError {
        let Self { name, what } = self;
        Content(format!("the array `{name}` is missing; add {what}"))
    }

    /// Error for a missing array that another array requires.
    pub fn incomplete(&self, given: &'static str) -> ImportedModesError {
        let Self { name, what } = self;
        Content(format!(
            "`{name}` is missing, which `{given}` requires; add {what}, or remove both arrays"
        ))
    }

    /// Error for an array of zeros, with the consequence.
    pub fn zero(&self, effect: &'static str) -> ImportedModesError {
        let Self { name, what } = self;
        Content(format!(
            "`{name}` contains zeros only: {effect}; it must contain {what}"
        ))
    }

    /// Rejects values that are not positive.
    pub fn positive(&self, values: &[f64]) -> Result<(), ImportedModesError> {
        let Self { name, what } = self;
        match values.iter().position(|value| *value <= 0.0) {
            None => Ok(()),
            Some(at) => Err(Content(format!(
                "`{name}`[{at}] is {}; it must be above 0: {what}",
                values[at]
            ))),
        }
    }
}

/// The arrays of a file.
pub(super) struct Arrays<'a>(pub &'a mut dyn NamedArrays);

impl Arrays<'_> {
    /// Reads an optional array of any shape.
    pub fn find(&mut self, named: &Named) -> Result<Option<Vec<f64>>, ImportedModesError> {
        let shape = self.shape(named)?;
        shape.map(|shape| self.values(named, &shape)).transpose()
    }

    /// Reads an array of a known shape; its values are finite.
    fn values(&mut self, named: &Named, shape: &[usize]) -> Result<Vec<f64>, ImportedModesError> {
        let values = self.0.values(named.name)?;
        let Some(at) = values.iter().position(|value| !value.is_finite()) else {
            return Ok(values);
        };
        // The index along each axis; the last axis varies fastest.
        let mut rest = at;
        let mut index: Vec<usize> = shape
            .iter()
            .rev()
            .map(|length| {
                let along = rest % length;
                rest /= length;
                along
            })
            .collect();
        index.reverse();
        Err(Content(format!(
            "`{}`{index:?} is {}; correct the file, or repeat the modal analysis",
            named.name, values[at]
        )))
    }

    /// Shape of an optional array, from its header.
    pub fn shape(&mut self, named: &Named) -> Result<Option<Vec<usize>>, ImportedModesError> {
        Ok(self.0.shape(named.name)?)
    }

    /// Reads a required array of one axis with 1 to `most` values.
    pub fn counted(&mut self, named: &Named, most: usize) -> Result<Vec<f64>, ImportedModesError> {
        let shape = self.shape(named)?.ok_or_else(|| named.missing())?;
        match shape[..] {
            [count] if (1..=most).contains(&count) => self.need(named, &[count]),
            _ => Err(Content(format!(
                "`{}` has the shape {shape:?}; it must have one axis with a length of 1 to {most}",
                named.name
            ))),
        }
    }

    /// Reads an optional array; its shape is checked before its data are read.
    pub fn optional(
        &mut self,
        named: &Named,
        shape: &[usize],
    ) -> Result<Option<Vec<f64>>, ImportedModesError> {
        match self.shape(named)? {
            Some(found) if found != shape => Err(named.shape(&found, shape)),
            found => found.map(|_| self.values(named, shape)).transpose(),
        }
    }

    /// Reads a required array of a given shape.
    pub fn need(&mut self, named: &Named, shape: &[usize]) -> Result<Vec<f64>, ImportedModesError> {
        let values = self.optional(named, shape)?;
        values.ok_or_else(|| named.missing())
    }

    /// Reads an array that the array `given` requires.
    pub fn belonging(
        &mut self,
        named: &Named,
        given: &'static str,
        shape: &[usize],
    ) -> Result<Vec<f64>, ImportedModesError> {
        let values = self.optional(named, shape)?;
        values.ok_or_else(|| named.incomplete(given))
    }
}
