use std::sync::Arc;

use super::equilibria::add_equilibria;
use super::orbits::add_orbits;
use super::*;
use crate::dynamics::continuation::Criticality;
use crate::scene::{Parameter, Scene};
use crate::study::Stopped;

fn plan(scene: Scene, key: &str, interval: [f64; 2], points: usize) -> BranchPlan {
    BranchPlan::new(scene, Parameter::named(key).unwrap(), interval, points)
}

fn branch(plan: &BranchPlan) -> Branch {
    let mut found = Branch::new(plan);
    add_equilibria(plan, &mut found, &mut |_, _| Ok(())).unwrap();
    found
}

fn belt() -> Scene {
    let system = "natural_frequency_hz = 100\ndamping_ratio = 0.01\nload_n_per_kg = 20\nmu_s = 0.6\nmu_d = 0.3\n\
                  belt_speed_mm_per_s = 100\nstribeck_slope_s_per_m = 10";
    let text = format!("[mass_on_belt]\n{system}\n[time]\nduration_ms = 100\n");
    Scene::parse("belt", text).unwrap()
}

#[test]
fn the_belt_has_its_hopf_point_where_the_slope_of_friction_equals_the_damping() {
    let found = branch(&plan(
        belt(),
        "mass_on_belt.belt_speed_mm_per_s",
        [50.0, 500.0],
        20,
    ));
    let [BranchBifurcation::Steady(hopf)] = &found.bifurcations[..] else {
        panic!("{:?}", found.bifurcations);
    };
    // n k (mu_s - mu_d) exp(-k v) = 2 zeta omega.
    let damping = 2.0 * 0.01 * std::f64::consts::TAU * 100.0;
    let exact = 1e3 * (20.0 * 10.0 * 0.3 / damping).ln() / 10.0;
    assert!(
        (hopf.at.value / exact - 1.0).abs() < 1e-10,
        "{hopf:?} {exact}"
    );
    assert_eq!(hopf.at.name, "belt_speed_mm_per_s");
    // growth = (n k dmu exp(-k v) - 2 zeta omega) / 2.
    let speed = -0.5 * damping * 10.0 * 1e-3;
    assert!((hopf.crossing_speed.unwrap() / speed - 1.0).abs() < 1e-8);
    let cycle = hopf.cycle.as_ref().unwrap();
    assert_eq!(cycle.criticality, Criticality::Subcritical);
    let omega = std::f64::consts::TAU * 100.0;
    let third = -damping * 10.0_f64.powi(2) / 20.0;
    let expected = -20.0 * third / 8.0 / omega;
    assert!(
        (cycle.first_lyapunov / expected - 1.0).abs() < 1e-6,
        "{cycle:?} {expected}"
    );
    assert_eq!(found.equilibria[0].unstable_modes, 1);
    assert_eq!(found.equilibria.last().unwrap().unstable_modes, 0);
}

/// The mass of `impact-oscillator` is driven; its settled motion is named by no classification, and returns after periods of the
/// drive.
#[test]
fn a_driven_system_has_orbits_of_multiples_of_the_period_of_its_drive() {
    let scene = Scene::load("impact-oscillator").unwrap();
    let key = "impact_oscillator.drive_frequency_hz";
    let plan = plan(scene, key, [300.0, 420.0], 2);
    let mut result = Branch::new(&plan);
    let start = OrbitStarts::Scene;
    add_orbits(&plan, start, &mut result, &mut |_, _| Ok(()), &mut |_| ()).unwrap();
    assert!(!result.points.is_empty(), "{:?}", result.ended);
    for point in &result.points {
        let count = f64::from(point.orbit.drive_periods.unwrap());
        let drive = point.at.value;
        assert!((point.orbit.frequency_hz() * count / drive - 1.0).abs() < 1e-12);
        assert!(point.orbit.residual < 1e-8);
    }
    assert!(result.points.iter().any(|point| point.orbit.stable));
}

/// At 10 mm/s the mass of `mass-on-belt` slips for 1.552 ms and sticks for 1.996 ms; the branch passes the speed at which both
/// take half of the period.
#[test]
fn the_branch_of_the_belt_follows_the_closed_form_over_a_decade_of_speeds() {
    let scene = Scene::load("mass-on-belt").unwrap();
    let plan = plan(scene, "mass_on_belt.belt_speed_mm_per_s", [5.0, 50.0], 2);
    let mut result = branch(&plan);
    let start = OrbitStarts::Scene;
    add_orbits(&plan, start, &mut result, &mut |_, _| Ok(()), &mut |_| ()).unwrap();
    let omega = std::f64::consts::TAU * 400.0;
    let elongation = 0.3 * 210.0 / omega.powi(2);
    let ends = [result.points.first(), result.points.last()];
    assert_eq!(ends.map(|end| end.unwrap().at.value), [5.0, 50.0]);
    crate::report::agreement::check(&result, &[]);
    for point in &result.points {
        let speed = 1e-3 * point.at.value;
        let slip = 2.0 * (std::f64::consts::PI - (elongation * omega / speed).atan()) / omega;
        let period = slip + 2.0 * elongation / speed;
        assert!(
            (point.orbit.period_s / period - 1.0).abs() < 1e-8,
            "{point:?}"
        );
    }
}

