//! Families of small systems.

use super::super::{Family, FamilyError};
use crate::dynamics::{Differentiable, System};

/// A system of first-order equations with its Jacobian as closures: `w' = g(t, w)`.
pub struct Equations<G, J> {
    pub dimension: usize,
    pub rates: G,
    /// Writes the Jacobian, row-major.
    pub jacobian: J,
    pub autonomous: bool,
}

impl<G, J> System for Equations<G, J>
where
    G: Fn(f64, &[f64], &mut [f64]),
    J: Fn(f64, &[f64], &mut [f64]),
{
    fn omega(&self) -> &[f64] {
        &[]
    }
    fn first_order(&self) -> usize {
        self.dimension
    }
    fn force(&self, t: f64, w: &[f64], out: &mut [f64]) {
        (self.rates)(t, w, out);
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
    fn is_autonomous(&self) -> bool {
        self.autonomous
    }
}

impl<G, J> Differentiable for Equations<G, J>
where
    G: Fn(f64, &[f64], &mut [f64]),
    J: Fn(f64, &[f64], &mut [f64]),
{
    fn product(
        &self,
        _status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let n = self.dimension;
        let mut jacobian = vec![0.0; n * n];
        (self.jacobian)(record[0], &record[1..], &mut jacobian);
        for i in 0..n {
            for l in 0..width {
                let terms = (0..n).map(|j| jacobian[i * n + j] * vectors[j * width + l]);
                out[i * width + l] = terms.sum();
            }
        }
    }
}

/// A family of such systems.
pub struct Smooth<B> {
    pub build: B,
    /// Period of the drive at a value of the parameter.
    pub drive: Option<fn(f64) -> f64>,
    pub symmetry: Option<Vec<f64>>,
}

impl<B: Fn(f64) -> Box<dyn System + Send>> Family for Smooth<B> {
    fn system(&self, parameter: f64) -> Result<Box<dyn System + Send>, FamilyError> {
        Ok((self.build)(parameter))
    }
    fn drive_period(&self, parameter: f64) -> Option<f64> {
        self.drive.map(|drive| drive(parameter))
    }
    fn symmetry(&self) -> Option<&[f64]> {
        self.symmetry.as_deref()
    }
}

/// An autonomous family of first-order equations.
pub fn autonomous<G, J>(
    dimension: usize,
    rates: G,
    jacobian: J,
) -> Smooth<impl Fn(f64) -> Box<dyn System + Send>>
where
    G: Fn(f64, &[f64], &mut [f64]) + Clone + Send + 'static,
    J: Fn(f64, &[f64], &mut [f64]) + Clone + Send + 'static,
{
    Smooth {
        build: move |parameter| {
            let (rates, jacobian) = (rates.clone(), jacobian.clone());
            Box::new(Equations {
                dimension,
                rates: move |_: f64, w: &[f64], out: &mut [f64]| rates(parameter, w, out),
                jacobian: move |_: f64, w: &[f64], out: &mut [f64]| jacobian(parameter, w, out),
                autonomous: true,
            }) as Box<dyn System + Send>
        },
        drive: None,
        symmetry: None,
    }
}
