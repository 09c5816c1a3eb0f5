//! The impact oscillator against the closed form of its orbits with one impact.

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Vector2};

use super::systems::Smooth;
use super::*;
use squeakscope_dynamics::System;
use squeakscope_joint::systems::ImpactOscillator;

const ZETA: f64 = 0.1;
const RESTITUTION: f64 = 0.8;

fn oscillator(drive_omega: f64, wall: f64) -> ImpactOscillator {
    ImpactOscillator {
        omega: 1.0,
        damping: ZETA,
        drive: 1.0,
        drive_omega,
        drive_phase: 0.0,
        wall,
        restitution: RESTITUTION,
    }
}

/// The motion between impacts: the response to the drive plus a free vibration.
#[derive(Clone, Copy)]
struct Flight {
    drive_omega: f64,
}

impl Flight {
    /// Position, velocity and acceleration of the response to `cos(W t)`.
    fn response(self, t: f64) -> [f64; 3] {
        let w = self.drive_omega;
        let (re, im) = (1.0 - w * w, 2.0 * ZETA * w);
        let size = re * re + im * im;
        let (sin, cos) = (w * t).sin_cos();
        let x = (re * cos + im * sin) / size;
        let v = w * (-re * sin + im * cos) / size;
        [x, v, -w * w * x]
    }

    /// The matrix of the free vibration over a time.
    fn free(t: f64) -> Matrix2<f64> {
        let wd = (1.0 - ZETA * ZETA).sqrt();
        let (sin, cos) = (wd * t).sin_cos();
        let decay = (-ZETA * t).exp();
        Matrix2::new(
            cos + ZETA / wd * sin,
            sin / wd,
            -sin / wd,
            cos - ZETA / wd * sin,
        ) * decay
    }

    fn at(self, start: f64, z: [f64; 2], t: f64) -> [f64; 2] {
        let [x0, v0, _] = self.response(start);
        let [x, v, _] = self.response(t);
        let free = Self::free(t - start) * Vector2::new(z[0] - x0, z[1] - v0);
        [x + free[0], v + free[1]]
    }

    /// The orbit with one impact per `periods` of the drive on a wall: the time and the velocity after the impact, by Newton's
    /// method.
    fn orbit(self, wall: f64, periods: f64, mut guess: [f64; 2]) -> [f64; 2] {
        let period = periods * TAU / self.drive_omega;
        let residual = |[t, v]: [f64; 2]| {
            let end = self.at(t, [wall, v], t + period);
            Vector2::new(end[0] - wall, -RESTITUTION * end[1] - v)
        };
        for _ in 0..50 {
            let here = residual(guess);
            let h = 1e-6;
            let columns = [0, 1].map(|j| {
                let [mut a, mut b] = [guess, guess];
                a[j] += h;
                b[j] -= h;
                (residual(a) - residual(b)) / (2.0 * h)
            });
            let step = Matrix2::from_columns(&columns).lu().solve(&here).unwrap();
            guess = [guess[0] - step[0], guess[1] - step[1]];
            if step.norm() < 1e-14 {
                break;
            }
        }
        guess
    }

    /// Trace and determinant of the return map of that orbit, in the coordinates of the flight (A. B. Nordmark, J. Sound Vib.
    /// 145 (1991) 279-297): the saltation of the impact after the free vibration.
    fn trace_and_determinant(self, wall: f64, periods: f64, [t, v]: [f64; 2]) -> [f64; 2] {
        let period = periods * TAU / self.drive_omega;
        let after = v;
        let before = -after / RESTITUTION;
        let acceleration = |v: f64| (self.drive_omega * t).cos() - 2.0 * ZETA * v - wall;
        let [a, b] = [acceleration(before), acceleration(after)];
        // dz+ = R dz- + (R F- - F+) dt with dt = -dx / v-.
        let jump = Matrix2::new(
            -RESTITUTION,
            0.0,
            (RESTITUTION * a + b) / before,
            -RESTITUTION,
        );
        let map = jump * Self::free(period);
        [map.trace(), map.determinant()]
    }
}

