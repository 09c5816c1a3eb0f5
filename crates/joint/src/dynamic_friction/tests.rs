use super::*;
use crate::vector::norm;

/// Derivatives of coefficient and rate of the state by components of the slip velocity and of the state.
struct Slopes {
    coefficient_by_velocity: [[f64; 3]; 3],
    coefficient_by_state: [[f64; 3]; 3],
    rate_by_velocity: [[f64; 3]; 3],
    rate_by_state: [[f64; 3]; 3],
}

impl DynamicFriction {
    fn slopes(&self, velocity: [f64; 3], state: [f64; 3]) -> Slopes {
        let [coefficient, rate] = self.duals::<6>(velocity, state);
        let by = |of: [Dual<Scalar, 1, 6>; 3], first: usize| {
            of.map(|of| [0, 1, 2].map(|j| of.slopes[first + j].sum()))
        };
        Slopes {
            coefficient_by_velocity: by(coefficient, 0),
            coefficient_by_state: by(coefficient, 3),
            rate_by_velocity: by(rate, 0),
            rate_by_state: by(rate, 3),
        }
    }
}

const BRISTLES: LuGre = LuGre {
    mu_s: 0.55,
    mu_d: 0.25,
    stribeck: 10.0,
    stiffness: 1e5,
    damping: 3.0,
    viscous: 0.2,
};

const AGEING: RateAndState = RateAndState {
    mu_0: 0.4,
    direct: 0.01,
    evolution: 0.03,
    reference_speed: 1e-3,
    distance: 5e-6,
};

/// Integrates the state at a slip velocity along the first axis by the classical Runge-Kutta method with steps of
/// `h` seconds, and returns the coefficient after each step.
fn driven(
    law: DynamicFriction,
    mut state: f64,
    h: f64,
    steps: usize,
    velocity: impl Fn(f64) -> f64,
) -> Vec<f64> {
    // Coefficient, and rate of the state, along the first axis.
    let at = |t: f64, s: f64| {
        let response = law.response([velocity(t), 0.0, 0.0], [s, 0.0, 0.0]);
        response.map(|vector| vector[0])
    };
    let mut all = Vec::new();
    for k in 0..steps {
        let t = k as f64 * h;
        let slope = |t: f64, s: f64| {
            let [_, rate] = at(t, s);
            rate
        };
        let a = slope(t, state);
        let b = slope(t + 0.5 * h, state + 0.5 * h * a);
        let c = slope(t + 0.5 * h, state + 0.5 * h * b);
        let d = slope(t + h, state + h * c);
        state += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
        let [coefficient, _] = at(t + h, state);
        all.push(coefficient);
    }
    all
}

/// In steady sliding the state rests, and the coefficient is the closed form.
#[test]
fn steady_sliding_has_the_closed_form() {
    for speed in [1e-5_f64, 1e-3, 0.0159, 0.3, 5.0] {
        let cases = [
            (
                DynamicFriction::LuGre(BRISTLES),
                0.25 + 0.3 * (-10.0 * speed).exp() + 0.2 * speed,
            ),
            (
                DynamicFriction::RateAndState(AGEING),
                0.4 - 0.02 * (speed / 1e-3).ln(),
            ),
        ];
        for (law, exact) in cases {
            let [coefficient, rate] = law.response([speed, 0.0, 0.0], law.steady_state(speed));
            assert!(
                (coefficient[0] / exact - 1.0).abs() < 1e-12,
                "{law:?} {speed}"
            );
            let scale = match law {
                DynamicFriction::LuGre(law) => law.stiffness * speed,
                DynamicFriction::RateAndState(law) => speed / law.distance,
            };
            assert!(rate[0].abs() < 1e-14 * scale, "{law:?} {speed}");
        }
    }
}

