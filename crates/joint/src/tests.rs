//! Tests of the joint: a model with scattered nodes that exercises every term, and Hoffmann's two-mode model.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::simd::LANES;
use super::vector::{add_scaled, cross, dot, norm, scale};
use super::*;
use squeakscope_dynamics::equilibrium::Linearised;
use squeakscope_dynamics::{Differentiable, System};

mod derivative;
mod evolving;
mod hot_loop;
mod measured;
mod optional_terms;
mod pushing;
mod switching;

const STRIBECK: Friction = Friction::Stribeck {
    law: Stribeck {
        mu_s: 0.55,
        mu_d: 0.25,
        creep: 1000.0,
        stribeck: 10.0,
    },
    radial: true,
};

/// Nodes scattered on a sphere with random mode shapes; no symmetry can hide an error.
pub(super) fn scattered(nodes: usize, modes: usize, friction: Friction) -> Model {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut uniform = |low: f64, high: f64| rng.random_range(low..high);
    let radius = 15.875e-3;
    let normals: Vec<[f64; 3]> = (0..nodes)
        .map(|_| {
            let n = [uniform(-0.5, 0.5), uniform(-0.5, 0.5), 1.0];
            scale(n, 1.0 / norm(n))
        })
        .collect();
    let positions: Vec<_> = normals.iter().map(|n| scale(*n, radius)).collect();
    let rotation = [0.7, 0.6, 0.3];
    Model {
        sliding_velocity: positions.iter().map(|x| cross(rotation, *x)).collect(),
        areas: (0..nodes).map(|_| uniform(5e-8, 1.5e-7)).collect(),
        pre_stress: (0..nodes).map(|_| uniform(5e6, 2.5e7)).collect(),
        stiffness: (0..nodes).map(|_| uniform(1e13, 3e13)).collect(),
        shapes: (0..nodes * modes)
            .map(|_| [uniform(-2.0, 2.0), uniform(-2.0, 2.0), uniform(-2.0, 2.0)])
            .collect(),
        omega: (0..modes).map(|_| uniform(1e4, 8e4)).collect(),
        damping: (0..modes).map(|_| uniform(1e-4, 1e-2)).collect(),
        probe: (0..modes).map(|_| uniform(-2.0, 2.0)).collect(),
        positions,
        normals,
        friction,
        unilateral: true,
        contact_damping: ContactDamping::None,
        convection: None,
    }
}

/// A state in which about half of the nodes are separated and the velocities are of the order of the sliding
/// speed.
fn state(joint: &Joint, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let m = joint.omega().len();
    (0..joint.dim())
        .map(|i| if i < m { 4e-7 } else { 5e-3 } * rng.random_range(-1.0..1.0))
        .collect()
}

/// Powers at an instant, W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Power {
    /// Power of the deviation of friction from steady sliding. (The steady friction force is constant and
    /// part of the equilibrium.)
    friction: f64,
    /// Power of the contact springs on the modes: the decrease of the energy of the springs.
    contact: f64,
    /// Power of contact damping, including the end of the force while the spring is still compressed; never
    /// positive for contacts that can separate.
    contact_damping: f64,
    /// Power of modal damping; never positive.
    damping: f64,
}

impl Joint {
    /// Returns the powers at state `z`.
    fn power(&self, z: &[f64]) -> Power {
        let [q, v, states] = self.parts(z);
        let mut power = Power {
            damping: self.damping_power(v),
            ..Power::default()
        };
        for k in 0..self.nodes.count {
            let action = self.node_action(k, q, v, states);
            let (block, lane) = (&self.nodes.blocks[k / LANES], k % LANES);
            let rows = &self.nodes.rows[k / LANES * self.nodes.modes..][..self.nodes.modes];
            let mut vibration = [0.0; 3];
            for (row, v) in rows.iter().zip(v) {
                vibration = add_scaled(vibration, *v, [&row.s, &row.t, &row.r].map(|x| x.0[lane]));
            }
            let steady = block.pre_stress.0[lane] * block.area.0[lane];
            let [along, across, outward] = action.friction;
            let friction = [along - block.steady_friction.0[lane], across, outward];
            power.friction += dot(friction, vibration);
            power.contact -= (action.normal - action.dashpot - steady) * vibration[2];
            power.contact_damping -= action.dashpot * vibration[2];
        }
        power
    }
}

