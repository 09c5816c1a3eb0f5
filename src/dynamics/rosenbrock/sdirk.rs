//! Coefficients of the singly diagonally implicit Runge–Kutta (SDIRK) method of order 4 in E. Hairer, G.
//! Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996, Table IV.6.5.

pub(super) const STAGES: usize = 5;

pub(super) const GAMMA: f64 = 0.25;

pub(super) const NODES: [f64; STAGES] = [0.25, 0.75, 0.55, 0.5, 1.0];

/// Weights below the diagonal. The last stage is the solution.
pub(super) const WEIGHTS: [&[f64]; STAGES] = [
    &[],
    &[0.5],
    &[17.0 / 50.0, -1.0 / 25.0],
    &[371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0],
    &[25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0],
];
