//! A sweep as its recording shows it: what a study found, in the terms of a recording.

use std::collections::HashMap;

use crate::analysis::AnalysisError;
use crate::fem::ModeKind;
use crate::joint::{AssemblyError, BallJoint};
use crate::record::sweep::{
    BodyView, MotionView, ParameterView, PointView, ResponseView, ShapeView, StartView, SweepView,
    UnstableMode,
};
use crate::scene::Parameter;
use crate::study::response::{Portrait, Response, section_lag};
use crate::study::sweep::{Axis, Shard, Start, SweepPlan, SweepPoint};

/// The view of a sweep over one parameter, as far as its points are known.
///
/// # Errors
/// When a motion cannot be compared with itself.
pub(super) fn sweep_view(
    plan: &SweepPlan,
    points: &[SweepPoint],
    command: &str,
) -> Result<SweepView, AnalysisError> {
    let chains = plan.chains(Shard::WHOLE);
    let pairs = chains.iter().flat_map(|chain| chain.windows(2));
    let before: HashMap<usize, usize> = pairs.map(|pair| (pair[1], pair[0])).collect();
    // Where there was no response there was no state to go on from.
    let states: HashMap<usize, f64> = points
        .iter()
        .filter(|point| point.outcome.is_ok())
        .map(|point| (point.place.index, point.place.values[0]))
        .collect();
    let mut starts = Vec::new();
    for &start in &plan.starts {
        let of_start = points.iter().filter(|point| point.place.start == start);
        let views = of_start.map(|point| {
            let from = before.get(&point.place.index);
            Ok(PointView {
                value: point.place.values[0],
                from: from.and_then(|index| states.get(index)).copied(),
                outcome: match &point.outcome {
                    Ok(found) => Ok(response_view(found)?),
                    Err(reason) => Err(reason.clone()),
                },
            })
        });
        let points = views.collect::<Result<Vec<_>, AnalysisError>>()?;
        if !points.is_empty() {
            starts.push(StartView {
                key: start.to_string(),
                words: words(start).to_owned(),
                points,
            });
        }
    }
    let scene = &plan.scene;
    let axis = plan.axes.first();
    Ok(SweepView {
        scene: scene.name.clone(),
        title: scene.title.clone(),
        about: scene.about.clone(),
        scene_text: scene.text.clone(),
        command: command.to_owned(),
        letter: if scene.joint().is_ok() { "u" } else { "x" },
        lag: section_lag(scene),
        parameter: axis.map(parameter_view).unwrap_or_default(),
        values: axis.map(|axis| axis.values().to_vec()).unwrap_or_default(),
        starts,
        body: None,
    })
}

/// Ball and beam with one mode of each family.
///
/// # Errors
/// If the modes come from a file.
pub(super) fn body_view(ball: &BallJoint) -> Result<BodyView, AssemblyError> {
    /// Rings and meridians.
    const OUTLINE: [usize; 2] = [60, 24];
    let body = ball.body()?;
    let mesh = body.outline(OUTLINE[0], OUTLINE[1]);
    let modes = body.families().into_iter().map(|family| ShapeView {
        name: family.name,
        frequency: ball.frequencies_hz()[family.mode],
        mode: family.mode,
        turns: body.modes()[family.mode].kind == ModeKind::Torsion,
    });
    Ok(BodyView {
        modes: modes.collect(),
        outline: mesh,
    })
}

/// How points were started, in words.
fn words(start: Start) -> &'static str {
    match start {
        Start::Cold => "each started cold",
        Start::Up => "continued up",
        Start::Down => "continued down",
    }
}

fn parameter_view(axis: &Axis) -> ParameterView {
    ParameterView {
        name: name(axis.parameter()),
        unit: axis.parameter().unit().to_owned(),
        label: axis.label(),
    }
}

/// The last part of a parameter's path without its unit, as words: `load.tilt_deg` is `tilt`.
fn name(parameter: Parameter) -> String {
    let path = parameter.path();
    let key = path.rsplit('.').next().unwrap_or(path);
    let unit = parameter.unit().to_lowercase().replace('/', "_per_");
    let bare = key.strip_suffix(&unit).filter(|_| !unit.is_empty());
    let bare = bare.and_then(|bare| bare.strip_suffix('_'));
    bare.unwrap_or(key).replace('_', " ")
}

fn response_view(found: &Response) -> Result<ResponseView, AnalysisError> {
    let unstable = found.linear.as_ref().map(|linear| {
        let modes = linear.unstable().map(|mode| UnstableMode {
            label: mode.label.clone(),
            frequency: mode.frequency_hz,
            growth: mode.growth,
        });
        modes.collect()
    });
    // A plot of what does not move would show the rounding of its numbers.
    let moving = found.portrait.as_ref().filter(|_| !found.maxima.is_empty());
    let recurrence = moving.map(Portrait::recurrence).transpose()?.flatten();
    Ok(ResponseView {
        transient: found.transient,
        settled: found.settled,
        regime: found.regime,
        confidence: found.confidence,
        amplitude: found.amplitude,
        rms_velocity: found.rms_velocity,
        maxima: found.maxima.clone(),
        section: found.section.clone(),
        lines: found.lines.clone(),
        exponents: found.exponents.clone(),
        measures: found.recurrence.clone(),
        unstable,
        motion: found.portrait.as_ref().map(|portrait| MotionView {
            dt: portrait.dt,
            displacement: portrait.displacement.clone(),
            velocity: portrait.velocity.clone(),
            bin: portrait.bin,
            spectrum: portrait.spectrum.clone(),
        }),
        recurrence,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::study::response::ResponsePlan;

    #[test]
    fn parameters_have_names_without_units() {
        let of = |path: &str| name(Parameter::named(path).unwrap());
        assert_eq!(name(Parameter::tilt()), "tilt");
        assert_eq!(of("load.load_n"), "load");
        assert_eq!(of("stiffness_factor"), "stiffness factor");
        assert_eq!(of("socket.diameter_mm"), "diameter");
    }

    #[test]
    fn a_point_says_what_it_was_started_from() {
        let plan = SweepPlan {
            scene: Scene::load("torus-3deg").unwrap(),
            axes: vec![Axis::new(Parameter::tilt(), [1.0, 2.0, 3.0])],
            starts: vec![Start::Up, Start::Cold],
            response: ResponsePlan::default(),
        };
        let failed = |index: usize| SweepPoint {
            place: plan.place(index),
            outcome: Err("it fell over".to_owned()),
        };
        let view = sweep_view(&plan, &[failed(1), failed(0)], "squeakscope sweep").unwrap();
        // Where none has a response all are started by the kick; what was not begun is left out.
        assert_eq!(view.starts.len(), 1);
        assert_eq!(view.starts[0].key, "up");
        let points = &view.starts[0].points;
        assert!(points.iter().all(|point| point.from.is_none()));
        assert_eq!(points[0].outcome, Err("it fell over".to_owned()));
        assert_eq!((view.values.len(), view.lag), (3, 60e-6));
        assert_eq!(view.parameter.label, "tilt of the load, deg");
    }
}
