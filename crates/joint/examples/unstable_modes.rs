//! Unstable modes of a steel ball on a steel beam in an aluminium socket, over the tilt of the load.
//!
//! ```text
//! cargo run --release -p squeakscope-joint --example unstable_modes
//! ```

use std::error::Error;
use std::f64::consts::FRAC_1_SQRT_2;

use squeakscope_joint::fem::{Elements, Geometry, LengthReading, Material};
use squeakscope_joint::{
    BallJoint, BallOnBeam, BodySpec, Contact, ContactDamping, Frequencies, Friction, JointSpec,
    PUBLISHED, Quadrature, Socket, StiffnessLaw, Stribeck,
};

fn main() -> Result<(), Box<dyn Error>> {
    let body = BallOnBeam {
        geometry: Geometry {
            ball_diameter: 31.75e-3,
            beam_diameter: 20e-3,
            beam_length: 200e-3,
            reading: LengthReading::ToSphere,
        },
        material: Material {
            young: 207e9,
            poisson: 0.30,
            density: 7800.0,
        },
        elements: Elements::default(),
        families: PUBLISHED,
        frequencies: Frequencies::FiniteElement,
    };
    let spec = JointSpec {
        body: BodySpec::BallOnBeam(body),
        socket: Socket {
            diameter: 31.95e-3,
            young: 70e9,
            poisson: 0.33,
        },
        load: 150.0,
        azimuth: 0.0,
        rotation: [FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0],
        convection: false,
        contact: Contact {
            nodes: 16,
            quadrature: Quadrature::Gauss,
            stiffness_factor: 1.0,
            stiffness: StiffnessLaw::Uniform,
            radius_factor: 1.0,
            unilateral: true,
            damping: ContactDamping::None,
        },
        pressure: None,
        friction: Friction::Stribeck {
            law: Stribeck {
                mu_s: 0.55,
                mu_d: 0.25,
                creep: 1000.0,
                stribeck: 10.0,
            },
            radial: true,
        },
        damping: Vec::new(),
    };
    let joint = BallJoint::new(&spec)?;
    for tilt_deg in [0.0_f64, 2.0, 4.0] {
        println!("tilt {tilt_deg} deg:");
        let modes = joint.joint(tilt_deg.to_radians())?.linear_modes()?;
        for mode in modes.iter().filter(|mode| mode.unstable()) {
            println!(
                "{:8.1} Hz grows by {:6.1} 1/s",
                mode.frequency_hz, mode.growth
            );
        }
    }
    Ok(())
}