/// The derivatives are those of central differences, also at rest.
#[test]
fn slopes_are_the_derivatives() {
    for law in [
        DynamicFriction::LuGre(BRISTLES),
        DynamicFriction::RateAndState(AGEING),
    ] {
        let states = [[0.31, -0.12, 0.05], [-2.5, 0.0, 0.0]];
        for state in states {
            for velocity in [[0.02, -0.01, 0.003], [-1e-4, 2e-4, 0.0], [0.7, 0.0, 0.1]] {
                let slopes = law.slopes(velocity, state);
                let differs = |got: f64, exact: f64, scale: f64| {
                    assert!((got - exact).abs() <= 1e-6 * scale, "{law:?} {got} {exact}");
                };
                for j in 0..3 {
                    let moved = |of: [f64; 3], h: f64| {
                        let mut of = of;
                        of[j] += h;
                        of
                    };
                    let h = 1e-5 * norm(velocity);
                    let [[low, low_rate], [high, high_rate]] =
                        [-h, h].map(|h| law.response(moved(velocity, h), state));
                    let size = slopes.coefficient_by_velocity.as_flattened();
                    let size = size.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                    let fast = slopes.rate_by_velocity.as_flattened();
                    let fast = fast.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                    for i in 0..3 {
                        let exact = (high[i] - low[i]) / (2.0 * h);
                        differs(slopes.coefficient_by_velocity[i][j], exact, size);
                        let exact = (high_rate[i] - low_rate[i]) / (2.0 * h);
                        differs(slopes.rate_by_velocity[i][j], exact, fast);
                    }
                    let [[low, low_rate], [high, high_rate]] =
                        [-1e-5, 1e-5].map(|h| law.response(velocity, moved(state, h)));
                    for i in 0..3 {
                        let exact = (high[i] - low[i]) / 2e-5;
                        differs(slopes.coefficient_by_state[i][j], exact, 1.0);
                        let exact = (high_rate[i] - low_rate[i]) / 2e-5;
                        let scale = 1.0 + slopes.rate_by_state[i][i].abs();
                        differs(slopes.rate_by_state[i][j], exact, scale);
                    }
                }
            }
        }
    }
    let resting = DynamicFriction::LuGre(BRISTLES).slopes([0.0; 3], [0.2, 0.0, 0.0]);
    assert_eq!(resting.rate_by_velocity[0], [1e5, 0.0, 0.0]);
}

/// Before sliding, the bristles are springs of stiffness `sigma_0`, and their dashpots act at once.
#[test]
fn bristles_are_springs_before_they_slide() {
    let law = LuGre {
        damping: 0.0,
        viscous: 0.0,
        ..BRISTLES
    };
    // 10 nm at 0.1 mm/s: 1/300 of the way to sliding.
    let pushed = driven(DynamicFriction::LuGre(law), 0.0, 1e-7, 1000, |_| 1e-4);
    let springs = 1e5 * 1e-8;
    let share = springs / law.steady(1e-4);
    // ds/dx = sigma_0 (1 - s / mu) at a constant speed.
    let exact = law.steady(1e-4) * -(-share).exp_m1();
    assert!((pushed[999] / exact - 1.0).abs() < 1e-9, "{}", pushed[999]);
    assert!((pushed[999] / springs - 1.0).abs() < 2e-3);
    let [coefficient, _] = DynamicFriction::LuGre(BRISTLES).response([1e-4, 0.0, 0.0], [0.0; 3]);
    assert!((coefficient[0] / ((3.0 + 0.2) * 1e-4) - 1.0).abs() < 1e-12);
}

/// A force that increases slowly breaks the contact away at `mu_s`, one that increases fast at less: the bristles
/// slide faster before they are bent.
#[test]
fn break_away_falls_with_the_rate_of_the_load() {
    let law = LuGre {
        damping: 0.0,
        viscous: 0.0,
        ..BRISTLES
    };
    // The velocity for a given rate r of the coefficient: sigma_0 V (1 - s / mu(V)) = r.
    let broken = |r: f64| {
        let (mut s, mut v) = (0.0, r / law.stiffness);
        let h = 1e-5 * law.mu_s / r;
        while v < 1.0 {
            for _ in 0..50 {
                let free = 1.0 - s / law.steady(v);
                if free <= 0.0 {
                    return s;
                }
                v = 0.5 * (v + r / (law.stiffness * free));
            }
            s += r * h;
        }
        s
    };
    let all = [0.1, 10.0, 1000.0].map(broken);
    assert!((all[0] / law.mu_s - 1.0).abs() < 1e-2, "{all:?}");
    assert!(all[0] > all[1] && all[1] > all[2], "{all:?}");
    assert!(all[2] > law.mu_d);
}

