//! The arrays of a file by name, finite and of the shape that is due.

use std::path::Path;

use super::OwnModesError;
use crate::numpy::{Array, Npz};

/// An array of the layout.
pub(super) struct Named {
    /// Its name in the file.
    pub name: &'static str,
    /// What it holds, with shape and unit.
    pub what: &'static str,
}

impl Named {
    /// The error of another shape.
    pub fn shape(&self, found: Vec<usize>, expected: Vec<usize>) -> OwnModesError {
        OwnModesError::Shape {
            array: self.name,
            found,
            expected,
            what: self.what,
        }
    }

    /// The error of its absence.
    pub fn missing(&self) -> OwnModesError {
        OwnModesError::Missing {
            array: self.name,
            what: self.what,
        }
    }

    /// The error of its absence where another array asks for it.
    pub fn incomplete(&self, given: &'static str) -> OwnModesError {
        OwnModesError::Incomplete {
            array: self.name,
            given,
            what: self.what,
        }
    }

    /// The error of nothing but zeros, with what that would come to.
    pub fn zero(&self, effect: &'static str) -> OwnModesError {
        OwnModesError::AllZero {
            array: self.name,
            effect,
            what: self.what,
        }
    }

    /// Refuses values that are not above zero.
    pub fn positive(&self, values: &[f64]) -> Result<(), OwnModesError> {
        match values.iter().position(|value| *value <= 0.0) {
            None => Ok(()),
            Some(at) => Err(OwnModesError::NotPositive {
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
    pub fn open(path: &Path) -> Result<Self, OwnModesError> {
        Ok(Self {
            npz: Npz::open(path)?,
        })
    }

    /// An array that may be there; its values are finite.
    pub fn find(&mut self, named: &Named) -> Result<Option<Array>, OwnModesError> {
        let Some(array) = self.npz.array(named.name)? else {
            return Ok(None);
        };
        let Some(at) = array.values.iter().position(|value| !value.is_finite()) else {
            return Ok(Some(array));
        };
        // The index along each axis, the last of which changes fastest.
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
        Err(OwnModesError::NotFinite {
            array: named.name,
            at: index,
            value: array.values[at],
        })
    }

    /// The shape of an array that may be there, by its header.
    pub fn shape(&mut self, named: &Named) -> Result<Option<Vec<usize>>, OwnModesError> {
        Ok(self.npz.shape(named.name)?)
    }

    /// An array that must be there, along whose only axis there is something to count.
    pub fn counted(&mut self, named: &Named, most: usize) -> Result<Vec<f64>, OwnModesError> {
        let shape = self.shape(named)?.ok_or_else(|| named.missing())?;
        match shape[..] {
            [count] if (1..=most).contains(&count) => self.need(named, &[count]),
            _ => Err(OwnModesError::Count {
                array: named.name,
                found: shape,
                most,
            }),
        }
    }

    /// An array that may be there, of a given shape, which is checked before it is read.
    pub fn optional(
        &mut self,
        named: &Named,
        shape: &[usize],
    ) -> Result<Option<Vec<f64>>, OwnModesError> {
        match self.shape(named)? {
            Some(found) if found != shape => Err(named.shape(found, shape.to_vec())),
            _ => Ok(self.find(named)?.map(|array| array.values)),
        }
    }

    /// An array that must be there, of a given shape.
    pub fn need(&mut self, named: &Named, shape: &[usize]) -> Result<Vec<f64>, OwnModesError> {
        let values = self.optional(named, shape)?;
        values.ok_or_else(|| named.missing())
    }

    /// An array that must be there because another one is, of a given shape.
    pub fn belonging(
        &mut self,
        named: &Named,
        given: &'static str,
        shape: &[usize],
    ) -> Result<Vec<f64>, OwnModesError> {
        let values = self.optional(named, shape)?;
        values.ok_or_else(|| named.incomplete(given))
    }
}