/// The branch of cycles born at the Hopf point of the belt decides as the normal form does, whose sign is known.
#[test]
fn the_first_cycle_tells_how_it_is_born_where_the_normal_form_does_not() {
    let plan = plan(
        belt(),
        "mass_on_belt.belt_speed_mm_per_s",
        [150.0, 500.0],
        20,
    );
    let mut result = branch(&plan);
    let [BranchBifurcation::Steady(hopf)] = &mut result.bifurcations[..] else {
        panic!("{:?}", result.bifurcations);
    };
    let cycle = hopf.cycle.as_mut().unwrap();
    cycle.criticality = Criticality::Undetermined;
    let start = OrbitStarts::Settled(&[]);
    add_orbits(&plan, start, &mut result, &mut |_, _| Ok(()), &mut |_| ()).unwrap();
    let hopf = result.steady_bifurcations().next().unwrap();
    let cycle = hopf.cycle.as_ref().unwrap();
    assert_eq!(cycle.method, CriticalityMethod::FittedBranch);
    assert_eq!(cycle.criticality, Criticality::Subcritical);
    // The cycle repels, and exists where steady sliding is stable.
    let first = &result.points[0];
    assert!(
        first.at.value > hopf.at.value && !first.orbit.stable,
        "{first:?}"
    );
}

#[test]
fn modes_without_damping_meet_at_the_critical_coefficient_of_friction() {
    let scene = Scene::load("mode-coupling").unwrap();
    let crate::scene::SystemSpec::Small(crate::scene::SmallSystem::TwoModesOnBelt(system)) =
        &scene.subject
    else {
        panic!("two modes");
    };
    let critical = system.critical_mu().unwrap();
    let found = branch(&plan(scene, "two_modes_on_belt.mu", [0.05, 0.9], 18));
    let [BranchBifurcation::Steady(flutter)] = &found.bifurcations[..] else {
        panic!("{:?}", found.bifurcations);
    };
    assert_eq!(flutter.kind, SteadyBifurcationKind::Flutter);
    assert!(
        (flutter.at.value / critical - 1.0).abs() < 1e-8,
        "{flutter:?} {critical}"
    );
    assert_eq!(flutter.crossing_speed, None);
}

#[test]
fn a_point_in_json_has_the_name_of_the_parameter() {
    let found = branch(&plan(
        belt(),
        "mass_on_belt.belt_speed_mm_per_s",
        [50.0, 500.0],
        3,
    ));
    let json = serde_json::to_value(&found).unwrap();
    assert_eq!(json["equilibria"][0]["belt_speed_mm_per_s"], 50.0);
    assert_eq!(json["bifurcations"][0]["kind"], "hopf");
}

/// A joint with few nodes, for tests of differences.
fn joint() -> Scene {
    let scene = Scene::load("doubled-torus-3deg").unwrap();
    let nodes = Parameter::named("contact.nodes").unwrap();
    let damping = Parameter::named("damping.ratio").unwrap();
    scene
        .with_values(&[(Parameter::tilt(), 3.0), (nodes, 28.0), (damping, 1e-4)])
        .unwrap()
}

/// Derivative of the eigenvalue of a mode by differences of the eigenvalues themselves.
fn by_differences(scene: &Scene, key: &str, frequency_hz: f64) -> [f64; 2] {
    let parameter = Parameter::named(key).unwrap();
    let value = scene.value_of(parameter).unwrap();
    let family = SubjectFamily::new(Arc::new(scene.clone()), vec![parameter.path().to_owned()]);
    let at = |value: f64| {
        let modes = family.at(&[value]).unwrap().linearised.modes().unwrap();
        let apart = |mode: &crate::dynamics::equilibrium::Eigenmode| {
            (mode.frequency_hz() - frequency_hz).abs()
        };
        let mode = modes
            .into_iter()
            .min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let value = mode.unwrap().value;
        [value.re, value.im / std::f64::consts::TAU]
    };
    // Central differences with steps h and h/2, extrapolated twice.
    let central = |h: f64| {
        let (up, down) = (at(value + h), at(value - h));
        [0, 1].map(|k| (up[k] - down[k]) / (2.0 * h))
    };
    let first = 4e-3 * value;
    let rows = [first, 0.5 * first, 0.25 * first].map(central);
    [0, 1].map(|k| {
        let once = |j: usize| (4.0 * rows[j + 1][k] - rows[j][k]) / 3.0;
        (16.0 * once(1) - once(0)) / 15.0
    })
}

