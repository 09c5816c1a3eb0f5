//! Texts of all figures of real results: in every style and at every size that is accepted no text covers another.

use resvg::usvg::{Group, Node, Rect};

use super::*;
use crate::import::Signal;
use crate::joint::{BallJoint, Friction};
use crate::scene::{Parameter, Scene};
use crate::study::basins::attractors;
use crate::study::branch::{
    Branch, BranchPlan, MapPlan, OrbitStarts, sensitivities, stability_map,
};
use crate::study::cost::tests::OF_THE_BELT;
use crate::study::lyapunov::{Goal, LyapunovRequest, scene_lyapunov};
use crate::study::paper as evidence;
use crate::study::response::ResponsePlan;
use crate::study::signal::{SignalOptions, analyse_signal};
use crate::study::sweep::{Axis as SweptAxis, Shard, Start, SweepPlan, SweepPoint, sweep};
use crate::study::{StudyError, stability};
use crate::test_signals::{noise, sines};

/// Sizes that are tried besides the default, mm.
const SIZES: [&str; 3] = ["254x143", "160x90", "120x70"];

/// A sweep. With a short transient some motions are not settled, with a long one no exponents are computed.
fn swept(
    scene: &str,
    axes: &[(&str, &[f64])],
    starts: &[Start],
    max_transient: f64,
) -> (SweepPlan, Vec<SweepPoint>) {
    let axes = axes.iter().map(|(key, values)| {
        SweptAxis::new(Parameter::named(key).unwrap(), values.iter().copied())
    });
    let plan = SweepPlan {
        subject: Scene::load(scene).unwrap(),
        axes: axes.collect(),
        starts: starts.to_vec(),
        response: ResponsePlan {
            min_transient_s: 0.01,
            max_transient_s: max_transient,
            measurement_s: 0.03,
            exponents: if max_transient < 0.1 { 3 } else { 0 },
            portrait: true,
            ..ResponsePlan::default()
        },
    };
    let (known, ignore) = (Vec::new(), |_: &SweepPoint| Ok::<_, StudyError>(()));
    let mut progress = |_: f64, _: &str| Ok(());
    let points = sweep(&plan, Shard::WHOLE, known, 2, &mut progress, ignore).unwrap();
    (plan, points)
}

fn branch(scene: &str, key: &str, interval: [f64; 2], start: Option<f64>) -> Branch {
    let parameter = Parameter::named(key).unwrap();
    let plan = BranchPlan::new(Scene::load(scene).unwrap(), parameter, interval, 20);
    let starts = start.map(OrbitStarts::At);
    plan.follow(starts, &mut |_, _| Ok(()), &mut |_| ())
        .unwrap()
}

/// The figures of the paper from a sweep over the tilt.
fn paper(plan: &SweepPlan, points: &[SweepPoint]) -> Vec<Figure> {
    use super::paper::*;
    let found = points
        .iter()
        .filter_map(|point| Some((point.place.values[0], point.outcome.as_ref().ok()?)));
    let found: Vec<_> = found.take(6).collect();
    let ball = BallJoint::new(&plan.subject.joint().unwrap().spec).unwrap();
    let tilt = 5.5_f64.to_radians();
    let Friction::Stribeck { law, .. } = &ball.spec().friction else {
        panic!("the paper has Stribeck friction");
    };
    let causes = ball.model(tilt).unwrap().explained_modes().unwrap();
    let (choice, dt) = evidence::embedding(found[0].1).unwrap();
    vec![
        configuration(&ball, &ball.model(tilt).unwrap(), tilt).unwrap(),
        mode_shapes(&ball).unwrap(),
        friction_curves(law, 0.02),
        motion(5, found[1].0, found[1].1, &causes),
        motion(6, found[5].0, found[5].1, &causes),
        embedding(5.0, &choice, dt),
        recurrence_plots(&found),
        sections(&found),
        bifurcation(plan, points),
    ]
}

