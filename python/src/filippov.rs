//! Laws that jump at the zeros of guards: the motion crosses them, is reset there, or slides on them (Filippov).

use nalgebra::{DMatrix, DVector};
use squeakscope::dynamics::{Switching, central_difference};

use crate::system::OwnSystem;

/// Signs of a guard: the law below zero, on it (sliding), and above.
const BELOW: i8 = -1;
pub const ON: i8 = 0;
const ABOVE: i8 = 1;

/// Distance from a guard that counts as on it, relative to the state: a few units in the last place.
const ROUNDING: f64 = 1e-15;

/// Part of a tangent vector that is left by rounding when it is projected away.
const VANISHED: f64 = 1e-12;

/// Part of a law that differences leave of one that is cancelled.
const CANCELLED: f64 = 1e-9;

impl OwnSystem {
    /// The law for the signs of the guards: of a sliding guard, the combination of the laws on both sides that keeps
    /// it at zero (Filippov), if it has one that attracts. Contributions of several sliding guards add. Returns the
    /// shares of the laws above, which leave 0 to 1 where the sliding ends, and whether each guard attracts.
    pub fn law(&self, signs: &[i8], t: f64, z: &[f64], out: &mut [f64]) -> Vec<(f64, bool)> {
        let sliding: Vec<usize> = (0..signs.len()).filter(|&k| signs[k] == ON).collect();
        // The law with one of the sliding guards above zero, and the rates of the guards.
        let side = |above: Option<usize>, out: &mut [f64]| {
            let mut all = signs.to_vec();
            for &k in &sliding {
                all[k] = if above == Some(k) { ABOVE } else { BELOW };
            }
            let signs = self.events.as_ref().map(|_| all.as_slice());
            self.call(("rhs", &self.rhs), signs, t, z, out);
            let mut rates = vec![0.0; signs.map_or(0, <[i8]>::len)];
            if !sliding.is_empty() {
                central_difference((t, z), (out, 1.0), &mut rates, |t, z, out| {
                    self.raw_guards(t, z, out)
                });
            }
            rates
        };
        let base = side(None, out);
        if sliding.is_empty() {
            return Vec::new();
        }
        let below = out.to_vec();
        let others = sliding.iter().map(|&k| {
            let mut law = vec![0.0; z.len()];
            let rates = side(Some(k), &mut law);
            (law, rates)
        });
        let others: Vec<_> = others.collect();
        let m = sliding.len();
        let change = DMatrix::from_fn(m, m, |i, j| others[j].1[sliding[i]] - base[sliding[i]]);
        let attracts: Vec<bool> = (0..m).map(|k| change[(k, k)] < 0.0).collect();
        let right = DVector::from_fn(m, |i, _| -base[sliding[i]]);
        let shares = change.lu().solve(&right);
        let shares = shares.unwrap_or_else(|| DVector::from_element(m, f64::NAN));
        for (c, out) in out.iter_mut().enumerate() {
            let parts = shares
                .iter()
                .zip(&others)
                .map(|(share, (law, _))| share * (law[c] - below[c]));
            let change: f64 = parts.sum();
            *out += change;
            // What holds the motion cancels but for rounding.
            if out.abs() < CANCELLED * change.abs() {
                *out = 0.0;
            }
        }
        shares.iter().copied().zip(attracts).collect()
    }

    /// Whether a guard holds the motion on it: the laws of both sides lead to it.
    fn slides(&self, signs: &[i8], guard: usize, t: f64, z: &[f64]) -> bool {
        let mut signs = signs.to_vec();
        signs[guard] = ON;
        let place = signs[..guard].iter().filter(|sign| **sign == ON).count();
        let (share, attracts) = self.law(&signs, t, z, &mut vec![0.0; z.len()])[place];
        attracts && (0.0..=1.0).contains(&share)
    }

    /// The guard of the functions that was crossed, and whether it rose (1) or fell (-1) from a status.
    pub fn event(&self, crossed: usize, before: &[u8]) -> (usize, i8) {
        let guard = crossed % self.guards;
        let direction = match before[guard] as i8 {
            ON if crossed == guard => BELOW,
            ON => ABOVE,
            sign => -sign,
        };
        (guard, direction)
    }

