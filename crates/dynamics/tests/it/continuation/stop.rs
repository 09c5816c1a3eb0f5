//! A driven oscillator that reaches a soft stop: the grazing of a continuous system.

use std::f64::consts::TAU;

use super::systems::Smooth;
use super::*;
use crate::systems::by_differences;
use squeakscope_dynamics::{Differentiable, Switching, System};

const DAMPING: f64 = 0.1;
/// Distance and stiffness of the stop.
const STOP: [f64; 2] = [1.2, 5.0];

/// `x'' + 2 zeta x' + x = cos(W t + phase) - k max(x - d, 0)`.
struct Stop {
    drive: f64,
    phase: f64,
    /// The status of contact: 0 or 1.
    touching: u8,
}

impl Stop {
    fn rates(&self, t: f64, x: f64, touches: bool) -> f64 {
        let [distance, stiffness] = STOP;
        let push = if touches {
            stiffness * (x - distance)
        } else {
            0.0
        };
        (self.drive * t + self.phase).cos() - push
    }
}

impl System for Stop {
    fn omega(&self) -> &[f64] {
        &[1.0]
    }
    fn damping(&self) -> &[f64] {
        &[DAMPING]
    }
    fn force(&self, t: f64, z: &[f64], out: &mut [f64]) {
        out[0] = self.rates(t, z[0], z[0] > STOP[0]);
    }
    fn switching(&self) -> Option<&dyn Switching> {
        Some(self)
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
    fn is_autonomous(&self) -> bool {
        false
    }
}

by_differences!(Stop);

impl Switching for Stop {
    fn status_of(&self, _t: f64, z: &[f64], status: &mut [u8]) {
        let touches = u8::from(z[0] > STOP[0]);
        status[0] = 1 - (self.touching ^ touches);
    }
    fn force_in(&self, status: &[u8], t: f64, z: &[f64], out: &mut [f64]) {
        out[0] = self.rates(t, z[0], status[0] == self.touching);
    }
    fn guards(&self) -> usize {
        1
    }
    fn guard_values(&self, status: &[u8], _t: f64, z: &[f64], values: &mut [f64]) {
        let beyond = z[0] - STOP[0];
        values[0] = if status[0] == self.touching {
            beyond
        } else {
            -beyond
        };
    }
    fn cross(&self, _guard: usize, _t: f64, _z: &mut [f64], status: &mut [u8]) {
        status[0] ^= 1;
    }
    fn is_continuous(&self) -> bool {
        true
    }
    fn guard_gradient(
        &self,
        status: &[u8],
        _guard: usize,
        _t: f64,
        _z: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let slope = if status[0] == self.touching {
            1.0
        } else {
            -1.0
        };
        gradient.copy_from_slice(&[slope, 0.0]);
        0.0
    }
}

/// The linear response has the amplitude `1 / |1 - W^2 + 2 i zeta W|`, and reaches the stop where this is its distance. The
/// grazing is found from orbits with and without contact, at phases of the drive at which they touch the stop or do not, and
/// whichever status has the number zero.
#[test]
fn the_stop_is_grazed_where_the_linear_response_reaches_it() {
    // (1 - W^2)^2 + (2 zeta W)^2 = 1 / d^2, below resonance.
    let half = 1.0 - 2.0 * DAMPING * DAMPING;
    let square = half - (half * half - 1.0 + STOP[0].powi(-2)).sqrt();
    let exact = square.sqrt();
    let options = precise([0.7 * exact, 1.5 * exact], 0.1);
    for (start, phase, touching) in [
        (0.8, 0.0, 1),
        (1.4, 0.0, 1),
        (1.4, 1.0, 1),
        (1.4, 2.5, 0),
        (0.8, 4.0, 0),
    ] {
        let family = Smooth {
            build: move |drive: f64| {
                Box::new(Stop {
                    drive,
                    phase,
                    touching,
                }) as Box<dyn System>
            },
            drive: Some(|drive| TAU / drive),
        };
        let orbit = settle(&family, start * exact, &[0.0, 0.0], 400.0, &options);
        assert_eq!(orbit.open_guards, usize::from(start > 1.0));
        let branch = follow(&family, orbit, &options);
        let [grazing] = &of_kind(&branch, BifurcationKind::Grazing)[..] else {
            panic!("{:?}", branch.bifurcations);
        };
        // Between samples of the orbit the minimum is that of a cubic, with an error of about 1e-8.
        let error = (grazing.parameter - exact).abs();
        assert!(error < 3e-8, "{error:e}");
    }
}