fn studies() -> Vec<Figure> {
    let mut figures = Vec::new();
    let tilts = [1.0, 2.0, 3.0, 4.0, 5.0, 8.0];
    for (scene, axes, starts) in [
        (
            "torus-1.75deg",
            &[("load.tilt_deg", &tilts[..])][..],
            &Start::ALL[..],
        ),
        (
            "torus-1.75deg",
            &[
                ("load.tilt_deg", &tilts[2..4]),
                ("load.load_n", &[100.0, 200.0]),
            ],
            &Start::ALL[..1],
        ),
        (
            "mass-on-belt",
            &[("mass_on_belt.belt_speed_mm_per_s", &[50.0, 100.0])],
            &Start::ALL[1..2],
        ),
    ] {
        let (plan, points) = swept(scene, axes, starts, 0.03);
        figures.extend(sweep_figures(&plan, &points));
        if starts.len() == 3 {
            figures.extend(paper(&plan, &points));
        }
    }
    let seeds: Vec<f64> = (1..5).map(f64::from).collect();
    let (_, points) = swept(
        "torus-1.75deg",
        &[("start.seed", &seeds)],
        &[Start::Fresh],
        0.1,
    );
    figures.push(basins_figure(
        "torus-1.75deg",
        &points,
        &attractors(&points),
    ));
    for (scene, count) in [("chaos-5deg", None), ("impact-oscillator", None)] {
        let request = LyapunovRequest {
            count,
            settle: Some(0.005),
            goal: Goal::Time(0.02),
            tolerance: Some(1e-5),
        };
        let scene = Scene::load(scene).unwrap().with_duration(20.0).unwrap();
        let found = scene_lyapunov(&scene, &request, &mut |_, _| Ok(())).unwrap();
        figures.push(lyapunov_figure(&scene.name, &found));
    }
    for name in ["torus-1.75deg", "which-mode-wins"] {
        // Sensitivities need many bodies.
        let elements = [("body.element_order", "2")];
        let scene = Scene::load(name)
            .unwrap()
            .with_overrides(&elements)
            .unwrap();
        let ball = BallJoint::new(&scene.joint().unwrap().spec).unwrap();
        let tilt = [scene.joint().unwrap().tilt.at(0.0)];
        let causes = ball.model(tilt[0]).unwrap().explained_modes().unwrap();
        let at = stability(&ball, &tilt).unwrap();
        figures.push(causes_figure(name, &at[0], &causes));
        let modes = sensitivities(&scene, &mut |_, _| Ok(())).unwrap();
        figures.push(sensitivities_figure(
            name,
            &modes.iter().collect::<Vec<_>>(),
        ));
        figures.push(sensitivities_figure(
            name,
            &modes.iter().take(1).collect::<Vec<_>>(),
        ));
    }
    for (scene, key, interval, start) in [
        ("torus-birth", "load.tilt_deg", [0.0, 1.0], Some(0.0)),
        (
            "mass-on-belt",
            "mass_on_belt.belt_speed_mm_per_s",
            [20.0, 400.0],
            None,
        ),
    ] {
        let branch = branch(scene, key, interval, start);
        figures.extend(branch_figures(scene, &branch));
    }
    let map = MapPlan {
        scene: Scene::load("torus-1.75deg").unwrap(),
        parameters: ["load.tilt_deg", "friction.stribeck_slope_s_per_m"]
            .map(|key| Parameter::named(key).unwrap()),
        intervals: [[0.0, 8.0], [1.0, 20.0]],
        size: [12, 12],
        orbits: false,
    };
    let map = stability_map(&map, 2, &mut |_, _| Ok(())).unwrap();
    figures.push(map_figure("torus-1.75deg", &map));
    figures.push(cost_figure("mass-on-belt", &OF_THE_BELT));
    figures
}