    /// The gradient of a guard by its state.
    fn gradient(&self, guard: usize, t: f64, z: &[f64]) -> Vec<f64> {
        let mut slopes = vec![0.0; self.guards];
        let slope = |c: usize| {
            let mut unit = vec![0.0; z.len()];
            unit[c] = 1.0;
            central_difference((t, z), (&unit, 0.0), &mut slopes, |t, z, out| {
                self.raw_guards(t, z, out)
            });
            slopes[guard]
        };
        (0..z.len()).map(slope).collect()
    }
}

/// The signs of a status.
pub fn signs(status: &[u8]) -> Vec<i8> {
    status.iter().map(|byte| *byte as i8).collect()
}

/// A status is the sign of each guard as a byte. Guard `k` of the functions has two guards here: the end of its sign,
/// or of sliding towards the law below, at `k`, and of sliding towards the law above at `guards + k`.
impl Switching for OwnSystem {
    fn status_len(&self) -> usize {
        self.guards
    }

    fn status_of(&self, t: f64, z: &[f64], status: &mut [u8]) {
        let mut values = vec![0.0; status.len()];
        self.raw_guards(t, z, &mut values);
        let mut found: Vec<i8> = values
            .iter()
            .map(|h| if *h < 0.0 { BELOW } else { ABOVE })
            .collect();
        for guard in (0..values.len()).filter(|&k| values[k] == 0.0) {
            if self.reset(t, z, guard).is_none() && self.slides(&found, guard, t, z) {
                found[guard] = ON;
            }
        }
        for (status, sign) in status.iter_mut().zip(found) {
            *status = sign as u8;
        }
    }

    fn force_in(&self, status: &[u8], t: f64, z: &[f64], out: &mut [f64]) {
        self.law(&signs(status), t, z, out);
    }

    fn guards(&self) -> usize {
        2 * self.guards
    }

    fn guard_values(&self, status: &[u8], t: f64, z: &[f64], values: &mut [f64]) {
        let signs = signs(status);
        let size = z.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let (below, above) = values.split_at_mut(self.guards);
        self.raw_guards(t, z, below);
        above.fill(1.0);
        for (value, sign) in below.iter_mut().zip(&signs) {
            *value = *value * f64::from(*sign) + ROUNDING * size;
        }
        if signs.contains(&ON) {
            let shares = self.law(&signs, t, z, &mut vec![0.0; z.len()]);
            let sliding = (0..signs.len()).filter(|&k| signs[k] == ON);
            for (k, (share, _)) in sliding.zip(shares) {
                (below[k], above[k]) = (share, 1.0 - share);
            }
        }
    }

    fn cross(&self, guard: usize, t: f64, z: &mut [f64], status: &mut [u8]) {
        let before = signs(status);
        let k = guard % self.guards;
        let after = if before[k] == ON {
            if guard == k { BELOW } else { ABOVE }
        } else if let Some(after) = self.reset(t, z, k) {
            return z.copy_from_slice(&after);
        } else if self.slides(&before, k, t, z) {
            ON
        } else {
            -before[k]
        };
        status[k] = after as u8;
    }

    fn settle(&self, status: &[u8], t: f64, z: &mut [f64], (vectors, width): (&mut [f64], usize)) {
        let sliding = (0..status.len()).filter(|&k| status[k] as i8 == ON);
        for guard in sliding {
            let mut values = vec![0.0; self.guards];
            self.raw_guards(t, z, &mut values);
            let gradient = self.gradient(guard, t, z);
            let square: f64 = gradient.iter().map(|g| g * g).sum();
            for (z, g) in z.iter_mut().zip(&gradient) {
                *z -= g * values[guard] / square;
            }
            for l in 0..width {
                let vector = || vectors.iter().skip(l).step_by(width);
                let size = vector().fold(0.0_f64, |most, x| most.max(x.abs()));
                let across: f64 = vector().zip(&gradient).map(|(v, g)| v * g).sum::<f64>() / square;
                for (v, g) in vectors.iter_mut().skip(l).step_by(width).zip(&gradient) {
                    *v -= g * across;
                    if v.abs() < VANISHED * size {
                        *v = 0.0;
                    }
                }
            }
        }
    }
}
