//! The plain form: the method integrates the state itself.
//!
//! A tableau in this form is the standard explicit Runge–Kutta method (Hairer, Norsett and Wanner,
//! Solving Ordinary Differential Equations I, 2nd ed., Section II.1). Its step must resolve the highest
//! natural frequency, even if that mode is not excited.

use pulp::Arch;

use super::System;
use super::combination::{Write, lanes};
use super::runge_kutta::{Form, Rows};
use super::system::add_linear;
use crate::instruction_set::instruction_set;

/// The method's coordinates are the state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plain {
    arch: Arch,
    dim: usize,
}

impl Plain {
    /// The plain form of a system.
    pub fn new<Y: System + ?Sized>(sys: &Y) -> Self {
        Self {
            arch: instruction_set(),
            dim: sys.dim(),
        }
    }
}

impl Form for Plain {
    fn row_len(&self) -> usize {
        self.dim.next_multiple_of(lanes(self.arch))
    }

    fn position(&self, component: usize) -> usize {
        component
    }

    fn pack(&self, z: &[f64], row: &mut [f64]) {
        row[..self.dim].copy_from_slice(z);
    }

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

    fn advance(&self, _stage: usize, rows: Rows<'_>, out: &mut [f64]) {
        let combination = rows.combination();
        self.arch.dispatch(Write { combination, out });
    }

    fn advance_by(&mut self, _offset: f64, rows: Rows<'_>, out: &mut [f64]) {
        self.advance(0, rows, out);
    }

    fn slope<Y: System + ?Sized>(
        &self,
        sys: &Y,
        _stage: usize,
        z: &[f64],
        force: &[f64],
        slope: &mut [f64],
    ) {
        let slope = &mut slope[..self.dim];
        let force = &force[..self.dim - sys.modes()];
        slope[sys.modes()..].copy_from_slice(force);
        add_linear(sys.omega(), sys.damping(), z, slope, 1);
    }

    fn pull_back(&self, _stage: usize, _slope: &mut [f64], _width: usize) {}

    fn push_forward(&self, _stage: usize, _y: &mut [f64], _width: usize) {}

    fn push_forward_by(&mut self, _offset: f64, _y: &mut [f64], _width: usize) {}
}