fn signals() -> Vec<Figure> {
    let rate = 48e3;
    let tones: Vec<(f64, f64, f64)> = (1..30)
        .map(|k| (437.0 * f64::from(k), 0.1 / f64::from(k), f64::from(k)))
        .collect();
    let squeaks = (0..6).flat_map(|k| {
        let tone = [(1500.0 + 300.0 * k as f64, 0.1, 0.0)];
        [sines(rate, 14_000, &tone), noise(k, 6000, 1e-4)].concat()
    });
    let recordings = [
        (
            "a_recording_with_a_very_long_name_of_a_door_that_squeaks_in_the_cellar.wav",
            sines(rate, 24_000, &tones),
        ),
        ("noise.wav", noise(3, 24_000, 0.1)),
        ("many squeaks.wav", squeaks.collect()),
    ];
    let analysed = recordings.map(|(name, samples)| {
        let signal = Signal {
            name: name.to_owned(),
            unit: "Pa".to_owned(),
            rate,
            start: 0.0,
            samples,
        };
        let found = analyse_signal(signal, &SignalOptions::default(), &mut |_, _| Ok(()));
        signal_figures(&found.unwrap())
    });
    let report = signal_figures(&super::tests::report("probe/displacement"));
    analysed.concat().into_iter().chain(report).collect()
}

/// The inked boxes of all texts of a document, with the texts.
fn texts(group: &Group, found: &mut Vec<(Rect, String)>) {
    for node in group.children() {
        match node {
            Node::Group(group) => texts(group, found),
            Node::Text(text) => {
                let written = text.chunks().iter().map(|chunk| chunk.text());
                let ink = text.flattened().bounding_box();
                let place = ink.transform(text.abs_transform()).unwrap();
                found.push((place, written.collect()));
            }
            _ => {}
        }
    }
}

/// Texts that cover each other or leave the page. Marks of data have none.
fn collisions(svg: &str) -> Vec<String> {
    let tree = raster::tree(svg).unwrap();
    let mut found = Vec::new();
    texts(tree.root(), &mut found);
    let page = tree.size().to_rect(0.0, 0.0).unwrap();
    let mut wrong = Vec::new();
    for (k, (place, text)) in found.iter().enumerate() {
        let is_inside = page.left() <= place.left()
            && place.right() <= page.right()
            && page.top() <= place.top()
            && place.bottom() <= page.bottom();
        if !is_inside {
            wrong.push(format!("`{text}` leaves the page"));
        }
        for (other, covered) in &found[..k] {
            let apart = place.right() <= other.left()
                || other.right() <= place.left()
                || place.bottom() <= other.top()
                || other.bottom() <= place.top();
            if !apart {
                wrong.push(format!("`{text}` covers `{covered}`"));
            }
        }
    }
    wrong
}

#[test]
fn no_text_covers_another() {
    let figures = [studies(), signals()].concat();
    let panels: Vec<Figure> = figures.iter().flat_map(Figure::panels).collect();
    let sizes = SIZES.iter().map(|size| Some(parse_size(size).unwrap()));
    let sizes: Vec<Option<[f64; 2]>> = [None].into_iter().chain(sizes).collect();
    let mut wrong = Vec::new();
    for (style, figures) in [
        (Style::Paper, &figures),
        (Style::Screen, &figures),
        (Style::Slides, &panels),
    ] {
        for size in &sizes {
            for figure in figures {
                let mut options = FigureOptions { style, size: *size };
                let name = &figure.name;
                if let Some(least) = options.needed_size(std::slice::from_ref(figure)) {
                    assert!(style != Style::Slides, "{name}: {least:?}");
                    options.size = Some(least);
                }
                let layout = svg::layout(figure, &options);
                let found = collisions(&svg::page(figure, &options, layout, false).out);
                wrong.extend(
                    found
                        .iter()
                        .map(|found| format!("{name}, {options:?}: {found}")),
                );
            }
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}
