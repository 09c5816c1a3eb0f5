//! Families of small systems.

pub use crate::systems::Equations;
use squeakscope_dynamics::System;
use squeakscope_dynamics::continuation::{Family, FamilyError, FamilyMember};

/// A family of systems of first-order equations.
pub struct Smooth<B> {
    pub build: B,
    /// Period of the drive at a value of the parameter.
    pub drive: Option<fn(f64) -> f64>,
}

impl<B: Fn(f64) -> Box<dyn System>> Family for Smooth<B> {
    fn member(&self, parameter: f64) -> Result<FamilyMember, FamilyError> {
        Ok(FamilyMember {
            system: (self.build)(parameter),
            drive_period: self.drive.map(|drive| drive(parameter)),
            observable: vec![1.0],
        })
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