/// The zero of a function on an interval, by bisection.
fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let sign = f(low) > 0.0;
    assert_ne!(sign, f(high) > 0.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if (f(middle) > 0.0) == sign {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Without impacts the mass touches the wall where the amplitude equals its distance.
#[test]
fn the_grazing_of_the_free_orbit_is_exact() {
    let family = Smooth {
        build: |wall| Box::new(oscillator(1.6, wall)) as Box<dyn System>,
        drive: Some(|_| TAU / 1.6),
    };
    let amplitude = {
        let (re, im): (f64, f64) = (1.0 - 1.6 * 1.6, 2.0 * ZETA * 1.6);
        1.0 / re.hypot(im)
    };
    let options = precise([-1.0, -0.2], 0.1);
    let [x, v, _] = Flight { drive_omega: 1.6 }.response(0.0);
    let orbit = settle(&family, -0.9, &[x, v], 0.0, &options);
    assert_eq!(orbit.events, 0);
    let branch = follow(&family, orbit, &options);
    let last = branch.points.last().unwrap();
    eprintln!(
        "grazing: last {:e} from {:e}, {:?}, {:?}",
        last.parameter,
        -amplitude,
        branch.ends,
        branch
            .bifurcations
            .iter()
            .map(|b| (b.kind, b.parameter))
            .collect::<Vec<_>>()
    );
    let grazings = of_kind(&branch, BifurcationKind::Grazing);
    assert_eq!(grazings.len(), 1);
    assert!((grazings[0].parameter + amplitude).abs() < 1e-6);
    assert!((grazings[0].parameter + amplitude).abs() <= 2.0 * grazings[0].accuracy + 1e-9);
}

/// Orbits with one impact per period of the drive: multipliers, period doublings and folds over the drive frequency.
#[test]
fn orbits_with_one_impact_agree_with_their_closed_form() {
    let wall = 0.0;
    let family = Smooth {
        build: move |omega| Box::new(oscillator(omega, wall)) as Box<dyn System>,
        drive: Some(|omega| TAU / omega),
    };
    let options = precise([2.0, 3.2], 0.1);
    let orbit = settle(&family, 2.2, &[0.5, 0.0], 300.0, &options);
    eprintln!("start {orbit:?}");
    assert_eq!(orbit.events, 1);
    let periods = f64::from(orbit.drive_periods.unwrap());
    let branch = follow(&family, orbit, &options);
    // The closed form along the same branch.
    let mut guess = None;
    let mut worst = 0.0_f64;
    for orbit in &branch.points {
        let flight = Flight {
            drive_omega: orbit.parameter,
        };
        let [t, v] = match guess {
            Some(guess) => flight.orbit(wall, periods, guess),
            None => {
                // A scan of the phase of the impact.
                let fits = (0..40)
                    .map(|k| flight.orbit(wall, periods, [f64::from(k) * 0.1, 0.7]))
                    .find(|[_, v]| {
                        *v > 0.05
                            && (v / impact_velocity(&family, orbit, &options) - 1.0).abs() < 1e-6
                    });
                fits.expect("the orbit of the closed form")
            }
        };
        guess = Some([t, v]);
        let [trace, determinant] = flight.trace_and_determinant(wall, periods, [t, v]);
        let found: [f64; 2] = [
            orbit.multipliers.iter().map(|m| m.re()).sum(),
            orbit
                .multipliers
                .iter()
                .map(|m| m.ln_magnitude)
                .sum::<f64>()
                .exp(),
        ];
        worst = worst
            .max((found[0] - trace).abs() / (1.0 + trace.abs()))
            .max((found[1] - determinant.abs()).abs());
    }
    let kinds: Vec<_> = branch
        .bifurcations
        .iter()
        .map(|b| (b.kind, b.parameter))
        .collect();
    eprintln!(
        "{} points, worst {worst:e}, {kinds:?}, {:?}",
        branch.points.len(),
        branch.ends
    );
    assert!(worst < 1e-7, "{worst:e}");
    let doublings = of_kind(&branch, BifurcationKind::PeriodDoubling);
    assert!(!doublings.is_empty());
    for doubling in doublings {
        let start = guess.unwrap();
        let test = |omega: f64| {
            let flight = Flight { drive_omega: omega };
            let mut at = start;
            // Continue from the last point to this frequency.
            let from = branch.points.last().unwrap().parameter;
            for k in 1..=100 {
                let omega = from + (omega - from) * f64::from(k) / 100.0;
                at = Flight { drive_omega: omega }.orbit(wall, periods, at);
            }
            let [trace, determinant] = flight.trace_and_determinant(wall, periods, at);
            1.0 + trace + determinant
        };
        let exact = bisect(doubling.parameter - 1e-3, doubling.parameter + 1e-3, test);
        eprintln!("doubling error {:e}", doubling.parameter - exact);
        assert!((doubling.parameter - exact).abs() < 1e-8);
    }
}

/// The velocity after the impact of an orbit, from its samples near the wall.
fn impact_velocity(
    family: &dyn Family,
    orbit: &PeriodicOrbit,
    options: &ContinuationOptions,
) -> f64 {
    // Energy methods would need the phase; the largest change of the velocity between dense samples is at the impact.
    let samples = sample_orbit(family, orbit, 200_000, options);
    let jump = samples
        .windows(2)
        .max_by(|a, b| {
            let change = |pair: &[(f64, Vec<f64>)]| pair[1].1[1] - pair[0].1[1];
            change(a).total_cmp(&change(b))
        })
        .unwrap();
    // The sample after the impact, carried back to the wall.
    let (t, state) = &jump[1];
    let [x, v] = [state[0], state[1]];
    let sys = family.member(orbit.parameter).unwrap().system;
    let mut slope = [0.0; 2];
    sys.rhs(*t, state, &mut slope);
    v - slope[1] * (x / v)
}
