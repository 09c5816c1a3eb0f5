//! Contact nodes of the shipped scenes: the fewest with which the settled motion is that of 1,000 nodes.

use squeakscope::dynamics::Exponent;
use squeakscope::joint::{BallJoint, Friction, MAX_NODES_WITH_STATES};
use squeakscope::scene::{PRESETS, Scene, Schedule};
use squeakscope::study::response::{ResponsePlan, SettledResponse, response};
use squeakscope::study::{Trial, stability};

/// Numbers of nodes of a Gauss rule among which a scene chooses.
const COUNTS: [usize; 5] = [16, 36, 64, 100, 300];

/// Nodes of the reference; fewer with friction that has states, whose number of nodes is limited.
const REFERENCE: usize = 1000;

/// Largest relative difference.
const TOLERANCE: f64 = 1e-4;

/// Windows of a chaotic motion from which the scatter of its averages is estimated.
const WINDOWS: usize = 6;

/// Tilts (degrees) at which scenes whose tilt changes are held; the others have their own.
const HELD: [(&str, &[f64]); 4] = [
    ("tilt-ramp", &[0.0, 3.0, 5.5]),
    ("torus-birth", &[0.0, 1.2]),
    ("hysteresis", &[2.0, 6.0]),
    ("articulation", &[-6.0]),
];

/// Tilts (degrees) on the way of two scenes at which the numbers converge slowly: 16 nodes differ by up to 1.4e-3 from
/// 1,000, 100 nodes by up to 6e-4, and 300 by up to 2e-4.
const PASSED: [(&str, f64); 3] = [
    ("hysteresis", 10.0),
    ("articulation", 2.0),
    ("articulation", 6.0),
];

/// Largest relative difference with the nodes of the scene at these tilts.
const PASSED_TOLERANCE: f64 = 2e-3;

/// The settled motion at one tilt.
#[derive(Debug)]
struct Motion {
    /// Frequency (Hz) and amplitude (m) of the strongest line, and rms velocity (m/s); nothing if the motion is
    /// silent.
    numbers: Option<[f64; 3]>,
    /// Largest Lyapunov exponent, 1/s.
    exponent: Option<Exponent>,
    /// Growth rates of the modes in steady sliding, 1/s.
    growth: Vec<f64>,
}

impl Motion {
    fn of(found: &SettledResponse) -> Self {
        let modes = &found.linear.as_ref().expect("a joint").modes;
        let line = found.lines.first();
        Self {
            numbers: line.map(|line| [line.frequency, line.amplitude, found.rms_velocity_m_per_s]),
            exponent: found
                .exponents
                .as_ref()
                .map(|spectrum| spectrum.exponents[0]),
            growth: modes.iter().map(|mode| mode.growth).collect(),
        }
    }

    /// Whether a motion is that of the reference: within the tolerance, or the scatter of the numbers if there is one.
    /// Exponents are averages and agree within their intervals.
    fn agrees(&self, reference: &Self, scatter: [f64; 3]) -> bool {
        let numbers = match (self.numbers, reference.numbers) {
            (Some(found), Some(expected)) => (0..3).all(|k| {
                let allowed = TOLERANCE * expected[k] + 3.0 * scatter[k];
                (found[k] - expected[k]).abs() <= allowed
            }),
            (found, expected) => found.is_none() == expected.is_none(),
        };
        let exponent = match (self.exponent, reference.exponent) {
            (Some(found), Some(expected)) => {
                let intervals = found.half_width + expected.half_width;
                let allowed = TOLERANCE * expected.value.abs() + intervals;
                (found.value - expected.value).abs() <= allowed
            }
            (found, expected) => found.is_none() == expected.is_none(),
        };
        numbers && exponent && self.largest_growth_error(reference) <= TOLERANCE
    }

    /// Largest difference of a growth rate, relative to the largest one.
    fn largest_growth_error(&self, reference: &Self) -> f64 {
        let size = reference
            .growth
            .iter()
            .fold(0.0, |a: f64, g| a.max(g.abs()));
        let pairs = self.growth.iter().zip(&reference.growth);
        pairs.fold(0.0, |a: f64, (g, r)| a.max((g - r).abs() / size))
    }

    /// Columns of the table.
    fn row(&self) -> String {
        let numbers = self.numbers.map_or("silent".to_owned(), |[f, a, rms]| {
            format!("{f:.3} Hz, {:.6} um, {:.5} mm/s", 1e6 * a, 1e3 * rms)
        });
        let exponent = self.exponent.map_or(String::new(), |e| {
            format!("{:.3} ± {:.3} 1/s", e.value, e.half_width)
        });
        format!("{numbers} | {exponent}")
    }
}

/// A joint at a constant tilt (degrees) and a constant rotation.
fn held(name: &str, tilt: Option<f64>) -> Scene {
    let mut scene = Scene::load(name).unwrap();
    let joint = scene.joint_mut().unwrap();
    if let Some(tilt) = tilt {
        joint.tilt = Schedule::constant(tilt.to_radians());
    }
    joint.rotation_factor = Schedule::constant(1.0);
    joint.spec.rotation = joint.full_rotation;
    joint.patch_moves_from = None;
    scene.without_analyses()
}

fn settled(scene: &Scene, nodes: usize, earlier: Option<&SettledResponse>) -> SettledResponse {
    let mut scene = scene.clone();
    scene.joint_mut().unwrap().spec.contact.nodes = nodes;
    let plan = ResponsePlan {
        exponents: 1,
        // With a friction law that has states, an orbit has hundreds of multipliers.
        orbits: scene.joint().unwrap().spec.friction.states() == 0,
        portrait: false,
        ..ResponsePlan::default()
    };
    let trial = Trial::of_scene(scene).unwrap();
    response(trial, earlier, &plan, &mut || Ok(())).unwrap()
}

