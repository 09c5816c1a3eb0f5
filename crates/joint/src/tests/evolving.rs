//! Friction with states in the equation of motion.

use nalgebra::{DMatrix, DVector};

use super::*;
use squeakscope_dynamics::{Accuracy, Integrator, MethodName, Switching};

const BRISTLES: LuGre = LuGre {
    mu_s: 0.55,
    mu_d: 0.25,
    stribeck: 10.0,
    stiffness: 1e5,
    damping: 2.0,
    viscous: 0.1,
};

const AGEING: RateAndState = RateAndState {
    mu_0: 0.5,
    direct: 0.01,
    evolution: 0.03,
    reference_speed: 0.016,
    distance: 5e-6,
};

/// Both laws, with and without the radial slip velocity.
pub(super) fn laws() -> [Friction; 4] {
    let [bristles, ageing] = [
        DynamicFriction::LuGre(BRISTLES),
        DynamicFriction::RateAndState(AGEING),
    ];
    [
        (bristles, true),
        (bristles, false),
        (ageing, true),
        (ageing, false),
    ]
    .map(|(law, radial)| Friction::Dynamic { law, radial })
}

/// Models with both laws, and with contact damping and `Omega x u`.
fn models() -> Vec<Model> {
    let dampings = [
        ContactDamping::None,
        ContactDamping::KelvinVoigt { time: 2e-7 },
        ContactDamping::HuntCrossley { dissipation: 0.5 },
    ];
    let all = laws().into_iter().flat_map(|friction| {
        dampings.map(|contact_damping| Model {
            contact_damping,
            convection: (!contact_damping.is_none()).then_some([700.0, -300.0, 200.0]),
            ..scattered(21, 11, friction.clone())
        })
    });
    all.collect()
}

#[test]
fn the_state_has_the_states_of_the_nodes() {
    let counts = laws().map(|law| Joint::new(&scattered(21, 11, law)).friction_states());
    assert_eq!(counts, [63, 42, 21, 21]);
    let joint = Joint::new(&scattered(21, 11, laws()[1].clone())).with_audit();
    assert_eq!((joint.dim(), joint.tangent_dim()), (22 + 42 + 1, 22 + 42));
    let z: Vec<f64> = (0..joint.dim()).map(|k| k as f64).collect();
    let [q, v, s] = joint.parts(&z);
    assert_eq!((q[0], v[0], s[0], s.len()), (0.0, 11.0, 22.0, 42));
}

/// Steady sliding is exactly stationary, and its force is that of the closed form of the coefficient.
#[test]
fn steady_sliding_is_the_equilibrium() {
    for model in models() {
        let joint = Joint::new(&model).with_audit();
        let mut rate = vec![1.0; joint.dim()];
        joint.rhs(0.0, &vec![0.0; joint.dim()], &mut rate);
        assert!(rate.iter().all(|r| *r == 0.0), "{rate:?}");
        let mut force = vec![0.0; model.modes()];
        for k in 0..model.nodes() {
            let speed = norm(model.sliding_velocity[k]);
            let mu = match &model.friction {
                Friction::Dynamic {
                    law: DynamicFriction::LuGre(law),
                    ..
                } => 0.25 + 0.3 * (-10.0 * speed).exp() + law.viscous * speed,
                _ => 0.5 - 0.02 * (speed / 0.016).ln(),
            };
            let normal = model.pre_stress[k] * model.areas[k];
            let mut traction = scale(model.normals[k], -normal);
            let along = -mu * normal / speed;
            traction = vector::add_scaled(traction, along, model.sliding_velocity[k]);
            for (force, shape) in force.iter_mut().zip(model.shapes_at(k)) {
                *force += dot(*shape, traction);
            }
        }
        for (a, b) in joint.equilibrium().force.iter().zip(&force) {
            assert!((a - b).abs() < 1e-11 * b.abs().max(1.0), "{a} {b}");
        }
    }
}

/// A record and the status of the state leave the force bit-identical, and the products with tangent vectors are
/// those of differences, one by one and together.
#[test]
fn products_are_the_derivative() {
    for model in models() {
        let joint = Joint::new(&model);
        let z = state(&joint, 3);
        let (m, n) = (joint.modes(), joint.dim());
        let mut status = vec![0; joint.status_len()];
        joint.status_of(0.0, &z, &mut status);
        let mut record = vec![0.0; joint.record_len()];
        let mut force_at = |z: &[f64]| {
            let mut out = vec![0.0; n - m];
            joint.force_recorded(Some(&status), 0.0, z, &mut out, &mut record);
            out
        };
        let mut plain = vec![0.0; n - m];
        joint.force(0.0, &z, &mut plain);
        assert_eq!(plain, force_at(&z));
        let width = 3;
        let vectors = state(&joint, 9);
        let vectors: Vec<f64> = (0..n * width)
            .map(|k| vectors[k / width] * (1.0 + (k % width) as f64))
            .collect();
        let step = 1e-5;
        let moved = |sign: f64| -> Vec<f64> {
            let along = vectors.iter().step_by(width);
            z.iter()
                .zip(along)
                .map(|(z, d)| z + sign * step * d)
                .collect()
        };
        let [plus, minus] = [1.0, -1.0].map(|sign| force_at(&moved(sign)));
        force_at(&z);
        let mut out = vec![0.0; (n - m) * width];
        joint.product(Some(&status), &mut record, &vectors, width, &mut out);
        for part in [0..m, m..n - m] {
            let size = part
                .clone()
                .map(|i| out[i * width].abs())
                .fold(0.0, f64::max);
            for i in part {
                let difference = (plus[i] - minus[i]) / (2.0 * step);
                let error = (out[i * width] - difference).abs();
                assert!(error < 1e-6 * size, "{i}: {error:e} of {size:e}");
                let doubled = out[i * width + 1] - 2.0 * out[i * width];
                assert!(doubled.abs() < 1e-12 * size);
            }
        }
    }
}