/// `mu(V)/V` of a law as printed, and its limit at rest.
fn over_speed(friction: &Friction, speed: f64) -> f64 {
    let rising = |creep: f64, sliding: f64| {
        if speed > 0.0 {
            -(-creep * speed).exp_m1() / speed * sliding
        } else {
            creep * sliding
        }
    };
    match friction {
        Friction::Stribeck { law, .. } => rising(law.creep, sliding(law, speed)),
        Friction::Table { law, .. } => rising(law.creep(), law.sliding(speed)[0]),
        Friction::None | Friction::Dynamic { .. } | Friction::Custom { .. } => {
            unreachable!("no formula of the speed")
        }
    }
}

/// The sliding factor of Eq. (5).
fn sliding(law: &Stribeck, speed: f64) -> f64 {
    law.mu_d + (law.mu_s - law.mu_d) * (-law.stribeck * speed).exp()
}

/// An independent implementation of Eq. (8) from the arrays of the model, in Cartesian components.
fn equation_8(model: &Model, q: &[f64], v: &[f64]) -> Vec<f64> {
    let mut force = vec![0.0; model.modes()];
    for k in 0..model.nodes() {
        let shapes = model.shapes_at(k);
        let (mut u_r, mut rate) = (0.0, 0.0);
        let mut slip = model.sliding_velocity[k];
        for i in 0..model.modes() {
            u_r += dot(shapes[i], model.normals[k]) * q[i];
            slip = add_scaled(slip, v[i], shapes[i]);
            if let Some(omega) = model.convection {
                slip = add_scaled(slip, q[i], cross(omega, shapes[i]));
            }
            rate += dot(shapes[i], model.normals[k]) * v[i];
        }
        let gap = model.pre_stress[k] + model.stiffness[k] * u_r;
        let closed = !model.unilateral || gap > 0.0;
        let stress = match model.contact_damping {
            _ if !closed => 0.0,
            ContactDamping::None => gap,
            ContactDamping::KelvinVoigt { time } => gap + model.stiffness[k] * time * rate,
            ContactDamping::HuntCrossley { dissipation } => gap * (1.0 + dissipation * rate),
        };
        let stress = if model.unilateral {
            stress.max(0.0)
        } else {
            stress
        };
        let mut traction = scale(model.normals[k], -stress);
        if model.friction.law().is_some() {
            if !model.friction.radial() {
                slip = add_scaled(slip, -dot(slip, model.normals[k]), model.normals[k]);
            }
            let ratio = over_speed(&model.friction, norm(slip));
            traction = add_scaled(traction, -ratio * stress, slip);
        }
        for i in 0..model.modes() {
            force[i] += dot(shapes[i], traction) * model.areas[k];
        }
    }
    force
}

/// A table of Eq. (5) with uneven speeds.
fn measured(radial: bool) -> Friction {
    let Friction::Stribeck { law, .. } = STRIBECK else {
        unreachable!()
    };
    let speeds = (0..40).map(|k| 1e-3 * f64::from(k).powf(1.7));
    let points = speeds.map(|v| [v, sliding(&law, v)]).collect();
    let law = FrictionTable::new(points, law.creep).unwrap();
    let law = Arc::new(law);
    Friction::Table { law, radial }
}

fn frictions() -> [Friction; 7] {
    let Friction::Stribeck { law, .. } = STRIBECK else {
        unreachable!()
    };
    let tangent = Friction::Stribeck { law, radial: false };
    let level = |radial| Friction::Stribeck {
        law: Stribeck::constant(0.4, 1000.0),
        radial,
    };
    [
        Friction::None,
        STRIBECK,
        tangent,
        level(true),
        level(false),
        measured(true),
        measured(false),
    ]
}

/// The equilibrium is exactly stationary; `omega^2 q_eq` balances Eq. (8).
#[test]
fn equilibrium_is_exact() {
    for friction in frictions() {
        let model = scattered(21, 11, friction);
        let joint = Joint::new(&model).with_audit();
        let mut rate = vec![1.0; joint.dim()];
        joint.rhs(0.0, &vec![0.0; joint.dim()], &mut rate);
        assert!(rate.iter().all(|r| *r == 0.0), "{rate:?}");
        let rest = [0.0; 11];
        let balance = equation_8(&model, &rest, &rest);
        let q_eq = &joint.equilibrium().q;
        for ((omega, q), balance) in model.omega.iter().zip(q_eq).zip(&balance) {
            let residual = omega.powi(2) * q - balance;
            assert!(
                residual.abs() < 1e-12 * balance.abs().max(1.0),
                "{residual}"
            );
        }
    }
}

