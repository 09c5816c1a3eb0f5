//! Closed-form solutions of the smooth phases of non-smooth motions.

/// `x'' + 2 decay x' + stiffness x = drive cos(drive_omega t)`, less than critically damped.
#[derive(Clone, Copy)]
pub struct Oscillator {
    pub decay: f64,
    pub stiffness: f64,
    pub drive: f64,
    pub drive_omega: f64,
}

impl Oscillator {
    /// The steady-state response at time `t`.
    fn steady_state(&self, t: f64) -> [f64; 2] {
        let w = self.drive_omega;
        let (real, imaginary) = (self.stiffness - w * w, 2.0 * self.decay * w);
        let square = real * real + imaginary * imaginary;
        let (a, b) = (self.drive * real / square, self.drive * imaginary / square);
        let (s, c) = (w * t).sin_cos();
        [a * c + b * s, w * (b * c - a * s)]
    }

    /// The state at time `t` from `z0` at `t0`.
    pub fn at(&self, t0: f64, z0: [f64; 2], t: f64) -> [f64; 2] {
        let (before, after) = (self.steady_state(t0), self.steady_state(t));
        let (x, v) = (z0[0] - before[0], z0[1] - before[1]);
        let w = (self.stiffness - self.decay * self.decay).sqrt();
        let (s, c) = (w * (t - t0)).sin_cos();
        let attenuation = (-self.decay * (t - t0)).exp();
        let b = (v + self.decay * x) / w;
        [
            after[0] + attenuation * (x * c + b * s),
            after[1] + attenuation * ((b * w - self.decay * x) * c - (x * w + self.decay * b) * s),
        ]
    }

    /// First time after `t0`, up to `end`, at which `sign * (x - level)` falls through zero.
    pub fn fall(&self, t0: f64, z0: [f64; 2], end: f64, sign: f64, level: f64) -> Option<f64> {
        const STEP: f64 = 1e-3;
        let height = |t: f64| sign * (self.at(t0, z0, t)[0] - level);
        let mut low = t0 + 1e-9;
        while low < end {
            let mut high = (low + STEP).min(end);
            if height(high) < 0.0 {
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if height(middle) < 0.0 {
                        high = middle;
                    } else {
                        low = middle;
                    }
                }
                return Some(high);
            }
            low = high;
        }
        None
    }
}
