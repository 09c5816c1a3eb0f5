//! Systems of the textbook signals: flows, maps and a delay equation, with their largest exponents.

use std::f64::consts::TAU;

use super::advance;

/// Right-hand side of an autonomous system; a driven one has the phase of its drive as last component.
pub(super) type Flow<const N: usize> = Box<dyn Fn([f64; N]) -> [f64; N]>;

/// `x' = s (y - x)`, `y' = x (r - z) - y`, `z' = x y - 8/3 z`, `s = 10`.
pub(super) fn lorenz(r: f64) -> Flow<3> {
    Box::new(move |[x, y, z]| [10.0 * (y - x), x * (r - z) - y, x * y - 8.0 / 3.0 * z])
}

/// Roessler system (`a = b = 0.2`) driven by `e cos p`: `x' = -y - z + e cos p`, `y' = x + 0.2 y`,
/// `z' = 0.2 + z (x - c)`, `p' = w`. Without drive its period doubles at `c` = 2.83, 3.84, 4.12, ...; with a
/// weak drive of a frequency of its own the torus doubles instead.
pub(super) fn driven_roessler(c: f64, e: f64, w: f64) -> Flow<4> {
    Box::new(move |[x, y, z, p]| [-y - z + e * p.cos(), x + 0.2 * y, 0.2 + z * (x - c), w])
}

/// Duffing oscillator: `x'' + d x' + l x + x^3 = g cos p`, `p' = w`.
pub(super) fn duffing(d: f64, l: f64, g: f64, w: f64) -> Flow<3> {
    Box::new(move |[x, v, p]| [v, -d * v - l * x - x.powi(3) + g * p.cos(), w])
}

/// Driven oscillator of van der Pol: `x'' - m (1 - x^2) x' + x = g cos p`, `p' = w`.
pub(super) fn van_der_pol(m: f64, g: f64, w: f64) -> Flow<3> {
    Box::new(move |[x, v, p]| [v, m * (1.0 - x * x) * v - x + g * p.cos(), w])
}

/// Circuit of Chua, dimensionless: slopes -8/7 and -5/7, `b = 100/7`.
pub(super) fn chua(a: f64) -> Flow<3> {
    Box::new(move |[x, y, z]| {
        let current = -5.0 / 7.0 * x - 3.0 / 14.0 * ((x + 1.0).abs() - (x - 1.0).abs());
        [a * (y - x - current), x - y + z, -100.0 / 7.0 * y]
    })
}

/// Largest Lyapunov exponent per unit of time: growth of the distance of two trajectories, renormalised
/// every `step` (G. Benettin, L. Galgani and J.-M. Strelcyn, Phys. Rev. A 14, 2338, 1976).
pub(super) fn exponent<const N: usize>(
    flow: &Flow<N>,
    start: [f64; N],
    duration: f64,
    step: f64,
) -> f64 {
    const DISTANCE: f64 = 1e-7;
    let mut a = start;
    let mut b = a;
    b[0] += DISTANCE;
    let steps = (duration / step) as usize;
    let mut growth = 0.0;
    for k in 0..steps {
        a = advance(flow, a, step, step);
        b = advance(flow, b, step, step);
        let distance = (0..N).map(|c| (b[c] - a[c]).powi(2)).sum::<f64>().sqrt();
        // The first fifth aligns the difference.
        growth += if 5 * k < steps {
            0.0
        } else {
            (distance / DISTANCE).ln()
        };
        b = std::array::from_fn(|c| a[c] + (b[c] - a[c]) * DISTANCE / distance);
    }
    growth / (0.8 * steps as f64 * step)
}

/// `n` iterates of a map after 2000 others.
pub(super) fn iterate<const N: usize>(
    map: impl Fn([f64; N]) -> [f64; N],
    mut state: [f64; N],
    n: usize,
) -> Vec<[f64; N]> {
    for _ in 0..2000 {
        state = map(state);
    }
    let next = |_| {
        state = map(state);
        state
    };
    (0..n).map(next).collect()
}

/// Logistic map.
pub(super) fn logistic(a: f64) -> impl Fn([f64; 1]) -> [f64; 1] {
    move |[x]| [a * x * (1.0 - x)]
}

/// Map of Henon.
pub(super) fn henon(a: f64) -> impl Fn([f64; 2]) -> [f64; 2] {
    move |[x, y]| [1.0 - a * x * x + y, 0.3 * x]
}

/// Logistic map modulated by a rotation of `w` per step, whose torus doubles (K. Kaneko, Prog. Theor. Phys. 72,
/// 202, 1984): `x -> a x (1 - x) + e cos p`.
pub(super) fn kaneko(a: f64, e: f64, w: f64) -> impl Fn([f64; 2]) -> [f64; 2] {
    move |[x, p]| [a * x * (1.0 - x) + e * p.cos(), (p + w).rem_euclid(TAU)]
}

/// `n` samples `dt` apart, after 2000 time units, of `x' = 0.2 x(t - delay) / (1 + x(t - delay)^10) - 0.1 x`
/// (M. C. Mackey and L. Glass, Science 197, 287, 1977), by the Runge-Kutta method with steps of `dt / 10`
/// and linear interpolation of the past.
pub(super) fn mackey_glass(n: usize, dt: f64, delay: f64, start: f64) -> Vec<f64> {
    let back = (delay / (dt / 10.0)).round() as usize;
    let h = delay / back as f64;
    let rate = |x: f64, past: f64| 0.2 * past / (1.0 + past.powi(10)) - 0.1 * x;
    let mut x = vec![start; back + 1];
    for _ in 0..(2000.0 / h) as usize + 10 * n {
        let now = x[x.len() - 1];
        let (past, later) = (x[x.len() - 1 - back], x[x.len() - back]);
        let middle = 0.5 * (past + later);
        let k1 = rate(now, past);
        let k2 = rate(now + 0.5 * h * k1, middle);
        let k3 = rate(now + 0.5 * h * k2, middle);
        let k4 = rate(now + h * k3, later);
        x.push(now + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4));
    }
    let late = &x[x.len() - 10 * n..];
    late.iter().step_by(10).copied().collect()
}