/// The power is at least the rate of the storage function while `sigma_1 |V| <= 4 mu(|V|)`.
#[test]
fn bristles_are_passive_up_to_the_stated_speed() {
    let mut seen = [0; 2];
    for k in 0..20_000 {
        // A sequence that fills the space of states and velocities evenly.
        let part = |alpha: f64| 2.0 * (f64::from(k) * alpha).fract() - 1.0;
        let velocity = [part(0.8192), part(0.6711), part(0.5497)].map(|v| 0.7 * v);
        let state = [part(0.4503), part(0.3689), part(0.3022)].map(|s| 0.6 * s);
        let [coefficient, rate] = DynamicFriction::LuGre(BRISTLES).response(velocity, state);
        let dot = |a: [f64; 3], b: [f64; 3]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let stored = dot(state, rate) / BRISTLES.stiffness;
        let lost = dot(coefficient, velocity) - stored;
        let speed = norm(velocity);
        let holds = BRISTLES.damping * speed <= 4.0 * BRISTLES.steady(speed);
        assert!(!holds || lost >= -1e-12, "{velocity:?} {state:?}: {lost}");
        seen[usize::from(holds)] += 1;
    }
    assert!(seen.iter().all(|count| *count > 1000), "{seen:?}");
}

/// The loop of a reciprocating motion that does not slide encloses an area that is small and positive, and the
/// law dissipates over every closed path while `sigma_1 |V| <= 4 mu`.
#[test]
fn bristles_dissipate_over_a_loop() {
    for amplitude in [1e-7, 1e-6, 1e-5, 1e-4] {
        let omega = 2.0 * std::f64::consts::PI * 100.0;
        let (steps, h) = (40_000, 5e-7);
        let speed = |t: f64| amplitude * omega * (omega * t).cos();
        let law = DynamicFriction::LuGre(BRISTLES);
        let forces = driven(law, 0.0, h, steps, speed);
        // The second period is closed.
        let later = (steps / 2..steps).map(|k| forces[k] * speed((k + 1) as f64 * h) * h);
        let lost: f64 = later.sum();
        assert!(lost > 0.0, "{amplitude}: {lost}");
        // Never more than sliding over the whole path.
        assert!(lost < 0.56 * 4.0 * amplitude, "{amplitude}: {lost}");
    }
}

/// A step of the speed raises the coefficient at once by `a ln(V2/V1)`, and it then evolves to a decrease of
/// `(b - a) ln(V2/V1)`, with the slip `D_c` for a state near its end.
#[test]
fn a_step_of_the_speed_has_a_direct_and_an_evolved_effect() {
    let law = DynamicFriction::RateAndState(AGEING);
    let [slow, fast]: [f64; 2] = [1e-3, 3e-3];
    let [before, at_once] = [slow, fast].map(|speed| {
        let [coefficient, _] = law.response([speed, 0.0, 0.0], law.steady_state(slow));
        coefficient[0]
    });
    let ln = (fast / slow).ln();
    assert!((at_once - before - 0.01 * ln).abs() < 1e-12);
    let h = 1e-3 * AGEING.distance / fast;
    let evolved = driven(law, law.steady_state(slow)[0], h, 20_000, |_| fast);
    assert!((evolved[19_999] - before - (0.01 - 0.03) * ln).abs() < 1e-7);
    // The last part decays by 1/e over D_c.
    let end = before - 0.02 * ln;
    let ratio = (evolved[5999] - end) / (evolved[4999] - end);
    assert!((ratio - (-1.0_f64).exp()).abs() < 0.01, "{ratio}");
}

