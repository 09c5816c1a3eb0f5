//! Joints of the shipped scenes and of other loads, directions and laws.

use crate::fem::{Elements, Geometry, LengthReading, Material};
use crate::joint::*;

/// The scene `torus-3deg`.
fn torus() -> JointSpec {
    JointSpec {
        body: BodySpec::BallOnBeam(BallOnBeam {
            geometry: Geometry {
                ball_diameter: 31.75e-3,
                beam_diameter: 20e-3,
                beam_length: 0.2,
                reading: LengthReading::ToSphere,
            },
            material: Material {
                young: 207e9,
                poisson: 0.30,
                density: 7800.0,
            },
            elements: Elements::default(),
            families: PUBLISHED,
            frequencies: Frequencies::Published,
        }),
        socket: Socket {
            diameter: 31.95e-3,
            young: 70e9,
            poisson: 0.33,
        },
        load: 150.0,
        azimuth: 0.0,
        rotation: [0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0],
        convection: false,
        contact: Contact {
            nodes: 100,
            quadrature: Quadrature::Rings,
            stiffness_factor: 2.75,
            stiffness: StiffnessLaw::Uniform,
            radius_factor: 1.0,
            reduction: None,
            unilateral: true,
            damping: ContactDamping::None,
        },
        friction: stribeck(1000.0, 13.25),
        damping: vec![],
    }
}

fn stribeck(creep: f64, stribeck: f64) -> Friction {
    let (mu_s, mu_d) = (0.55, 0.25);
    let law = Stribeck {
        mu_s,
        mu_d,
        creep,
        stribeck,
    };
    Friction::Stribeck { law, radial: true }
}

/// The body with its lowest bending pair only.
fn one_pair(body: BodySpec) -> BodySpec {
    let BodySpec::BallOnBeam(body) = body else {
        unreachable!()
    };
    BodySpec::BallOnBeam(BallOnBeam {
        families: crate::fem::Families {
            bending_pairs: 1,
            torsion: 0,
            axial: 0,
        },
        ..body
    })
}

/// The joint of a scene, or a variant of `torus-3deg`, with its tilt (rad). Patches of 1,000 nodes have the Gauss
/// rule, for which rules are shipped.
pub(super) fn named(name: &str, nodes: usize) -> (JointSpec, f64) {
    let mut spec = torus();
    spec.contact.nodes = nodes;
    if nodes == 1000 {
        spec.contact.quadrature = Quadrature::Gauss;
    }
    let mut tilt_deg = 3.0_f64;
    if let Some(tilt) = name.strip_prefix("tilt-") {
        tilt_deg = tilt.parse().expect("a tilt in degrees");
    } else if let Some(load) = name.strip_prefix("load-") {
        spec.load = load.parse().expect("a load in N");
    } else if let Some(factor) = name.strip_prefix("stiffness-") {
        spec.contact.stiffness_factor = factor.parse().expect("a factor");
    }
    match name {
        "chaos-5deg" => tilt_deg = 5.0,
        "periodic-2deg" | "mode-shift-3.5deg" => {
            spec.contact.stiffness_factor = 1.0;
            spec.friction = stribeck(1000.0, 10.0);
            tilt_deg = 2.0;
        }
        "stick-slip" => {
            tilt_deg = 2.0;
            spec.body = one_pair(spec.body);
            spec.rotation = [0.09, 0.09, 0.0];
            spec.contact.stiffness_factor = 1.0;
            spec.friction = stribeck(10_000.0, 200.0);
        }
        "lift-off" => {
            tilt_deg = 10.0;
            spec.body = one_pair(spec.body);
            spec.azimuth = 135_f64.to_radians();
            spec.rotation = [2.1, 2.1, 0.0];
            spec.friction = stribeck(1000.0, 5.0);
        }
        "azimuth-60" => {
            spec.azimuth = 60_f64.to_radians();
            spec.friction = stribeck(1000.0, 25.0);
        }
        "pre-stress" => spec.contact.stiffness = StiffnessLaw::LikePreStress,
        "hunt-crossley" => {
            spec.contact.damping = ContactDamping::HuntCrossley { dissipation: 1.0 };
        }
        "radius-0.4" => spec.contact.radius_factor = 0.4,
        _ => {}
    }
    if name == "mode-shift-3.5deg" {
        spec.azimuth = 135_f64.to_radians();
        tilt_deg = 3.5;
    }
    (spec, tilt_deg.to_radians())
}
