//! The contact model as arrays, for use in other programs.

use std::io::{self, Seek, Write};

use crate::joint::{ContactDamping, DynamicFriction, Friction, Joint, Model};
use crate::numpy::{Array, encode_npz};

/// Version of the layout. It increases when an array changes its meaning.
const MODEL_VERSION: f64 = 1.0;

/// An array with a row for each vector.
fn flat<const N: usize>(vectors: &[[f64; N]]) -> Array {
    Array::matrix(vectors.len(), vectors.as_flattened().to_vec())
}

/// The arrays of friction laws that the four coefficients do not describe.
fn friction_arrays(friction: &Friction) -> Option<(&'static str, Array)> {
    Some(match friction {
        Friction::Table { law, .. } => ("friction_points", flat(law.points())),
        Friction::Dynamic { law, .. } => match law {
            DynamicFriction::LuGre(law) => {
                let bristles = [law.stiffness, law.damping, law.viscous];
                let numbers = [&[law.mu_s, law.mu_d, law.stribeck][..], &bristles].concat();
                ("lugre", Array::vector(numbers))
            }
            DynamicFriction::RateAndState(law) => {
                let effects = [law.mu_0, law.direct, law.evolution];
                let numbers = [&effects[..], &[law.reference_speed, law.distance]].concat();
                ("rate_and_state", Array::vector(numbers))
            }
        },
        Friction::None | Friction::Stribeck { .. } | Friction::Custom { .. } => return None,
    })
}

/// Writes a model file: the model of Eq. (8), its equilibrium and an initial state `z0`.
///
/// With `n` contact nodes and `m` modes, in SI units; Cartesian vectors relative to the ball's centre (the
/// beam's axis is z, with the beam on its negative side); doubles in row-major order:
///
/// | array | shape | meaning |
/// |---|---|---|
/// | `version` | () | 1 |
/// | `positions` | (n, 3) | contact nodes, m |
/// | `normals` | (n, 3) | outward unit normals `e_r` of the ball |
/// | `areas` | (n) | `Delta A`, m^2 |
/// | `pre_stress` | (n) | `p_n`, Pa |
/// | `stiffness` | (n) | `k_c`, N/m^3 |
/// | `shapes` | (n, 3, m) | mode shapes, 1/sqrt(kg) |
/// | `omega` | (m) | natural circular frequencies, rad/s |
/// | `damping` | (m) | modal damping ratios |
/// | `sliding_velocity` | (n, 3) | `Omega x x`, m/s |
/// | `friction` | (4) | `mu_s`, `mu_d`, creep slope (s/m), Stribeck slope (s/m); zeros: none; `mu_s = mu_d` and no Stribeck slope: constant; with a measured curve the coefficients are NaN, with a law with states all four |
/// | `lugre` | (6) | LuGre friction ([`LuGre`](crate::joint::LuGre)): `mu_s`, `mu_d`, Stribeck slope (s/m), `sigma_0` (1/m), `sigma_1` (s/m), `sigma_2` (s/m); only where it is the law |
/// | `rate_and_state` | (5) | rate-and-state friction ([`RateAndState`](crate::joint::RateAndState)): `mu_0`, `a`, `b`, `V_0` (m/s), `D_c` (m); only where it is the law |
/// | `friction_points` | (k, 2) | measured curve ([`FrictionTable`](crate::joint::FrictionTable)): slip speed (m/s) and coefficient; only where there is one |
/// | `radial` | () | 1: the radial velocity is part of `V`, as in Eq. (8); 0: projected out |
/// | `unilateral` | () | 1: nodes lift off; 0: bonded |
/// | `contact_damping` | (2) | retardation time `tau` (s) and dissipation `chi` (s/m), one of which is zero; only where there is any |
/// | `convection` | (3) | `Omega`, rad/s; only where `Omega x u` is part of the slip velocity |
/// | `q_eq` | (m) | equilibrium of steady sliding, sqrt(kg) m |
/// | `probe` | (m) | row that gives Eq. (24) from `q`, 1/sqrt(kg) |
/// | `z0` | (2m) | initial `[q, dq/dt]` in the perturbation from the equilibrium |
///
/// Equations in these arrays, with `Q = q_eq + q`, for each node (`Phi` is the node's `3 x m` block):
///
/// ```text
/// N = max(0, p_n + k_c e_r . Phi q)      V = Omega x x + Phi dq/dt [+ Omega x Phi q]
/// d2Q/dt2 + omega^2 Q = sum over nodes of Phi^T (-mu(|V|) N V/|V| - N e_r) Delta A
/// ```
///
/// The states of friction, where there are any, start at those of steady sliding. Contact damping adds `k_c tau e_r . Phi dq/dt` to `N` of a closed node, or multiplies `N` by
/// `1 + chi e_r . Phi dq/dt`; where nodes lift off, a negative result is replaced by zero.
///
/// # Errors
/// If `out` cannot be written.
pub fn encode_model(out: impl Write + Seek, model: &Model, z0: &[f64]) -> io::Result<()> {
    let (n, m) = (model.nodes(), model.modes());
    // (n, m, 3) in memory, (n, 3, m) in the file: rows that multiply q.
    let mut shapes = Vec::with_capacity(3 * n * m);
    for k in 0..n {
        for axis in 0..3 {
            shapes.extend(model.shapes_at(k).iter().map(|shape| shape[axis]));
        }
    }
    let shapes = Array {
        shape: vec![n, 3, m],
        values: shapes,
    };
    let friction = match &model.friction {
        Friction::None => vec![0.0; 4],
        Friction::Stribeck { law, .. } => vec![law.mu_s, law.mu_d, law.creep, law.stribeck],
        Friction::Table { law, .. } => vec![f64::NAN, f64::NAN, law.creep(), 0.0],
        Friction::Dynamic { .. } | Friction::Custom { .. } => vec![f64::NAN; 4],
    };
    let q_eq = Joint::new(model).equilibrium().q.clone();
    let mut damping = model.damping.clone();
    damping.resize(m, 0.0);
    let flag = |on: bool| Array::number(f64::from(u8::from(on)));
    let mut all = vec![
        ("version", Array::number(MODEL_VERSION)),
        ("positions", flat(&model.positions)),
        ("normals", flat(&model.normals)),
        ("areas", Array::vector(model.areas.clone())),
        ("pre_stress", Array::vector(model.pre_stress.clone())),
        ("stiffness", Array::vector(model.stiffness.clone())),
        ("shapes", shapes),
        ("omega", Array::vector(model.omega.clone())),
        ("damping", Array::vector(damping)),
        ("sliding_velocity", flat(&model.sliding_velocity)),
        ("friction", Array::vector(friction)),
        ("radial", flag(model.friction.radial())),
        ("unilateral", flag(model.unilateral)),
        ("q_eq", Array::vector(q_eq)),
        ("probe", Array::vector(model.probe.clone())),
        ("z0", Array::vector(z0.to_vec())),
    ];
    let contact_damping = match model.contact_damping {
        ContactDamping::None => None,
        ContactDamping::KelvinVoigt { time } => Some(vec![time, 0.0]),
        ContactDamping::HuntCrossley { dissipation } => Some(vec![0.0, dissipation]),
    };
    all.extend(contact_damping.map(|numbers| ("contact_damping", Array::vector(numbers))));
    all.extend(friction_arrays(&model.friction));
    let convection = model.convection.map(|omega| omega.to_vec());
    all.extend(convection.map(|omega| ("convection", Array::vector(omega))));
    encode_npz(out, &all)
}