/// The reference, and the scatter of its averages over one window: zero unless the motion is chaotic.
fn reference(scene: &Scene) -> (Motion, [f64; 3]) {
    let friction = &scene.joint().unwrap().spec.friction;
    let nodes = match friction {
        Friction::Dynamic { .. } => MAX_NODES_WITH_STATES,
        _ => REFERENCE,
    };
    let mut found = settled(scene, nodes, None);
    let mut motion = Motion::of(&found);
    let is_chaotic = motion.exponent.is_some_and(|e| e.low() > 0.0);
    let (Some(_), true) = (motion.numbers, is_chaotic) else {
        return (motion, [0.0; 3]);
    };
    let windows: Vec<[f64; 3]> = (0..WINDOWS)
        .map(|_| {
            let numbers = Motion::of(&found).numbers.expect("a line");
            found = settled(scene, nodes, Some(&found));
            numbers
        })
        .collect();
    let count = WINDOWS as f64;
    let mean: [f64; 3] = std::array::from_fn(|k| windows.iter().map(|w| w[k]).sum::<f64>() / count);
    let scatter = std::array::from_fn(|k| {
        let squares: f64 = windows.iter().map(|w| (w[k] - mean[k]).powi(2)).sum();
        (squares / (count - 1.0)).sqrt()
    });
    motion.numbers = Some(mean);
    (motion, scatter)
}

/// The fewest nodes of [`COUNTS`] that reproduce the reference. Prints a row for each number tried.
fn fewest(scene: &Scene, label: &str) -> usize {
    let (expected, scatter) = reference(scene);
    println!("| {label} | {REFERENCE} | {} |", expected.row());
    for nodes in COUNTS {
        let found = Motion::of(&settled(scene, nodes, None));
        let agrees = found.agrees(&expected, scatter);
        let growth = found.largest_growth_error(&expected);
        println!(
            "| {label} | {nodes} | {} | {growth:.0e} | {agrees} |",
            found.row()
        );
        if agrees {
            return nodes;
        }
    }
    panic!("{label}: no number of nodes agrees with {REFERENCE}");
}

/// Every scene has the fewest nodes of a Gauss rule with which its settled motion and its growth rates are those of
/// 1,000 nodes. The scene `paper` has the nodes of its table. Last result, in `guide::explanation::nodes`: 16 nodes in all
/// scenes but `contact-age`, which needs 64.
#[test]
#[ignore = "takes minutes: cargo test --release --test it nodes:: -- --ignored --nocapture"]
fn scenes_have_the_fewest_sufficient_nodes() {
    let mut wrong = Vec::new();
    for name in PRESETS.iter().map(|preset| preset.name) {
        let scene = Scene::load(name).unwrap();
        let Ok(joint) = scene.joint() else { continue };
        if name == "paper" {
            continue;
        }
        let shipped = joint.spec.contact.nodes;
        let tilts = HELD.iter().find(|(of, _)| *of == name);
        let tilts: Vec<Option<f64>> = tilts.map_or(vec![None], |(_, tilts)| {
            tilts.iter().copied().map(Some).collect()
        });
        let counts = tilts.into_iter().map(|tilt| {
            let label = tilt.map_or(name.to_owned(), |tilt| format!("{name}, {tilt} deg"));
            fewest(&held(name, tilt), &label)
        });
        let fewest = counts.max().expect("a tilt");
        if shipped != fewest {
            wrong.push(format!("{name}: {shipped} nodes, {fewest} are the fewest"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Where the numbers converge slowly, few nodes are near 1,000, too.
#[test]
#[ignore = "takes minutes: cargo test --release --test it nodes:: -- --ignored --nocapture"]
fn passed_motions_are_near_those_of_many_nodes() {
    for (name, tilt) in PASSED {
        let scene = held(name, Some(tilt));
        let shipped = scene.joint().unwrap().spec.contact.nodes;
        let of = |nodes| Motion::of(&settled(&scene, nodes, None));
        let (few, many) = (of(shipped), of(REFERENCE));
        println!("| {name}, {tilt} deg | {shipped} | {} |", few.row());
        println!("| {name}, {tilt} deg | {REFERENCE} | {} |", many.row());
        let (few, many) = (
            few.numbers.expect("a squeak"),
            many.numbers.expect("a squeak"),
        );
        for (few, many) in few.into_iter().zip(many) {
            assert!(
                (few / many - 1.0).abs() < PASSED_TOLERANCE,
                "{name}, {tilt}: {few} {many}"
            );
        }
    }
}

/// Growth rates with the nodes of each scene are those of 1,000 nodes, from a tilt of 0 to 8 degrees.
#[test]
fn growth_rates_are_those_of_many_nodes() {
    for name in ["doubled-torus-3deg", "periodic-2deg", "lift-off"] {
        let scene = Scene::load(name).unwrap();
        let mut spec = scene.joint().unwrap().spec.clone();
        let tilts: Vec<f64> = (0..5).map(|k| f64::from(2 * k).to_radians()).collect();
        let few = stability(&BallJoint::new(&spec).unwrap(), &tilts).unwrap();
        spec.contact.nodes = REFERENCE;
        let many = stability(&BallJoint::new(&spec).unwrap(), &tilts).unwrap();
        for (few, many) in few.iter().zip(&many) {
            let size = many
                .modes
                .iter()
                .fold(0.0, |a: f64, mode| a.max(mode.growth.abs()));
            for (few, many) in few.modes.iter().zip(&many.modes) {
                let error = (few.growth - many.growth).abs() / size;
                assert!(error < TOLERANCE, "{name}: {few:?} {many:?}");
            }
        }
    }
}