/// The forces of the nodes add up to the generalised force.
#[test]
fn the_forces_of_the_nodes_make_the_force() {
    for model in models() {
        let joint = Joint::new(&model);
        let z = state(&joint, 5);
        let forces = joint.node_forces(&z);
        let mut out = vec![0.0; joint.dim() - 11];
        joint.force(0.0, &z, &mut out);
        let steady = &joint.equilibrium().force;
        for (i, (out, steady)) in out.iter().zip(steady).enumerate().take(11) {
            let of_node = |k: usize| {
                let normal = scale(model.normals[k], -forces.normal[k]);
                let total = vector::add_scaled(normal, 1.0, forces.friction[k]);
                dot(total, model.shapes_at(k)[i])
            };
            let sum: f64 = (0..model.nodes()).map(of_node).sum();
            assert!((sum - out - steady).abs() < 1e-10 * steady.abs().max(1.0));
        }
    }
}

/// Stiff bristles slide as Eq. (5) does: the difference decreases with their compliance.
#[test]
fn stiff_bristles_approach_the_law_of_the_speed() {
    let run = |friction| {
        let joint = Joint::new(&scattered(12, 5, friction));
        let method = MethodName::Tsit5.with(Accuracy::relative(1e-8), 1e-5);
        let mut run = Integrator::new(method, &joint).unwrap();
        let mut z = vec![0.0; joint.dim()];
        z[5..10].fill(2e-4);
        run.start(0.0, &z).unwrap();
        run.integrate_to(2e-4).unwrap();
        run.state()[..10].to_vec()
    };
    let exact = run(Friction::Stribeck {
        law: Stribeck {
            mu_s: 0.55,
            mu_d: 0.25,
            creep: 1e6,
            stribeck: 10.0,
        },
        radial: true,
    });
    let errors = [1e7, 1e8].map(|stiffness| {
        let law = LuGre {
            stiffness,
            damping: 0.0,
            viscous: 0.0,
            ..BRISTLES
        };
        let with = run(Friction::Dynamic {
            law: DynamicFriction::LuGre(law),
            radial: true,
        });
        let size: f64 = exact[5..].iter().map(|v| v.abs()).sum();
        let pairs = with.iter().zip(&exact).skip(5);
        pairs.map(|(a, b)| (a - b).abs()).sum::<f64>() / size
    });
    assert!(errors[1] < 0.2 * errors[0], "{errors:?}");
    assert!(errors[1] < 2e-3, "{errors:?}");
}

/// Explicit, exponential and implicit methods agree.
#[test]
fn methods_agree() {
    for friction in laws() {
        let joint = Joint::new(&scattered(6, 3, friction)).with_audit();
        let ends = [MethodName::Tsit5, MethodName::Lawson54, MethodName::Rodas5P].map(|method| {
            let method = method.with(Accuracy::relative(1e-9), 1e-6);
            let mut run = Integrator::new(method, &joint).unwrap();
            run.start(0.0, &state(&joint, 31)).unwrap();
            run.integrate_to(1e-4).unwrap();
            run.state().to_vec()
        });
        for part in [
            0..3,
            3..6,
            6..joint.tangent_dim(),
            joint.tangent_dim()..joint.dim(),
        ] {
            let size: f64 = ends[0][part.clone()].iter().map(|x| x.abs()).sum();
            for end in &ends[1..] {
                let pairs = ends[0][part.clone()].iter().zip(&end[part.clone()]);
                let error: f64 = pairs.map(|(a, b)| (a - b).abs()).sum();
                assert!(error < 1e-5 * size, "{part:?}: {error:e} of {size:e}");
            }
        }
    }
}

/// A spring and a mass on a sliding contact.
fn slider(friction: DynamicFriction, mass: f64, spring: f64, speed: f64) -> Model {
    Model {
        normals: vec![[0.0, 0.0, 1.0]],
        positions: vec![[0.0, 0.0, 0.016]],
        sliding_velocity: vec![[speed, 0.0, 0.0]],
        areas: vec![1e-6],
        pre_stress: vec![1e8],
        stiffness: vec![1e13],
        shapes: vec![[1.0 / mass.sqrt(), 0.0, 0.0]],
        omega: vec![(spring / mass).sqrt()],
        damping: Vec::new(),
        probe: vec![1.0],
        ..scattered(
            1,
            1,
            Friction::Dynamic {
                law: friction,
                radial: false,
            },
        )
    }
}