/// The Jacobian `dF/dz` in a state, row by row.
fn jacobian(joint: &Joint, z: &[f64]) -> Vec<f64> {
    let at = Linearised::at(joint, None, 0.0, z);
    let of = |k: usize| {
        let (i, j) = (k / at.dim(), k % at.dim());
        at.matrix[(i, j)] * at.scale[j] / at.scale[i]
    };
    (0..at.dim() * at.dim()).map(of).collect()
}

/// The analytic Jacobian agrees with central differences of the right-hand side.
#[test]
fn jacobian_is_the_derivative() {
    for friction in frictions().into_iter().chain(evolving::laws()) {
        let joint = Joint::new(&scattered(40, 11, friction));
        let z = state(&joint, 11);
        let dim = joint.dim();
        let jacobian = jacobian(&joint, &z);
        let (mut plus, mut minus) = (vec![0.0; dim], vec![0.0; dim]);
        for j in 0..dim {
            // The steps are small enough that no node changes its status.
            let step = if j < 11 { 2e-12 } else { 1e-7 };
            let mut shifted = z.clone();
            shifted[j] = z[j] + step;
            joint.rhs(0.0, &shifted, &mut plus);
            shifted[j] = z[j] - step;
            joint.rhs(0.0, &shifted, &mut minus);
            let column = (0..dim)
                .map(|i| jacobian[i * dim + j].abs())
                .fold(0.0, f64::max);
            for i in 0..dim {
                let difference = (plus[i] - minus[i]) / (2.0 * step);
                let error = (jacobian[i * dim + j] - difference).abs();
                assert!(error < 1e-7 * column, "({i},{j}): {error:e} of {column:e}");
            }
        }
    }
}

/// The change of energy is the work of friction and damping.
#[test]
fn energy_balance() {
    for friction in frictions().into_iter().chain(evolving::laws()) {
        for unilateral in [true, false] {
            let model = Model {
                unilateral,
                ..scattered(40, 11, friction.clone())
            };
            let joint = Joint::new(&model).with_audit();
            let z = state(&joint, 5);
            let mut rate = vec![0.0; joint.dim()];
            joint.rhs(0.0, &z, &mut rate);
            let step = 1e-10;
            let along = |s: f64| {
                let moved: Vec<f64> = z.iter().zip(&rate).map(|(z, r)| z + s * r).collect();
                joint.energy(&moved)
            };
            let (later, before) = (along(step), along(-step));
            let power = joint.power(&z);
            let size = power.contact.abs() + power.friction.abs() + power.damping.abs();
            let change = (later.total() - before.total()) / (2.0 * step);
            assert!((change - power.friction - power.damping).abs() < 1e-6 * size);
            let released = -(later.contact - before.contact) / (2.0 * step);
            assert!((released - power.contact).abs() < 1e-6 * size);
            let audited = rate[joint.tangent_dim()];
            assert!((audited - power.friction - power.damping).abs() < 1e-12 * size);
            if friction == Friction::None {
                assert_eq!(power.friction, 0.0);
            }
        }
    }
}

#[test]
fn gaps_and_status_agree() {
    let joint = Joint::new(&scattered(37, 11, STRIBECK));
    let z = state(&joint, 5);
    let mut gaps = vec![0.0; 37];
    joint.gaps(&z[..11], &mut gaps);
    let mut bits = vec![0; 5];
    joint.separated_nodes(&z[..11], &mut bits);
    let mut separated = 0;
    for (k, gap) in gaps.iter().enumerate() {
        assert_eq!(bits[k / 8] >> (k % 8) & 1 == 1, *gap < 0.0);
        let action = joint.node_action(k, &z[..11], &z[11..22], &[]);
        assert!((action.gap - gap).abs() < 1e-6);
        assert_eq!(action.normal == 0.0, *gap < 0.0);
        separated += usize::from(*gap < 0.0);
    }
    assert!(
        (5..32).contains(&separated),
        "{separated} separated: the state must contain both"
    );
    assert_eq!(bits[4] >> 5, 0, "padding nodes are never separated");
}

