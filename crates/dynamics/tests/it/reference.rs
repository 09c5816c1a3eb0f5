//! Reference solutions that share no code with the methods under test.

use super::System;
use super::systems::Unilateral;

/// Extrapolated modified midpoint rule (W. B. Gragg, SIAM J. Numer. Anal. 2 (1965) 384–403; Hairer,
/// Norsett and Wanner, Section II.9) of order 16 in `steps` steps, for smooth systems.
pub fn extrapolated<Y: System>(sys: &Y, z0: &[f64], t_end: f64, steps: usize) -> Vec<f64> {
    extrapolated_from(sys, 0.0, z0, t_end, steps)
}

/// [`extrapolated`] from time `start`.
pub fn extrapolated_from<Y: System>(
    sys: &Y,
    start: f64,
    z0: &[f64],
    t_end: f64,
    steps: usize,
) -> Vec<f64> {
    const COLUMNS: usize = 8;
    let big = (t_end - start) / steps as f64;
    let mut z = z0.to_vec();
    for step in 0..steps {
        let t = start + step as f64 * big;
        let mut table: Vec<Vec<f64>> = Vec::new();
        for row in 0..COLUMNS {
            let mut line = midpoint(sys, t, &z, big, 2 * (row + 1));
            for column in 1..=row {
                let ratio = ((row + 1) as f64 / (row + 1 - column) as f64).powi(2) - 1.0;
                let before = std::mem::replace(&mut table[column - 1], line.clone());
                for (x, old) in line.iter_mut().zip(&before) {
                    *x += (*x - old) / ratio;
                }
            }
            table.push(line);
        }
        z.clone_from(&table[COLUMNS - 1]);
    }
    z
}

/// The midpoint rule without smoothing in `n` (even) substeps of a step `big`.
fn midpoint<Y: System>(sys: &Y, t: f64, z: &[f64], big: f64, n: usize) -> Vec<f64> {
    let h = big / n as f64;
    let mut slope = vec![0.0; z.len()];
    sys.rhs(t, z, &mut slope);
    let mut before = z.to_vec();
    let mut now: Vec<f64> = z.iter().zip(&slope).map(|(z, s)| z + h * s).collect();
    for k in 1..n {
        sys.rhs(t + k as f64 * h, &now, &mut slope);
        for (x, s) in before.iter_mut().zip(&slope) {
            *x += 2.0 * h * s;
        }
        std::mem::swap(&mut before, &mut now);
    }
    now
}

/// The state `[q | v]` of [`Unilateral`] at time `t_end`. Between contact changes the system is linear
/// and its Taylor series is exact to rounding. Contact changes are located by bisection on the series,
/// which then restarts.
pub fn unilateral(z0: &[f64], t_end: f64) -> Vec<f64> {
    const H: f64 = 0.01;
    let mut z = [0.0; 6];
    z.copy_from_slice(&z0[..6]);
    let mut t = 0.0;
    let mut in_contact: [bool; 3] = std::array::from_fn(|n| Unilateral::gap(n, &z) > 0.0);
    while t < t_end {
        let series = taylor(&z, in_contact);
        let h = H.min(t_end - t);
        let holds = |tau: f64| {
            (0..3).all(|n| (Unilateral::gap(n, &at(&series, tau)) > 0.0) == in_contact[n])
        };
        if holds(h) {
            z = at(&series, h);
            t = if h < H { t_end } else { t + h };
            continue;
        }
        // The first instant at which a contact changes.
        let (mut low, mut high) = (0.0, h);
        while high - low > 1e-16 {
            let middle = 0.5 * (low + high);
            if holds(middle) {
                low = middle
            } else {
                high = middle
            }
        }
        z = at(&series, high);
        t += high;
        in_contact = std::array::from_fn(|n| Unilateral::gap(n, &z) > 0.0);
    }
    z.to_vec()
}

/// Taylor coefficients of `[q | v]` for fixed contacts.
fn taylor(z: &[f64; 6], in_contact: [bool; 3]) -> [[f64; 6]; 14] {
    let mut series = [[0.0; 6]; 14];
    series[0] = *z;
    for order in 1..14 {
        let last = series[order - 1];
        let next = &mut series[order];
        for i in 0..3 {
            next[i] = last[3 + i];
            next[3 + i] = -Unilateral::OMEGA[i].powi(2) * last[i];
        }
        for (n, &in_contact) in in_contact.iter().enumerate() {
            let constant = if order == 1 { Unilateral::PRESS } else { 0.0 };
            let gap = Unilateral::gap(n, &last) - Unilateral::PRESS + constant;
            let change = if in_contact { gap } else { 0.0 } - constant;
            for i in 0..3 {
                next[3 + i] -= Unilateral::SHAPES[n][i] * change;
            }
        }
        next.iter_mut().for_each(|x| *x /= order as f64);
    }
    series
}

/// The Taylor polynomial at `tau`.
fn at(series: &[[f64; 6]; 14], tau: f64) -> [f64; 6] {
    let mut z = [0.0; 6];
    for term in series.iter().rev() {
        for (z, c) in z.iter_mut().zip(term) {
            *z = *z * tau + c;
        }
    }
    z
}