/// The joint with large elements: sensitivities need many bodies.
fn coarse() -> Scene {
    let elements = [("body.element_size_mm", "10"), ("body.element_order", "2")];
    joint().with_overrides(&elements).unwrap()
}

#[test]
fn sensitivities_are_the_derivatives_of_the_eigenvalues() {
    let scene = coarse();
    let modes = sensitivities(&scene, &mut |_, _| Ok(())).unwrap();
    let unstable: Vec<_> = modes.iter().filter(|mode| mode.mode.unstable).collect();
    assert!(unstable.len() >= 3, "{}", unstable.len());
    let mode = unstable[1];
    for (key, tolerance) in [
        ("friction.mu_s", 1e-6),
        ("friction.mu_d", 1e-6),
        ("friction.stribeck_slope_s_per_m", 1e-6),
        ("load.load_n", 1e-6),
        ("load.tilt_deg", 1e-6),
        ("contact.stiffness_factor", 1e-6),
        ("contact.radius_factor", 1e-6),
        ("damping.ratio", 1e-6),
        ("rotation.angular_velocity_rad_per_s", 1e-6),
        // The modes of the body come from an iteration, whose error the differences amplify: 1.4e-5 here.
        ("body.youngs_modulus_gpa", 1e-4),
    ] {
        let expected = by_differences(&scene, key, mode.mode.frequency_hz);
        let found = mode.parameters.iter().find(|found| found.parameter == key);
        let found = found.unwrap_or_else(|| panic!("{key} is missing"));
        let size = expected[0].abs().max(expected[1].abs());
        for (found, expected) in [found.growth_per_unit, found.frequency_per_unit]
            .into_iter()
            .zip(expected)
        {
            assert!(
                (found - expected).abs() < tolerance * size,
                "{key}: {found} {expected}"
            );
        }
    }
    let percents = mode.parameters.iter().map(|p| p.growth_per_percent.abs());
    assert!(percents.is_sorted_by(|a, b| a >= b));
}

/// Growth rate of the mode nearest to a frequency (Hz).
fn growth_near(scene: &Scene, frequency: f64) -> f64 {
    let joint = scene.joint().unwrap();
    let ball = crate::joint::BallJoint::new(&joint.spec).unwrap();
    let modes = &crate::study::stability(&ball, &[joint.tilt.at(0.0)]).unwrap()[0].modes;
    let away = |mode: &&crate::joint::NamedMode| (mode.frequency_hz - frequency).abs();
    let nearest = modes.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
    nearest.unwrap().growth
}

#[test]
fn the_clearance_counts_and_so_does_absent_damping() {
    let scene = coarse().with_overrides(&[("damping", "absent")]).unwrap();
    let modes = sensitivities(&scene, &mut |_, _| Ok(())).unwrap();
    let mode = modes.iter().find(|mode| mode.mode.unstable).unwrap();
    let of = |name: &str| mode.parameters.iter().find(|one| one.parameter == name);
    assert!(of("socket.diameter_mm").is_none() && of("body.ball_diameter_mm").is_none());
    let clearance = of("clearance_mm").unwrap();
    let socket = scene.parameter("socket.diameter_mm").unwrap();
    let diameter = scene.value_of(socket).unwrap();
    let ball = scene
        .value_of(scene.parameter("body.ball_diameter_mm").unwrap())
        .unwrap();
    assert!((clearance.value - (diameter - ball)).abs() < 1e-12);
    let growth = |mm: f64| {
        let moved = scene.with_values(&[(socket, diameter + mm)]).unwrap();
        growth_near(&moved, mode.mode.frequency_hz)
    };
    let expected = (growth(1e-4) - growth(-1e-4)) / 2e-4;
    let found = clearance.growth_per_unit;
    assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
    // A damping ratio of 1 % damps a mode of the body by its angular frequency times 0.01, in the main.
    let damping = of("damping.ratio").unwrap();
    assert_eq!(damping.value, 0.0);
    let usual = -0.01 * std::f64::consts::TAU * mode.mode.frequency_hz;
    let share = damping.growth_per_percent / usual;
    assert!((0.8..1.2).contains(&share), "{share}");
}