/// A custom law with Eq. (5) gives the same forces.
#[test]
fn custom_laws_give_the_same_forces() {
    let model = scattered(20, 11, STRIBECK);
    let built_in = Joint::new(&model);
    let law = Stribeck {
        mu_s: 0.55,
        mu_d: 0.25,
        creep: 1000.0,
        stribeck: 10.0,
    };
    let own = Joint::with_friction(&model, Arc::new(law), true);
    let z = state(&built_in, 9);
    let (mut a, mut b) = (vec![0.0; 22], vec![0.0; 22]);
    built_in.rhs(0.0, &z, &mut a);
    own.rhs(0.0, &z, &mut b);
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).abs() <= 1e-12 * a.abs().max(1.0));
    }
}

/// Zero slip speed at a node or everywhere gives finite forces without friction.
#[test]
fn zero_slip_gives_finite_forces() {
    let mut model = scattered(8, 11, STRIBECK);
    model.sliding_velocity = vec![[0.0; 3]; 8];
    let joint = Joint::new(&model);
    let mut rate = vec![0.0; 22];
    joint.rhs(0.0, &[0.0; 22], &mut rate);
    assert!(rate.iter().all(|r| *r == 0.0));
    assert!(jacobian(&joint, &[0.0; 22]).iter().all(|x| x.is_finite()));
}

/// Hoffmann's two-mode model at friction `mu`: K = [[2, 1 - 4 mu/3], [1, 2]], M = I, as a joint with one node
/// whose spring 4/3 couples the second coordinate (normal) to the first (sliding).
fn hoffmann(mu: f64) -> Joint {
    // The stiffness without the spring of the node, [[2, 1], [1, 2/3]], diagonalised by a rotation.
    let (a, b, c) = (2.0_f64, 1.0_f64, 2.0 / 3.0);
    let angle = 0.5 * (2.0 * b).atan2(a - c);
    let (cos, sin) = (angle.cos(), angle.sin());
    let stiffness = |x: f64, y: f64| a * x * x + 2.0 * b * x * y + c * y * y;
    // Modal coordinate i moves the mass along row i of the rotation. Friction acts against the sliding
    // direction, here -x.
    let shapes = vec![[cos, 0.0, sin], [-sin, 0.0, cos]];
    Joint::new(&Model {
        positions: vec![[0.0, 0.0, 1.0]],
        normals: vec![[0.0, 0.0, 1.0]],
        areas: vec![1.0],
        pre_stress: vec![1.0],
        stiffness: vec![4.0 / 3.0],
        shapes,
        omega: vec![stiffness(cos, sin).sqrt(), stiffness(-sin, cos).sqrt()],
        damping: vec![],
        sliding_velocity: vec![[-1.0, 0.0, 0.0]],
        // The coefficient is constant, since the creep region is far below the sliding speed.
        friction: Friction::Stribeck {
            law: Stribeck::constant(mu, 1e4),
            radial: false,
        },
        unilateral: true,
        contact_damping: ContactDamping::None,
        convection: None,
        probe: vec![1.0, 0.0],
    })
}

/// Mode coupling: the critical coefficient is 0.75; eigenvalues at mu = 1.
#[test]
fn hoffmann_mode_coupling() {
    let growth = |mu| {
        let modes = hoffmann(mu).linear_modes().unwrap();
        modes.iter().map(|m| m.growth).fold(f64::MIN, f64::max)
    };
    assert!(growth(0.7499) < 1e-6 && growth(0.7501) > 1e-3);
    let modes = hoffmann(1.0).linear_modes().unwrap();
    for mode in &modes {
        assert!((mode.frequency_hz * std::f64::consts::TAU - 1.428577).abs() < 1e-6);
        assert!((mode.growth.abs() - 0.202072).abs() < 1e-6);
    }
    assert_eq!(modes.iter().filter(|m| m.unstable()).count(), 1);
}

/// The instruction sets that this machine supports, starting with none.
pub(crate) fn machines() -> Vec<pulp::Arch> {
    let mut machines = vec![pulp::Arch::Scalar];
    #[cfg(target_arch = "x86_64")]
    {
        machines.extend(pulp::x86::V3::try_new().map(pulp::Arch::V3));
        machines.extend(pulp::x86::V4::try_new().map(pulp::Arch::V4));
    }
    machines
}
