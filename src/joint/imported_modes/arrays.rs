//! Arrays of a file by name, with checks of shape and finiteness.

use std::path::Path;

use super::ImportedModesError;
use crate::numpy::{Array, Npz};

/// An array of the file format.
pub(super) struct Named {
    /// Name in the file.
    pub name: &'static str,
    /// Content, with shape and unit.
    pub what: &'static str,
}

impl Named {
    /// Error for a wrong shape.
    pub fn shape(&self, found: Vec<usize>, expected: Vec<usize>) -> ImportedModesError {
        ImportedModesError::Shape {
            array: self.name,
            found,
            expected,
            what: self.what,
        }
    }

    /// Error for a missing array.
    pub fn missing(&self) -> ImportedModesError {
        ImportedModesError::Missing {
            array: self.name,
            what: self.what,
        }
    }

    /// Error for a missing array that another array requires.
    pub fn incomplete(&self, given: &'static str) -> ImportedModesError {
        ImportedModesError::Incomplete {
            array: self.name,
            given,
            what: self.what,
        }
    }

    /// Error for an array of zeros, with the consequence.
    pub fn zero(&self, effect: &'static str) -> ImportedModesError {
        ImportedModesError::AllZero {
            array: self.name,
            effect,
            what: self.what,
        }
    }

    /// Rejects values that are not positive.
    pub fn positive(&self, values: &[f64]) -> Result<(), ImportedModesError> {
        match values.iter().position(|value| *value <= 0.0) {
            None => Ok(()),
            Some(at) => Err(ImportedModesError::NotPositive {
                array: self.name,
                at,
                value: values[at],
                what: self.what,
            }),
        }
    }
}

/// An open file.
pub(super) struct Arrays {
    npz: Npz,
}

impl Arrays {
    pub fn open(path: &Path) -> Result<Self, ImportedModesError> {
        Ok(Self {
            npz: Npz::open(path)?,
        })
    }

    /// Reads an optional array; its values are finite.
    pub fn find(&mut self, named: &Named) -> Result<Option<Array>, ImportedModesError> {
        let Some(array) = self.npz.array(named.name)? else {
            return Ok(None);
        };
        let Some(at) = array.values.iter().position(|value| !value.is_finite()) else {
            return Ok(Some(array));
        };
        // The index along each axis; the last axis varies fastest.
        let mut rest = at;
        let mut index: Vec<usize> = array
            .shape
            .iter()
            .rev()
            .map(|length| {
                let along = rest % length;
                rest /= length;
                along
            })
            .collect();
        index.reverse();
        Err(ImportedModesError::NotFinite {
            array: named.name,
            at: index,
            value: array.values[at],
        })
    }

    /// Shape of an optional array, from its header.
    pub fn shape(&mut self, named: &Named) -> Result<Option<Vec<usize>>, ImportedModesError> {
        Ok(self.npz.shape(named.name)?)
    }

    /// Reads a required array of one axis with 1 to `most` values.
    pub fn counted(&mut self, named: &Named, most: usize) -> Result<Vec<f64>, ImportedModesError> {
        let shape = self.shape(named)?.ok_or_else(|| named.missing())?;
        match shape[..] {
            [count] if (1..=most).contains(&count) => self.need(named, &[count]),
            _ => Err(ImportedModesError::Count {
                array: named.name,
                found: shape,
                most,
            }),
        }
    }

    /// Reads an optional array; its shape is checked before its data are read.
    pub fn optional(
        &mut self,
        named: &Named,
        shape: &[usize],
    ) -> Result<Option<Vec<f64>>, ImportedModesError> {
        match self.shape(named)? {
            Some(found) if found != shape => Err(named.shape(found, shape.to_vec())),
            _ => Ok(self.find(named)?.map(|array| array.values)),
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