/// The slope for an oscillation is the closed form of each law, and that of the driven law at small amplitude.
#[test]
fn a_fast_oscillation_meets_another_slope_than_a_slow_one() {
    let speed: f64 = 0.0159;
    let bristles = LuGre {
        stiffness: 2e5,
        damping: 0.5,
        ..BRISTLES
    };
    let falling = (bristles.mu_s - bristles.mu_d) * (-bristles.stribeck * speed).exp();
    let (mu, slope) = (bristles.mu_d + falling, -bristles.stribeck * falling);
    for (law, rate) in [
        (DynamicFriction::LuGre(bristles), 2e5 * speed / mu),
        (
            DynamicFriction::RateAndState(AGEING),
            speed / AGEING.distance,
        ),
    ] {
        let found = law.oscillating(speed);
        assert!((found.relaxation / rate - 1.0).abs() < 1e-12);
        for omega in [0.0, 0.3 * rate, rate, 5.0 * rate] {
            let share = 1.0 / (1.0 + (omega / rate).powi(2));
            let exact = match law {
                DynamicFriction::LuGre(law) => {
                    let dashpot = law.damping * speed / mu * slope * (1.0 - share);
                    slope * share + dashpot + law.viscous
                }
                DynamicFriction::RateAndState(law) => (law.direct - law.evolution * share) / speed,
            };
            let got = found.slope(omega);
            assert!((got / exact - 1.0).abs() < 1e-9, "{law:?}: {got} {exact}");
            if omega == 0.0 {
                continue;
            }
            // Work over the second of two periods, V = v + e cos(w t): e^2 pi/w times the slope.
            let (e, steps) = (1e-4 * speed, 20_000_usize);
            let periods = 2.0 + (10.0 * omega / rate).ceil();
            let h = std::f64::consts::TAU / omega / steps as f64;
            let all = (periods * steps as f64) as usize;
            let start = law.steady_state(speed)[0];
            let forces = driven(law, start, h, all, |t| speed + e * (omega * t).cos());
            let last = all - steps..all;
            let power = last.map(|k| forces[k] * (omega * (k + 1) as f64 * h).cos());
            let seen = 2.0 * power.sum::<f64>() / steps as f64 / e;
            assert!((seen / exact - 1.0).abs() < 1e-3, "{law:?}: {seen} {exact}");
        }
        let faster = law.with_faster_state(1e3).oscillating(speed);
        assert!((faster.slope(0.0) / found.slope(0.0) - 1.0).abs() < 1e-9);
        assert!((faster.slope(rate) / found.slope(0.0) - 1.0).abs() < 1e-2);
    }
    let critical = DynamicFriction::RateAndState(AGEING)
        .oscillating(speed)
        .damping_above();
    let exact = speed / AGEING.distance * (0.03_f64 / 0.01 - 1.0).sqrt();
    assert!((critical.unwrap() / exact - 1.0).abs() < 1e-12);
    let weak = RateAndState {
        evolution: 0.005,
        ..AGEING
    };
    assert_eq!(
        DynamicFriction::RateAndState(weak)
            .oscillating(speed)
            .damping_above(),
        None
    );
}

/// At rest the age of the contact increases with time, and its strength by `b ln`.
#[test]
fn a_contact_at_rest_ages() {
    let law = DynamicFriction::RateAndState(AGEING);
    let start = law.steady_state(1e-2)[0];
    let theta = AGEING.distance / 1e-2;
    let h = 1e-3 * theta;
    let mut state = start;
    for _ in 0..100_000 {
        let slope = |state: f64| {
            let [_, rate] = law.response([0.0; 3], [state, 0.0, 0.0]);
            rate[0]
        };
        let half = state + 0.5 * h * slope(state);
        state += h * slope(half);
    }
    let exact = (AGEING.reference_speed * 101.0 * theta / AGEING.distance).ln();
    assert!((state - exact).abs() < 1e-5, "{state} {exact}");
}

/// No number overflows at rest, at any speed, or with a strong direct effect.
#[test]
fn extreme_arguments_give_finite_numbers() {
    let strong = RateAndState {
        mu_0: 3.0,
        direct: 0.01,
        ..AGEING
    };
    for law in [
        DynamicFriction::LuGre(BRISTLES),
        DynamicFriction::RateAndState(AGEING),
        DynamicFriction::RateAndState(strong),
    ] {
        for speed in [0.0, 1e-300, 1e-9, 1e3] {
            for state in [-15.0, 0.0, 15.0] {
                let at = ([speed, 0.0, 0.0], [state, 0.0, 0.0]);
                let response = law.response(at.0, at.1);
                let slopes = law.slopes(at.0, at.1);
                let all = response.as_flattened().iter();
                let all = all.chain(slopes.coefficient_by_velocity.as_flattened());
                let mut all = all.chain(slopes.rate_by_state.as_flattened());
                assert!(all.all(|x| x.is_finite()), "{law:?} {speed} {state}");
            }
        }
        let [coefficient, _] = law.response([0.0; 3], [0.0; 3]);
        assert_eq!(coefficient, [0.0; 3]);
    }
}