#[test]
fn a_measured_friction_curve_has_a_level_and_a_slope() {
    let curve = "[{speed_m_per_s = 0, mu = 0.5}, {speed_m_per_s = 0.02, mu = 0.4}, {speed_m_per_s = 0.1, mu = 0.2}]";
    let scene = coarse()
        .with_overrides(&[
            ("mu_s", "absent"),
            ("mu_d", "absent"),
            ("stribeck_slope_s_per_m", "absent"),
            ("friction.law", "table"),
            ("friction.points", curve),
        ])
        .unwrap();
    let modes = sensitivities(&scene, &mut |_, _| Ok(())).unwrap();
    let mode = modes.iter().find(|mode| mode.mode.unstable).unwrap();
    let of = |name: &str| {
        let found = mode.parameters.iter().find(|one| one.parameter == name);
        found.unwrap_or_else(|| panic!("{name} is missing"))
    };
    let growth = |factor: f64| {
        let points = [[0.0, 0.5], [0.02, 0.4], [0.1, 0.2]].map(|[v, mu]| [v, factor * mu]);
        growth_near(
            &scene.with_friction_points(&points).unwrap(),
            mode.mode.frequency_hz,
        )
    };
    let expected = (growth(1.0 + 1e-4) - growth(1.0 - 1e-4)) / 2e-4;
    let level = of("friction.points.level");
    assert!((level.growth_per_unit / expected - 1.0).abs() < 1e-4);
    // The growth comes from the slope, which the level scales, too, and the slope alone without the level.
    let slope = of("friction.points.slope");
    assert!(slope.growth_per_percent > 0.0 && slope.growth_per_unit != level.growth_per_unit);
}

#[test]
fn the_modes_of_a_branch_are_those_of_linear_stability() {
    let scene = joint();
    let found = branch(&plan(scene.clone(), "load.tilt_deg", [2.0, 4.0], 3));
    let middle = found
        .equilibria
        .iter()
        .find(|point| point.at.value == 3.0)
        .unwrap();
    let ball = crate::joint::BallJoint::new(&scene.joint().unwrap().spec).unwrap();
    let expected = crate::study::stability(&ball, &[3.0_f64.to_radians()]).unwrap();
    let mut modes: Vec<_> = middle.modes.iter().map(|mode| &mode.mode).collect();
    modes.sort_by(|a, b| {
        let by_frequency = a.frequency_hz.total_cmp(&b.frequency_hz);
        by_frequency.then(a.growth.total_cmp(&b.growth))
    });
    assert_eq!(modes.len(), expected[0].modes.len());
    for (found, expected) in modes.into_iter().zip(&expected[0].modes) {
        assert!(
            (found.growth - expected.growth).abs() < 1e-6,
            "{found:?} {expected:?}"
        );
        assert!((found.frequency_hz - expected.frequency_hz).abs() < 1e-6);
        assert_eq!(found.label, expected.label);
    }
}

#[test]
fn the_hopf_points_of_the_joint_are_located_to_ten_digits() {
    let scene = joint();
    let key = "friction.stribeck_slope_s_per_m";
    let found = branch(&plan(scene.clone(), key, [0.0, 12.0], 13));
    let hopf: Vec<_> = found.steady_bifurcations().collect();
    assert!(!hopf.is_empty());
    let parameter = Parameter::named(key).unwrap();
    let family = SubjectFamily::new(Arc::new(scene), vec![parameter.path().to_owned()]);
    for hopf in hopf {
        assert_eq!(hopf.kind, SteadyBifurcationKind::Hopf);
        assert!(hopf.location_error < 1e-9 * hopf.at.value, "{hopf:?}");
        // On both sides the growth rate has the sign and size of the crossing speed.
        let step = 1e-6 * hopf.at.value;
        for side in [-step, step] {
            let modes = family
                .at(&[hopf.at.value + side])
                .unwrap()
                .linearised
                .modes()
                .unwrap();
            let apart = |mode: &crate::dynamics::equilibrium::Eigenmode| {
                (mode.frequency_hz() - hopf.frequency_hz).abs()
            };
            let mode = modes
                .into_iter()
                .min_by(|a, b| apart(a).total_cmp(&apart(b)));
            let growth = mode.unwrap().value.re;
            let expected = side * hopf.crossing_speed.unwrap();
            assert!(
                (growth / expected - 1.0).abs() < 1e-3,
                "{growth} {expected}"
            );
        }
    }
}

