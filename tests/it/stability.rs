//! Complex eigenvalues of the paper's joint.
//!
//! An early table of growth rates (785.0, 721.4, 675.9, 607.9 1/s at 0 degrees) used mode shapes from a mesh without
//! refinement at the corner between beam and ball. An independent program with quadratic triangles reproduces that
//! table on such a mesh of 2 mm, and converges to the growth rates below on meshes graded towards the corner, like
//! this crate. The first two growth rates of the table are within 0.1 %, the third and fourth are 0.16 % and 0.22 %
//! low.

use std::collections::BTreeMap;

use squeakscope::joint::BallJoint;
use squeakscope::scene::{Parameter, Scene};
use squeakscope::study::{StabilityAt, stability};

/// The joint of `periodic-2deg` with enough nodes for a negligible quadrature error.
fn unstable(azimuth_deg: f64, factor: f64, tilts_deg: &[f64]) -> Vec<StabilityAt> {
    let mut scene = Scene::load("periodic-2deg").unwrap();
    let spec = &mut scene.joint_mut().unwrap().spec;
    spec.azimuth = azimuth_deg.to_radians();
    spec.contact.stiffness_factor = factor;
    spec.contact.nodes = 2000;
    let ball = BallJoint::new(spec).unwrap();
    let tilts: Vec<f64> = tilts_deg.iter().map(|deg| deg.to_radians()).collect();
    let mut found = stability(&ball, &tilts).unwrap();
    found
        .iter_mut()
        .for_each(|at| at.modes.retain(|mode| mode.unstable));
    found
}

const LABELS: [&str; 4] = ["1st bending", "2nd bending", "3rd bending", "4th bending"];

#[test]
fn four_bending_modes_are_unstable() {
    let frequencies = [
        [1705.4, 4087.2, 7537.6, 12441.0],
        [1780.1, 4104.6, 7540.8, 12441.8],
        [1857.1, 4124.4, 7544.3, 12442.7],
    ];
    let converged = [
        [785.17, 721.93, 677.01, 609.26],
        [766.76, 747.88, 691.13, 604.94],
        [726.34, 768.69, 703.33, 598.33],
    ];
    let first_table = [
        [785.0, 721.4, 675.9, 607.9],
        [766.6, 747.3, 690.0, 603.6],
        [726.2, 768.1, 702.2, 597.0],
    ];
    // Errors of the early table due to its coarse mesh, for each mode.
    let table_low = [0.2e-3, 0.75e-3, 1.65e-3, 2.25e-3];
    for (row, at) in unstable(0.0, 1.0, &[0.0, 3.5, 7.0]).iter().enumerate() {
        assert_eq!(at.modes.len(), 4, "{:?}", at.modes);
        for (i, mode) in at.modes.iter().enumerate() {
            assert_eq!(mode.label, LABELS[i]);
            let off = |got: f64, want: f64| got / want - 1.0;
            assert!(
                off(mode.frequency_hz, frequencies[row][i]).abs() < 1e-4,
                "{mode:?}"
            );
            assert!(off(mode.growth, converged[row][i]).abs() < 1e-4, "{mode:?}");
            let low = off(mode.growth, first_table[row][i]) - table_low[i];
            assert!(low.abs() < 1.5e-4, "{mode:?}: {low:e}");
        }
    }
}

/// The default number of nodes gives the same modes to 0.1 %.
#[test]
fn one_hundred_nodes_are_sufficient() {
    let scene = Scene::load("periodic-2deg").unwrap();
    let ball = BallJoint::new(&scene.joint().unwrap().spec).unwrap();
    let coarse = stability(&ball, &[2.0_f64.to_radians()]).unwrap().remove(0);
    let fine = unstable(0.0, 1.0, &[2.0]).remove(0);
    assert_eq!((coarse.unstable().count(), fine.modes.len()), (4, 4));
    for (coarse, fine) in coarse.unstable().zip(&fine.modes) {
        assert!((coarse.frequency_hz / fine.frequency_hz - 1.0).abs() < 1e-4);
        assert!((coarse.growth / fine.growth - 1.0).abs() < 1e-3);
    }
}

/// At azimuth -90 degrees with a stiff contact the first torsion mode becomes unstable below 7 degrees.
#[test]
fn a_fifth_mode_becomes_unstable() {
    let at = unstable(-90.0, 16.0, &[7.0]).remove(0);
    assert_eq!(at.modes.len(), 5);
    let torsion = at
        .modes
        .iter()
        .find(|mode| mode.label == "1st torsion")
        .unwrap();
    assert!((torsion.frequency_hz / 4500.7 - 1.0).abs() < 1e-3);
    assert!((torsion.growth - 5.0).abs() < 0.15, "{}", torsion.growth);
}

/// The friction curve as printed has a positive slope at the sliding speed, so that all modes are stable.
#[test]
fn all_modes_are_stable_with_the_printed_curve() {
    let scene = Scene::load("printed-friction").unwrap();
    let ball = BallJoint::new(&scene.joint().unwrap().spec).unwrap();
    for tilt_deg in [0.0_f64, 3.5, 7.0] {
        let at = stability(&ball, &[tilt_deg.to_radians()])
            .unwrap()
            .remove(0);
        assert_eq!(at.unstable().count(), 0, "{:?}", at.modes);
    }
}

