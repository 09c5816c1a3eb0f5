//! Training of the shipped rules, and their errors over many joints.

use std::fmt::Write as _;

use super::super::shipped::FILES;
use super::joints::named;
use super::*;
use crate::joint::Quadrature;

/// Joints of the training with the factors on their errors. Where nodes separate or slip reverses, the errors
/// of any rule are larger.
const TRAINING: [(&str, f64); 15] = [
    ("tilt-0", 1.0),
    ("torus-3deg", 1.0),
    ("chaos-5deg", 1.0),
    ("tilt-6.5", 1.0),
    ("tilt-8", 0.3),
    ("periodic-2deg", 1.0),
    ("mode-shift-3.5deg", 1.0),
    ("stick-slip", 0.3),
    ("load-75", 1.0),
    ("load-500", 0.05),
    ("azimuth-60", 0.05),
    ("stiffness-1", 1.0),
    ("stiffness-5", 0.02),
    ("lift-off", 0.02),
    ("tilt-20", 0.1),
];

/// Joints of the held-out errors, all of one body first.
const HELD_OUT: [&str; 20] = [
    "tilt-1",
    "tilt-4",
    "tilt-7",
    "torus-3deg",
    "chaos-5deg",
    "periodic-2deg",
    "mode-shift-3.5deg",
    "stick-slip",
    "lift-off",
    "load-75",
    "load-300",
    "load-500",
    "azimuth-60",
    "tilt-15",
    "tilt-30",
    "stiffness-6",
    "stiffness-20",
    "pre-stress",
    "hunt-crossley",
    "radius-0.4",
];

/// Numbers of kept nodes, as far as they are at most two thirds of all.
const SIZES: [usize; 7] = [16, 24, 32, 40, 48, 64, 80];

/// The excitation of the training: small kicks, from which the vibration grows, and large ones.
fn excitation() -> Excitation {
    Excitation {
        kicks: vec![0.001, 0.01, 0.05, 0.1, 0.3],
        ..Excitation::default()
    }
}

/// A joint with states of a coarse patch.
fn case(
    name: &str,
    patch: (Quadrature, usize),
    weight: f64,
    excitation: &Excitation,
) -> TrainingCase {
    let (mut spec, tilt) = named(name, 100);
    let coarse = BallJoint::new(&spec).unwrap();
    (spec.contact.quadrature, spec.contact.nodes) = patch;
    let states = excitation.states_of(&coarse.joint(tilt).unwrap()).unwrap();
    let joint = BallJoint::new(&spec).unwrap().joint(tilt).unwrap();
    TrainingCase {
        joint,
        states,
        weight,
    }
}

/// The settled motion after a small kick.
fn settled() -> Excitation {
    Excitation {
        kicks: vec![0.01],
        duration: 80e-3,
        states: 801,
        seed: 4,
    }
}

fn held_out(name: &str, patch: (Quadrature, usize)) -> [TrainingCase; 2] {
    let seed = 2;
    let kicked = Excitation {
        seed,
        ..Excitation::default()
    };
    let mut settled = case(name, patch, 1.0, &settled());
    settled.states.drain(..600);
    [case(name, patch, 1.0, &kicked), settled]
}

/// Writes the shipped rules and prints their errors: rms over kicked and over settled motion.
#[test]
#[ignore = "writes the shipped rules"]
fn write_shipped_rules() {
    for (quadrature, nodes, _) in FILES {
        let patch = (quadrature, nodes);
        let cases: Vec<_> = TRAINING
            .iter()
            .map(|(name, weight)| case(name, patch, *weight, &excitation()))
            .collect();
        let trainer = Trainer::new(&cases).unwrap();
        let tests: Vec<_> = HELD_OUT.map(|name| held_out(name, patch)).into();
        // The rule is stated to fit the joints of the paper's body up to the azimuth.
        let stated: Vec<_> = tests[..7].iter().flatten().cloned().collect();
        let mut text = String::from(
            "# Cubature rules of the contact patch, in ascending order of their numbers of nodes.\n\
             # Written by: cargo test --release --no-default-features --lib write_shipped_rules -- --ignored\n\
             # Errors: relative errors of the generalised force. The held-out states are those of tilts and\n\
             # initial velocities that were not used in the training.\n",
        );
        let sizes = SIZES.into_iter().filter(|size| 3 * size <= 2 * nodes);
        let rules: Vec<_> = sizes
            .map(|size| trainer.rule(size, &stated).unwrap())
            .collect();
        for TrainedRule {
            rule,
            training,
            held_out,
        } in &rules
        {
            let errors = |errors: &RuleErrors| {
                let RuleErrors { max, rms, steady } = errors;
                format!("{{ max = {max:.1e}, rms = {rms:.1e}, steady = {steady:.1e} }}")
            };
            let kept = rule.kept();
            let at: Vec<_> = kept.iter().map(|kept| kept.node).collect();
            let weights: Vec<_> = kept.iter().map(|kept| kept.weight).collect();
            let (training, held_out) = (errors(training), errors(held_out));
            write!(
                text,
                "\n[[rules]]\ntraining = {training}\nheld_out = {held_out}\nnodes = {at:?}\n\
                 weights = {weights:?}\n"
            )
            .unwrap();
        }
        let file = format!(
            "{}/assets/reduction/{}-{nodes}.toml",
            env!("CARGO_MANIFEST_DIR"),
            <&str>::from(quadrature)
        );
        std::fs::write(file, text).unwrap();
        print_errors(nodes, &rules, &tests);
    }
}

fn print_errors(nodes: usize, rules: &[TrainedRule], tests: &[[TrainingCase; 2]]) {
    print!("{nodes:18}");
    for TrainedRule { rule, held_out, .. } in rules {
        print!(" | {:2} ({:.1e})     ", rule.kept().len(), held_out.steady);
    }
    println!();
    for (name, [kicked, settled]) in HELD_OUT.iter().zip(tests) {
        print!("{name:18}");
        for TrainedRule { rule, .. } in rules {
            let errors = |case| errors_of(rule, std::slice::from_ref(case)).rms;
            print!(" | {:.1e}, {:.1e}", errors(kicked), errors(settled));
        }
        println!();
    }
}