/// With rate-and-state friction, steady sliding is unstable below the critical stiffness
/// `N (b - a) / D_c (1 + m V^2 / (N a D_c))`, at which it oscillates with `V / D_c sqrt((b - a) / a)` (J. R. Rice, A. L.
/// Ruina, J. Appl. Mech. 50 (1983) 343).
#[test]
fn the_critical_stiffness_is_the_closed_form() {
    let (normal, speed) = (100.0, 0.02);
    for mass in [1e-4, 0.02, 0.5] {
        let difference = AGEING.evolution - AGEING.direct;
        let inertia = mass * speed * speed / (normal * AGEING.direct * AGEING.distance);
        let critical = normal * difference / AGEING.distance * (1.0 + inertia);
        let mode = |spring| {
            let law = DynamicFriction::RateAndState(AGEING);
            let modes = Joint::new(&slider(law, mass, spring, speed)).linear_modes();
            let mut modes = modes.unwrap();
            modes.retain(|mode| mode.frequency_hz > 0.0);
            assert_eq!(modes.len(), 1, "{modes:?}");
            modes.remove(0)
        };
        let [below, at, above] = [0.999, 1.0, 1.001].map(|factor| mode(factor * critical));
        assert!(
            below.growth > 0.0 && above.growth < 0.0,
            "{below:?} {above:?}"
        );
        let omega = speed / AGEING.distance * (difference / AGEING.direct).sqrt();
        let found = std::f64::consts::TAU * at.frequency_hz;
        assert!((found / omega - 1.0).abs() < 1e-9, "{found} {omega}");
        assert!(at.growth.abs() < 1e-9 * omega);
    }
}

/// At rest the bristles are springs and dashpots beside those of the body.
#[test]
fn bristles_at_rest_are_a_spring_and_a_dashpot() {
    let (mass, spring, normal) = (0.02, 1e6, 100.0);
    let law = DynamicFriction::LuGre(BRISTLES);
    let modes = Joint::new(&slider(law, mass, spring, 0.0))
        .linear_modes()
        .unwrap();
    let mode = modes.iter().find(|mode| mode.frequency_hz > 0.0).unwrap();
    let stiffness = spring + normal * BRISTLES.stiffness;
    let damping = normal * (BRISTLES.damping + BRISTLES.viscous);
    let growth = -damping / (2.0 * mass);
    let omega = (stiffness / mass - growth * growth).sqrt();
    assert!((mode.growth / growth - 1.0).abs() < 1e-9);
    assert!((std::f64::consts::TAU * mode.frequency_hz / omega - 1.0).abs() < 1e-9);
}

/// The eigenvalues that are shown are those of the Jacobian, without stable relaxations.
#[test]
fn linear_modes_are_eigenvalues_of_the_jacobian() {
    for friction in laws() {
        let joint = Joint::new(&scattered(7, 3, friction));
        let n = joint.dim();
        let jacobian = jacobian(&joint, &vec![0.0; n]);
        let values = DMatrix::from_row_slice(n, n, &jacobian).complex_eigenvalues();
        let modes = joint.linear_modes().unwrap();
        assert!(modes.iter().filter(|mode| mode.frequency_hz > 1e3).count() >= 3);
        for mode in modes {
            let omega = std::f64::consts::TAU * mode.frequency_hz;
            let near = values
                .iter()
                .map(|value| (value.re - mode.growth).hypot(value.im - omega))
                .fold(f64::INFINITY, f64::min);
            assert!(near < 1e-6 * omega.max(mode.growth.abs()), "{mode:?}");
        }
    }
}

/// Bristles and the age of the contact do not jump with the loading, also if it turns the direction of sliding.
#[test]
fn states_are_carried_to_another_loading() {
    for friction in laws() {
        let before = scattered(9, 3, friction.clone());
        let mut after = before.clone();
        for velocity in &mut after.sliding_velocity {
            *velocity = scale(*velocity, -2.0);
        }
        let joints = [&before, &after].map(Joint::new);
        let mut z = state(&joints[0], 4);
        // No vibration: the slip velocity is that of the rotation.
        z[..6].fill(0.0);
        let total = |joint: &Joint, z: &[f64]| -> Vec<DVector<f64>> {
            let law = joint.law.evolving().unwrap().law;
            let [_, _, states] = joint.parts(z);
            let of = |k: usize| {
                let state = joint.state_of(k, states);
                if law.has_vector_state() {
                    let frame = joint.nodes.frames[k].as_flattened();
                    DMatrix::from_column_slice(3, 3, frame) * DVector::from_row_slice(&state)
                } else {
                    DVector::from_row_slice(&state)
                }
            };
            (0..9).map(of).collect()
        };
        let start = total(&joints[0], &z);
        joints[0].carry_friction(&joints[1], &mut z);
        for (a, b) in start.iter().zip(total(&joints[1], &z)) {
            assert!((a - &b).amax() < 1e-12, "{a} {b}");
        }
    }
}
