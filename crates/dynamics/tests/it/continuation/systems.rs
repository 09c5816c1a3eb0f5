//! Families of small systems.

pub use crate::systems::Equations;
use squeakscope_dynamics::System;
use squeakscope_dynamics::continuation::{Family, FamilyError};

/// A family of systems of first-order equations.
pub struct Smooth<B> {
    pub build: B,
    /// Period of the drive at a value of the parameter.
    pub drive: Option<fn(f64) -> f64>,
}

impl<B: Fn(f64) -> Box<dyn System>> Family for Smooth<B> {
    fn system(&self, parameter: f64) -> Result<Box<dyn System>, FamilyError> {
        Ok((self.build)(parameter))
    }
    fn drive_period(&self, parameter: f64) -> Option<f64> {
        self.drive.map(|drive| drive(parameter))
    }
}

/// An autonomous family of first-order equations.
pub fn autonomous<G, J>(
    dimension: usize,
    rates: G,
    jacobian: J,
) -> Smooth<impl Fn(f64) -> Box<dyn System>>
where
    G: Fn(f64, &[f64], &mut [f64]) + Clone + Send + Sync + 'static,
    J: Fn(f64, &[f64], &mut [f64]) + Clone + Send + Sync + 'static,
{
    Smooth {
        build: move |parameter| {
            let (rates, jacobian) = (rates.clone(), jacobian.clone());
            Box::new(Equations {
                dimension,
                rates: move |_: f64, w: &[f64], out: &mut [f64]| rates(parameter, w, out),
                jacobian: move |_: f64, w: &[f64], out: &mut [f64]| jacobian(parameter, w, out),
                autonomous: true,
            }) as Box<dyn System>
        },
        drive: None,
    }
}
