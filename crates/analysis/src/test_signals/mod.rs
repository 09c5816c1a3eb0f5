//! Test signals: closed-form signals, and chaotic systems with known exponents.

pub mod recorded;
mod systems;
pub mod textbook;

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Sum of sines, each (frequency in Hz, amplitude, phase in rad).
pub fn sines(sample_rate: f64, n: usize, tones: &[(f64, f64, f64)]) -> Vec<f64> {
    let at = |i: usize| {
        let t = i as f64 / sample_rate;
        tones
            .iter()
            .map(|(f, a, phase)| a * (TAU * f * t + phase).sin())
            .sum()
    };
    (0..n).map(at).collect()
}

/// Gaussian white noise of the given standard deviation (Box-Muller).
pub fn noise(seed: u64, n: usize, deviation: f64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || {
        let (u, v): (f64, f64) = (rng.random(), rng.random());
        (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
    };
    (0..n).map(|_| deviation * normal()).collect()
}

/// `n` states of the Lorenz system (10, 28, 8/3) on the attractor, `dt` apart: `x' = 10 (y - x)`,
/// `y' = x (28 - z) - y`, `z' = x y - 8/3 z`.
///
/// The largest Lyapunov exponent is 0.9056 (Sprott). Another `start` (any state but zero) gives another
/// section of the attractor.
pub fn lorenz(n: usize, dt: f64, start: [f64; 3]) -> Vec<[f64; 3]> {
    let flow = |[x, y, z]: [f64; 3]| [10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z];
    trajectory(flow, start, 100.0, n, dt, 0.002)
}

/// `n` states of the Roessler system, `dt` apart, after 1000 time units: `x' = -y - z`, `y' = x + a y`,
/// `z' = b + z (x - c)`, parameters `[a, b, c]`.
///
/// At 0.2, 0.2, 5.7 it is chaotic: the largest Lyapunov exponent is 0.0714 (Sprott), the mean period
/// about 5.86.
pub fn roessler(n: usize, dt: f64, [a, b, c]: [f64; 3], start: [f64; 3]) -> Vec<[f64; 3]> {
    let flow = |[x, y, z]: [f64; 3]| [-y - z, x + a * y, b + z * (x - c)];
    trajectory(flow, start, 1000.0, n, dt, 0.01)
}

/// One coordinate of each state.
pub fn coordinate(states: &[[f64; 3]], c: usize) -> Vec<f64> {
    states.iter().map(|state| state[c]).collect()
}

/// States `dt` apart after a transient, computed with the classical Runge-Kutta method in equal steps of
/// at most `step`.
fn trajectory<const N: usize>(
    flow: impl Fn([f64; N]) -> [f64; N],
    start: [f64; N],
    transient: f64,
    n: usize,
    dt: f64,
    step: f64,
) -> Vec<[f64; N]> {
    let mut state = advance(&flow, start, transient, step);
    let mut next = || {
        let after = advance(&flow, state, dt, step);
        std::mem::replace(&mut state, after)
    };
    (0..n).map(|_| next()).collect()
}

/// The state after a duration, computed as in [`trajectory`].
fn advance<const N: usize>(
    flow: impl Fn([f64; N]) -> [f64; N],
    mut s: [f64; N],
    duration: f64,
    step: f64,
) -> [f64; N] {
    let ahead = |s: [f64; N], k: [f64; N], h: f64| std::array::from_fn(|c| s[c] + h * k[c]);
    let steps = (duration / step).ceil();
    let h = duration / steps.max(1.0);
    for _ in 0..steps as usize {
        let k1 = flow(s);
        let k2 = flow(ahead(s, k1, h / 2.0));
        let k3 = flow(ahead(s, k2, h / 2.0));
        let k4 = flow(ahead(s, k3, h));
        let mean = |c: usize| (k1[c] + 2.0 * k2[c] + 2.0 * k3[c] + k4[c]) / 6.0;
        s = ahead(s, std::array::from_fn(mean), h);
    }
    s
}

#[test]
fn the_lorenz_attractor_satisfies_its_mean_balances() {
    // The time average of the derivative of a bounded quantity is 0. With x^2 / 2 and z this gives <x^2>
    // = <x y> = 8/3 <z>, here within the bound divided by the duration of 1000.
    let states = lorenz(50_000, 0.02, [1.0, 1.0, 1.0]);
    let count = states.len() as f64;
    let mean = |f: fn(&[f64; 3]) -> f64| states.iter().map(f).sum::<f64>() / count;
    let (squares, product, height) = (
        mean(|s| s[0] * s[0]),
        mean(|s| s[0] * s[1]),
        mean(|s| 8.0 / 3.0 * s[2]),
    );
    assert!((squares - product).abs() < 0.02, "{squares} {product}");
    assert!((product - height).abs() < 0.05, "{product} {height}");
    assert!(height > 60.0 && mean(|s| s[0]).abs() < 0.5);
}

#[test]
fn the_roessler_attractor_has_its_known_size() {
    // Bounds of the attractor: x from about -9.1 to 11.5, z up to about 23. The mean period is 5.86.
    let states = roessler(20_000, 0.1, [0.2, 0.2, 5.7], [1.0, 1.0, 0.0]);
    let x = coordinate(&states, 0);
    let [low, high] = squeakscope_analysis::stats::range(x.iter().copied());
    assert!(
        (low + 9.1).abs() < 0.2 && (high - 11.5).abs() < 0.4,
        "{low} {high}"
    );
    let cycles = x.windows(2).filter(|w| w[0] < 0.0 && w[1] >= 0.0).count();
    assert!((2000.0 / cycles as f64 - 5.86).abs() < 0.05, "{cycles}");
}
