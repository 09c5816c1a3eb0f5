//! The direct picture: the method is applied to the state itself.
//!
//! This makes a tableau the plain explicit Runge–Kutta method that books describe (Hairer, Norsett
//! and Wanner, Solving Ordinary Differential Equations I, 2nd ed., Section II.1). Its step must
//! resolve the fastest natural frequency, whether or not that mode is being forced.

use super::System;
use super::runge_kutta::Picture;
use super::system::add_linear;

/// The state is its own coordinate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direct;

impl Picture for Direct {
    fn complete<Y: System + ?Sized>(&self, sys: &Y, z: &[f64], slope: &mut [f64], width: usize) {
        add_linear(sys.omega(), sys.damping(), z, slope, width);
    }

    fn prepare(&mut self, _nodes: &[f64], _h: f64) {}

    fn pull(&self, _stage: usize, _slope: &mut [f64], _width: usize) {}

    fn push(&self, _stage: usize, _y: &mut [f64], _width: usize) {}

    fn push_by(&mut self, _offset: f64, _y: &mut [f64], _width: usize) {}
}