#[test]
fn a_hopf_curve_of_the_belt_is_that_of_its_closed_form() {
    let keys = [
        "mass_on_belt.belt_speed_mm_per_s",
        "mass_on_belt.damping_ratio",
    ];
    let plan = MapPlan {
        scene: belt(),
        parameters: keys.map(|key| Parameter::named(key).unwrap()),
        intervals: [[50.0, 400.0], [0.002, 0.04]],
        size: [9, 8],
        orbits: false,
    };
    let map = stability_map(&plan, 2, &mut |_, _| Ok(())).unwrap();
    assert!(map.grid.len() == 72 && !map.interrupted);
    // An interrupted study keeps the grid.
    let part = stability_map(&plan, 2, &mut |share, _| {
        if share <= 0.5 { Ok(()) } else { Err(Stopped) }
    });
    let part = part.unwrap();
    assert!(part.interrupted && part.curves.is_empty() && part.grid == map.grid);
    let [curve] = &map.curves[..] else {
        panic!("{} curves", map.curves.len());
    };
    assert!(!curve.closed && curve.ended.is_empty(), "{:?}", curve.ended);
    let omega = std::f64::consts::TAU * 100.0;
    for point in &curve.points {
        let [speed, damping] = point.values;
        let exact = 20.0 * 10.0 * 0.3 * (-10.0 * 1e-3 * speed).exp() / (2.0 * omega);
        assert!((damping / exact - 1.0).abs() < 1e-8, "{point:?} {exact}");
    }
    let share = |count: usize| {
        let points = map.grid.iter();
        let counted = points.filter(|point| point.unstable_modes == Some(count));
        counted.count() as f64 / map.grid.len() as f64
    };
    crate::report::agreement::check(&map, &[share(0), share(1)]);
    // From border to border.
    let ends = [curve.points.first().unwrap(), curve.points.last().unwrap()];
    let on_border = |point: &CurvePoint| {
        let [speed, damping] = point.values;
        [speed - 50.0, speed - 400.0].iter().any(|d| d.abs() < 1e-6)
            || [damping - 0.002, damping - 0.04]
                .iter()
                .any(|d| d.abs() < 1e-9)
    };
    assert!(ends.iter().all(|end| on_border(end)), "{ends:?}");
    // The number of unstable modes changes across the curve.
    for (k, point) in map.grid.iter().enumerate() {
        let (speed, damping) = (map.axes[0].values[k % 9], map.axes[1].values[k / 9]);
        let exact = 20.0 * 10.0 * 0.3 * (-10.0 * 1e-3 * speed).exp() / (2.0 * omega);
        // Growth rates below 0.1 1/s do not count as unstable.
        let growth = (exact - damping) * omega;
        assert_eq!(
            point.unstable_modes,
            Some(usize::from(growth >= 0.1)),
            "{growth}"
        );
    }
}

/// The curve of the birth of the torus passes the Neimark-Sacker points of the branches over each of the parameters: that over
/// the tilt, and that over the slope, which AUTO-07p has at 12.5457891 s/m (`benches/peers/branches`).
#[test]
fn a_curve_of_tori_joins_the_points_of_the_branches_from_border_to_border() {
    let nodes = Parameter::named("contact.nodes").unwrap();
    let scene = Scene::load("periodic-2deg").unwrap();
    let scene = scene.with_values(&[(nodes, 100.0)]).unwrap();
    let slope = Parameter::named("friction.stribeck_slope_s_per_m").unwrap();
    let own = scene.value_of(slope).unwrap();
    let plan = MapPlan {
        scene,
        parameters: [Parameter::tilt(), slope],
        intervals: [[2.0, 7.5], [8.0, 14.0]],
        size: [2, 2],
        orbits: true,
    };
    let mut curves = Vec::new();
    map::add_torus_curves(&plan, &mut curves, &mut || Ok(())).unwrap();
    let [curve] = &curves[..] else {
        panic!("{} curves", curves.len());
    };
    assert!(!curve.closed && curve.ended.is_empty(), "{:?}", curve.ended);
    assert!(curve.points.iter().any(|point| {
        let [tilt, slope] = point.values;
        slope == own && (tilt - 6.778_622_6).abs() < 1e-6
    }));
    let ends = [curve.points.first().unwrap(), curve.points.last().unwrap()];
    let [[low, at_low], [high, _]] = match ends.map(|end| end.values) {
        [a, b] if a[0] < b[0] => [a, b],
        [a, b] => [b, a],
    };
    assert!((low - 2.0).abs() < 1e-12 && (high - 7.5).abs() < 1e-12);
    assert!((at_low - 12.545_789_1).abs() < 2e-6, "{at_low}");
}