#[test]
fn the_squeak_is_fed_by_the_slope_and_damped_across() {
    let scene = Scene::load("periodic-2deg").unwrap();
    let tilted = scene.joint().unwrap();
    let ball = BallJoint::new(&tilted.spec).unwrap();
    let model = ball.model(tilted.tilt.at(0.0)).unwrap();
    let modes = model.explained_modes().unwrap();
    let unstable: Vec<_> = modes
        .iter()
        .filter(|mode| mode.growth_per_s > 1.0)
        .collect();
    assert_eq!(unstable.len(), 4);
    for mode in unstable {
        let [slope, _, direction, structure] = &mode.causes[..] else {
            panic!("four causes");
        };
        assert!(
            slope.share_per_s > 0.5 * mode.growth_per_s
                && slope.without_per_s < 0.5 * mode.growth_per_s,
            "{mode:?}"
        );
        // The mode shape changes without the term, so that the growth rate need not increase.
        assert!(direction.share_per_s < 0.0, "{mode:?}");
        assert_eq!(structure.share_per_s, 0.0);
        assert!((structure.without_per_s - mode.growth_per_s).abs() < 1e-6);
    }
}

/// The numbers of unstable modes and growth rates in the texts of the scenes.
#[test]
fn the_texts_of_the_scenes_are_true() {
    let unstable = |name: &str, change: Option<(&str, f64)>| -> Vec<f64> {
        let mut scene = Scene::load(name).unwrap();
        if let Some((path, value)) = change {
            let parameter = Parameter::named(path).unwrap();
            scene = scene.with_values(&[(parameter, value)]).unwrap();
        }
        let tilted = scene.joint().unwrap();
        let joint = BallJoint::new(&tilted.spec).unwrap();
        let modes = joint
            .joint(tilted.tilt.at(0.0))
            .unwrap()
            .linear_modes()
            .unwrap();
        assert!(
            modes
                .iter()
                .all(|mode| mode.frequency_hz > 1e3 || name == "periodic-2deg")
        );
        let growing = modes.iter().filter(|mode| mode.unstable());
        growing.map(|mode| mode.growth.round()).collect()
    };
    assert_eq!(unstable("periodic-2deg", None)[1..], [737.0, 685.0, 607.0]);
    assert_eq!(unstable("bristles", None)[1..], [51.0, 22.0, 13.0]);
    let stiff = unstable("bristles", Some(("friction.bristle_stiffness_per_m", 1e7)));
    assert!(stiff.len() == 4 && stiff[1] > 700.0, "{stiff:?}");
    assert_eq!(unstable("contact-age", None).len(), 2);
    let of = |distance| unstable("contact-age", Some(("friction.slip_distance_um", distance)));
    assert_eq!((of(0.05).len(), of(5.0).len()), (4, 0));
}

/// Natural frequencies of a body with the given lines by the names of the modes, from a source. The order of the
/// modes depends on the body.
fn frequencies(lines: &str, source: &str) -> BTreeMap<String, f64> {
    let text = format!(
        "{lines}\nbody.frequencies = \"{source}\"\nload = {{ load_n = 150, tilt_deg = 2 }}\n\
         time.duration_ms = 10\n"
    );
    let scene = Scene::parse("mine.toml", text).unwrap_or_else(|error| panic!("{error}"));
    let ball = BallJoint::new(&scene.joint().unwrap().spec).unwrap();
    let labels = ball.mode_labels().into_iter();
    labels.zip(ball.frequencies_hz().iter().copied()).collect()
}

#[test]
fn scaled_frequencies_of_the_published_body_are_the_published_ones() {
    for lines in [
        "",
        "body.beam_length_to = \"centre\"",
        "body.element_size_mm = 5",
    ] {
        assert_eq!(
            frequencies(lines, "scaled"),
            frequencies(lines, "published"),
            "{lines}"
        );
    }
}

/// The ratio of scaled to published frequencies is that of the finite-element frequencies of the two bodies. A
/// softer material scales all of them with the root of Young's modulus.
#[test]
fn scaled_frequencies_follow_the_finite_element_model() {
    let published = frequencies("", "published");
    let of_published_body = frequencies("", "fe");
    for lines in ["body.beam_length_mm = 240", "body.youngs_modulus_gpa = 70"] {
        let [scaled, own] = ["scaled", "fe"].map(|source| frequencies(lines, source));
        for (mode, &hz) in &published {
            let [ratio, expected] = [scaled[mode] / hz, own[mode] / of_published_body[mode]];
            assert!((ratio / expected - 1.0).abs() < 1e-12, "{lines}, {mode}");
            assert!(ratio < 0.95, "{lines}, {mode}: {ratio}");
            if lines.contains("young") {
                let root = (70.0_f64 / 207.0).sqrt();
                assert!((ratio / root - 1.0).abs() < 1e-8, "{mode}: {ratio}");
            }
        }
    }
}
