//! The plain form: the method integrates the state itself.
//!
//! A tableau in this form is the standard explicit Runge–Kutta method (Hairer, Norsett and Wanner,
//! Solving Ordinary Differential Equations I, 2nd ed., Section II.1). Its step must resolve the highest
//! natural frequency, even if that mode is not excited.

use pulp::Arch;

use super::System;
use super::combination::{Combination, Write};
use super::runge_kutta::Form;
use super::system::add_linear;

/// The method's coordinates are the state.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Plain {
    arch: Arch,
}

impl Form for Plain {
    fn add_linear_part<Y: System + ?Sized>(
        &self,
        sys: &Y,
        z: &[f64],
        slope: &mut [f64],
        width: usize,
    ) {
        add_linear(sys.omega(), sys.damping(), z, slope, width);
    }

    fn prepare(&mut self, _nodes: &[f64], _h: f64) {}

    fn advance(&self, _stage: usize, combination: Combination<'_>, out: &mut [f64]) {
        self.arch.dispatch(Write { combination, out });
    }

    fn advance_by(&mut self, _offset: f64, combination: Combination<'_>, out: &mut [f64]) {
        self.arch.dispatch(Write { combination, out });
    }

    fn slope<Y: System + ?Sized>(
        &self,
        sys: &Y,
        _stage: usize,
        z: &[f64],
        force: &[f64],
        slope: &mut [f64],
    ) {
        slope[sys.modes()..].copy_from_slice(force);
        add_linear(sys.omega(), sys.damping(), z, slope, 1);
    }

    fn pull_back(&self, _stage: usize, _slope: &mut [f64], _width: usize) {}

    fn push_forward(&self, _stage: usize, _y: &mut [f64], _width: usize) {}

    fn push_forward_by(&mut self, _offset: f64, _y: &mut [f64], _width: usize) {}
}
